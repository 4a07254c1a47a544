"""Overlapping people share a crop: which boxes go together (Seker et al. 2021, section 3.2)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...arrays import FloatArray
from ...overlap import shared_areas


@dataclass(frozen=True)
class BoxGroup:
    """Boxes that share a crop.

    rows: of the boxes, ascending. region_px: x0, y0, x1, y1 around them all. count: how many people the group is
    taken to hold; that of its rows, but for the published code's miscounts.
    """

    rows: tuple[int, ...]
    region_px: tuple[float, float, float, float]
    count: int


def grouped(boxes_px: FloatArray) -> list[BoxGroup]:
    """Return the connected groups of boxes: a box that overlaps one of a group belongs to it.

    Every box is in exactly one group, whatever the order; touching edges are no overlap, identical boxes are one.
    """
    boxes = np.asarray(boxes_px, dtype=float).reshape(-1, 4)
    linked = shared_areas(boxes, boxes) > 0
    group = np.arange(len(boxes))
    while True:
        # the lowest number among those that one overlaps, oneself included, until nothing changes any more
        lower = np.where(linked, group[None, :], len(boxes)).min(axis=1, initial=len(boxes))
        lower = np.minimum(lower, group)
        if np.array_equal(lower, group):
            break
        group = lower
    rows = [np.flatnonzero(group == g) for g in np.unique(group)]
    return [_group(boxes, tuple(r.tolist()), len(r)) for r in rows]


def grouped_as_published(boxes_px: FloatArray) -> list[BoxGroup]:
    """Return the groups that the authors' public code makes; rows are those of `boxes_px`.

    Its peculiarities: boxes are taken from left to right and a group chains only to boxes further right, so a person
    may be in two groups; overlap is strict, so boxes with the same left and right (or upper and lower) edges do not
    overlap; a box that is reached in several ways is counted as often; and a group is dropped only where all of it is
    in one that starts further left.
    """
    boxes = np.asarray(boxes_px, dtype=float).reshape(-1, 4)
    order = np.argsort(boxes[:, 0], kind="stable")
    ordered = boxes[order]
    number = len(ordered)
    overlap = _strict_overlap(ordered)
    ways = np.zeros((number, number), dtype=object)  # how often the code lists box k in the group of box i
    for i in reversed(range(number)):
        for k in np.flatnonzero(overlap[i, i + 1 :]) + i + 1:
            ways[i] += ways[k]
            ways[i, k] += 1
    members = [frozenset([i, *np.flatnonzero(ways[i] != 0).tolist()]) for i in range(number)]
    kept = [i for i in range(number) if not any(members[i] <= members[k] for k in range(i))]
    return [_group(boxes, tuple(sorted(order[j].item() for j in members[i])), 1 + int(sum(ways[i]))) for i in kept]


def _strict_overlap(boxes: FloatArray) -> NDArray[np.bool_]:
    """Whether an edge of one lies strictly between those of the other, on both axes."""

    def on_axis(low: FloatArray, high: FloatArray) -> NDArray[np.bool_]:
        within = np.zeros((len(boxes), len(boxes)), dtype=bool)
        for edge in (low, high):
            within |= (low[:, None] < edge[None, :]) & (edge[None, :] < high[:, None])
        return within | within.T

    return on_axis(boxes[:, 0], boxes[:, 2]) & on_axis(boxes[:, 1], boxes[:, 3])


def _group(boxes: FloatArray, rows: tuple[int, ...], count: int) -> BoxGroup:
    own = boxes[list(rows)]
    x0, y0 = own[:, :2].min(axis=0).tolist()
    x1, y1 = own[:, 2:].max(axis=0).tolist()
    return BoxGroup(rows, (x0, y0, x1, y1), count)
