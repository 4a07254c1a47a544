"""The fields of a mount's JSON form, each read strictly: what is not a number is an error, not a zero."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, cast

from ..errors import CameraError
from .camera import NO_DISTORTION, Camera
from .floor_frame import FloorFrame
from .sources import Source

#: Significant digits of what is written: more than is ever measured, and few enough to survive degrees and radians.
_DIGITS = 12


def significant(value: float) -> float | None:
    """Return a number for JSON, None for NaN."""
    return float(f"{value:.{_DIGITS}g}") if math.isfinite(value) else None


def finite(fields: Mapping[str, Any], name: str) -> float | None:
    """Return a number, None where it is left out; raises CameraError for anything else."""
    value = fields.get(name)
    if value is None:
        return None
    if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
        raise CameraError(f"{name} is {value!r:.40}: it must be a finite number, or left out where it is unknown")
    return float(value)


def nan_if_unknown(value: float | None) -> float:
    """Return a number, NaN where it is left out."""
    return math.nan if value is None else value


def radians(degrees: float | None, default: float = math.nan) -> float:
    """Return an angle in radians, the default where it is left out."""
    return default if degrees is None else math.radians(degrees)


def size_of(fields: Mapping[str, Any]) -> tuple[int, int] | None:
    """Return width and height in pixels, None where they are left out; raises CameraError for half of them."""
    width, height = finite(fields, "width_px"), finite(fields, "height_px")
    if width is None and height is None:
        return None
    if width is None or height is None or min(width, height) < 1 or width != int(width) or height != int(height):
        raise CameraError(f"width_px is {width!r} and height_px is {height!r}: they must be two whole numbers, or none")
    return int(width), int(height)


def camera_of(fields: Any) -> Camera | None:
    """Return the intrinsics, None where they are left out; raises CameraError for what is no camera."""
    if fields is None:
        return None
    try:
        named = dict(fields)
        named["distortion"] = tuple(named.get("distortion") or NO_DISTORTION)
        if isinstance(named.get("source"), Mapping):
            named["source"] = Source.from_dict(named["source"])
        return Camera(**named)
    except (KeyError, TypeError, ValueError) as error:
        raise CameraError(f"camera: {error}") from error


def floor_frame_of(fields: Any) -> FloorFrame | None:
    """Return the user's floor coordinates, None where they are left out; raises CameraError for anything else."""
    if fields is None:
        return None
    if not isinstance(fields, Mapping):
        raise CameraError("floor_frame: it must be an object of x_m, y_m, yaw_deg and mirrored")
    named = cast("Mapping[str, Any]", fields)
    x, y, yaw = (finite(named, name) or 0.0 for name in ("x_m", "y_m", "yaw_deg"))
    return FloorFrame(x, y, math.radians(yaw), bool(named.get("mirrored", False)))
