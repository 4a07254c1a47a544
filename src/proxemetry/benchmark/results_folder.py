"""Predictions from the results folder of a run: `photos.csv`, `people.csv` and `pairs.csv`, metres to millimetres."""

from __future__ import annotations

import csv
import math
from collections import defaultdict
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from ..errors import LabelsError
from ..files import csv_lines, read_text, reason_of, text_of
from ..people.skeleton import PARTS
from .predictions import Prediction, Predictions

Row = Mapping[str, str]

_COLUMNS = {
    "photos": ("photo", "width_px", "height_px"),
    "people": ("photo", "person", "x_m", "y_m", "z_m", *(f"{p.lower()}_{a}_px" for p in PARTS for a in "uv")),
    "pairs": ("photo", "person_a", "person_b", "distance_m", "low_m", "high_m"),
}
_MM = 1000.0


def read_results_folder(folder: Path) -> Predictions:
    """Read the tables of a results folder; raises LabelsError where one is missing or malformed.

    A distance counts as one along the ground where the run knew gravity (`on_ground`); where it did not, positions
    alone are handed on and the camera's own up holds, as for any other method.
    """
    people, pairs = (_by_photo(_read(folder, name)) for name in ("people", "pairs"))
    photos = _read(folder, "photos")
    known = {row["photo"] for row in photos}
    for name, rows in (("people", people), ("pairs", pairs)):
        if strangers := [photo for photo in rows if photo not in known]:
            raise LabelsError(f"{folder / f'{name}.csv'}: photo {strangers[0]} is not in photos.csv")
    images = [_image(row, people.get(row["photo"], []), pairs.get(row["photo"], []), folder) for row in photos]
    return Predictions(tuple(images), str(folder))


def _read(folder: Path, name: str) -> list[dict[str, str]]:
    path = folder / f"{name}.csv"
    try:
        reader = csv.DictReader(csv_lines(read_text(path)))
        columns, rows = list(reader.fieldnames or ()), list(reader)
    except FileNotFoundError as error:
        raise LabelsError(f"{path}: no such file; a results folder has photos.csv, people.csv and pairs.csv") from error
    except (OSError, ValueError, csv.Error) as error:
        raise LabelsError(f"{path}: cannot be read as UTF-8 text ({reason_of(error)})") from error
    missing = [column for column in _COLUMNS[name] if column not in columns]
    if missing:
        hint = (
            "; commas are expected between columns, not semicolons" if any(";" in column for column in columns) else ""
        )
        raise LabelsError(f"{path}: column {missing[0]} is missing{hint}")
    for line, row in enumerate(rows, start=2):
        row["photo"] = text_of(row["photo"] or "")
        if any(row[column] is None for column in _COLUMNS[name]):
            raise LabelsError(f"{path}: row {line - 1} ends early: {len(columns)} columns are expected")
    return rows


def _by_photo(rows: list[dict[str, str]]) -> dict[str, list[dict[str, str]]]:
    answer: dict[str, list[dict[str, str]]] = defaultdict(list)
    for row in rows:
        answer[row["photo"]].append(row)
    return answer


def _image(photo: Row, people: list[dict[str, str]], pairs: list[dict[str, str]], folder: Path) -> Prediction:
    name = photo["photo"]
    where = f"{folder / 'people.csv'}: photo {name}"
    by_number = {_whole(row, "person", where): row for row in people}
    if len(by_number) < len(people):
        raise LabelsError(f"{where}: a person is listed twice")
    index = {number: k for k, number in enumerate(sorted(by_number))}
    count = len(people)
    points, positions = np.full((count, len(PARTS), 2), np.nan), np.full((count, 3), np.nan)
    for number, k in index.items():
        here, row = f"{where}, person {number}", by_number[number]
        for p, part in enumerate(PARTS):
            points[k, p] = [_finite_or_nan(row, f"{part.lower()}_{axis}_px", here) for axis in "uv"]
        positions[k] = [_finite_or_nan(row, f"{axis}_m", here) * _MM for axis in "xyz"]
    distances, low, high = (np.full((count, count), np.nan) for _ in range(3))
    on_ground = False
    seen: set[tuple[int, int]] = set()
    for row in pairs:
        where = f"{folder / 'pairs.csv'}: photo {name}"
        one, other = sorted(_whole(row, column, where) for column in ("person_a", "person_b"))
        if unknown := [number for number in (one, other) if number not in index]:
            raise LabelsError(f"{where}: person {unknown[0]} is not in people.csv")
        if one == other or (one, other) in seen:
            raise LabelsError(f"{where}: pair {one}-{other} {'is not a pair' if one == other else 'is listed twice'}")
        seen.add((one, other))
        a, b = index[one], index[other]
        for matrix, column in ((distances, "distance_m"), (low, "low_m"), (high, "high_m")):
            matrix[a, b] = matrix[b, a] = _finite_or_nan(row, column, where) * _MM
        if min(distances[a, b], low[a, b]) < 0 or low[a, b] > high[a, b]:
            raise LabelsError(f"{where}, pair {one}-{other}: a length is negative, or low_m above high_m")
        on_ground |= row.get("on_ground", "true").lower() in ("true", "1", "t")
    width, height = (
        _finite_or_nan(photo, key, f"{folder / 'photos.csv'}: photo {name}") for key in ("width_px", "height_px")
    )
    known = width > 0 and height > 0  # a photo that could not be read has no size
    return Prediction(
        name, width if known else None, height if known else None, points, positions,
        distances if on_ground else None, low, high,
    )  # fmt: skip


def _finite_or_nan(row: Row, column: str, where: str) -> float:
    text = row[column].strip()
    if not text:
        return math.nan
    try:
        value = float(text)
    except ValueError:
        value = math.inf
    if math.isinf(value):
        raise LabelsError(f"{where}: {column} is {text!r} where a number is expected")
    return value


def _whole(row: Row, column: str, where: str) -> int:
    """Return a whole number, also where another program has written it as 3.0."""
    value = _finite_or_nan(row, column, where)
    if not value.is_integer():
        raise LabelsError(f"{where}: {column} is {row[column]!r} where a whole number is expected")
    return int(value)
