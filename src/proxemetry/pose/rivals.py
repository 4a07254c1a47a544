"""What else a detector of many classes sees where it sees a person, out of its raw answer."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from ..arrays import FloatArray
from ..overlap import pairwise_iou
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
#: Rivals that score less than this part of the person's score are none.
LEAST_RATIO = 0.05


_COMPANIONS = [row for row, name in enumerate(COCO_CLASSES) if name in COMPANIONS]


def rivals_of(
    boxes_px: FloatArray, scores: FloatArray, class_scores: NDArray[np.floating], person: int,
    boxes_of: Callable[[NDArray[np.intp]], FloatArray], least: float = 0.0,
) -> tuple[Rival | None, ...]:  # fmt: skip
    """Return of each of R boxes of people (R, 4) the other class that scores highest in its place, None without any.

    Of COCO's classes `COMPANIONS` do not count.
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
    others = class_scores.copy()
    of_coco = class_scores.shape[1] == len(COCO_CLASSES) and person == 0
    others[:, [person, *(_COMPANIONS if of_coco else ())]] = 0.0
    best = others.max(axis=1)
    rows = np.flatnonzero(best >= LEAST_RATIO * max(float(scores.min()), 1e-6))
    if not len(rows):
        return (None,) * len(boxes_px)
    same = np.nan_to_num(pairwise_iou(boxes_px, boxes_of(rows))) >= SAME_PLACE
    there = np.where(same, best[rows], 0.0)
    strongest = there.argmax(axis=1)
    ratios = there[np.arange(len(there)), strongest] / np.maximum(scores, 1e-6)
    names = others[rows[strongest]].argmax(axis=1)
    return tuple(
        Rival(COCO_CLASSES[name] if of_coco else f"class {name}", float(ratio)) if ratio >= LEAST_RATIO else None
        for name, ratio in zip(names.tolist(), ratios.tolist(), strict=True)
    )
