"""Keypoints that come as bare numbers: which skeleton so many of them are, and whether they are pixels at all."""

from __future__ import annotations

import numpy as np

from ..arrays import FloatArray
from ..people.skeleton import BLAZEPOSE_33, BODY_25, COCO_17, HALPE_26, Skeleton

#: The skeleton that a number of keypoints stands for where nothing is stated.
BY_COUNT = {len(s): s for s in (COCO_17, HALPE_26, BODY_25, BLAZEPOSE_33)}
#: Whole bodies begin with a known skeleton: COCO-WholeBody's 133 keypoints and Halpe's 136; hands and face follow.
WHOLE_BODIES = {133: COCO_17, 136: HALPE_26}


def skeleton_of(count: int) -> Skeleton | None:
    """Return the skeleton that `count` keypoints are, or begin with; None where none is known."""
    return BY_COUNT.get(count) or WHOLE_BODIES.get(count)


def are_fractions(keypoints: FloatArray) -> bool:
    """Return whether a person of shape (P, K, 2) is spread out over the first pixel: no person is that small."""
    for points in keypoints:
        seen = points[np.isfinite(points).all(axis=-1) & (points != 0).any(axis=-1)]
        if len(seen) > 2 and np.abs(seen).max() <= 1 and np.ptp(seen) > 0:
            return True
    return False
