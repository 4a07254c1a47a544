"""`proxemetry summary`: print an archive's figures by year, country, folder or any other column."""

from __future__ import annotations

import argparse
import csv
import io
import math
import sys
import textwrap
from typing import IO, Any

from ..archive.figures.focal_bases import in_words
from ..archive.figures.grouping import GROUPINGS, UNKNOWN
from ..archive.figures.shoots import shoots_in_words
from ..archive.figures.summary import Share, Summary, summarise
from ..archive.store.current_tables import current_tables
from ..archive.store.folder import Folder
from ..archive.store.results import Results
from ..camera import FocalBasis
from ..distances import ZONES
from ..errors import one_line
from ..files import cell_of
from ..people.attributes import PairsWhere
from ..plots.pair_selection import metres_text
from ..text_tables import Columns, in_blocks, terminal_width
from . import DONE, SOME_FAILED
from .attribute_options import add_pairs_where

_EXAMPLES = f"""examples:
  proxemetry summary results --by year
  proxemetry summary results --by country --by year --csv figures.csv
  proxemetry summary results --by folder --figures figures
  proxemetry summary results --pairs-where mask=no
  proxemetry summary results --methods

--by takes {", ".join(GROUPINGS)} or any column of the photos table. Brackets are 90 % intervals if the photos are a
sample; the sampling unit is the photo, since the pairs in one photo are not independent.
"""


def configure(parser: argparse.ArgumentParser) -> None:
    """Add this command's options."""
    parser.epilog = _EXAMPLES
    parser.add_argument("results", metavar="DIR", help="results folder")
    parser.add_argument("--by", action="append", default=[], metavar="WHAT", help="group by this; may be given again")
    add_pairs_where(parser)
    parser.add_argument("--methods", action="store_true", help="print a methods paragraph to paste, and nothing else")
    parser.add_argument("--distinct", action="store_true", help="count copies of a file only once in each group")
    parser.add_argument(
        "--csv", metavar="FILE", help="write the figures as CSV too (- for stdout, instead of the table)"
    )
    parser.add_argument(
        "--figures", metavar="DIR", help="draw the distribution by group and, with years or months, over time"
    )


def run(args: argparse.Namespace) -> int:
    """Print, write and draw the figures; return the exit code."""
    results = Results.open(args.results)
    with current_tables(results) as tables:
        _summarise(results, tables.folder, args)
        return SOME_FAILED if tables.damaged else DONE


def _summarise(results: Results, tables: Folder, args: argparse.Namespace) -> None:
    if args.methods:
        from ..archive.figures.methods import methods_paragraph

        print(textwrap.fill(methods_paragraph(results.run, tables, PairsWhere.parsed(args.pairs_where)), 100))
        return
    by = [name.strip() for text in args.by for name in text.split(",") if name.strip()]
    where = PairsWhere.parsed(args.pairs_where)
    summary = summarise(results, by, distinct=args.distinct, where=where, tables=tables)
    if where is not None and args.csv != "-":
        print(f"only people with {where} count, and pairs of two such people")
    if args.csv == "-":
        _write_csv(summary, sys.stdout)
    else:
        _print(summary)
        for said in shoots_in_words(results.folder):
            print(textwrap.fill(f"--same-camera: {said}", terminal_width(), subsequent_indent="  "))
    if args.csv and args.csv != "-":
        folder, slash, name = args.csv.rpartition("/")
        text = io.StringIO()
        _write_csv(summary, text)
        Folder(folder or slash or ".").write(name, text.getvalue().encode())
    if args.figures:
        from ..archive.figures.charts import draw

        for path in draw(summary, args.figures):
            print(path, file=sys.stderr)


def _write_csv(summary: Summary, file: IO[str]) -> None:
    rows = summary.rows()
    writer = csv.DictWriter(file, list(rows[0]) if rows else [], lineterminator="\n")
    writer.writeheader()
    writer.writerows({name: _cell(value) for name, value in row.items()} for row in rows)


def _cell(value: Any) -> Any:
    if isinstance(value, float):
        return "" if math.isnan(value) else f"{value:.5g}"
    return "" if value is None else cell_of(value) if isinstance(value, str) else value


def _print(summary: Summary) -> None:
    groups = summary.groups
    keys = Columns(
        "", (*summary.by, "photos"),
        tuple((*(UNKNOWN if k is None else one_line(k) for k in group.key), str(group.n_photos)) for group in groups),
    )  # fmt: skip
    nearest = tuple((str(g.n_people), _metres(g.nearest_m)) for g in groups)
    pairs = tuple((str(g.n_pairs), *map(_percent, g.zones), _metres(g.pairs_m)) for g in groups)
    figures = [
        Columns("nearest other person", ("people", "median m"), nearest),
        Columns("all pairs", ("pairs", *ZONES, "median m"), pairs),
    ]
    print("\n".join(in_blocks(keys, figures, terminal_width())))
    for note in (
        "nearest other person: quote its median; that of all pairs mostly reflects the size of crowds",
        "zones: shares of all pairs, each counted by its probabilities",
    ):
        print(note)
    bases = {basis: sum(group.bases[basis] for group in groups) for basis in FocalBasis}
    if any(bases.values()):
        text = f"focal lengths of the measured photos: {in_words(bases)}; by group in --csv"
        print(textwrap.fill(text, terminal_width(), subsequent_indent="  "))
    if any(not math.isnan(group.pairs_m.low) for group in groups):
        print("[ ]: 90 % intervals if the photos are a sample; none where they are too few")


def _metres(share: Share) -> str:
    return metres_text(share.value, share.low, share.high).replace(" m", "") if math.isfinite(share.value) else "-"


def _percent(share: Share) -> str:
    if math.isnan(share.value):
        return "-"
    if math.isnan(share.low):
        return f"{share.value:.0%}"
    return f"{share.value:.0%} [{100 * share.low:.0f}, {100 * share.high:.0f}]"
