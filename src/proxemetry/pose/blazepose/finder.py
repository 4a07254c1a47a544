"""Boxes around people: MediaPipe's SSD on MobileNetV2, trained on Open Images, over the whole photo and tiles of it.

Its boxes show where people may be. Whether a person is there, and how the body lies, is for the landmark network.
"""

from __future__ import annotations

import math
from itertools import product
from pathlib import Path

import numpy as np

from ...arrays import FloatArray
from ..detections import Detections, joined, suppressed, uncut
from ..onnx.letterbox import Region as Window
from ..onnx.letterbox import tiles, tiles_around
from .networks import Network
from .regions import Picture

_PERSON, _CLASSES = 4, 24
# The anchors of TensorFlow's object detection API (Liu et al. 2016, section 2.2): six layers of cells, in each cell
# boxes of one size and several shapes (width / height), and a square one between this layer's size and the next's.
_STRIDES = (16, 32, 64, 128, 256, 512)
_SIZES = (0.2, 0.35, 0.5, 0.65, 0.8, 0.95, 1.0)
_SHAPES = (1.0, 2.0, 0.5, 3.0, 1 / 3)
_LOWEST_LAYER = ((0.1, 1.0), (0.2, 2.0), (0.2, 0.5))
# The network's outputs are relative to an anchor's size, and times these.
_MIDDLE_SCALE, _SIDE_SCALE = 10.0, 5.0
#: Boxes of one look that overlap by more than this are one person's.
_SAME_BOX = 0.5


class PersonFinder:
    """The detector at work on pictures."""

    def __init__(self, path: Path, threads: int) -> None:
        self._network = Network(path, threads)
        self._anchors = _anchors(self._network.side)

    def find(
        self, picture: Picture, fractions: tuple[float, ...], *, suspicion: float, threshold: float, guided: bool
    ) -> Detections:
        """Return the best of the boxes that overlap, best first.

        The whole photo gives every suspected person, down to `suspicion`. Tiles of the fractions of its longer
        side must reach `threshold`: each is one more chance to be wrong. guided: tiles lie only around suspects.
        """
        width, height = picture.width, picture.height
        found = [self._in_window(picture, (0, 0, width, height), suspicion)]
        for fraction in fractions:
            windows = (
                tiles_around(found[0].boxes_px, width, height, fraction) if guided else tiles(width, height, fraction)
            )
            found += [uncut(self._in_window(picture, window, threshold), window, (width, height)) for window in windows]
        return suppressed(joined(found), _SAME_BOX)

    def _in_window(self, picture: Picture, window: Window, threshold: float) -> Detections:
        x0, y0, x1, y1 = window
        side = self._network.side
        canvas, scale, offset = picture.letterboxed((x0, y0, x1 - x0, y1 - y0), side)
        outputs = self._network(canvas.astype(np.float32) / np.float32(127.5) - np.float32(1))
        logits = outputs[len(self._anchors) * _CLASSES].reshape(-1, _CLASSES)[:, _PERSON]
        rows = np.flatnonzero(logits > math.log(threshold / (1 - threshold)))
        raw = outputs[len(self._anchors) * 4].reshape(-1, 4)[rows].astype(float)
        middles, sides = self._anchors[rows, :2], self._anchors[rows, 2:]
        middles = middles + raw[:, :2] / _MIDDLE_SCALE * sides
        half = np.exp(raw[:, 2:] / _SIDE_SCALE) * sides / 2
        # the network counts y before x
        boxes = np.concatenate([middles - half, middles + half], axis=1)[:, [1, 0, 3, 2]] * side
        scores = 1 / (1 + np.exp(-logits[rows].astype(float)))
        placed = (boxes - np.tile(offset, 2)) / scale + (x0, y0, x0, y0)
        placed = placed.clip(0, (picture.width, picture.height) * 2)
        return suppressed(Detections(placed, scores), _SAME_BOX)


def _anchors(side: int) -> FloatArray:
    """Return the anchors' middles and sides as fractions of the input, shape (N, 4): y, x, height, width."""
    rows: list[tuple[float, float, float, float]] = []
    for layer, stride in enumerate(_STRIDES):
        between = math.sqrt(_SIZES[layer] * _SIZES[layer + 1])
        kinds = [*((_SIZES[layer], shape) for shape in _SHAPES), (between, 1.0)] if layer else _LOWEST_LAYER
        cells = math.ceil(side / stride)
        for y, x in product(range(cells), repeat=2):
            for size, shape in kinds:
                rows.append(((y + 0.5) / cells, (x + 0.5) / cells, size / math.sqrt(shape), size * math.sqrt(shape)))
    return np.array(rows)
