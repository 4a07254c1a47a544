"""Processor time that `measure --overlays` adds to a photo, beside what measuring the same photos takes.

    python -m benchmarks.speed.drawing_cost PHOTOS [--pose auto] [--repeats 3]

PHOTOS is a folder of real photos. One thread where `OMP_NUM_THREADS=1` is set. Every round is a process of its own, in
which each photo is drawn once: texts that were laid out before would be cheaper. The first photo, with which matplotlib
and its fonts are loaded, is said apart, and so are decoding the photo, laying the figure out and writing its file. The
round that took least counts: other programs of the machine only add.
"""

from __future__ import annotations

import argparse
import multiprocessing
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar

from proxemetry import plots
from proxemetry.archive.run.run import run
from proxemetry.archive.run.work import Job
from proxemetry.archive.store.results import Results
from proxemetry.photo import Photo
from proxemetry.scene import Scene

_T = TypeVar("_T")


def main() -> None:
    """Run the benchmark and print what it found."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("source", metavar="PHOTOS", type=Path)
    parser.add_argument("--pose", default="auto")
    parser.add_argument("--repeats", type=int, default=3)
    args = parser.parse_args()
    with tempfile.TemporaryDirectory() as scratch:
        _, seconds = _timed(lambda: run([str(args.source)], Job(f"{scratch}/out", args.pose), jobs=0))
        scenes = _scenes(scratch)
        people = sum(len(scene) for scene, _ in scenes) / len(scenes)
        measuring = 1000 * seconds / len(scenes)
        print(f"{len(scenes)} photos, {people:.1f} people each: measuring {measuring:.0f} ms a photo")
        with multiprocessing.get_context("spawn").Pool(1, maxtasksperchild=1) as pool:
            rounds = pool.map(_round, [scratch] * args.repeats, chunksize=1)
    first, *least = (1000 * part for part in min(rounds, key=lambda parts: sum(parts[1:])))
    print(
        f"drawing {sum(least):.0f} ms a photo: decoding {least[0]:.0f}, layout {least[1]:.0f}, writing {least[2]:.0f}; "
        f"the first photo, matplotlib's loading included, {first:.0f} ms"
    )


def _scenes(scratch: str) -> list[tuple[Scene, str | None]]:
    results = Results.open(f"{scratch}/out")
    return [(s, results.location(s.photo)) for s in results.scenes() if s.status in ("ok", "no_camera")]


def _round(scratch: str) -> tuple[float, ...]:
    """Draw all photos once; return the seconds of the first, and decoding, layout and writing of each further one."""
    scenes = _scenes(scratch)
    _, first = _timed(lambda: _drawn(*scenes[0], Path(scratch)))
    parts = [_drawn(scene, location, Path(scratch)) for scene, location in scenes[1:]]
    return first, *(sum(seconds) / len(parts) for seconds in zip(*parts, strict=True))


def _drawn(scene: Scene, location: str | None, folder: Path) -> tuple[float, float, float]:
    """Draw a scene as `measure --overlays` does; return the seconds of its three parts."""
    assert location is not None
    photo, opened = _timed(lambda: Photo.open(location, scene.photo))
    decode, decoding = photo.pixels, list[float]()

    def timed_pixels(*args: Any, **options: Any) -> Any:
        pixels, seconds = _timed(lambda: decode(*args, **options))
        decoding.append(seconds)
        return pixels

    object.__setattr__(photo, "pixels", timed_pixels)
    figure, laid_out = _timed(lambda: plots.overlay(scene, photo))
    _, written = _timed(lambda: plots.save(figure, folder / Path(scene.photo).name))
    return opened + sum(decoding), laid_out - sum(decoding), written


def _timed(work: Callable[[], _T]) -> tuple[_T, float]:
    started = time.process_time()
    return work(), time.process_time() - started


if __name__ == "__main__":
    main()
