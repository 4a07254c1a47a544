"""People before a car's camera, 2 to 40 m away: depth errors in metres by distance, and how often intervals hold.

    python -m synthetic.street_scenes [--mocap FILE] [--count 100]

Bodies and detector as in `synthetic/scenes.py`; a camera of 1600 x 900 pixels with f = 1266 px at 1.45 to 1.75 m, level
within half a degree, over a street that is uneven by some centimetres; one in six stands on a kerb 12 cm high.
"""

from __future__ import annotations

import argparse
import math
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from proxemetry.camera import Camera
from proxemetry.people import People
from proxemetry.people.skeleton import COCO_17
from synthetic import scenes as made
from synthetic.detections import Detector, detect
from synthetic.layouts import DrawBody, drawn_body
from synthetic.mocap import mocap_bodies
from synthetic.pair_errors import Records, record

CAMERA = Camera(1266.4, 1266.4, 816.3, 491.5, 1600, 900)
RANGES_M = ((0, 10), (10, 20), (20, 30), (30, 40), (0, 40))
METHODS = ("scene", "combined", "torso", "shoulder")


def street_photos(count: int, seed: int, body: DrawBody, detector: Detector) -> Iterator[made.SyntheticPhoto]:
    """Yield photos of one to ten people each."""
    for number in range(count):
        rng = np.random.default_rng([seed, number])
        height, pitch = float(rng.uniform(1.45, 1.75)), float(rng.normal(0, math.radians(0.5)))
        view = made._View(height, pitch, float(rng.normal(0, math.radians(0.5))), 0.0, np.zeros(2), 0.0)
        total = int(rng.integers(1, 11))
        far = 2 + 38 * np.sqrt(rng.random(total))
        across = far * (rng.uniform(80, 1520, total) - CAMERA.cx) / CAMERA.fx
        headings = rng.uniform(-np.pi, np.pi, total)
        raised = np.where(rng.random(total) < 1 / 6, 0.12, 0.0) + rng.normal(0, 0.04, total)
        bodies = [body(rng, False) for _ in range(total)]
        joints = [
            {name: view.rotation @ (view.rotation.T @ point - (0, up, 0)) for name, point in placed.items()}
            for placed, up in zip(
                (made._to_camera(b, np.array(p), float(h), view) for (b, _), p, h in
                 zip(bodies, zip(across, far, strict=True), headings, strict=True)),
                raised, strict=True,
            )
        ]  # fmt: skip
        seen = [made._seen(rng, CAMERA, j, float(h), False) for j, h in zip(joints, headings, strict=True)]
        keypoints, scores, owners = detect(rng, seen, COCO_17, CAMERA.width, CAMERA.height, detector)
        if owners:
            stacked = {joint: np.array([j[joint] for j in joints]) for joint in joints[0]}
            positions = (stacked["neck"] + stacked["mid_hip"]) / 2
            yield made.SyntheticPhoto(
                f"street_{number}", "street", CAMERA, 0.0, height, pitch, view.roll_rad,
                People(COCO_17, keypoints, scores), np.array(owners, dtype=np.intp), stacked, positions,
                (positions @ view.rotation)[:, [0, 2]] * 1000, view.up, headings, np.array([s for _, s in bodies]),
                np.zeros(total, dtype=bool), np.zeros(total, dtype=bool), {},
            )  # fmt: skip


def line(records: Records, low: float, high: float) -> str:
    """Return count, mean absolute and signed depth error in metres, and coverage of the 90 % interval."""
    true, depth, sd = map(np.array, (records.true_depth_m, records.depth_m, records.depth_sd_m))
    keep = (true > low) & (true <= high)
    known = keep & np.isfinite(depth)
    error = (depth - true)[known]
    cover = 100 * np.mean(np.abs(error) < 1.645 * sd[known])
    return (f"{keep.sum():6d}{100 * (1 - known.sum() / max(keep.sum(), 1)):8.0f}{np.abs(error).mean():9.2f}"
            f"{error.mean():+9.2f}{100 * np.mean(np.abs(error / true[known])):9.1f}{cover:9.0f}")  # fmt: skip


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--mocap", type=Path)
    parser.add_argument("--count", type=int, default=100)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--noise", type=float, default=0.5, help="in units of annotators' spread")
    parser.add_argument("--methods", nargs="+", default=METHODS)
    args = parser.parse_args()
    body = mocap_bodies(args.mocap) if args.mocap else drawn_body
    detector = Detector(noise=args.noise, outliers=0.04, floor_px=0.8)
    results = record(street_photos(args.count, args.seed, body, detector), tuple(args.methods))
    columns = ("people", "miss %", "error m", "bias m", "error %", "cover %")
    print(
        f"{'metres':10s}{'method':10s}"
        + "".join(f"{c:>{w}s}" for c, w in zip(columns, (6, 8, 9, 9, 9, 9), strict=True))
    )
    for low, high in RANGES_M:
        for method, records in results.items():
            print(f"{f'{low}-{high}':10s}{method:10s}{line(records, low, high)}")


if __name__ == "__main__":
    main()
