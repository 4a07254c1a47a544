"""`proxemetry doctor` shows every candidate, the choice and what is missing, and runs no network."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import cv2
import numpy as np
import pytest
from PIL import Image

from proxemetry.cli import doctor, main
from synthetic.camera_files import FOCAL, FOCAL_35, MAKE, MODEL, PLANE_UNIT, PLANE_X, write
from synthetic.line_scenes import exact_scene


@pytest.fixture
def photos(tmp_path: Path) -> Path:
    folder = tmp_path / "photos"
    (folder / "roll").mkdir(parents=True)
    tags = {FOCAL: (50, 1), FOCAL_35: 81, MAKE: "Canon", MODEL: "Canon EOS 600D", PLANE_X: (51840, 223), PLANE_UNIT: 4}
    write(folder / "known.jpg", 5184, 3456, tags)
    write(folder / "roll" / "scan.png", 3000, 2000)
    return folder


def test_candidates_choice_and_what_is_missing(photos: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["doctor", str(photos)]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[0] == "known.jpg: 5184 x 3456, Canon EOS 600D"
    chosen = [line for line in lines if "->" in line]
    assert (
        len(chosen) == 2
        and "ASSUMED" in chosen[1]
        and f"{50 * 51840 / 223:.0f} px" in chosen[0]
        and "focal plane" in chosen[0]
    )
    assert any("35 mm equivalent" in line for line in lines) and any("crop factor" in line for line in lines)
    assert "  missing: no focal length in the photo" in lines
    assert sum("--camera-table" in line for line in lines) == 1  # what to do is said once
    counted = "2 photos: 2 with a focal length (1 recorded in the file, 1 ASSUMED; 1 of them doubtful), 0 without"
    assert lines[-1] == f"{counted}, 0 that cannot be read"


def drawn(path: Path, pitch_deg: float) -> None:
    """Write a photo that says nothing, of two walls at right angles, focal length 600 px."""
    pixels = np.zeros((480, 640, 3), np.uint8)
    scene = exact_scene(pitch_deg, 0.0, 600.0, 640, 480, azimuths_deg=(35.0, 125.0), each=16)
    for u0, v0, u1, v1 in scene.segments_px.tolist():
        ends = [(round(16 * (u - 0.5)), round(16 * (v - 0.5))) for u, v in ((u0, v0), (u1, v1))]
        cv2.line(pixels, ends[0], ends[1], (255, 255, 255), 2, cv2.LINE_AA, shift=4)
    Image.fromarray(pixels).save(path)


def test_a_mixed_folder_is_told_who_won_and_why(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    tags = {FOCAL: (50, 1), FOCAL_35: 81, MAKE: "Canon", MODEL: "Canon EOS 600D"}
    write(tmp_path / "a.jpg", 5184, 3456, tags)
    drawn(tmp_path / "b.png", pitch_deg=8.0)
    write(tmp_path / "c.png", 1500, 1000)
    assert main(["doctor", str(tmp_path)]) == 0
    text = capsys.readouterr().out
    by_name = {photo[:5]: photo for photo in re.split(r"\n(?=[abc]\.)", text)}
    assert "-> " in by_name["a.jpg"] and "why: the camera's sensor size agrees" in by_name["a.jpg"]
    lines = by_name["b.png"]
    assert re.search(r"-> +(5[6-9]|6[0-4])\d px .* estimated from straight lines", lines)
    assert "why: they narrow it most" in lines and "published photos: half have less than 37 mm" in lines
    assert re.search(r"pitch and roll from straight lines: it looks down by (7\.[5-9]|8\.[0-5]) degrees", lines)
    nothing = by_name["c.png"]
    assert "ASSUMED: like published photos" in nothing and "19 to 10" in nothing
    assert "focal length from straight lines: none: fewer than 4 straight segments" in nothing
    assert "focal length from people: not looked for (--pose auto looks for them)" in nothing
    assert "1 recorded in the file, 1 estimated, 1 ASSUMED" in nothing


def test_what_is_not_wanted_is_not_asked(photos: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["doctor", str(photos), "--no-lines", "--no-assume"]) == 0
    out = capsys.readouterr().out
    assert "straight lines" not in out and "ASSUMED" not in out and "published photos: not asked" in out
    assert "1 with a focal length (1 recorded in the file; 0 of them doubtful), 1 without" in out


def test_people_are_asked_where_somebody_finds_them(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    write(tmp_path / "c.png", 1500, 1000)
    assert main(["doctor", str(tmp_path), "--pose", "python:synthetic.small_photos:two_people"]) == 0
    assert "focal length from people: none: " in capsys.readouterr().out


def test_only_what_is_missing(photos: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["doctor", str(photos), "--missing"]) == 0
    out = capsys.readouterr().out
    assert "known.jpg" not in out and "roll/scan.png" in out


def test_a_table_can_be_tried(photos: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    table = tmp_path / "cameras.csv"
    table.write_text("photo,focal_mm,sensor_width_mm\nroll/*,50,36\n")
    assert main(["doctor", str(photos), "--camera-table", str(table)]) == 0
    assert f"{50 * 3000 / 36:.0f} px" in capsys.readouterr().out


def test_a_row_that_fits_no_photo_is_named(photos: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    table = tmp_path / "cameras.csv"
    table.write_text("photo,focal_35mm\nrolls/*,50\nroll/*,35\n")
    assert main(["doctor", str(photos), "--camera-table", str(table)]) == 0
    out = capsys.readouterr().out
    assert "line 2 is used for none of these photos" in out and "line 3" not in out.replace("table line 3", "")


def test_exit_codes(photos: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    broken = photos / "broken.jpg"
    broken.write_bytes(b"no photo")
    assert main(["doctor", str(photos)]) == 1
    assert "broken.jpg: cannot be read" in capsys.readouterr().out
    assert main(["doctor", str(broken)]) == 2
    assert main(["doctor", str(tmp_path / "nowhere")]) == 2
    assert main(["doctor", str(photos), "--focal-mm", "50", "--focal-px", "3000"]) == 2
    assert "state the focal length twice" in capsys.readouterr().err


def _cut(path: Path) -> None:
    """Cut a file in half."""
    content = path.read_bytes()
    path.write_bytes(content[: len(content) // 2])


@pytest.mark.parametrize("ending", ["jpg", "png", "tif", "webp"])
@pytest.mark.parametrize("options", [[], ["--no-lines"], ["--focal-35mm", "35"]])
def test_a_file_that_was_cut_short_is_found(
    ending: str, options: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    noise = np.random.default_rng(1).integers(0, 256, (240, 320, 3), dtype=np.uint8)
    for name in ("cut", "whole"):
        Image.fromarray(noise).save(tmp_path / f"{name}.{ending}")
    _cut(tmp_path / f"cut.{ending}")
    assert main(["doctor", str(tmp_path), *options]) == 1
    out = capsys.readouterr().out
    assert f"cut.{ending}: cannot be read\n  not a photo that can be read (" in out
    assert f"whole.{ending}: 320 x 240" in out and f"cut.{ending}: 320" not in out
    assert "1 that cannot be read" in out.splitlines()[-1]


def test_of_many_photos_without_lines_a_spread_sample_is_decoded(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(doctor, "_DECODED", 3)
    for number in range(7):  # of which 0, 2 and 4 are decoded
        Image.new("RGB", (320, 240), (number, 0, 0)).save(tmp_path / f"{number}.jpg")
    for number in (1, 4):
        _cut(tmp_path / f"{number}.jpg")
    assert main(["doctor", str(tmp_path), "--no-lines"]) == 1
    lines = capsys.readouterr().out.splitlines()
    assert "4.jpg: cannot be read" in lines and "1.jpg: cannot be read" not in lines
    assert lines[-2] == "3 pictures, spread over all, were decoded; without --no-lines all are"
    assert main(["doctor", str(tmp_path)]) == 1
    assert "5 with a focal length" in capsys.readouterr().out.splitlines()[-1]


def test_no_network_is_loaded(photos: Path) -> None:
    code = (
        "import sys; from proxemetry.cli import main; main(['doctor', sys.argv[1]]); "
        "print([m for m in ('ai_edge_litert', 'onnxruntime', 'matplotlib') if m in sys.modules])"
    )
    run = subprocess.run([sys.executable, "-c", code, str(photos)], capture_output=True, text=True, check=True)
    assert run.stdout.splitlines()[-1] == "[]"
