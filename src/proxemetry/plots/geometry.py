"""Where things are in the two views of a scene: for the figures and for the page alike. No drawing."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from ..arrays import FloatArray
from ..bodies import Bodies
from ..camera import Camera
from ..distances import ground_frame
from ..intervals import CHI2_2D
from ..people import People


def anchors_px(people: People) -> FloatArray:
    """Return where a person's distance lines end, shape (P, 2): the torso's middle, else the best that was seen."""
    boxes = people.boxes_px
    middle = (boxes[:, :2] + boxes[:, 2:]) / 2
    for part in ("Head", "Shoulder", "Torso"):
        point = people.part(part)
        middle = np.where(np.isfinite(point).all(axis=-1, keepdims=True), point, middle)
    return middle


def ground_positions(bodies: Bodies) -> tuple[FloatArray, FloatArray]:
    """Return positions (P, 2) and covariances (P, 2, 2) on the ground: metres to the camera's right, and forward."""
    frame = ground_frame(bodies.up)[:2]
    blocks = bodies.covariance_m2.reshape(len(bodies), 3, len(bodies), 3)
    own = np.einsum("ikil->ikl", blocks)
    return bodies.positions_m @ frame.T, frame @ own @ frame.T


def ellipse(covariance_m2: FloatArray) -> tuple[float, float, float]:
    """Return the half axes in metres and the angle in radians, from right to forward, of the 90 % ellipse."""
    values, vectors = np.linalg.eigh(covariance_m2)
    a, b = np.sqrt(CHI2_2D * np.maximum(values, 0))
    return float(a), float(b), math.atan2(vectors[1, 0], vectors[0, 0])


def horizon_px(camera: Camera, pitch_rad: float, roll_rad: float) -> FloatArray:
    """Return where the horizon meets the photo's left and right edge, pixels (2, 2); NaN where it stands upright.

    Of an ideal camera: a bent lens bends it. pitch_rad, roll_rad: as in `bodies.Floor`.
    """
    down = np.array([-math.sin(roll_rad) * math.cos(pitch_rad), math.cos(roll_rad) * math.cos(pitch_rad),
                     math.sin(pitch_rad)])  # fmt: skip
    if abs(down[1]) < 1e-6:
        return np.full((2, 2), np.nan)
    u = np.array([0.0, float(camera.width)])
    x = (u - camera.cx) / camera.fx
    return np.column_stack([u, camera.cy - camera.fy * (down[0] * x + down[2]) / down[1]])


def camera_as_fitted(camera: Camera, bodies: Bodies) -> Camera:
    """Return a camera with the focal length and principal point that its people made of it, and are placed with."""
    fitted = bodies.intrinsics
    return replace(
        camera, fx=camera.fx * fitted.focal_factor, fy=camera.fy * fitted.focal_factor,
        cx=camera.cx + camera.fx * fitted.shift[0], cy=camera.cy + camera.fy * fitted.shift[1],
    )  # fmt: skip


def field_of_view(camera: Camera, up: FloatArray | None) -> FloatArray:
    """Return unit vectors on the ground, shape (2, 2), along the left and the right edge of the photo."""
    edges = np.array([[0.0, camera.cy], [camera.width, camera.cy]])
    sides = camera.rays(edges) @ ground_frame(up)[:2].T
    return sides / np.linalg.norm(sides, axis=1, keepdims=True)
