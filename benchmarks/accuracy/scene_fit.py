"""The joint fit and the paper's estimators on the layouts of a measured benchmark, simulated with synthetic bodies.

    python -m benchmarks.accuracy.scene_fit --labels DIR [--repeats 2] [--bodies synthetic|mocap FILE] [--lines]

The true focal length is given. Neither the bodies nor the detector share anything with the fit.
"""

from __future__ import annotations

import argparse
import math
import zlib
from pathlib import Path

import numpy as np

from proxemetry.camera import Mount
from proxemetry.camera.lines import gravity_from_lines
from proxemetry.locate import LocateSettings
from synthetic.layouts import drawn_body, photos
from synthetic.line_scenes import seen_by
from synthetic.mocap import mocap_bodies
from synthetic.pair_errors import constant_error_pct, depth_summary, record, summary
from synthetic.scenes import SyntheticPhoto

METHODS = ("scene", "combined", "torso", "shoulder")
CONSTANT_M = 1.70


def mount_of(photo: SyntheticPhoto) -> Mount | None:
    """Return gravity as a detector's segments tell it, on a building or floor that stands anyhow before the camera."""
    camera, rng = photo.camera, np.random.default_rng(zlib.crc32(f"{photo.name} {photo.roll_rad}".encode()))
    kind = ("street", "odd angles", "one wall", "few")[int(rng.integers(4))]
    pitch, roll = math.degrees(photo.pitch_rad), math.degrees(photo.roll_rad)
    seen = seen_by(kind, rng, camera.width, camera.height, camera.f_px, pitch, roll)
    gravity = gravity_from_lines(seen.segments_px, camera)
    return None if gravity is None else gravity.mount()


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--labels", type=Path, required=True)
    parser.add_argument("--mocap", type=Path, help="use captured postures instead of drawn ones (standing only)")
    parser.add_argument("--repeats", type=int, default=2)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--methods", nargs="+", default=METHODS)
    parser.add_argument("--body-size", default=LocateSettings().body_size)
    parser.add_argument("--lines", action="store_true", help="the scene fit also with gravity from straight lines")
    args = parser.parse_args()
    body = mocap_bodies(args.mocap) if args.mocap else drawn_body
    sets = (p for k in range(args.repeats) for p in photos(args.labels, args.seed + k, body=body))
    told = LocateSettings(body_size=args.body_size)
    every = list(sets)
    results = record(every, tuple(args.methods), told)
    if args.lines:
        results["with lines"] = record(every, ("scene",), told, mount_of=mount_of)["scene"]
    groups = sorted(set(next(iter(results.values())).group))
    print(f"{'':24s}{'method':10s}{'pairs':>6s}{'miss%':>7s}{'mean%':>8s}{'median%':>8s}{'bias%':>8s}{'cover%':>8s}"
          f"{'width%':>8s}{'depth%':>8s}{'bias%':>7s}{'z':>6s}")  # fmt: skip
    for group in (*groups, "feet hidden", None):
        for method, records in results.items():
            s = summary(records, group)
            depth, bias, z = depth_summary(records, group)
            print(f"{group or 'all':24s}{method:10s}{s.pairs:6d}{s.missing_pct:7.0f}{s.mean_error_pct:8.1f}"
                  f"{s.median_error_pct:8.1f}{s.bias_pct:+8.1f}{s.coverage_pct:8.1f}{s.width_pct:8.0f}"
                  f"{depth:8.1f}{bias:+7.1f}{z:6.2f}")  # fmt: skip
        error = constant_error_pct(next(iter(results.values())), CONSTANT_M, group)
        print(f"{group or 'all':24s}{'1.70 m':10s}{'':6s}{'':7s}{error:8.1f}")
    for method, records in results.items():
        print(f"{method}: {1000 * records.seconds / max(records.people, 1):.2f} ms a person")


if __name__ == "__main__":
    main()
