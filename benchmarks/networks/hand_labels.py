"""Joints labelled by hand, and those that a back end finds of the same people.

The folders are public sets' own files in COCO's form (`../shared/data/labelled_people`): COCO, CrowdPose, OCHuman,
PoseTrack18, AI Challenger, JHMDB, MPII. Joints that a set defines differently from COCO are left out:
the hips of MPII and JHMDB, and necks and tops of heads, which COCO's 17 do not have.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from proxemetry.people import People, PoseBackend
from proxemetry.people.keypoint_noise import apparent_stature_px
from proxemetry.people.skeleton import COCO_17
from proxemetry.photo import Photo
from proxemetry.pose.confirmation import closeness

FloatArray = NDArray[np.float64]

_FILES = (
    "coco/test_coco.json", "aic/test_aic.json", "ochuman/test_ochuman.json", "crowdpose/test_crowdpose.json",
    "posetrack18/annotations/test_posetrack18_val.json", "jhmdb/test_jhmdb_sub1.json",
)  # fmt: skip
_MPII = "mpii/test_mpii.json"
_MPII_JOINTS = (
    "right_ankle", "right_knee", "", "", "left_knee", "left_ankle", "", "", "", "", "right_wrist", "right_elbow",
    "right_shoulder", "left_shoulder", "left_elbow", "left_wrist",
)  # fmt: skip
#: Sets whose hips lie elsewhere.
_OTHER_HIPS = ("jhmdb",)
#: A back end's person is a labelled one where the joints agree this well, of 1.
_SAME = 0.5

#: Lengths between joints that a person has in common: name of `anthropometry.LENGTHS`, its ends, and the least that is
#: to be seen of it for a ratio to say something, in statures.
LENGTHS = {
    "torso": ("neck", "mid_hip", 0.15),
    "shoulders": ("left_shoulder", "right_shoulder", 0.12),
    "head": ("left_ear", "right_ear", 0.05),
    "pupils": ("left_eye", "right_eye", 0.02),
}


@dataclass(frozen=True, eq=False)
class Pair:
    """One labelled person and the back end's: rows of two `People`, and the apparent stature in pixels."""

    photo: str
    truth: People
    row: int
    seen: People
    seen_row: int
    stature_px: float

    def errors(self) -> Iterator[tuple[str, float, FloatArray]]:
        """Yield joint, score and the error (2,) in statures of every joint that both have."""
        for joint in COCO_17.joints:
            error = (self.seen.joint(joint)[self.seen_row] - self.truth.joint(joint)[self.row]) / self.stature_px
            if np.isfinite(error).all():
                yield joint, float(self.seen.joint_score(joint)[self.seen_row]), error

    def ratio(self, length: str) -> tuple[float, float, tuple[float, float]] | None:
        """Return a length as seen over the labelled one, the latter in statures, and the scores of its ends.

        None where it is hidden or foreshortened.
        """
        one, other, least = LENGTHS[length]
        true = (self.truth.joint(other)[self.row] - self.truth.joint(one)[self.row]) / self.stature_px
        seen = (self.seen.joint(other)[self.seen_row] - self.seen.joint(one)[self.seen_row]) / self.stature_px
        size = float(np.linalg.norm(true))
        if not (np.isfinite(seen).all() and size >= least):
            return None
        scores = tuple(float(self.seen.joint_score(joint)[self.seen_row]) for joint in (one, other))
        return float(seen @ true) / size**2, size, (scores[0], scores[1])


def labelled_people(folder: Path) -> dict[Path, People]:
    """Return the hand-labelled people of every photo; a joint that the annotator guessed has score 0.5."""
    rows: dict[Path, list[FloatArray]] = {}
    files = {path.relative_to(folder).as_posix(): path for path in folder.rglob("*") if path.is_file()}
    for name in _FILES:
        table = json.loads((folder / name).read_text(encoding="utf-8"))
        names = [joint.lower().replace(" ", "_") for joint in table["categories"][0]["keypoints"]]
        if name.startswith(_OTHER_HIPS):
            names = ["" if joint.endswith("hip") else joint for joint in names]
        photos = {image["id"]: _below(files, name, image["file_name"]) for image in table["images"]}
        for row in table["annotations"]:
            labels = np.array(row.get("keypoints") or [], dtype=float).reshape(-1, 3)
            if (labels[:, 2] > 0).any():
                rows.setdefault(photos[row["image_id"]], []).append(_in_order(names, labels))
    for row in json.loads((folder / _MPII).read_text(encoding="utf-8")):
        labels = np.column_stack([row["joints"], 1 + np.array(row["joints_vis"], dtype=float)])
        labels[(labels[:, :2] <= 0).any(axis=1), 2] = 0
        rows.setdefault(_below(files, _MPII, row["image"]), []).append(_in_order(_MPII_JOINTS, labels))
    stacked = {path: np.stack(people) for path, people in rows.items()}
    return {path: People(COCO_17, people[..., :2], people[..., 2] / 2) for path, people in stacked.items()}


def _below(files: Mapping[str, Path], table: str, name: str) -> Path:
    """Return the photo of that name in the folder of a set."""
    top = table.split("/")[0] + "/"
    return next(path for key, path in files.items() if key.startswith(top) and key.endswith("/" + name))


def _in_order(names: Sequence[str], labels: FloatArray) -> FloatArray:
    result = np.zeros((len(COCO_17), 3))
    for joint, label in zip(names, labels, strict=True):
        row = COCO_17.index(joint)
        if row is not None:
            result[row] = label
    return result


def pairs(backend: PoseBackend, truth: Mapping[Path, People]) -> list[Pair]:
    """Return everyone whom both the labels and the back end have."""
    found: list[Pair] = []
    for path, labelled in truth.items():
        found += matched(path.name, labelled, backend.detect(Photo.open(path)))
    return found


def matched(photo: str, labelled: People, seen: People) -> list[Pair]:
    """Return the labelled people of one photo whom a back end saw, each other's nearest."""
    if not len(seen):
        return []
    near, statures = closeness(labelled, seen), apparent_stature_px(labelled)
    best = near.argmax(axis=1)
    return [
        Pair(photo, labelled, row, seen, int(column), float(statures[row]))
        for row, column in enumerate(best)
        if near[row, column] >= _SAME and near[:, column].argmax() == row
    ]


def joint_arrays(found: Sequence[Pair]) -> dict[str, Any]:
    """Return all joints' kinds, scores, apparent statures in pixels and errors (N, 2) in statures."""
    rows = [(joint, score, pair.stature_px, *error) for pair in found for joint, score, error in pair.errors()]
    numbers = np.array([row[1:] for row in rows], dtype=float).reshape(-1, 4)
    return {
        "joint": [row[0] for row in rows],
        "score": numbers[:, 0],
        "body_px": numbers[:, 1],
        "error": numbers[:, 2:],
    }
