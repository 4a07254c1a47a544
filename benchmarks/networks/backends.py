"""What every pose back end at hand finds on labelled photos, how long it takes, and what depths come of it.

    python -m benchmarks.networks.backends --photos DIR [--models DIR] [--street DIR] [--pose A,B] [--effort normal]

DIR holds photos and people.json: for each photo its people with head and mid-shoulder in pixels, a box and a difficulty
(clear or hard), and zones of real but unlabelled people. A person is found where a result's head and mid-shoulder both
lie within one head-to-shoulder distance of a label's; another result inside a labelled box is a double, any other one
false, but for small ones in those zones. With --street the depth errors of street.py follow.

Times are of the machine it runs on: wall clock and processor of one photo at a time with two threads, and photos a
second of one and of two processes with one thread each, with the milliseconds a photo that this comes to. What an
archive takes on two cores is the last of these.
"""

from __future__ import annotations

import argparse
import json
import multiprocessing
import os
import time
from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.accuracy.street import check, read_streets, report
from benchmarks.networks.networks_at_hand import add_models_option
from proxemetry.arrays import FloatArray
from proxemetry.people import People, PoseBackend
from proxemetry.photo import EXTENSIONS, Photo
from proxemetry.pose import PoseOptions, available, backend_named


def counts(people: People, labels: Mapping[str, Any]) -> Counter[str]:
    """Return how many labelled people were found by difficulty, and how many results are doubles or false."""
    truth = labels["people"]
    result = Counter({f"{label['difficulty']}_found": 0 for label in truth})
    result.update(label["difficulty"] for label in truth)
    for verdict in verdicts(people, labels):
        result[f"{verdict}_found" if verdict in ("clear", "hard") else verdict] += 1
    return result


def verdicts(people: People, labels: Mapping[str, Any]) -> list[str]:
    """Return what each result is: the difficulty of the label it found, "double", "false" or "unlabelled"."""
    truth = labels["people"]
    heads, shoulders, torsos = people.part("Head"), people.part("Shoulder"), people.part("Torso")
    found = _matched(heads, shoulders, truth)

    def of(row: int) -> str:
        if row in found:
            return truth[found[row]]["difficulty"]
        torso_px = 2 * float(np.linalg.norm(shoulders[row] - torsos[row]))
        if any(_inside(heads[row], zone[:4]) and not torso_px >= zone[4] for zone in labels["ignore"]):
            return "unlabelled"
        return "double" if any(_inside(shoulders[row], label["box"]) for label in truth) else "false"

    return [of(row) for row in range(len(people))]


def _matched(heads: FloatArray, shoulders: FloatArray, truth: Sequence[Mapping[str, Any]]) -> dict[int, int]:
    """Return row of the result -> row of the label, nearest first, one to one."""
    pairs: list[tuple[float, int, int]] = []
    for j, label in enumerate(truth):
        x0, y0, x1, y1 = label["box"]
        neck = np.linalg.norm(np.subtract(label["head"], label["mid_shoulder"]))
        reach = max(float(neck), 0.12 * min(y1 - y0, 3 * (x1 - x0)))
        of_heads = np.linalg.norm(heads - label["head"], axis=1) / reach
        of_shoulders = np.linalg.norm(shoulders - label["mid_shoulder"], axis=1) / reach
        near = np.flatnonzero((of_heads < 1) & (of_shoulders < 1))
        pairs.extend((float(of_heads[i] + of_shoulders[i]), int(i), j) for i in near)
    taken: dict[int, int] = {}
    for _, i, j in sorted(pairs):
        if i not in taken and j not in taken.values():
            taken[i] = j
    return taken


def _inside(point: FloatArray, box: Sequence[float]) -> bool:
    return bool(box[0] <= point[0] <= box[2] and box[1] <= point[1] <= box[3])


def photos_in(folder: Path) -> list[Path]:
    """Return the photos of a folder, in order."""
    return sorted(path for path in folder.iterdir() if path.suffix.lower() in EXTENSIONS)


def count_line(backend: PoseBackend, folder: Path) -> str:
    """Return one back end's row of the table: people counted and milliseconds a photo."""
    labelled = json.loads((folder / "people.json").read_text())["images"]
    total, wall_s, cpu_s = Counter[str](), [], []
    backend.detect(Photo.open(photos_in(folder)[0]))  # networks warm up on their first photo
    for path in photos_in(folder):
        started, started_cpu = time.perf_counter(), time.process_time()
        people = backend.detect(Photo.open(path))
        wall_s.append(time.perf_counter() - started)
        cpu_s.append(time.process_time() - started_cpu)
        if path.name in labelled:
            total += counts(people, labelled[path.name])
    return (
        f"{total['clear_found']:3d} of {total['clear']:3d} {total['hard_found']:4d} of {total['hard']:3d} "
        f"{total['double']:7d} {total['false']:6d} {1000 * np.mean(wall_s):8.0f} {1000 * np.mean(cpu_s):8.0f}"
    )


_worker: dict[str, PoseBackend] = {}


def _start_worker(name: str, effort: str) -> None:
    os.environ["OPENCV_FOR_THREADS_NUM"] = "1"  # as the archive's workers have it
    _worker["backend"] = backend_named(name, PoseOptions(threads=1, effort=effort))


def _work(path: str) -> int:
    return len(_worker["backend"].detect(Photo.open(path)))


def photos_a_second(name: str, effort: str, folder: Path, workers: int, rounds: int) -> float:
    """Return the throughput of processes with one thread each, once all have started."""
    paths = [str(path) for path in photos_in(folder)]
    with multiprocessing.get_context("spawn").Pool(workers, _start_worker, (name, effort)) as pool:
        pool.map(_work, paths[: 2 * workers], chunksize=1)
        started = time.perf_counter()
        pool.map(_work, paths * rounds, chunksize=1)
        return len(paths) * rounds / (time.perf_counter() - started)


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--photos", type=Path, default=Path("../shared/data/photos"))
    parser.add_argument("--street", type=Path, help="the folder of street.py")
    add_models_option(parser)
    parser.add_argument("--pose", default="", help="names with commas between; all at hand without it")
    parser.add_argument("--effort", default="fast,normal,thorough")
    parser.add_argument("--rounds", type=int, default=2, help="times through the photos for the throughput; 0: none")
    args = parser.parse_args()
    names = args.pose.split(",") if args.pose else available()
    print(f"{'back end':34s}      clear        hard doubles  false ms/photo ms (cpu)  photos/s (ms) with 1, 2 workers")
    for name in names:
        for effort in args.effort.split(","):
            row = count_line(backend_named(name, PoseOptions(effort=effort)), args.photos)
            speeds = [photos_a_second(name, effort, args.photos, n, args.rounds) for n in (1, 2) if args.rounds]
            print(
                f"{name + ' ' + effort:34s} {row}  " + ", ".join(f"{s:.1f} ({1000 / s:.0f})" for s in speeds),
                flush=True,
            )
    if args.street:
        streets = read_streets(args.street)
        print(f"\n{check(streets)}")
        for name in names:
            report(backend_named(name), streets, ("scene", "combined", "torso"))


if __name__ == "__main__":
    main()
