"""Photos per second with one worker and with two, with one thread each and with the runtimes' own choice of threads.

    python -m benchmarks.speed.throughput PHOTOS [--photos 39] [--pose auto] [--effort normal]

PHOTOS is a folder of real photos; they are repeated, each file made different by bytes after its end. Every line is
a run in processes of its own, timed from the first tenth of its photos until a worker has nothing left to do. It gives
clock time and the workers' processor time a photo. The latter says more on a shared machine: where it stays the same,
throughput grows with the number of workers up to the number of cores. The share of time outside decoding and inference
is of one process, in processor time: everything that is not inside `Photo.pixels` or the back end's `detect`, writing
parts and tables included. Linux only (reads /proc). For memory see `worker_memory.py`.
"""

from __future__ import annotations

import argparse
import itertools
import json
import multiprocessing
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

from proxemetry.archive.run import pool
from proxemetry.archive.run.run import run
from proxemetry.archive.run.schedule import Note, Progress
from proxemetry.archive.run.work import Job, Measurer
from proxemetry.photo import EXTENSIONS, Photo
from proxemetry.pose import PoseOptions

_ONE_THREAD = dict.fromkeys(
    ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "OPENCV_FOR_THREADS_NUM"), "1"
)


def main() -> None:
    """Run the benchmark and print what it found."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("source", metavar="PHOTOS", type=Path)
    parser.add_argument("--photos", type=int, default=39)
    parser.add_argument("--pose", default="auto")
    parser.add_argument("--effort", default="normal")
    parser.add_argument("--one", choices=("shares", "rate"), help=argparse.SUPPRESS)
    parser.add_argument("--jobs", type=int, default=1, help=argparse.SUPPRESS)
    parser.add_argument("--own-threads", action="store_true", help=argparse.SUPPRESS)
    args = parser.parse_args()
    with tempfile.TemporaryDirectory() as scratch:
        job = Job(f"{scratch}/out", args.pose, PoseOptions(effort=args.effort))
        if args.one == "shares":
            _shares(args.source, job)
        elif args.one == "rate":
            print(json.dumps(_rate(args.source, job, args.jobs, args.own_threads)))
        else:
            photos = Path(scratch) / "photos"
            _repeated(args.source, photos, args.photos)
            _compare(photos, args)


def _compare(photos: Path, args: argparse.Namespace) -> None:
    again = [sys.executable, "-m", __spec__.name, photos, "--pose", args.pose, "--effort", args.effort]
    others = {name: value for name, value in os.environ.items() if name not in _ONE_THREAD}
    print(f"{args.photos} photos, {args.pose}, {args.effort}; {os.cpu_count()} cores, load {os.getloadavg()[0]:.1f}")
    subprocess.run([*again, "--one", "shares"], env={**others, **_ONE_THREAD}, check=True)
    rates: dict[tuple[int, bool], float] = {}
    for own_threads, jobs in itertools.product((False, True), (1, 2)):
        extra = ["--own-threads"] if own_threads else []
        said = subprocess.run(
            [*again, "--one", "rate", "--jobs", str(jobs), *extra], env=others, check=True, stdout=subprocess.PIPE
        )
        rates[jobs, own_threads], processor = json.loads(said.stdout)
        threads = "as many threads as the runtimes take" if own_threads else "one thread each"
        print(
            f"{jobs} worker{'s' * (jobs > 1)}, {threads}: {rates[jobs, own_threads]:.3f} photos/s, {processor:.3f} s "
            f"of processor a photo; load {os.getloadavg()[0]:.1f}",
            flush=True,
        )
    print(f"two workers against one, one thread each: {rates[2, False] / rates[1, False]:.2f}x")
    print(f"two workers, the runtimes' threads against one each: {rates[2, True] / rates[2, False]:.2f}x")


def _repeated(source: Path, target: Path, count: int) -> None:
    target.mkdir()
    files = sorted(p for p in source.iterdir() if p.suffix.lower() in EXTENSIONS)
    for number, file in zip(range(count), itertools.cycle(files), strict=False):
        # Bytes after a photo's end change its hash and nothing else.
        (target / f"{number:05d}_{file.name}").write_bytes(file.read_bytes() + str(number).encode())


def _rate(photos: Path, job: Job, jobs: int, own_threads: bool) -> tuple[float, float]:
    """Return photos per second, and the workers' processor seconds a photo; starting and loading are not in them."""
    seen: list[tuple[float, float, int]] = []

    def on_progress(progress: Progress | Note) -> None:
        if isinstance(progress, Progress) and (not seen or progress.done > seen[-1][2]):
            seen.append((time.perf_counter(), _processor(), progress.done))

    if own_threads:
        pool.quiet_threads = lambda job: job
    run([str(photos)], job, jobs=jobs, on_progress=on_progress)
    total = seen[-1][2]
    start = next(i for i, (_, _, done) in enumerate(seen) if done >= total / 10)
    # The last photos leave workers idle one by one: the end is when the first of them had nothing more to do.
    end = max(i for i, (_, _, done) in enumerate(seen) if done <= total - jobs)
    seconds, processor, done = (b - a for a, b in zip(seen[start], seen[end], strict=True))
    return done / seconds, processor / done


def _processor() -> float:
    """Return the processor seconds of all workers so far."""
    ticks = 0
    for child in multiprocessing.active_children():
        fields = Path(f"/proc/{child.pid}/stat").read_text().rpartition(")")[2].split()
        ticks += int(fields[11]) + int(fields[12])
    return ticks / os.sysconf("SC_CLK_TCK")


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


def _shares(photos: Path, job: Job) -> None:
    pixels, detections = _Timed(Photo.pixels), list[_Timed]()
    loaded = Measurer.__init__

    def timed_init(self: Measurer, job: Job) -> None:
        loaded(self, job)
        backend: Any = self.backend
        detections.append(_Timed(backend.detect))
        backend.detect = detections[0]
        starts.append(time.process_time())

    starts: list[float] = []
    Photo.pixels = lambda self, *a, **k: pixels(self, *a, **k)  # type: ignore[method-assign]
    Measurer.__init__ = timed_init  # type: ignore[method-assign]
    outcome = run([str(photos)], job, jobs=0)
    whole = time.process_time() - starts[0]
    inside = pixels.seconds + detections[0].seconds
    print(
        f"one process: {whole / outcome.photos:.3f} s of processor a photo, {1 - inside / whole:.1%} outside decoding "
        f"and inference ({(whole - inside) / outcome.photos * 1000:.0f} ms), tables included",
        flush=True,
    )


if __name__ == "__main__":
    main()
