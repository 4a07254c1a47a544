"""Hand-labelled joints of seven public sets, read in one form under this package's joint names.

The folder is that of `--labelled`: one folder for each set, with a COCO-form JSON file beside the pictures (MPII's in
its own form), as MMPose's test data has them. Sets label different joints; a joint under the same name is the same
place.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

#: Where the pictures of a set lie below its folder, and which file labels them.
_SETS = {
    "coco": ("test_coco.json", ""),
    "crowdpose": ("test_crowdpose.json", ""),
    "ochuman": ("test_ochuman.json", ""),
    "aic": ("test_aic.json", ""),
    "jhmdb": ("test_jhmdb_sub1.json", ""),
    "posetrack18": ("annotations/test_posetrack18_val.json", ""),
    "mpii": ("test_mpii.json", ""),
}
_MPII = (
    "right_ankle", "right_knee", "right_hip", "left_hip", "left_knee", "left_ankle", "pelvis", "thorax", "upper_neck",
    "head_top", "right_wrist", "right_elbow", "right_shoulder", "left_shoulder", "left_elbow", "left_wrist",
)  # fmt: skip
_TRUNK = ("left_shoulder", "right_shoulder", "left_hip", "right_hip")
#: A box is at least this much larger than the joints in it, where a set gives none.
_MARGIN = 0.15


@dataclass(frozen=True)
class LabelledPerson:
    """One person: box (x0, y0, x1, y1) and labelled joints in pixels, by name."""

    box_px: FloatArray
    joints_px: Mapping[str, FloatArray]

    @property
    def torso_px(self) -> float:
        """The distance from the middle of the shoulders to that of the hips; NaN where one is not labelled."""
        if not all(joint in self.joints_px for joint in _TRUNK):
            return float("nan")
        a, b, c, d = (self.joints_px[joint] for joint in _TRUNK)
        return float(np.linalg.norm((a + b) / 2 - (c + d) / 2))


@dataclass(frozen=True)
class LabelledPicture:
    """One picture of a set and its labelled people; whether everyone in it is labelled is the set's own matter."""

    set_name: str
    path: Path
    people: Sequence[LabelledPerson]


def labelled_pictures(folder: Path) -> Iterator[LabelledPicture]:
    """Yield every picture of the sets that the folder holds."""
    for name, (file, below) in _SETS.items():
        labels = folder / name / file
        if not labels.is_file():
            continue
        table = json.loads(labels.read_text(encoding="utf-8"))
        of_picture = _mpii(table) if isinstance(table, list) else _coco_form(table)
        for picture, people in of_picture.items():
            yield LabelledPicture(name, folder / name / below / picture, people)


def _coco_form(table: Mapping[str, Any]) -> dict[str, list[LabelledPerson]]:
    names = [name.lower().replace(" ", "_") for name in table["categories"][0]["keypoints"]]
    pictures = {image["id"]: image["file_name"] for image in table["images"]}
    found: dict[str, list[LabelledPerson]] = {name: [] for name in pictures.values()}
    for label in table["annotations"]:
        if label.get("iscrowd"):
            continue
        points = np.array(label["keypoints"], dtype=float).reshape(-1, 3)
        joints = {name: point[:2] for name, point in zip(names, points, strict=True) if point[2] > 0}
        if joints:
            found[pictures[label["image_id"]]].append(_person(joints, label.get("bbox")))
    return found


def _mpii(table: Sequence[Mapping[str, Any]]) -> dict[str, list[LabelledPerson]]:
    found: dict[str, list[LabelledPerson]] = {}
    for label in table:
        seen = zip(_MPII, label["joints"], label["joints_vis"], strict=True)
        joints = {name: np.array(point, dtype=float) for name, point, visible in seen if visible}
        found.setdefault(label["image"], []).append(_person(joints, None))
    return found


def _person(joints: Mapping[str, FloatArray], box: Sequence[float] | None) -> LabelledPerson:
    if box is not None and box[2] > 0:
        return LabelledPerson(np.array([box[0], box[1], box[0] + box[2], box[1] + box[3]], dtype=float), joints)
    points = np.array(list(joints.values()))
    low, high = points.min(axis=0), points.max(axis=0)
    margin = _MARGIN * (high - low).max()
    return LabelledPerson(np.concatenate([low - margin, high + margin]), joints)
