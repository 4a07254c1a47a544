"""The project's own keypoint file: photos by name, people with keypoints, cameras where they are known."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from ...camera import Camera, FocalSource, Source
from ...errors import KeypointsError
from ...people.skeleton import BOX, Skeleton, skeleton_named
from .recording import Person, RecordedPhoto, box_person, naming, people_of, person_of, size_of


def read_own(where: str, content: Mapping[str, Any]) -> list[RecordedPhoto]:
    """Return the photos of `{"skeleton": ..., "images": [...]}`; raises KeypointsError naming the entry."""
    with naming(where):
        skeleton = skeleton_named(str(content["skeleton"]))
    answer: list[RecordedPhoto] = []
    for number, entry in enumerate(content["images"]):
        with naming(f"{where}, images[{number}]"):
            name = entry["filename"]
            if not isinstance(name, str) or not name:
                raise KeypointsError(f"'filename' is {name!r}: it must be the photo's name")
            width, height = size_of(entry)
            persons = [_person(person, skeleton) for person in entry.get("people", [])]
            camera = _camera(entry.get("camera"), width, height)
            answer.append(RecordedPhoto(name, people_of(skeleton, persons), width, height, camera))
    return answer


def _person(entry: Mapping[str, Any], skeleton: Skeleton) -> Person:
    if skeleton == BOX:
        return box_person(entry["box"], entry.get("score")).stating(entry)
    return person_of(entry["keypoints"], entry.get("score"), entry.get("box")).stating(entry)


def _camera(entry: Mapping[str, Any] | None, width: float | None, height: float | None) -> Camera | None:
    if entry is None:
        return None
    if width is None or height is None:
        raise KeypointsError("a camera needs the width and height of the photo that its pixels belong to")
    fx = float(entry["fx"])
    distortion = tuple(float(entry.get(name, 0.0)) for name in ("k1", "k2", "p1", "p2", "k3"))
    return Camera(
        fx, float(entry.get("fy", fx)), float(entry.get("cx", width / 2)), float(entry.get("cy", height / 2)),
        int(width), int(height), distortion=distortion, source=Source(FocalSource.KEYPOINT_FILE),  # type: ignore[arg-type]
    )  # fmt: skip
