"""What was read of another tool's labels, written again as COCO annotations with the points as they are now."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from ..people.skeleton import COCO_17
from ..pose.formats.recording import canonical_names
from .photos import OwnPhoto
from .state import Annotations, Person, PhotoNotes

#: The file that holds what was read, with the points as they are now.
COCO_FILE = "coco_keypoints.json"

Fields = Mapping[str, Any]


def coco_file(now: Annotations, photos: Sequence[OwnPhoto]) -> bytes | None:
    """Return COCO annotations of all people where some were read from a file, None where none were.

    Joints, boxes, scores, depths and attributes are those that were read, and so is everything else that the file had:
    ids, licences, outlines, hands and faces, categories, annotations of no person. The attributes `person` and
    `eyes_px`, `shoulder_px`, `torso_px` and `head_px` are the person's tag and points as they are now.
    """
    kept = [(photo, now.photo(photo.sha256)) for photo in photos]
    kept = [(photo, notes) for photo, notes in kept if notes.people or notes.read]
    if not any(notes.read for _, notes in kept) and not any(p.read for _, notes in kept for p in notes.people):
        return None
    joints = _joints(person for _, notes in kept for person in notes.people)
    files = [_file_of(notes) for _, notes in kept]
    image_ids = _ids([(notes.read or {}).get("image", {}).get("id") for _, notes in kept])
    images = [
        {**(notes.read or {}).get("image", {}), "id": identity, "file_name": photo.name, "width": photo.width,
         "height": photo.height}
        for identity, (photo, notes) in zip(image_ids, kept, strict=True)
    ]  # fmt: skip
    categories, person_id = _categories(files, joints)
    found: list[dict[str, Any]] = []
    for identity, (_, notes) in zip(image_ids, kept, strict=True):
        for person in notes.people:
            beside = (person.read or {}).get("beside", {})
            of_person = {"category_id": person_id, "iscrowd": 0, **_annotation(person, joints), **beside}
            found.append({**of_person, "image_id": identity})
        found += [{**entry, "image_id": identity} for entry in (notes.read or {}).get("annotations", ())]
    numbers = _ids([entry.get("id") for entry in found])
    annotations = [{**entry, "id": number} for number, entry in zip(numbers, found, strict=True)]
    rest = {name: value for file in reversed(files) for name, value in file.items() if name not in _TOLD_APART}
    if licences := _united(files, "licenses"):
        rest["licenses"] = licences
    content = {**rest, "images": images, "annotations": annotations, "categories": categories}
    return (json.dumps(content, indent=1, ensure_ascii=False) + "\n").encode()


#: Of several files these are put together; of everything else the first file's stays.
_TOLD_APART = frozenset(("categories", "licenses"))


def _file_of(notes: PhotoNotes) -> Fields:
    return (notes.read or {}).get("file", {})


def _ids(wanted: Sequence[Any]) -> list[Any]:
    """Return an id for each entry: its own where it has one that no entry before has, else the next free number."""
    taken = {identity for identity in wanted if isinstance(identity, int | str)}
    found: list[Any] = []
    used: set[Any] = set()
    following = 1
    for identity in wanted:
        if not isinstance(identity, int | str) or identity in used:
            while following in taken or following in used:
                following += 1
            identity = following
        used.add(identity)
        found.append(identity)
    return found


def _united(files: Sequence[Fields], name: str) -> list[Any]:
    """Return the entries of lists of several files, each once."""
    found: list[Any] = []
    for file in files:
        entries = file.get(name)
        found += [e for e in (entries if isinstance(entries, list) else ()) if e not in found]  # pyright: ignore[reportUnknownVariableType]
    return found


def _categories(files: Sequence[Fields], joints: list[str]) -> tuple[list[Any], Any]:
    """Return the categories that were read, those of people with the joints as they are written, and one of people."""
    listed: list[Any] = []
    for category in _united(files, "categories"):
        peopled = isinstance(category, Mapping) and _has_known_joints(category, joints)  # pyright: ignore[reportUnknownArgumentType]
        listed.append(_rewritten(category, joints) if peopled else category)  # pyright: ignore[reportUnknownArgumentType]
    peopled = [c for c in listed if isinstance(c, Mapping) and c.get("keypoints") == joints]  # pyright: ignore[reportUnknownMemberType, reportUnknownVariableType]
    if peopled:
        return listed, peopled[0].get("id", 1)  # pyright: ignore[reportUnknownMemberType, reportUnknownVariableType]
    identity = _ids([*(c.get("id") for c in listed if isinstance(c, Mapping)), None])[-1]  # pyright: ignore[reportUnknownMemberType, reportUnknownVariableType]
    person = {"id": identity, "name": "person", "supercategory": "person", "keypoints": joints, "skeleton": []}
    return [*listed, person], identity


def _has_known_joints(category: Fields, joints: Sequence[str]) -> bool:
    names = category.get("keypoints")
    return bool(names) and set(canonical_names(names)) <= set(joints)


def _rewritten(category: Fields, joints: list[str]) -> dict[str, Any]:
    """Return a category of people with these joints, and the lines between joints where they are now."""
    place = [joints.index(name) + 1 for name in canonical_names(category["keypoints"])]
    lines = [
        [place[a - 1], place[b - 1]]
        for a, b in category.get("skeleton") or ()
        if 0 < a <= len(place) and 0 < b <= len(place)
    ]
    return {**category, "keypoints": joints, "skeleton": lines}


def _joints(people: Iterable[Person]) -> list[str]:
    found = dict.fromkeys(COCO_17.joints)
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
