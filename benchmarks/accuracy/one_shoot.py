"""The focal length of one shoot's photos without metadata, estimated from the people in all of them; simulated.

    python -m benchmarks.accuracy.one_shoot [--shoots 12] [--photos 20] [--people 8]
                                          [--mocap ../shared/data/mocap/cmu_subjects_01-03_12fps_joints_m.npz]

A shoot has one hand-held camera and lens: pitch, roll, height and direction differ from photo to photo. The same people
recur, four to a photo, standing and walking as captured ones did with --mocap, with 3 px of noise a joint in photos of
4160 x 2768. One line for each mean pitch: how many shoots get an answer, how far off it is, how often its 90 % interval
holds the truth, and the errors in stated standard deviations, root mean square, of all shoots, answered or not. With
--stranger, one photo of each shoot was taken with a lens twice as long.
"""

from __future__ import annotations

import argparse
import math
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from benchmarks.accuracy.self_calibration import KORTE_SIZE, NOISE_PX
from proxemetry.arrays import FloatArray
from proxemetry.calibration.shoot import told_by_shoot
from proxemetry.camera import Camera
from proxemetry.intervals import HALF_WIDTH_SD
from proxemetry.locate import LocateSettings
from proxemetry.people import People
from proxemetry.people.skeleton import COCO_17
from synthetic import mocap
from synthetic.bodies import Build, draw_build, draw_posture, pose_joints

PITCHES_DEG = (2, 10, 20, 30)
_SEEN_AT_ONCE = 4

Rng = np.random.Generator


def postures(file: Path | None):
    """Return what gives a body's joints on the floor, for a build: captured ones, or drawn ones that stand."""
    if file is None:
        return lambda rng, build: pose_joints(build, draw_posture(rng, False))
    frames, names = mocap._upright(file)
    return lambda rng, build: mocap._dressed(rng, build, frames[rng.integers(len(frames))], names)


def photo(rng: Rng, camera: Camera, pitch: float, height_m: float, builds: Sequence[Build], joints_of) -> People:
    """Return the people of one photo, who stand where the camera sees them whole."""
    seen: list[FloatArray] = []
    roll = math.radians(rng.normal(0, 1))
    up = np.array([math.sin(roll) * math.cos(pitch), -math.cos(roll) * math.cos(pitch), -math.sin(pitch)])
    ahead = np.array([0.0, -math.sin(pitch), math.cos(pitch)])
    ahead = ahead - (ahead @ up) * up
    ahead /= np.linalg.norm(ahead)
    for build in rng.permutation(np.array(builds, dtype=object))[:_SEEN_AT_ONCE]:
        for _ in range(60):
            along = rng.uniform(3, 15)
            side = rng.uniform(-1, 1) * along * camera.width / 2 / camera.f_px
            turn = rng.uniform(-math.pi, math.pi)
            right = np.cross(ahead, up)
            forward = math.cos(turn) * right + math.sin(turn) * ahead
            axes = np.stack([forward, np.cross(up, forward), up])
            foot = -height_m * up + along * ahead + side * right
            joints = joints_of(rng, build)
            pixels = camera.project(foot + np.array([joints[name] for name in COCO_17.joints]) @ axes)
            pixels += rng.normal(0, NOISE_PX, pixels.shape)
            if np.isfinite(pixels).all() and (pixels > 0).all() and (pixels < (camera.width, camera.height)).all():
                seen.append(pixels)
                break
    keypoints = np.array(seen).reshape(-1, len(COCO_17), 2)
    return People(COCO_17, keypoints, np.full(keypoints.shape[:2], 0.9))


def shoot(rng: Rng, pitch_deg: float, args: argparse.Namespace, joints_of) -> tuple[list[People], Camera]:
    """Return the photos of one shoot, and its camera."""
    width, height = KORTE_SIZE
    camera = Camera.centred(math.exp(rng.uniform(math.log(0.7), math.log(1.8))) * width, width, height)
    builds = [draw_build(rng) for _ in range(args.people)]
    photos: list[People] = []
    for number in range(args.photos):
        pitch = math.radians(pitch_deg + rng.normal(0, 3))
        height_m = 1.5 + max(0.0, 9.0 * math.tan(pitch)) * rng.uniform(0.7, 1.1)
        lens = camera.with_focal(2 * camera.f_px) if args.stranger and number == args.photos // 2 else camera
        photos.append(photo(rng, lens, pitch, height_m, builds, joints_of))
    return photos, camera


def main() -> None:
    """Print one row a mean pitch."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--shoots", type=int, default=12)
    parser.add_argument("--photos", type=int, default=20)
    parser.add_argument("--people", type=int, default=8)
    parser.add_argument("--mocap", type=Path)
    parser.add_argument("--stranger", action="store_true")
    args = parser.parse_args()
    joints_of = postures(args.mocap)
    print(f"{'pitch':>6s}{'answered':>9s}{'median off':>11s}{'bias':>7s}{'in 90':>6s}{'z':>6s}{'stated sd':>10s}")
    for pitch_deg in PITCHES_DEG:
        rng = np.random.default_rng(pitch_deg)
        rows: list[tuple[float, float, bool]] = []
        for _ in range(args.shoots):
            photos, camera = shoot(rng, pitch_deg, args, joints_of)
            fit = told_by_shoot(photos, camera.width, camera.height, LocateSettings(), stayed=False)
            rows.append((fit.log_focal_px - math.log(camera.f_px), fit.log_sd, fit.doubt is None))
        off, sd = np.array([r[0] for r in rows]), np.array([r[1] for r in rows])
        told = np.array([r[2] for r in rows])
        held = np.abs(off) <= HALF_WIDTH_SD * sd
        answers = f"{'-':>11s}{'-':>7s}{'-':>6s}"
        if told.any():
            median, bias = 100 * np.median(np.abs(off[told])), 100 * off[told].mean()
            answers = f"{median:10.1f}%{bias:+6.1f}%{100 * held[told].mean():6.0f}"
        print(f"{pitch_deg:6d}{100 * told.mean():8.0f}%{answers}{np.sqrt(np.mean((off / sd) ** 2)):6.2f}"
              f"{100 * np.median(sd):9.0f}%", flush=True)  # fmt: skip


if __name__ == "__main__":
    main()
