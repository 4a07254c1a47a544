"""What every available pose back end finds on labelled photos, how accurate its joints are, and how long it takes.

    python -m benchmarks.networks.backends --photos DIR [--labelled DIR] [--models DIR] [--pose A,B] [--write]

--photos: photos and people.json: for each photo its people with head and mid-shoulder in pixels, a box and a difficulty
(clear or hard), and zones of real but unlabelled people. A person is found where a result's head and mid-shoulder both
lie within one head-to-shoulder distance of a label's; another result inside a labelled box is a double, any other
is false, except small ones in those zones.

--labelled: hand-labelled joints (`labelled_people`). Of the people found there: the share of joints within 0.1 and 0.2
torsos of the label (one not found counts as wrong), and the median ratio of lengths, found to labelled, of torso,
shoulders, hips and ears.

Times are processor time a photo, of one process with one thread and of two at once (half of each one's, what two
workers take for a photo), so that other programs on the machine matter less. With --street the depth errors of
street.py follow. --write puts the table into docs/backends_measured.md.
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
from benchmarks.networks.joints import joint_errors
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


COLUMNS = (
    "back end, effort", "clear", "hard", "doubles", "false", "labelled people", "PCK@.1", "PCK@.2",
    "torso / shoulders / hips / ears", "ms, one worker", "ms, two",
)  # fmt: skip
_PAGE = Path(__file__).parents[2] / "docs" / "backends_measured.md"
BEGIN, END = "<!-- benchmarks/networks/backends.py: begin -->", "<!-- end -->"


def counted(backend: PoseBackend, folder: Path) -> Counter[str]:
    """Return the people of a folder's labelled photos that a back end found, doubled and invented."""
    labelled = json.loads((folder / "people.json").read_text())["images"]
    total = Counter[str]()
    for name, labels in labelled.items():
        total += counts(backend.detect(Photo.open(folder / name)), labels)
    return total


def count_cells(total: Counter[str]) -> list[str]:
    """Return the table's cells of people: clear, hard, doubles, false."""
    return [
        f"{total['clear_found']} of {total['clear']}", f"{total['hard_found']} of {total['hard']}",
        str(total["double"]), str(total["false"]),
    ]  # fmt: skip


_worker: dict[str, PoseBackend] = {}


def _start_worker(name: str, effort: str) -> None:
    os.environ["OPENCV_FOR_THREADS_NUM"] = "1"  # as the archive's workers have it
    _worker["backend"] = backend_named(name, PoseOptions(threads=1, effort=effort))


def _work(path: str) -> float:
    started = time.process_time()
    _worker["backend"].detect(Photo.open(path))
    return time.process_time() - started


def processor_ms(name: str, effort: str, folder: Path, workers: int) -> float:
    """Return the milliseconds of processor time a photo that so many processes take, with one thread each."""
    paths = [str(path) for path in photos_in(folder)]
    with multiprocessing.get_context("spawn").Pool(workers, _start_worker, (name, effort)) as pool:
        pool.map(_work, paths[: 2 * workers], chunksize=1)  # networks warm up on their first photo
        return 1000 * float(np.mean(pool.map(_work, paths, chunksize=1))) / workers


def row(name: str, effort: str, photos: Path, labelled: Path) -> list[str]:
    """Return one back end's row of the table."""
    backend = backend_named(name, PoseOptions(effort=effort))
    cells = [f"`{name}` {effort}", *count_cells(counted(backend, photos)), *joint_errors(backend, labelled).cells()]
    return [*cells, *(f"{processor_ms(name, effort, photos, workers):.0f}" for workers in (1, 2))]


def markdown(rows: Sequence[Sequence[str]]) -> str:
    """Return the table as Markdown."""
    lines = [COLUMNS, ["---"] * len(COLUMNS), *rows]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines)


def written(page: str, table: str) -> str:
    """Return the page with this table in the place of the one that it has."""
    before, _, rest = page.partition(BEGIN)
    return f"{before}{BEGIN}\n{table}\n{END}{rest.partition(END)[2]}"


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--photos", type=Path, default=Path("../shared/data/photos"))
    parser.add_argument("--labelled", type=Path, default=Path("../shared/data/labelled_people"))
    parser.add_argument("--street", type=Path, help="the folder of street.py")
    add_models_option(parser)
    parser.add_argument("--pose", default="", help="comma-separated names (default: all that are available)")
    parser.add_argument("--effort", default="normal")
    parser.add_argument("--write", action="store_true", help="put the table into docs/backends_measured.md")
    args = parser.parse_args()
    names = args.pose.split(",") if args.pose else available()
    rows: list[list[str]] = []
    for name in names:
        for effort in args.effort.split(","):
            rows.append(row(name, effort, args.photos, args.labelled))
            print(" | ".join(rows[-1]), flush=True)
    if args.write:
        _PAGE.write_text(written(_PAGE.read_text(encoding="utf-8"), markdown(rows)), encoding="utf-8")
    if args.street:
        streets = read_streets(args.street)
        print(f"\n{check(streets)}")
        for name in names:
            report(backend_named(name), streets, ("scene", "combined", "torso"))


if __name__ == "__main__":
    main()
