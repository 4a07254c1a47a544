"""The whole picture that a file is a part or a copy of: resized files, crops, and how far they can be distinguished."""

from __future__ import annotations

import cmath
import math
from dataclasses import dataclass, replace

from ..intervals import HALF_WIDTH_SD
from ..photo.metadata import Crop, Metadata

#: Shapes of sensors, long side to short. 16:9 and 1:1 are mostly crops made by the camera, centred.
_SENSOR_SHAPES = {"3:2": 1.5, "4:3": 4 / 3, "16:9": 16 / 9, "1:1": 1.0}
_SHAPE_TOLERANCE = 0.015
#: Relative sd of a diagonal that may belong to a larger sensor: 16:9 out of 4:3 loses 8 % of it, 1:1 out of 3:2 27 %.
_CAMERA_CROP_SD = {"16:9": 0.04, "1:1": 0.12}
#: The same for an editor's crop of unknown extent, and the spread of its centre as a part of the long side.
_EDITOR_CROP_SD = 0.2
_EDITOR_CROP_SHIFT = 0.1
#: How well a recorded rectangle determines the whole picture, as a relative standard deviation of its size: editors
#: count a few rows and columns of the sensor more or less than the camera does.
_RECORDED_CROP_SD = 0.004


@dataclass(frozen=True)
class Frame:
    """The uncropped picture, measured in pixels of the upright file.

    width_px, height_px: its size; the file's own where it is not known to be a crop. size_rel_sd: the relative
    standard deviation of that size. scale: pixels of the file for one pixel as first stored, with scale_rel_sd.
    crop: the evidence that the file is a crop, or None. principal_sd_px: how far the principal point may be from the
    middle of the file, as a standard deviation per axis in pixels; from principal_px where that is known instead.
    is_whole_known: whether width_px and height_px are the whole picture's, rather than those of an unknown part of it.
    is_tied: whether the metadata still hold the size of another stage than this file: what was cut or resized since.
    """

    width_px: float
    height_px: float
    size_rel_sd: float = 0.0
    scale: float = 1.0
    scale_rel_sd: float = 0.0
    crop: str | None = None
    principal_sd_px: float = 0.0
    principal_px: tuple[float, float] | None = None
    is_whole_known: bool = True
    is_tied: bool = False

    @property
    def diagonal_px(self) -> float:
        """The diagonal of the uncropped picture in pixels of the file."""
        return math.hypot(self.width_px, self.height_px)

    @property
    def aspect(self) -> float:
        """Long side to short."""
        return max(self.width_px, self.height_px) / min(self.width_px, self.height_px)


def frame_of(width: int, height: int, metadata: Metadata) -> Frame:
    """Return the uncropped picture behind a file of `width` x `height` upright pixels (METHOD section 7.2)."""
    stored = _stored(width, height, metadata)
    if stored is not None and not _same_shape((width, height), stored):
        return _crop_of(width, height, stored)
    scale = 1.0 if stored is None else max(width, height) / max(stored)  # exactly 1 where nothing was resized
    tied = scale != 1.0
    recorded = None if metadata.crop is None else _recorded_crop(width, height, metadata.crop, scale)
    if recorded is not None:
        return replace(recorded, is_tied=tied)
    shape = _shape(width, height)
    if metadata.cropped or shape is None:
        evidence = "an editor's crop is recorded" if metadata.cropped else "its shape is no sensor's"
        shift = _EDITOR_CROP_SHIFT * max(width, height)
        return Frame(
            width, height, _EDITOR_CROP_SD, scale, crop=evidence, principal_sd_px=shift, is_whole_known=False,
            is_tied=tied,
        )  # fmt: skip
    return Frame(width, height, _CAMERA_CROP_SD.get(shape, 0.0), scale, is_tied=tied)


def _stored(width: int, height: int, metadata: Metadata) -> tuple[int, int] | None:
    """Return the size as first stored, turned as the file is: editors turn pixels and leave the old size standing."""
    if metadata.stored_width_px is None or metadata.stored_height_px is None:
        return None
    stored = (metadata.stored_width_px, metadata.stored_height_px)
    turned = (stored[1], stored[0])
    if _same_shape((width, height), stored):
        return stored
    fits = width <= stored[0] and height <= stored[1]
    return turned if _same_shape((width, height), turned) or not fits else stored


def _same_shape(a: tuple[int, int], b: tuple[int, int]) -> bool:
    rounding = max(0.005, 1.5 / min(*a, *b))
    return abs(math.log(a[0] / a[1] * b[1] / b[0])) <= rounding


def _crop_of(width: int, height: int, stored: tuple[int, int]) -> Frame:
    """Return the frame of a file whose shape differs from the stored one.

    What cuts without rewriting the stored size seldom resizes as well, so it was cut at full size; the interval
    reaches down to the largest cut that fits, made smaller.
    """
    smallest = max(width / stored[0], height / stored[1])
    scale = max(1.0, smallest)
    scale_sd = math.log(scale / smallest) / HALF_WIDTH_SD
    full = (stored[0] * scale, stored[1] * scale)
    room = math.hypot(full[0] - width, full[1] - height) / math.sqrt(2)
    return Frame(
        *full, size_rel_sd=scale_sd, scale=scale, scale_rel_sd=scale_sd,
        crop=f"stored as {stored[0]} x {stored[1]}", principal_sd_px=room / math.sqrt(12), is_tied=True,
    )  # fmt: skip


@dataclass(frozen=True)
class _Reading:
    """A recorded rectangle as a part of a sensor's picture of some shape, turned or not.

    miss: by how much its shape differs from the file's, as a logarithm. shape: the picture's width over its height.
    height_px: the picture's height in pixels of the file. away: from the rectangle's middle to the picture's, right
    and down as one complex number, in heights of the picture.
    """

    miss: float
    turned: bool
    shape: float
    height_px: float
    away: complex


def _recorded_crop(width: int, height: int, crop: Crop, scale: float) -> Frame | None:
    """Return the frame of a file that shows a recorded rectangle of a picture with a sensor's shape, or None.

    The rectangle is that of the sensor's picture, which may have been turned upright since; what is tried is whether
    the rectangle then has the file's shape. Which way a turned one was turned is not recorded: there the principal
    point is only known to be on one side or the other.
    """
    best: _Reading | None = None
    angle = math.radians(crop.angle_deg)
    for turned in (False, True):
        file_width, file_height = (height, width) if turned else (width, height)
        for shape in _SENSOR_SHAPES.values():  # places as complex numbers, in heights of the sensor's picture
            upper, lower = complex(crop.left * shape, crop.top), complex(crop.right * shape, crop.bottom)
            for turn in (cmath.exp(1j * angle), cmath.exp(-1j * angle)):
                kept = (lower - upper) * turn
                if kept.real <= 0 or kept.imag <= 0:
                    continue
                miss = abs(math.log(kept.real / kept.imag * file_height / file_width))
                if best is None or miss < best.miss - 1e-9:
                    away = (complex(shape / 2, 0.5) - (upper + lower) / 2) * turn
                    best = _Reading(miss, turned, shape, file_width / kept.real, away)
    if best is None or best.miss > _SHAPE_TOLERANCE:
        return None
    height_px, away = best.height_px, best.away * best.height_px
    width_px = best.shape * height_px
    known = _RECORDED_CROP_SD * width_px
    evidence = "an editor recorded what was cut"
    if best.turned:
        doubt = max(abs(away) / math.sqrt(2), known)
        return Frame(height_px, width_px, _RECORDED_CROP_SD, scale, crop=evidence, principal_sd_px=doubt)
    return Frame(
        width_px, height_px, _RECORDED_CROP_SD, scale, crop=evidence, principal_sd_px=known,
        principal_px=(width / 2 + away.real, height / 2 + away.imag),
    )  # fmt: skip


def _shape(width: int, height: int) -> str | None:
    """Return the sensor shape that a file has, or None."""
    aspect = max(width, height) / min(width, height)
    rounding = max(_SHAPE_TOLERANCE, 1.5 / min(width, height))
    near = (name for name, shape in _SENSOR_SHAPES.items() if abs(math.log(aspect / shape)) <= rounding)
    return next(near, None)
