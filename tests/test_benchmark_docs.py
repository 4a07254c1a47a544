"""The benchmark's page and scripts do what they say."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest

from benchmarks.accuracy import compare_methods, korte_tables
from benchmarks.speed import score_speed
from proxemetry.benchmark import load_errata, read_predictions
from proxemetry.benchmark.tables import TABLES
from proxemetry.cli.benchmark import HOW
from synthetic.files import write
from synthetic.scenes import Recipe, layouts_from_labels, scenes

ROOT = Path(__file__).parent.parent
PAGE = (ROOT / "docs" / "benchmark.md").read_text(encoding="utf-8")
KORTE = ROOT.parent / "shared" / "data" / "korte"
needs_korte = pytest.mark.skipif(not KORTE.exists(), reason="the labels of the KORTE benchmark are not here")


def block(language: str) -> str:
    found = re.search(rf"```{language}\n(.*?)```", PAGE, re.DOTALL)
    assert found is not None
    return found.group(1)


def test_the_example_prediction_file_is_one(tmp_path: Path) -> None:
    path = tmp_path / "predictions.json"
    path.write_text(block("json"))
    (image,) = read_predictions(path)
    assert len(image) == 2
    assert image.up is not None
    assert image.low_mm[0, 1] == 1200


@needs_korte
def test_the_python_of_the_page_runs(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    pytest.importorskip("matplotlib")
    monkeypatch.chdir(tmp_path)
    for name in ("predictions.json", "other.json"):
        (tmp_path / name).write_text(block("json"))
    (tmp_path / "korte").mkdir()
    (tmp_path / "korte" / "labels").symlink_to(KORTE.resolve())
    exec(compile(block("python"), "benchmark.md", "exec"), {})
    assert "(" in capsys.readouterr().out


def test_the_page_names_every_table_and_erratum() -> None:
    for table in TABLES:
        assert f"`{table}`" in PAGE
    for erratum in load_errata():
        assert erratum.filename[4:8] in PAGE
    for doi in ("10.23729/b2ea87e6-b845-46b8-abf3-cdbe299ce8b0", "10.1016/j.mlwa.2022.100427"):
        assert doi in PAGE
        assert doi in HOW


@needs_korte
def test_figures_of_the_torso_on_the_page_are_what_comes_out() -> None:
    """The one row that no change of another method moves; the whole is made anew by the script."""
    rows = [line.split("|")[1:-1] for line in PAGE.splitlines() if line.startswith("| torso |")]
    published = korte_tables.score_annotated(str(KORTE), "seker2021", ["torso"])["torso"].overall
    assert rows[1][4].strip() == f"{published.pair_error_pct_mean_over_images:.1f}"
    assert rows[1][1].strip() == str(published.n_pairs)


def test_methods_are_compared_on_synthetic_scenes() -> None:
    photos = list(scenes(3, 5, Recipe(kind="tripod", posture="standing")))
    result = compare_methods.score_methods(photos, ["torso", "combined"])
    assert result["torso"].overall.n_images == 3
    assert result["torso"].overall.n_annotated_pairs == result["combined"].overall.n_annotated_pairs > 0
    text = korte_tables.summary(result, all_photos=False)
    assert len({line.count("|") for line in text.splitlines()}) == 1


def test_places_come_from_a_ground_truth_file(tmp_path: Path) -> None:
    write(tmp_path, scenes(2, 5))
    layouts = layouts_from_labels(str(tmp_path / "ground_truth_locations.csv"))
    assert len(layouts) == 2
    again = list(scenes(2, 6, Recipe(layouts=layouts)))
    assert all(len(photo.heading_rad) <= max(map(len, layouts)) for photo in again)


def test_answers_to_time_are_made_for_every_photo(tmp_path: Path) -> None:
    write(tmp_path, scenes(3, 5))
    assert score_speed.made_up_answers(str(tmp_path), tmp_path / "answers.json") == 3
    assert len(json.loads((tmp_path / "answers.json").read_text())["images"]) == 3
