"""The whole picture that a file is a part or a copy of: resized files, crops, and how far they can be told apart."""

from __future__ import annotations

import math
from dataclasses import dataclass

from .metadata import Metadata

#: Shapes of sensors, long side to short. 16:9 and 1:1 are mostly crops made by the camera, centred.
_SENSOR_SHAPES = {"3:2": 1.5, "4:3": 4 / 3, "16:9": 16 / 9, "1:1": 1.0}
_SHAPE_TOLERANCE = 0.015
#: Relative sd of a diagonal that may belong to a larger sensor: 16:9 out of 4:3 loses 8 % of it, 1:1 out of 3:2 27 %.
_CAMERA_CROP_SD = {"16:9": 0.04, "1:1": 0.12}
#: The same for an editor's crop of unknown extent, and the spread of its centre as a part of the long side.
_EDITOR_CROP_SD = 0.2
_EDITOR_CROP_SHIFT = 0.1
#: The central 90 % of a normal distribution ends this many standard deviations out.
SD_OF_90 = 1.645


@dataclass(frozen=True)
class Frame:
    """The uncropped picture, measured in pixels of the upright file.

    width_px, height_px: its size; the file's own where it is not known to be a crop. size_rel_sd: the relative
    standard deviation of that size. scale: pixels of the file for one pixel as first stored, with scale_rel_sd.
    crop: the evidence that the file is a crop, or None. principal_sd_px: how far the principal point may be from the
    middle of the file, as a standard deviation per axis in pixels.
    """

    width_px: float
    height_px: float
    size_rel_sd: float = 0.0
    scale: float = 1.0
    scale_rel_sd: float = 0.0
    crop: str | None = None
    principal_sd_px: float = 0.0

    @property
    def diagonal_px(self) -> float:
        """The diagonal of the uncropped picture in pixels of the file."""
        return math.hypot(self.width_px, self.height_px)


def frame_of(width: int, height: int, metadata: Metadata) -> Frame:
    """Return the uncropped picture behind a file of `width` x `height` upright pixels (METHOD section 7.2)."""
    stored = _stored(width, height, metadata)
    if stored is not None and not _same_shape((width, height), stored):
        return _crop_of(width, height, stored)
    scale = 1.0 if stored is None else max(width, height) / max(stored)  # exactly 1 where nothing was resized
    shape = _shape(width, height)
    if metadata.cropped or shape is None:
        evidence = "an editor's crop is recorded" if metadata.cropped else "its shape is no sensor's"
        shift = _EDITOR_CROP_SHIFT * max(width, height)
        return Frame(width, height, _EDITOR_CROP_SD, scale, crop=evidence, principal_sd_px=shift)
    return Frame(width, height, _CAMERA_CROP_SD.get(shape, 0.0), scale)


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
    scale_sd = math.log(scale / smallest) / SD_OF_90
    full = (stored[0] * scale, stored[1] * scale)
    room = math.hypot(full[0] - width, full[1] - height) / math.sqrt(2)
    return Frame(
        *full, size_rel_sd=scale_sd, scale=scale, scale_rel_sd=scale_sd,
        crop=f"stored as {stored[0]} x {stored[1]}", principal_sd_px=room / math.sqrt(12),
    )  # fmt: skip


def _shape(width: int, height: int) -> str | None:
    """Return the sensor shape that a file has, or None."""
    aspect = max(width, height) / min(width, height)
    rounding = max(_SHAPE_TOLERANCE, 1.5 / min(width, height))
    near = (name for name, shape in _SENSOR_SHAPES.items() if abs(math.log(aspect / shape)) <= rounding)
    return next(near, None)
