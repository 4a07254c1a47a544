"""`proxemetry doctor` shows every candidate, the choice and what is missing, and runs no network."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from proxemetry.cli import main
from synthetic.camera_files import FOCAL, FOCAL_35, MAKE, MODEL, PLANE_UNIT, PLANE_X, write


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
    assert len(chosen) == 1 and f"{50 * 51840 / 223:.0f} px" in chosen[0] and "focal plane" in chosen[0]
    assert any("35 mm equivalent" in line for line in lines) and any("crop factor" in line for line in lines)
    assert "  missing: no focal length in the photo" in lines
    assert sum("--camera-table" in line for line in lines) == 1  # what to do is said once
    assert lines[-1] == "2 photos: 1 with a focal length (0 of them doubtful), 1 without, 0 that cannot be read"


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


def test_no_network_is_loaded(photos: Path) -> None:
    code = (
        "import sys; from proxemetry.cli import main; main(['doctor', sys.argv[1]]); "
        "print([m for m in ('cv2', 'ai_edge_litert', 'onnxruntime', 'matplotlib') if m in sys.modules])"
    )
    run = subprocess.run([sys.executable, "-c", code, str(photos)], capture_output=True, text=True, check=True)
    assert run.stdout.splitlines()[-1] == "[]"
