"""People's boxes out of a detector's raw answer: decoding, and one box a person.

Boxes are x0, y0, x1, y1 in pixels of whatever the function was given.
"""

from __future__ import annotations

import functools
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from ..arrays import FloatArray
from ..errors import ModelError
from ..overlap import pairwise_iou
from ..people.rival import Rival
from .rivals import LEAST_RATIO, rivals_of


@dataclass(frozen=True, eq=False)
class Detections:
    """N boxes of people, shape (N, 4), with scores 0..1, shape (N,).

    keypoints_px, keypoint_scores: shapes (N, K, 2) and (N, K), the points that the network gives with each box; K is 0
    where it gives none, scores are NaN where it does not score them. rivals: of each box what else it may be, None
    where the network gives nothing else.
    """

    boxes_px: FloatArray
    scores: FloatArray
    keypoints_px: FloatArray = field(default_factory=lambda: np.zeros((0, 0, 2)))
    keypoint_scores: FloatArray = field(default_factory=lambda: np.zeros((0, 0)))
    rivals: tuple[Rival | None, ...] = ()

    def __post_init__(self) -> None:
        if len(self.keypoints_px) != len(self.boxes_px):
            object.__setattr__(self, "keypoints_px", np.zeros((len(self.boxes_px), 0, 2)))
        if self.keypoint_scores.shape != self.keypoints_px.shape[:2]:
            object.__setattr__(self, "keypoint_scores", np.full(self.keypoints_px.shape[:2], np.nan))
        if not self.rivals:
            object.__setattr__(self, "rivals", (None,) * len(self.boxes_px))

    def __len__(self) -> int:
        return len(self.boxes_px)

    def __getitem__(self, rows: NDArray[np.bool_] | NDArray[np.intp] | slice) -> Detections:
        rivals = tuple(self.rivals[row] for row in np.arange(len(self))[rows])
        return Detections(
            self.boxes_px[rows], self.scores[rows], self.keypoints_px[rows], self.keypoint_scores[rows], rivals
        )

    def placed(self, boxes_px: FloatArray) -> Detections:
        """Return the same with other boxes, without points."""
        return Detections(boxes_px, self.scores, rivals=self.rivals)

    @property
    def centres_px(self) -> FloatArray:
        """The boxes' middles, shape (N, 2)."""
        return (self.boxes_px[:, :2] + self.boxes_px[:, 2:]) / 2


_NANODET_STRIDES = (8, 16, 32)
#: Of so many boxes at once the overlaps with all others are computed.
_AT_ONCE = 32
NOBODY = Detections(np.zeros((0, 4)), np.zeros(0))


def joined(parts: list[Detections]) -> Detections:
    """Return the detections of several parts of a photo as one."""
    parts = [part for part in parts if len(part)] or parts[:1]
    if not parts:
        return NOBODY
    return Detections(
        np.concatenate([p.boxes_px for p in parts]),
        np.concatenate([p.scores for p in parts]),
        np.concatenate([p.keypoints_px for p in parts]),
        np.concatenate([p.keypoint_scores for p in parts]),
        tuple(rival for p in parts for rival in p.rivals),
    )


@functools.lru_cache(maxsize=8)
def _grid(size: tuple[int, int], strides: tuple[int, ...]) -> tuple[FloatArray, FloatArray]:
    """Return the cells of all feature maps, shape (N, 2), and the stride of each, shape (N, 1)."""
    cells = [
        np.stack(np.meshgrid(np.arange(size[0] // s), np.arange(size[1] // s)), axis=-1).reshape(-1, 2) for s in strides
    ]
    each = [np.full((len(c), 1), s) for c, s in zip(cells, strides, strict=True)]
    return np.concatenate(cells).astype(float), np.concatenate(each).astype(float)


def decode_yolox(
    outputs: list[NDArray[np.float32]], size: tuple[int, int], person: int = 0, least: float = 0.0,
    rivals_from: float = 0.0,
) -> Detections:  # fmt: skip
    """Decode YOLOX's raw heads, one array of shape (1, N, 5 + classes): cell offsets, log sizes, objectness, classes.

    size: (width, height) of the input. Only boxes scoring at least `least` come back, and of those of `rivals_from` or
    more what else they may be. Ge et al. 2021 (YOLOX).
    """
    raw = outputs[0][0]
    cells, strides = _grid(size, (8, 16, 32))
    if raw.ndim != 2 or len(raw) != len(cells) or raw.shape[1] <= 5 + person:
        raise ModelError(
            f"the detector returns {outputs[0].shape}, which is not a YOLOX head for an input of {size[0]} x "
            f"{size[1]}: expected (1, {len(cells)}, 5 + classes)"
        )
    scores = raw[:, 4].astype(float) * raw[:, 5 + person]
    rows = np.flatnonzero(scores >= least)

    def boxes_of(rows: NDArray[np.intp]) -> FloatArray:
        centres = (raw[rows, :2] + cells[rows]) * strides[rows]
        halves = np.exp(raw[rows, 2:4].astype(float)) * strides[rows] / 2
        return np.concatenate([centres - halves, centres + halves], axis=1)

    boxes = boxes_of(rows)
    # no class scores more than the objectness that it is multiplied by
    seen = np.flatnonzero(raw[:, 4] >= LEAST_RATIO * rivals_from)
    classes = raw[seen, 4:5] * raw[seen, 5:]
    rivals = rivals_of(boxes, scores[rows], classes, person, lambda near: boxes_of(seen[near]), rivals_from)
    return Detections(boxes, scores[rows], rivals=rivals)


def decode_boxes(
    outputs: list[NDArray[np.float32]], size: tuple[int, int], person: int = 0, least: float = 0.0,
    rivals_from: float = 0.0,
) -> Detections:  # fmt: skip
    """Decode a detector that ends in its own suppression, as MMDeploy exports RTMDet and YOLOX.

    outputs: boxes with scores of shape (1, N, 5), and where there is a second array the classes of shape (1, N).
    """
    rows = outputs[0][0] if outputs[0].ndim == 3 else outputs[0]
    if rows.ndim != 2 or rows.shape[1] < 5:
        raise ModelError(f"the detector returns {outputs[0].shape}: expected boxes with scores, (1, N, 5)")
    keep = rows[:, 4] >= max(least, 1e-6)
    if len(outputs) > 1:
        keep &= outputs[1].reshape(-1)[: len(rows)].astype(int) == person
    return Detections(rows[keep, :4].astype(float), rows[keep, 4].astype(float))


def decode_ultralytics(
    outputs: list[NDArray[np.float32]], size: tuple[int, int], person: int = 0, least: float = 0.0,
    rivals_from: float = 0.0,
) -> Detections:  # fmt: skip
    """Decode an anchor-free head of shape (1, 4 + classes, N): centre x, y, width, height, class scores."""
    raw = outputs[0][0].T
    if raw.ndim != 2 or raw.shape[1] <= 4 + person:
        raise ModelError(f"the detector returns {outputs[0].shape}: expected (1, 4 + classes, N)")
    scores = raw[:, 4 + person].astype(float)
    rows = np.flatnonzero(scores >= least)

    def boxes_of(rows: NDArray[np.intp]) -> FloatArray:
        sides = raw[rows, :4].astype(float)
        return np.concatenate([sides[:, :2] - sides[:, 2:] / 2, sides[:, :2] + sides[:, 2:] / 2], axis=1)

    boxes = boxes_of(rows)
    return Detections(
        boxes, scores[rows], rivals=rivals_of(boxes, scores[rows], raw[:, 4:], person, boxes_of, rivals_from)
    )


def decode_nanodet(
    outputs: list[NDArray[np.float32]], size: tuple[int, int], person: int = 0, least: float = 0.0,
    rivals_from: float = 0.0,
) -> Detections:  # fmt: skip
    """Decode NanoDet: for strides 8, 16 and 32 class scores (1, N, classes), then distances (1, N, 4 bins).

    How far each side of a box lies from its cell's middle is the mean of a distribution over whole strides (Li et al.
    2020, Generalized Focal Loss).
    """
    cells, strides = _grid(size, _NANODET_STRIDES)
    classes = np.concatenate([part[0] for part in outputs[: len(_NANODET_STRIDES)]])
    sides = np.concatenate([part[0] for part in outputs[len(_NANODET_STRIDES) :]])
    if not len(cells) == len(classes) == len(sides) or sides.shape[1] % 4 or classes.shape[1] <= person:
        shapes = ", ".join(str(part.shape) for part in outputs)
        raise ModelError(f"the detector returns {shapes}, which is not a NanoDet head for {size[0]} x {size[1]}")
    rows = np.flatnonzero(classes[:, person] >= least)

    def boxes_of(rows: NDArray[np.intp]) -> FloatArray:
        logits = sides[rows].reshape(len(rows), 4, sides.shape[1] // 4).astype(float)
        chances = np.exp(logits - logits.max(axis=-1, initial=-np.inf, keepdims=True))
        bins = np.arange(logits.shape[-1])
        distances = (chances @ bins) / chances.sum(axis=-1) * strides[rows]
        middles = (cells[rows] + 0.5) * strides[rows]
        return np.concatenate([middles - distances[:, :2], middles + distances[:, 2:]], axis=1)

    boxes, scores = boxes_of(rows), classes[rows, person].astype(float)
    return Detections(boxes, scores, rivals=rivals_of(boxes, scores, classes, person, boxes_of, rivals_from))


def suppressed(found: Detections, most_overlap: float) -> Detections:
    """Return the best-scoring boxes, none overlapping a better one by more than `most_overlap`; best first."""
    order = np.argsort(-found.scores, kind="stable")
    boxes, left = found.boxes_px[order], np.ones(len(order), dtype=bool)
    for begin in range(0, len(order), _AT_ONCE):
        # a few of the best at a time: one by one takes six times as long, all at once the square of the memory
        rows = begin + np.flatnonzero(left[begin : begin + _AT_ONCE])
        overlaps = np.nan_to_num(pairwise_iou(boxes[rows], boxes[begin:]))
        overlaps[(boxes[rows, None] == boxes[None, begin:]).all(axis=-1)] = 1.0
        drops = overlaps > most_overlap
        for row, dropped in zip(rows.tolist(), drops, strict=True):
            if left[row]:
                left[row + 1 :] &= ~dropped[row - begin + 1 :]
    return found[order[left]]


def seen_often(found: Detections, among: Detections, overlap: float, least: int) -> Detections:
    """Return the boxes that at least so many of `among` overlap by more than `overlap`, themselves included.

    A person is seen by several neighbouring cells of a detector and in several tiles; what one cell alone takes for a
    person is seldom one.
    """
    if least <= 1 or not len(found):
        return found
    return found[(pairwise_iou(found.boxes_px, among.boxes_px) > overlap).sum(axis=1) >= least]


def uncut(found: Detections, region: tuple[int, int, int, int], photo_size: tuple[int, int]) -> Detections:
    """Return a tile's boxes that its inner edges do not cut: another tile or the whole photo sees those better.

    photo_size: (width, height). An edge counts as touched within a hundredth of the tile's longer side.
    """
    x0, y0, x1, y1 = region
    margin, boxes = 0.01 * max(x1 - x0, y1 - y0), found.boxes_px
    keep = np.ones(len(found), dtype=bool)
    for column, edge, is_inner, sign in (
        (0, x0, x0 > 0, 1), (1, y0, y0 > 0, 1), (2, x1, x1 < photo_size[0], -1), (3, y1, y1 < photo_size[1], -1),
    ):  # fmt: skip
        if is_inner:
            keep &= sign * (boxes[:, column] - edge) > margin
    return found[keep]


DECODERS = {
    "yolox": decode_yolox,
    "boxes": decode_boxes,
    "ultralytics": decode_ultralytics,
    "nanodet": decode_nanodet,
}
