"""The page on back ends: its specification is one, and its table names what there is."""

import re
from pathlib import Path

from proxemetry.pose import BACKENDS
from proxemetry.pose.specification import READY, read_specification

PAGE = (Path(__file__).parents[1] / "docs" / "backends.md").read_text(encoding="utf-8")


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
