"""`proxemetry score`: predictions against a benchmark's labels; needs numpy alone."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Generator, Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any

from ..archive.store.folder import RUN_FILE
from ..benchmark import DEFAULT_PROTOCOL, PROTOCOLS, Score, score_files
from ..benchmark.figures import plot_score, plot_table
from ..benchmark.report import comparison, to_text
from ..benchmark.tables import TABLES, make_table
from ..benchmark.validate_labels import check_labels
from ..errors import OutputError, SettingsError
from ..text_tables import terminal_width
from . import DONE, SOME_FAILED

_EXAMPLES = """examples:
  proxemetry score predictions.json --labels korte/
  proxemetry score results/ --labels korte/ --protocol seker2021 --json score.json
  proxemetry score torso=a.json combined=b.json --labels korte/ --table outdoor --format latex
  proxemetry score --check korte/
"""

#: No method is so much too short by itself: centimetres for millimetres are 90 % too short, metres 99.9 %.
_BIAS_OF_A_UNIT_PCT = -80.0


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the command's options."""
    parser.epilog = _EXAMPLES
    parser.add_argument(
        "predictions", nargs="*", metavar="PREDICTIONS",
        help="prediction file or results folder of `measure`; give several as NAME=FILE",
    )  # fmt: skip
    parser.add_argument("--labels", metavar="DIR", help="folder with the three label files")
    parser.add_argument(
        "--protocol", choices=list(PROTOCOLS), default=DEFAULT_PROTOCOL,
        help="rules of scoring: v1, corrected (default), or seker2021, as published",
    )  # fmt: skip
    parser.add_argument("--json", metavar="FILE", help="write the score to this file")
    parser.add_argument("--csv", metavar="FILE", help="write one row per photo to this file")
    parser.add_argument("--plot", metavar="FILE", help="draw the score, or the table, to this file (.png, .pdf, .svg)")
    parser.add_argument("--table", choices=list(TABLES), help="one of the paper's tables instead of the whole score")
    parser.add_argument(
        "--format", choices=("text", "csv", "latex"), default="text", help="form of --table (default: text)"
    )
    parser.add_argument("--check", metavar="DIR", help="list every fault of a labels folder, and score nothing")


def run(args: argparse.Namespace) -> int:
    """Score, or check; 1 where a check found faults."""
    if args.check:
        faults = check_labels(args.check)
        for fault in faults:
            print(fault)
        count = sum(not fault.harmless for fault in faults)
        print(f"{args.check}: {count or 'no'} fault{'' if count == 1 else 's'}")
        return SOME_FAILED if count else DONE
    if not args.predictions or not args.labels:
        raise SettingsError("score needs PREDICTIONS and --labels DIR, or --check DIR")
    check_output(args, len(args.predictions))
    scores, damaged = {}, False
    for name, path in map(_named, args.predictions):
        with _answers(path) as (answers, lacks_photos):
            scores[name] = replace(score_files(answers, args.labels, args.protocol), predictions=path)
        damaged |= lacks_photos
    if len(scores) < len(args.predictions):
        raise SettingsError("two predictions have the same name: give each as NAME=FILE")
    show(scores, args)
    return SOME_FAILED if damaged else DONE


@contextmanager
def _answers(path: str) -> Generator[tuple[str, bool]]:
    """Yield where a method's answers are, of results the tables as they are now, and whether damage left some out."""
    if not Path(path, RUN_FILE).is_file():
        yield path, False
        return
    from ..archive.store.current_tables import current_tables
    from ..archive.store.results import Results

    results = Results.open(path)
    with current_tables(results, formats=("csv",)) as tables:
        here = tables.folder.location == results.folder.location
        yield (path if here else tables.folder.location), bool(tables.damaged)


def _doubts(score: Score) -> Iterator[str]:
    """Yield what looks like a mistake in a whole file, so that its score is not taken for a method's."""
    bias = score.overall.signed_bias_pct
    if bias < _BIAS_OF_A_UNIT_PCT:
        yield f"distances are {1 + bias / 100:.2g} of the true ones on average: positions and distances are millimetres"
    if score.n_misshapen:
        yield (
            f"the pictures of {score.n_misshapen} predictions have another shape than the labelled ones: are width and "
            "height swapped, or the points of a cropped picture?"
        )
    if score.n_outside:
        yield (
            f"most points of {score.n_outside} predictions lie outside a picture of the width and height given: state "
            "those of the picture that the points were found in"
        )


def _named(text: str) -> tuple[str, str]:
    """Split NAME=FILE; a file that exists under the whole text is not split."""
    name, separator, path = text.partition("=")
    if separator and not Path(text).exists():
        return name, path
    return Path(text).stem, text


def check_output(args: argparse.Namespace, count: int) -> None:
    """Refuse options that cannot be followed for `count` scores, before anything is computed."""
    if args.format != "text" and not args.table:
        raise SettingsError("--format goes with --table")
    if count > 1 and (args.json or args.csv or (args.plot and not args.table)):
        raise SettingsError("--json, --csv and --plot are for one prediction or method (--plot also for a --table)")


def show(scores: dict[str, Score], args: argparse.Namespace) -> None:
    """Print scores, or one table of them, and write the files asked for (`check_output`)."""
    for name, one in scores.items():
        for doubt in _doubts(one):
            print(f"proxemetry: {name}: {doubt}", file=sys.stderr)
    if args.table:
        table = make_table(args.table, scores)
        text = {"csv": table.to_csv, "latex": table.to_latex}.get(args.format, lambda: table.to_text(terminal_width()))
        print(text(), end="")
        if args.plot:
            _write_figure(args.plot, plot_table(table))
    else:
        for name, score in scores.items():
            print((f"{name}: " if len(scores) > 1 else "") + to_text(score))
        if len(scores) > 1:
            print(comparison(scores, terminal_width()), end="")
    score = next(iter(scores.values()))
    if args.json:
        _write(args.json, score.to_json())
    if args.csv:
        _write(args.csv, score.to_csv())
    if args.plot and not args.table:
        _write_figure(args.plot, plot_score(score))


def _write(path: str, text: str) -> None:
    try:
        Path(path).write_text(text, encoding="utf-8")
    except OSError as error:
        raise OutputError(f"{path}: cannot be written ({error.strerror})") from error


def _write_figure(path: str, figure: Any) -> None:
    from ..plots import render

    try:
        render(figure, Path(path), dpi=150)
    except (OSError, ValueError) as error:
        raise OutputError(f"{path}: cannot be drawn ({error})") from error
