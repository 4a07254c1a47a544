"""One person of three in an odd posture: the error of their depth, their interval, and the effect on the others.

    python -m benchmarks.accuracy.odd_postures [--count 60]

Three people 5 to 14 m away; the first rides a bicycle, stoops, squats, sits, lies on the ground or is a child. Bodies
and detector as in `synthetic/scenes.py`; nothing is shared with the method.
"""

from __future__ import annotations

import argparse
import math
from collections.abc import Callable, Iterator
from dataclasses import replace

import numpy as np

from proxemetry.arrays import FloatArray
from proxemetry.camera import Camera
from proxemetry.intervals import HALF_WIDTH_SD
from proxemetry.locate import LocateSettings, method_named
from proxemetry.people import People
from proxemetry.people.skeleton import COCO_17
from synthetic import scenes as made
from synthetic.bodies import Build, draw_build, draw_posture, pose_joints, rotation
from synthetic.detections import Detector, detect

Rng = np.random.Generator
Joints = dict[str, FloatArray]

CAMERA = Camera.centred(1800, 1920, 1080)


def standing(rng: Rng, build: Build) -> Joints:
    """Return a person who stands or walks."""
    return pose_joints(build, draw_posture(rng, False))


def seated(rng: Rng, build: Build) -> Joints:
    """Return a person on a chair."""
    return pose_joints(build, draw_posture(rng, True))


def riding(rng: Rng, build: Build) -> Joints:
    """Return a person on a bicycle, the lower pedal some 11 cm above the road."""
    turn = math.cos(rng.uniform(0, 2 * math.pi))
    thighs = (math.radians(52 + 24 * turn), math.radians(52 - 24 * turn))
    knees = (math.radians(75 + 35 * turn), math.radians(75 - 35 * turn))
    lean = math.radians(rng.normal(22, 10))
    posture = replace(draw_posture(rng, False), lean=lean, thighs=thighs, knees=knees, spread=(0.03, 0.03))
    return _moved(pose_joints(build, posture), np.array([0.0, 0.0, 0.11 + rng.normal(0, 0.02)]))


def stooping(rng: Rng, build: Build) -> Joints:
    """Return a person bent forward by some 60 degrees."""
    return pose_joints(build, replace(draw_posture(rng, False), lean=math.radians(rng.normal(60, 10))))


def squatting(rng: Rng, build: Build) -> Joints:
    """Return a person on their haunches."""
    thighs, knees = np.radians(rng.normal(105, 10, 2)), np.radians(rng.normal(135, 8, 2))
    lean = math.radians(rng.normal(25, 10))
    posture = replace(draw_posture(rng, False), lean=lean, thighs=tuple(thighs), knees=tuple(knees))
    return pose_joints(build, posture)


def lying(rng: Rng, build: Build) -> Joints:
    """Return a person flat on the ground: on the back mostly, on the belly or on a side."""
    way = rng.choice(["back", "belly", "side"], p=[0.56, 0.14, 0.3])
    tip = {"back": ("y", -math.pi / 2), "belly": ("y", math.pi / 2), "side": ("x", math.pi / 2)}[str(way)]
    joints = {name: rotation(*tip) @ (point - (0.0, 0.0, 0.9)) for name, point in standing(rng, build).items()}
    lowest = min(point[2] for point in joints.values())
    return _moved(joints, np.array([0.0, 0.0, 0.08 - lowest]))


def child(rng: Rng, build: Build) -> Joints:
    """Return a standing child of 2 to 16 years."""
    return standing(rng, draw_build(rng, child=True))


POSTURES: dict[str, Callable[[Rng, Build], Joints]] = {
    "standing": standing, "seated": seated, "riding": riding, "stooping": stooping, "squatting": squatting,
    "lying": lying, "child": child,
}  # fmt: skip


def _moved(joints: Joints, by: FloatArray) -> Joints:
    return {name: point + by for name, point in joints.items()}


def photos(posture: str, count: int, seed: int = 0) -> Iterator[tuple[People, list[int], FloatArray]]:
    """Yield detections, whom each shows, and the true middles of the torsos (3, 3), the odd one first."""
    for number in range(count):
        rng = np.random.default_rng([seed, number])
        view = made._View(
            rng.uniform(1.4, 1.7), rng.normal(0, math.radians(3)), rng.normal(0, 0.012), 0.0, np.zeros(2), 0.0
        )
        far = rng.uniform(5, 14, 3)
        places = np.stack([far * rng.uniform(-0.4, 0.4, 3), far], axis=1)
        builds = [draw_build(rng) for _ in places]
        bodies = [POSTURES[posture if k == 0 else "standing"](rng, build) for k, build in enumerate(builds)]
        headings = rng.uniform(-math.pi, math.pi, 3)
        joints = [
            made._to_camera(body, place, float(heading), view)
            for body, place, heading in zip(bodies, places, headings, strict=True)
        ]
        seen = [made._seen(rng, CAMERA, j, float(h), False) for j, h in zip(joints, headings, strict=True)]
        detector = Detector(noise=0.4, miss_rate=0.0)
        keypoints, scores, owners = detect(rng, seen, COCO_17, CAMERA.width, CAMERA.height, detector)
        middles = np.array([(j["neck"] + j["mid_hip"]) / 2 for j in joints])
        yield People(COCO_17, keypoints, scores), owners, middles


def line(errors: list[tuple[float, float]]) -> str:
    """Return percent errors of depth, and how many truths lie in the 90 % interval."""
    relative, deviations = np.array(errors).reshape(-1, 2).T
    known = np.isfinite(relative)
    error, bias = 100 * np.abs(relative[known]).mean(), 100 * relative[known].mean()
    inside = 100 * np.mean(np.abs(deviations[known]) < HALF_WIDTH_SD)
    return f"{known.sum():4d} of {len(known):3d}{error:8.1f}{bias:+8.1f}{inside:8.0f}"


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--count", type=int, default=60)
    parser.add_argument("--seed", type=int, default=0)
    args = parser.parse_args()
    print(f"{'':12s}{'placed':>11s}{'error %':>8s}{'bias %':>8s}{'in 90 %':>8s}   the other two")
    for posture in POSTURES:
        odd: list[tuple[float, float]] = []
        others: list[tuple[float, float]] = []
        for people, owners, middles in photos(posture, args.count, args.seed):
            bodies = method_named("scene")(people, CAMERA, LocateSettings())
            sd = bodies.position_sd_m
            for row, owner in enumerate(owners):
                off = bodies.positions_m[row, 2] - middles[owner, 2]
                (others if owner else odd).append((off / middles[owner, 2], off / sd[row, 2]))
        print(f"{posture:12s}{line(odd)}   {line(others)}")


if __name__ == "__main__":
    main()
