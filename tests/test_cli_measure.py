"""`proxemetry measure` from outside: exit codes, one clear line or row for each bad input, and the tables."""

import csv
import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

import proxemetry
from proxemetry.cli import main
from proxemetry.distances import UNCERTAIN, ZONES
from proxemetry.tables import TABLES
from synthetic.small_photos import write_photo, write_photos

FAKE = ["--pose", "python:synthetic.small_photos:two_people", "--jobs", "0"]


@pytest.fixture
def measure(tmp_path, capsys):
    """Return a function that measures into tmp_path/out and returns exit code, stdout and stderr."""

    def run(*arguments, out=tmp_path / "out", fake=True):
        code = main(["measure", *(FAKE if fake else []), *map(str, arguments), "--out", str(out)])
        said = capsys.readouterr()
        return code, said.out, said.err

    return run


def table(folder, name):
    with (Path(folder) / f"{name}.csv").open(newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def test_every_photo_and_pair_has_its_row(measure, tmp_path):
    write_photos(tmp_path / "photos", 5)
    code, out, _ = measure(tmp_path / "photos", "--safe-distance", "2")
    assert code == 0
    photos, people, pairs = (table(tmp_path / "out", name) for name in ("photos", "people", "pairs"))
    assert [p["photo"] for p in photos] == [f"00/photo_{i:05d}.jpg" for i in range(5)]
    assert {p["status"] for p in photos} == {"ok"}
    assert [p["person"] for p in people] == ["0", "1"] * 5
    assert len(pairs) == 5
    for pair in pairs:
        assert 0 < float(pair["low_m"]) < float(pair["distance_m"]) < float(pair["high_m"])
        assert pair["zone"] in (*ZONES, UNCERTAIN)
    below = sum(float(p["distance_m"]) < 2 for p in pairs)
    assert sum(int(p["n_below_safe"]) for p in photos) == below
    assert {p["safe_distance_m"] for p in photos} == {"2.0"}
    assert "photos   5: 5 measured" in out
    assert f"{below} nearer than 2 m" in out
    run = json.loads((tmp_path / "out" / "run.json").read_text())
    assert run["pose"] == "python:synthetic.small_photos:two_people"
    assert run["settings"]["method"]


def test_columns_are_those_of_the_codebook(measure, tmp_path):
    write_photos(tmp_path / "photos", 1)
    measure(tmp_path / "photos")
    for name, columns in TABLES.items():
        header = (tmp_path / "out" / f"{name}.csv").read_text().splitlines()[0].split(",")
        assert header[: len(columns)] == [c.name for c in columns]


def test_bad_photos_are_rows(measure, tmp_path):
    photos = tmp_path / "photos"
    whole = write_photo(photos / "whole.jpg", 1)
    (photos / "truncated.jpg").write_bytes(whole.read_bytes()[: whole.stat().st_size // 2])
    (photos / "text.jpg").write_text("not a photo")
    (photos / "empty.jpg").write_bytes(b"")
    code, _, _ = measure(photos)
    assert code == 1
    rows = {row["photo"]: row for row in table(tmp_path / "out", "photos")}
    assert rows["whole.jpg"]["status"] == "ok"
    for bad in ("truncated.jpg", "text.jpg", "empty.jpg"):
        assert rows[bad]["status"] == "failed"
        assert rows[bad]["reason"]
        assert str(tmp_path) not in rows[bad]["reason"]
    assert len(table(tmp_path / "out", "people")) == 2


def test_a_photo_without_focal_length_lists_its_people(measure, tmp_path):
    from PIL import Image

    path = write_photo(tmp_path / "photos" / "a.png", 1)
    Image.open(path).convert("RGB").save(tmp_path / "photos" / "b.bmp")  # no EXIF
    code, out, err = measure(tmp_path / "photos" / "b.bmp")
    assert code == 0
    (row,) = table(tmp_path / "out", "photos")
    assert (row["status"], row["n_pairs"], row["focal_assumed"]) == ("ok", "1", "true")
    assert row["focal_source"] == "ASSUMED: like published photos" and float(row["focal_rel_sd"]) > 0.3
    assert "focal lengths: 1 ASSUMED\n" in out and "--focal-35mm 35" in out and "Warning" not in err
    (pair,) = table(tmp_path / "out", "pairs")
    assert float(pair["low_m"]) < float(pair["distance_m"]) < float(pair["high_m"])
    code, out, _ = measure(tmp_path / "photos" / "b.bmp", "--no-assume", "--restart")
    assert code == 0
    (row,) = table(tmp_path / "out", "photos")
    assert (row["photo"], row["status"], row["n_people"], row["n_pairs"]) == ("b.bmp", "no_camera", "2", "0")
    assert "focal" in row["reason"]
    assert "1 without a focal length" in out
    assert "--focal-35mm" in out and "--camera-table" in out  # what to do is said once
    (pair,) = table(tmp_path / "out", "pairs")
    assert pair["distance_m"] == ""
    assert pair["reason"]


def test_assumed_focal_lengths_are_counted(measure, tmp_path):
    write_photos(tmp_path / "photos", 2)
    _, out, _ = measure(tmp_path / "photos", "--focal-35mm", "28")
    assert "photos   2: 2 measured\n         focal lengths: 2 ASSUMED\n" in out


def test_a_bug_in_one_photo_is_a_row_and_shows_its_traceback(measure, tmp_path):
    write_photos(tmp_path / "photos", 9)
    arguments = ["--pose", "python:synthetic.small_photos:broken_at_seven", "--jobs", "0"]
    code, _, err = measure(tmp_path / "photos", *arguments, fake=False)
    assert code == 1
    bad = [row for row in table(tmp_path / "out", "photos") if row["status"] == "failed"]
    assert [(row["photo"], "ZeroDivisionError: seven" in row["reason"]) for row in bad] == [
        ("00/photo_00007.jpg", True)
    ]
    assert "Traceback" in err


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["missing"], "no such file or folder"),
        (["empty"], "no photos there"),
        (["photos/*.webp"], "no photos match"),
        ([], "no photos named"),
        (["photos", "--focal-mm", "50", "--focal-px", "1000"], "leave one out"),
        (["photos", "--focal-mm", "-1"], "--focal-mm"),
        (["photos", "--assume-fov", "500"], "--assume-fov"),
        (["photos", "--safe-distance", "-1"], "--safe-distance"),
        (["photos", "--jobs", "-2"], "--jobs"),
        (["photos", "--shard", "0/4"], "--shard"),
        (["photos", "--quirks", "nonsense"], "nonsense"),
        (["photos", "--child-weight", "2"], "child weight"),
        (["photos", "--camera-table", "missing.csv"], "missing.csv"),
        (["photos", "--pose", "telepathy"], "telepathy"),
        (["photos", "--pose", "recorded:missing.json"], "missing.json"),
        (["photos", "--pose", "recorded:broken.json"], "broken.json"),
        (["--pose", "recorded:broken.json"], "broken.json"),
    ],
)
def test_what_cannot_be_done_is_one_line(measure, tmp_path, monkeypatch, arguments, said):
    write_photos(tmp_path / "photos", 1)
    (tmp_path / "empty").mkdir()
    (tmp_path / "broken.json").write_text('{"images": [')
    monkeypatch.chdir(tmp_path)
    fake = "--pose" not in arguments
    code, out, err = measure(*arguments, *([] if fake else ["--jobs", "0"]), fake=fake)
    assert code == 2
    assert out == ""
    assert len(err.splitlines()) == 1
    assert said in err
    assert not (tmp_path / "out" / "photos.csv").exists()


def test_a_folder_that_cannot_be_written_is_one_line(measure, tmp_path):
    write_photos(tmp_path / "photos", 1)
    (tmp_path / "file").write_text("in the way")
    for out in (tmp_path / "file" / "out", tmp_path / "file"):
        code, _, err = measure(tmp_path / "photos", out=out)
        assert code == 2
        assert len(err.splitlines()) == 1
        assert f"cannot be written ({tmp_path / 'file'} is a file, not a folder)" in err


def test_nothing_readable_is_exit_code_2(measure, tmp_path):
    (tmp_path / "photos").mkdir()
    (tmp_path / "photos" / "text.jpg").write_text("not a photo")
    code, _, err = measure(tmp_path / "photos")
    assert code == 2
    assert len(table(tmp_path / "out", "photos")) == 1
    assert "none of the photos could be measured" in err


def test_other_settings_are_refused_by_name_and_restart_begins_anew(measure, tmp_path):
    write_photos(tmp_path / "photos", 2)
    assert measure(tmp_path / "photos")[0] == 0
    code, _, err = measure(tmp_path / "photos", "--method", "torso", "--assume-fov", "40")
    assert code == 2
    assert len(err.splitlines()) == 1
    assert "--method was" in err
    assert "--assume-fov was not given, is 40" in err
    assert "--restart" in err
    assert measure(tmp_path / "photos", "--method", "torso", "--restart")[0] == 0
    assert {row["method"] for row in table(tmp_path / "out", "people")} == {"torso"}


def test_recorded_keypoints_need_no_photos(measure, tmp_path):
    people = [{"keypoints": [[x + 3 * k, 100 + 9 * k, 0.9] for k in range(17)]} for x in (100, 300)]
    camera = {"fx": 800, "fy": 800, "cx": 320, "cy": 240}
    images = [
        {"filename": f"{name}.jpg", "width": 640, "height": 480, "camera": camera, "people": people} for name in "ab"
    ]
    recorded = tmp_path / "keypoints.json"
    recorded.write_text(json.dumps({"skeleton": "coco17", "images": images}))
    (tmp_path / "empty").mkdir()
    for number, paths in enumerate(([], [tmp_path / "empty"])):
        out = tmp_path / f"out{number}"
        code, _, err = measure(*paths, "--pose", f"recorded:{recorded}", "--jobs", "0", out=out, fake=False)
        assert code == 0, err
        assert [row["photo"] for row in table(out, "photos")] == ["a.jpg", "b.jpg"]
        assert [row["focal_px"] for row in table(out, "photos")] == ["800.0", "800.0"]
        assert len(table(out, "people")) == 4
    recorded.write_text(json.dumps({"skeleton": "coco17", "images": images[:1]}))
    code, _, err = measure("--pose", f"recorded:{recorded}", "--jobs", "0", out=out, fake=False)
    assert code == 2  # other keypoints under the same name
    assert "keypoints.json" in err


def test_overlays_lie_beside_the_tables(measure, tmp_path):
    pytest.importorskip("matplotlib")
    write_photos(tmp_path / "photos", 1)
    assert measure(tmp_path / "photos", "--overlays")[0] == 0
    assert (tmp_path / "out" / "overlays" / "00" / "photo_00000.jpg").read_bytes()[:2] == b"\xff\xd8"
    code, _, _ = measure(tmp_path, "--overlays", out=tmp_path / "out")  # the overlays are no photos of the archive
    assert code == 0
    assert len(table(tmp_path / "out", "photos")) == 1
    assert measure(tmp_path, out=tmp_path / "another")[0] == 0  # nor those of another one
    assert len(table(tmp_path / "another", "photos")) == 1


def test_the_command_as_it_is_typed(tmp_path):
    write_photos(tmp_path / "photos", 3)
    here = str(Path(__file__).parents[1])
    path = os.pathsep.join([here, str(Path(proxemetry.__file__).parents[1])])
    done = subprocess.run(
        [sys.executable, "-m", "proxemetry", "measure", "photos", "--out", "out", *FAKE[:2], "--jobs", "2"],
        cwd=tmp_path, env={**os.environ, "PYTHONPATH": path}, capture_output=True, text=True,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert "3/3 photos" in done.stderr
    assert len(table(tmp_path / "out", "pairs")) == 3


def test_the_end_says_where_the_pictures_are_and_what_comes_next(tmp_path, capsys):
    pytest.importorskip("matplotlib")
    write_photos(tmp_path / "photos", 1)
    assert main(["measure", str(tmp_path / "photos"), "--out", str(tmp_path / "out"), *FAKE, "--overlays"]) == 0
    said = capsys.readouterr().out
    assert f"pictures in {tmp_path / 'out'}/overlays (faces are not blurred" in said
    assert "proxemetry review" in said and "proxemetry report" in said


def test_an_option_given_twice_is_not_dropped_in_silence(tmp_path, capsys):
    with pytest.raises(SystemExit) as left:
        main(["measure", "x", "--out", str(tmp_path / "out"), "--method", "torso", "--method", "scene"])
    assert left.value.code == 2 and "--method is given twice" in capsys.readouterr().err


@pytest.mark.parametrize("shell", ["bash", "zsh", "tcsh"])
def test_shells_complete_every_command(shell, capsys):
    pytest.importorskip("shtab")
    assert main(["--print-completion", shell]) == 0
    said = capsys.readouterr().out
    assert all(word in said for word in ("measure", "review", "focal-35mm", "overlays"))


@pytest.mark.parametrize(
    ("stated", "doubt"),
    [
        (["--focal-mm", "50"], "--focal-mm without --sensor-mm WxH is used only"),
        (["--focal-mm", "50", "--sensor-mm", "36x24"], None),
        (["--focal-35mm", "5000"], "5000 is unusual: lenses have 8 to 800 mm"),
        (["--focal-35mm", "800"], None),
    ],
)
def test_what_is_doubtful_of_a_statement_is_said(measure, tmp_path, stated, doubt):
    photos = write_photos(tmp_path / "photos", 1)
    code, _, said = measure(photos, *stated)
    assert code == 0
    assert ("is used only" in said or "is unusual" in said) == (doubt is not None)
    assert doubt is None or doubt in said


def test_results_go_to_a_folder_of_that_name_by_default(tmp_path, monkeypatch):
    photos = write_photos(tmp_path / "photos", 1)
    (tmp_path / "elsewhere").mkdir()
    monkeypatch.chdir(tmp_path / "elsewhere")
    assert main(["measure", str(photos), *FAKE]) == 0
    assert (tmp_path / "elsewhere" / "results" / "pairs.csv").is_file()
