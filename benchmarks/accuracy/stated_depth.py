"""Depths from elsewhere in the scene fit: an RGB-D camera's, a lidar's or a metric-depth network's, right and wrong.

    python -m benchmarks.accuracy.stated_depth [--photos 150] [--labels DIR] [--within 0.02] [--wrong 1.5]

Synthetic photos whose bodies and detector share nothing with the fit (`synthetic.scenes`): all of them, and those whose
people all stand within 10 m; with --labels also the layouts of the measured benchmark. The true focal
length is given. Rows: nothing stated; every person's depth right within 2 % (--within; evenly spread); with a normal
error of that standard deviation; then the latter with one person's depth multiplied by --wrong, stated as surely as
the others: how far everyone else moves, how much the distances among them change, and in how many photos the
contradiction is reported for that person and for anyone else.
"""

from __future__ import annotations

import argparse
import zlib
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from proxemetry.bodies import MOST_DEPTH_MISFIT, Bodies
from proxemetry.distances import measure_distances
from proxemetry.locate import LocateSettings, method_named
from proxemetry.people import People
from synthetic.layouts import photos
from synthetic.pair_errors import depth_summary, record, summary
from synthetic.scenes import SyntheticPhoto, scenes

#: As far as depth cameras for rooms see.
_NEAR_M = 10.0


def stated(photo: SyntheticPhoto, rel_sd: float, seed: int, *, even: bool = False) -> People:
    """Return a photo's people with their depths as an instrument of that precision measures them.

    even: no error is beyond rel_sd, and all up to it are alike; else they are normal.
    """
    rng = np.random.default_rng([seed, zlib.crc32(photo.people.keypoints_px.tobytes())])
    true = photo.positions_m[photo.owners, 2]
    off = rng.uniform(-1, 1, len(true)) if even else rng.standard_normal(len(true))
    depth = true * (1 + rel_sd * off)
    return replace(photo.people, depth_m=depth, depth_sd_m=rel_sd * depth / (np.sqrt(3) if even else 1))


def with_wrong(people: People, person: int, factor: float) -> People:
    """Return people one of whom is said to be elsewhere, as surely as before."""
    depth, sd = people.depth_m.copy(), people.depth_sd_m.copy()
    depth[person] *= factor
    sd[person] *= factor
    return replace(people, depth_m=depth, depth_sd_m=sd)


@dataclass(frozen=True)
class Moved:
    """What one wrong depth did: relative shifts of the others' depths and of their pairs, and who was doubted."""

    depths: list[float]
    pairs: list[float]
    wrong_one: float
    said: bool
    said_of_others: bool


def moved(before: Bodies, after: Bodies, person: int) -> Moved:
    """Return how the others moved when one depth became wrong."""
    others = np.flatnonzero((np.arange(len(before)) != person) & before.placed & after.placed)
    shift = np.abs(after.positions_m[:, 2] / before.positions_m[:, 2] - 1)
    one, other = (measure_distances(bodies).distance_m[np.ix_(others, others)] for bodies in (before, after))
    pairs = np.abs(other / one - 1)[np.triu_indices(len(others), 1)]
    doubted = np.abs(after.depth_misfit) > MOST_DEPTH_MISFIT
    return Moved(
        shift[others].tolist(), pairs.tolist(), float(shift[person]), bool(doubted[person]),
        bool(np.delete(doubted, person).any()),
    )  # fmt: skip


def one_wrong(sets: Sequence[SyntheticPhoto], rel_sd: float, factor: float, seed: int) -> list[Moved]:
    """Return what a wrong depth of one person, in turn the first, second ..., does in each photo of three or more."""
    locate, told = method_named("scene"), LocateSettings()
    answer: list[Moved] = []
    for number, photo in enumerate(p for p in sets if len(p.people) >= 3):
        people, person = stated(photo, rel_sd, seed), number % len(photo.people)
        before = locate(people, photo.camera, told, None)
        after = locate(with_wrong(people, person, factor), photo.camera, told, None)
        answer.append(moved(before, after, person))
    return answer


def report(name: str, sets: Sequence[SyntheticPhoto], rel_sd: float, factors: Sequence[float], seed: int) -> None:
    """Print one set's rows."""
    print(f"{name}: {len(sets)} photos, {sum(len(p.people) for p in sets)} people at "
          f"{np.median(np.concatenate([p.positions_m[:, 2] for p in sets])):.1f} m in the median")  # fmt: skip
    print(f"  {'':26s}{'pairs':>6s}{'mean%':>8s}{'median%':>8s}{'bias%':>8s}{'cover%':>8s}{'depth%':>8s}{'z':>6s}")
    for label, people_of in (
        ("nothing stated", lambda p: p.people),
        (f"right within {rel_sd:.0%}", lambda p: stated(p, rel_sd, seed, even=True)),
        (f"standard deviation {rel_sd:.0%}", lambda p: stated(p, rel_sd, seed)),
    ):  # fmt: skip
        records = record(sets, ("scene",), people_of=people_of)["scene"]
        s, (depth, _, z) = summary(records), depth_summary(records)
        print(f"  {label:26s}{s.pairs:6d}{s.mean_error_pct:8.1f}{s.median_error_pct:8.1f}{s.bias_pct:+8.1f}"
              f"{s.coverage_pct:8.1f}{depth:8.1f}{z:6.2f}")  # fmt: skip
    for factor in factors:
        found = one_wrong(sets, rel_sd, factor, seed)
        depths, pairs = np.concatenate([m.depths for m in found]), np.concatenate([m.pairs for m in found])
        print(f"  one depth times {factor:<4g}: others' depths move {100 * depths.mean():.2f} % (95 % of them up to "
              f"{100 * np.quantile(depths, 0.95):.2f} %), their pairs {100 * pairs.mean():.2f} % "
              f"({100 * np.quantile(pairs, 0.95):.2f} %), the one {100 * np.mean([m.wrong_one for m in found]):.1f} %; "
              f"said of that person in {100 * np.mean([m.said for m in found]):.0f} %, of another in "
              f"{100 * np.mean([m.said_of_others for m in found]):.0f} % of {len(found)} photos")  # fmt: skip


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--photos", type=int, default=150)
    parser.add_argument("--labels", type=Path)
    parser.add_argument("--within", type=float, default=0.02)
    parser.add_argument("--wrong", type=float, nargs="+", default=(1.5, 0.5))
    parser.add_argument("--seed", type=int, default=0)
    args = parser.parse_args()
    made_up = list(scenes(args.photos, args.seed))
    report("synthetic photos", made_up, args.within, args.wrong, args.seed)
    near = [photo for photo in made_up if photo.positions_m[:, 2].max() <= _NEAR_M]
    report(f"of these, everyone within {_NEAR_M:g} m", near, args.within, args.wrong, args.seed)
    if args.labels:
        report("measured layouts", list(photos(args.labels, args.seed)), args.within, args.wrong, args.seed)


if __name__ == "__main__":
    main()
