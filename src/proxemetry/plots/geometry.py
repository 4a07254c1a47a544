"""Where things are in the two views of a scene: for the figures and for the page alike. No drawing."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from ..arrays import FloatArray
from ..bodies import Bodies
from ..camera import Camera
from ..distances import ground_frame
from ..draws import log_sd
from ..intervals import CHI2_2D
from ..people import People
from ..scene import Scene


def anchors_px(people: People) -> FloatArray:
    """Return where a person's distance lines end, shape (P, 2): the torso's middle, else the best that was seen."""
    boxes = people.boxes_px
    middle = (boxes[:, :2] + boxes[:, 2:]) / 2
    for part in ("Head", "Shoulder", "Torso"):
        point = people.part(part)
        middle = np.where(np.isfinite(point).all(axis=-1, keepdims=True), point, middle)
    return middle


def ground_positions(bodies: Bodies) -> FloatArray:
    """Return positions on the ground, shape (P, 2): metres to the camera's right, and forward."""
    return bodies.positions_m @ ground_frame(bodies.up)[:2].T


def ground_regions(bodies: Bodies) -> FloatArray:
    """Return the outlines of where each person stands with 90 %, shape (P, K, 2); NaN where unknown.

    A depth is uncertain by a factor: at twice the focal length everyone is twice as far. So what the covariance says
    of depth is taken for its logarithm's, which keeps everyone in front of the camera. Where depth is sure the outline
    is the ellipse of the covariance.
    """
    plane = ground_frame(bodies.up)[:2]
    own = np.einsum("ikil->ikl", bodies.covariance_m2.reshape(len(bodies), 3, len(bodies), 3))
    angle = np.linspace(0, 2 * math.pi, _OUTLINE, endpoint=False)
    circle = math.sqrt(CHI2_2D) * np.column_stack([np.cos(angle), np.sin(angle)])
    outlines = np.full((len(bodies), _OUTLINE, 2), np.nan)
    for person in np.flatnonzero(bodies.placed & np.isfinite(own).all(axis=(1, 2))):
        position, covariance = bodies.positions_m[person], own[person]
        values, vectors = np.linalg.eigh(plane @ covariance @ plane.T)
        root = np.sqrt(np.maximum(values, 0.0))
        # Of all errors in space that look like this one from above, the likeliest.
        onto = covariance @ plane.T @ vectors / np.maximum(root, _SURE_M)
        outlines[person] = _before_the_camera(position, circle @ onto.T, covariance) @ plane.T
    return outlines


#: Corners of an outline, and the least standard deviation that is drawn, metres.
_OUTLINE, _SURE_M = 64, 1e-6


def _before_the_camera(position: FloatArray, errors: FloatArray, covariance: FloatArray) -> FloatArray:
    """Return a position with errors (K, 3), in which those of the depth are factors.

    What goes with depth across the picture does so by a power of that factor: the first where a body's size is unsure,
    which leaves it on its line of sight, and none where the focal length is, which leaves it as far from the axis.
    """
    depth = float(position[2])
    relative_sd = math.sqrt(max(float(covariance[2, 2]), 0.0)) / max(depth, _SURE_M)
    if depth <= 0 or relative_sd < _SURE_M:
        return position + errors
    relative = errors[:, 2] / depth
    logarithm = relative * float(log_sd(relative_sd)) / relative_sd
    slope = covariance[:2, 2] / (depth * relative_sd**2)  # of the place across the picture, with depth's relative error
    power = float(np.clip(slope @ position[:2] / max(float(position[:2] @ position[:2]), _SURE_M**2), 0.0, 1.0))
    along = np.outer(np.exp(power * logarithm), position[:2]) + np.outer(logarithm, slope - power * position[:2])
    across = along + errors[:, :2] - np.outer(relative, slope)
    return np.column_stack([across, depth * np.exp(logarithm)])


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


def known_horizon_px(scene: Scene) -> FloatArray | None:
    """Return the horizon's two ends, where pitch and roll are known independently of the people: stated, or by lines.

    None where they are not, or where the horizon lies outside the photo.
    """
    camera, mount = scene.camera.camera, scene.camera.mount
    if camera is None or mount is None or not np.isfinite([mount.pitch_rad, mount.roll_rad]).all():
        return None
    ends = horizon_px(camera, mount.pitch_rad, mount.roll_rad)
    inside = ends[:, 1].max() >= 0 and ends[:, 1].min() <= camera.height  # False of NaN
    return ends if inside else None


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
