"""The floor as a mounted camera sees it: pixels to metres and back, the horizon, and what an angle does to a distance.

Floor coordinates are metres to the camera's right and ahead of it, from the point of the floor below the camera.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from ..arrays import FloatArray
from ..errors import CameraError
from .camera import Camera
from .mount import Mount


def level_axes(pitch_rad: float, roll_rad: float) -> FloatArray:
    """Return the matrix (3, 3) from the level frame (right, down, ahead) to the camera's, of one pitch and roll."""
    cp, sp, cr, sr = math.cos(pitch_rad), math.sin(pitch_rad), math.cos(roll_rad), math.sin(roll_rad)
    return np.array([(cr, -sr * cp, sr * sp), (sr, cr * cp, -cr * sp), (0.0, sp, cp)])


def intrinsics_of(mount: Mount) -> Camera:
    """Return a mount's camera; raises CameraError where it has none or does not know its whole place."""
    if mount.camera is None:
        raise CameraError("the mount has no focal length: the floor's place in the picture is unknown")
    if not all(map(math.isfinite, (mount.pitch_rad, mount.roll_rad, mount.height_m))):
        raise CameraError("the mount does not know its pitch, roll and height: the floor's place is unknown")
    return mount.camera


def to_pixels(mount: Mount, floor_m: ArrayLike, above_m: float = 0.0) -> FloatArray:
    """Return the pixels (..., 2) of points of the floor (..., 2), or above it; NaN behind the camera."""
    camera = intrinsics_of(mount)
    floor = np.asarray(floor_m, dtype=float)
    level = np.stack([floor[..., 0], np.full(floor.shape[:-1], mount.height_m - above_m), floor[..., 1]], axis=-1)
    return camera.project(level @ level_axes(mount.pitch_rad, mount.roll_rad).T)


def to_floor(mount: Mount, points_px: ArrayLike) -> FloatArray:
    """Return the points of the floor (..., 2) seen at pixels (..., 2); NaN at the horizon and above it."""
    camera = intrinsics_of(mount)
    level = camera.rays(points_px) @ level_axes(mount.pitch_rad, mount.roll_rad)
    below = np.where(level[..., 1] > 1e-9, level[..., 1], np.nan)
    return level[..., [0, 2]] * (mount.height_m / below)[..., None]


def horizon(mount: Mount) -> tuple[tuple[float, float], tuple[float, float]] | None:
    """Return the horizon's ends at the left and right edge of the picture, of a lens without distortion, pixels.

    None where it is further off than ten pictures, as for a camera that looks straight down.
    """
    camera = intrinsics_of(mount)
    down = level_axes(mount.pitch_rad, mount.roll_rad)[:, 1]
    # rays along the floor: down . (x, y, 1) = 0
    if abs(down[1]) < 1e-6:
        return None
    x = (np.array([0.0, camera.width]) - camera.cx) / camera.fx
    v = camera.cy - camera.fy * (down[2] + down[0] * x) / down[1]
    if np.abs(v).max() > 10 * camera.height:
        return None
    return (0.0, float(v[0])), (float(camera.width), float(v[1]))


def reach(mount: Mount, distance_m: float, pitch_off_rad: float) -> float:
    """Return by how many metres a point of the floor so far ahead is put wrong where the pitch is wrong by an angle."""
    below = math.atan2(mount.height_m, distance_m) + pitch_off_rad
    return mount.height_m / math.tan(below) - distance_m if 0 < below < math.pi else math.inf
