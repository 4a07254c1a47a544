"""Photos and results behind URLs, and Ray over the same shards: nothing lost and nothing doubled there either."""

from __future__ import annotations

import contextlib
import csv
import io
import os
import signal
import subprocess
import sys
import time
from collections import Counter
from pathlib import Path

import pytest

import proxemetry
from proxemetry.archive.review.corrections import FILE, Log
from proxemetry.archive.run.run import run
from proxemetry.archive.run.work import Job
from proxemetry.archive.store.results import Results
from proxemetry.errors import SettingsError
from synthetic.small_photos import write_photos

HERE = str(Path(__file__).parents[1])
SOURCE = str(Path(proxemetry.__file__).parents[1])
TWO_PEOPLE = "python:synthetic.small_photos:two_people"


def put(filesystem, folder, photos):
    for path in sorted(photos.rglob("*.jpg")):
        filesystem.pipe_file(f"{folder}/{path.relative_to(photos).as_posix()}", path.read_bytes())


def table(filesystem, path):
    return list(csv.DictReader(io.StringIO(filesystem.cat_file(path).decode())))


def test_results_in_memory(tmp_path):
    fsspec = pytest.importorskip("fsspec")
    memory = fsspec.filesystem("memory")
    put(memory, "/archive", write_photos(tmp_path, 4))
    memory.pipe_file("/archive/copy.jpg", memory.cat_file("/archive/00/photo_00001.jpg"))
    job = Job("memory://results", TWO_PEOPLE)
    try:
        assert not run(["memory://archive"], job, jobs=0, shard=(1, 2)).complete
        assert run(["memory://archive"], job, jobs=0).complete
        rows = table(memory, "/results/photos.csv")
        assert [r["photo"] for r in rows] == [*(f"00/photo_0000{i}.jpg" for i in range(4)), "copy.jpg"]
        assert {r["status"] for r in rows} == {"ok"}
        assert len(list(Results.open("memory://results").scenes())) == 5
        run(["memory://archive"], job, jobs=0, restart=True)
        assert len(table(memory, "/results/photos.csv")) == 5
    finally:
        memory.rm("/", recursive=True)


def test_corrections_beside_results_in_memory_are_applied_after_every_rerun(tmp_path):
    fsspec = pytest.importorskip("fsspec")
    memory = fsspec.filesystem("memory")
    put(memory, "/archive", write_photos(tmp_path / "photos", 2))
    job = Job("memory://results", TWO_PEOPLE)
    try:
        run(["memory://archive"], job, jobs=0)
        before = table(memory, "/results/pairs.csv")
        # Reviewed in a copy on this machine; the log is put back beside the results.
        log = Log(tmp_path / FILE)
        log.append(next(Results.open("memory://results").scenes()), "set_camera", {"focal_px": 100.0}, "ann")
        log.close()
        memory.put_file(str(tmp_path / FILE), f"/results/{FILE}")
        assert run(["memory://archive"], job, jobs=0).measured.photos == 0
        after = table(memory, "/results/pairs.csv")
        assert after[0]["distance_m"] != before[0]["distance_m"]
        assert after[1:] == before[1:]
        assert table(memory, "/results/photos.csv")[0]["corrections"] == "1"
        run(["memory://archive"], job, jobs=0, restart=True)
        assert table(memory, "/results/pairs.csv") == after
    finally:
        memory.rm("/", recursive=True)


def test_a_file_url_is_a_local_folder(tmp_path):
    photos = write_photos(tmp_path / "photos", 2)
    run([f"file://{photos}"], Job(f"file://{tmp_path}/out", TWO_PEOPLE), jobs=0)
    assert (tmp_path / "out" / "pairs.csv").exists()


def test_local_and_remote_photos_do_not_mix(tmp_path):
    pytest.importorskip("fsspec")
    with pytest.raises(SettingsError, match="run twice"):
        run([str(write_photos(tmp_path, 1)), "memory://archive"], Job(str(tmp_path / "out"), TWO_PEOPLE), jobs=0)


@pytest.mark.cluster
def test_a_store_that_speaks_s3(tmp_path, monkeypatch):
    pytest.importorskip("s3fs")
    server_module = pytest.importorskip("moto.server")
    import fsspec

    server = server_module.ThreadedMotoServer(ip_address="127.0.0.1", port=0, verbose=False)
    server.start()
    try:
        host, port = server.get_host_and_port()
        for name, value in {
            "AWS_ENDPOINT_URL": f"http://{host}:{port}", "AWS_ACCESS_KEY_ID": "test", "AWS_SECRET_ACCESS_KEY": "test",
            "AWS_DEFAULT_REGION": "us-east-1",
        }.items():  # fmt: skip
            monkeypatch.setenv(name, value)
        fsspec.config.conf.clear()
        s3 = fsspec.filesystem("s3", skip_instance_cache=False)
        s3.mkdir("archive")
        s3.mkdir("results")
        put(s3, "archive/photos", write_photos(tmp_path, 5))
        job = Job("s3://results/run", TWO_PEOPLE)
        assert run(["s3://archive/photos"], job, jobs=2).complete
        assert run(["s3://archive/photos"], job, jobs=0).measured.photos == 0
        rows = table(s3, "results/run/photos.csv")
        assert [r["photo"] for r in rows] == [f"00/photo_0000{i}.jpg" for i in range(5)]
        assert {r["status"] for r in rows} == {"ok"}
        assert not [name for name in s3.find("results") if name.endswith(".tmp")]
    finally:
        server.stop()
        fsspec.filesystem("s3").clear_instance_cache()


def _ray_run(photos, out, *arguments):
    return subprocess.Popen(
        [sys.executable, "-m", "proxemetry", "measure", photos, "--out", out, "--pose", TWO_PEOPLE, "--engine", "ray",
         "--jobs", "2", *arguments],
        env={**os.environ, "PYTHONPATH": os.pathsep.join([HERE, SOURCE]), "RAY_LOG_TO_STDERR": "0"},
        stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, start_new_session=True,
    )  # fmt: skip


def _wait_for_parts(out, count, process):
    until = time.monotonic() + 180
    while len(list(Path(out).glob("scenes/part-*.parquet"))) < count:
        assert process.poll() is None
        assert time.monotonic() < until
        time.sleep(0.02)


def _actors():
    """Return the process ids of Ray's actors of this kind, by the title that Ray gives them."""
    found = []
    for path in Path("/proc").glob("[0-9]*/cmdline"):
        with contextlib.suppress(OSError):
            if path.read_bytes().startswith(b"ray::_Actor"):
                found.append(int(path.parent.name))
    return found


@pytest.mark.cluster
@pytest.mark.skipif(not Path("/proc/self/cmdline").exists(), reason="finds actors through /proc")
def test_ray_survives_a_killed_actor_and_a_killed_driver(tmp_path):
    pytest.importorskip("ray")
    photos, out = write_photos(tmp_path / "photos", 120), tmp_path / "out"
    before = set(_actors())
    driver = _ray_run(photos, out)
    _wait_for_parts(out, 4, driver)
    driver.kill()
    driver.wait()
    with contextlib.suppress(ProcessLookupError):  # the cluster that it had started goes with it
        os.killpg(driver.pid, signal.SIGKILL)
    there = len(list(out.glob("scenes/part-*.parquet")))
    assert there < 60
    driver = _ray_run(photos, out)
    _wait_for_parts(out, there + 2, driver)
    for actor in set(_actors()) - before:
        with contextlib.suppress(ProcessLookupError):
            os.kill(actor, signal.SIGKILL)
            break
    assert driver.wait(timeout=300) == 0
    with (out / "photos.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert Counter(r["photo"] for r in rows) == Counter(f"{i // 100:02d}/photo_{i:05d}.jpg" for i in range(120))
    assert {r["status"] for r in rows} == {"ok"}
    assert not [p for p in out.rglob("*") if p.name.startswith(".")]
