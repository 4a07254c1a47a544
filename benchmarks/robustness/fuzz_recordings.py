"""The recordings that the fuzzer starts from: keypoints in each form that is read."""

from __future__ import annotations

import json
import tempfile
from collections.abc import Callable, Iterable, Iterator
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.robustness.fuzz_damage import Rng, broken_json, broken_text, pick
from proxemetry.camera import Camera
from proxemetry.measure import measure
from proxemetry.people.skeleton import COCO_17
from proxemetry.photo import Photo
from proxemetry.pose.recorded import Recorded
from proxemetry.scene import Scene

HandIn = Callable[[], Iterable[Scene]]

WIDTH, HEIGHT = 640, 480
_NAMES = ("a.jpg", "b/c.jpg")
_COCO = (
    (0.0, -0.5), (0.02, -0.53), (-0.02, -0.53), (0.05, -0.5), (-0.05, -0.5), (0.12, -0.3), (-0.12, -0.3), (0.16, -0.1),
    (-0.16, -0.1), (0.17, 0.1), (-0.17, 0.1), (0.08, 0.05), (-0.08, 0.05), (0.08, 0.32), (-0.08, 0.32), (0.08, 0.55),
    (-0.08, 0.55),
)  # fmt: skip


def _person(x: float, size: float = 180.0, joints: int = 17) -> list[list[float]]:
    rows = [[round(x + u * size, 1), round(240 + v * size, 1), 0.9] for u, v in _COCO]
    return [rows[k % len(rows)] for k in range(joints)]


def _flat(x: float, joints: int = 17) -> list[float]:
    return [value for row in _person(x, joints=joints) for value in row]


#: What a recorded person may carry besides.
_SAID: dict[str, Any] = {
    "depth_m": 5.9, "depth_sd_m": 0.1, "attributes": {"mask": "no", "age": 30, "tags": ["a", {"b": None}]},
}  # fmt: skip


def _own() -> Any:
    camera = {"fx": 700, "fy": 700, "cx": 320, "cy": 240, "k1": -0.05}
    people = [
        {"keypoints": _person(x), "box": [x - 40, 140, x + 40, 350], "score": 0.9, **_SAID} for x in (150, 320, 500)
    ]
    images = [{"filename": n, "width": WIDTH, "height": HEIGHT, "camera": camera, "people": people} for n in _NAMES]
    return {"skeleton": "coco17", "images": images}


def _coco_annotations() -> Any:
    images = [{"id": k + 1, "file_name": n, "width": WIDTH, "height": HEIGHT} for k, n in enumerate(_NAMES)]
    marked = [v if k % 3 != 2 else 2 for k, v in enumerate(_flat(150))]
    annotations = [
        {
            "id": 1,
            "image_id": 1,
            "category_id": 1,
            "keypoints": marked,
            "bbox": [110, 140, 80, 210],
            "iscrowd": 0,
            **_SAID,
        },
        {"id": 2, "image_id": 1, "category_id": 1, "keypoints": _flat(400), "score": 0.8},
    ]
    return {"images": images, "annotations": annotations, "categories": [{"id": 1, "name": "person"}]}


def _coco_results() -> Any:
    return [
        {"image_id": 1 + k % 2, "category_id": 1, "keypoints": _flat(150 + 120 * k), "score": 2.5} for k in range(3)
    ]


def _openpose() -> Any:
    people = [{"pose_keypoints_2d": _flat(x, 25)} for x in (150, 400)]
    return {"version": 1.3, "people": people}


def _label_studio() -> Any:
    size = {"original_width": WIDTH, "original_height": HEIGHT}
    regions: list[dict[str, Any]] = []
    for k in range(2):
        box = {"x": 10 + 40 * k, "y": 10, "width": 30, "height": 80, "rectanglelabels": ["person"]}
        regions.append({"id": f"b{k}", "type": "rectanglelabels", "value": box, **size})
        for joint, (x, y, _) in zip(COCO_17.joints, _person(150 + 200 * k), strict=True):
            value = {"x": 100 * x / WIDTH, "y": 100 * y / HEIGHT, "width": 0.5, "keypointlabels": [joint]}
            regions.append({"id": f"{k}{joint}", "parentID": f"b{k}", "type": "keypointlabels", "value": value, **size})
    return [{"id": 1, "data": {"image": "/data/upload/1/a.jpg"}, "annotations": [{"result": regions}]}]


def _ultralytics() -> Any:
    def one(x: float) -> dict[str, Any]:
        rows = np.array(_person(x))
        keypoints = {"x": rows[:, 0].tolist(), "y": rows[:, 1].tolist(), "visible": rows[:, 2].tolist()}
        box = {"x1": x - 40, "y1": 140, "x2": x + 40, "y2": 350}
        return {"name": "person", "class": 0, "confidence": 0.9, "box": box, "keypoints": keypoints}

    return [one(x) for x in (150, 400)]


def _mmpose() -> Any:
    def one(x: float) -> dict[str, Any]:
        points = [row[:2] for row in _person(x)]
        return {
            "keypoints": points,
            "keypoint_scores": [0.9] * 17,
            "bbox": [[x - 40, 140, x + 40, 350]],
            "bbox_score": 0.9,
        }

    return {"instance_info": [{"frame_id": 1, "instances": [one(150), one(400)]}], "meta_info": {}}


def _vitpose() -> Any:
    return {"preds": [_person(150), _person(400)], "image_paths": ["x/a.jpg", "x/a.jpg"], "boxes": [[0] * 6] * 2}


def _easy() -> Any:
    frames = {str(k): [[y, x, s] for x, y, s in _person(150 + 200 * k)] for k in range(2)}
    return {"keypoints": [frames], "skeleton": {str(k): n for k, n in enumerate(COCO_17.joints)}}


_RECORDINGS: dict[str, Callable[[], Any]] = {
    "own.json": _own, "annotations.json": _coco_annotations, "results.json": _coco_results,
    "a_keypoints.json": _openpose, "tasks.json": _label_studio,
    "a.json": _ultralytics, "results_a.json": _mmpose, "preds.json": _vitpose, "a_result.json": _easy,
}  # fmt: skip
_TEXT = "\n".join("0 0.25 0.5 0.12 0.4 " + " ".join(f"{v / 640:.4f}" for v in _flat(x)) for x in (150, 400))


def recording(rng: Rng, folder: Path) -> HandIn:
    """Write a damaged recording and return what measures photos by it."""
    name = pick(rng, [*_RECORDINGS, "a.txt"])
    path = folder / name
    path.write_bytes(broken_text(rng, _TEXT) if name == "a.txt" else broken_json(rng, _RECORDINGS[name]()))

    def hand_in() -> Iterator[Scene]:
        recorded = Recorded(path if rng.random() < 0.9 else folder)
        for photo in list(recorded.photos)[:2]:
            known = recorded._recording(photo)
            opened = (
                recorded.photo(photo) if known and known.width and known.width > 1 else Photo(photo, WIDTH, HEIGHT, "")
            )
            camera = None if recorded.camera_of(opened) else Camera.centred(700, opened.width, opened.height)
            yield measure(opened, pose=recorded, camera=camera)

    return hand_in


@cache
def recorded_whole() -> Recorded:
    """Return keypoints of two photos, undamaged, without a camera."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "own.json"
        content = _own()
        for image in content["images"]:
            del image["camera"]
        path.write_text(json.dumps(content))
        return Recorded(path)
