"""Damaged, copied-over, young and vanished results folders: each is one line, and rot is named."""

import csv
import os
import shutil
import socket
import subprocess
import sys
import threading
from pathlib import Path

import numpy as np
import pytest

from proxemetry.archive.review.corrections import FILE, Log
from proxemetry.archive.run import run as run_module
from proxemetry.archive.run.run import run
from proxemetry.archive.run.work import Job
from proxemetry.archive.store import damage, parts, usable
from proxemetry.archive.store.folder import Folder
from proxemetry.archive.store.index import cards
from proxemetry.archive.store.results import Results
from proxemetry.cli import main
from proxemetry.errors import OutputError
from proxemetry.evaluate import predict_photos
from proxemetry.report import write_report
from proxemetry.settings import Settings
from synthetic.small_photos import write_photo

POSE = "python:synthetic.small_photos:two_people"
NAMES = ("run.json", "manifest/manifest-000.parquet", "scenes/part-000001.parquet", "photos.parquet", "pairs.parquet")


def _measure(photos: Path, results: Path, *more: str) -> int:
    return main(["measure", str(photos), "--out", str(results), "--pose", POSE, "--jobs", "0", *more])


def _commands(results: Path) -> list[list[str]]:
    there = str(results)
    return [["export", there], ["report", there], ["summary", there], ["export", there, "--format", "coco"]]


def test_every_flipped_bit_of_a_part_is_noticed(original: Path) -> None:
    content = (original / "r/scenes/part-000002.parquet").read_bytes()
    assert damage.is_whole(content)
    generator = np.random.default_rng(1)
    for place in generator.integers(0, 8 * len(content), 500):
        flipped = bytearray(content)
        flipped[place // 8] ^= 1 << place % 8
        assert not damage.is_whole(bytes(flipped))
    assert not damage.is_whole(content[:-1])
    assert not damage.is_whole(b"")


def _rot(path: Path, where: float = 1 / 3) -> bytes:
    """Flip a bit at this part of a file's length, and return what it was."""
    content = path.read_bytes()
    damaged = bytearray(content)
    damaged[int(where * len(content))] ^= 4
    path.write_bytes(damaged)
    return content


def _rows(results: Path, table: str) -> list[dict[str, str]]:
    with (results / f"{table}.csv").open() as file:
        return list(csv.DictReader(file))


def _every_reader(results: Path, tmp_path: Path) -> list[list[str]]:
    there = str(results)
    more = [["figures", there, "--out", str(tmp_path / "f")], ["summary", there, "--methods"]]
    return [*_commands(results), *more, ["export", there, "--format", "spss,xlsx", "--out", str(tmp_path / "e")]]


def test_rot_is_named_once_and_the_rest_is_read(
    original: Path, results: Path, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    before = _rows(results, "pairs")
    _rot(results / "scenes/part-000003.parquet")
    for command in _every_reader(results, tmp_path):
        usable._warn.cache_clear()  # every command is a process of its own
        caplog.clear()
        assert main(command) == 1, command
        (said,) = [record.message for record in caplog.records]
        assert "part-000003.parquet: damaged after it was written: its 1 photo is without results" in said
        assert "--repair measures it again" in said
    lost = before[3]["photo"]
    assert [row for row in before if row["photo"] != lost] == _rows(results, "pairs")
    photos = _rows(results, "photos")
    assert [row["status"] for row in photos] == ["ok", "ok", "ok", "failed", "ok"]
    assert (photos[3]["photo"], photos[3]["n_people"], photos[3]["reason"]) == (lost, "", usable.REASON)
    assert "--repair measures it again" in (results / "report.html").read_text()
    written = {path.name for path in (tmp_path / "f").rglob("*.png")}
    assert len(written) == 8
    assert not any(Path(lost).name in name for name in written)


@pytest.mark.parametrize("where", [0.1, 0.5])
def test_rot_is_measured_again_on_request(
    where: float, original: Path, results: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    before = (results / "pairs.csv").read_bytes()
    _rot(results / "scenes/part-000003.parquet", where)
    assert main(["export", str(results)]) == 1
    assert _measure(original / "photos", results) == 2  # a run leaves nothing out
    said = capsys.readouterr().err
    assert "part-000003.parquet: damaged since it was written; delete it (or add --repair)" in said
    assert _measure(original / "photos", results, "--repair") == 0
    assert "1 damaged part removed" in capsys.readouterr().err
    assert (results / "pairs.csv").read_bytes() == before
    assert main(["report", str(results)]) == 0


def test_tables_without_what_is_damaged_are_written_anew_once_it_is_mended(results: Path) -> None:
    before = (results / "photos.csv").read_bytes()
    part = results / "scenes/part-000001.parquet"
    state = part.stat()
    whole = _rot(part)
    os.utime(part, ns=(state.st_atime_ns, state.st_mtime_ns))  # as a disk rots
    Results.open(results).write_tables()
    assert (results / "photos.csv").read_bytes() != before
    part.write_bytes(whole)
    os.utime(part, ns=(state.st_atime_ns, state.st_mtime_ns))
    assert not Results.open(results).tables_are_current()
    assert main(["report", str(results)]) == 0
    assert (results / "photos.csv").read_bytes() == before


def test_the_review_and_scenes_have_what_is_whole(results: Path) -> None:
    parts_there = sorted((results / "scenes").glob("part-*.parquet"))
    for path in (parts_there[0], parts_there[4]):
        _rot(path)
    stored = Results.open(results)
    scenes = list(stored.scenes())
    assert stored.usable().left_out == (scenes[0].photo, scenes[4].photo)
    assert [scene.status for scene in scenes] == ["failed", "ok", "ok", "ok", "failed"]
    assert [card.photo for card in cards(stored)] == [scene.photo for scene in scenes]
    assert [card.status for card in cards(stored)] == [scene.status for scene in scenes]
    assert cards(stored)[4].reason == usable.REASON
    assert [s.photo for s in stored.scenes([scenes[4].photo, scenes[1].photo])] == [scenes[1].photo, scenes[4].photo]


def test_who_asks_for_a_photo_reads_its_part_alone(results: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    stored, read = Results.open(results), Folder.read
    photos = [scene.photo for scene in stored.scenes()]
    damage._found_whole.clear()
    asked: list[str] = []
    monkeypatch.setattr(Folder, "read", lambda self, name: asked.append(name) or read(self, name))
    assert [s.photo for s in stored.scenes([photos[2], "no such photo.jpg"], corrected=False)] == [photos[2]]
    assert [name for name in asked if "part" in name] == ["scenes/part-000002.parquet"]
    assert list(stored.scenes(["no such photo.jpg"], corrected=False)) == []
    _rot(results / "scenes/part-000002.parquet")
    assert [s.status for s in stored.scenes([photos[2]], corrected=False)] == ["failed"]
    assert stored.usable([photos[2]]).damaged == stored.usable().damaged == ("scenes/part-000002.parquet",)
    assert stored.usable([photos[1]]).damaged == ()
    _rot(results / "scenes/part-000002.parquet")  # and back
    assert [s.status for s in stored.scenes()] == ["ok"] * 5
    assert stored.usable().damaged == ()


def test_a_summary_of_tables_that_are_current_reads_no_part(
    original: Path, results: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert main(["export", str(results)]) == 0
    _rot(results / "scenes/part-000002.parquet")
    monkeypatch.setattr(Results, "tables_are_current", lambda *_: True)
    assert main(["summary", str(results)]) == 0


def test_a_figure_that_a_report_lacks_is_told_though_its_tables_are_whole(
    results: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert main(["export", str(results)]) == 0
    monkeypatch.setattr(Results, "tables_are_current", lambda *_: True)
    assert write_report(results, photos=5).damaged == ()
    _rot(results / "scenes/part-000002.parquet")
    assert write_report(results, photos=5).damaged == ("scenes/part-000002.parquet",)
    assert write_report(results, photos=0).damaged == ()  # nothing was read of it


def test_tables_of_an_unfinished_run_tell_what_they_lack(results: Path) -> None:
    whole = _rot(results / "scenes/part-000002.parquet")
    assert main(["export", str(results)]) == 1
    (results / "scenes/part-000002.parquet").write_bytes(whole)
    (results / "scenes/part-000004.parquet").unlink()
    assert main(["summary", str(results)]) == 1
    assert Results.open(results).damaged_in_tables() == ("scenes/part-000002.parquet",)


def test_what_is_wholly_damaged_is_one_line(results: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for path in (results / "scenes").glob("part-*.parquet"):
        _rot(path)
    for command in _commands(results):
        assert main(command) == 2
        assert "part-000000.parquet and 4 more: damaged since" in capsys.readouterr().err


def test_a_benchmark_leaves_no_photo_out(original: Path, results: Path) -> None:
    shutil.rmtree(results)
    predict_photos(original / "photos", results, {"scene": Settings()}, pose=POSE, jobs=0)
    _rot(results / "scenes/part-000003.parquet")
    with pytest.raises(OutputError, match=r"part-000003.parquet: damaged"):
        predict_photos(original / "photos", results, {"scene": Settings()}, pose=POSE, jobs=0)


def test_stray_copies_are_ignored_and_told(results: Path, caplog: pytest.LogCaptureFixture) -> None:
    before = (results / "pairs.csv").read_bytes()
    for name in ("scenes/part-000001", "manifest/manifest-000"):
        shutil.copy(results / f"{name}.parquet", results / f"{name} (1).parquet")
    for command in _commands(results):
        assert main(command) == 0
    assert (results / "pairs.csv").read_bytes() == before
    assert "part-000001 (1).parquet: no part of a run" in caplog.text


@pytest.mark.parametrize("name", NAMES)
def test_every_damage_is_one_line_or_none(
    name: str, original: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    content = (original / "r" / name).read_bytes()
    other = b"[1]" if name.endswith("json") else (original / "r/people.parquet").read_bytes()
    kinds = {
        "cut": content[: len(content) // 2], "flipped": bytes(b ^ 16 for b in content), "empty": b"", "other": other,
        "folder": None, "pipe": None, "gone": None,
    }  # fmt: skip
    for kind, damaged in kinds.items():
        results = tmp_path / kind
        shutil.copytree(original / "r", results)
        (results / name).unlink()
        if damaged is not None:
            (results / name).write_bytes(damaged)
        elif kind != "gone":
            {"folder": os.mkdir, "pipe": os.mkfifo}[kind](results / name)
        for command in (*_commands(results), ["measure", "--pose", POSE, "--out", str(results), "--jobs", "0"]):
            codes: list[int] = []
            # a loop or a wait would keep a plain call here for ever
            worker = threading.Thread(target=lambda c=command, k=codes: k.append(main(c)), daemon=True)
            worker.start()
            worker.join(60)
            said = capsys.readouterr().err
            assert codes in ([0], [1], [2]), (kind, command, said)
            lines = [line for line in said.splitlines() if "measured already" not in line and "photos/s" not in line]
            assert codes != [2] or len(lines) == 1, (kind, command, said)


@pytest.mark.parametrize(
    "content",
    ["3", "{}", '{"metadata": 3}', '{"settings": [1]}', '{"metadata": {"proxemetry_settings": 5}}', "[" * 100_000],
)
def test_a_run_file_of_another_kind_is_one_line(
    content: str, original: Path, results: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (results / "run.json").write_text(content)
    for command in _commands(results):
        code, said = main(command), capsys.readouterr().err
        assert code == 0 or (code == 2 and said.count("\n") == 1), (command, said)
    assert _measure(original / "photos", results) == 2


def test_a_run_that_is_still_listed_is_one_line(results: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for name in ("scenes", "manifest"):
        shutil.rmtree(results / name)
    for command in (["report", str(results)], ["export", str(results)], ["export", str(results), "--format", "coco"]):
        assert main(command) == 2
        assert "photos are not listed yet" in capsys.readouterr().err


def test_a_folder_that_vanishes_is_not_success(original: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    real = run_module.Schedule.run

    def gone(*arguments: object) -> object:
        counts = real(*arguments)  # type: ignore[arg-type]
        shutil.rmtree(tmp_path / "v")
        return counts

    monkeypatch.setattr(run_module.Schedule, "run", gone)
    assert _measure(original / "photos", tmp_path / "v") == 2


def test_what_a_killed_run_left_of_tables_goes(original: Path, results: Path) -> None:
    gone = subprocess.Popen([sys.executable, "-c", ""])
    gone.wait()
    ours, theirs = (f".pairs.parquet@{host}+{gone.pid}.tmp" for host in (socket.gethostname(), "elsewhere"))
    for name in (ours, theirs):
        (results / name).write_bytes(b"x")
    assert _measure(original / "photos", results) == 0
    assert not (results / ours).exists()
    assert (results / theirs).exists()  # whoever writes there may be at it


def test_tables_of_a_part_that_is_replaced_meanwhile_are_known_to_be_old(
    results: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = Folder(results)
    stored = Results(folder)
    records = [record.record(record.file) for record in parts.previous_rows(folder, 2).values()]
    (metadata,) = parts.metadata_of(folder, [2])
    read = Results.view

    def replaced_after_reading(self: Results) -> object:
        duck = read(self)
        parts.write(folder, 2, records, metadata)
        return duck

    with monkeypatch.context() as patched:
        patched.setattr(Results, "view", replaced_after_reading)
        stored.write_tables()
    assert not stored.tables_are_current()
    stored.write_tables()
    assert stored.tables_are_current()


@pytest.mark.skipif(os.name != "posix", reason="bytes as names")
def test_a_name_of_bytes_and_one_that_spells_them_are_two(tmp_path: Path) -> None:
    (tmp_path / "photos").mkdir()
    names = [b"a\xfc.jpg", rb"a\xfc.jpg", rb"a\x5cxfc.jpg"]
    for number, name in enumerate(names):
        made = write_photo(tmp_path / f"made/{number}.jpg", number)
        try:
            shutil.copy(made, os.fsencode(tmp_path / "photos") + b"/" + name)
        except OSError:
            pytest.skip("this disk takes no such names")
    assert _measure(tmp_path / "photos", tmp_path / "r") == 0
    scenes = list(Results.open(tmp_path / "r").scenes())
    assert len({scene.sha256 for scene in scenes}) == len({scene.photo for scene in scenes}) == 3
    locations = Results.open(tmp_path / "r").locations()
    assert sorted(os.fsencode(Path(path or "").name) for path in locations.values()) == sorted(names)
    again = run([str(tmp_path / "photos")], Job(str(tmp_path / "r"), POSE), jobs=0)
    assert again.measured.photos == 0  # none is taken for another


@pytest.mark.skipif(not hasattr(os, "geteuid"), reason="POSIX rights")
def test_finished_results_that_cannot_be_written_are_looked_at(original: Path, results: Path, tmp_path: Path) -> None:
    if os.geteuid() == 0 and shutil.which("setpriv") is None:
        pytest.skip("root writes everywhere")
    assert _measure(original / "photos", results) == 0  # the copy's tables are of the copy's parts
    for path in (results, *results.rglob("*")):
        path.chmod(0o555 if path.is_dir() else 0o444)
    plain = ["setpriv", "--bounding-set=-all", "--inh-caps=-all"] if os.geteuid() == 0 else []
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, sys.path))}
    commands = (
        ["report", str(results), "--out", "x.html"],
        ["measure", str(original / "photos"), "--out", str(results), "--pose", POSE, "--jobs", "0"],
    )
    for command in commands:
        program = f"import sys; from proxemetry.cli import main; sys.exit(main({command!r}))"
        done = subprocess.run(
            [*plain, sys.executable, "-c", program], cwd=tmp_path, capture_output=True, text=True, env=environment
        )
        assert done.returncode == 0, done.stderr
    for path in (results, *results.rglob("*")):
        path.chmod(0o755)
    assert (tmp_path / "x.html").exists()


def test_corrections_of_a_disk_that_cannot_be_written_are_read(original: Path, results: Path) -> None:
    scene = next(iter(Results.open(results).scenes()))
    empty = Log(results / FILE, read_only=True)
    assert empty.actions() == []
    assert not (results / FILE).exists()
    log = Log(results / FILE)
    log.append(scene, "note", {"text": "x"}, "ada")
    log.close()
    reader = Log(results / FILE, read_only=True)
    assert [a.action for a in reader.actions()] == ["note"]
    with pytest.raises(OutputError, match="copy its folder"):
        reader.append(scene, "note", {"text": "y"}, "ada")
