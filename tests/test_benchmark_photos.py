"""The whole way: photos in a folder, people found in them, placed, scored; and on again where a run stopped."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from proxemetry.benchmark import score_files
from proxemetry.cli import main
from synthetic.detections import EXACT
from synthetic.files import write
from synthetic.scenes import Recipe, scenes

DETECTOR = """
import json, pathlib
from proxemetry.people import People
from proxemetry.people.skeleton import COCO_17

SEEN = json.loads((pathlib.Path(__file__).parent / "seen.json").read_text())

def detect(pixels):
    number = round(float(pixels.mean()) / 40) - 1      # the photo's grey says which one it is
    points = SEEN[number]
    with (pathlib.Path(__file__).parent / "calls.txt").open("a") as file:
        file.write(f"{number}\\n")
    return People(COCO_17, [[xy[:2] for xy in p] for p in points], [[xy[2] for xy in p] for p in points])
"""


@pytest.fixture
def benchmark(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Three grey photos with a 35 mm equivalent in their metadata, labels, and a detector that knows who is there."""
    recipe = Recipe(kind="eye_level", posture="standing", width=640, height=426, detector=EXACT, focal_mm=(24.0, 50.0))
    photos = list(scenes(3, 11, recipe))
    write(tmp_path / "labels", photos)
    (tmp_path / "photos").mkdir()
    for number, photo in enumerate(photos):
        exif = Image.Exif()
        exif[0x010F], exif[0x0110] = "Made", "Up"
        exif.get_ifd(0x8769)[0xA405] = round(photo.focal_mm)
        grey = Image.new("RGB", (640, 426), (40 * (number + 1),) * 3)
        grey.save(tmp_path / "photos" / photo.name, exif=exif)
    seen = [np.nan_to_num(np.dstack([p.people.keypoints_px, p.people.scores])).tolist() for p in photos]
    (tmp_path / "seen.json").write_text(json.dumps(seen))
    (tmp_path / "made_up_detector.py").write_text(DETECTOR)
    monkeypatch.syspath_prepend(tmp_path)
    return tmp_path


def test_photos_to_score_and_on_again(benchmark: Path, capsys: pytest.CaptureFixture[str]) -> None:
    command = [
        "benchmark", "--images", str(benchmark / "photos"), "--labels", str(benchmark / "labels"), "--jobs", "0",
        "--out", str(benchmark / "run"), "--pose", "python:made_up_detector:detect",
    ]  # fmt: skip
    assert main([*command, "--method", "torso,scene"]) == 0
    assert "scene" in capsys.readouterr().out
    calls = (benchmark / "calls.txt").read_text()
    assert len(calls.split()) == 3
    kept = score_files(benchmark / "run" / "predictions_scene.json", benchmark / "labels").overall
    assert (kept.detection_rate, kept.false_discovery_rate, kept.n_unscored) == (1, 0, 0)
    assert kept.pair_error_pct_median_over_pairs < 25
    assert main([*command, "--method", "combined"]) == 0  # other methods, the same people: nothing is looked at again
    assert (benchmark / "calls.txt").read_text() == calls
    tables = score_files(benchmark / "run", benchmark / "labels").overall
    assert tables.n_detected == kept.n_detected


def test_recorded_keypoints_need_no_photos(benchmark: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The camera is in the file that a synthetic set comes with, so the errors are those of the geometry alone."""
    labels = benchmark / "labels"
    command = ["benchmark", "--keypoints", str(labels / "keypoints.json"), "--labels", str(labels), "--jobs", "0"]
    assert main([*command, "--out", str(benchmark / "recorded"), "--method", "torso,scene"]) == 0
    assert "scene" in capsys.readouterr().out
    overall = score_files(benchmark / "recorded" / "predictions_scene.json", labels).overall
    assert (overall.detection_rate, overall.n_unscored) == (1, 0)
    assert main(command) == 2
    assert "--out DIR" in capsys.readouterr().err
