"""Labels of another tool to begin with: keypoint files of every kind that is read, and KORTE's own label files.

What the file gives beside the four parts is kept, and written back by `keypoint_file.coco_file` with the points as they
are now.
"""

from __future__ import annotations

import json
import math
import re
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any, cast

import numpy as np

from ..benchmark.labels import BODY_FILE, LabelImage, Labels, read_labels, read_places
from ..errors import SettingsError
from ..people import People
from ..people.skeleton import PARTS
from ..pose.formats import EXTRA_JOINTS
from ..pose.recorded import Recorded
from .photos import OwnPhoto
from .proposals import proposed_people
from .state import PhotoNotes

#: Attributes that may name a person, as P3.
_NAMES = ("person", "tag", "name", "id")
_TAG = re.compile(r"P(0|[1-9]\d{0,2})")
_MM = 1000.0
#: Label files are of the photo itself, or of a copy of another size: within this they have the same shape.
_SAME_SHAPE = 0.02


def is_label_folder(path: str | Path) -> bool:
    """Return whether a path is a folder of the benchmark's label files."""
    return (Path(path) / BODY_FILE).is_file()


# Keypoint files


def recorded_people(recorded: Recorded, photo: OwnPhoto, first_key: int) -> list[dict[str, Any]] | None:
    """Return the people of a photo as a "propose" action lists them, None where the file does not name the photo.

    recorded: with what is not used of it.

    Raises KeypointsError where the file's numbers are of another photo.
    """
    if recorded.why_no_people(photo.photo) is not None or not recorded.names(photo.name):
        return None
    people, beside = recorded.detect(photo.photo), recorded.beside(photo.photo)
    listed = proposed_people(people, photo.width, photo.height, first_key, keep_all=True)
    taken: set[str] = set()
    answer: list[dict[str, Any]] = []
    for entry in listed:
        k = int(entry.pop("row"))
        attributes = dict(people.attributes[k])
        tag = next((v for name in _NAMES if _TAG.fullmatch(v := attributes.get(name, "")) and v not in taken), None)
        taken |= {tag} if tag else set()
        points = _stated_points(attributes, photo)
        if points is not None:
            entry["points"] = points
        kept = {key: v for key, v in attributes.items() if key not in _part_keys()}
        of_person = beside.people[k] if k < len(beside.people) else {}
        answer.append({**entry, "tag": tag, "read": _read(people, k, kept, of_person)})
    return answer


def of_photo(recorded: Recorded, photo: OwnPhoto) -> dict[str, Any]:
    """Return what a file has of a photo beside its people, as a "propose" action keeps it."""
    found = recorded.beside(photo.photo)
    fields = {"image": found.image, "annotations": list(found.annotations), "file": found.file}
    return {name: value for name, value in fields.items() if value}


def _read(people: People, k: int, attributes: Mapping[str, str], beside: Mapping[str, Any]) -> dict[str, Any]:
    """Return what a file gives of a person, as JSON values."""
    joints = {
        name: [round(float(x), 2), round(float(y), 2), round(float(score), 4)]
        for name, (x, y), score in zip(people.skeleton.joints, people.keypoints_px[k], people.scores[k], strict=True)
        if math.isfinite(x) and math.isfinite(y)
    }
    joints |= {name: [round(x, 2), round(y, 2), score] for name, (x, y, score) in beside.get(EXTRA_JOINTS, {}).items()}
    found: dict[str, Any] = {"joints": joints}
    if rest := {name: value for name, value in beside.items() if name != EXTRA_JOINTS}:
        found["beside"] = rest
    if np.isfinite(people.boxes_px[k]).all():
        found["box"] = [round(float(v), 2) for v in people.boxes_px[k]]
    if people.person_scores[k] > 0:
        found["score"] = round(float(people.person_scores[k]), 4)
    if math.isfinite(people.depth_m[k]):
        found |= {"depth_m": float(people.depth_m[k]), "depth_sd_m": float(people.depth_sd_m[k])}
    return {**found, "attributes": dict(attributes)} if attributes else found


def _part_keys() -> dict[str, str]:
    return {f"{part.lower()}_px": part for part in PARTS}


def _stated_points(attributes: Mapping[str, str], photo: OwnPhoto) -> dict[str, list[int]] | None:
    """Return the four parts as `keypoint_file.coco_file` wrote them, None where a file does not state them."""
    found: dict[str, list[int]] = {}
    stated = [key for key in _part_keys() if key in attributes]
    for key in stated:
        try:
            x, y = (int(v) for v in json.loads(attributes[key]))
        except (ValueError, TypeError):
            return None
        if 0 <= x < photo.width and 0 <= y < photo.height:
            found[_part_keys()[key]] = [x, y]
    return found if stated else None


# The benchmark's own label files


class LabelFolder:
    """A folder of KORTE's files, read whole; raises LabelsError where they cannot be used."""

    def __init__(self, path: str | Path) -> None:
        self.labels: Labels = read_labels(path)
        self._places = read_places(path)
        self._by_base = {Path(image.filename).name: image for image in self.labels}

    def image(self, photo: OwnPhoto) -> LabelImage | None:
        """Return a photo's labels, None where there are none; raises SettingsError where they are of another shape."""
        image = self.labels.by_name.get(photo.name) or self._by_base.get(Path(photo.name).name)
        if image is None:
            return None
        if abs(image.width * photo.height / (image.height * photo.width) - 1) > _SAME_SHAPE:
            raise SettingsError(
                f"{photo.name}: is {photo.width} x {photo.height}, but its labels are of {image.width} x {image.height}"
            )
        return image

    def people(self, photo: OwnPhoto, image: LabelImage, first_key: int) -> list[dict[str, Any]]:
        """Return the people of a photo as a "propose" action lists them."""
        scale = np.array([photo.width / image.width, photo.height / image.height])
        return [
            {"person": first_key + k, "tag": tag, "points": _inside(image.parts_px[k] * scale, photo)}
            for k, tag in enumerate(image.tags)
        ]

    def photo_actions(self, photo: OwnPhoto, image: LabelImage, notes: PhotoNotes) -> list[tuple[str, dict[str, Any]]]:
        """Return the actions that say where a photo was taken, and with which lens where the file says another."""
        if not image.shoot.isdecimal():
            raise SettingsError(f"{self.labels.source}: shoot {image.shoot!r} is not a number")
        place = {"photos": [photo.sha256], "shoot": int(image.shoot), "camera": image.camera}
        found: list[tuple[str, dict[str, Any]]] = []
        if (notes.shoot, notes.camera) != (place["shoot"], place["camera"]):
            found.append(("place_photos", place))
        lens = photo.lens
        if math.isfinite(image.focal_mm) and (lens is None or abs(lens.focal_mm - image.focal_mm) > 0.01):
            stated = {"focal_mm": image.focal_mm, "sensor_mm": sorted(image.sensor_mm, reverse=True)}
            found.append(("set_lens", {"photos": [photo.sha256], "lens": stated}))
        return found

    def shoot_actions(self, shoots: Iterable[str]) -> list[tuple[str, dict[str, Any]]]:
        """Return the actions that give the marks of these shoots their coordinates, and the shoots their names."""
        settings = {image.shoot: image.setting for image in self.labels}
        found: list[tuple[str, dict[str, Any]]] = []
        for shoot in sorted(shoots):
            if settings[shoot] != f"shoot {shoot}":
                found.append(("name_shoot", {"shoot": int(shoot), "name": settings[shoot]}))
            for tag, (x, _, z) in self._places.get(shoot, {}).items():
                found.append(("set_spot", {"shoot": int(shoot), "tag": tag, "at": [x / _MM, z / _MM]}))
        return found


def _inside(parts_px: Any, photo: OwnPhoto) -> dict[str, list[int]]:
    points = {part: point for part, point in zip(PARTS, parts_px, strict=True) if np.isfinite(point).all()}
    return {
        part: [int(x), int(y)]
        for part, (x, y) in cast("dict[str, tuple[float, float]]", points).items()
        if 0 <= x < photo.width and 0 <= y < photo.height
    }
