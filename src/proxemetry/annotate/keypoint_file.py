"""What was read of another tool's labels, written again as COCO annotations with the points as they are now."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from typing import Any

from ..people.skeleton import COCO_17
from ..pose.formats.coco import joints_of_people
from ..pose.formats.recording import canonical_names
from .photos import OwnPhoto
from .state import Annotations, Person, PhotoNotes
from .united import United, ids_apart, united

#: The file that holds what was read, with the points as they are now.
COCO_FILE = "coco_keypoints.json"

Fields = Mapping[str, Any]


def coco_file(now: Annotations, photos: Sequence[OwnPhoto]) -> bytes | None:
    """Return COCO annotations of all people where some were read from a file, None where none were.

    Joints, boxes, scores, depths and attributes are those that were read, and so is everything else that the file had:
    ids, licences, outlines, hands and faces, categories, annotations of no person. Where several files were read, an id
    that stands for something else in a later one is another number in that one's entries. The attributes `person` and
    `eyes_px`, `shoulder_px`, `torso_px` and `head_px` are the person's tag and points as they are now.
    """
    kept = [(photo, now.photo(photo.sha256)) for photo in photos]
    kept = [(photo, notes) for photo, notes in kept if notes.people or notes.read]
    if not any(notes.read for _, notes in kept) and not any(p.read for _, notes in kept for p in notes.people):
        return None
    files, file_of = _files([notes for _, notes in kept])
    joints = _joints((person for _, notes in kept for person in notes.people), files)
    categories, person_id = _categories(files, joints)
    licences = united([_entries(file, "licenses") for file in files])
    image_ids = ids_apart([_image(notes).get("id") for _, notes in kept])
    images: list[Fields] = []
    found: list[Fields] = []
    for (photo, notes), of, identity in zip(kept, file_of, image_ids, strict=True):
        size = {"file_name": photo.name, "width": photo.width, "height": photo.height}
        images.append({**licences.renamed(of, "license", _image(notes)), "id": identity, **size})
        for person in notes.people:
            of_file = categories.renamed(of, "category_id", (person.read or {}).get("beside", {}))
            entry = {"category_id": person_id, "iscrowd": 0, **_annotation(person, joints), **of_file}
            found.append({**entry, "image_id": identity})
        for entry in (notes.read or {}).get("annotations", ()):
            entry = _with_joints(entry, files[of], joints)
            found.append({**categories.renamed(of, "category_id", entry), "image_id": identity})
    numbers = ids_apart([entry.get("id") for entry in found])
    annotations = [{**entry, "id": number} for number, entry in zip(numbers, found, strict=True)]
    rest = {name: value for file in reversed(files) for name, value in file.items() if name not in _UNITED}
    if licences.entries:
        rest["licenses"] = licences.entries
    content = {**rest, "images": images, "annotations": annotations, "categories": categories.entries}
    return (json.dumps(content, indent=1, ensure_ascii=False) + "\n").encode()


#: Of several files these are put together; of everything else the first file's stays.
_UNITED = frozenset(("categories", "licenses"))
#: Of a category, pairs of joints that a line connects, counted from 1.
_LINES = "skeleton"


def _image(notes: PhotoNotes) -> Fields:
    return (notes.read or {}).get("image", {})


def _files(of_photos: Sequence[PhotoNotes]) -> tuple[list[Fields], list[int]]:
    """Return the files that were read, without their images and annotations, and which one each photo is of."""
    files: list[Fields] = []
    file_of: list[int] = []
    for notes in of_photos:
        file: Fields = (notes.read or {}).get("file", {})
        if file not in files:
            files.append(file)
        file_of.append(files.index(file))
    return files, file_of


def _entries(file: Fields, name: str) -> list[Any]:
    found: Any = file.get(name)
    return found if isinstance(found, list) else []  # pyright: ignore[reportUnknownVariableType]


def _categories(files: Sequence[Fields], joints: list[str]) -> tuple[United, Any]:
    """Return the categories that were read, those of people with the joints as they are written, and one of people."""
    lists = [
        [_rewritten(c, joints) if _is_of_people(file, c) else c for c in _entries(file, "categories")] for file in files
    ]
    found = united(_with_all_lines(lists))
    of_people = next((c for c in found.entries if c.get("keypoints") == joints), None)
    if of_people is not None:
        return found, of_people.get("id", 1)
    identity = ids_apart([*(c.get("id") for c in found.entries), None])[-1]
    person = {"id": identity, "name": "person", "supercategory": "person", "keypoints": joints, "skeleton": []}
    return replace(found, entries=[*found.entries, person]), identity


def _is_of_people(file: Fields, category: Fields) -> bool:
    """Return whether a category of a file is one whose entries were read as people."""
    names, _ = joints_of_people(_entries(file, "categories"))
    return names is not None and category.get("keypoints") == names


def _rewritten(category: Fields, joints: list[str]) -> dict[str, Any]:
    """Return a category of people with these joints, and the lines between joints where they are now."""
    place = [joints.index(name) + 1 for name in canonical_names(category["keypoints"])]
    lines = [
        [place[line[0] - 1], place[line[1] - 1]]
        for line in _entries(category, _LINES)
        if len(line) == 2 and all(isinstance(end, int) and 0 < end <= len(place) for end in line)
    ]
    return {**category, "keypoints": joints, _LINES: lines}


def _with_all_lines(lists: Sequence[Sequence[Fields]]) -> list[list[Fields]]:
    """Return categories; those of several files that differ in nothing but the lines between joints have all lines."""
    every = [category for of_file in lists for category in of_file]

    def lines_of(category: Fields) -> list[Any]:
        rest = {**category, _LINES: None}
        alike = [_entries(other, _LINES) for other in every if {**other, _LINES: None} == rest]
        found: list[Any] = []
        for line in (line for lines in alike for line in lines):
            if line not in found:
                found.append(line)
        return found

    return [[{**c, _LINES: lines_of(c)} if _LINES in c else c for c in of_file] for of_file in lists]


def _with_joints(entry: Fields, file: Fields, joints: Sequence[str]) -> Fields:
    """Return an entry that is of no one, as a crowd, with its keypoints where its category has them now."""
    category = next(
        (c for c in _entries(file, "categories") if str(c.get("id")) == str(entry.get("category_id"))), None
    )
    if category is None or not _is_of_people(file, category):
        return entry
    names, values = canonical_names(category["keypoints"]), _entries(entry, "keypoints")
    if len(values) != 3 * len(names):
        return entry
    placed = {name: values[3 * k : 3 * k + 3] for k, name in enumerate(names)}
    return {**entry, "keypoints": [v for joint in joints for v in placed.get(joint, [0, 0, 0])]}


def _joints(people: Iterable[Person], files: Sequence[Fields]) -> list[str]:
    found = dict.fromkeys(COCO_17.joints)
    for file in files:
        for category in _entries(file, "categories"):
            if _is_of_people(file, category):
                found |= dict.fromkeys(canonical_names(category["keypoints"]))
    for person in people:
        found |= dict.fromkeys((person.read or {}).get("joints", {}))
    return list(found)


def _annotation(person: Person, joints: Sequence[str]) -> dict[str, Any]:
    read = person.read or {}
    seen: Mapping[str, list[float]] = read.get("joints", {})
    where = [seen.get(joint, [0, 0, 0]) for joint in joints]
    x0, y0, x1, y1 = read.get("box", (0, 0, 0, 0))
    points = {f"{part.lower()}_px": list(point) for part, point in person.points.items()}
    known = {name: read[name] for name in ("score", "depth_m", "depth_sd_m") if name in read}
    return {
        "keypoints": [v for x, y, score in where for v in (x, y, _visibility(score))],
        "num_keypoints": len(seen),
        "keypoint_scores": [score for *_, score in where],
        **({"bbox": [x0, y0, x1 - x0, y1 - y0], "area": (x1 - x0) * (y1 - y0)} if "box" in read else {}),
        **known,
        "attributes": {**read.get("attributes", {}), **({"person": person.tag} if person.tag else {}), **points},
    }


def _visibility(score: float) -> int:
    """Return COCO's word for a joint: not labelled, labelled but hidden, seen."""
    return 0 if score <= 0 else 1 if score <= 0.5 else 2
