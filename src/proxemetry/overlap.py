"""How alike two boxes or two skeletons are: intersection over union, and COCO's object keypoint similarity."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from .arrays import FloatArray

#: COCO's constants: how far labellers disagree on a joint, as a fraction of the square root of the person's area
#: (cocodataset.org, keypoint evaluation).
SIGMAS = {
    "nose": 0.026, "eye": 0.025, "ear": 0.035, "shoulder": 0.079, "elbow": 0.072, "wrist": 0.062, "hip": 0.107,
    "knee": 0.087, "ankle": 0.089,
}  # fmt: skip
#: Of joints that COCO lacks (feet, neck, hands): between a wrist's and a shoulder's.
SIGMA_OF_OTHERS = 0.075


def iou(box: FloatArray, others: FloatArray) -> FloatArray:
    """Return the intersection over union of one box (4,) with others (N, 4), shape (N,).

    Boxes are x0, y0, x1, y1. A box without area overlaps with nothing but itself; one of NaN with nothing.
    """
    return np.where((others == box).all(axis=1), 1.0, np.nan_to_num(pairwise_iou(box[None], others)[0]))


def pairwise_iou(a: FloatArray, b: FloatArray) -> FloatArray:
    """Return the intersection over union of boxes (N, 4) with others (M, 4), shape (N, M).

    It is NaN where one of the two is no box, of NaN or both without area.
    """
    shared = shared_areas(a, b)
    union = areas_of(a)[:, None] + areas_of(b) - shared
    return np.divide(shared, union, out=np.full_like(union, np.nan), where=union > 0)


def shared_areas(a: FloatArray, b: FloatArray) -> FloatArray:
    """Return the area that boxes (N, 4) share with others (M, 4), shape (N, M); NaN with a box of NaN."""
    # axis by axis: arrays (N, M, 2) and products along them take four times as long
    wide = np.minimum(a[:, 2, None], b[:, 2]) - np.maximum(a[:, 0, None], b[:, 0])
    high = np.minimum(a[:, 3, None], b[:, 3]) - np.maximum(a[:, 1, None], b[:, 1])
    shared = np.maximum(wide, 0.0, out=wide)
    shared *= np.maximum(high, 0.0, out=high)
    return shared


def areas_of(boxes: FloatArray) -> FloatArray:
    """Return the areas of boxes (N, 4), shape (N,); 0 of one that is turned inside out."""
    sides = np.maximum(boxes[:, 2:] - boxes[:, :2], 0.0)
    return sides[:, 0] * sides[:, 1]


def sigmas_of(joints: Sequence[str]) -> FloatArray:
    """Return the constants of joints by name ("left_eye_outer" is none of COCO's), shape (K,)."""
    return np.array([SIGMAS.get(joint.split("_")[-1], SIGMA_OF_OTHERS) for joint in joints])


def keypoint_similarity(
    squared_px2: FloatArray, area_px2: FloatArray, sigmas: FloatArray, weights: FloatArray
) -> FloatArray:
    """Return COCO's object keypoint similarity, 0..1: the weighted mean of exp(-d^2 / (2 area (2 sigma)^2)).

    squared_px2: shape (..., K), squared distances of the joints. area_px2: shape (...), of the person. sigmas: shape
    (K,). weights: shape (..., K), 0 for joints that do not count; where none counts the similarity is 0.
    """
    likeness = np.exp(-squared_px2 / (8 * area_px2[..., None] * sigmas**2))
    total = weights.sum(axis=-1)
    return np.divide((likeness * weights).sum(axis=-1), total, out=np.zeros_like(total), where=total > 0)
