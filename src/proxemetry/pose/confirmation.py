"""Which people another model confirms, by its own skeletons or by its boxes, one for one."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..arrays import FloatArray
from ..assignment import assign
from ..people import People
from ..people.skeleton import MIDDLES

#: Skeletons agree where their shared joints are this close on average: a third of the smaller one's size.
_REACH = 1 / 3
#: A box confirms a skeleton where it holds at least this part of its joints.
_LEAST_INSIDE = 0.5
#: A box is grown by this part of its sides first: detectors cut hands and feet.
_BOX_MARGIN = 0.1


def confirmed_by_people(people: People, others: People) -> People:
    """Return those of `people` who are matched one to one by one of `others`, in their order.

    Two skeletons agree where the joints that both have lie near each other on average, relative to the smaller one's
    size; skeletons that share no joint do not.
    """
    return people[_paired(closeness(people, others))]


def confirmed_by_boxes(people: People, boxes_px: FloatArray) -> People:
    """Return those of `people` who are matched one to one by a detector's box, in their order.

    boxes_px: shape (N, 4). A box and a skeleton agree where the box, slightly grown, holds at least half of its joints.
    """
    boxes = np.asarray(boxes_px, dtype=float).reshape(-1, 4)
    margins = _BOX_MARGIN * (boxes[:, 2:] - boxes[:, :2])
    low, high = boxes[:, :2] - margins, boxes[:, 2:] + margins
    points = people.keypoints_px[:, None]
    seen = np.isfinite(points).all(axis=-1)
    inside = (points >= low[None, :, None]) & (points <= high[None, :, None])
    share = inside.all(axis=-1).sum(axis=-1) / np.maximum(seen.sum(axis=-1), 1)
    return people[_paired(np.where(share >= _LEAST_INSIDE, share, 0.0))]


def closeness(people: People, others: People) -> FloatArray:
    """Return how near each skeleton is to each of the others, shape (P, Q): 1 on the same spot, 0 beyond reach."""
    names = list({**dict.fromkeys(people.skeleton.joints), **dict.fromkeys(MIDDLES)})
    ours = np.stack([people.joint(name) for name in names], axis=1)
    theirs = np.stack([others.joint(name) for name in names], axis=1)
    gaps = np.linalg.norm(ours[:, None] - theirs[None], axis=-1)
    shared = np.isfinite(gaps)
    mean = np.where(shared, gaps, 0.0).sum(axis=-1) / np.maximum(shared.sum(axis=-1), 1)
    reach = _REACH * np.minimum.outer(_extent(people), _extent(others))
    near = 1 - mean / np.maximum(reach, 1e-9)
    return np.where(shared.any(axis=-1), np.clip(near, 0.0, 1.0), 0.0)


def _extent(people: People) -> FloatArray:
    """Return the diagonal of each skeleton's bounds, shape (P,)."""
    points = people.keypoints_px
    if not len(points):
        return np.zeros(0)
    low = np.where(np.isfinite(points), points, np.inf).min(axis=1)
    high = np.where(np.isfinite(points), points, -np.inf).max(axis=1)
    return np.nan_to_num(np.linalg.norm(high - low, axis=1), posinf=0.0)


def _paired(agreement: FloatArray) -> NDArray[np.intp]:
    """Return the rows that get a partner of their own where as many and as good pairs as possible are made."""
    return np.array([row for row, column in assign(-agreement) if agreement[row, column] > 0], dtype=np.intp)
