"""Processor time of the scene fit by the number of people, and of the paper's combined estimator in the same run.

    python -m benchmarks.speed.fit_cost [--photos 16] [--repeats 10]

Synthetic groups in front of all cameras (`synthetic/scenes.py`), seated or standing, so that people have several
explanations. Processor time of one core, the least of several repeats a photo; over the photos the least, the median,
the ninth decile and the most. On a busy machine the ratio to the other's median says more than milliseconds.
"""

from __future__ import annotations

import os

os.environ.setdefault("OMP_NUM_THREADS", "1")  # before NumPy is loaded: one core

import argparse
import itertools
import time
from collections.abc import Iterator

import numpy as np

from proxemetry.locate import LocateSettings, method_named
from synthetic.scenes import Recipe, SyntheticPhoto, scenes

SEED = 3000
COUNTS = (1, 2, 6, 20, 50)
FOCAL_MM = (24.0, 35.0, 50.0, 85.0)


def photos_with(count: int) -> Iterator[SyntheticPhoto]:
    """Yield photos in which at least so many people were detected."""
    most = max(3, count * 3 // 2)
    recipe = Recipe(people=(max(2, count), most), focal_mm=FOCAL_MM)
    return (photo for photo in scenes(10_000, SEED, recipe) if len(photo.people) >= count)


def least_ms(method: str, photo: SyntheticPhoto, count: int, repeats: int) -> float:
    """Return the least processor time that placing the photo's first people took, milliseconds."""
    locate, people, settings = method_named(method), photo.people[np.arange(count)], LocateSettings()
    times: list[float] = []
    for _ in range(repeats):
        started = time.process_time()
        locate(people, photo.camera, settings)
        times.append(time.process_time() - started)
    return 1000 * min(times)


def main() -> None:
    """Print a line a number of people."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--photos", type=int, default=16)
    parser.add_argument("--repeats", type=int, default=10)
    args = parser.parse_args()
    print(f"{'people':>6}{'least':>8}{'median':>8}{'90 %':>8}{'most':>8}  ms{'combined':>10}{'ratio':>8}")
    for count in COUNTS:
        photos = list(itertools.islice(photos_with(count), args.photos))
        scene = np.array([least_ms("scene", photo, count, args.repeats) for photo in photos])
        peer = float(np.median([least_ms("combined", photo, count, args.repeats) for photo in photos]))
        figures = (scene.min(), np.median(scene), np.quantile(scene, 0.9), scene.max())
        print(f"{count:6d}" + "".join(f"{value:8.1f}" for value in figures)
              + f"    {peer:10.2f}{np.median(scene) / peer:8.0f}")  # fmt: skip


if __name__ == "__main__":
    main()
