"""The prediction file, in which any method can write its answers as JSON.

    {"images": [{"filename": "IMG_1.JPG", "width": 4160, "height": 2768,
                 "people": [{"position_mm": [x, y, z], "points": {"Shoulder": [u, v], "Torso": [u, v]}}],
                 "up": [x, y, z], "distances_mm": [[i, j, d], ...], "intervals_mm": [[i, j, low, high], ...]}]}

`points` holds at least one of Eyes, Shoulder, Torso and Head in pixels of an image of `width` x `height`. An image
carries positions, or distances between people counted from 0, or both; `up` is against gravity in the positions'
frame; intervals enclose 90 %. Null is missing.
"""

from __future__ import annotations

import difflib
import json
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any, cast

import numpy as np

from ..arrays import FloatArray
from ..errors import LabelsError, OutputError
from ..files import is_file, read_json, reason_of
from ..people.skeleton import PARTS
from .predictions import Prediction, Predictions

_IMAGE_KEYS = ("filename", "width", "height", "people", "distances_mm", "intervals_mm", "up")
_PERSON_KEYS = ("position_mm", "points")
#: From here on two keys are taken for one and its slip of the pen: position_m, Position_mm, distance_mm, interval_mm.
_ALIKE = 0.85
#: What JSON calls the kinds of values that are read.
_KINDS = {list: "a list", str: "text", dict: "an object"}
#: Ten times the distance of the sun: what lies beyond is no length, and overflows.
_LONGEST_MM = 1e15


def read_prediction_file(path: Path) -> Predictions:
    """Read a prediction file; raises LabelsError saying what is wrong and where."""
    try:
        content = read_json(path)
    except FileNotFoundError as error:
        raise LabelsError(f"{path}: no such prediction file or results folder") from error
    except (OSError, ValueError) as error:
        hint = f"; the results folder is {path.parent}" if is_file(path.with_name("photos.csv")) else ""
        raise LabelsError(
            f"{path}: not a JSON prediction file ({reason_of(error)}); predictions are one, or a results folder, and "
            f"no table{hint}"
        ) from error
    images = _field(content, "images", list, str(path))
    return Predictions(tuple(_image(image, f"{path}: image {k}") for k, image in enumerate(images)), str(path))


def _image(content: Any, where: str) -> Prediction:
    filename = _field(content, "filename", str, where)
    where = f"{where} ({filename})"
    if not filename:
        raise LabelsError(f"{where}: 'filename' is empty: name the photo")
    _check_keys(content, _IMAGE_KEYS, where)
    people = _field(content, "people", list, where)
    count = len(people)
    points, positions = np.full((count, len(PARTS), 2), np.nan), np.full((count, 3), np.nan)
    for k, person in enumerate(people):
        here = f"{where}, person {k}"
        for part, point in _field(person, "points", dict, here, {}).items():
            if part not in PARTS:
                raise LabelsError(f"{here}: part {part!r} is unknown: use some of {', '.join(PARTS)}")
            points[k, PARTS.index(part)] = _vector(point, 2, f"{here}, {part}")
        _check_keys(person, _PERSON_KEYS, here)
        positions[k] = _vector(person.get("position_mm"), 3, f"{here}, position_mm")
    distances = None
    if content.get("distances_mm") is not None:
        (distances,) = _pairs(_field(content, "distances_mm", list, where), count, 1, f"{where}, distances_mm")
    low, high = _pairs(_field(content, "intervals_mm", list, where, []), count, 2, f"{where}, intervals_mm")
    up = None
    if content.get("up") is not None:
        up = _vector(content["up"], 3, f"{where}, up")
        if not np.linalg.norm(up) > 0:
            raise LabelsError(f"{where}: up has no direction: give a vector against gravity or leave it out")
        up = up / np.linalg.norm(up)
    width, height = (_size(content, key, where) for key in ("width", "height"))
    if (width is None) != (height is None):
        raise LabelsError(f"{where}: width and height go together: give both, or neither for the photo's own size")
    return Prediction(filename, width, height, points, positions, distances, low, high, up)


def _check_keys(content: Mapping[str, Any], known: tuple[str, ...], where: str) -> None:
    """Refuse a misspelled key, which would be passed over in silence; what is quite another is its writer's own."""
    for key in content:
        meant = [] if key in known else difflib.get_close_matches(key, known, n=1, cutoff=_ALIKE)
        if meant:
            raise LabelsError(f"{where}: {key!r} is unknown: {meant[0]!r} is the key")


def _field(content: Any, key: str, kind: type, where: str, default: Any = None) -> Any:
    if not isinstance(content, Mapping):
        raise LabelsError(f"{where}: an object with {key!r} is expected")
    value = cast("Mapping[str, Any]", content).get(key)
    value = default if value is None else value
    if value is None:
        raise LabelsError(f"{where}: {key!r} is missing")
    if not isinstance(value, kind):
        raise LabelsError(f"{where}: {key!r} must be {_KINDS[kind]}, not {json.dumps(value)[:40]}")
    return value


def _size(content: Any, key: str, where: str) -> float | None:
    value = content.get(key)
    if value is None:
        return None
    if not _is_number(value) or value <= 0:
        raise LabelsError(f"{where}: {key} must be a positive number of pixels, not {json.dumps(value)[:40]}")
    return float(value)


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and abs(value) <= _LONGEST_MM


def _vector(value: Any, length: int, where: str) -> FloatArray:
    """Return a list of numbers; NaN for a null, or for a list with nulls in it."""
    if value is None:
        return np.full(length, np.nan)
    if not isinstance(value, list) or len(value) != length:  # pyright: ignore[reportUnknownArgumentType]
        raise LabelsError(f"{where}: {length} numbers are expected, not {json.dumps(value)[:40]}")
    items = cast("list[Any]", value)
    if not all(item is None or _is_number(item) for item in items):
        problem = f"{length} numbers are expected, not {json.dumps(value)[:40]}; null is missing"
        raise LabelsError(f"{where}: {problem}")
    if any(item is None for item in items):
        return np.full(length, np.nan)
    return np.array(items, dtype=float)


def _pairs(rows: Any, count: int, values: int, where: str) -> list[FloatArray]:
    """Return symmetric matrices (count, count) from rows [i, j, value...]."""
    matrices = [np.full((count, count), np.nan) for _ in range(values)]
    seen: set[tuple[int, int]] = set()
    for k, row in enumerate(rows):
        if not isinstance(row, list) or len(cast("list[Any]", row)) != 2 + values:
            raise LabelsError(f"{where}, row {k}: {2 + values} numbers are expected, not {json.dumps(row)[:40]}")
        i, j, *numbers = cast("list[Any]", row)
        if not all(type(n) is int and 0 <= n < count for n in (i, j)) or i == j:
            raise LabelsError(f"{where}, row {k}: two different people from 0 to {count - 1} are expected")
        if (min(i, j), max(i, j)) in seen:
            raise LabelsError(f"{where}, row {k}: people {i} and {j} have a row already")
        seen.add((min(i, j), max(i, j)))
        lengths = _vector(numbers, values, f"{where}, row {k}")
        if (lengths < 0).any() or (np.diff(lengths) < 0).any():
            raise LabelsError(f"{where}, row {k}: a distance is negative, or an interval's low end above its high end")
        for matrix, number in zip(matrices, lengths, strict=True):
            matrix[i, j] = matrix[j, i] = number
    return matrices


def write_predictions(path: str | Path, images: Iterable[Prediction]) -> None:
    """Write a prediction file that `read_predictions` reads; raises OutputError where it cannot be written."""
    text = json.dumps({"images": [_to_dict(image) for image in images]}, allow_nan=False)
    try:
        Path(path).write_text(text + "\n", encoding="utf-8")
    except OSError as error:
        raise OutputError(f"{path}: cannot be written ({error})") from error


def _to_dict(image: Prediction) -> dict[str, Any]:
    people: list[dict[str, Any]] = []
    for points, position in zip(image.points_px, image.positions_mm, strict=True):
        given = {p: [float(v) for v in uv] for p, uv in zip(PARTS, points, strict=True) if np.isfinite(uv).all()}
        placed = [float(v) for v in position] if np.isfinite(position).all() else None
        people.append({"position_mm": placed, "points": given})
    content: dict[str, Any] = {"filename": image.filename, "people": people}
    content |= {k: v for k, v in (("width", image.width), ("height", image.height)) if v is not None}
    if image.up is not None:
        content["up"] = [float(v) for v in image.up]
    if image.distances_mm is not None:
        content["distances_mm"] = _rows([image.distances_mm])
    intervals = _rows([image.low_mm, image.high_mm])
    return content | ({"intervals_mm": intervals} if intervals else {})


def _rows(matrices: list[FloatArray]) -> list[list[float]]:
    count = len(matrices[0])
    pairs = [(i, j) for i in range(count) for j in range(i + 1, count)]
    return [
        [i, j, *(float(m[i, j]) for m in matrices)] for i, j in pairs if all(np.isfinite(m[i, j]) for m in matrices)
    ]
