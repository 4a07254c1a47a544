"""The pages on back ends: their specification and their keypoint file are such, and the table names what there is."""

import re
from pathlib import Path

from proxemetry.measure import measure
from proxemetry.pose import BACKENDS
from proxemetry.pose.onnx.specification import READY, read_specification
from proxemetry.pose.recorded import Recorded

DOCS = Path(__file__).parents[1] / "docs"
PAGE = (DOCS / "backends.md").read_text(encoding="utf-8")


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
    (block,) = re.findall(r"```json\n(.*?)```", (DOCS / "detectors.md").read_text(encoding="utf-8"), re.DOTALL)
    path = tmp_path / "mine.json"
    path.write_text(block)
    recorded = Recorded(path)
    scene = measure(recorded.photo("IMG_1.JPG"), pose=recorded)
    assert scene.camera.camera is not None
    assert scene.camera.camera.fx == 700
    # 100 px from neck to hips at 700 px of focal length: half a metre of torso is 3.5 m away, and a little more
    assert 3.2 < scene.positions_m[0, 2] < 4.2
