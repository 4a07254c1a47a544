"""Results for other programs: SPSS files with labels, and keypoints in COCO's form."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator
from typing import Any

from ..errors import SettingsError
from ..scene import Scene
from ..skeleton import COCO_17
from ..tables import Column, all_columns
from .folder import Folder
from .results import Results, table_query

COCO_FILE = "coco_keypoints.json"


def write_spss(results: Results, target: Folder, safe_distance_m: float | None = None) -> None:
    """Write photos, people and pairs as .sav files with the codebook's meanings as variable labels.

    Raises SettingsError where pyreadstat is missing, OutputError where a file cannot be written.
    """
    try:
        import pandas as pd
        import pyreadstat
    except ImportError as error:
        raise SettingsError("SPSS files need an extra: pip install 'proxemetry[spss]'") from error
    duck = results.view()
    for table, columns in all_columns().items():
        frame: Any = pd.DataFrame(duck.execute(table_query(table, safe_distance_m)).fetchnumpy())
        for column in columns:
            frame[column.name] = _spss_values(frame[column.name], column.kind)
        with target.writing(f"{table}.sav") as temporary:
            pyreadstat.write_sav(
                frame, temporary, file_label=f"proxemetry: {table}", row_compress=True,
                column_labels={c.name: _label(c) for c in columns},
                variable_value_labels={c.name: {0.0: "no", 1.0: "yes"} for c in columns if c.kind == "BOOLEAN"},
                variable_measure={c.name: "nominal" if c.kind in ("VARCHAR", "BOOLEAN") else "scale" for c in columns},
            )  # fmt: skip


def _spss_values(values: Any, kind: str) -> Any:
    """Return a column as SPSS has them: texts, or numbers where missing is missing."""
    if kind == "VARCHAR":
        return values.astype(object).where(values.notna(), "").astype(str)
    return values.astype("float64")


def _label(column: Column) -> str:
    return f"{column.meaning} [{column.unit}]" if column.unit else column.meaning


def write_coco(results: Results, target: Folder) -> None:
    """Write everybody's keypoints, corrections applied, as COCO keypoint annotations with scores.

    Joints that COCO does not name are left out; joints that a skeleton lacks or that were not seen have visibility 0.
    Raises OutputError where the file cannot be written.
    """
    edges = [[a, b] for a, b in ((COCO_17.index(x), COCO_17.index(y)) for x, y in COCO_17.bones) if None not in (a, b)]
    category = {
        "id": 1, "name": "person", "supercategory": "person", "keypoints": list(COCO_17.joints),
        "skeleton": [[a + 1, b + 1] for a, b in edges if a is not None and b is not None],
    }  # fmt: skip
    with target.writing(COCO_FILE) as temporary, open(temporary, "w", encoding="utf-8") as file:
        file.write('{"info": {"description": "keypoints by proxemetry"},\n"categories": ')
        json.dump([category], file)
        for name, items in (("images", _images(results)), ("annotations", _annotations(results))):
            file.write(f',\n"{name}": [')
            for number, item in enumerate(items):
                file.write((",\n" if number else "\n") + json.dumps(item, allow_nan=False))
            file.write("]")
        file.write("}\n")


def _readable(results: Results) -> Iterator[tuple[int, Scene]]:
    """Yield the photos that could be read, numbered from 1."""
    yield from enumerate((s for s in results.scenes() if s.status != "failed"), start=1)


def _images(results: Results) -> Iterator[dict[str, Any]]:
    for number, scene in _readable(results):
        yield {"id": number, "file_name": scene.photo, "width": scene.width_px, "height": scene.height_px}


def _annotations(results: Results) -> Iterator[dict[str, Any]]:
    identity = 0
    for number, scene in _readable(results):
        for person in range(len(scene)):
            identity += 1
            yield {"id": identity, "image_id": number, "category_id": 1, **_annotation(scene, person)}


def _annotation(scene: Scene, person: int) -> dict[str, Any]:
    keypoints: list[float] = []
    scores: list[float] = []
    for joint in COCO_17.joints:
        x, y = (float(v) for v in scene.people.joint(joint)[person])
        seen = math.isfinite(x)
        keypoints += [round(x, 2), round(y, 2), 2] if seen else [0, 0, 0]
        scores.append(round(float(scene.people.joint_score(joint)[person]), 4))
    x0, y0, x1, y1 = (float(v) if math.isfinite(v) else 0.0 for v in scene.people.boxes_px[person])
    return {
        "keypoints": keypoints,
        "keypoint_scores": scores,
        "num_keypoints": sum(v > 0 for v in keypoints[2::3]),
        "bbox": [round(v, 2) for v in (x0, y0, x1 - x0, y1 - y0)],
        "area": round((x1 - x0) * (y1 - y0), 1),
        "iscrowd": 0,
        "score": round(float(scene.people.person_scores[person]), 4),
    }
