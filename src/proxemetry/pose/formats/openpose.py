"""OpenPose's `--write_json` folders: one NAME_keypoints.json a photo, in its old and its new spelling."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from ...errors import KeypointsError
from ...people.skeleton import BODY_25, COCO_17, Skeleton
from .beside import Beside
from .recording import Person, RecordedPhoto, naming, people_of, person_of

ENDING = "_keypoints.json"

# OpenPose's 18-joint order; its neck is the middle of the shoulders, which is what COCO-17's is taken to be.
_COCO_18 = (
    "nose", "neck", "right_shoulder", "right_elbow", "right_wrist", "left_shoulder", "left_elbow", "left_wrist",
    "right_hip", "right_knee", "right_ankle", "left_hip", "left_knee", "left_ankle", "right_eye", "left_eye",
    "right_ear", "left_ear",
)  # fmt: skip
_FROM_18 = np.array([_COCO_18.index(joint) for joint in COCO_17.joints])


def read_openpose(where: str, photo: str, content: Mapping[str, Any]) -> RecordedPhoto:
    """Return the people of one file; raises KeypointsError naming the person."""
    persons: list[Person] = []
    skeleton: Skeleton = BODY_25
    for number, entry in enumerate(content["people"]):
        with naming(f"{where}, people[{number}]"):
            numbers = entry.get("pose_keypoints_2d", entry.get("pose_keypoints"))
            if numbers is None:
                raise KeypointsError("neither 'pose_keypoints_2d' nor 'pose_keypoints' is there")
            person = person_of(numbers)
            _refuse_fractions(person)
            if len(person.scores) == len(_COCO_18):
                skeleton, person = COCO_17, Person(person.keypoints[_FROM_18], person.scores[_FROM_18])
            persons.append(person.stating(entry))
    with naming(where):
        file = {name: value for name, value in content.items() if name != "people"}
        beside = Beside(tuple(person.beside for person in persons), file=file)
        return RecordedPhoto(photo, people_of(skeleton, persons), beside=beside)


def _refuse_fractions(person: Person) -> None:
    """OpenPose can write coordinates as fractions of a size that it does not write."""
    seen = person.keypoints[person.scores > 0]
    if len(seen) > 2 and np.abs(seen).max() <= 1:
        raise KeypointsError("coordinates are fractions, not pixels: run OpenPose with --keypoint_scale 0")
