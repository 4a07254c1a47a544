"""One skeleton a person: which of several skeletons are the same person seen twice."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..arrays import FloatArray
from ..overlap import keypoint_similarity, sigmas_of
from .people import People

#: Skeletons more alike than this may be one person's. Of 236 people of hand-labelled photos (`data/photos`,
#: `data/labelled_people`) and 7 doubles, whose similarity to a surer person was checked by eye, 2 people and 4 of the
#: doubles lie above.
POSSIBLY_SAME = 0.25
#: A skeleton that is another one moved aside and a little resized, as panoramas and double exposures show people twice:
#: moved by this part of the square root of the smaller box's area at most, resized by this factor at most, and as alike
#: as this once both are taken back. Of 2,411 pairs of people in hand-labelled photos (`data/photos`,
#: `data/labelled_people`, `data/street_sample`; yolox-tinypose and nanodet-movenet) none is; of 27 people laid 0.3 of
#: their width aside and found twice 15 are (`benchmarks/networks/doubtful.py`).
MOST_MOVED, MOST_RESIZED, SAME_SHAPE = 0.4, 1.4, 0.7
#: Fewer shared joints are alike in many bodies.
_LEAST_SHARED = 8


def similarity(people: People) -> FloatArray:
    """Return COCO's object keypoint similarity of all pairs of people, shape (P, P), 0..1.

    Over the joints that both have; 0 where they share fewer than two. The size is that of the smaller of the two, so
    that a small person in front of a large one is not taken for their double.
    """
    count = len(people)
    if count == 0:
        return np.zeros((0, 0))
    sides = np.maximum(people.boxes_px[:, 2:] - people.boxes_px[:, :2], 1.0)
    size2 = np.minimum.outer(sides.prod(axis=1), sides.prod(axis=1))
    gaps = people.keypoints_px[:, None] - people.keypoints_px[None]
    distance2 = (gaps**2).sum(axis=-1)
    shared = np.isfinite(distance2)
    sigmas = sigmas_of(people.skeleton.joints)
    alike = keypoint_similarity(np.where(shared, distance2, 0.0), size2, sigmas, shared.astype(float))
    return np.where(shared.sum(axis=-1) >= 2, alike, 0.0)


def possible_duplicates(people: People) -> NDArray[np.bool_]:
    """Return who may be a surer person seen a second time, shape (P,); of two alike the less sure one is.

    They are kept, and marked: people who embrace or stand one behind the other look alike too.
    """
    order = np.argsort(-people.person_scores, kind="stable")
    rank = np.empty(len(people), dtype=int)
    rank[order] = np.arange(len(people))
    surer = rank[None, :] < rank[:, None]
    same = (similarity(people) > POSSIBLY_SAME) | moved_aside(people)
    return np.asarray((same & surer).any(axis=1))


def moved_aside(people: People) -> NDArray[np.bool_]:
    """Return whose skeleton is another's moved aside by less than a body and a little resized, shape (P, P).

    Two people seldom stand in the same pose so near to one another; a photo that shows one twice does.
    """
    same = np.zeros((len(people), len(people)), dtype=bool)
    sides = np.maximum(people.boxes_px[:, 2:] - people.boxes_px[:, :2], 1.0)
    sizes = np.sqrt(sides.prod(axis=1))
    middles = (people.boxes_px[:, :2] + people.boxes_px[:, 2:]) / 2
    apart = np.linalg.norm(middles[:, None] - middles[None], axis=-1)
    one, other = np.nonzero(np.triu(apart < np.maximum.outer(sizes, sizes), 1))  # of a crowd not all pairs
    points = people.keypoints_px
    shared = np.asarray(np.isfinite(points[one] + points[other]).all(axis=-1))
    number = shared.sum(axis=-1)
    shapes, centres, extents = zip(*(_shape(points[rows], shared) for rows in (one, other)), strict=True)
    factor = extents[1] / np.maximum(extents[0], 1e-9)
    left = shapes[1] - factor[:, None, None] * shapes[0]
    size = np.minimum(sizes[one], sizes[other])
    sigmas = sigmas_of(people.skeleton.joints)
    alike = keypoint_similarity((left**2).sum(axis=-1), size**2, sigmas, shared.astype(float))
    moved = np.linalg.norm(centres[1] - centres[0], axis=-1) / size
    resized = np.maximum(factor, 1 / np.maximum(factor, 1e-9))
    same[one, other] = (
        (alike > SAME_SHAPE) & (moved < MOST_MOVED) & (resized < MOST_RESIZED) & (number >= _LEAST_SHARED)
    )
    return same | same.T


def _shape(points: FloatArray, shared: NDArray[np.bool_]) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return shared joints (N, K, 2) about their middle, 0 for the others, the middle (N, 2) and their extent (N,)."""
    own = np.where(shared[..., None], points, 0.0)
    middle = own.sum(axis=1) / np.maximum(shared.sum(axis=1), 1)[:, None]
    about = np.where(shared[..., None], own - middle[:, None], 0.0)
    return about, middle, np.sqrt((about**2).sum(axis=(1, 2)))


def distinct(people: People, most_similar: float = 0.5) -> People:
    """Return each person once, the best-scoring of several skeletons, in the order given."""
    alike, kept = similarity(people), []
    for row in np.argsort(-people.person_scores, kind="stable"):
        if all(alike[row, other] <= most_similar for other in kept):
            kept.append(int(row))
    return people[sorted(kept)]
