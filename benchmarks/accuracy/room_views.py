"""Three people in a room with calibrated cameras, level to steep: errors of the people's and the cameras' places.

    python -m benchmarks.accuracy.room_views ../shared/data/panoptic_poses --mocap FILE [--seed 2] [--bands]

The cameras are CMU Panoptic's 31 high-definition ones: 0.7 to 3.4 m high, -15 to 53 degrees down, rolled by up to 7.
`standing`: three people of the synthetic population in captured upright postures (`synthetic/mocap.py`), 0.5 to 1.5 m
around a point near the room's middle, more or less facing it. Folder names stand for the three seated people
whose joints were measured there. The focal length is given, the camera's place is not.

Joints: as they are (`true`), or disturbed by a back end's row (`disturbed_joints.py`), with the measured noise and with
half of it, which is about what calibrated photos show (`benchmarks/networks/calibrated_views.py`), each without, with
half and with all of the systematic errors on rendered people. Nothing was chosen on `band2` or on seed 2.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from itertools import product
from pathlib import Path

import numpy as np

from benchmarks.accuracy.captured_people import JOINTS, View, frames_of, views_of
from benchmarks.accuracy.disturbed_joints import HABITS, Disturbance
from proxemetry.arrays import FloatArray
from proxemetry.distances import measure_distances
from proxemetry.locate import LocateSettings, method_named
from proxemetry.people.skeleton import COCO_17
from synthetic.layouts import DrawBody
from synthetic.mocap import mocap_bodies

#: Pitches in degrees, from and to.
BANDS = ((-20, 10), (10, 20), (20, 35), (35, 60))
_TO_90 = 1.645
_LEAST_JOINTS = 5


@dataclass(frozen=True, eq=False)
class Scene:
    """One view of people: COCO's joints (P, 17, 3) and the middles of their torsos (P, 3), in metres in the room."""

    view: View
    joints_m: FloatArray
    middles_m: FloatArray

    @property
    def down(self) -> FloatArray:
        """Gravity's direction in the camera frame; the room's y points down."""
        return self.view.rotation[:, 1]

    @property
    def pitch_deg(self) -> float:
        """How far the camera looks down."""
        return float(np.rad2deg(np.arcsin(self.down[2])))


def captured(folder: Path, every: int = 10) -> Iterator[Scene]:
    """Yield the measured people of a folder of `panoptic_poses`."""
    shown = [JOINTS.index(joint) for joint in COCO_17.joints]
    views = views_of(next(folder.glob("calibration_*.json")))
    for joints_m, view in product(frames_of(folder, every), views):
        middles = (joints_m[:, JOINTS.index("neck")] + joints_m[:, JOINTS.index("mid_hip")]) / 2
        known = np.isfinite(middles).all(axis=1)
        yield Scene(view, joints_m[known][:, shown], middles[known])


def standing(views: Sequence[View], body: DrawBody, seed: int, repeat: int) -> Iterator[Scene]:
    """Yield three people who stand together, others in every view."""
    for turn, (number, view) in product(range(repeat), enumerate(views)):
        rng = np.random.default_rng([seed, turn, number])
        centre, radius, start = rng.uniform(-0.3, 0.3, 2), rng.uniform(0.5, 1.3), rng.uniform(0, 2 * np.pi)
        joints, middles = list[FloatArray](), list[FloatArray]()
        for third in range(3):
            angle = start + 2 * np.pi * third / 3 + rng.normal(0, 0.35)
            x, z = centre + radius * rng.uniform(0.8, 1.2) * np.array([np.cos(angle), np.sin(angle)])
            drawn, _ = body(rng, False)
            facing = np.arctan2(centre[1] - z, centre[0] - x) + rng.normal(0, 0.5)
            forward, up = np.array([np.cos(facing), 0.0, np.sin(facing)]), np.array([0.0, -1.0, 0.0])
            axes = np.stack([forward, np.cross(up, forward), up])
            at = {name: point @ axes + (x, 0.0, z) for name, point in drawn.items()}
            joints.append(np.array([at[joint] for joint in COCO_17.joints]))
            middles.append((at["neck"] + at["mid_hip"]) / 2)
        yield Scene(view, np.array(joints), np.array(middles))


@dataclass
class Answers:
    """Depths: true pitch, found over true, standard deviation over true. Pairs: true pitch, true, found, low, high.
    Pitches: true, error, standard deviation, in degrees."""

    depths: list[tuple[float, ...]] = field(default_factory=list)
    pairs: list[tuple[float, ...]] = field(default_factory=list)
    pitches: list[tuple[float, ...]] = field(default_factory=list)

    def add(self, scene: Scene, disturbance: Disturbance, rng: np.random.Generator) -> None:
        """Measure one scene."""
        people = disturbance.seen(scene.view.seen(scene.joints_m), scene.view.camera, scene.down, rng)
        keep = np.flatnonzero((people.scores > 0).sum(axis=1) >= _LEAST_JOINTS)
        if len(keep) < 2:
            return
        bodies = method_named("scene")(people[keep], scene.view.camera, LocateSettings(), None)
        distances, middles = measure_distances(bodies), scene.middles_m[keep]
        true_m = scene.view.seen(middles)[:, 2]
        sd_m = bodies.position_sd_m[:, 2]
        self.depths += [
            (scene.pitch_deg, found / true, sd / true)
            for found, true, sd in zip(bodies.positions_m[:, 2], true_m, sd_m, strict=True)
        ]
        apart = np.linalg.norm((middles[:, None] - middles)[..., [0, 2]], axis=-1)
        ends = (distances.distance_m, distances.low_m, distances.high_m)
        self.pairs += [(scene.pitch_deg, apart[p], *(end[p] for end in ends)) for p in distances.pairs()]
        if bodies.floor is not None:
            told, sd = np.rad2deg([bodies.floor.pitch_rad, bodies.floor.pitch_sd_rad])
            self.pitches.append((scene.pitch_deg, told - scene.pitch_deg, sd))

    def line(self, low_deg: float, high_deg: float) -> str:
        """Return the figures of cameras between two pitches; people without an answer count as not placed."""
        depths, pairs, pitches = (
            np.array([row for row in rows if low_deg <= row[0] < high_deg]).T
            for rows in (self.depths, self.pairs, self.pitches)
        )
        placed, told = np.isfinite(depths[1]), np.isfinite(pairs[2])
        depths, pairs = depths[:, placed], pairs[:, told]
        held = np.mean(np.abs(depths[1] - 1) <= _TO_90 * depths[2])
        off = np.mean(np.abs(pairs[2] / pairs[1] - 1))
        inside = np.mean((pairs[3] <= pairs[1]) & (pairs[1] <= pairs[4]))
        return (
            f"{placed.sum():3d} of {len(placed):3d} placed, depth x{np.median(depths[1]):.2f}, {held:4.0%} in 90 % | "
            f"{told.sum():3d} pairs {off:5.1%} off, {inside:4.0%} in 90 %, "
            f"width {np.median((pairs[4] - pairs[3]) / pairs[2]):3.0%} | pitch {np.median(pitches[1]):+5.1f}, "
            f"{np.mean(np.abs(pitches[1]) <= _TO_90 * pitches[2]):4.0%} in 90 %"
        )


def disturbances() -> Iterator[tuple[str, Disturbance]]:
    """Yield every way of seeing with its name."""
    yield "true", Disturbance("", 0.0)
    for name, noise, habits in product(HABITS, (1.0, 0.5), (0.0, 0.5, 1.0)):
        yield f"{name}, noise x{noise:g}, habits x{habits:g}", Disturbance(name, noise, habits)


def main() -> None:
    """Print a line for each way of seeing."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("poses", type=Path)
    parser.add_argument("--mocap", type=Path, required=True)
    parser.add_argument("--seed", type=int, default=2)
    parser.add_argument("--repeat", type=int, default=3)
    parser.add_argument("--bands", action="store_true", help="print a line for each band of pitches too")
    args = parser.parse_args()
    folders = sorted(p for p in args.poses.iterdir() if p.is_dir())
    views = views_of(next(folders[0].glob("calibration_*.json")))
    sets = {"standing": list(standing(views, mocap_bodies(args.mocap), args.seed, args.repeat))}
    sets |= {folder.name: list(captured(folder)) for folder in folders}
    for set_name, scenes in sets.items():
        print(set_name)
        for label, disturbance in disturbances():
            answers, rng = Answers(), np.random.default_rng(args.seed)
            for scene in scenes:
                answers.add(scene, disturbance, rng)
            print(f"  {label:44s} {answers.line(-90, 90)}", flush=True)
            for low, high in BANDS if args.bands else ():
                print(f"    {f'{low} to {high} degrees':42s} {answers.line(low, high)}", flush=True)


if __name__ == "__main__":
    main()
