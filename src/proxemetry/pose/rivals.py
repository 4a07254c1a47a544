"""What else a detector of many classes sees where it sees a person, out of its raw answer."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from ..arrays import FloatArray
from ..overlap import areas_of, pairwise_iou, shared_areas
from ..people.rival import Rival

#: The classes of detectors trained on COCO, in its order (cocodataset.org).
COCO_CLASSES = (
    "person", "bicycle", "car", "motorcycle", "airplane", "bus", "train", "truck", "boat", "traffic light",
    "fire hydrant", "stop sign", "parking meter", "bench", "bird", "cat", "dog", "horse", "sheep", "cow", "elephant",
    "bear", "zebra", "giraffe", "backpack", "umbrella", "handbag", "tie", "suitcase", "frisbee", "skis", "snowboard",
    "sports ball", "kite", "baseball bat", "baseball glove", "skateboard", "surfboard", "tennis racket", "bottle",
    "wine glass", "cup", "fork", "knife", "spoon", "bowl", "banana", "apple", "sandwich", "orange", "broccoli",
    "carrot", "hot dog", "pizza", "donut", "cake", "chair", "couch", "potted plant", "bed", "dining table", "toilet",
    "tv", "laptop", "mouse", "remote", "keyboard", "cell phone", "microwave", "oven", "toaster", "sink", "refrigerator",
    "book", "clock", "vase", "scissors", "teddy bear", "hair drier", "toothbrush",
)  # fmt: skip

#: What people ride, sit on, wear, carry and play with: seen in a person's place it says nothing against the person.
COMPANIONS = frozenset((
    "bicycle", "car", "motorcycle", "airplane", "bus", "train", "truck", "boat", "bench", "backpack", "umbrella",
    "handbag", "tie", "suitcase", "frisbee", "skis", "snowboard", "sports ball", "baseball bat", "baseball glove",
    "skateboard", "surfboard", "tennis racket", "bottle", "wine glass", "cup", "chair", "couch", "bed", "dining table",
    "toilet", "laptop", "cell phone", "book",
))  # fmt: skip

#: Boxes that overlap as much are of one thing. What a person wears, holds or sits on has a box of its own, a smaller or
#: a larger one.
SAME_PLACE = 0.7
#: Rivals that score less than this part of the person's score do not count.
LEAST_RATIO = 0.05
#: What shows people who are not there: one that lies inside of it may be on a screen, a poster or a page.
SHOWING = ("tv", "laptop", "cell phone", "book", "microwave", "oven", "refrigerator")
#: So much of a person's box lies inside such a thing: frames cut feet and elbows, and boxes are not exact.
INSIDE = 0.85

_SHOWING = [COCO_CLASSES.index(name) for name in SHOWING]
_COMPANIONS = [row for row, name in enumerate(COCO_CLASSES) if name in COMPANIONS]


def rivals_of(
    boxes_px: FloatArray, scores: FloatArray, class_scores: NDArray[np.floating], person: int,
    boxes_of: Callable[[NDArray[np.intp]], FloatArray], least: float = 0.0,
) -> tuple[Rival | None, ...]:  # fmt: skip
    """Return of each of R boxes of people (R, 4) the other class that scores highest in its place, None without any.

    Of COCO's classes `COMPANIONS` do not count, and `SHOWING` do that hold the whole person.
    scores: shape (R,), of the people. class_scores: shape (N, C), what every cell of the network gives every class;
    boxes_of returns the boxes (M, 4) of M cells by their rows, in the coordinates of boxes_px. least: boxes of lower
    scores get None.
    """
    asked = scores >= least
    if not asked.all():
        found = iter(rivals_of(boxes_px[asked], scores[asked], class_scores, person, boxes_of))
        return tuple(next(found) if one else None for one in asked.tolist())
    if not len(boxes_px) or class_scores.shape[1] < 2:
        return (None,) * len(boxes_px)
    # of thousands of cells a few dozen see anything: to look at those alone is most of what this takes
    near = np.flatnonzero(class_scores.max(axis=1) >= LEAST_RATIO * max(float(scores.min()), 1e-6))
    class_scores, boxes_near = class_scores[near], boxes_of(near)
    of_coco = class_scores.shape[1] == len(COCO_CLASSES) and person == 0
    without = {person, *(_COMPANIONS if of_coco else ())}
    columns = [column for column in range(class_scores.shape[1]) if column not in without]
    named = [COCO_CLASSES[column] if of_coco else f"class {column}" for column in columns]
    there = _strongest(boxes_px, scores, class_scores[:, columns], boxes_near, _in_the_same_place)
    rivals = [Rival(named[k], ratio) if ratio >= LEAST_RATIO else None for k, ratio in there]
    if of_coco:
        around = _strongest(boxes_px, scores, class_scores[:, _SHOWING], boxes_near, _inside)
        for row, (k, ratio) in enumerate(around):
            other = rivals[row]
            if ratio >= LEAST_RATIO and (other is None or ratio > other.ratio):
                rivals[row] = Rival(SHOWING[k], ratio, shows=True)
    return tuple(rivals)


def _strongest(
    boxes_px: FloatArray, scores: FloatArray, class_scores: NDArray[np.floating], others_px: FloatArray,
    meets: Callable[[FloatArray, FloatArray], NDArray[np.bool_]],
) -> list[tuple[int, float]]:  # fmt: skip
    """Return each person's column and ratio of the class that scores highest in a box that meets the person's."""
    best = class_scores.max(axis=1)
    rows = np.flatnonzero(best >= LEAST_RATIO * max(float(scores.min()), 1e-6))
    if not len(rows):
        return [(0, 0.0)] * len(boxes_px)
    there = np.where(meets(boxes_px, others_px[rows]), best[rows], 0.0)
    strongest = there.argmax(axis=1)
    ratios = there[np.arange(len(there)), strongest] / np.maximum(scores, 1e-6)
    return list(zip(class_scores[rows[strongest]].argmax(axis=1).tolist(), ratios.tolist(), strict=True))


def _in_the_same_place(people: FloatArray, others: FloatArray) -> NDArray[np.bool_]:
    return np.nan_to_num(pairwise_iou(people, others)) >= SAME_PLACE


def _inside(people: FloatArray, others: FloatArray) -> NDArray[np.bool_]:
    """Return which people (R, 4) lie inside of which boxes (M, 4), shape (R, M)."""
    areas = np.maximum(areas_of(people), 1e-9)
    return shared_areas(people, others) >= INSIDE * areas[:, None]
