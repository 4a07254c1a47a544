"""One skeleton a person: which of several skeletons are the same person seen twice."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..arrays import FloatArray
from ..overlap import keypoint_similarity, sigmas_of
from .people import People

#: Skeletons more alike than this may be one person's. Of 236 people of hand-labelled photos (`data/photos`,
#: `data/labelled_people`) and 7 doubles, whose similarity to a surer person was checked by eye, 2 people and 4 of the
#: doubles lie above.
POSSIBLY_SAME = 0.25
#: Two skeletons have one shape if they are as alike as `SAME_SHAPE` once a shift and a factor of size are taken back.
#: With a shift below `MOST_MOVED`, in square roots of the smaller box's area, and a factor below `MOST_RESIZED` it is
#: one person whom a panorama or a double exposure shows twice: 0.34 is 0.3 m on a standing body, so people side by side
#: are further apart, and one behind the other looks smaller. Of 27 people laid 0.3 of their width aside and found
#: twice, in equal size or 0.9 of it, 15 are told; of 3,386 pairs of people in the photos of
#: `benchmarks/networks/doubtful.py` (yolox-tinypose and nanodet-movenet) one is taken for one person. The limits were
#: settled on these and on group photos: with 0.4 and 1.4 it would be four pairs, and five of people who pose in a row.
SAME_SHAPE, MOST_MOVED, MOST_RESIZED = 0.7, 0.34, 1.15
#: Skeletons of one shape that lie further apart than this, with sizes more different than `MOST_RESIZED`, are of two
#: people one behind the other, even where they overlap: a second skeleton on one body lies nearer to the first.
_APART = 0.15
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
    """Return which people may be others found a second time, shape (P,); of two alike, the one with the lower score.

    They are kept, and marked: people who embrace or stand one behind the other look alike too.
    """
    order = np.argsort(-people.person_scores, kind="stable")
    rank = np.empty(len(people), dtype=int)
    rank[order] = np.arange(len(people))
    surer = rank[None, :] < rank[:, None]
    shapes = _same_shapes(people)
    behind = shapes.same & (shapes.moved > _APART) & (shapes.resized >= MOST_RESIZED)
    same = ((similarity(people) > POSSIBLY_SAME) & ~behind) | shapes.aside
    return np.asarray((same & surer).any(axis=1))


def moved_aside(people: People) -> NDArray[np.bool_]:
    """Return whose skeleton is another's moved aside by less than a body and hardly resized, shape (P, P).

    Two people seldom stand in the same pose so near to one another; a photo that shows one twice does.
    """
    return _same_shapes(people).aside


@dataclass(frozen=True, eq=False)
class _Shapes:
    """Of all pairs of people, shape (P, P), symmetric: whether their skeletons have one shape, and how they differ.

    moved: in square roots of the smaller box's area. resized: the factor, 1 or more. Both NaN where boxes lie apart.
    """

    same: NDArray[np.bool_]
    moved: FloatArray
    resized: FloatArray

    @property
    def aside(self) -> NDArray[np.bool_]:
        return self.same & (self.moved < MOST_MOVED) & (self.resized < MOST_RESIZED)


def _same_shapes(people: People) -> _Shapes:
    same = np.zeros((len(people), len(people)), dtype=bool)
    moved, resized = np.full(same.shape, np.nan), np.full(same.shape, np.nan)
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
    for pair in ((one, other), (other, one)):
        same[pair] = (alike > SAME_SHAPE) & (number >= _LEAST_SHARED)
        moved[pair] = np.linalg.norm(centres[1] - centres[0], axis=-1) / size
        resized[pair] = np.maximum(factor, 1 / np.maximum(factor, 1e-9))
    return _Shapes(same, moved, resized)


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
