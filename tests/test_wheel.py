"""A wheel built from the tree, unpacked anywhere, measures: what is shipped is complete, and needs no checkout."""

import csv
import json
import os
import shutil
import subprocess
import sys
import venv
import zipfile
from pathlib import Path

import pytest

from proxemetry.camera import Camera
from proxemetry.version import __version__
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


@pytest.fixture(scope="module")
def wheel(tmp_path_factory):
    pytest.importorskip("hatchling")
    folder = tmp_path_factory.mktemp("dist")
    build = [sys.executable, "-m", "hatchling", "build", "-t", "wheel", "-d", str(folder)]
    subprocess.run(build, cwd=ROOT, check=True, capture_output=True)
    (built,) = folder.glob("*.whl")
    return built


def outside():
    """Return an environment in which Python does not find the checkout."""
    return {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}


def test_pip_installs_the_wheel_into_a_new_environment(wheel, tmp_path):
    environment = tmp_path / "environment"
    venv.create(environment, with_pip=True, system_site_packages=True)
    scripts = environment / ("Scripts" if os.name == "nt" else "bin")
    pip = [scripts / "python", "-m", "pip", "install", "--no-index", "--no-deps", "--force-reinstall", wheel]
    subprocess.run([*map(str, pip)], check=True, capture_output=True, env=outside(), cwd=tmp_path)
    # Its dependencies are those of the environment that runs the tests.
    paths = {**outside(), "PYTHONPATH": os.pathsep.join(p for p in sys.path if p.endswith("site-packages"))}
    shown = subprocess.run([str(scripts / "proxemetry"), "--version"], check=True, capture_output=True, env=paths)
    assert shown.stdout.decode().strip() == f"proxemetry {__version__}"


@pytest.mark.parametrize("manager", ["uvx", "pipx"])
def test_a_tool_manager_runs_the_wheel(wheel, manager):
    """Fetches the dependencies: only where such a manager is installed, and where it reaches a package index."""
    if shutil.which(manager) is None:
        pytest.skip(f"{manager} is not installed")
    command = ["uvx", "--from"] if manager == "uvx" else ["pipx", "run", "--spec"]
    shown = subprocess.run([*command, str(wheel), "proxemetry", "--version"], capture_output=True, env=outside())
    if shown.returncode and b"proxemetry" not in shown.stdout:
        pytest.skip(f"{manager} could not fetch the dependencies")
    assert shown.stdout.decode().splitlines()[-1] == f"proxemetry {__version__}"


def test_a_wheel_measures_outside_the_checkout(wheel, tmp_path):
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
