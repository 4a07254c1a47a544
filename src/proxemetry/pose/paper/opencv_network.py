"""Darknet and Caffe files through OpenCV 4's reader; OpenCV 5 has none for them."""

from __future__ import annotations

import threading
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...errors import ModelError
from ...photo import RGBArray
from ..detections import Detections, suppressed

_FORMATS = {"Darknet": "readNetFromDarknet", "Caffe": "readNetFromCaffe"}


class OpenCvNetwork:
    """A network in two files: its description and its weights. One caller at a time runs it, others wait.

    kind: "Darknet" (.cfg, .weights) or "Caffe" (.prototxt, .caffemodel). Raises ModelError where a file is absent,
    cannot be read, or this OpenCV has no such reader.
    """

    def __init__(self, kind: str, description: str | Path, weights: str | Path) -> None:
        import cv2

        self.files = Path(description), Path(weights)
        for file in self.files:
            if not file.is_file():
                raise ModelError(f"{file}: no such network file")
        reader = getattr(cv2.dnn, _FORMATS[kind], None)
        if reader is None:
            raise ModelError(f"OpenCV {cv2.__version__} reads no {kind} files: pip install 'proxemetry[paper]'")
        try:
            self._net: Any = reader(*map(str, self.files))
        except cv2.error as error:
            raise ModelError(
                f"{self.files[0]} with {self.files[1].name}: OpenCV cannot read them ({error.err})"
            ) from error
        self._outputs: Sequence[str] = self._net.getUnconnectedOutLayersNames()
        self._lock = threading.Lock()

    def run(self, blob: NDArray[np.float32]) -> list[NDArray[np.float32]]:
        """Return the outputs for one blob of shape (1, 3, H, W)."""
        import cv2

        with self._lock:
            try:
                self._net.setInput(blob)
                return [np.array(o, np.float32) for o in self._net.forward(self._outputs)]
            except cv2.error as error:
                raise ModelError(f"{self.files[1].name} does not fit {self.files[0].name} ({error.err})") from error


class DarknetDetector:
    """People's boxes by a YOLO of the Darknet family.

    size: (width, height) of the input, to which the picture is stretched, as Darknet does. score: boxes below are
    dropped. overlap: of two people's boxes overlapping more the surer one stays. person: the class.
    """

    def __init__(
        self,
        description: str | Path,
        weights: str | Path,
        *,
        size: tuple[int, int] = (704, 704),
        score: float = 0.3,
        overlap: float = 0.4,
        person: int = 0,
    ) -> None:
        self.network = OpenCvNetwork("Darknet", description, weights)
        self.size, self.score, self.overlap, self.person = size, score, overlap, person

    def detect(self, pixels: RGBArray) -> Detections:
        """Return the people in RGB pixels of shape (H, W, 3), in those pixels, best first."""
        import cv2

        blob = cv2.dnn.blobFromImage(pixels, 1 / 255, self.size)  # already RGB, which Darknet wants
        rows = np.concatenate([o.reshape(-1, o.shape[-1]) for o in self.network.run(np.asarray(blob, np.float32))])
        if rows.shape[1] <= 5 + self.person:
            raise ModelError(
                f"{self.network.files[0].name} returns {rows.shape[1]} numbers per box: that is not a YOLO network"
            )
        return self._decoded(rows.astype(float), pixels.shape[1], pixels.shape[0])

    def _decoded(self, rows: NDArray[np.float64], width: int, height: int) -> Detections:
        # OpenCV's region layer answers centre and size relative to the picture; class scores contain the objectness
        scores = rows[:, 5 + self.person]
        # a box is a person's where no other class is likelier
        is_person = (scores >= self.score) & (rows[:, 5:].argmax(axis=1) == self.person)
        rows, scores = rows[is_person], scores[is_person]
        halves = rows[:, 2:4] / 2
        boxes = np.concatenate([rows[:, :2] - halves, rows[:, :2] + halves], axis=1) * (width, height, width, height)
        return suppressed(Detections(boxes.clip(0, (width, height, width, height)), scores), self.overlap)
