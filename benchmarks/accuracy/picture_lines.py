"""Gravity and focal length from straight segments: York Urban's pictures, and synthetic scenes of every kind.

    python -m benchmarks.accuracy.picture_lines [--york segments.npz] [--scenes 60] [--seed 100]

York's file holds per picture NAME the arrays NAME_segments_px (N, 4) and NAME_vp_directions (3, M) (columns are unit
directions, y up); its camera is in the code. There are two truths for them: the labelled vertical, and the labels
turned to right angles. `scaled` is the coverage after intervals were scaled to hold 90 % of every other picture,
measured on the rest: it shows whether the constants fit these pictures alone.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from proxemetry.arrays import FloatArray
from proxemetry.camera import Camera
from proxemetry.camera.lines import focal_from_lines, gravity_from_lines
from synthetic.line_scenes import KINDS, STRAIGHT, line_scene

#: York Urban's camera (Denis, Elder and Estrada, ECCV 2008): 6.0532 mm at 9 um a pixel.
YORK = Camera(672.57, 672.57, 307.55, 251.45, 640, 480)
_SD_OF_90 = 1.645


@dataclass(frozen=True)
class Case:
    """Segments with the truth: camera (true focal length), pitch and roll in degrees, and other truths of the pitch."""

    segments_px: FloatArray
    camera: Camera
    pitch_deg: float
    roll_deg: float
    other_pitch_deg: float


@dataclass(frozen=True)
class Table:
    """Answers of C cases. tilt: (C, 5), errors of pitch, of pitch to the other truth, of roll, and both deviations.

    focal: (C, 3), log of estimate, low and high over the truth. NaN where there was none.
    """

    tilt: FloatArray
    focal: FloatArray
    milliseconds: tuple[float, float]


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--york", type=Path)
    parser.add_argument("--scenes", type=int, default=60)
    parser.add_argument("--seed", type=int, default=100)
    parser.add_argument("--kinds", nargs="+", default=list(KINDS))
    args = parser.parse_args()
    print(f"{'':15s}{'pitch':>7s}{'median':>8s}{'90 %':>7s}{'worst':>7s}{'holds':>7s}{'far out':>8s}{'roll':>7s}"
          f"{'holds':>7s}{'| focal':>9s}{'median%':>9s}{'holds':>7s}"
          f"{'width':>7s}{'far out':>8s}{'ms':>9s}")  # fmt: skip
    if args.york:
        york = answered(york_cases(args.york))
        _print("York Urban", york)
        _print_york(york)
    for kinds in (STRAIGHT, KINDS):
        for kind in kinds:
            if kind in args.kinds and (kinds is STRAIGHT or kind not in STRAIGHT):
                _print(kind, answered(scene_cases(kind, args.scenes, args.seed)))


def york_cases(path: Path) -> Iterator[Case]:
    """Yield York's pictures."""
    file = np.load(path)
    for key in sorted(file):
        if not key.endswith("_segments_px"):
            continue
        labels = file[key.replace("_segments_px", "_vp_directions")].astype(float) * ((1.0,), (-1.0,), (1.0,))
        vertical = int(np.abs(labels[1]).argmax())
        left, _, right = np.linalg.svd(labels)
        squared = left[:, : labels.shape[1]] @ right
        down, other = (v[:, vertical] * np.sign(v[1, vertical]) for v in (labels, squared))
        yield Case(file[key].astype(float), YORK, _pitch(down), float(np.degrees(np.arctan2(-down[0], down[1]))),
                   _pitch(other))  # fmt: skip


def _pitch(down: FloatArray) -> float:
    return float(np.degrees(np.arcsin(down[2] / np.linalg.norm(down))))


def scene_cases(kind: str, count: int, seed: int) -> Iterator[Case]:
    """Yield synthetic pictures of a kind; their principal point is not told."""
    rng = np.random.default_rng([seed, list(KINDS).index(kind)])
    for _ in range(count):
        scene = line_scene(kind, rng)
        camera = Camera.centred(scene.focal_px, scene.width, scene.height)
        yield Case(scene.segments_px, camera, scene.pitch_deg, scene.roll_deg, scene.pitch_deg)


def answered(cases: Iterator[Case]) -> Table:
    """Return what the lines tell of each case."""
    tilt, focal = [], []
    seconds = np.zeros(2)
    for case in cases:
        began = time.process_time()
        gravity = gravity_from_lines(case.segments_px, case.camera)
        between = time.process_time()
        found = focal_from_lines(case.segments_px, case.camera.width, case.camera.height)
        seconds += between - began, time.process_time() - between
        nothing = [np.nan] * 5
        tilt.append(nothing if gravity is None else [
            gravity.pitch_deg - case.pitch_deg, gravity.pitch_deg - case.other_pitch_deg,
            gravity.roll_deg - case.roll_deg, gravity.pitch_sd_deg, gravity.roll_sd_deg,
        ])  # fmt: skip
        f = case.camera.f_px
        focal.append(
            nothing[:3] if found is None else np.log([found.focal_px / f, found.low_px / f, found.high_px / f])
        )
    each = 1000 * seconds / len(tilt)
    return Table(np.array(tilt), np.array(focal), (float(each[0]), float(each[1])))


def _print(name: str, table: Table) -> None:
    tilt = table.tilt[np.isfinite(table.tilt[:, 0])]
    focal = table.focal[np.isfinite(table.focal[:, 0])]
    words = f"{name:15s}{100 * len(tilt) / len(table.tilt):6.0f}%"
    if len(tilt):
        pitch, reach = np.abs(tilt[:, 0]), _SD_OF_90 * tilt[:, 3]
        words += "".join(f"{v:{w}.2f}" for v, w in zip(np.percentile(pitch, [50, 90, 100]), (8, 7, 7), strict=True))
        words += f"{100 * (pitch < reach).mean():6.0f}%{100 * (pitch > 3 * reach).mean():7.0f}%"
        words += (
            f"{np.median(np.abs(tilt[:, 2])):7.2f}{100 * (np.abs(tilt[:, 2]) < _SD_OF_90 * tilt[:, 4]).mean():6.0f}%"
        )
    else:
        words += " " * 51
    words += f"{100 * len(focal) / len(table.focal):8.0f}%"
    if len(focal):
        width = focal[:, 2] - focal[:, 1]
        outside = np.maximum(focal[:, 1], -focal[:, 2])
        words += f"{100 * np.median(np.abs(np.expm1(focal[:, 0]))):9.1f}{100 * (outside < 0).mean():6.0f}%"
        words += f"{np.median(width):7.2f}{100 * (outside > width).mean():7.0f}%"
    else:
        words += " " * 30
    print(words + f"{table.milliseconds[0]:5.0f}{table.milliseconds[1]:4.0f}")


def _print_york(table: Table) -> None:
    """Print what only York has: the other truth, and coverage with intervals scaled on every other picture."""
    tilt, focal = table.tilt, table.focal
    other = np.abs(tilt[:, 1])
    print(f"    labels at right angles: median {np.nanmedian(other):.2f}, 90 % {np.nanpercentile(other, 90):.2f}, "
          f"holds {100 * (other < _SD_OF_90 * tilt[:, 3]).mean():.0f}%")  # fmt: skip
    outside = np.where(
        focal[:, 0] > 0, focal[:, 0] / (focal[:, 0] - focal[:, 1]), -focal[:, 0] / (focal[:, 2] - focal[:, 0])
    )
    for name, strays in (("pitch", np.abs(tilt[:, 0]) / (_SD_OF_90 * tilt[:, 3])), ("focal", outside)):
        for half in (0, 1):
            factor = float(np.nanpercentile(strays[half::2], 90))
            rest = strays[1 - half :: 2]
            rest = rest[np.isfinite(rest)]
            held = 100 * (rest < factor).mean()
            print(f"    {name} scaled by {factor:.2f} for half the pictures holds {held:.0f}% of the rest")


if __name__ == "__main__":
    main()
