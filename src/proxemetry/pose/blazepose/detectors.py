"""Where people and faces may be: MediaPipe's two detectors over windows of several sizes.

Both see little more than a dozen small heads' worth of one window at once, so the photo is also shown to them in
overlapping windows of a fraction of its long side.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ...arrays import FloatArray
from ...overlap import iou
from ..detections import Detections, joined
from .networks import Network
from .regions import Picture

Window = tuple[int, int, int, int]

#: Boxes that overlap by more than this are one, as in MediaPipe.
_MERGE_IOU = 0.3


@dataclass(frozen=True)
class Head:
    """What makes a detector: its strides with the anchors a cell has, and how many points come with a box."""

    grids: tuple[tuple[int, int], ...]
    points: int


#: Points of a pose detection: middle of the hips, a point above on the circle around the whole body, the same two for
#: the upper body. Its box is around the head. Points of a face: right eye, left eye, nose, mouth, right ear, left ear.
POSE_HEAD = Head(((8, 2), (16, 2), (32, 6)), 4)
FACE_HEAD = Head(((4, 1),), 6)


class Detector:
    """One of the two detectors at work on windows of a picture."""

    def __init__(self, path: Path, head: Head, threads: int) -> None:
        self._network, self._head = Network(path, threads), head
        self._anchors = _anchors(self._network.side, head)

    def find(self, picture: Picture, windows: list[Window], threshold: float) -> Detections:
        """Return what scores above the threshold, merged within each window but not across windows."""
        return joined([self._nothing(), *(merged(self._in_window(picture, w, threshold)) for w in windows)])

    def _nothing(self) -> Detections:
        return Detections(np.zeros((0, 4)), np.zeros(0), np.zeros((0, self._head.points, 2)))

    def _in_window(self, picture: Picture, window: Window, threshold: float) -> Detections:
        canvas, scale, offset = picture.letterboxed(window, self._network.side)
        outputs = self._network(canvas.astype(np.float32) / np.float32(127.5) - np.float32(1)).values()
        raw, logits = sorted(outputs, key=lambda output: -output.size)
        rows = np.flatnonzero(logits.ravel() > math.log(threshold / (1 - threshold)))
        scores = 1 / (1 + np.exp(-logits.ravel()[rows].astype(float)))
        values = raw.reshape(len(self._anchors), -1)[rows].astype(float)
        centre, half = values[:, :2] + self._anchors[rows], np.abs(values[:, 2:4]) / 2
        points = values[:, 4:].reshape(len(rows), self._head.points, 2) + self._anchors[rows, None]
        boxes = np.concatenate([centre - half - offset, centre + half - offset], axis=1) / scale
        corner = np.array(window[:2])
        return Detections(boxes + np.tile(corner, 2), scores, (points - offset) / scale + corner)


def windows_of(width: int, height: int, fraction: float, overlap: float) -> Iterator[Window]:
    """Yield windows (x, y, width, height) of a fraction of the long side that cover a photo evenly."""
    side = max(1, round(max(width, height) * fraction))
    for y in _starts(height, side, overlap):
        for x in _starts(width, side, overlap):
            yield x, y, min(width, side), min(height, side)


def _starts(length: int, side: int, overlap: float) -> list[int]:
    if length <= side:
        return [0]
    count = math.ceil((length - side) / (side * (1 - overlap))) + 1
    return [round(k * (length - side) / (count - 1)) for k in range(count)]


def _anchors(side: int, head: Head) -> FloatArray:
    grids: list[FloatArray] = []
    for stride, per_cell in head.grids:
        y, x = np.mgrid[stride / 2 : side : stride, stride / 2 : side : stride]
        grids.append(np.stack([x, y], axis=-1).reshape(-1, 2).repeat(per_cell, axis=0))
    return np.concatenate(grids)


def merged(found: Detections) -> Detections:
    """Return overlapping boxes as their mean, weighted by score, with the best score (MediaPipe's weighted NMS)."""
    order = np.argsort(-found.scores, kind="stable")
    groups: list[NDArray[np.intp]] = []
    while len(order):
        same = iou(found.boxes_px[order[0]], found.boxes_px[order]) > _MERGE_IOU
        same[0] = True
        groups.append(order[same])
        order = order[~same]
    return mean_of_groups(found, groups)


def mean_of_groups(found: Detections, groups: list[NDArray[np.intp]]) -> Detections:
    """Return each group's mean weighted by score, with its best score; the best comes first in a group."""
    if not groups:
        return found
    weights = [found.scores[rows] / found.scores[rows].sum() for rows in groups]
    return Detections(
        np.array([w @ found.boxes_px[rows] for w, rows in zip(weights, groups, strict=True)]),
        np.array([found.scores[rows[0]] for rows in groups]),
        np.array([np.tensordot(w, found.keypoints_px[rows], 1) for w, rows in zip(weights, groups, strict=True)]),
    )
