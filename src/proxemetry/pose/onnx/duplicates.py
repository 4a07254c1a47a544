"""One skeleton a person: which of several skeletons are the same person seen twice."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ...people import People
from ...people.skeleton import Skeleton

FloatArray = NDArray[np.float64]

#: How far a joint may lie from itself, as a fraction of the person's size: COCO's keypoint constants (2 sigma), those
#: of the nearest joint for joints that COCO lacks.
_REACH = {
    "nose": 0.052, "eye": 0.050, "ear": 0.070, "shoulder": 0.158, "elbow": 0.144, "wrist": 0.124, "hip": 0.214,
    "knee": 0.174, "ankle": 0.178,
}  # fmt: skip
_REACH_OF_OTHERS = 0.15


def similarity(people: People) -> FloatArray:
    """Return COCO's object keypoint similarity of everybody with everybody, shape (P, P), 0..1.

    Over the joints that both have; 0 where they share fewer than two. The size is that of the smaller of the two, so
    that a small person in front of a large one is not taken for their double.
    """
    count = len(people)
    if count == 0:
        return np.zeros((0, 0))
    reach = _reaches(people.skeleton)
    sides = np.maximum(people.boxes_px[:, 2:] - people.boxes_px[:, :2], 1.0)
    size2 = np.minimum.outer(sides.prod(axis=1), sides.prod(axis=1))
    gaps = people.keypoints_px[:, None] - people.keypoints_px[None]
    distance2 = (gaps**2).sum(axis=-1)
    shared = np.isfinite(distance2)
    likeness = np.exp(-np.where(shared, distance2, 0.0) / (2 * size2[..., None] * reach**2))
    number = shared.sum(axis=-1)
    return np.where(number >= 2, (likeness * shared).sum(axis=-1) / np.maximum(number, 1), 0.0)


def distinct(people: People, most_similar: float = 0.5) -> People:
    """Return the best-scoring of everybody seen several times, in the order given."""
    alike, kept = similarity(people), []
    for row in np.argsort(-people.person_scores, kind="stable"):
        if all(alike[row, other] <= most_similar for other in kept):
            kept.append(int(row))
    return people[sorted(kept)]


def _reaches(skeleton: Skeleton) -> FloatArray:
    return np.array([_REACH.get(joint.split("_")[-1], _REACH_OF_OTHERS) for joint in skeleton.joints])
