"""Memory of one worker over many photos, in a run of `proxemetry measure --jobs 1`; a line every so often.

    python -m benchmarks.robustness.worker_memory PHOTOS [--photos 20000] [--side 320] [--pose auto] [--effort fast]

PHOTOS is a folder of real photos. They are shrunk to several sizes of at most `--side` pixels and repeated, each file
made its own by bytes after its end, so that decoding, networks and placing meet what they meet in an archive in
reasonable time. `--side 0` takes the photos as they are. `--pose recorded` needs no network: keypoints of one to four
people in each photo are written first. Prints what the worker holds now, the most it ever held, and the growth from
the first tenth to the end. Linux only (reads /proc).
"""

from __future__ import annotations

import argparse
import multiprocessing
import tempfile
import time
from collections.abc import Iterator
from io import BytesIO
from pathlib import Path

from PIL import Image, ImageOps

from benchmarks.robustness.process_memory import memory_bytes
from benchmarks.speed.recorded_archive import write_keypoints, write_photos
from proxemetry.archive.run.run import run
from proxemetry.archive.run.schedule import Note, Progress
from proxemetry.archive.run.work import Job
from proxemetry.photo import EXTENSIONS
from proxemetry.pose import PoseOptions

_LINES = 40
#: A worker that met large photos first would look flat whatever came after: sizes follow each other, largest last.
_SIZES = (0.6, 0.8, 1.0)


def main() -> None:
    """Run the benchmark and print what it found."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("source", metavar="PHOTOS", type=Path)
    parser.add_argument("--photos", type=int, default=20_000)
    parser.add_argument("--side", type=int, default=320)
    parser.add_argument("--pose", default="auto")
    parser.add_argument("--effort", default="fast")
    args = parser.parse_args()
    with tempfile.TemporaryDirectory() as scratch:
        photos, pose = Path(scratch) / "photos", args.pose
        if pose == "recorded":
            write_photos(photos, args.photos)
            write_keypoints(Path(scratch) / "keypoints.json", args.photos)
            pose = f"recorded:{scratch}/keypoints.json"
        else:
            _write(list(_variants(args.source, args.side)), photos, args.photos)
        _watch(photos, Job(f"{scratch}/out", pose, PoseOptions(effort=args.effort)), args.photos)


def _variants(source: Path, side: int) -> Iterator[bytes]:
    files = sorted(p for p in source.iterdir() if p.suffix.lower() in EXTENSIONS)
    if not side:
        yield from (file.read_bytes() for file in files)
        return
    for size in _SIZES:
        for file in files:
            with Image.open(file) as image:
                small = ImageOps.exif_transpose(image).convert("RGB")
            small.thumbnail((round(size * side), round(size * side)))
            buffer = BytesIO()
            small.save(buffer, "jpeg", quality=85)
            yield buffer.getvalue()


def _write(variants: list[bytes], folder: Path, count: int) -> None:
    for number in range(count):
        path = folder / f"{number // 500:04d}" / f"photo_{number:07d}.jpg"
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(variants[number % len(variants)] + number.to_bytes(8, "big"))


def _watch(photos: Path, job: Job, count: int) -> None:
    every = max(1, count // _LINES)
    held: list[tuple[int, float]] = []
    started = time.monotonic()

    def on_progress(progress: Progress | Note) -> None:
        if (
            isinstance(progress, Note)
            or not progress.done
            or (progress.done % every and progress.done != count)
            or (held and held[-1][0] == progress.done)
        ):
            return
        (worker,) = multiprocessing.active_children()
        now, most = memory_bytes(worker.pid or 0)
        held.append((progress.done, now))
        print(
            f"{progress.done:7d} photos: {now:.0f} MB now, {most:.0f} MB at most; "
            f"{(time.monotonic() - started) / 60:.1f} min",
            flush=True,
        )

    outcome = run([str(photos)], job, jobs=1, on_progress=on_progress)
    early = [mb for done, mb in held if done <= max(count / 10, held[0][0])]
    late = [mb for done, mb in held if done >= count * 0.9]
    print(
        f"{outcome.photos} photos, {outcome.measured.people} people, {outcome.measured.failed} failed; mean of the "
        f"first tenth {sum(early) / len(early):.0f} MB, of the last {sum(late) / len(late):.0f} MB"
    )


if __name__ == "__main__":
    main()
