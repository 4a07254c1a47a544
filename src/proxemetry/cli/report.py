"""`proxemetry report`: one page on a results folder."""

from __future__ import annotations

import argparse
import importlib.util

from ..errors import SettingsError
from ..people.attributes import PairsWhere
from ..plots.faces import FACES
from ..report import write_report
from . import DONE, SOME_FAILED
from .attribute_options import add_pairs_where

_EXAMPLES = """examples:
  proxemetry report results                           writes results/report.html, heads pixelated
  proxemetry report results --group-by country        compares countries, as the photos' metadata name them
  proxemetry report results --out essay.html --faces show
"""


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the options."""
    parser.epilog = _EXAMPLES
    parser.add_argument("results", metavar="DIR", help="results folder of `proxemetry measure`")
    parser.add_argument("--out", metavar="FILE", help="where to write the page (default: DIR/report.html)")
    parser.add_argument("--faces", choices=FACES, default="blur", help="pixelate heads in the figures (default: blur)")
    parser.add_argument(
        "--group-by", default="folder", metavar="WHAT",
        help="compare photos by folder, year, month, country or another column of photos.csv (default: folder)",
    )  # fmt: skip
    add_pairs_where(parser)
    parser.add_argument("--photos", type=int, default=6, metavar="N", help="figures in the sample (default: 6)")


def run(args: argparse.Namespace) -> int:
    """Write the report."""
    if importlib.util.find_spec("matplotlib") is None:
        raise SettingsError("the report's figures need matplotlib: pip install 'proxemetry[plot]'")
    if args.photos < 0:
        raise SettingsError(f"--photos is {args.photos}: it must be 0 or more")
    report = write_report(
        args.results,
        args.out,
        faces=args.faces,
        group_by=args.group_by,
        photos=args.photos,
        where=PairsWhere.parsed(args.pairs_where),
    )
    print(f"report: {report.path}")
    return SOME_FAILED if report.damaged else DONE
