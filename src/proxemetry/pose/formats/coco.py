"""COCO's two forms of keypoints: annotations with the photos' names, and bare results with image ids."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ...errors import KeypointsError
from ...people import People
from .beside import Beside
from .recording import (
    Person,
    RecordedPhoto,
    by_count,
    checked,
    has_shoulders,
    naming,
    people_of,
    person_of,
    renamed,
    size_of,
)

#: An annotator's word for a joint as a score: 1 is "there, but hidden", placed by guess; 2 is "seen".
_VISIBILITY_SCORES = np.array([0.0, 0.5, 1.0])


def read_annotations(where: str, content: Mapping[str, Any]) -> list[RecordedPhoto]:
    """Return the photos of a COCO annotation file; crowds are left out. Raises KeypointsError naming the entry."""
    persons: dict[str, list[Person]] = {}  # an id may be a number in one place and text in another
    for number, image in enumerate(content["images"]):
        with naming(f"{where}, images[{number}]"):
            if str(image["id"]) in persons:
                raise KeypointsError(f"id {image['id']} is another image's already")
            persons[str(image["id"])] = []
    with naming(f"{where}, categories"):
        names, others = joints_of_people(content.get("categories", []))
    unused: dict[str, list[Mapping[str, Any]]] = {image: [] for image in persons}
    strangers = 0  # a file may list some of its images alone, but not others alone
    for number, entry in enumerate(content["annotations"]):
        with naming(f"{where}, annotations[{number}]"):
            found = persons.get(str(entry["image_id"]))
            strangers += found is None
            if found is None:
                continue
            if str(entry.get("category_id")) in others or not entry.get("keypoints") or entry.get("iscrowd"):
                unused[str(entry["image_id"])].append(entry)
            else:
                found.append(_annotated(entry).stating(entry))
    if strangers and strangers == len(content["annotations"]):
        raise KeypointsError(f"{where}: no annotation's image_id is among the images' ids")
    file = {name: value for name, value in content.items() if name not in ("images", "annotations")}
    answer: list[RecordedPhoto] = []
    for number, image in enumerate(content["images"]):
        with naming(f"{where}, images[{number}]"):
            width, height = size_of(image)
            people, of_each = _people(persons[str(image["id"])], names)
            beside = Beside(of_each, image, tuple(unused[str(image["id"])]), file)
            answer.append(RecordedPhoto(str(image["file_name"]), people, width, height, beside=beside))
    return answer


def joints_of_people(categories: Sequence[Mapping[str, Any]]) -> tuple[Sequence[str] | None, set[str]]:
    """Return the joints' names of the category that people are in, and the ids of the others, as text.

    People have shoulders; of several such categories it is the one called person, else the first, with all others that
    have the same joints.
    """
    jointed = [category for category in categories if category.get("keypoints")]
    if not jointed:
        return None, set()
    peopled = [category for category in jointed if has_shoulders(category["keypoints"])] or jointed
    chosen = next((c for c in peopled if str(c.get("name", "")).lower() == "person"), peopled[0])
    others = {str(c["id"]) for c in categories if c.get("keypoints") != chosen["keypoints"]}
    return chosen["keypoints"], others - {str(chosen.get("id"))}


def read_results(where: str, content: Sequence[Mapping[str, Any]]) -> list[RecordedPhoto]:
    """Return the photos of a COCO results file, by image id or by name where the ids are names.

    Photos without people do not occur in such a file. Raises KeypointsError naming the entry.
    """
    persons: dict[int | str, list[Person]] = defaultdict(list)
    for number, entry in enumerate(content):
        with naming(f"{where}, entry {number}"):
            identity = entry["image_id"]
            if not isinstance(identity, int | str):
                raise KeypointsError(f"image_id {identity!r} is neither a number nor a name")
            person = person_of(entry["keypoints"], entry.get("score"), _box(entry))
            persons[identity].append(person.stating(entry))
    answer: list[RecordedPhoto] = []
    for identity, found in persons.items():
        with naming(f"{where}, image_id {identity}"):
            number = int(identity) if str(identity).isdecimal() else None
            people, of_each = _people(found, None)
            answer.append(RecordedPhoto(str(identity), people, number=number, beside=Beside(of_each)))
    return answer


def _annotated(entry: Mapping[str, Any]) -> Person:
    values = np.asarray(entry["keypoints"], dtype=float).reshape(-1, 3)
    flags = values[:, 2]
    if not np.isin(flags, (0, 1, 2)).all():
        return person_of(values, entry.get("score"), _box(entry))  # a detector's answer in the annotations' form
    return checked(Person(values[:, :2], _VISIBILITY_SCORES[flags.astype(int)], _box(entry), entry.get("score")))


def _box(entry: Mapping[str, Any]) -> list[float] | None:
    """Return x0, y0, x1, y1 of COCO's x, y, width, height."""
    if not entry.get("bbox"):
        return None
    x, y, width, height = (float(v) for v in entry["bbox"][:4])
    return [x, y, x + width, y + height]


def _people(persons: list[Person], names: Sequence[str] | None) -> tuple[People, tuple[Mapping[str, Any], ...]]:
    """Return people, and what else the file has of each."""
    skeleton, persons = by_count(persons) if names is None else renamed(names, persons)
    return people_of(skeleton, persons), tuple(person.beside for person in persons)
