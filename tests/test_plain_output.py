"""What is written for others: no formula runs, no home folder is told, no name ends a run, messages are one line."""

import csv
import json
import os
import subprocess
import sys
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from proxemetry.archive.review.corrections import FILE, Log
from proxemetry.archive.run.run import run
from proxemetry.archive.run.work import Job
from proxemetry.archive.store.results import Results
from proxemetry.benchmark import read_predictions
from proxemetry.benchmark.labels import FOCAL_FILES, read_labels
from proxemetry.benchmark.validate_labels import check_labels
from proxemetry.cli import main
from proxemetry.errors import LabelsError, PhotoError, ProxemetryError
from proxemetry.files import cell_of, parse_json, text_of
from synthetic.small_photos import write_photo, write_photos

POSE = "python:synthetic.small_photos:two_people"


@given(st.one_of(st.text(max_size=6), st.text("'=+-@\t\ra", max_size=6)))
def test_a_cell_gives_back_its_text_and_is_no_formula(text: str) -> None:
    assert text_of(cell_of(text)) == text
    assert not cell_of(text).startswith(("=", "+", "-", "@", "\t", "\r"))


def test_names_and_notes_are_no_formulas_in_csv_and_as_they_are_in_parquet(tmp_path: Path) -> None:
    for number, name in enumerate(("=HYPERLINK(1)", "'=2", "-minus", "plain")):
        write_photo(tmp_path / "photos" / f"{name}.jpg", number)
    run([str(tmp_path / "photos")], Job(str(tmp_path / "r"), POSE), jobs=0)
    results = Results.open(tmp_path / "r")
    scene = next(iter(results.scenes(["plain.jpg"])))
    log = Log(tmp_path / "r" / FILE)
    log.append(scene, "note", {"text": "+cmd|' /C calc'!A0"}, "ada")
    log.close()
    results.write_tables()
    with (tmp_path / "r/photos.csv").open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert sorted(row["photo"] for row in rows) == ["''=2.jpg", "'-minus.jpg", "'=HYPERLINK(1).jpg", "plain.jpg"]
    assert [row["note"] for row in rows if row["note"]] == ["'+cmd|' /C calc'!A0"]
    names = {"'=2.jpg", "-minus.jpg", "=HYPERLINK(1).jpg", "plain.jpg"}
    assert {image.filename for image in read_predictions(tmp_path / "r")} == names
    assert {scene.photo for scene in results.scenes()} == names


def test_a_results_folder_tells_no_home_folder_and_finds_photos_that_moved_with_it(tmp_path: Path) -> None:
    write_photos(tmp_path / "home-of-anna/photos", 2)
    (tmp_path / "home-of-anna/photos/00/z.jpg").write_bytes(b"no photo")
    run([str(tmp_path / "home-of-anna/photos")], Job(str(tmp_path / "home-of-anna/r"), POSE), jobs=0)
    for path in (tmp_path / "home-of-anna/r").rglob("*"):
        if path.is_file():
            assert str(tmp_path).encode() not in path.read_bytes(), path
            assert b"home-of-anna" not in path.read_bytes(), path
    assert json.loads((tmp_path / "home-of-anna/r/run.json").read_text())["photos_in"] == "../photos"
    (tmp_path / "home-of-anna").rename(tmp_path / "elsewhere")
    results = Results.open(tmp_path / "elsewhere/r")
    assert all(Path(where or "").exists() for where in results.locations().values())
    again = run([str(tmp_path / "elsewhere/photos")], Job(str(tmp_path / "elsewhere/r"), POSE), jobs=0)
    assert again.measured.again == 0


@pytest.mark.parametrize("encoding", ["ascii", "cp1252"])
def test_names_that_the_terminal_lacks_end_nothing(encoding: str, tmp_path: Path) -> None:
    write_photo(tmp_path / "photos/фото ä.jpg", 1)
    environment = {
        **os.environ, "PYTHONIOENCODING": encoding, "PYTHONPATH": os.pathsep.join(filter(None, sys.path)),
    }  # fmt: skip
    command = ["measure", "photos", "--out", "r", "--pose", POSE, "--jobs", "0"]
    for arguments in (command, ["doctor", "photos"]):
        done = subprocess.run(
            [sys.executable, "-m", "proxemetry", *arguments], cwd=tmp_path, env=environment, capture_output=True
        )
        assert done.returncode == 0, done.stderr
        assert rb"\u0444" in done.stdout


def test_messages_are_one_line_of_a_bearable_length() -> None:
    assert str(ProxemetryError("a\nb\r\n  c")) == "a b c"
    assert str(PhotoError("name\x1b[31m")) == r"name\x1b[31m"
    assert 500 < len(str(LabelsError("x" * 100_000))) <= 1000


@pytest.mark.skipif(os.name != "posix", reason="such names are none")
def test_names_that_would_move_the_cursor_are_spelled(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    photos, out = tmp_path / "photos", str(tmp_path / "r")
    write_photo(photos / "a\x1b[2Jb" / "one\ntwo.jpg", 1)
    write_photo(photos / "gone\x1b[1m.jpg", 2)
    (photos / "bad\x1b]0;title\x07.jpg").write_bytes(b"no photo")
    command = ["measure", str(photos), "--out", out, "--pose", POSE, "--jobs", "0"]
    assert main(command) == 1
    (photos / "gone\x1b[1m.jpg").unlink()
    for arguments in (command, ["doctor", str(photos)], ["summary", out, "--by", "folder"]):
        assert main(arguments) in (0, 1)
    said = "".join(capsys.readouterr())
    assert not set(said) & {"\x1b", "\x07"}
    for line in (r"a\x1b[2Jb/one two.jpg", r"bad\x1b]0;title\x07.jpg: cannot be read", r"any more (gone\x1b[1m.jpg)"):
        assert line in said
    assert "not there any more" in said


def test_json_that_nobody_means_is_refused() -> None:
    for text in ("[" * 100_000, '{"a": "\\ud800"}', '{"\\udc00": 1}'):
        with pytest.raises(ValueError, match=r"nested|half of a character"):
            parse_json(text)
    assert parse_json('"\\ud83d\\ude00"') == "\U0001f600"
    assert parse_json('"C:\\\\ud800"') == r"C:\ud800"
    assert parse_json("1" + "0" * 400) == float("inf")
    assert parse_json("-1" + "0" * 400) == -float("inf")


@pytest.mark.parametrize(
    "row", [b"a.jpg", b"\xff,35", b"a.jpg,0", b"a.jpg," + b"9" * 200_000, b"a.jpg,-35", b"a.jpg,nan"],
)  # fmt: skip
def test_focal_lengths_that_are_none_are_faults(row: bytes, tmp_path: Path) -> None:
    (tmp_path / "body_pixel_locations.csv").write_text("P1,Torso,1,1,a.jpg,64,48\nP2,Torso,9,1,a.jpg,64,48\n")
    (tmp_path / "ground_truth_locations.csv").write_text("0,P1,0,0,0\n0,P2,1000,0,0\n0,C1,0,0,3000\n")
    (tmp_path / "camera_locations_photoshoot_identifiers.csv").write_text("0,C1,a.jpg\n")
    (tmp_path / FOCAL_FILES[0]).write_bytes(b"filename,focal_length_mm\n" + row + b"\n")
    assert [fault.file for fault in check_labels(tmp_path)] == [FOCAL_FILES[0]]
    with pytest.raises(LabelsError):
        read_labels(tmp_path)
    assert main(["score", "--check", str(tmp_path)]) == 1


@pytest.mark.skipif(sys.platform != "linux", reason="a limit on memory")
def test_too_little_memory_is_one_line() -> None:
    program = (
        "import resource, sys; resource.setrlimit(resource.RLIMIT_AS, (512_000_000, 512_000_000))\n"
        "from proxemetry.cli import main; sys.exit(main(['doctor', '.']))"
    )
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, sys.path))}
    done = subprocess.run([sys.executable, "-c", program], env=environment, capture_output=True, text=True)
    assert done.returncode == 2
    assert done.stderr.count("\n") == 1
    assert "512 MB of memory" in done.stderr
