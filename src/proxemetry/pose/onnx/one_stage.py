"""People and their keypoints out of one network that looks at the whole photo.

Decoders have a detector's form (`detections`): they take the outputs for one input, and return who scores at least
`least` with their keypoints, in pixels of the input.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ...errors import ModelError
from ..detections import Detections


def decode_rtmo(
    outputs: list[NDArray[np.float32]], size: tuple[int, int], person: int = 0, least: float = 0.0
) -> Detections:
    """Decode RTMO (Lu et al. 2024) as MMDeploy exports it: boxes with scores (1, N, 5), keypoints (1, N, K, 3)."""
    shaped = sorted(outputs, key=lambda o: o.ndim)
    if len(shaped) != 2 or shaped[0].ndim != 3 or shaped[1].ndim != 4 or shaped[1].shape[3] != 3:
        shapes = ", ".join(str(o.shape) for o in outputs)
        raise ModelError(f"the network returns {shapes}: expected boxes (1, N, 5) and keypoints (1, N, K, 3)")
    boxes, points = shaped[0][0].astype(float), shaped[1][0].astype(float)
    keep = boxes[:, 4] >= max(least, 1e-6)
    boxes, points = boxes[keep], points[keep]
    # whole-numbered keypoints name the middle of a pixel, boxes its corners
    return Detections(boxes[:, :4], boxes[:, 4], points[..., :2] + 0.5, points[..., 2].clip(0, 1))


def decode_ultralytics_pose(
    outputs: list[NDArray[np.float32]], size: tuple[int, int], person: int = 0, least: float = 0.0
) -> Detections:
    """Decode a pose head of shape (1, 5 + 3 K, N): centre x, y, width, height, score, then x, y, score a joint."""
    raw = outputs[0][0].T.astype(float)
    if raw.ndim != 2 or raw.shape[1] < 8 or (raw.shape[1] - 5) % 3:
        raise ModelError(f"the network returns {outputs[0].shape}: expected (1, 5 + 3 K, N)")
    raw = raw[raw[:, 4] >= least]
    boxes = np.concatenate([raw[:, :2] - raw[:, 2:4] / 2, raw[:, :2] + raw[:, 2:4] / 2], axis=1)
    points = raw[:, 5:].reshape(len(raw), (raw.shape[1] - 5) // 3, 3)
    return Detections(boxes, raw[:, 4], points[..., :2] + 0.5, points[..., 2].clip(0, 1))


ONE_STAGE = {"rtmo": decode_rtmo, "ultralytics-pose": decode_ultralytics_pose}
