"""A wheel built from the tree, unpacked anywhere, measures: what is shipped is complete, and needs no checkout."""

import csv
import json
import os
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

from proxemetry.camera import Camera
from synthetic.drawn import people_at

ROOT = Path(__file__).parents[1]
CAMERA = Camera.centred(1000, 1000, 800)


def recorded(path):
    """Write a recording of two people on a 3-4-5 triangle with its camera."""
    people = people_at([(-1.5, 0, 5), (1.5, 0, 9)], CAMERA)
    persons = [
        {"keypoints": [[*xy, score] if score else [0, 0, 0] for xy, score in zip(p.tolist(), s.tolist(), strict=True)]}
        for p, s in zip(people.keypoints_px, people.scores, strict=True)
    ]
    camera = {"fx": CAMERA.fx, "fy": CAMERA.fy, "cx": CAMERA.cx, "cy": CAMERA.cy}
    image = {"filename": "a.jpg", "width": 1000, "height": 800, "camera": camera, "people": persons}
    path.write_text(json.dumps({"skeleton": "coco17", "images": [image]}))


def test_a_wheel_measures_outside_the_checkout(tmp_path):
    pytest.importorskip("hatchling")
    build = [sys.executable, "-m", "hatchling", "build", "-t", "wheel", "-d", str(tmp_path / "dist")]
    subprocess.run(build, cwd=ROOT, check=True, capture_output=True)
    (wheel,) = (tmp_path / "dist").glob("*.whl")
    with zipfile.ZipFile(wheel) as file:
        file.extractall(tmp_path / "installed")
    data = {p.relative_to(ROOT / "src") for p in (ROOT / "src").rglob("*") if p.is_file() and p.suffix != ".pyc"}
    unpacked = {p.relative_to(tmp_path / "installed") for p in (tmp_path / "installed").rglob("*") if p.is_file()}
    assert data <= unpacked
    recorded(tmp_path / "people.json")
    environment = {**os.environ, "PYTHONPATH": str(tmp_path / "installed"), "PROXEMETRY_OFFLINE": "1"}
    measure = [
        sys.executable, "-m", "proxemetry", "measure", "--pose", "recorded:people.json", "--method", "torso", "--jobs",
        "0", "--out", "out",
    ]  # fmt: skip
    subprocess.run(measure, cwd=tmp_path, env=environment, check=True, capture_output=True)
    program = "import proxemetry; print(proxemetry.__file__)"
    where = subprocess.run(
        [sys.executable, "-c", program], cwd=tmp_path, env=environment, check=True, capture_output=True
    )
    assert str(tmp_path / "installed") in where.stdout.decode()
    with (tmp_path / "out" / "pairs.csv").open(newline="", encoding="utf-8") as file:
        (pair,) = csv.DictReader(file)
    assert float(pair["distance_m"]) == pytest.approx(5.0, rel=0.01)
