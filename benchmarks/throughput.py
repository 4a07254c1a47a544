"""Photos per second with one worker and with two, what a worker spends its time on, and its memory over many photos.

    python benchmarks/throughput.py PHOTOS [--pose auto] [--repeat 8] [--memory-photos 20000]

PHOTOS is a folder of real photos; they are linked `--repeat` times, each file made its own by bytes after its end.
The share of time outside decoding and inference is of one process, in processor time: everything that is not inside
`Photo.pixels` or the back end's `detect`, writing the part included. Memory is that of one process over small photos
with recorded keypoints (decoding and placing without a network) unless `--memory-pose` names a back end.
"""

from __future__ import annotations

import argparse
import os
import resource
import tempfile
import time
from pathlib import Path
from typing import Any

from recorded_archive import write_keypoints, write_photos

from proxemetry.archive.run import run
from proxemetry.archive.schedule import Progress
from proxemetry.archive.work import Job, Measurer
from proxemetry.photo import EXTENSIONS, Photo


def main() -> None:
    """Run the benchmark and print what it found."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("photos", type=Path)
    parser.add_argument("--pose", default="auto")
    parser.add_argument("--repeat", type=int, default=8)
    parser.add_argument("--memory-photos", type=int, default=20_000)
    args = parser.parse_args()
    os.environ.setdefault("OMP_NUM_THREADS", "1")
    with tempfile.TemporaryDirectory() as scratch:
        photos = Path(scratch) / "photos"
        count = _repeated(args.photos, photos, args.repeat)
        _shares(photos, Path(scratch) / "shares", args.pose)
        rates = {jobs: _rate(photos, Path(scratch) / f"out{jobs}", args.pose, jobs) for jobs in (1, 2)}
        print(
            f"{count} photos: {rates[1]:.3f} photos/s with 1 worker, {rates[2]:.3f} with 2: {rates[2] / rates[1]:.2f}x"
        )
        if args.memory_photos:
            _memory(Path(scratch), args.memory_photos)


def _repeated(source: Path, target: Path, repeat: int) -> int:
    target.mkdir()
    files = sorted(p for p in source.iterdir() if p.suffix.lower() in EXTENSIONS)
    for number in range(repeat):
        for file in files:  # bytes after a photo's end change its hash and nothing else
            (target / f"{number:03d}_{file.name}").write_bytes(file.read_bytes() + str(number).encode())
    return repeat * len(files)


def _rate(photos: Path, out: Path, pose: str, jobs: int) -> float:
    """Return photos per second between the first tenth and the end: starting and loading are not in it."""
    seen: list[tuple[float, int]] = []

    def tell(progress: Progress) -> None:
        seen.append((time.perf_counter(), progress.done))

    run([str(photos)], Job(str(out), pose), jobs=jobs, tell=tell)
    start = next(i for i, (_, done) in enumerate(seen) if done >= seen[-1][1] / 10)
    # The last photos leave workers idle one by one: the end is when the first of them had nothing more to do.
    end = max(i for i, (_, done) in enumerate(seen) if done <= seen[-1][1] - jobs)
    return (seen[end][1] - seen[start][1]) / (seen[end][0] - seen[start][0])


class _Timed:
    """A callable that adds up the processor time spent inside it, its own recursion and other timed calls left out."""

    inside = 0

    def __init__(self, function: Any) -> None:
        self.function, self.seconds = function, 0.0

    def __call__(self, *args: Any, **kwargs: Any) -> Any:
        if _Timed.inside:
            return self.function(*args, **kwargs)
        _Timed.inside += 1
        started = time.process_time()
        try:
            return self.function(*args, **kwargs)
        finally:
            self.seconds += time.process_time() - started
            _Timed.inside -= 1


def _shares(photos: Path, out: Path, pose: str) -> None:
    pixels, detections = _Timed(Photo.pixels), list[_Timed]()
    loaded = Measurer.__init__

    def timed_init(self: Measurer, job: Job) -> None:
        loaded(self, job)
        backend: Any = self.backend
        detections.append(_Timed(backend.detect))
        backend.detect = detections[0]
        starts.append(time.process_time())

    starts: list[float] = []
    original = Photo.pixels
    Photo.pixels = lambda self, *a, **k: pixels(self, *a, **k)  # type: ignore[method-assign]
    Measurer.__init__ = timed_init  # type: ignore[method-assign]
    try:
        outcome = run([str(photos)], Job(str(out), pose), jobs=0)
    finally:
        Photo.pixels, Measurer.__init__ = original, loaded  # type: ignore[method-assign]
    whole = time.process_time() - starts[0]
    inside = pixels.seconds + detections[0].seconds
    print(
        f"one process: {whole / outcome.photos:.3f} s of processor a photo, {1 - inside / whole:.1%} outside decoding "
        f"and inference ({(whole - inside) / outcome.photos * 1000:.0f} ms), tables included"
    )


def _memory(scratch: Path, count: int) -> None:
    photos, keypoints = scratch / "small", scratch / "keypoints.json"
    write_photos(photos, count)
    write_keypoints(keypoints, count)
    peaks: list[str] = []

    def tell(progress: Progress) -> None:
        if progress.done % (count // 5) == 0:
            peaks.append(f"{progress.done}: {resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e3:.0f} MB")

    run([str(photos)], Job(str(scratch / "memory"), f"recorded:{keypoints}"), jobs=0, tell=tell)
    print(f"peak memory of one process after so many photos: {', '.join(peaks)}")


if __name__ == "__main__":
    main()
