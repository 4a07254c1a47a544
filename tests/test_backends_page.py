"""The pages on back ends: their specification and their keypoint file are such, and the table names what there is."""

import json
import os
import re
from pathlib import Path

import pytest

from benchmarks.networks.backends import BEGIN, END, count_cells, counted, markdown, written
from proxemetry import weights
from proxemetry.measure import measure
from proxemetry.pose import BACKENDS, PoseOptions, backend_named, is_available
from proxemetry.pose.default_eyes import EYES
from proxemetry.pose.onnx.specification import READY, read_specification
from proxemetry.pose.recorded import Recorded

SHARED = Path(__file__).resolve().parents[2] / "shared"
DOCS = Path(__file__).parents[1] / "docs"
PAGE = (DOCS / "backends.md").read_text(encoding="utf-8")
RECORD = (DOCS / "backends_measured.md").read_text(encoding="utf-8")


def test_the_specification_on_the_page_is_one(tmp_path: Path) -> None:
    (block,) = re.findall(r"```toml\n(.*?)```", PAGE, re.DOTALL)
    path = tmp_path / "mine.toml"
    path.write_text(block)
    spec = read_specification(str(path))
    assert spec.name == "my-pair" and spec.pose is not None
    assert spec.detector.tiles == (1.0, 0.6)


def test_every_back_end_is_on_the_page() -> None:
    named = set(re.findall(r"`([a-z0-9-]+)[:`]", PAGE))
    assert set(BACKENDS) <= named
    assert set(READY) <= set(BACKENDS)


def test_the_keypoint_file_on_the_page_is_one(tmp_path: Path) -> None:
    blocks = re.findall(r"```json\n(.*?)```", (DOCS / "detectors.md").read_text(encoding="utf-8"), re.DOTALL)
    (block,) = (b for b in blocks if "images" in json.loads(b))
    path = tmp_path / "mine.json"
    path.write_text(block)
    recorded = Recorded(path)
    scene = measure(recorded.photo("IMG_1.JPG"), pose=recorded)
    assert scene.camera.camera is not None
    assert scene.camera.camera.fx == 700
    # 100 px from neck to hips at 700 px of focal length: half a metre of torso is 3.5 m away, and a little more
    assert 3.2 < scene.positions_m[0, 2] < 4.2


def test_the_table_of_back_ends_is_the_benchmarks() -> None:
    block = RECORD.partition(BEGIN)[2].partition(END)[0].strip()
    rows = [[cell.strip() for cell in line.strip("|").split("|")] for line in block.splitlines()]
    assert markdown(rows[2:]) == block
    named = [row[0] for row in rows[2:]]
    assert named == [f"`{name}` normal" for name in EYES]
    assert written(RECORD, block) == RECORD


@pytest.mark.parametrize("name", EYES[:1])
def test_the_people_counted_in_the_table_are_still_found(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    folders = [*map(str, weights.cache_folders()), str(SHARED / "models")]
    monkeypatch.setenv("PROXEMETRY_CACHE", os.pathsep.join(folders))
    if not is_available(name) or not (SHARED / "data" / "photos").is_dir():
        pytest.skip(f"{name}: its networks or the labelled photos are not here")
    total = counted(backend_named(name, PoseOptions(offline=True)), SHARED / "data" / "photos")
    (line,) = [line for line in RECORD.splitlines() if line.startswith(f"| `{name}` normal |")]
    assert [cell.strip() for cell in line.split("|")[2:6]] == count_cells(total)
