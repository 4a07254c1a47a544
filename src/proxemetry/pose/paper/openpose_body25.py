"""OpenPose BODY_25 on a picture: its own input-size rule, the network, and the joints back in the picture."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ...arrays import FloatArray
from ...errors import ModelError
from ...photo import RGBArray
from .body25 import CHANNELS, decode
from .opencv_network import OpenCvNetwork

#: OpenPose's `--net_resolution -1x368`.
NET_HEIGHT = 368


class Body25:
    """The network of OpenPose's BODY_25, given by the user: its .prototxt and .caffemodel."""

    def __init__(self, description: str | Path, weights: str | Path, *, net_height: int = NET_HEIGHT) -> None:
        self.network = OpenCvNetwork("Caffe", description, weights)
        self.net_height = net_height

    def detect(self, pixels: RGBArray) -> tuple[FloatArray, FloatArray]:
        """Return all people's joints in RGB pixels of shape (H, W, 3): points (P, 25, 2), NaN unseen, and scores."""
        size = net_size(pixels.shape[1], pixels.shape[0], self.net_height)
        scale = net_scale(pixels.shape[1], pixels.shape[0], size)
        points, scores = decode(self._maps(pixels, size, scale))
        # whole-numbered positions of the input are positions of the picture times the scale; + 0.5 is ours, and theirs
        return points / scale + 0.5, scores

    def _maps(self, pixels: RGBArray, size: tuple[int, int], scale: float) -> NDArray[np.float32]:
        """Return the network's answer at the size of its input, shape (78, H, W)."""
        import cv2

        matrix = np.array([[scale, 0, 0], [0, scale, 0]], dtype=float)
        how = cv2.INTER_CUBIC if scale > 1 else cv2.INTER_AREA
        drawn = cv2.warpAffine(pixels, matrix, size, flags=how, borderMode=cv2.BORDER_CONSTANT)
        blob = np.asarray(drawn[..., ::-1].transpose(2, 0, 1)[None], np.float32) / np.float32(256) - np.float32(
            0.5
        )  # BGR
        answer = self.network.run(np.ascontiguousarray(blob))[0]
        if answer.ndim != 4 or answer.shape[1] != CHANNELS:
            raise ModelError(
                f"{self.network.files[0].name} returns {answer.shape}: BODY_25 has (1, {CHANNELS}, height, width)"
            )
        return np.stack([cv2.resize(channel, size, interpolation=cv2.INTER_CUBIC) for channel in answer[0]])


def net_size(width: int, height: int, net_height: int = NET_HEIGHT) -> tuple[int, int]:
    """Return the (width, height) of the input for a picture: the width in proportion, a multiple of 16."""
    return max(16, 16 * round(net_height * width / height / 16)), net_height


def net_scale(width: int, height: int, size: tuple[int, int]) -> float:
    """Return the factor by which a picture is drawn into an input of `size`: its corner pixels stay inside."""
    return min((size[0] - 1) / max(width - 1, 1), (size[1] - 1) / max(height - 1, 1))
