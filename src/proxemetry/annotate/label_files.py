"""The benchmark's label files from annotations: the three, and those that name shoots and lenses beside them."""

from __future__ import annotations

import csv
import glob
import io
from collections.abc import Iterable, Sequence

from ..benchmark.labels import BODY_FILE, FOCAL_FILES, PHOTOS_FILE, SETTINGS_FILE, TRUTH_FILE
from ..camera.table import CameraRow
from ..people.skeleton import PARTS
from .keypoint_file import COCO_FILE, coco_file
from .lens import for_shape
from .photos import OwnPhoto
from .places import Places
from .state import Annotations, PhotoNotes, in_order

#: What the annotator states of lenses, in the form of `--camera-table`.
CAMERA_TABLE = "camera_table.csv"
FOCAL_FILE = FOCAL_FILES[0]
_MM = 1000.0


def label_files(now: Annotations, photos: Sequence[OwnPhoto], places: dict[int, Places]) -> dict[str, bytes | None]:
    """Return name -> content of every file; None of one that has nothing to hold.

    places: shoot -> where its marks are. What is not finished is in the files as far as it goes; `check_labels` says
    what is missing.
    """
    counted = [(photo, now.photo(photo.sha256)) for photo in photos]
    counted = [(photo, notes) for photo, notes in counted if notes.named and not notes.skipped]
    shoots = sorted({*(notes.shoot for _, notes in counted), *(n for n, p in places.items() if p.by_tag)})
    names = {number: now.shoot(number).name for number in shoots}
    table = _camera_table(counted)
    return {
        BODY_FILE: _csv(row for photo, notes in counted for row in _points(photo, notes)),
        TRUTH_FILE: _csv(row for number in shoots if number in places for row in _truth(number, places[number])),
        PHOTOS_FILE: _csv((notes.shoot, notes.camera, photo.name) for photo, notes in counted),
        SETTINGS_FILE: _csv([("shoot", "setting"), *((n, name or f"shoot {n}") for n, name in names.items())])
        if any(names.values())
        else None,
        FOCAL_FILE: _focal_lengths(counted),
        CAMERA_TABLE: table,
        COCO_FILE: coco_file(now, photos),
    }


def _csv(rows: Iterable[Sequence[object]]) -> bytes:
    text = io.StringIO()
    csv.writer(text, lineterminator="\n").writerows(rows)
    return text.getvalue().encode()


def _points(photo: OwnPhoto, notes: PhotoNotes) -> Iterable[Sequence[object]]:
    for person in notes.named:
        for part in PARTS:
            if part in person.points:
                yield (person.tag, part, *person.points[part], photo.name, photo.width, photo.height)


def _truth(shoot: int, places: Places) -> Iterable[Sequence[object]]:
    """Yield shoot,tag,x,y,z in whole millimetres; the floor is y = 0, as in KORTE's own files."""
    for tag in in_order(places.by_tag):
        x_m, y_m = places.by_tag[tag]
        yield shoot, tag, round(x_m * _MM), 0, round(y_m * _MM)


def _focal_lengths(counted: list[tuple[OwnPhoto, PhotoNotes]]) -> bytes | None:
    rows: list[Sequence[object]] = []
    for photo, notes in counted:
        lens = photo.lens if notes.lens is None else for_shape(notes.lens, photo.width, photo.height)
        if lens is not None:
            rows.append((photo.name, f"{lens.focal_mm:g}", *(f"{side:g}" for side in lens.sensor_mm)))
    head = ("filename", "focal_length_mm", "sensor_width_mm", "sensor_height_mm")
    return _csv([head, *rows]) if rows else None


def stated_rows(counted: Iterable[tuple[OwnPhoto, PhotoNotes]]) -> list[CameraRow]:
    """Return the rows of a camera table for the photos whose lens is stated."""
    rows: list[CameraRow] = []
    for photo, notes in counted:
        if notes.lens is not None:
            own = notes.lens.equivalent
            rows.append(
                CameraRow(
                    len(rows) + 2,
                    glob.escape(photo.name),
                    focal_35mm=notes.lens.focal_mm if own else None,
                    focal_mm=None if own else notes.lens.focal_mm,
                    sensor_width_mm=None if own else notes.lens.sensor_mm[0],
                    sensor_height_mm=None if own else notes.lens.sensor_mm[1],
                )
            )
    return rows


def _camera_table(counted: list[tuple[OwnPhoto, PhotoNotes]]) -> bytes | None:
    columns = ("photo", "focal_mm", "focal_35mm", "sensor_width_mm", "sensor_height_mm")
    rows = stated_rows(counted)
    text = (["" if (v := getattr(row, name)) is None else v for name in columns] for row in rows)
    return _csv([columns, *text]) if rows else None
