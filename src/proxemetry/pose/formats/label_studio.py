"""Label Studio's own JSON: tasks with annotations, whose keypoints belong together by the rectangle around them."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping, Sequence
from pathlib import PurePosixPath
from typing import Any
from urllib.parse import unquote, urlsplit

import numpy as np

from ...errors import KeypointsError
from ...people import People
from ...people.skeleton import COCO_17, HALPE_26
from .recording import Person, RecordedPhoto, canonical_names, checked, naming, people_of, renamed

_POINTS, _BOXES = "keypointlabels", "rectanglelabels"


def is_label_studio(entry: Mapping[str, Any]) -> bool:
    """Return whether an entry of a list is one of Label Studio's tasks."""
    return "data" in entry and "annotations" in entry


def read_label_studio(where: str, content: Sequence[Mapping[str, Any]]) -> list[RecordedPhoto]:
    """Return the photos of exported tasks, people of the last annotation that was not cancelled.

    Keypoints with the same parent region are a person, with the parent's box where it is a rectangle; all those of a
    task without one are a person as well. Raises KeypointsError naming the task.
    """
    answer: list[RecordedPhoto] = []
    for number, task in enumerate(content):
        with naming(f"{where}, task {number}"):
            kept = [a for a in task["annotations"] if not a.get("was_cancelled")]
            regions: list[Mapping[str, Any]] = kept[-1]["result"] if kept else []
            answer.append(_photo(_name(task["data"]), regions))
    return answer


def _name(data: Mapping[str, Any]) -> str:
    """Return the photo's name: of the first of a task's data that is a path or URL."""
    for value in (data.get("image"), *data.values()):
        if isinstance(value, str) and value:
            parts = urlsplit(value)
            path = parts.query.partition("d=")[2] if parts.query.startswith("d=") else parts.path
            return PurePosixPath(unquote(path)).name
    raise KeypointsError("'data' names no image")


def _photo(name: str, regions: Sequence[Mapping[str, Any]]) -> RecordedPhoto:
    boxes = {str(r["id"]): _box(r) for r in regions if r.get("type") == _BOXES}
    joints: dict[str, dict[str, tuple[float, float]]] = defaultdict(dict)
    sizes = {(r["original_width"], r["original_height"]) for r in regions if r.get("type") in (_POINTS, _BOXES)}
    if len(sizes) > 1:
        raise KeypointsError(f"its regions are of photos of {len(sizes)} sizes")
    for region in regions:
        if region.get("type") != _POINTS:
            continue
        value, (width, height) = region["value"], next(iter(sizes))
        for label in value[_POINTS]:
            mine = joints[str(region.get("parentID") or "")]
            if label in mine:
                raise KeypointsError(f"{label!r} is there twice for one person: put a rectangle around each person")
            mine[label] = (float(value["x"]) / 100 * width, float(value["y"]) / 100 * height)
    size = next(iter(sizes), (None, None))
    if not joints:
        return RecordedPhoto(name, People.none(COCO_17), *size)
    labels = sorted({label for mine in joints.values() for label in mine})
    known = {*HALPE_26.joints} & {*canonical_names(labels)}
    if not known:
        raise KeypointsError(f"no joint of a person among its labels ({', '.join(labels[:6])})")
    names = [*labels, *(side for side in _SHOULDERS if side not in canonical_names(labels))]
    skeleton, persons = renamed(names, [_person(mine, names, boxes.get(parent)) for parent, mine in joints.items()])
    return RecordedPhoto(name, people_of(skeleton, persons), *size)


#: A recording's joints must name both, whether they were marked or not.
_SHOULDERS = ("left_shoulder", "right_shoulder")


def _person(joints: Mapping[str, tuple[float, float]], names: Sequence[str], box: Sequence[float] | None) -> Person:
    keypoints = np.array([joints.get(name, (np.nan, np.nan)) for name in names], dtype=float)
    return checked(Person(keypoints, np.isfinite(keypoints[:, 0]).astype(float), box))


def _box(region: Mapping[str, Any]) -> list[float]:
    """Return x0, y0, x1, y1 in pixels of a rectangle in hundredths of the photo's sides."""
    value, width, height = region["value"], region["original_width"], region["original_height"]
    x, y, across, down = (float(value[name]) / 100 for name in ("x", "y", "width", "height"))
    return [x * width, y * height, (x + across) * width, (y + down) * height]
