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
    return np.asarray(((similarity(people) > POSSIBLY_SAME) & surer).any(axis=1))


def distinct(people: People, most_similar: float = 0.5) -> People:
    """Return each person once, the best-scoring of several skeletons, in the order given."""
    alike, kept = similarity(people), []
    for row in np.argsort(-people.person_scores, kind="stable"):
        if all(alike[row, other] <= most_similar for other in kept):
            kept.append(int(row))
    return people[sorted(kept)]
