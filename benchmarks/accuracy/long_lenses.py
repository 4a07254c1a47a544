"""Telephotos from above, with feet visible and hidden: what straight lines contribute to the pitch and the distances.

    python -m benchmarks.accuracy.long_lenses --labels DIR [--repeats 6] [--seed 300] [--exact]

The elevated photos of a measured benchmark's layouts, simulated with synthetic bodies in front of buildings at
random angles, as in `scene_fit --lines`; only these photos, so that there are more of them. `--exact` adds rows with
the pitch known to half a degree, the most that lines could contribute.
"""

from __future__ import annotations

import argparse
import math
import zlib
from pathlib import Path

import numpy as np

from benchmarks.accuracy.scene_fit import mount_of
from proxemetry.camera import Mount
from proxemetry.intervals import HALF_WIDTH_SD
from synthetic.layouts import photos
from synthetic.pair_errors import record, summary
from synthetic.scenes import SyntheticPhoto

LONG_MM, EXACT_RAD = 105.0, math.radians(0.5)


def exact(photo: SyntheticPhoto) -> Mount:
    """Return the true pitch and roll within half a degree."""
    rng = np.random.default_rng(zlib.crc32(f"{photo.name} {photo.roll_rad}".encode()))
    pitch = photo.pitch_rad + EXACT_RAD * rng.standard_normal()
    return Mount.stated(pitch, photo.roll_rad, math.nan, pitch_sd_rad=EXACT_RAD, roll_sd_rad=EXACT_RAD)


def group(photo: SyntheticPhoto, feet: bool) -> str:
    """Return the row of the table."""
    lens = "105 mm and more" if photo.focal_mm >= LONG_MM else "shorter"
    return f"{lens}, {'feet seen' if feet else 'feet hidden'}"


def main() -> None:
    """Print what is told of the pitch by focal length, and the table of pairs."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--labels", type=Path, required=True)
    parser.add_argument("--repeats", type=int, default=6)
    parser.add_argument("--seed", type=int, default=300)
    parser.add_argument("--exact", action="store_true")
    args = parser.parse_args()
    every = [
        p for k in range(args.repeats) for p in photos(args.labels, args.seed + k)
        if p.kind == "elevated" and p.focal_mm >= LONG_MM
    ]  # fmt: skip
    told = {id(photo): mount_of(photo) for photo in every}
    for focal_mm in sorted({photo.focal_mm for photo in every}):
        of = [photo for photo in every if photo.focal_mm == focal_mm]
        heard = [(photo, mount) for photo in of if (mount := told[id(photo)]) is not None]
        off = np.degrees([mount.pitch_rad - photo.pitch_rad for photo, mount in heard])
        sd = np.degrees([mount.sd[0] for _, mount in heard])
        held = f"holds {np.mean(np.abs(off) < HALF_WIDTH_SD * sd):.0%}" if heard else ""
        off_by = f"off by {np.median(np.abs(off)):.1f} degrees in the median, sd {np.median(sd):.1f}" if heard else ""
        print(f"{focal_mm:4.0f} mm: pitch told in {len(heard)} of {len(of)}, {off_by}, {held}")
    ways = {"without lines": lambda photo: None, "with lines": lambda photo: told[id(photo)]}
    ways |= {"pitch known": exact} if args.exact else {}
    telling = [photo for photo in every if told[id(photo)] is not None]
    for name, chosen in (("all", every), ("where lines tell", telling)):
        results = {way: record(chosen, ("scene",), group=group, mount_of=mount)["scene"] for way, mount in ways.items()}
        for row in sorted(set(results["without lines"].group)):
            for way, records in results.items():
                s = summary(records, row)
                print(f"{name:18s}{row:30s}{way:15s}{s.pairs:5d} pairs, mean error {s.mean_error_pct:5.1f} %, median "
                      f"{s.median_error_pct:5.1f}, bias {s.bias_pct:+6.1f}, holds {s.coverage_pct:3.0f} %, width "
                      f"{s.width_pct:3.0f} %")  # fmt: skip


if __name__ == "__main__":
    main()
