"""A million finished photos: how long a resumed run takes to begin, the tables to be made, a summary to be read.

    python benchmarks/archive_scale.py [--photos 1000000] [--folder DIR]

Photos are sparse files of different sizes, never opened since they are finished; their parts are those of 256 photos
with recorded keypoints, one to four people each, under other names. One part is left out, so that the run has
something to begin with: what is timed is from the command's start to its first photo. With --folder the archive is
kept there and used again.
"""

from __future__ import annotations

import argparse
import json
import os
import resource
import tempfile
import time
from pathlib import Path

from recorded_archive import name_of, write_keypoints

from proxemetry.archive import manifest, parts
from proxemetry.archive.folder import Folder
from proxemetry.archive.photos import find_photos
from proxemetry.archive.results import RUN_FILE, Results
from proxemetry.archive.run import run
from proxemetry.archive.schedule import Progress
from proxemetry.archive.summary import summarise
from proxemetry.archive.work import Job

TEMPLATE = 256


def main() -> None:
    """Run the benchmark and print what it found."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--photos", type=int, default=1_000_000)
    parser.add_argument("--folder")
    args = parser.parse_args()
    if args.folder:
        _measure(Path(args.folder), args.photos)
        return
    with tempfile.TemporaryDirectory() as scratch:
        _measure(Path(scratch), args.photos)


def _measure(root: Path, count: int) -> None:
    photos, out, keypoints = root / "photos", root / "out", root / "keypoints.json"
    job = Job(str(out), f"recorded:{keypoints}")
    if not (out / RUN_FILE).exists():
        _make(root, photos, out, keypoints, job, count)
    parts_there = parts.finished(Folder(out))
    size = sum(p.stat().st_size for p in (out / "scenes").iterdir())
    print(f"{count} photos in {len(parts_there)} parts, {size / count / 1000:.2f} kB a photo in the parts")
    last = max(parts_there)
    (out / parts.name_of(last)).unlink()
    first: list[float] = []
    started = time.perf_counter()

    def tell(progress: Progress) -> None:
        first.append(time.perf_counter() - started)

    outcome = run([str(photos)], job, jobs=1, tell=tell)
    whole = time.perf_counter() - started
    print(f"resumed: first photo after {first[0]:.2f} s; {outcome.measured.photos} photos and all tables {whole:.1f} s")
    tables = sum((out / f"{t}.{f}").stat().st_size for t in ("photos", "people", "pairs") for f in ("csv", "parquet"))
    print(f"tables: {tables / count / 1000:.2f} kB a photo, CSV and Parquet together")
    for by in ([], ["year"], ["folder"]):
        times = []
        for _ in range(3):
            started = time.perf_counter()
            groups = len(summarise(Results.open(out), by).groups)
            times.append(time.perf_counter() - started)
        print(f"summary by {by or 'nothing'}: {groups} groups, {min(times):.2f} s (least of 3)")
    print(f"peak memory of this process: {resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e3:.0f} MB")


def _make(root: Path, photos: Path, out: Path, keypoints: Path, job: Job, count: int) -> None:
    started = time.perf_counter()
    for number in range(count):
        path = photos / name_of(number)
        if number % 500 == 0:
            path.parent.mkdir(parents=True, exist_ok=True)
        with path.open("wb") as file:
            file.truncate(number + 1)
    print(f"made {count} sparse files in {time.perf_counter() - started:.0f} s")
    write_keypoints(keypoints, TEMPLATE)
    template = root / "template"
    run([], Job(str(template), job.pose), jobs=0)
    folder = Folder(out)
    out.mkdir(exist_ok=True)
    (out / RUN_FILE).write_bytes((template / RUN_FILE).read_bytes())
    started = time.perf_counter()
    listed = manifest.frozen(folder, find_photos([str(photos)]))
    print(f"listed and frozen in {time.perf_counter() - started:.1f} s")
    metadata = json.loads((template / RUN_FILE).read_text())["metadata"]
    _copy_parts(template, folder, listed, metadata)


def _copy_parts(template: Path, folder: Folder, listed: manifest.Manifest, metadata: dict[str, str]) -> None:
    """Write the template's rows under the names of every shard."""
    duck = parts.connection()
    duck.execute(
        "CREATE TEMP TABLE rows AS SELECT *, row_number() OVER (ORDER BY photo) AS place FROM "
        f"read_parquet('{template}/scenes/*.parquet')"
    )
    pairs = ", ".join(f"{key}: {parts.quoted(value)}" for key, value in metadata.items())
    (Path(folder.location) / "scenes").mkdir(exist_ok=True)
    for shard in range(listed.n_shards):
        names = [item.photo for item in listed.items(shard)]
        duck.execute(
            "COPY (SELECT rows.* EXCLUDE (place) REPLACE (names.photo AS photo, sha256(names.photo) AS sha256, "
            "(1960 + hash(names.photo) % 60)::VARCHAR AS date) FROM rows JOIN "
            "(SELECT unnest($names) AS photo, generate_subscripts($names, 1) AS place) names USING (place)) "
            f"TO '{folder.path(parts.name_of(shard))}' (FORMAT parquet, COMPRESSION zstd, KV_METADATA {{{pairs}}})",
            {"names": names},
        )
    duck.execute("DROP TABLE rows")


if __name__ == "__main__":
    os.environ.setdefault("OMP_NUM_THREADS", "1")
    main()
