"""Pieces of a photo as a network wants them: letterboxed whole, or cut out square and turned.

All coordinates are in pixels with (0, 0) the outer corner of the top-left pixel; OpenCV's warp counts from pixel
centres, which is undone here and nowhere else.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import cv2
import numpy as np

from ...arrays import FloatArray, RGBArray

#: A crop is taken from a copy of the photo that is at most this much larger, or linear sampling would skip pixels.
_MAX_SHRINK = 1.6


@dataclass(frozen=True)
class Region:
    """A square of a photo: centre, side length in pixels, and the angle by which it is turned clockwise."""

    x: float
    y: float
    size: float
    angle_rad: float = 0.0

    @classmethod
    def around(cls, centre: FloatArray, edge: FloatArray, factor: float) -> Region:
        """Return the square around a circle given by its centre and a point straight above on its edge."""
        dx, dy = (float(v) for v in edge - centre)
        return cls(float(centre[0]), float(centre[1]), 2 * math.hypot(dx, dy) * factor, math.atan2(dx, -dy))

    def moved(self, right: float, down: float, grown: float = 1.0, turned_rad: float = 0.0) -> Region:
        """Return the square moved along its own axes by fractions of its size, grown and turned."""
        dx, dy = self._axes() @ (right * self.size, down * self.size)
        return Region(self.x + dx, self.y + dy, self.size * grown, self.angle_rad + turned_rad)

    def to_photo(self, points: FloatArray) -> FloatArray:
        """Map points of shape (..., 2), in fractions of the square (0..1), to pixels of the photo."""
        return (points - 0.5) * self.size @ self._axes().T + (self.x, self.y)

    def from_photo(self, points_px: FloatArray) -> FloatArray:
        """Map pixels of the photo to fractions of the square."""
        return (points_px - (self.x, self.y)) @ self._axes() / self.size + 0.5

    def resembles(self, other: Region) -> bool:
        """Return whether a network would see nearly the same in both: 3 % of the size, 6 % of scale, 7 degrees."""
        near = max(abs(self.x - other.x), abs(self.y - other.y)) < 0.03 * other.size
        turn = (self.angle_rad - other.angle_rad + math.pi) % (2 * math.pi) - math.pi
        return near and abs(math.log(self.size / other.size)) < 0.06 and abs(turn) < 0.12

    def _axes(self) -> FloatArray:
        """Return the square's right and down directions in the photo, as columns."""
        c, s = math.cos(self.angle_rad), math.sin(self.angle_rad)
        return np.array([[c, -s], [s, c]])


class Picture:
    """RGB pixels of shape (H, W, 3) and their halved copies, made when a crop needs them."""

    def __init__(self, pixels: RGBArray) -> None:
        self._levels = [pixels]
        self.height, self.width = pixels.shape[:2]

    def crop(self, region: Region, side: int) -> RGBArray:
        """Return the region as (side, side, 3); black outside the photo."""
        source = self._level(region.size / side)
        scale = np.array([source.shape[1] / self.width, source.shape[0] / self.height])
        corner, right, down = (
            region.to_photo(np.array(p)) * scale for p in ((0.0, 0.0), (1.0 / side, 0.0), (0.0, 1.0 / side))
        )
        linear = np.stack([right - corner, down - corner], axis=1)
        shift = corner + linear @ (0.5, 0.5) - 0.5
        matrix = np.concatenate([linear, shift[:, None]], axis=1)
        return cv2.warpAffine(source, matrix, (side, side), flags=cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP)  # type: ignore[return-value]

    def letterboxed(self, window: tuple[int, int, int, int], side: int) -> tuple[RGBArray, float, FloatArray]:
        """Return a window (x, y, width, height) in the middle of a black (side, side, 3).

        With it come the canvas pixels per pixel of the photo, and the window's corner on the canvas.
        """
        x, y, width, height = window
        scale = side / max(width, height)
        size = max(1, round(width * scale)), max(1, round(height * scale))
        source = self._level(1 / scale)
        fx, fy = source.shape[1] / self.width, source.shape[0] / self.height
        part = source[round(y * fy) : max(round((y + height) * fy), 1), round(x * fx) : max(round((x + width) * fx), 1)]
        left, top = (side - size[0]) // 2, (side - size[1]) // 2
        canvas = np.zeros((side, side, 3), np.uint8)
        way = cv2.INTER_AREA if scale < 1 else cv2.INTER_LINEAR
        canvas[top : top + size[1], left : left + size[0]] = cv2.resize(part, size, interpolation=way)
        return canvas, scale, np.array([left, top], dtype=float)

    def _level(self, shrink: float) -> RGBArray:
        """Return the smallest copy from which a crop is still shrunk by no less than half of `_MAX_SHRINK`."""
        level = 0
        while shrink > _MAX_SHRINK and min(self._levels[level].shape[:2]) > 1:
            level, shrink = level + 1, shrink / 2
            if level == len(self._levels):
                height, width = (max(1, (n + 1) // 2) for n in self._levels[-1].shape[:2])
                self._levels.append(cv2.resize(self._levels[-1], (width, height), interpolation=cv2.INTER_AREA))  # type: ignore[arg-type]
        return self._levels[level]
