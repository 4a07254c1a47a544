"""A clip's tracks for other programs: trajectories of PedPy and JuPedSim, MOT Challenge boxes, COCO keypoints."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator
from typing import Any

import numpy as np

from ..archive.store.folder import Folder
from ..people.skeleton import COCO_17
from ..scene import Scene
from .analysis import Analysis
from .measuring import scenes
from .writing import rows_of

TRAJECTORIES, MOT, COCO = "trajectories.txt", "mot.txt", "coco_keypoints.json"


def write_exports(found: Analysis, folder: Folder) -> list[str]:
    """Write all of them and return their names."""
    _trajectories(found, folder)
    who = _tracks_of_rows(found, folder)
    _mot_and_coco(folder, who)
    return [TRAJECTORIES, MOT, COCO]


def _trajectories(found: Analysis, folder: Folder) -> None:
    """PedPy's and JuPedSim's text: id, frame, x, y in metres, with the frame rate in the head."""
    times = found.measured.times_s
    step = float(np.median(np.diff(times))) if len(times) > 1 else 1.0
    with folder.writing(TRAJECTORIES) as temporary, open(temporary, "w", encoding="utf-8") as file:
        file.write(f"# framerate: {1 / step:.6g}\n# ID\tframe\tx/m\ty/m\tz/m\n")
        for frame, track, x, y in sorted(rows_of(found.people), key=lambda r: (r[1], r[0])):
            file.write(f"{track}\t{frame}\t{x:.4f}\t{y:.4f}\t0.0\n")


def _tracks_of_rows(found: Analysis, folder: Folder) -> dict[tuple[int, int], int]:
    """Return the track of each (frame, row of the scene) that belongs to one."""
    return {
        (int(f), int(r)): p.track.number
        for p in found.people
        for f, r in zip(p.track.frames, p.rows, strict=True)
        if r >= 0
    }


def _mot_and_coco(folder: Folder, who: dict[tuple[int, int], int]) -> None:
    edges = [(COCO_17.index(a), COCO_17.index(b)) for a, b in COCO_17.bones]
    category = {
        "id": 1, "name": "person", "supercategory": "person", "keypoints": list(COCO_17.joints),
        "skeleton": [[a + 1, b + 1] for a, b in edges if a is not None and b is not None],
    }  # fmt: skip
    with (
        folder.writing(MOT) as mot_path, folder.writing(COCO) as coco_path,
        open(mot_path, "w", encoding="utf-8") as mot, open(coco_path, "w", encoding="utf-8") as coco,
    ):  # fmt: skip
        coco.write('{"info": {"description": "keypoints by proxemetry, with track numbers"},\n"categories": ')
        coco.write(json.dumps([category]) + ',\n"annotations": [')
        images: list[str] = []
        identity = 0
        for frame, scene in _every(folder):
            images.append(json.dumps({
                "id": frame + 1, "file_name": scene.photo, "width": scene.width_px, "height": scene.height_px
            }))  # fmt: skip
            for row in range(len(scene)):
                track = who.get((frame, row))
                mot.write(_mot_row(frame, track, scene, row))
                coco.write((",\n" if identity else "\n") + json.dumps({
                    "id": identity + 1, "image_id": frame + 1, "category_id": 1, "track_id": track,
                    **_keypoints(scene, row),
                }))  # fmt: skip
                identity += 1
        coco.write('],\n"images": [\n' + ",\n".join(images) + "]}\n")


def _every(folder: Folder) -> Iterator[tuple[int, Scene]]:
    for first, texts in scenes(folder):
        for k, text in enumerate(texts, start=first):
            yield k, Scene.from_json(text)


def _mot_row(frame: int, track: int | None, scene: Scene, row: int) -> str:
    if track is None or not np.isfinite(scene.people.boxes_px[row]).all():
        return ""
    x0, y0, x1, y1 = map(float, scene.people.boxes_px[row])
    score = float(scene.people.person_scores[row])
    return f"{frame + 1},{track},{x0:.2f},{y0:.2f},{x1 - x0:.2f},{y1 - y0:.2f},{score:.4f},-1,-1,-1\n"


def _keypoints(scene: Scene, row: int) -> dict[str, Any]:
    points: list[float] = []
    for joint in COCO_17.joints:
        x, y = map(float, scene.people.joint(joint)[row])
        points += [round(x, 2), round(y, 2), 2] if math.isfinite(x) else [0, 0, 0]
    x0, y0, x1, y1 = (float(v) if math.isfinite(v) else 0.0 for v in scene.people.boxes_px[row])
    return {
        "keypoints": points, "num_keypoints": sum(v > 0 for v in points[2::3]),
        "bbox": [round(v, 2) for v in (x0, y0, x1 - x0, y1 - y0)], "area": round((x1 - x0) * (y1 - y0), 1),
        "iscrowd": 0, "score": round(float(scene.people.person_scores[row]), 4),
    }  # fmt: skip
