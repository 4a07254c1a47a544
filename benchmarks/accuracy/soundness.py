"""Do the other stated probabilities hold? Zones, groups, headings, statures, floors and uncertain focal lengths.

    python -m benchmarks.accuracy.soundness [--count 300] [--method scene]

Synthetic groups in front of all cameras (`synthetic/scenes.py`), on seeds that no constant was chosen on;
`calibration.py` has the intervals of distances at every level. A focal length with a standard deviation of s is the
true one times e^x, x normal with that deviation, and is stated so, as `--assume-fov` does.
"""

from __future__ import annotations

import argparse
import itertools
import math
from collections.abc import Iterator
from dataclasses import dataclass, field, replace

import numpy as np

from proxemetry import distances, formations
from proxemetry.bodies import Bodies
from proxemetry.intervals import HALF_WIDTH_SD
from proxemetry.locate import LocateSettings, method_named
from synthetic.scenes import Recipe, SyntheticPhoto, scenes

SEED = 2000
FOCAL_SDS = (0.0, 0.025, 0.05, 0.1, 0.2)
EDGES = (0.0, 0.02, 0.1, 0.3, 0.5, 0.7, 0.9, 0.98, 1.0 + 1e-9)


@dataclass
class Tally:
    """What was stated and what was so: probabilities with outcomes, and errors in standard deviations by quantity."""

    zones: list[tuple[float, bool]] = field(default_factory=list)
    groups: list[tuple[float, bool]] = field(default_factory=list)
    errors: dict[str, list[float]] = field(default_factory=dict)
    intervals: dict[str, list[tuple[bool, float]]] = field(default_factory=dict)

    def error(self, quantity: str, error: float, sd: float) -> None:
        """Note an error with the standard deviation that was stated for it."""
        if math.isfinite(error) and math.isfinite(sd):
            self.errors.setdefault(quantity, []).append(error / sd)

    def interval(self, name: str, low: float, high: float, true: float) -> None:
        """Note whether an interval holds the truth, and how wide it is relative to it."""
        if math.isfinite(low):
            self.intervals.setdefault(name, []).append((low <= true <= high, (high - low) / true))


def truly_grouped(photo: SyntheticPhoto, i: int, j: int) -> bool:
    """Whether two people form an F-formation where they truly stand, facing as they truly do."""
    place = photo.ground_mm[:, 0] / 1000 + 1j * photo.ground_mm[:, 1] / 1000
    if abs(place[i] - place[j]) > formations.GROUP_REACH_M:
        return False
    facing = -1j * np.exp(1j * photo.heading_rad[[i, j]])
    others = np.array([p for k, p in enumerate(place) if k not in (i, j)], dtype=complex)
    return bool(formations.face_each_other(place[[i]], place[[j]], facing[:, None], others)[0])


def note_people(tally: Tally, photo: SyntheticPhoto, bodies: Bodies) -> None:
    """Note how far off everyone's place, heading and stature are, and the camera's height and pitch."""
    for row, owner in enumerate(photo.owners):
        if not bodies.placed[row]:
            continue
        apart = bodies.positions_m[row] - photo.positions_m[owner]
        for axis, name in enumerate(("to the right", "down", "depth")):
            tally.error(name, apart[axis], bodies.position_sd_m[row, axis])
        turned = float(np.angle(np.exp(1j * (bodies.heading_rad[row] - photo.heading_rad[owner]))))
        tally.error("heading", turned, bodies.heading_sd_rad[row])
        tally.error("stature", bodies.stature_m[row] - photo.stature_m[owner], bodies.stature_sd_m[row])
    if bodies.floor is not None:
        floor = bodies.floor
        tally.error("camera height", floor.height_m - photo.height_m, floor.height_sd_m)
        tally.error("pitch", floor.pitch_rad - photo.pitch_rad, floor.pitch_sd_rad)
        tally.error("roll", floor.roll_rad - photo.roll_rad, floor.roll_sd_rad)


def pairs(photo: SyntheticPhoto, bodies: Bodies) -> Iterator[tuple[int, int, int, int]]:
    """Yield rows and owners of every two detections of different people."""
    for i, owner in enumerate(photo.owners):
        for j, other in enumerate(photo.owners[:i]):
            if owner != other and bodies.placed[[i, j]].all():
                yield i, j, int(owner), int(other)


def note_pairs(tally: Tally, photo: SyntheticPhoto, bodies: Bodies) -> None:
    """Note the zones, groups and intervals of all pairs."""
    answer = distances.measure_distances(bodies)
    for i, j, owner, other in pairs(photo, bodies):
        spatial = float(np.linalg.norm(photo.positions_m[owner] - photo.positions_m[other]))
        true = float(photo.distances_m[owner, other]) if answer.on_ground else spatial
        zone = distances.zone_of(true)
        for k, name in enumerate(distances.ZONES):
            tally.zones.append((float(answer.zone_probability[i, j, k]), zone == name))
        if math.isfinite(answer.group_probability[i, j]):
            tally.groups.append((float(answer.group_probability[i, j]), truly_grouped(photo, owner, other)))
        tally.interval("distance", answer.low_m[i, j], answer.high_m[i, j], true)
        rise = math.sqrt(max(answer.distance_3d_m[i, j] ** 2 - answer.distance_m[i, j] ** 2, 0.0))
        low, high = (math.hypot(edge[i, j], rise) for edge in (answer.low_m, answer.high_m))
        tally.interval("in space", low, high, spatial)


def measured(count: int, method: str) -> tuple[Tally, dict[float, Tally]]:
    """Fit all photos with the true focal length, and with unsure ones."""
    recipe, settings = Recipe(focal_mm=(24.0, 35.0, 50.0, 85.0)), LocateSettings()
    sure, unsure = Tally(), {sd: Tally() for sd in FOCAL_SDS}
    for number, photo in enumerate(scenes(count, SEED, recipe)):
        rng = np.random.default_rng([SEED, number, 1])
        for sd in FOCAL_SDS:
            said = photo.camera.with_focal(photo.camera.f_px * math.exp(sd * rng.standard_normal()), focal_rel_sd=sd)
            bodies = method_named(method)(photo.people, said, settings)
            note_pairs(unsure[sd], photo, bodies)
            if not sd:
                note_people(sure, photo, bodies)
    return replace(sure, zones=unsure[0.0].zones, groups=unsure[0.0].groups), unsure


def print_reliability(name: str, stated: list[tuple[float, bool]]) -> None:
    """Print the share of cases in which what was given a probability was so, by that probability."""
    if not stated:
        return
    p, so = np.array([s for s, _ in stated]), np.array([o for _, o in stated])
    print(f"| {name}, stated | cases | mean stated | observed |\n|---|---|---|---|")
    for low, high in itertools.pairwise(EDGES):
        here = (p >= low) & (p < high)
        if here.any():
            print(f"| {low:.2f}-{min(high, 1):.2f} | {here.sum()} | {p[here].mean():.3f} | {so[here].mean():.3f} |")
    base = so.mean()
    print(f"Brier score {np.mean((p - so) ** 2):.4f}, of always saying {base:.2f}: {base * (1 - base):.4f}\n")


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--count", type=int, default=300)
    parser.add_argument("--method", default="scene")
    args = parser.parse_args()
    sure, unsure = measured(args.count, args.method)
    print_reliability("zone", sure.zones)
    print_reliability("group", sure.groups)
    print(
        "| quantity | cases | within 90 % | error over sd: median of its size (0.674) | bias |\n|---|---|---|---|---|"
    )
    for name, errors in sure.errors.items():
        z = np.array(errors)
        held = np.mean(np.abs(z) <= HALF_WIDTH_SD)
        print(f"| {name} | {len(z)} | {100 * held:.1f} | {np.median(np.abs(z)):.2f} | {np.median(z):+.2f} |")
    print("\n| sd of the focal length | pairs | 90 % holds | width | in space | width |\n|---|---|---|---|---|---|")
    for sd, tally in unsure.items():
        cells = []
        for name in ("distance", "in space"):
            held, width = np.array(tally.intervals[name]).T
            cells += [f"{100 * held.mean():.1f}", f"{100 * np.median(width):.0f} %"]
        print(f"| {100 * sd:g} % | {len(tally.intervals['distance'])} | {' | '.join(cells)} |")


if __name__ == "__main__":
    main()
