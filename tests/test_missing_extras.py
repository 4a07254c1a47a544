"""What an installation without an extra says: one line with what to install, before any work is done."""

from __future__ import annotations

import importlib.util
import shutil
import sys
import tomllib
from pathlib import Path

import pytest

import proxemetry as px
from proxemetry import plots
from proxemetry.camera import lens
from proxemetry.cli import installation, main
from proxemetry.errors import CacheError, SettingsError
from proxemetry.pose import default_eyes
from proxemetry.weights import cache as cache_module
from proxemetry.weights import fetching

PLAZA = Path(__file__).resolve().parent.parent / "examples" / "plaza.jpg"
RECORDED = f"recorded:{PLAZA.with_suffix('.json')}"


@pytest.fixture
def without(monkeypatch):
    """Make packages absent."""
    real = importlib.util.find_spec

    def hide(*names: str) -> None:
        monkeypatch.setattr(importlib.util, "find_spec", lambda name, *rest: None if name in names else real(name))

    return hide


def test_figures_without_matplotlib_are_one_line(without):
    scene = px.measure(PLAZA, pose=RECORDED)
    without("matplotlib")
    drawn = (
        scene.plot,
        lambda: plots.plan(scene),
        lambda: plots.circles(scene, None),
        lambda: plots.birds_eye(scene, None),
    )
    for draw in drawn:
        with pytest.raises(SettingsError, match=r"proxemetry\[plot\]"):
            draw()


def test_a_folder_is_not_measured_for_tables_that_cannot_be_returned(without, tmp_path):
    without("pandas")
    with pytest.raises(SettingsError, match=r"proxemetry\[notebook\]"):
        px.measure_folder(PLAZA, tmp_path / "results", pose=RECORDED, jobs=0)
    assert not (tmp_path / "results").exists()


def test_doctor_looks_for_every_extra_that_all_brings(without, capsys):
    extras = tomllib.loads((PLAZA.parents[1] / "pyproject.toml").read_text())["project"]["optional-dependencies"]
    wanted = set(extras["all"][0].partition("[")[2].rstrip("]").split(","))
    assert wanted <= {extra for _, _, extra in installation._PACKAGES}
    without(*(package for _, package, _ in installation._PACKAGES))
    main(["doctor"])
    said = capsys.readouterr().out
    assert all(f"proxemetry[{extra}]" in said for extra in wanted)


def test_a_system_without_glib_is_told_before_any_photo_is_measured(monkeypatch, tmp_path, capsys):
    lens._database.cache_clear()
    lens._cameras.cache_clear()
    monkeypatch.setitem(sys.modules, "lensfunpy", None)  # importing it fails
    shutil.copy(PLAZA, tmp_path / "a.jpg")
    pose = "python:synthetic.small_photos:two_people"
    assert main(["measure", str(tmp_path), "--out", str(tmp_path / "r"), "--pose", pose, "--jobs", "0"]) == 2
    said = capsys.readouterr().err
    assert said.count("\n") == 1 and "`apt install libglib2.0-0`" in said
    assert main(["doctor"]) == 0
    said = capsys.readouterr().out
    assert "`apt install libglib2.0-0`" in said and "nothing is missing" not in said
    # keypoints alone need no cameras' database
    assert main(["measure", "--out", str(tmp_path / "k"), "--pose", RECORDED, "--jobs", "0"]) == 0


def test_a_cache_that_cannot_be_written_is_told_once_and_before_anything_is_fetched(monkeypatch, tmp_path):
    def fetched(*_: object) -> None:
        raise AssertionError("fetched what cannot be kept")

    monkeypatch.setattr(fetching, "_fetch_files", fetched)
    monkeypatch.setattr(cache_module.os, "access", lambda path, mode: False)
    monkeypatch.setenv("PROXEMETRY_CACHE", str(tmp_path))
    monkeypatch.delenv("PROXEMETRY_OFFLINE", raising=False)
    with pytest.raises(CacheError) as told:
        default_eyes.choose(log=lambda line: None)
    assert str(told.value) == f"{tmp_path}: cannot be written; name a folder that can with PROXEMETRY_CACHE"
    assert not any(tmp_path.iterdir())
