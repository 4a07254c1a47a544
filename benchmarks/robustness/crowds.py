"""Processor time and peak memory for photos of crowds, by the number of people.

    python -m benchmarks.robustness.crowds [--people 50 200 600 2000] [--unknown-camera]

Synthetic people stand on a floor in front of a pitched camera, 0.8 to 1.5 m apart, with keypoints a pixel or two off.
Each size runs in a process of its own: camera, places, distances, groups, the row of a results folder and its JSON.
"""

from __future__ import annotations

import argparse
import json
import math
import subprocess
import sys
import time

import numpy as np

from benchmarks.robustness.process_memory import memory_bytes
from proxemetry.archive.store.part_rows import record_of
from proxemetry.camera import Camera
from proxemetry.measure import measure
from proxemetry.people import People
from proxemetry.people.skeleton import COCO_17
from proxemetry.photo import Photo

WIDTH, HEIGHT, F_PX, HEIGHT_M, PITCH_RAD = 6000, 4000, 4500.0, 6.0, math.radians(14)
#: An upright body: metres to the side (of its own left) and above the floor, by joint (ANSUR II's proportions).
_BODY = {
    "nose": (0.0, 1.6), "left_eye": (0.03, 1.63), "right_eye": (-0.03, 1.63), "left_ear": (0.08, 1.61),
    "right_ear": (-0.08, 1.61), "left_shoulder": (0.18, 1.41), "right_shoulder": (-0.18, 1.41),
    "left_elbow": (0.24, 1.1), "right_elbow": (-0.24, 1.1), "left_wrist": (0.25, 0.85), "right_wrist": (-0.25, 0.85),
    "left_hip": (0.1, 0.92), "right_hip": (-0.1, 0.92), "left_knee": (0.1, 0.49), "right_knee": (-0.1, 0.49),
    "left_ankle": (0.1, 0.07), "right_ankle": (-0.1, 0.07),
}  # fmt: skip


def crowd(count: int, seed: int = 0) -> People:
    """Return so many people as a detector might see them, in a photo of `WIDTH` x `HEIGHT` pixels."""
    generator = np.random.default_rng(seed)
    columns = math.ceil(math.sqrt(count))
    place = np.stack(np.divmod(np.arange(count), columns), axis=1) * (1.5, 1.2)
    place = place + generator.uniform(-0.3, 0.3, place.shape) + (12.0, -0.6 * columns)
    turned, stature = generator.uniform(-math.pi, math.pi, count), generator.normal(1.0, 0.04, count)
    body = np.array([_BODY[joint] for joint in COCO_17.joints])
    side = body[:, 0] * np.cos(turned)[:, None]
    x = place[:, 1, None] + side * stature[:, None]
    z = place[:, 0, None] + body[:, 0] * np.sin(turned)[:, None]
    y = body[:, 1] * stature[:, None] - HEIGHT_M
    sin, cos = math.sin(PITCH_RAD), math.cos(PITCH_RAD)
    depth, down = z * cos - y * sin, -y * cos - z * sin
    pixels = np.stack([F_PX * x / depth + WIDTH / 2, F_PX * down / depth + HEIGHT / 2], axis=-1)
    pixels += generator.normal(0, 1.5, pixels.shape)
    outside = (pixels < 0).any(axis=-1) | (pixels > (WIDTH, HEIGHT)).any(axis=-1)
    return People(COCO_17, pixels, np.where(outside, 0.0, 0.8))


def _one(count: int, known: bool) -> dict[str, float]:
    people = crowd(count)
    photo = Photo("crowd.jpg", WIDTH, HEIGHT, "")
    camera = Camera.centred(F_PX, WIDTH, HEIGHT, focal_rel_sd=0.02) if known else None
    empty = memory_bytes()[1] / 1e6
    started = time.process_time()
    scene = measure(photo, pose=_Given(people), camera=camera)
    fitted = time.process_time()
    placed, pairs = int(scene.bodies.placed.sum()), scene.distances.below(math.inf)
    measured = time.process_time()
    record_of(scene)
    done = time.process_time()
    peak = memory_bytes()[1] / 1e6
    return {
        "people": count, "placed": placed, "pairs": pairs, "fit_s": fitted - started, "distances_s": measured - fitted,
        "record_s": done - measured, "all_s": done - started, "peak_mb": peak, "before_mb": empty,
    }  # fmt: skip


class _Given:
    """A back end that found the people before."""

    name, skeleton, models = "given", COCO_17, {}

    def __init__(self, people: People) -> None:
        self._people = people

    def detect(self, photo: Photo) -> People:
        return self._people


def main() -> None:
    """Run each size in a process of its own and print a table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--people", type=int, nargs="+", default=[10, 50, 200, 600, 2000])
    parser.add_argument("--unknown-camera", action="store_true", help="leave the focal length to the people")
    parser.add_argument("--one", type=int, help=argparse.SUPPRESS)
    args = parser.parse_args()
    if args.one is not None:
        print(json.dumps(_one(args.one, not args.unknown_camera)))
        return
    print("| people | placed | pairs | fit s | distances s | row s | all s (CPU) | peak MB |")
    print("|---" * 8 + "|")
    for count in args.people:
        options = ["--one", str(count), *(["--unknown-camera"] if args.unknown_camera else [])]
        command = [sys.executable, "-m", "benchmarks.robustness.crowds", *options]
        row = json.loads(subprocess.run(command, check=True, capture_output=True, text=True).stdout)
        print(
            f"| {count} | {row['placed']} | {row['pairs']} | {row['fit_s']:.1f} | {row['distances_s']:.1f} | "
            f"{row['record_s']:.1f} | {row['all_s']:.1f} | {row['peak_mb']:.0f} |",
            flush=True,
        )


if __name__ == "__main__":
    main()
