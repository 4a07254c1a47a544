"""A million measured photos: time until a resumed run starts, to write the tables, and to print a summary.

    python -m benchmarks.speed.archive_scale [--photos 1000000] [--folder DIR]

Photos are sparse files of different sizes, never opened since they are finished; their parts are those of 256 photos
with recorded keypoints, one to four people each, under other names and with other distances. One part is left out, so
that the run has something to begin with. What is timed are whole commands, from the start of their process: of a run
to its first photo measured, of a summary to its end. Clock times depend on what else the machine does; processor times
(of all processes of the command) show what an idle one could do. With --folder the archive is kept there and reused.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from benchmarks.speed.recorded_archive import name_of, write_keypoints
from proxemetry.archive.run.run import run
from proxemetry.archive.run.schedule import Note, Progress
from proxemetry.archive.run.work import Job
from proxemetry.archive.store import manifest, parts
from proxemetry.archive.store.duck import connection, quoted
from proxemetry.archive.store.file_state import FileState
from proxemetry.archive.store.folder import RUN_FILE, Folder
from proxemetry.archive.store.photos import search
from proxemetry.distances import ZONES
from synthetic.manifests import listed_photos

TEMPLATE = 256
_TIMES = 3


def main() -> None:
    """Run the benchmark and print what it found."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--photos", type=int, default=1_000_000)
    parser.add_argument("--folder")
    parser.add_argument("--resume", action="store_true", help=argparse.SUPPRESS)
    args = parser.parse_args()
    if args.resume:
        _resume(Path(args.folder))
    elif args.folder:
        _measure(Path(args.folder), args.photos)
    else:
        with tempfile.TemporaryDirectory() as scratch:
            _measure(Path(scratch), args.photos)


def _job(root: Path) -> Job:
    return Job(str(root / "out"), f"recorded:{root / 'keypoints.json'}")


def _resume(root: Path) -> None:
    """Go on with the run until its first photo is measured, and say when that was."""

    def on_progress(progress: Progress | Note) -> None:
        if isinstance(progress, Progress) and progress.done:
            print(time.time(), os.times().user + os.times().system, flush=True)
            os._exit(0)  # workers notice that their pipe is closed

    run([str(root / "photos")], _job(root), jobs=1, on_progress=on_progress)


def _measure(root: Path, count: int) -> None:
    out = root / "out"
    if not (out / RUN_FILE).exists():
        _make(root, count)
    there = parts.finished(Folder(out))
    size = sum(p.stat().st_size for p in (out / "scenes").iterdir())
    print(f"{count} photos in {len(there)} parts, {size / count / 1000:.2f} kB a photo in the parts")
    (out / parts.name_of(max(there))).unlink(missing_ok=True)
    for _ in range(_TIMES):
        started = time.time()
        command = [sys.executable, "-m", __spec__.name, "--resume", "--folder", root]
        when, processor = subprocess.run(command, check=True, capture_output=True, text=True).stdout.split()
        print(f"resumed: first photo after {float(when) - started:.2f} s; {float(processor):.2f} s of processor so far")
        time.sleep(2)
    started, before = time.perf_counter(), os.times()
    outcome = run([str(root / "photos")], _job(root), jobs=1)
    print(f"{outcome.measured.photos} photos and all tables: {_elapsed(started, before)}")
    tables = sum((out / f"{t}.{f}").stat().st_size for t in ("photos", "people", "pairs") for f in ("csv", "parquet"))
    print(f"tables: {tables / count / 1000:.2f} kB a photo, CSV and Parquet together")
    _timed("the same again, nothing to do", "measure", root / "photos", "--out", out, "--pose", _job(root).pose)
    for by in ("", "year", "folder"):
        _timed(f"summary by {by or 'nothing'}", "summary", out, *(["--by", by] if by else []))


def _timed(what: str, *arguments: str | Path) -> None:
    """Print the least of some times that a whole command takes."""
    taken: list[tuple[float, float]] = []
    for _ in range(_TIMES):
        started, before = time.perf_counter(), os.times()
        subprocess.run([sys.executable, "-m", "proxemetry", *arguments], check=False, capture_output=True)
        now = os.times()
        processor = sum(getattr(now, n) - getattr(before, n) for n in ("children_user", "children_system"))
        taken.append((time.perf_counter() - started, processor))
    (wall, _), (_, processor) = min(taken), min(taken, key=lambda t: t[1])
    print(f"{what}: {wall:.2f} s, {processor:.2f} s of processor (least of {_TIMES})")


def _elapsed(started: float, before: os.times_result) -> str:
    now = os.times()
    processor = sum(now[k] - before[k] for k in range(4))
    return f"{time.perf_counter() - started:.1f} s, {processor:.1f} s of processor"


def _make(root: Path, count: int) -> None:
    photos, out = root / "photos", root / "out"
    started = time.perf_counter()
    for number in range(count):
        path = photos / name_of(number)
        if number % 500 == 0:
            path.parent.mkdir(parents=True, exist_ok=True)
        if not path.exists():
            with path.open("wb") as file:
                file.truncate(number + 1)
    print(f"made {count} sparse files in {time.perf_counter() - started:.0f} s")
    write_keypoints(root / "keypoints.json", TEMPLATE)
    template = root / "template"
    run([], Job(str(template), _job(root).pose), jobs=0)
    folder = Folder(out)
    out.mkdir(exist_ok=True)
    (out / RUN_FILE).write_bytes((template / RUN_FILE).read_bytes())
    started, before = time.perf_counter(), os.times()
    listed = listed_photos(folder, search([str(photos)]))
    print(f"listed and frozen in {_elapsed(started, before)}")
    metadata = json.loads((template / RUN_FILE).read_text())["metadata"]
    _copy_parts(template, folder, listed, metadata)


def _copy_parts(template: Path, folder: Folder, listed: manifest.Manifest, metadata: dict[str, str]) -> None:
    """Write the template's rows under the names of every shard."""
    duck = connection()
    # Numbers that repeat would be read in no time: every pair gets its own.
    noise = "(hash(names.photo, p.person_a, p.person_b) % 1000003) / 1000003.0"
    numbers = ", ".join(
        f"{name} := p.{name} * ({low} + {noise} * {width})"
        for names, low, width in (
            (("distance_m", "low_m", "high_m", "distance_3d_m"), 0.8, 0.4),
            ([f"p_{zone}" for zone in ZONES], 0.999, 0.002),
        )
        for name in names
    )
    duck.execute(
        "CREATE TEMP TABLE rows AS SELECT *, row_number() OVER (ORDER BY photo) AS place FROM "
        f"read_parquet('{template}/scenes/*.parquet')"
    )
    pairs = ", ".join(f"{key}: {quoted(value)}" for key, value in metadata.items())
    (Path(folder.location) / "scenes").mkdir(exist_ok=True)
    for shard in range(listed.n_shards):
        items = listed.items(shard)
        states = [FileState.of(item.location) for item in items]
        assert None not in states
        duck.execute(
            "COPY (SELECT rows.* EXCLUDE (place) REPLACE (names.photo AS photo, sha256(names.photo) AS sha256, "
            "(1960 + hash(names.photo) % 60)::VARCHAR AS date, bytes AS file_bytes, ns AS file_modified_ns, "
            f"list_transform(pairs, lambda p: struct_update(p, {numbers})) AS pairs) FROM rows JOIN "
            "(SELECT unnest($names) AS photo, unnest($bytes) AS bytes, unnest($dates) AS ns, "
            "generate_subscripts($names, 1) AS place) names USING (place)) "
            f"TO '{folder.path(parts.name_of(shard))}' (FORMAT parquet, COMPRESSION zstd, KV_METADATA {{{pairs}}})",
            {
                "names": [item.photo for item in items],
                "bytes": [state.size for state in states if state],
                "dates": [state.modified_ns for state in states if state],
            },
        )
    duck.execute("DROP TABLE rows")


if __name__ == "__main__":
    os.environ.setdefault("OMP_NUM_THREADS", "1")
    main()
