"""Mounts estimated from people: seven real cameras, real positions of people, synthetic bodies.

    python -m benchmarks.accuracy.mounts_from_people --data DIR [--frames 60] [--judged 12] [--noise 0.5]

DIR is WILDTRACK's calibrations and positions (`fixed_camera_data`). Bodies and detector are those of `synthetic`, which
share nothing with the fit; a person keeps one body in all frames. The focal length is given, and the principal point
too, unless --principal middle takes it to be the picture's (it is up to 96 px off). Pair errors of frames that did not
calibrate: each frame by itself, with the people's mount, with the true one. z: how many stated standard deviations
pitch and log height are off. --habits draws for every row a systematic error in the height of each kind of joint, the
same for all people, as real detectors have: without it the simulated detector is better than any real one, and the
stated deviations look too large.
"""

from __future__ import annotations

import argparse
import math
from dataclasses import replace
from pathlib import Path

import numpy as np

from benchmarks.accuracy.fixed_camera import PRINCIPAL_REL_SD, pairs_of
from benchmarks.accuracy.fixed_camera_data import (
    WILDTRACK_CAMERAS,
    FixedCamera,
    Frame,
    wildtrack_camera,
    wildtrack_people,
)
from proxemetry.arrays import FloatArray
from proxemetry.calibration.people import Gathered, from_people
from proxemetry.camera import Camera
from proxemetry.people import People
from proxemetry.people.skeleton import COCO_17
from synthetic import scenes as made
from synthetic.bodies import Build, draw_build, draw_posture, pose_joints
from synthetic.detections import Detector, detect

#: People further away are not looked at: they are fifty pixels tall.
FARTHEST_M = 25.0
#: How high a detector sees each kind of joint, of all people alike, in statures, and which go together.
HABIT_SD = 0.015
_KINDS = ("ankle", "knee", "hip", "shoulder", "eye", "nose ear")


def frames_of(
    true: FixedCamera, positions: dict[int, tuple[np.ndarray, FloatArray]], count: int, seed: int, noise: float,
    habits: bool = False,
) -> list[Frame]:  # fmt: skip
    """Return frames spread over the recording, each with who is seen and what a detector makes of them."""
    rng = np.random.default_rng(seed)
    builds: dict[int, Build] = {}
    raised = dict(zip(_KINDS, np.random.default_rng([seed, 1]).normal(0, HABIT_SD, len(_KINDS)).tolist(), strict=True))
    frames: list[Frame] = []
    numbers = sorted(positions)
    for number in numbers[:: max(1, len(numbers) // count)][:count]:
        persons, floor = positions[number]
        seen, kept = [], []
        for k, (person, place) in enumerate(zip(persons.tolist(), floor, strict=True)):
            build = builds.setdefault(person, draw_build(np.random.default_rng([seed, person])))
            heading = float(rng.uniform(-math.pi, math.pi))
            joints = _joints(true, build, place, heading, rng, raised if habits else {})
            away = float(np.linalg.norm(joints["neck"]))
            if away < FARTHEST_M and made._is_shown(true.camera, joints):
                # the way it faces as the camera sees it, for what hides what
                facing = joints["nose"] - joints["head_centre"]
                seen.append(made._seen(rng, true.camera, joints, math.atan2(facing[0], -facing[2]), False))
                kept.append(k)
        detector = replace(Detector(), noise=noise)
        keypoints, scores, owners = detect(rng, seen, COCO_17, true.camera.width, true.camera.height, detector)
        if owners:
            who = np.array(kept)
            frames.append(Frame(number, People(COCO_17, keypoints, scores), np.array(owners), persons[who], floor[who]))
    return frames


def _joints(
    true: FixedCamera, build: Build, place: FloatArray, heading: float, rng: np.random.Generator,
    raised: dict[str, float],
) -> dict[str, FloatArray]:  # fmt: skip
    """Return a standing person's joints in the camera frame; the body's frame is forward, left and up.

    raised: how much too high each kind of joint is seen, in statures.
    """
    forward = np.array([math.cos(heading), math.sin(heading), 0.0])
    axes = np.stack([forward, np.cross((0.0, 0.0, 1.0), forward), (0.0, 0.0, 1.0)])
    body = pose_joints(build, draw_posture(rng, False))
    for name in body:
        body[name] = body[name] + (0.0, 0.0, raised.get(_kind(name), 0.0) * build.stature)
    return {
        name: true.rotation @ (point @ axes + (place[0], place[1], 0.0) - true.place_m) for name, point in body.items()
    }


def _kind(joint: str) -> str:
    part = joint.removeprefix("left_").removeprefix("right_")
    return next((kind for kind in _KINDS if part in kind), "")


def main() -> None:
    """Print one row a camera and draw of bodies."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--data", type=Path, required=True)
    parser.add_argument("--frames", type=int, default=60)
    parser.add_argument("--judged", type=int, default=12)
    parser.add_argument("--noise", type=float, default=0.5)
    parser.add_argument("--principal", choices=("known", "middle"), default="known")
    parser.add_argument("--seeds", type=int, default=2)
    parser.add_argument("--habits", action="store_true")
    args = parser.parse_args()
    positions = wildtrack_people(args.data)
    print(f"{'camera':8s}{'people':>7s}{'seen':>6s}{'pitch off':>10s}{'z':>6s}{'height off':>11s}{'z':>6s}   "
          f"{'frame %':>8s}{'people %':>9s}{'in 90':>6s}{'true %':>7s}{'in 90':>6s}")  # fmt: skip
    z: list[tuple[float, float]] = []
    means: list[tuple[float, float, float]] = []
    for name in WILDTRACK_CAMERAS:
        true = wildtrack_camera(args.data, name)
        lens = true.camera
        if args.principal == "middle":
            lens = Camera.centred(true.camera.f_px, true.camera.width, true.camera.height)
            lens = replace(lens, principal_sd_px=PRINCIPAL_REL_SD * lens.width)
        for seed in range(args.seeds):
            frames = frames_of(true, positions, args.frames + args.judged, seed, args.noise, args.habits)
            judged = frames[:: max(2, len(frames) // args.judged)]
            told = [f for f in frames if f not in judged]
            gathered = Gathered()
            for frame in told:
                gathered.add(frame.people, frame.persons[frame.owners].tolist())
            fit = from_people(gathered, lens)
            mount, truth = fit.mount, true.mount
            off = mount.pitch_rad - truth.pitch_rad, math.log(mount.height_m / truth.height_m)
            z.append((off[0] / mount.sd[0], off[1] / mount.sd[2]))
            assert mount.camera is not None
            found = [pairs_of(judged, lens, None), pairs_of(judged, mount.camera, mount),
                     pairs_of(judged, true.camera, truth)]  # fmt: skip
            errors = tuple(100 * float(np.abs(p.found_m / p.truth_m - 1).mean()) for p in found)
            holds = [100 * float(((p.low_m <= p.truth_m) & (p.truth_m <= p.high_m)).mean()) for p in found]
            means.append((errors[0], errors[1], errors[2]))
            print(f"{name:8s}{fit.n_people:7d}{fit.n_detections:6d}{math.degrees(off[0]):+9.2f}d{z[-1][0]:+6.1f}"
                  f"{100 * off[1]:+10.1f}%{z[-1][1]:+6.1f}   {errors[0]:8.1f}{errors[1]:9.1f}{holds[1]:6.0f}"
                  f"{errors[2]:7.1f}{holds[2]:6.0f}", flush=True)  # fmt: skip
    rms, mean = np.sqrt(np.mean(np.square(z), axis=0)), np.mean(means, axis=0)
    print(f"mean pair error: frame {mean[0]:.1f} %, people {mean[1]:.1f} %, true {mean[2]:.1f} %; "
          f"errors in stated standard deviations: pitch {rms[0]:.2f}, height {rms[1]:.2f}")  # fmt: skip


if __name__ == "__main__":
    main()
