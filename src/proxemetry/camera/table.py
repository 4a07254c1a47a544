"""The camera table: a researcher states once what is known of the cameras behind scanned or stripped photos.

A CSV file with a header. A row applies to the photos whose name matches `photo` (a glob) or whose metadata match
`make` and `model`; a row that gives both applies where both match. The most specific row wins.
"""

from __future__ import annotations

import csv
import math
import re
import unicodedata
from collections.abc import Iterable
from dataclasses import dataclass, fields
from fnmatch import fnmatchcase
from functools import lru_cache
from pathlib import Path

from ..errors import CameraError, SettingsError
from ..files import csv_lines, read_text
from .mount import STATED_ANGLE_SD_RAD, Mount

#: Brackets about one letter, which no glob needs: they are the name's own, as in a browser's photo[1].jpg.
_ONE_LETTER = re.compile(r"\[([^]*?[!])\]")
_KEYS = ("photo", "make", "model")
_PLACE = (("pitch_deg", "pitch_sd_deg"), ("roll_deg", "roll_sd_deg"), ("height_m", "height_sd_m"))

#: Bounds of a stated focal length or sensor side, millimetres or pixels: wider than any camera's, and squares and
#: ratios of them are ordinary numbers.
LENGTH_BOUNDS = (1e-3, 1e7)
#: So many rows are held against names before it is given up which of them apply to no photo: some seconds.
_MOST_TRIED = 300_000


@dataclass(frozen=True)
class CameraRow:
    """One row: which photos it applies to, and what it states of their camera; None where a cell is empty.

    Lengths named _mm are millimetres; focal_px, focal_y_px, cx_px, cy_px are pixels of the upright full-size photo;
    k1, k2, p1, p2, k3 are OpenCV's; pitch_deg, roll_deg (degrees, a positive pitch looks down) and height_m above the
    floor are where the camera is, each with its standard deviation or that of `Mount.stated`. line is the row's line in
    the file.
    """

    line: int
    photo: str | None = None
    make: str | None = None
    model: str | None = None
    focal_mm: float | None = None
    focal_35mm: float | None = None
    sensor_width_mm: float | None = None
    sensor_height_mm: float | None = None
    focal_px: float | None = None
    focal_y_px: float | None = None
    cx_px: float | None = None
    cy_px: float | None = None
    k1: float | None = None
    k2: float | None = None
    p1: float | None = None
    p2: float | None = None
    k3: float | None = None
    pitch_deg: float | None = None
    roll_deg: float | None = None
    height_m: float | None = None
    pitch_sd_deg: float | None = None
    roll_sd_deg: float | None = None
    height_sd_m: float | None = None

    def __post_init__(self) -> None:
        if not (self.photo or self.make or self.model):
            raise CameraError("the row names neither a photo nor a camera: fill photo, or make and model")
        for name in ("focal_mm", "focal_35mm", "sensor_width_mm", "sensor_height_mm", "focal_px", "focal_y_px"):
            value = getattr(self, name)
            low, high = LENGTH_BOUNDS
            if value is not None and not low <= value <= high:
                raise CameraError(f"{name} is {value:g}: it must be positive, {low:g} to {high:g}")
        stated = [name for name in ("focal_mm", "focal_35mm", "focal_px") if getattr(self, name) is not None]
        if len(stated) > 1:
            raise CameraError(f"{' and '.join(stated)} state the focal length twice: leave one empty")
        if self.sensor_height_mm is not None and self.sensor_width_mm is None:
            raise CameraError("sensor_height_mm is given without sensor_width_mm")
        if self.focal_y_px is not None and self.focal_px is None:
            raise CameraError("focal_y_px is given without focal_px")
        if (self.cx_px is None) != (self.cy_px is None):
            raise CameraError("cx_px and cy_px belong together: give both or none")
        for name, sd_name in _PLACE:
            if getattr(self, sd_name) is not None and getattr(self, name) is None:
                raise CameraError(f"{sd_name} is given without {name}")
            if (getattr(self, sd_name) or 0.0) < 0:
                raise CameraError(f"{sd_name} is {getattr(self, sd_name):g}: a standard deviation is 0 or more")
        _ = self.mount  # raises for what it cannot be

    @property
    def distortion(self) -> tuple[float, float, float, float, float] | None:
        """OpenCV's k1, k2, p1, p2, k3, empty cells being 0; None where the row has none of them."""
        if all(value is None for value in (self.k1, self.k2, self.p1, self.p2, self.k3)):
            return None
        return (self.k1 or 0.0, self.k2 or 0.0, self.p1 or 0.0, self.p2 or 0.0, self.k3 or 0.0)

    @property
    def mount(self) -> Mount | None:
        """Where the camera is, or None where the row does not state it."""
        if self.pitch_deg is None and self.roll_deg is None and self.height_m is None:
            return None
        return Mount.stated(
            _radians(self.pitch_deg), _radians(self.roll_deg), math.nan if self.height_m is None else self.height_m,
            pitch_sd_rad=_radians(self.pitch_sd_deg, STATED_ANGLE_SD_RAD),
            roll_sd_rad=_radians(self.roll_sd_deg, STATED_ANGLE_SD_RAD), height_sd_m=self.height_sd_m,
            source=f"camera table line {self.line}",
        )  # fmt: skip

    def applies(self, name: str, make: str | None, model: str | None) -> bool:
        """Return whether the row applies to a photo of that name from a camera of that make and model."""
        return self.names(name) and all(
            not wanted or _matches(wanted, had or "") for wanted, had in ((self.make, make), (self.model, model))
        )

    def names(self, name: str) -> bool:
        """Return whether the row applies to a photo of that name, whatever camera it is from."""
        path = name.replace("\\", "/")
        return not self.photo or any(_matches(self.photo, p) for p in (path, path.rpartition("/")[2]))

    @property
    def specificity(self) -> tuple[bool, int, int]:
        """A larger one wins: a name written out, then the more letters of it (but for its ending), then the camera."""
        pattern = self.photo or ""
        stem = pattern.rpartition(".")[0] or pattern
        wild = any(c in pattern for c in "*?[")
        letters = sum(c not in "*?[]" for c in stem)
        return bool(pattern) and not wild, letters, bool(self.make) + 2 * bool(self.model)


def _radians(degrees: float | None, default: float = math.nan) -> float:
    return default if degrees is None else math.radians(degrees)


def _matches(pattern: str, text: str) -> bool:
    """Return whether a glob fits; a name that is written out fits itself, brackets in it or not: photo[1].jpg."""
    name, wanted = _folded(text), _folded(pattern.replace("\\", "/"))
    return name == wanted or fnmatchcase(name, _as_glob(wanted))


@lru_cache(4096)
def _as_glob(pattern: str) -> str:
    return _ONE_LETTER.sub(r"[[]\1]", pattern)


@lru_cache(4096)
def _folded(text: str) -> str:
    """Return a name as it is compared: a Mac writes an umlaut as two signs where a spreadsheet writes one."""
    return unicodedata.normalize("NFC", text.strip().casefold())


@dataclass(frozen=True)
class CameraTable:
    """All rows of a camera table, in the order of the file. source: the file, as errors and results name it."""

    rows: tuple[CameraRow, ...]
    source: str = "camera table"

    @classmethod
    def read(cls, path: str | Path) -> CameraTable:
        """Read a CSV file, commas or semicolons; raises SettingsError or CameraError with the line that is wrong."""
        path = Path(path)
        try:
            text = read_text(path)
        except OSError as error:
            raise SettingsError(f"--camera-table {path}: cannot be read ({error.strerror})") from error
        except ValueError as error:
            raise SettingsError(f"--camera-table {path}: not UTF-8 text; save it as CSV UTF-8") from error
        lines = csv_lines(text)
        header = next((line for line in lines if line.strip()), "")
        semicolons = header.count(";") > header.count(",")
        reader = csv.DictReader(lines, delimiter=";" if semicolons else ",", skipinitialspace=True)
        columns = [(name or "").strip() for name in reader.fieldnames or ()]
        known = {f.name for f in fields(CameraRow)} - {"line"}
        unknown = [name for name in columns if name and name not in known]
        if unknown or not set(_KEYS) & set(columns):
            what = f"column {unknown[0]!r} is unknown" if unknown else "there is no column photo, make or model"
            raise CameraError(f"{path}: {what}; columns are {', '.join(f.name for f in fields(CameraRow)[1:])}")
        rows: list[CameraRow] = []
        for record in reader:
            cells = {(k or "").strip(): v.strip() for k, v in record.items() if isinstance(v, str) and v.strip()}
            if not cells:
                continue
            try:
                if None in record:  # what DictReader calls the cells beyond the header's
                    raise CameraError("there are more cells than columns")
                rows.append(_row(reader.line_num, cells, decimal_comma=semicolons))
            except CameraError as error:
                raise CameraError(f"{path}, line {reader.line_num}: {error}") from error
        if not rows:
            raise CameraError(f"{path}: the camera table has no rows")
        return cls(tuple(rows), path.name)

    def unused(self, names: Iterable[str]) -> tuple[CameraRow, ...] | None:
        """Return the rows that name photos of which none is among these, None where it would take too long to know."""
        left, tried = [row for row in self.rows if row.photo], 0
        for name in names:
            if not left:
                break
            tried += len(left)
            if tried > _MOST_TRIED:
                return None
            left = [row for row in left if not row.names(name)]
        return tuple(left)

    def row_for(self, name: str, make: str | None = None, model: str | None = None) -> CameraRow | None:
        """Return the most specific row that applies, the first of several alike, or None."""
        applying = [row for row in self.rows if row.applies(name, make, model)]
        return max(applying, key=lambda row: row.specificity, default=None)


def _row(line: int, cells: dict[str, str], *, decimal_comma: bool) -> CameraRow:
    values: dict[str, float] = {}
    for name, text in cells.items():
        if name in _KEYS or not name:
            continue
        try:
            values[name] = float(text.replace(",", ".") if decimal_comma else text)
        except ValueError:
            raise CameraError(f"{name} is {text!r}: it must be a number") from None
        if not math.isfinite(values[name]):
            raise CameraError(f"{name} is {text!r}: it must be a finite number")
    return CameraRow(line, cells.get("photo"), cells.get("make"), cells.get("model"), **values)
