"""The truth of a benchmark: three header-less CSV files, as the KORTE benchmark's authors publish them.

`body_pixel_locations.csv` has person,part,x,y,filename,width,height (pixels of the full-size photo),
`ground_truth_locations.csv` shoot,tag,x,y,z (millimetres; tags P* are people, C* cameras; y is up, 0 on the ground)
and `camera_locations_photoshoot_identifiers.csv` shoot,camera,filename (Seker et al. 2021, section 3.2). Two more may
lie next to them: `settings.csv` (shoot,setting with a header) names the shoots, and `focal_lengths_recovered.csv` or
`focal_lengths.csv` (a header with filename and focal_length_mm) gives each photo's lens; sensor_width_mm and
sensor_height_mm there are those of another sensor than KORTE's.
"""

from __future__ import annotations

import csv
import math
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from ..arrays import FloatArray
from ..errors import LabelsError
from ..files import csv_lines, read_text, reason_of
from ..people.skeleton import PARTS
from .errata import Erratum, load_errata

BODY_FILE = "body_pixel_locations.csv"
TRUTH_FILE = "ground_truth_locations.csv"
PHOTOS_FILE = "camera_locations_photoshoot_identifiers.csv"
SETTINGS_FILE = "settings.csv"
FOCAL_FILES = ("focal_lengths.csv", "focal_lengths_recovered.csv")

#: Both cameras of KORTE have this sensor (Seker et al. 2021, section 3.2); synthetic photos are made with it.
KORTE_SENSOR_MM = (36.0, 24.0)
#: The paper's names for KORTE's two shoots.
KORTE_SETTINGS = {"0": "outdoor", "1": "indoor"}


@dataclass(frozen=True)
class Mark:
    """One annotated point: whose, of which part, where in pixels, in the order of the file."""

    tag: str
    part: str
    x: float
    y: float


@dataclass(frozen=True, eq=False)
class LabelImage:
    """One photo's truth: P annotated people.

    marks: every annotated point in the file's order. tags: the people, in order of first mention. parts_px: shape
    (P, 4, 2) in the order of `skeleton.PARTS`, NaN where not annotated, the first where annotated twice. positions_mm:
    shape (P, 3). places_mm: tag -> position of every person in the shoot, seen here or not. focal_mm: NaN where no file
    gives it.
    """

    filename: str
    width: int
    height: int
    shoot: str
    camera: str
    setting: str
    focal_mm: float
    marks: tuple[Mark, ...]
    tags: tuple[str, ...]
    parts_px: FloatArray
    positions_mm: FloatArray
    places_mm: dict[str, tuple[float, float, float]]
    sensor_mm: tuple[float, float] = KORTE_SENSOR_MM

    def __len__(self) -> int:
        return len(self.tags)

    @property
    def n_pairs(self) -> int:
        """How many pairs of annotated people there are."""
        return len(self) * (len(self) - 1) // 2

    def distances_mm(self, ground: bool) -> FloatArray:
        """Shape (P, P): true distances, along the ground plane or in space."""
        places = self.positions_mm[:, [0, 2]] if ground else self.positions_mm
        return np.linalg.norm(places[:, None] - places[None], axis=-1)


@dataclass(frozen=True, eq=False)
class Labels:
    """All photos of a benchmark. errata: the corrections applied, empty for the labels as published."""

    images: tuple[LabelImage, ...]
    source: str
    errata: tuple[Erratum, ...] = ()
    by_name: dict[str, LabelImage] = field(init=False, repr=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "by_name", {image.filename: image for image in self.images})

    def __len__(self) -> int:
        return len(self.images)

    def __iter__(self) -> Iterator[LabelImage]:
        return iter(self.images)

    @property
    def description(self) -> str:
        """How results name these labels."""
        return f"with errata ({len(self.errata)} corrections)" if self.errata else "original"


def read_labels(folder: str | Path, errata: bool = True) -> Labels:
    """Read a labels folder; with `errata` the known mistakes of the published KORTE labels are corrected.

    Raises LabelsError naming file and line where the files cannot be used; `check_labels` lists every fault at once.
    """
    folder = Path(folder)
    truth = _read_truth(folder)
    photos = {row[2]: (row[0], row[1]) for _, row in _rows(folder / PHOTOS_FILE, 3)}
    marks: dict[str, list[Mark]] = {}
    sizes: dict[str, tuple[int, int]] = {}
    path = folder / BODY_FILE
    for line, row in _rows(path, 7):
        tag, part, x, y, filename, width, height = row
        where = f"{path}:{line}"
        if part not in PARTS:
            raise LabelsError(f"{where}: part {part!r} is unknown: use one of {', '.join(PARTS)}")
        marks.setdefault(filename, []).append(Mark(tag, part, _finite_number(x, where), _finite_number(y, where)))
        sizes[filename] = (_side(width, where), _side(height, where))
    if not marks:
        raise LabelsError(
            f"{path}: no person is annotated in it; rows of person,part,x,y,filename,width,height are expected"
        )
    corrections = _applicable(load_errata(), marks)
    applied = corrections if errata else ()
    names = _settings(folder, korte=bool(corrections))
    focal = _focal_lengths(folder)
    images: list[LabelImage] = []
    for filename, points in marks.items():
        if filename not in photos:
            raise LabelsError(f"{folder / PHOTOS_FILE}: no row for photo {filename}, which {BODY_FILE} annotates")
        shoot, camera = photos[filename]
        corrected = _corrected(points, [e for e in applied if e.filename == filename])
        setting = names.get(shoot, f"shoot {shoot}")
        people = _People(shoot, corrected, truth.get(shoot, {}))
        lens = focal.get(filename, (math.nan, KORTE_SENSOR_MM))
        images.append(_image(filename, sizes[filename], camera, setting, lens, people, folder))
    return Labels(tuple(images), str(folder), applied)


#: A focal length and the sensor that it goes with, millimetres.
_Lens = tuple[float, tuple[float, float]]


@dataclass(frozen=True)
class _People:
    """The files' content on the people of one photo: their points, and where every person of the shoot is."""

    shoot: str
    marks: tuple[Mark, ...]
    places_mm: dict[str, tuple[float, float, float]]


def _image(
    filename: str, size: tuple[int, int], camera: str, setting: str, lens: _Lens, people: _People, folder: Path
) -> LabelImage:
    shoot, marks, places = people.shoot, people.marks, people.places_mm
    tags = tuple(dict.fromkeys(mark.tag for mark in marks))
    for tag in tags:
        if tag not in places:
            raise LabelsError(
                f"{folder / TRUTH_FILE}: shoot {shoot} has no {tag}, who is annotated in {filename} ({BODY_FILE})"
            )
        if twin := next((other for other in tags if other != tag and places.get(other) == places[tag]), None):
            raise LabelsError(
                f"{folder / TRUTH_FILE}: {tag} and {twin} of shoot {shoot} stand at one place: no error is relative "
                "to a distance of 0"
            )
    parts = np.full((len(tags), len(PARTS), 2), np.nan)
    for mark in reversed(marks):  # of a point annotated twice the first stays
        parts[tags.index(mark.tag), PARTS.index(mark.part)] = mark.x, mark.y
    positions = np.array([places[tag] for tag in tags], dtype=float).reshape(-1, 3)
    focal_mm, sensor_mm = lens
    return LabelImage(
        filename, *size, shoot, camera, setting, focal_mm, marks, tags, parts, positions, places, sensor_mm
    )


def _applicable(errata: tuple[Erratum, ...], marks: dict[str, list[Mark]]) -> tuple[Erratum, ...]:
    """Return the errata whose wrong rows are there: labels already corrected, or of other photos, have none."""
    return tuple(e for e in errata if any(e.concerns(m.tag, m.part, m.x, m.y) for m in marks.get(e.filename, ())))


def _corrected(marks: list[Mark], errata: list[Erratum]) -> tuple[Mark, ...]:
    answer: list[Mark] = []
    for mark in marks:
        owner = next((e.belongs_to for e in errata if e.concerns(mark.tag, mark.part, mark.x, mark.y)), mark.tag)
        answer.append(Mark(owner, mark.part, mark.x, mark.y))
    return tuple(answer)


def _rows(path: Path, columns: int) -> Iterator[tuple[int, list[str]]]:
    """Yield (line number, fields) of a header-less CSV file."""
    try:
        rows = list(csv.reader(csv_lines(_text(path))))
    except csv.Error as error:
        raise LabelsError(f"{path}: cannot be read as CSV ({error})") from error
    for line, row in enumerate(rows, start=1):
        if not row:
            continue
        if len(row) != columns:
            raise LabelsError(f"{path}:{line}: {len(row)} columns where {columns} are expected")
        yield line, row


def _text(path: Path) -> str:
    try:
        return read_text(path)
    except FileNotFoundError as error:
        needed = f"a labels folder holds {BODY_FILE}, {TRUTH_FILE} and {PHOTOS_FILE}"
        raise LabelsError(f"{path}: no such file; {needed}") from error
    except (OSError, ValueError) as error:
        raise LabelsError(f"{path}: cannot be read as text ({reason_of(error)})") from error


def _finite_number(text: str, where: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = float("nan")
    if not math.isfinite(value):
        raise LabelsError(f"{where}: {text!r} where a number is expected")
    return value


def _side(text: str, where: str) -> int:
    """Return the width or height of a photo, pixels."""
    value = int(_finite_number(text, where))
    if value < 1:
        raise LabelsError(f"{where}: {text!r} where the photo's width or height is expected, in pixels")
    return value


def _read_truth(folder: Path) -> dict[str, dict[str, tuple[float, float, float]]]:
    """Return shoot -> tag -> position in millimetres, people only."""
    return {
        shoot: {tag: place for tag, place in places.items() if tag.startswith("P")}
        for shoot, places in read_places(folder).items()
    }


def read_places(folder: str | Path) -> dict[str, dict[str, tuple[float, float, float]]]:
    """Return shoot -> tag -> position in millimetres of people and cameras; raises LabelsError as `read_labels`."""
    folder = Path(folder)
    truth: dict[str, dict[str, tuple[float, float, float]]] = {}
    for line, (shoot, tag, *xyz) in _rows(folder / TRUTH_FILE, 5):
        where = f"{folder / TRUTH_FILE}:{line}"
        x, y, z = (_finite_number(value, where) for value in xyz)
        truth.setdefault(shoot, {})[tag] = (x, y, z)
    return truth


def _settings(folder: Path, korte: bool) -> dict[str, str]:
    path = folder / SETTINGS_FILE
    if not path.exists():
        return KORTE_SETTINGS if korte else {}
    return {row["shoot"]: row["setting"] for row in _table(path, ("shoot", "setting"))}


def _focal_lengths(folder: Path) -> dict[str, _Lens]:
    for path in (folder / name for name in FOCAL_FILES):
        if path.exists():
            return {row["filename"]: _lens(row, path) for row in _table(path, ("filename", "focal_length_mm"))}
    return {}


def _lens(row: dict[str, str], path: Path) -> _Lens:
    """Return the lens of a row; a sensor counts where both of its sides are there."""
    focal_mm = _finite_number(row["focal_length_mm"], str(path))
    if not focal_mm > 0:
        raise LabelsError(f"{path}: the focal length of {row['filename']} is {focal_mm:g} mm: it must be positive")
    sides = [row.get(name) or "" for name in ("sensor_width_mm", "sensor_height_mm")]
    if not all(sides):
        return focal_mm, KORTE_SENSOR_MM
    width, height = (_finite_number(side, str(path)) for side in sides)
    if not min(width, height) > 0:
        raise LabelsError(f"{path}: the sensor of {row['filename']} is {width:g} x {height:g} mm: it must be positive")
    return focal_mm, (width, height)


def _table(path: Path, columns: tuple[str, ...]) -> list[dict[str, str]]:
    try:
        rows = list(csv.DictReader(csv_lines(_text(path))))
    except csv.Error as error:
        raise LabelsError(f"{path}: cannot be read as CSV ({error})") from error
    for name in columns:
        if any(row.get(name) is None for row in rows):
            raise LabelsError(f"{path}: every row needs the columns {', '.join(columns)}")
    return rows
