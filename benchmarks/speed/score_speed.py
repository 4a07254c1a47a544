"""How long scoring takes: both protocols over a labels folder, reading included, in CPU seconds (least of several).

python -m benchmarks.speed.score_speed ../shared/data/korte
"""

from __future__ import annotations

import argparse
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

from proxemetry.benchmark import PROTOCOLS, Prediction, read_labels, score_files, write_predictions


def made_up_answers(folder: str, path: Path) -> int:
    """Write noisy positions for everyone annotated; returns the number of photos."""
    rng = np.random.default_rng(0)
    images = []
    for label in read_labels(folder):
        none = np.full((len(label), len(label)), np.nan)
        positions = label.positions_mm * rng.normal(1, 0.1, (len(label), 1)) + rng.normal(0, 100, (len(label), 3))
        images.append(
            Prediction(label.filename, label.width, label.height, label.parts_px, positions, None, none, none)
        )
    write_predictions(path, images)
    return len(images)


def least_cpu_seconds(work: Callable[[], object], repeats: int) -> float:
    """Return the least CPU time of several runs."""
    times = []
    for _ in range(repeats):
        started = time.process_time()
        work()
        times.append(time.process_time() - started)
    return min(times)


def main() -> None:
    """Print the seconds of each protocol and of both."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("labels")
    parser.add_argument("--repeats", type=int, default=5)
    args = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "predictions.json"
        count = made_up_answers(args.labels, path)
        total = 0.0
        for protocol in PROTOCOLS:
            seconds = least_cpu_seconds(lambda p=protocol: score_files(path, args.labels, p), args.repeats)
            total += seconds
            print(f"{protocol:<12}{seconds:7.3f} s CPU for {count} photos")
    print(f"{'both':<12}{total:7.3f} s CPU (budget 0.5 s)")


if __name__ == "__main__":
    main()
