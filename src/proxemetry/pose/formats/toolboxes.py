"""Result files of MMPose, ViTPose (Transformers, easy_ViTPose, the original) and Ultralytics."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ...errors import KeypointsError
from ...people import People
from ..bare_arrays import skeleton_of
from .recording import Person, RecordedPhoto, by_count, checked, naming, people_of, person_of, renamed


def read_mmpose(where: str, photo: str, content: Any) -> RecordedPhoto:
    """Return the people of an MMPose prediction: a list of instances, or `instance_info` with one frame."""
    names: Sequence[str] | None = None
    with naming(where):
        if isinstance(content, Mapping):
            meta, frames = content.get("meta_info") or {}, content["instance_info"]
            if frames and "instances" in frames[0]:
                if len(frames) != 1:
                    raise KeypointsError(f"{len(frames)} frames are a video, not a photo")
                frames = frames[0]["instances"]
            joints = meta.get("keypoint_id2name")
            names = None if joints is None else [joints[key] for key in sorted(joints, key=int)]
            content = frames
        if not isinstance(content, list):
            raise KeypointsError("the instances must be a list")
    persons: list[Person] = []
    for number, entry in enumerate(content):
        with naming(f"{where}, instance {number}"):
            scores = entry.get("keypoint_scores", entry.get("scores"))
            persons.append(_instance(entry["keypoints"], scores, entry.get("bbox"), entry.get("bbox_score")))
    with naming(where):
        return RecordedPhoto(photo, _people(persons, names))


def read_easy_vitpose(where: str, photo: str, content: Mapping[str, Any]) -> RecordedPhoto:
    """Return the people of an easy_ViTPose file, whose rows are y, x, score and whose joints are named."""
    with naming(where):
        frames, joints = content["keypoints"], content["skeleton"]
        if len(frames) != 1:
            raise KeypointsError(f"{len(frames)} frames are a video, not a photo")
        names = [joints[key] for key in sorted(joints, key=int)]
        persons = [person_of(np.asarray(rows, dtype=float)[:, [1, 0, 2]]) for rows in frames[0].values()]
        return RecordedPhoto(photo, _people(persons, names))


def read_preds(where: str, content: Mapping[str, Any]) -> list[RecordedPhoto]:
    """Return the photos of the original ViTPose's and MMPose 0.x's dump: `preds` and `image_paths` row by row."""
    persons: dict[str, list[Person]] = defaultdict(list)
    with naming(where):
        scores = content.get("scores") or [None] * len(content["preds"])
        for rows, path, score in zip(content["preds"], content["image_paths"], scores, strict=True):
            persons[str(path)].append(person_of(rows, score))
    answer: list[RecordedPhoto] = []
    for path, found in persons.items():
        with naming(f"{where}, {path}"):
            answer.append(RecordedPhoto(path, _people(found, None)))
    return answer


def read_ultralytics(where: str, photo: str, content: Sequence[Mapping[str, Any]]) -> RecordedPhoto:
    """Return the people of Ultralytics' `to_json()`; detections without keypoints are no people."""
    persons: list[Person] = []
    for number, entry in enumerate(content):
        with naming(f"{where}, entry {number}"):
            points, box = entry.get("keypoints"), entry["box"]
            if points is None:
                continue
            visible = points.get("visible", [1.0] * len(points["x"]))
            rows = np.column_stack([points["x"], points["y"], visible])
            corners = [box[side] for side in ("x1", "y1", "x2", "y2")]
            persons.append(person_of(rows, entry.get("confidence"), corners))
    with naming(where):
        return RecordedPhoto(photo, _people(persons, None))


def read_ultralytics_text(where: str, photo: str, text: str) -> RecordedPhoto:
    """Return the people of Ultralytics' `save_txt`: class, box and keypoints as fractions, confidence last if saved."""
    persons: list[Person] = []
    for number, line in enumerate(filter(None, (line.strip() for line in text.splitlines())), start=1):
        with naming(f"{where}, line {number}"):
            values = [float(v) for v in line.split()]
            joints, confidence = _text_joints(values[5:])
            x, y, width, height = values[1:5]
            box = [x - width / 2, y - height / 2, x + width / 2, y + height / 2]
            persons.append(person_of(joints, confidence, box))
    with naming(where):
        return RecordedPhoto(photo, _people(persons, None), 1.0, 1.0)


def _text_joints(numbers: list[float]) -> tuple[list[list[float]], float | None]:
    """Return the joints of a line, rows of x, y and visibility or of x, y, and the confidence where one is saved.

    Only their number shows which it is: the form in which they are a known skeleton.
    """
    if len(numbers) < 2:
        raise KeypointsError("no keypoints: it is a detector's file, not a pose model's")
    forms = [(width, saved) for width in (3, 2) for saved in (0, 1) if (len(numbers) - saved) % width == 0]
    known = [form for form in forms if skeleton_of((len(numbers) - form[1]) // form[0]) is not None]
    if not forms:
        raise KeypointsError(f"{len(numbers)} keypoint numbers are neither rows of x, y, visibility nor of x, y")
    width, saved = (known or forms)[0]
    end = len(numbers) - saved
    return [numbers[k : k + width] for k in range(0, end, width)], numbers[-1] if saved else None


def _instance(keypoints: Any, scores: Any, box: Any, score: Any) -> Person:
    rows = np.asarray(keypoints, dtype=float)[:, :2]
    box = box[0] if box and isinstance(box[0], Sequence) else box
    score = score[0] if isinstance(score, Sequence) and score else score
    values = np.ones(len(rows)) if scores is None else np.asarray(scores, dtype=float)
    return checked(Person(rows, values, box, None if score is None else float(score)))


def _people(persons: list[Person], names: Sequence[str] | None) -> People:
    skeleton, persons = by_count(persons) if names is None else renamed(names, persons)
    return people_of(skeleton, persons)
