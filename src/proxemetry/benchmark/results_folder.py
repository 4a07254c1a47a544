"""Predictions from the results folder of a run: `photos.csv`, `people.csv` and `pairs.csv`, metres to millimetres."""

from __future__ import annotations

import csv
from collections import defaultdict
from collections.abc import Mapping
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ..errors import LabelsError
from ..skeleton import PARTS
from .predictions import Prediction, Predictions

FloatArray = NDArray[np.float64]
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
    images = [
        _image(row, people.get(row["photo"], []), pairs.get(row["photo"], []), folder)
        for row in _read(folder, "photos")
    ]
    return Predictions(tuple(images), str(folder))


def _read(folder: Path, name: str) -> list[dict[str, str]]:
    path = folder / f"{name}.csv"
    try:
        with path.open(newline="", encoding="utf-8-sig") as file:
            reader = csv.DictReader(file)
            rows = list(reader)
    except FileNotFoundError as error:
        raise LabelsError(f"{path}: no such file; a results folder has photos.csv, people.csv and pairs.csv") from error
    missing = [column for column in _COLUMNS[name] if column not in (reader.fieldnames or ())]
    if missing:
        raise LabelsError(f"{path}: column {missing[0]} is missing")
    return rows


def _by_photo(rows: list[dict[str, str]]) -> dict[str, list[dict[str, str]]]:
    answer: dict[str, list[dict[str, str]]] = defaultdict(list)
    for row in rows:
        answer[row["photo"]].append(row)
    return answer


def _image(photo: Row, people: list[dict[str, str]], pairs: list[dict[str, str]], folder: Path) -> Prediction:
    name = photo["photo"]
    people = sorted(people, key=lambda row: int(row["person"]))
    index = {row["person"]: k for k, row in enumerate(people)}
    count = len(people)
    points, positions = np.full((count, len(PARTS), 2), np.nan), np.full((count, 3), np.nan)
    for k, row in enumerate(people):
        where = f"{folder / 'people.csv'}: photo {name}, person {row['person']}"
        for p, part in enumerate(PARTS):
            points[k, p] = [_number(row, f"{part.lower()}_{axis}_px", where) for axis in "uv"]
        positions[k] = [_number(row, f"{axis}_m", where) * _MM for axis in "xyz"]
    distances, low, high = (np.full((count, count), np.nan) for _ in range(3))
    on_ground = False
    for row in pairs:
        where = f"{folder / 'pairs.csv'}: photo {name}"
        try:
            a, b = index[row["person_a"]], index[row["person_b"]]
        except KeyError as error:
            raise LabelsError(f"{where}: person {error} is not in people.csv") from error
        for matrix, column in ((distances, "distance_m"), (low, "low_m"), (high, "high_m")):
            matrix[a, b] = matrix[b, a] = _number(row, column, where) * _MM
        on_ground |= row.get("on_ground", "true").lower() in ("true", "1", "t")
    width, height = (_number(photo, key, f"{folder / 'photos.csv'}: photo {name}") for key in ("width_px", "height_px"))
    known = width > 0 and height > 0  # a photo that could not be read has no size
    return Prediction(
        name, width if known else None, height if known else None, points, positions,
        distances if on_ground else None, low, high,
    )  # fmt: skip


def _number(row: Row, column: str, where: str) -> float:
    text = row[column].strip()
    if not text:
        return float("nan")
    try:
        return float(text)
    except ValueError as error:
        raise LabelsError(f"{where}: {column} is {text!r} where a number is expected") from error
