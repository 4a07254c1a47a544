"""The paper's tables for any methods, the published figures next to ours: text, CSV, LaTeX, plot.

`all`, `outdoor`, `indoor`: detection rate and pair error by focal length (tables 2-4), `elevated`: the camera on the
balcony (table 5), `f1`: the binary question (table 6).
"""

from __future__ import annotations

import csv
import functools
import io
import math
import textwrap
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from importlib.resources import files

from ..errors import SettingsError
from ..text_tables import WIDTH, Columns, in_blocks
from .labels import LabelImage
from .metrics import F1_THRESHOLDS_M, Summary
from .scores import Score

#: Table -> what it shows.
TABLES = {
    "all": "detection rate and pair error by focal length, all photos",
    "outdoor": "detection rate and pair error by focal length, outdoor (standing)",
    "indoor": "detection rate and pair error by focal length, indoor (seated)",
    "elevated": "the elevated camera, outdoor C2",
    "f1": "F1 of 'nearer than ...', over scored pairs",
}
_PAPER_WIDTH_PX = 4160  # the paper counts 16 photos of outdoor C2: those of the camera with files of this width
_PUBLISHED_UNDER = "seker2021"
_REFERENCE = "combined"  # the published method to hold others against
_NAN = float("nan")


@dataclass(frozen=True)
class Cell:
    """One method in one row: value (error in per cent, or F1) and detection rate, ours and published, NaN if none.

    answers_nothing: the method was scored, and placed no pair.
    """

    value: float = _NAN
    rate: float = _NAN
    published_value: float = _NAN
    published_rate: float = _NAN
    answers_nothing: bool = False


@dataclass(frozen=True)
class Row:
    """One line: its name, how many photos it counts, and a cell a method."""

    name: str
    n_images: int
    cells: dict[str, Cell]


@dataclass(frozen=True)
class Table:
    """A table of methods; `quantity` names the cells' value, `caption` what they were scored on."""

    name: str
    row_header: str
    quantity: str
    caption: str
    methods: tuple[str, ...]
    rows: tuple[Row, ...]

    def columns(self) -> list[tuple[str, Callable[[Row], float], str]]:
        """Return (heading, value of a row, format) for every column that holds a number."""
        answer = [
            (f"{method} {head}", _getter(method, name), ".2f")
            for method in self.methods
            for head, name in self._kinds()
        ]
        return [c for c in answer if any(math.isfinite(c[1](row)) for row in self.rows)]

    def to_text(self, width: int = WIDTH) -> str:
        """Return the table for a terminal, the caption above it and each method's columns under its name."""
        keys = Columns("", (self.row_header, "photos"), tuple((row.name, str(row.n_images)) for row in self.rows))
        groups = [self._group(method) for method in self.methods]
        lines = in_blocks(keys, [group for group in groups if group.heads], width)
        missing = [m for m in self.methods if all(row.cells[m].answers_nothing for row in self.rows)]
        notes = [f"no answer (-): {', '.join(missing)} placed no pair of people"] if missing else []
        caption = textwrap.wrap(f"{TABLES[self.name]}; {self.caption}", width)
        return "\n".join([*caption, *lines, *notes]) + "\n"

    def _group(self, method: str) -> Columns:
        """Return a method's columns for a terminal: those with a number, and what it was asked where it has none."""
        cells = [row.cells[method] for row in self.rows]
        found = [(head, name) for head, name in self._kinds() if any(math.isfinite(getattr(c, name)) for c in cells)]
        if any(cell.answers_nothing for cell in cells) and "value" not in {name for _, name in found}:
            found.insert(1 if self.name != "f1" else 0, (self.quantity, "value"))
        rows = tuple(tuple(_cell(getattr(cell, name)) for _, name in found) for cell in cells)
        return Columns(method, tuple(head for head, _ in found), rows)

    def _kinds(self) -> list[tuple[str, str]]:
        """Return heading and attribute of what a cell may hold, in order."""
        kinds = [(self.quantity, "value"), (f"published {self.quantity}", "published_value")]
        rates = [("rate", "rate"), ("published rate", "published_rate")]
        return kinds if self.name == "f1" else [pair for both in zip(rates, kinds, strict=True) for pair in both]

    def to_csv(self) -> str:
        """Return the table with a header; empty where there is no number."""
        output = io.StringIO()
        csv.writer(output, lineterminator="\n").writerows(self._grid(""))
        return output.getvalue()

    def to_latex(self) -> str:
        """Return a LaTeX table (booktabs)."""
        header, *body = [[_latex(cell) for cell in row] for row in self._grid("--")]
        lines = [" & ".join(row) + r" \\" for row in body]
        return "\n".join([
            r"\begin{table}", rf"\caption{{{_latex(TABLES[self.name] + '; ' + self.caption)}}}", r"\centering",
            rf"\begin{{tabular}}{{l{'r' * (len(header) - 1)}}}", r"\toprule", " & ".join(header) + r" \\",
            r"\midrule", *lines, r"\bottomrule", r"\end{tabular}", r"\end{table}",
        ]) + "\n"  # fmt: skip

    def _grid(self, nothing: str) -> list[list[str]]:
        columns = self.columns()
        body = [
            [row.name, str(row.n_images), *(format(v, f) if math.isfinite(v := value(row)) else nothing
                                            for _, value, f in columns)]
            for row in self.rows
        ]  # fmt: skip
        return [[self.row_header, "photos", *(heading for heading, _, _ in columns)], *body]


def _getter(method: str, attribute: str) -> Callable[[Row], float]:
    return lambda row: getattr(row.cells[method], attribute)


def _cell(value: float) -> str:
    return f"{value:.2f}" if math.isfinite(value) else "-"


def _latex(text: str) -> str:
    for character in "&%$#_{}":
        text = text.replace(character, "\\" + character)
    return text


def make_table(name: str, scores: Mapping[str, Score]) -> Table:
    """Return a table of methods by name; raises SettingsError for an unknown one, or scores of mixed protocols."""
    if name not in TABLES:
        raise SettingsError(f"table {name!r} is unknown: use one of {', '.join(TABLES)}")
    if len({score.protocol for score in scores.values()}) != 1:
        raise SettingsError("a table needs one or more scores of one protocol")
    if name == "f1":
        rows, header, quantity = _f1_rows(scores), "metres", "F1"
    elif name == "elevated":
        rows, header, quantity = _elevated_rows(scores), "camera", "%"
    else:
        rows, header, quantity = _focal_rows(name, scores), "mm", "%"
    methods = tuple(dict.fromkeys((*scores, _REFERENCE)))
    first = next(iter(scores.values()))
    caption = first.caption if len(scores) == 1 else f"protocol {first.protocol}; labels {first.labels}"
    if first.protocol != _PUBLISHED_UNDER:
        caption += f"; published figures: protocol {_PUBLISHED_UNDER}"
    return Table(name, header, quantity, caption, methods, tuple(rows))


def _focal_rows(name: str, scores: Mapping[str, Score]) -> list[Row]:
    def shown(label: LabelImage) -> bool:
        return name in ("all", label.setting)

    first = next(iter(scores.values()))
    lenses = {i.label.focal_mm for i in first.images if shown(i.label) and math.isfinite(i.label.focal_mm)}
    rows = [
        _row(name, f"{focal:g}", scores, lambda label, focal=focal: shown(label) and label.focal_mm == focal)
        for focal in sorted(lenses)
    ]
    return [*rows, _row(name, "all", scores, shown)]


def _elevated_rows(scores: Mapping[str, Score]) -> list[Row]:
    def elevated(label: LabelImage) -> bool:
        return label.setting == "outdoor" and label.camera == "C2"

    paper = _row("elevated", "all", scores, lambda label: elevated(label) and label.width == _PAPER_WIDTH_PX)
    whole = _row("", "C2, every lens", scores, elevated)
    return [Row(f"C2, files {_PAPER_WIDTH_PX} px wide", paper.n_images, paper.cells), whole]


def _row(table: str, row: str, scores: Mapping[str, Score], keep: Callable[[LabelImage], bool]) -> Row:
    published = published_figures()
    cells: dict[str, Cell] = {}
    for method in (*scores, _REFERENCE):
        summary = scores[method].select(keep) if method in scores else None
        rate, error = published.get((table, row, method), (_NAN, _NAN))
        rated = summary.detection_rate if summary else _NAN
        cells[method] = Cell(_error(summary), rated, error, rate, summary is not None and not summary.n_pairs)
    first = next(iter(scores.values()))
    return Row(row, sum(keep(image.label) for image in first.images), cells)


def _error(summary: Summary | None) -> float:
    """Return the error to print: none without a single pair, which the published protocol counts as 0."""
    return summary.pair_error_pct_mean_over_images if summary and summary.n_pairs else _NAN


def _f1_rows(scores: Mapping[str, Score]) -> list[Row]:
    published = {(row["threshold_m"], row["method"]): float(row["f1"]) for row in _data("published_f1.csv")}
    rows: list[Row] = []
    for key in (f"{threshold:.1f}" for threshold in F1_THRESHOLDS_M):
        cells = {
            method: Cell(
                value=scores[method].overall.f1[key] if method in scores else _NAN,
                published_value=published.get((key, method), _NAN),
                answers_nothing=method in scores and not scores[method].overall.n_pairs,
            )
            for method in (*scores, _REFERENCE)
        }
        rows.append(Row(key, next(iter(scores.values())).overall.n_images, cells))
    return rows


@functools.cache
def published_figures() -> dict[tuple[str, str, str], tuple[float, float]]:
    """Return (table, row, method) -> (detection rate, error in per cent) as the paper prints them, NaN for a dash."""
    return {
        (row["table"], row["row"], row["method"]): (
            float(row["detection_rate"]), float(row["error_pct"]) if row["error_pct"] else _NAN
        )
        for row in _data("published.csv")
    }  # fmt: skip


def _data(name: str) -> list[dict[str, str]]:
    text = (files("proxemetry.benchmark") / name).read_text(encoding="utf-8")
    return list(csv.DictReader(text.splitlines()))
