"""How much could a better start gain? The joint fit from its own coarse start, and from the truth itself.

    python -m benchmarks.accuracy.oracle_start --labels DIR [--repeats 2]

No learned start can be nearer than the truth: camera, places, headings and postures as they are. The difference between
the two answers is the most that a network trained to start the fit could gain.
"""

from __future__ import annotations

import argparse
from dataclasses import replace
from pathlib import Path

import numpy as np

from proxemetry.locate import LocateSettings
from proxemetry.locate.scenefit import fit as joint_fit
from proxemetry.locate.scenefit.body_tables import POSTURES
from proxemetry.locate.scenefit.projection import HEIGHT, PITCH, ROLL
from proxemetry.locate.scenefit.start import HEADINGS, Start
from synthetic.layouts import photos
from synthetic.pair_errors import Records, record, summary
from synthetic.scenes import SyntheticPhoto

SEED = 4000
#: The truth's posture and heading are this much likelier than any other (negative log).
_SURE = 30.0


def from_the_truth(start: Start, photo: SyntheticPhoto) -> Start:
    """Return the start with everything that is true of the photo in place of what was looked up."""
    truth = photo.positions_m[photo.owners]
    shared = start.shared.copy()
    shared[PITCH], shared[ROLL], shared[HEIGHT] = photo.pitch_rad, photo.roll_rad, np.log(photo.height_m)
    cost, log_depth, point = start.cost.copy(), start.log_depth.copy(), start.point.copy()
    log_depth[:] = np.log(truth[:, 2])[:, None, None]
    plane = truth[:, :2] / truth[:, 2:]
    point[:] = plane[:, None, None]
    for row, owner in enumerate(photo.owners):
        heading = np.cos(HEADINGS - photo.heading_rad[owner]).argmax()
        cost[row, POSTURES.index("seated" if photo.seated[owner] else "standing"), heading] -= _SURE
    return replace(start, shared=shared, cost=cost, log_depth=log_depth, point=point)


def from_truth(photo_set: list[SyntheticPhoto]) -> Records:
    """Run the fit with every start replaced by the truth."""
    real, current = joint_fit.initialise, iter(photo_set)

    def initialise(*arguments):
        start, photo = real(*arguments), next(current)
        return from_the_truth(start, photo) if len(start.cost) == len(photo.people) else start

    joint_fit.initialise = initialise
    try:
        return record(photo_set, ("scene",), LocateSettings())["scene"]
    finally:
        joint_fit.initialise = real


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--labels", type=Path, required=True)
    parser.add_argument("--repeats", type=int, default=2)
    args = parser.parse_args()
    some = [p for k in range(args.repeats) for p in photos(args.labels, SEED + k) if len(p.people)]
    own, best = record(some, ("scene",), LocateSettings())["scene"], from_truth(some)
    print(f"{'':24s}{'pairs':>6s}{'mean %, own start':>20s}{'from the truth':>16s}{'bias':>8s}{'':>8s}{'in 90 %':>9s}")
    for group in (*sorted(set(own.group)), None):
        a, b = summary(own, group), summary(best, group)
        print(f"{group or 'all':24s}{a.pairs:6d}{a.mean_error_pct:20.1f}{b.mean_error_pct:16.1f}{a.bias_pct:+8.1f}"
              f"{b.bias_pct:+8.1f}{a.coverage_pct:9.1f}{b.coverage_pct:8.1f}")  # fmt: skip
    apart = np.abs(np.array(own.depth_m) / np.array(best.depth_m) - 1)
    print(f"depths within 1 % of one another: {100 * np.nanmean(apart < 0.01):.0f} % of people")


if __name__ == "__main__":
    main()
