"""Whether two pictures are of a camera at one place: how most of what stands still in the one lies in the other.

Corners are followed by optical flow, and the motion that most of them share is the camera's, since people are the
smaller part of a picture and move each in their own way.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from ..arrays import FloatArray, RGBArray

GrayArray = NDArray[np.uint8]

#: The background is looked at in pictures of this width.
WIDTH_PX = 480
#: A camera has moved when its picture has by this share of its width: a quarter of a degree of a usual lens, from which
#: on distances are wrong by more than 5 % (PETS 2009: half a degree is 6-7 % along the line of sight).
MOVED_SHARE = 0.0045
#: Fewer corners than this share that are found again: another picture altogether.
FOUND_AGAIN = 0.35
FEWEST_CORNERS = 12


@dataclass(frozen=True)
class Motion:
    """How a picture lies to another: the shift of its corners in pixels, and the share of points found again."""

    shift_px: float
    found: float
    matrix: FloatArray


def is_at_one_place(reference: GrayArray, gray: GrayArray) -> bool:
    """Return whether a small picture shows what another one does, from the same place in the same direction."""
    if reference.shape != gray.shape:
        return False
    motion = motion_between(reference, corners_of(reference), gray)
    return motion is not None and motion.found >= FOUND_AGAIN and motion.shift_px <= MOVED_SHARE * gray.shape[1]


def small_gray(pixels: RGBArray) -> GrayArray:
    """Return a picture (H, W, 3) in gray, `WIDTH_PX` wide where it is wider."""
    gray = cv2.cvtColor(pixels, cv2.COLOR_RGB2GRAY)
    height, width = gray.shape
    if width <= WIDTH_PX:
        return gray.astype(np.uint8)
    size = (WIDTH_PX, max(1, round(height * WIDTH_PX / width)))
    return cv2.resize(gray, size, interpolation=cv2.INTER_AREA).astype(np.uint8)


def corners_of(gray: GrayArray) -> NDArray[np.float32]:
    """Return well-spread corners, shape (n, 1, 2), so that no crowd in one place outvotes the background."""
    found: Any = cv2.goodFeaturesToTrack(gray, 200, 0.01, max(8.0, gray.shape[1] / 40))
    return np.zeros((0, 1, 2), np.float32) if found is None else found.astype(np.float32)


def motion_between(before: GrayArray, corners: NDArray[np.float32], now: GrayArray) -> Motion | None:
    """Return how `now` lies to `before` by most of its corners, None where there is nothing to go by."""
    if len(corners) < FEWEST_CORNERS:
        return None
    moved, status, _ = cv2.calcOpticalFlowPyrLK(before, now, corners, None)  # pyright: ignore[reportCallIssue, reportArgumentType]
    back, status_back, _ = cv2.calcOpticalFlowPyrLK(now, before, moved, None)  # pyright: ignore[reportCallIssue, reportArgumentType]
    same = np.linalg.norm((back - corners).reshape(-1, 2), axis=1) < 1.0
    good = (status.ravel() > 0) & (status_back.ravel() > 0) & same
    if good.sum() < FEWEST_CORNERS // 2:
        return Motion(math.inf, 0.0, np.eye(3))
    fitted: Any = cv2.estimateAffinePartial2D(
        corners[good], moved[good], method=cv2.RANSAC, ransacReprojThreshold=1.0, confidence=0.999
    )
    matrix, inliers = fitted
    if matrix is None:
        return Motion(math.inf, 0.0, np.eye(3))
    whole = np.vstack([matrix, [0.0, 0.0, 1.0]])
    return Motion(shift_of(whole, now.shape), float(inliers.sum()) / len(corners), whole)


def shift_of(matrix: FloatArray, shape: tuple[int, ...]) -> float:
    """Return by how many pixels a motion moves the picture's inside, at most: turning and zooming count too."""
    height, width = shape[:2]
    # half way to the corners: what turns about the middle does not count as if only the corners mattered
    x, y = np.array([0.25, 0.75, 0.25, 0.75]) * width, np.array([0.25, 0.25, 0.75, 0.75]) * height
    points = np.stack([x, y, np.ones(4)])
    return float(np.linalg.norm((matrix @ points - points)[:2], axis=0).max())
