"""The floor of a scene: circles on it as the photo shows them, and the photo laid flat on it. No drawing."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from ..arrays import FloatArray
from ..bodies import Intrinsics
from ..camera import Camera
from ..distances import ground_frame
from ..photo import RGBArray
from ..scene import Scene

#: Corners of a circle that is drawn; nearer to the lens than this nothing is drawn, metres.
_CORNERS, _NEAREST_M = 73, 0.05
#: How far beyond the photo's corners a lens's distortion model is still believed, as a factor.
_BEYOND = 1.02


@dataclass(frozen=True, eq=False)
class Level:
    """A level plane before a camera: the floor, or, where no floor was found, one through the people's middles.

    camera: of the scene. axes: shape (3, 3), right, ahead and up in the camera frame. height_m: shape (P,), how far the
    plane is below the camera, for each person; the floor is the same for all. is_floor: whether it is the floor.
    intrinsics: what the people made of the camera's.
    """

    camera: Camera
    axes: FloatArray
    height_m: FloatArray
    is_floor: bool
    intrinsics: Intrinsics = field(default_factory=Intrinsics)

    @classmethod
    def of(cls, scene: Scene) -> Level | None:
        """Return the floor of a scene, or the planes through its people; None where there is no camera."""
        camera, bodies = scene.camera.camera, scene.bodies
        if camera is None:
            return None
        axes = ground_frame(bodies.up)
        if bodies.floor is not None:
            return cls(camera, axes, np.full(len(bodies), bodies.floor.height_m), True, bodies.intrinsics)
        return cls(camera, axes, -(bodies.positions_m @ axes[2]), False, bodies.intrinsics)

    def circles_px(self, places_m: FloatArray, radius_m: float) -> FloatArray:
        """Return the outlines of circles around places (P, 2), to the right and ahead, in pixels (P, corners, 2).

        NaN where they reach behind the lens.
        """
        angle = np.linspace(0, 2 * np.pi, _CORNERS)
        ring = radius_m * np.stack([np.cos(angle), np.sin(angle)], axis=-1)
        return self.to_pixels(places_m[:, None] + ring, self.height_m[:, None])

    def to_pixels(self, places_m: FloatArray, height_m: FloatArray) -> FloatArray:
        """Return the pixels (..., 2) of places (..., 2), to the right and ahead, so far below the camera; else NaN."""
        below = np.broadcast_to(-height_m, places_m.shape[:-1])
        points = self.intrinsics.seen(np.concatenate([places_m, below[..., None]], axis=-1) @ self.axes)
        # a lens's distortion says nothing of what it does not show: it may fold that back into the picture
        ideal = points[..., :2] / np.where(points[..., 2:] > _NEAREST_M, points[..., 2:], np.nan)
        corners = np.array([(u, v) for u in (0.0, self.camera.width) for v in (0.0, self.camera.height)])
        widest = np.linalg.norm(self.camera.rays(corners)[:, :2], axis=1).max()
        camera = self.camera if any(self.camera.distortion) else self.camera.without_distortion()
        shown = np.linalg.norm(ideal, axis=-1) < (_BEYOND * widest if any(self.camera.distortion) else np.inf)
        return np.where(shown[..., None], camera.project(np.where(shown[..., None], points, np.nan)), np.nan)


def laid_flat(pixels: RGBArray, level: Level, bounds_m: tuple[float, float, float, float], blank: RGBArray) -> RGBArray:
    """Return the photo as seen from straight above, the farthest row first: what lies on the floor has its true shape.

    pixels: the photo at any size. bounds_m: left, right, nearest and farthest edge, to the right and ahead. blank:
    shape (H, W, 3), the answer's size and what it shows where the photo shows no floor.
    """
    height, width = blank.shape[:2]
    x0, x1, y0, y1 = bounds_m
    across = x0 + (np.arange(width) + 0.5) / width * (x1 - x0)
    ahead = y1 - (np.arange(height) + 0.5) / height * (y1 - y0)
    places = np.stack(np.meshgrid(across, ahead), axis=-1)
    at = level.to_pixels(places, level.height_m[:1])
    at = at * (pixels.shape[1] / level.camera.width, pixels.shape[0] / level.camera.height)
    inside = ((at >= 0) & (at <= (pixels.shape[1], pixels.shape[0]))).all(axis=-1)
    answer = blank.copy()
    answer[inside] = _sampled(pixels, at[inside])
    return answer


def _sampled(pixels: RGBArray, at: FloatArray) -> RGBArray:
    """Return the colours (n, 3) at points (n, 2), between the middles of the pixels in proportion."""
    limit = np.array([pixels.shape[1] - 1, pixels.shape[0] - 1])
    point = np.clip(at - 0.5, 0, limit)
    low = np.minimum(point.astype(int), np.maximum(limit - 1, 0))
    high = np.minimum(low + 1, limit)
    fx, fy = (point - low).T[:, :, None]
    top = pixels[low[:, 1], low[:, 0]] * (1 - fx) + pixels[low[:, 1], high[:, 0]] * fx
    bottom = pixels[high[:, 1], low[:, 0]] * (1 - fx) + pixels[high[:, 1], high[:, 0]] * fx
    return np.rint(top * (1 - fy) + bottom * fy).astype(np.uint8)
