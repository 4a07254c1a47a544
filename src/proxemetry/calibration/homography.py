"""Homographies between a picture and a floor: from points, and taken apart into a camera's place."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from ..arrays import FloatArray
from ..camera import FloorFrame
from ..camera.floor_view import level_axes
from ..errors import CameraError
from ..files import read_text

#: A homography of points whose second smallest singular value is below this share of the largest has no one answer.
_LEAST_RANK = 1e-7
_ON_A_LINE = "they lie on one line, or all but one do: take points that span an area"


def homography(source: FloatArray, target: FloatArray) -> FloatArray:
    """Return the matrix (3, 3) that takes points (N, 2) of one plane to those of another, N >= 4, by linear equations.

    Raises CameraError where the points do not determine it.
    """
    a, from_source = _normalised(source)
    b, from_target = _normalised(target)
    for points in (a, b):
        spread = np.linalg.svd(points, compute_uv=False)
        if spread[1] < _LEAST_RANK * spread[0]:
            raise CameraError(f"the points determine no camera: {_ON_A_LINE}")
    plain = np.column_stack([a, np.ones(len(a))])
    across = np.column_stack([plain, 0 * plain, -b[:, :1] * plain])
    system = np.concatenate([across, np.column_stack([0 * plain, plain, -b[:, 1:] * plain])])
    _, size, rows = np.linalg.svd(system, full_matrices=True)
    if size[7] < _LEAST_RANK * size[0]:
        raise CameraError(f"the points determine no camera: {_ON_A_LINE}")
    return np.linalg.inv(from_target) @ rows[-1].reshape(3, 3) @ from_source


def _normalised(points: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return points about their middle, on average the square root of two from it, and what made them so (3, 3)."""
    middle = points.mean(axis=0)
    size = float(np.linalg.norm(points - middle, axis=1).mean()) / math.sqrt(2)
    if not size > 0:
        raise CameraError("the points determine no camera: they are all the same one")
    matrix = np.array([[1 / size, 0, -middle[0] / size], [0, 1 / size, -middle[1] / size], [0, 0, 1]])
    return (points - middle) / size, matrix


def focal_of(floor_to_px: FloatArray, centre_px: tuple[float, float], aspect: float) -> float | None:
    """Return the focal length along x, in pixels, of which a homography is the picture, or None where it fixes none.

    aspect: fx / fy. The images of the floor's two axes are at right angles and of one scale, which are two equations.
    """
    moved = np.array([[1, 0, -centre_px[0]], [0, aspect, -aspect * centre_px[1]], [0, 0, 1]]) @ floor_to_px
    (a, b, c), (d, e, f) = moved[:, 0], moved[:, 1]
    # (a d + b e) w + c f = 0 and (a^2 + b^2 - d^2 - e^2) w + c^2 - f^2 = 0, with w = 1 / focal^2
    left = np.array([a * d + b * e, a * a + b * b - d * d - e * e])
    right = -np.array([c * f, c * c - f * f])
    power = float(left @ left)
    w = float(left @ right) / power if power > 0 else 0.0
    return 1 / math.sqrt(w) if w > 1e-12 else None


def place_of(floor_to_ray: FloatArray, floor_m: FloatArray) -> tuple[float, float, float, FloorFrame]:
    """Return pitch, roll, height in metres and the floor's frame of the homography from the floor to rays (x, y, 1).

    floor_m: shape (N, 2), points before the camera.
    """
    scaled = floor_to_ray / np.linalg.norm(floor_to_ray[:, :2], axis=0).mean()
    depths = np.column_stack([floor_m, np.ones(len(floor_m))]) @ scaled[2]
    scaled = scaled * math.copysign(1.0, float(np.median(depths)))
    u, _, v = np.linalg.svd(np.column_stack([scaled[:, 0], scaled[:, 1], np.cross(scaled[:, 0], scaled[:, 1])]))
    rotation = u @ np.diag([1.0, 1.0, float(np.linalg.det(u @ v))]) @ v
    where = -rotation.T @ scaled[:, 2]
    mirrored = bool(where[2] < 0)
    up = -rotation[:, 2] if mirrored else rotation[:, 2]
    pitch, roll = math.asin(float(np.clip(-up[2], -1, 1))), math.atan2(up[0], -up[1])
    right = rotation[:, :2].T @ level_axes(pitch, roll)[:, 0]
    frame = FloorFrame(float(where[0]), float(where[1]), math.atan2(right[1], right[0]), mirrored)
    return pitch, roll, abs(float(where[2])), frame


def read_homography(path: str | Path) -> FloatArray:
    """Read three lines of three numbers, from pixels (u, v, 1) to floor metres; raises CameraError for all else."""
    try:
        matrix = np.array([
            [float(cell) for cell in line.replace(",", " ").split()]
            for line in read_text(path).splitlines() if line.strip()
        ])  # fmt: skip
    except OSError as error:
        raise CameraError(f"{path}: cannot be read ({error.strerror})") from error
    except ValueError as error:
        raise CameraError(f"{path}: no homography, three lines of three numbers ({error})") from error
    if matrix.shape != (3, 3) or not np.isfinite(matrix).all():
        raise CameraError(f"{path}: no homography: it must be three lines of three finite numbers")
    if np.linalg.cond(matrix) > 1e14:
        raise CameraError(f"{path}: the homography takes the picture to a line: its determinant is 0")
    return matrix
