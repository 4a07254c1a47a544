"""The camera: pinhole intrinsics with lens distortion, in pixels of the upright photo.

Camera frame: x right, y down, z forward, metres, origin at the optical centre. Pixel (0, 0) is the outer corner of
the top-left pixel, so resizing is multiplication and cropping is subtraction.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import cast

import numpy as np
from numpy.typing import ArrayLike

from ..arrays import FloatArray
from ..errors import CameraError
from ..photo import LARGEST_PX
from .sources import FocalSource, Source

#: Focal lengths that a lens can have, as parts of the photo's side. Fisheyes have a quarter of the long one, a
#: telescope of ten metres on a full-frame sensor 280 times; a narrow crop makes either a hundred times more.
FOCAL_RANGE = (0.01, 10_000.0)
#: Beyond what any calibration finds; larger ones overflow.
_STRONGEST_DISTORTION = 1e6

NO_DISTORTION = (0.0, 0.0, 0.0, 0.0, 0.0)
_UNDISTORT_ITERATIONS = 30
_USER = Source(FocalSource.USER)


@dataclass(frozen=True)
class Camera:
    """Intrinsics of one photo.

    `fx`, `fy`, `cx`, `cy`, `width`, `height` are in pixels of the upright photo. `distortion` is OpenCV's
    (k1, k2, p1, p2, k3). `focal_rel_sd` is the relative standard deviation of the focal length (0 = exact),
    `principal_sd_px` that of the principal point in pixels (a crop's is unknown). `source` is where the focal
    length came from; a plain text counts as stated by the user.

    Raises CameraError where a focal length or a size is not a positive finite number, or a standard deviation negative.
    """

    fx: float
    fy: float
    cx: float
    cy: float
    width: int
    height: int
    distortion: tuple[float, float, float, float, float] = NO_DISTORTION
    focal_rel_sd: float = 0.0
    principal_sd_px: float = 0.0
    source: Source = _USER

    def __post_init__(self) -> None:
        object.__setattr__(self, "source", _source(self.source))
        for name in ("fx", "fy", "cx", "cy", "width", "height", "focal_rel_sd", "principal_sd_px"):
            object.__setattr__(self, name, _as_number(name, getattr(self, name)))
        object.__setattr__(self, "distortion", tuple(_as_number("distortion", value) for value in self.distortion))
        self._check_ranges()
        for name in ("focal_rel_sd", "principal_sd_px"):
            if getattr(self, name) < 0:
                raise CameraError(f"camera {name} is {getattr(self, name)}: a standard deviation is 0 or more")
        if len(self.distortion) != 5 or not all(abs(k) <= _STRONGEST_DISTORTION for k in self.distortion):
            raise CameraError(f"camera distortion is {self.distortion}: it must be five finite numbers k1 k2 p1 p2 k3")

    def _check_ranges(self) -> None:
        for name in ("fx", "fy", "width", "height"):
            value = getattr(self, name)
            if not (math.isfinite(value) and value > 0):
                raise CameraError(f"camera {name} is {value}: it must be a positive number of pixels")
        for name in ("cx", "cy", "focal_rel_sd", "principal_sd_px"):
            if not math.isfinite(getattr(self, name)):
                raise CameraError(f"camera {name} is {getattr(self, name)}: it must be a finite number")
        long_side = max(self.width, self.height)
        if long_side > LARGEST_PX:
            raise CameraError(f"camera size is {self.width} x {self.height}: no photo is larger than {LARGEST_PX:,}")
        for name, side in (("fx", self.width), ("fy", self.height)):
            if not FOCAL_RANGE[0] * side <= getattr(self, name) <= FOCAL_RANGE[1] * side:
                raise CameraError(
                    f"camera {name} is {getattr(self, name):.7g}: no lens has less than {FOCAL_RANGE[0]:g} or more "
                    f"than {FOCAL_RANGE[1]:,g} times the photo's {side} pixels"
                )
        for name in ("cx", "cy"):
            if abs(getattr(self, name)) > FOCAL_RANGE[1] * long_side:
                raise CameraError(f"camera {name} is {getattr(self, name):.7g}: it is nowhere near the photo")

    @classmethod
    def centred(
        cls, f_px: float, width: int, height: int, *, focal_rel_sd: float = 0.0, source: Source | str = _USER
    ) -> Camera:
        """Return the camera with square pixels and its principal point in the middle of the photo."""
        middle = (width / 2, height / 2)
        return cls(f_px, f_px, *middle, width, height, focal_rel_sd=focal_rel_sd, source=_source(source))

    @property
    def f_px(self) -> float:
        """The focal length in pixels: the geometric mean of `fx` and `fy`."""
        return math.sqrt(self.fx * self.fy)

    def with_focal(self, f_px: float, *, focal_rel_sd: float = 0.0, source: Source | str = _USER) -> Camera:
        """Return this camera with another focal length; the pixels' aspect ratio stays."""
        factor = f_px / self.f_px
        return replace(
            self, fx=self.fx * factor, fy=self.fy * factor, focal_rel_sd=focal_rel_sd, source=_source(source)
        )

    def resized(self, width: int, height: int) -> Camera:
        """Return the camera of the same photo resized to `width` x `height` pixels."""
        sx, sy = width / self.width, height / self.height
        return replace(
            self, fx=self.fx * sx, fy=self.fy * sy, cx=self.cx * sx, cy=self.cy * sy, width=width, height=height,
            principal_sd_px=self.principal_sd_px * math.sqrt(sx * sy),
        )  # fmt: skip

    def cropped(self, x0: int, y0: int, x1: int, y1: int) -> Camera:
        """Return the camera of the region [x0, x1) x [y0, y1) of the photo."""
        return replace(self, cx=self.cx - x0, cy=self.cy - y0, width=x1 - x0, height=y1 - y0)

    def mirrored(self) -> Camera:
        """Return the camera of the photo flipped left to right."""
        k1, k2, p1, p2, k3 = self.distortion
        return replace(self, cx=self.width - self.cx, distortion=(k1, k2, p1, -p2, k3))

    def project(self, points_m: ArrayLike) -> FloatArray:
        """Project points of shape (..., 3) in the camera frame, metres, to pixels of shape (..., 2).

        Points behind the camera come back as NaN, so that row i stays row i. Raises CameraError for another shape.
        """
        points = _of_length(points_m, 3)
        depth = np.where(points[..., 2] > 0, points[..., 2], np.nan)
        ideal = points[..., :2] / depth[..., None]
        return self._pixels(_distort(ideal, self.distortion))

    def rays(self, points_px: ArrayLike) -> FloatArray:
        """Return the rays (x, y, 1) of shape (..., 3) through pixels of shape (..., 2), lens distortion undone.

        Raises CameraError for another shape.
        """
        pixels = _of_length(points_px, 2)
        bent = (pixels - (self.cx, self.cy)) / (self.fx, self.fy)
        ideal = _undistort(bent, self.distortion)
        return np.concatenate([ideal, np.ones_like(ideal[..., :1])], axis=-1)

    def undistorted(self, points_px: ArrayLike) -> FloatArray:
        """Return pixels of shape (..., 2) moved to where a lens without distortion would have put them.

        Raises CameraError for another shape.
        """
        if self.distortion == NO_DISTORTION:
            return _of_length(points_px, 2).copy()
        return self._pixels(self.rays(points_px)[..., :2])

    def without_distortion(self) -> Camera:
        """Return the ideal camera to which `undistorted` pixels belong."""
        return replace(self, distortion=NO_DISTORTION)

    def _pixels(self, normalised: FloatArray) -> FloatArray:
        return normalised * (self.fx, self.fy) + (self.cx, self.cy)


def _source(source: Source | str) -> Source:
    if isinstance(source, Source):
        return source
    if not isinstance(cast(object, source), str):
        raise CameraError(f"camera source is {source!r:.40}: it must be a text, or a Source")
    return Source(FocalSource.USER, source)


def _as_number(name: str, value: object) -> float:
    """Return a number as Python's own: an element of an array is none that JSON knows."""
    if isinstance(value, int | float):
        return value
    array = np.asarray(value)
    if array.shape or array.dtype.kind not in "iuf":
        raise CameraError(f"camera {name} is {value!r:.40}: it must be a number")
    return array.item()


def _of_length(points: ArrayLike, length: int) -> FloatArray:
    """Return points as an array of shape (..., length): numpy would spread a single number over all axes."""
    array = np.asarray(points, dtype=float)
    if not array.ndim or array.shape[-1] != length:
        raise CameraError(f"points must have shape (..., {length}), not {array.shape}")
    return array


def _distort(ideal: FloatArray, distortion: tuple[float, float, float, float, float]) -> FloatArray:
    """Apply OpenCV's radial and tangential model to normalised points of shape (..., 2)."""
    if distortion == NO_DISTORTION:
        return ideal
    k1, k2, p1, p2, k3 = distortion
    x, y = ideal[..., 0], ideal[..., 1]
    r2 = x * x + y * y
    radial = 1 + r2 * (k1 + r2 * (k2 + r2 * k3))
    return np.stack(
        [
            x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x),
            y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y,
        ],
        axis=-1,
    )


def _undistort(bent: FloatArray, distortion: tuple[float, float, float, float, float]) -> FloatArray:
    """Invert `_distort` by Newton's method on the 2x2 Jacobian taken by finite differences."""
    if distortion == NO_DISTORTION:
        return bent
    ideal, step = bent.copy(), 1e-6
    for _ in range(_UNDISTORT_ITERATIONS):
        residual = _distort(ideal, distortion) - bent
        jx = (_distort(ideal + (step, 0.0), distortion) - bent - residual) / step
        jy = (_distort(ideal + (0.0, step), distortion) - bent - residual) / step
        determinant = jx[..., 0] * jy[..., 1] - jy[..., 0] * jx[..., 1]
        dx = (residual[..., 0] * jy[..., 1] - residual[..., 1] * jy[..., 0]) / determinant
        dy = (residual[..., 1] * jx[..., 0] - residual[..., 0] * jx[..., 1]) / determinant
        ideal = ideal - np.stack([dx, dy], axis=-1)
        if not np.nanmax(np.abs(residual), initial=0.0) > 1e-12:
            break
    return ideal
