"""Numbers, texts, dates and places from the values of metadata, whatever writers put there."""

from __future__ import annotations

import math
import re
from typing import Any

from .xmp_iptc import first


class Numbers:
    """Looks numbers up in EXIF, else in XMP, and remarks on those that make no sense."""

    def __init__(self, exif: dict[int, Any], xmp: dict[str, tuple[str, ...]], remarks: list[str]) -> None:
        self.exif, self.xmp, self.remarks = exif, xmp, remarks

    def number(self, tag: int, xmp_name: str) -> float | None:
        """Return the number, NaN for 0/0, None where it is absent or not a number."""
        value = self.exif.get(tag)
        return number_of(value if value is not None else first(self.xmp, xmp_name) or None)

    def within(self, what: str, tag: int, xmp_name: str, low: float, high: float) -> float | None:
        """Return the number, or None where it is absent, not a number, or outside [low, high]."""
        value = self.number(tag, xmp_name)
        if value is None or low <= value <= high:
            return value
        if value != 0 or what == "focal length":  # elsewhere 0 is the standard's own value for "unknown"
            shown = "0/0" if math.isnan(value) else f"{value:g}"
            self.remarks.append(f"{what} {shown} in the metadata is unusable")
        return None


def number_of(value: Any) -> float | None:
    """Return a number from an EXIF or XMP value: a rational, an integer, "425/10"; NaN for 0/0, None for no number."""
    if isinstance(value, tuple | list):
        value = value[0] if value else None
    if value is None or isinstance(value, bytes):
        return None
    if isinstance(value, str):
        match = re.fullmatch(r"\s*(-?\d+(?:\.\d+)?)\s*(?:/\s*(-?\d+))?\s*", value)
        if match is None:
            return None
        top, bottom = float(match[1]), float(match[2] or 1)
        return top / bottom if bottom else math.nan
    try:
        return float(value)  # pyright: ignore[reportArgumentType]
    except ZeroDivisionError:
        return math.nan
    except (TypeError, ValueError, OverflowError):
        return None


def text_of(*values: Any) -> str | None:
    """Return the first value that holds text, in one line without control characters."""
    for value in values:
        if isinstance(value, bytes):
            value = value.decode("utf-8", "replace")
        if isinstance(value, str):
            line = " ".join("".join(c if c.isprintable() else " " for c in value).split())
            if line:
                return line[:2000]
    return None


def date_of(*values: Any) -> str | None:
    """Return the first usable date as ISO 8601: "20180724" and "2018:07:24 11:22:45" become "2018-07-24...".

    What an editor wrote (IPTC, XMP) comes before the camera's: the EXIF date of a scan is the scanner's.
    """
    for value in values:
        text = text_of(value) or ""
        match = re.match(r"(\d{4})[:.-]?(\d\d)?[:.-]?(\d\d)?(?:[ T](\d\d:\d\d(?::\d\d)?))?", text)
        if match is None or match[1] == "0000":
            continue
        day = "-".join(part for part in match.group(1, 2, 3) if part and part != "00")
        return f"{day}T{match[4]}" if match[4] and len(day) == 10 else day
    return None


def position_of(gps: dict[int, Any]) -> tuple[float, float] | None:
    """Return latitude and longitude in degrees from the GPS directory."""
    degrees: list[float] = []
    for tag, limit in ((2, 90.0), (4, 180.0)):
        parts = gps.get(tag)
        if not isinstance(parts, tuple | list) or len(parts) != 3:
            return None
        numbers = [number_of(part) for part in parts]
        value = sum((n if n is not None else math.nan) / 60**i for i, n in enumerate(numbers))
        if not 0 <= value <= limit:
            return None
        sign = -1 if text_of(gps.get(tag - 1)) in ("S", "W") else 1
        degrees.append(sign * value)
    return degrees[0], degrees[1]
