"""`proxemetry export`: the tables again, for SPSS, as COCO keypoints, and the codebook."""

from __future__ import annotations

import argparse

from ..archive.figures.export import COCO_FILE, write_coco, write_spss
from ..archive.figures.spreadsheet import Locale, write_local_csv, write_xlsx
from ..archive.store.folder import Folder
from ..archive.store.results import TABLE_FORMATS, Results
from ..archive.store.run_file import is_of_clip
from ..clip.columns import codebook_page
from ..clip.tables_again import write_again
from ..errors import SettingsError
from ..tables import TABLES
from . import DONE, SOME_FAILED
from .camera_options import number

FORMATS = (*TABLE_FORMATS, "xlsx", "spss", "coco")

_EXAMPLES = """examples:
  proxemetry export results                         the CSV and Parquet tables again, with corrections applied
  proxemetry export results --format xlsx           one Excel workbook that includes the codebook
  proxemetry export results --format csv --locale fi --out tables    decimal commas, semicolons
  proxemetry export results --format spss           photos.sav, people.sav, pairs.sav with labels
  proxemetry export results --format coco --out elsewhere
  proxemetry export --codebook                      what every column means
"""


def configure(parser: argparse.ArgumentParser) -> None:
    """Add this command's options."""
    parser.epilog = _EXAMPLES
    parser.add_argument("results", nargs="?", metavar="DIR", help="results folder")
    parser.add_argument(
        "--format",
        type=_formats,
        default=TABLE_FORMATS,
        metavar="A,B",
        help="comma-separated: csv, parquet, xlsx, spss, coco (default: csv,parquet)",
    )
    parser.add_argument("--out", metavar="DIR", help="where to write (default: the results folder)")
    parser.add_argument(
        "--locale", metavar="NAME", help="write CSV as this country's spreadsheet reads it: fi, de_AT, en; needs --out"
    )
    parser.add_argument(
        "--safe-distance",
        type=number,
        metavar="M",
        help="count the pairs nearer than M metres (default: as in the run)",
    )
    parser.add_argument("--codebook", action="store_true", help="print the codebook and do nothing else")


def _formats(text: str) -> tuple[str, ...]:
    chosen = tuple(part.strip() for part in text.split(","))
    if unknown := [c for c in chosen if c not in FORMATS]:
        raise argparse.ArgumentTypeError(f"{', '.join(unknown)}: use {', '.join(FORMATS)}")
    return chosen


def run(args: argparse.Namespace) -> int:
    """Write what was asked for and return the exit code."""
    if args.codebook:
        print(codebook_page(), end="")
        return DONE
    if args.results is None:
        raise SettingsError("no results named: proxemetry export DIR")
    if is_of_clip(Folder(args.results)):
        return _clip(args)
    results = Results.open(args.results)
    results.require_finished()
    target = Folder(args.out) if args.out else results.folder
    safe = results.run.get("safe_distance_m") if args.safe_distance is None else args.safe_distance
    tables = [f for f in args.format if f in TABLE_FORMATS]
    written: list[str] = []
    if args.locale is not None:
        written += write_local_csv(results, target, _locale(args, results.folder, target), safe)
        tables = [form for form in tables if form != "csv"]
    if tables:
        results.write_tables(safe, target, tables)
        written += [f"{table}.{form}" for form in tables for table in TABLES] + ["codebook.csv"]
    if "xlsx" in args.format:
        written.append(write_xlsx(results, target, safe))
    if "spss" in args.format:
        written += write_spss(results, target, safe)
    if "coco" in args.format:
        write_coco(results, target)
        written.append(COCO_FILE)
    print(f"written to {target.location}: {', '.join(written)}")
    return SOME_FAILED if results.usable().damaged else DONE


def _clip(args: argparse.Namespace) -> int:
    """Write a clip's tables in other forms; CSV, Parquet and COCO are there from the start."""
    folder = Folder(args.results)
    target = Folder(args.out) if args.out else folder
    if args.safe_distance is not None:
        raise SettingsError("--safe-distance: of a clip ask `proxemetry video --within`")
    locale = None if args.locale is None else _locale(args, folder, target)
    written = write_again(folder, target, args.format, locale)
    if not written:
        print(f"{folder.location}: {', '.join(args.format)} are there already; --out copies them")
        return DONE
    print(f"written to {target.location}: {', '.join(written)}")
    return DONE


def _locale(args: argparse.Namespace, folder: Folder, target: Folder) -> Locale:
    """Return the locale of CSV files; the results folder's own stay as scripts expect them."""
    if "csv" not in args.format:
        raise SettingsError("--locale is for CSV: add --format csv")
    if target.location == folder.location:
        raise SettingsError("--locale needs --out: the results folder keeps its CSV files as scripts read them")
    return Locale.named(args.locale)
