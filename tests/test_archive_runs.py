"""Runs over many photos: nothing lost and nothing doubled, whatever happens in between."""

from __future__ import annotations

import contextlib
import csv
import errno
import json
import logging
import multiprocessing
import os
import random
import shutil
import signal
import subprocess
import sys
import time
from collections import Counter
from pathlib import Path

import duckdb
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import proxemetry
from proxemetry.archive.review.corrections import FILE, Log
from proxemetry.archive.run import manifest_update, pool
from proxemetry.archive.run.duplicates import find_duplicates, repeated
from proxemetry.archive.run.run import run
from proxemetry.archive.run.schedule import Note
from proxemetry.archive.run.work import Job
from proxemetry.archive.run.workers import require_same_networks
from proxemetry.archive.store import manifest, parts
from proxemetry.archive.store.folder import Folder
from proxemetry.archive.store.results import Results
from proxemetry.camera.focal import FocalRequest
from proxemetry.camera.table import CameraTable
from proxemetry.cli import main
from proxemetry.errors import ModelError, OutputError, SettingsError
from proxemetry.pose import PoseOptions
from proxemetry.settings import Settings
from synthetic.manifests import listed_photos
from synthetic.small_photos import write_photo, write_photos

HERE = str(Path(__file__).parents[1])
SOURCE = str(Path(proxemetry.__file__).parents[1])
TWO_PEOPLE = "python:synthetic.small_photos:two_people"


def job(out, detector="two_people"):
    return Job(str(out), f"python:synthetic.small_photos:{detector}")


def rows(out, name="photos"):
    with (Path(out) / f"{name}.csv").open(newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def timeless(out, name):
    return [{k: v for k, v in row.items() if k != "seconds"} for row in rows(out, name)]


def leftovers(out):
    """Return what no finished run may leave: anything hidden or temporary."""
    return [p for p in Path(out).rglob("*") if p.name.startswith(".") or p.name.endswith(".tmp")]


def started(photos, out, *arguments, environment=None):
    """Start the command in a session of its own, so that its workers are found by their group."""
    return subprocess.Popen(
        [sys.executable, "-m", "proxemetry", "measure", photos, "--out", out, "--pose", TWO_PEOPLE, *arguments],
        env={**os.environ, "PYTHONPATH": os.pathsep.join([HERE, SOURCE]), **(environment or {})},
        stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True, start_new_session=True,
    )  # fmt: skip


def workers_of(parent):
    """Return the process ids of a command's workers."""
    with contextlib.suppress(OSError):
        children = Path(f"/proc/{parent}/task/{parent}/children").read_text().split()
        return [int(c) for c in children if b"--multiprocessing-fork" in Path(f"/proc/{c}/cmdline").read_bytes()]
    return []


def wait_for_parts(out, count, process):
    until = time.monotonic() + 300
    while len(list(Path(out).glob("scenes/part-*.parquet"))) < count:
        assert process.poll() is None, process.stderr.read()
        assert time.monotonic() < until
        time.sleep(0.01)


def test_shards_cover_every_photo_once(tmp_path):
    folder = Folder(tmp_path)
    made = listed_photos(folder, [f"{i}.jpg" for i in range(1000)])
    assert made.n_shards == 63  # 1000 photos in shards of 16
    names = [item.photo for shard in range(made.n_shards) for item in made.items(shard)]
    assert Counter(names) == Counter(f"{i}.jpg" for i in range(1000))
    assert manifest.read(folder) == made
    assert listed_photos(folder, [f"{i}.jpg" for i in range(1000)]) == made


def test_photos_that_came_later_get_shards_of_their_own(tmp_path):
    photos = write_photos(tmp_path / "photos", 3)
    run([str(photos)], job(tmp_path / "out"), jobs=0)
    before = {p.name: p.read_bytes() for p in (tmp_path / "out" / "scenes").iterdir()}
    write_photo(photos / "a_new_one.jpg", 77)
    outcome = run([str(photos)], job(tmp_path / "out"), jobs=0)
    assert outcome.measured.photos == 1
    assert {name: (tmp_path / "out" / "scenes" / name).read_bytes() for name in before} == before
    assert [r["photo"] for r in rows(tmp_path / "out")][-1] == "a_new_one.jpg"
    assert len(rows(tmp_path / "out")) == 4


def test_an_archive_mounted_elsewhere_goes_on(tmp_path):
    photos = write_photos(tmp_path / "photos", 3)
    run([str(photos)], job(tmp_path / "out"), jobs=0, shard=(1, 2))
    shutil.move(photos, tmp_path / "elsewhere")
    outcome = run([str(tmp_path / "elsewhere")], job(tmp_path / "out"), jobs=0)
    assert outcome.complete
    assert {r["status"] for r in rows(tmp_path / "out")} == {"ok"}


def test_other_photos_of_the_same_names_are_measured_too(tmp_path):
    card, next_card = write_photos(tmp_path / "card_1", 3), tmp_path / "card_2"
    run([str(card)], job(tmp_path / "out"), jobs=0)
    for n, path in enumerate(sorted(card.rglob("*.jpg"))):
        (next_card / path.relative_to(card)).parent.mkdir(parents=True, exist_ok=True)
        write_photo(next_card / path.relative_to(card), 50 + n)
    outcome = run([str(next_card)], job(tmp_path / "out"), jobs=0)
    assert outcome.measured.photos == 3
    found = rows(tmp_path / "out")
    assert len({r["sha256"] for r in found}) == len(found) == 6
    assert sum(r["photo"].startswith("../card_2/") for r in found) == 3
    assert run([str(next_card)], job(tmp_path / "out"), jobs=0).measured.photos == 0


def test_a_file_is_measured_once_and_reported_for_each_path(tmp_path):
    photos = write_photos(tmp_path / "photos", 4)
    original = photos / "00" / "photo_00001.jpg"
    for name in ("copy.jpg", "z/other.jpg"):
        (photos / name).parent.mkdir(exist_ok=True)
        shutil.copy(original, photos / name)
    run([str(photos)], job(tmp_path / "out", "counted"), jobs=0)
    from synthetic import small_photos

    assert small_photos.COUNT["calls"] == 4
    found = {r["photo"]: r for r in rows(tmp_path / "out")}
    assert len(found) == 6
    twins = [found[n] for n in ("00/photo_00001.jpg", "copy.jpg", "z/other.jpg")]
    assert len({t["sha256"] for t in twins}) == 1
    distances = {r["photo"]: r["distance_m"] for r in rows(tmp_path / "out", "pairs")}
    assert distances["copy.jpg"] == distances["00/photo_00001.jpg"] == distances["z/other.jpg"]


def test_copies_that_came_later_are_not_measured_again(tmp_path):
    from synthetic import small_photos

    photos = write_photos(tmp_path / "photos", 4)
    run([str(photos)], job(tmp_path / "out", "counted"), jobs=0)
    (photos / "z").mkdir()
    for name in ("a_copy.jpg", "z/another.jpg"):
        shutil.copy(photos / "00" / "photo_00002.jpg", photos / name)
    write_photo(photos / "z" / "new.jpg", 77)
    shutil.copy(photos / "z" / "new.jpg", photos / "z" / "new_twice.jpg")
    calls = small_photos.COUNT["calls"]
    assert run([str(photos)], job(tmp_path / "out", "counted"), jobs=0).measured.photos == 4
    assert small_photos.COUNT["calls"] - calls == 1
    found = {r["photo"]: r for r in timeless(tmp_path / "out", "pairs")}
    for copy, original in (("a_copy", "00/photo_00002"), ("z/another", "00/photo_00002"), ("z/new_twice", "z/new")):
        assert {**found[f"{copy}.jpg"], "photo": ""} == {**found[f"{original}.jpg"], "photo": ""}


def test_copies_wait_for_the_shard_that_has_their_original(tmp_path):
    # The original's part is lost: it is measured first, by whichever worker, and its copy taken from there.
    from synthetic import small_photos

    photos = write_photos(tmp_path / "photos", 1)
    run([str(photos)], job(tmp_path / "out", "counted"), jobs=0)
    shutil.copy(photos / "00" / "photo_00000.jpg", photos / "copy.jpg")
    run([str(photos)], job(tmp_path / "out", "counted"), jobs=0)
    shutil.rmtree(tmp_path / "out" / "scenes")
    calls = small_photos.COUNT["calls"]
    assert run([str(photos)], job(tmp_path / "out", "counted"), jobs=0).measured.photos == 2
    assert small_photos.COUNT["calls"] - calls == 1
    # A share of the work that does not have the original measures the copy itself, to the same numbers.
    before = timeless(tmp_path / "out", "pairs")
    shutil.rmtree(tmp_path / "out" / "scenes")
    for share in ((2, 2), (1, 2)):
        run([str(photos)], job(tmp_path / "out", "counted"), jobs=0, shard=share)
    assert timeless(tmp_path / "out", "pairs") == before


def test_a_copy_under_a_name_with_a_camera_of_its_own_is_measured(tmp_path):
    photos = write_photos(tmp_path / "photos", 1)
    shutil.copy(photos / "00" / "photo_00000.jpg", photos / "b.jpg")
    (tmp_path / "cameras.csv").write_text("photo,focal_px\nb.jpg,200\nb.jpeg,300\n")
    settings = Settings(focal=FocalRequest(camera_table=CameraTable.read(tmp_path / "cameras.csv")))
    said: list[object] = []
    run([str(photos)], Job(str(tmp_path / "out"), TWO_PEOPLE, settings=settings), jobs=0, on_progress=said.append)
    assert Note("cameras.csv: line 3 (b.jpeg) applies to no photo") in said
    focal = [float(r["focal_px"]) for r in rows(tmp_path / "out")]
    assert focal[1] == 200
    assert focal[0] != 200


@given(st.lists(st.tuples(st.integers(-1, 3), st.integers(0, 3)), max_size=12), st.integers(0, 12))
def test_copies_are_found_by_size_and_end(files, n_new):
    # -1: a size that cannot be told is like no other (such files are not looked into)
    sizes, ends = (np.array([f[k] for f in files], dtype=np.int64) for k in (0, 1))
    n = min(n_new, len(files))
    alike = repeated(sizes[:n], sizes[n:])
    for i in range(n):
        same = [j for j in range(len(files)) if j != i and sizes[j] == sizes[i] >= 0]
        assert alike[i] == bool(same)
    found = find_duplicates(sizes[:n], ends[:n].astype(np.uint64), sizes[n:], ends[n:].astype(np.uint64))
    for i in range(n):
        twins = [j for j in range(n) if files[j] == files[i]]
        originals = [j for j in range(len(files) - n) if files[n + j] == files[i]]
        assert found.duplicate_of[i] == (twins[0] if len(twins) > 1 else -1)
        assert found.original[i] == (originals[0] if originals else -1)


def test_a_thousand_like_files_do_not_make_one_shard():
    twins = np.full(2000, -1)
    twins[100:1900] = 100
    shards, earlier = manifest_update.shards_of(twins, first=7)
    sizes = np.bincount(shards)[7:]
    assert sizes.min() > 0  # numbered without a gap
    assert sizes.max() <= (1 + manifest_update.COPIES_A_SHARD) * 32
    assert sizes.sum() == 2000
    home = shards[100]
    assert set(earlier[100:1900][shards[100:1900] == home]) == {-1}
    assert set(earlier[100:1900][shards[100:1900] != home]) == {home}
    assert set(earlier[:100]) == {-1}


def test_photos_that_came_later_are_found_while_others_are_measured(tmp_path):
    photos = write_photos(tmp_path / "photos", 6)
    run([str(photos)], job(tmp_path / "out"), jobs=0, shard=(1, 2))
    for number in range(60, 64):
        write_photo(photos / "late" / f"{number}.jpg", number)
    totals = []
    outcome = run(
        [str(photos)], job(tmp_path / "out"), jobs=2, on_progress=lambda step: totals.append(getattr(step, "total", 0))
    )
    assert outcome.complete
    assert outcome.photos == 10
    assert totals[-1] == outcome.measured.photos == 7
    assert len(rows(tmp_path / "out")) == 10


def test_an_archive_that_is_not_mounted_is_not_measured_as_failed(tmp_path):
    photos = write_photos(tmp_path / "photos", 3)
    run([str(photos)], job(tmp_path / "out"), jobs=0, shard=(1, 2))
    shutil.move(photos, tmp_path / "elsewhere")
    photos.mkdir()
    with pytest.raises(SettingsError, match="no photos there"):
        run([str(photos)], job(tmp_path / "out"), jobs=0)
    assert len(list((tmp_path / "out" / "scenes").iterdir())) == 2


@pytest.mark.skipif(sys.platform != "linux", reason="other systems' names are always text")
def test_a_name_that_is_no_text_is_measured(tmp_path):
    photos = write_photos(tmp_path / "photos", 1)
    (photos / "00" / "photo_00000.jpg").rename(os.fsdecode(os.fsencode(photos) + b"/gr\xfc\xdfe.jpg"))
    run([str(photos)], job(tmp_path / "out"), jobs=1)
    (row,) = rows(tmp_path / "out")
    assert (row["photo"], row["status"]) == ("gr\\xfc\\xdfe.jpg", "ok")
    assert run([str(photos)], job(tmp_path / "out"), jobs=0).measured.photos == 0


def test_workers_and_one_process_write_the_same(tmp_path):
    photos = write_photos(tmp_path / "photos", 6)
    run([str(photos)], job(tmp_path / "one"), jobs=0)
    run([str(photos)], job(tmp_path / "two"), jobs=2)
    for name in ("photos", "people", "pairs"):
        assert timeless(tmp_path / "one", name) == timeless(tmp_path / "two", name)
    for name in ("people", "pairs"):
        one, two = (tmp_path / folder / f"{name}.csv" for folder in ("one", "two"))
        assert one.read_bytes() == two.read_bytes()
        one, two = (duckdb.read_parquet(str(path.with_suffix(".parquet"))).fetchall() for path in (one, two))
        assert one == two


def test_a_photo_that_ends_its_process_becomes_a_row(tmp_path):
    photos = write_photos(tmp_path / "photos", 9)
    outcome = run([str(photos)], job(tmp_path / "out", "killed_by_seven"), jobs=2)
    assert outcome.measured.failed == 1
    assert outcome.measured.photos == 9
    bad = [r for r in rows(tmp_path / "out") if r["status"] == "failed"]
    assert [r["photo"] for r in bad] == ["00/photo_00007.jpg"]
    assert "SIGKILL" in bad[0]["reason"]
    assert len(rows(tmp_path / "out")) == 9


def test_a_shard_is_taken_apart_for_a_photo_that_ends_its_process(tmp_path, monkeypatch):
    monkeypatch.setattr(manifest_update, "SHARDS_OF_A_SMALL_RUN", 2)
    photos = write_photos(tmp_path / "photos", 9)
    outcome = run([str(photos)], job(tmp_path / "out", "killed_by_seven"), jobs=2)
    assert outcome.n_shards == 2
    assert (outcome.measured.photos, outcome.measured.failed) == (9, 1)
    assert [r["photo"] for r in rows(tmp_path / "out") if r["status"] == "failed"] == ["00/photo_00007.jpg"]


def test_shares_of_the_work_meet_in_one_folder(tmp_path):
    photos = write_photos(tmp_path / "photos", 7)
    first = run([str(photos)], job(tmp_path / "out"), jobs=0, shard=(1, 2))
    assert not first.complete
    assert not (tmp_path / "out" / "photos.csv").exists()
    second = run([str(photos)], job(tmp_path / "out"), jobs=0, shard=(2, 2))
    assert second.complete
    assert first.measured.photos + second.measured.photos == len(rows(tmp_path / "out")) == 7


def test_shares_at_the_same_time_do_not_meet(tmp_path):
    photos = write_photos(tmp_path / "photos", 8)
    both = [started(photos, tmp_path / "out", "--shard", f"{i}/2", "--jobs", "1") for i in (1, 2)]
    for process in both:
        _, said = process.communicate(timeout=300)
        assert process.returncode == 0, said
    assert Counter(r["photo"] for r in rows(tmp_path / "out")).most_common(1)[0][1] == 1
    assert len(rows(tmp_path / "out")) == 8
    assert not leftovers(tmp_path / "out")


def test_parts_say_what_made_them(tmp_path):
    photos = write_photos(tmp_path / "photos", 2)
    run([str(photos)], job(tmp_path / "out"), jobs=0)
    (found,) = parts.metadata_of(Folder(tmp_path / "out"), [0, 1])
    assert found["proxemetry_version"] == proxemetry.__version__
    assert len(found["proxemetry_settings_sha256"]) == 64
    assert TWO_PEOPLE in found["proxemetry_settings"]
    assert list(json.loads(found["proxemetry_models"])) == ["small_photos.py"]  # the file that the function is in
    (tmp_path / "out" / "run.json").unlink()  # the parts alone still refuse
    with pytest.raises(OutputError, match="two_people"):
        run([str(photos)], job(tmp_path / "out", "broken_at_seven"), jobs=0)


def test_results_give_scenes_back(tmp_path):
    photos = write_photos(tmp_path / "photos", 3)
    run([str(photos)], job(tmp_path / "out"), jobs=0)
    results = Results.open(tmp_path / "out")
    assert [s.photo for s in results.scenes()] == [r["photo"] for r in rows(tmp_path / "out")]
    (one,) = results.scenes(["00/photo_00001.jpg"])
    (pair,) = [r for r in rows(tmp_path / "out", "pairs") if r["photo"] == one.photo]
    assert float(pair["distance_m"]) == pytest.approx(one.distances_m[0, 1], rel=1e-5)
    assert Path(results.locations()[one.photo]).exists()
    assert results.location(one.photo) == results.locations()[one.photo]
    assert results.missing_shards() == []


def test_a_folder_may_be_called_anything(tmp_path):
    photos, out = write_photos(tmp_path / "1990 [scans] *", 3), tmp_path / "out? [1-9]"
    run([str(photos)], job(out), jobs=0)
    assert len(rows(out)) == 3
    results = Results.open(out)
    assert [scene.photo for scene in results.scenes()] == [row["photo"] for row in rows(out)]
    scene = next(results.scenes())
    log = Log(out / FILE)
    log.append(scene, "note", {"text": "x"}, "ada")
    log.close()
    assert results.touched() == {scene.photo}


def test_tables_that_would_be_the_same_are_left_alone(tmp_path):
    photos = write_photos(tmp_path / "photos", 2)
    run([str(photos)], job(tmp_path / "out"), jobs=0)
    pairs = tmp_path / "out" / "pairs.csv"
    before = pairs.stat().st_mtime_ns, pairs.read_bytes()
    run([str(photos)], job(tmp_path / "out"), jobs=0)
    assert (pairs.stat().st_mtime_ns, pairs.read_bytes()) == before
    run([str(photos)], job(tmp_path / "out"), jobs=0, safe_distance_m=2.0)
    assert rows(tmp_path / "out")[0]["safe_distance_m"] == "2.0"
    pairs.unlink()
    run([str(photos)], job(tmp_path / "out"), jobs=0, safe_distance_m=2.0)
    assert pairs.read_bytes() == before[1]


def test_a_folder_without_results_is_refused(tmp_path):
    with pytest.raises(OutputError, match="no results there"):
        Results.open(tmp_path)
    with pytest.raises(SettingsError, match="no photos named"):
        run([], job(tmp_path), jobs=0)


def test_interrupted_it_ends_cleanly_and_goes_on(tmp_path):
    photos = write_photos(tmp_path / "photos", 64)
    process = started(photos, tmp_path / "out", "--jobs", "2")
    wait_for_parts(tmp_path / "out", 2, process)
    process.send_signal(signal.SIGINT)
    _, said = process.communicate(timeout=120)
    assert process.returncode == 130
    assert "stopped; what was finished is kept" in said
    assert "Traceback" not in said
    assert not leftovers(tmp_path / "out")
    process = started(photos, tmp_path / "out", "--jobs", "2")
    _, said = process.communicate(timeout=300)
    assert process.returncode == 0, said
    assert Counter(r["photo"] for r in rows(tmp_path / "out")).most_common(1)[0][1] == 1
    assert len(rows(tmp_path / "out")) == 64


@pytest.mark.skipif(not Path("/proc/self/task").exists(), reason="finds workers through /proc")
def test_killed_at_random_nothing_is_lost_or_doubled(tmp_path):
    """Each round loses a worker, then the command, alone or with its workers. Long: benchmarks/robustness/kills.py."""
    photos, out = write_photos(tmp_path / "photos", 200), tmp_path / "out"
    chance = random.Random(20260101)
    for round_ in range(3):
        process = started(photos, out, "--jobs", "2")
        there = len(list(out.glob("scenes/part-*.parquet")))
        wait_for_parts(out, there + chance.randrange(1, 5), process)
        for worker in workers_of(process.pid)[:1]:
            os.kill(worker, signal.SIGKILL)
        wait_for_parts(out, there + chance.randrange(5, 12), process)
        for victim in [process.pid, *(workers_of(process.pid) if round_ else [])]:
            with contextlib.suppress(ProcessLookupError):
                os.kill(victim, signal.SIGKILL)
        process.communicate(timeout=120)
    process = started(photos, out, "--jobs", "2")
    _, said = process.communicate(timeout=300)
    assert process.returncode == 0, said
    found = rows(out)
    assert Counter(r["photo"] for r in found) == Counter(f"{i // 100:02d}/photo_{i:05d}.jpg" for i in range(200))
    assert {r["status"] for r in found} == {"ok"}
    assert not leftovers(out)


def test_a_disk_that_fills_up_is_one_line_and_nothing_half_written(tmp_path, monkeypatch):
    # The same as below on any machine: the system says so when a part's bytes are to reach the disk.
    photos, out = write_photos(tmp_path / "photos", 5), tmp_path / "out"
    room, sync = [4], os.fsync

    def sync_while_there_is_room(file):
        room[0] -= 1
        if room[0] < 0:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        sync(file)

    monkeypatch.setattr(os, "fsync", sync_while_there_is_room)
    with pytest.raises(OutputError, match="no space left; make room and run the same command again"):
        run([str(photos)], job(out), jobs=0)
    assert not leftovers(out)
    monkeypatch.undo()
    there = len(list(out.glob("scenes/part-*.parquet")))
    outcome = run([str(photos)], job(out), jobs=0)
    assert outcome.measured.photos == 5 - there
    assert len(rows(out)) == 5


@pytest.fixture
def small_disk(tmp_path):
    """Yield a folder on a disk of its own with 1 MB; only a superuser of Linux can have one."""
    disk = tmp_path / "disk"
    disk.mkdir()
    if not sys.platform.startswith("linux") or os.geteuid() != 0:
        pytest.skip("needs a superuser of Linux to mount a small disk")
    if subprocess.run(["mount", "-t", "tmpfs", "-o", "size=400k", "none", disk], capture_output=True).returncode:
        pytest.skip("a small disk cannot be mounted here")
    yield disk
    subprocess.run(["umount", "-l", disk], check=True)


def test_a_full_disk_stops_with_one_line_and_goes_on_when_there_is_room(tmp_path, small_disk):
    photos = write_photos(tmp_path / "photos", 40)
    ballast = small_disk / "ballast"
    ballast.write_bytes(b"0" * 250_000)
    process = started(photos, small_disk / "out", "--jobs", "2")
    _, said = process.communicate(timeout=300)
    assert process.returncode == 2
    problem = [line for line in said.splitlines() if line.startswith("proxemetry:")]
    assert len(problem) == 1
    assert "no space left" in problem[0]
    assert "Traceback" not in said
    assert not leftovers(small_disk / "out")
    ballast.unlink()
    subprocess.run(["mount", "-o", "remount,size=8m", small_disk], check=True)
    process = started(photos, small_disk / "out", "--jobs", "2")
    _, said = process.communicate(timeout=300)
    assert process.returncode == 0, said
    assert len(rows(small_disk / "out")) == 40
    assert not leftovers(small_disk / "out")


def fill(disk):
    """Take all the room of a disk, to the last byte."""
    with (disk / "ballast").open("wb", buffering=0) as ballast, contextlib.suppress(OSError):
        while ballast.write(b"0" * 1000):
            pass


@pytest.mark.parametrize("kind", ["spss", "xlsx", "coco"])
def test_an_export_onto_a_full_disk_is_one_line(tmp_path, small_disk, kind, capsys):
    write_photos(tmp_path / "photos", 3)
    run([str(tmp_path / "photos")], job(tmp_path / "out"), jobs=0)
    fill(small_disk)
    assert main(["export", str(tmp_path / "out"), "--format", kind, "--out", str(small_disk)]) == 2
    said = capsys.readouterr().err
    assert said.count("\n") == 1
    assert "no space left" in said
    assert sorted(p.name for p in small_disk.iterdir()) == ["ballast"]


def test_a_full_disk_for_temporary_files_is_named(tmp_path, small_disk):
    photos = write_photos(tmp_path / "photos", 3)
    fill(small_disk)
    process = started(photos, tmp_path / "out", "--jobs", "1", environment={"TMPDIR": str(small_disk)})
    _, said = process.communicate(timeout=300)
    assert "Traceback" not in said
    problem = [line for line in said.splitlines() if line.startswith("proxemetry:")]
    assert process.returncode == 0 or (len(problem) == 1 and str(small_disk) in problem[0])
    assert sorted(p.name for p in small_disk.iterdir()) == ["ballast"]


def test_beginning_anew_where_nothing_is_yet(tmp_path):
    write_photos(tmp_path / "photos", 2)
    run([str(tmp_path / "photos")], job(tmp_path / "new" / "results"), restart=True)
    assert len(rows(tmp_path / "new" / "results")) == 2


def test_workers_that_load_other_networks_than_the_first_are_refused():
    """What is fetched where it can be had may be had by one worker and not by the next."""
    require_same_networks("", {}, {"a": "1"})
    require_same_networks("blazepose", {"a": "1"}, {"a": "1"})
    for others in ({}, {"a": "2"}, {"a": "1", "b": "1"}):
        with pytest.raises(ModelError, match="workers have different networks"):
            require_same_networks("blazepose", {"a": "1"}, others)


def test_a_worker_that_ends_by_itself_is_ended_without_a_word():
    """Its command ends it as soon as it has refused: the signal may come after the work is unwound."""
    before = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)}
    ours, theirs = multiprocessing.Pipe()
    try:
        pool.serve(Job("results", "nonesuch"), theirs)
        assert signal.getsignal(signal.SIGTERM) is signal.SIG_DFL
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
    assert ours.recv()[0] == "refused"


def test_a_worker_that_follows_fetches_nothing_and_says_nothing_twice(monkeypatch, caplog):
    seen: list[bool] = []

    def measurer(job):
        seen.append(job.options.offline)
        logging.getLogger("proxemetry").warning("fewer people are found")

    monkeypatch.setattr(pool, "Measurer", measurer)
    pool._follower(Job("results", options=PoseOptions(offline=False)))
    assert seen == [True] and not caplog.records
    logging.getLogger("proxemetry").warning("heard again")
    assert [r.message for r in caplog.records] == ["heard again"]
