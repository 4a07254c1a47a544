"""Focal lengths estimated from people alone: simulated scenes by pitch and number of people.

Statures spread by 4.6 %, every point has 3 px of noise per axis, people stand where the camera sees them whole, 3 to 15
m away. How much that is depends on the photo: the default size is that of the KORTE benchmark's photos, `--size
1920x1080` that of a video frame. Errors are given for the scenes that got an answer, and for all of them as if none had
been declined. With `--mocap FILE` people stand and walk as captured ones did, men and women as in
`synthetic/bodies.py`.

    python -m benchmarks.accuracy.self_calibration [--scenes N] [--lean DEGREES] [--size WxH]
                                          [--mocap ../shared/data/mocap/cmu_subjects_01-03_12fps_joints_m.npz]
"""

from __future__ import annotations

import argparse
import math
from pathlib import Path

import numpy as np

from proxemetry.camera import Camera
from proxemetry.camera.from_people.self_calibration import calibrate
from proxemetry.intervals import HALF_WIDTH_SD
from proxemetry.people import People
from proxemetry.people.skeleton import COCO_17
from synthetic.layouts import DrawBody
from synthetic.mocap import mocap_bodies

NOISE_PX, STATURE_CV = 3.0, 0.046
KORTE_SIZE = (4160, 2768)
PITCHES_DEG = (0, 2, 5, 10, 15, 20)
COUNTS = (3, 4, 6, 8)

#: Joints of a person who stands upright, metres to the side and above the floor, for a stature of 1.70 m.
STANDING = {
    "nose": (0.0, 1.55), "left_eye": (0.03, 1.59), "right_eye": (-0.03, 1.59), "left_ear": (0.07, 1.59),
    "right_ear": (-0.07, 1.59), "left_shoulder": (0.17, 1.385), "right_shoulder": (-0.17, 1.385),
    "left_elbow": (0.22, 1.10), "right_elbow": (-0.22, 1.10), "left_wrist": (0.24, 0.85),
    "right_wrist": (-0.24, 0.85), "left_hip": (0.10, 0.90), "right_hip": (-0.10, 0.90), "left_knee": (0.10, 0.48),
    "right_knee": (-0.10, 0.48), "left_ankle": (0.10, 0.068), "right_ankle": (-0.10, 0.068),
}  # fmt: skip


def standing(lean_deg: float) -> DrawBody:
    """Return a drawer of people who stand alike, but for how tall they are and how they lean."""

    def draw(rng: np.random.Generator, seated: bool) -> tuple[dict[str, np.ndarray], float]:
        lean = np.radians(rng.normal(0, lean_deg, 2))
        stature, axis = 1 + STATURE_CV * rng.normal(), np.array([*lean, 1.0])
        joints = {n: stature * (np.array([0.0, left, 0.0]) + above * axis) for n, (left, above) in STANDING.items()}
        return joints, 1.7 * stature

    return draw


def scene(
    rng: np.random.Generator, pitch_deg: float, count: int, draw: DrawBody, size: tuple[int, int] = KORTE_SIZE
) -> tuple[People, Camera]:
    """Return people as a camera of random focal length and height sees them, and that camera."""
    width, height = size
    pitch = math.radians(pitch_deg)
    while True:
        camera = Camera.centred(rng.uniform(0.7, 1.8) * width, width, height)
        distance_m = rng.uniform(5, 10)
        height_m = 1.5 + distance_m * math.tan(pitch) * rng.uniform(0.7, 1.1)
        up = np.array([0.0, -math.cos(pitch), -math.sin(pitch)])
        ahead = np.array([0.0, -math.sin(pitch), math.cos(pitch)])
        seen: list[np.ndarray] = []
        for _ in range(60 * count):
            along = rng.uniform(3, 15)
            side = rng.uniform(-1, 1) * along * width / 2 / camera.f_px
            turn = rng.uniform(-math.pi, math.pi)
            left = np.array([math.cos(turn), 0.0, 0.0]) + math.sin(turn) * ahead
            foot = -height_m * up + along * ahead + np.array([side, 0.0, 0.0])
            joints, _ = draw(rng, False)
            body = np.array([joints[name] for name in COCO_17.joints])
            pixels = camera.project(foot + body @ np.stack([np.cross(left, up), left, up]))
            # the middle of a left and a right joint has the noise asked for
            pixels += rng.normal(0, NOISE_PX * math.sqrt(2), pixels.shape)
            if np.isfinite(pixels).all() and (pixels > 0).all() and (pixels < size).all():
                seen.append(pixels)
            if len(seen) == count:
                return People(COCO_17, np.stack(seen), np.full((count, len(COCO_17)), 0.9)), camera


def row(
    rng: np.random.Generator, pitch_deg: float, count: int, scenes: int, draw: DrawBody, size: tuple[int, int]
) -> dict[str, float]:
    """Return the figures of one cell of the table."""
    all_errors, errors, covered, widths = [], [], [], []
    for _ in range(scenes):
        people, truth = scene(rng, pitch_deg, count, draw, size)
        estimate = calibrate(people, *size)
        all_errors += [100 * abs(c.focal_px / truth.f_px - 1) for c in estimate.candidates]
        if estimate.camera is not None:
            log_error = math.log(estimate.camera.f_px / truth.f_px)
            errors.append(100 * abs(math.expm1(log_error)))
            covered.append(abs(log_error) <= HALF_WIDTH_SD * estimate.camera.focal_rel_sd)
            widths.append(100 * HALF_WIDTH_SD * estimate.camera.focal_rel_sd)
    nothing = float("nan")
    return {
        "declined_pct": 100 * (1 - len(errors) / scenes),
        "median_error_pct": float(np.median(errors)) if errors else nothing,
        "half_width_pct": float(np.median(widths)) if errors else nothing,
        "coverage_90_pct": 100 * float(np.mean(covered)) if covered else nothing,
        "all_error_pct": float(np.median(all_errors)) if all_errors else nothing,
    }


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--scenes", type=int, default=100, help="scenes in each cell of the table")
    parser.add_argument("--lean", type=float, default=0.0, help="standard deviation of people's lean, degrees")
    parser.add_argument("--pitch", type=int, nargs="+", default=PITCHES_DEG, metavar="DEGREES")
    parser.add_argument("--people", type=int, nargs="+", default=COUNTS, metavar="COUNT")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--size", default="x".join(map(str, KORTE_SIZE)), metavar="WxH")
    parser.add_argument("--mocap", type=Path, metavar="FILE")
    args = parser.parse_args()
    draw = mocap_bodies(args.mocap) if args.mocap else standing(args.lean)
    width, height = map(int, args.size.split("x"))
    print("pitch_deg people declined_pct median_error_pct half_width_pct coverage_90_pct all_error_pct")
    for pitch_deg in args.pitch:
        for count in args.people:
            rng = np.random.default_rng([args.seed, pitch_deg, count])
            figures = row(rng, pitch_deg, count, args.scenes, draw, (width, height))
            print(f"{pitch_deg:9d} {count:6d}", *(f"{value:12.1f}" for value in figures.values()), flush=True)


if __name__ == "__main__":
    main()
