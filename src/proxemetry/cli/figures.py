"""`proxemetry figures`: circles on the floor and the floor from above, for photos of a results folder."""

from __future__ import annotations

import argparse
import importlib.util

from ..archive.figures.floor_drawings import KINDS, draw
from ..archive.store.results import Results
from ..errors import SettingsError
from ..plots.faces import FACES
from . import DONE, SOME_FAILED
from .camera_options import number

_EXAMPLES = """examples:
  proxemetry figures results                                 both kinds, circles of 2 m, for every photo
  proxemetry figures results --kind circles --within 1.5 "frame_00*.jpg"
  proxemetry figures results --kind birds-eye --faces show --out figures

circles: the photo with a circle on the floor around each person; two circles touch where two people are nearer than
--within, and lines show how probable that is. birds-eye: the floor as seen from above, rectified from the photo, with a
metre grid and the people on it.
"""


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the options."""
    parser.epilog = _EXAMPLES
    parser.add_argument("results", metavar="DIR", help="results folder of `proxemetry measure`")
    parser.add_argument("photos", nargs="*", metavar="PHOTO", help="names or patterns of photos in it (default: all)")
    parser.add_argument("--kind", action="append", choices=KINDS, help="may be given again (default: both)")
    parser.add_argument("--within", type=number, default=2.0, metavar="M", help="the limit in metres (default: 2)")
    parser.add_argument("--faces", choices=FACES, default="blur", help="pixelate heads (default: blur)")
    parser.add_argument("--out", metavar="DIR", help="where to write (default: DIR/figures)")


def run(args: argparse.Namespace) -> int:
    """Draw the figures and print where they are."""
    if importlib.util.find_spec("matplotlib") is None:
        raise SettingsError("figures need matplotlib: pip install 'proxemetry[plot]'")
    results = Results.open(args.results, or_clip=True)
    drawn = draw(
        results, args.out, args.photos, kinds=args.kind or KINDS, within_m=args.within, faces=args.faces,
        on_written=lambda path: print(path, flush=True),
    )  # fmt: skip
    if not drawn:
        raise SettingsError(f"{args.results}: no measured photo there matches {' or '.join(args.photos)}")
    return SOME_FAILED if results.usable().damaged else DONE
