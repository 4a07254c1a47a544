"""A score as a page of text for a terminal."""

from __future__ import annotations

import math
import textwrap
from collections.abc import Mapping

from ..distances import ZONES
from ..text_tables import WIDTH, Columns, in_blocks
from .metrics import Summary
from .paired import difference
from .scores import Score


def to_text(score: Score) -> str:
    """Return the whole score as tables, the caption first, the constant answer's figure next to every error."""
    overall = score.overall
    lines = [
        *textwrap.wrap(score.caption, WIDTH),
        "",
        *_overall(score),
        "",
        *_groups(score),
        "",
        *_by_distance(overall),
    ]
    lines += ["", *_zones(overall)]
    lines += ["", "F1 of 'nearer than': " + ", ".join(f"{t} m {_two_decimals(v)}" for t, v in overall.f1.items())]
    return "\n".join(lines) + "\n"


def _overall(score: Score) -> list[str]:
    o, averaged = score.overall, "photos" if score.protocol == "seker2021" else "people"
    rows = [
        ("pair error, mean over photos", _answered(o, o.pair_error_pct_mean_over_images), "%",
         "pair_error_pct_mean_over_images"),
        ("  answering 1.70 m for every pair", o.baseline_constant_pct, "%", ""),
        ("pair error, mean over pairs", o.pair_error_pct_mean_over_pairs, "%", "pair_error_pct_mean_over_pairs"),
        ("pair error, median over pairs", o.pair_error_pct_median_over_pairs, "%", "pair_error_pct_median_over_pairs"),
        ("pair error in space, mean over photos", o.pair_error_3d_pct_mean_over_images, "%", ""),
        ("signed bias, mean over pairs", o.signed_bias_pct, "%", "signed_bias_pct"),
        ("|ln(estimated/true)|, mean over pairs", o.log_ratio_abs_mean, "", ""),
        (f"detection rate, over {averaged}", o.detection_rate * 100, "%", "detection_rate"),
        (f"false discovery rate, over {averaged}", o.false_discovery_rate * 100, "%", "false_discovery_rate"),
        ("pairs scored of those annotated", o.pair_recall * 100, "%", "pair_recall"),
        (f"coverage of 90 % intervals ({o.n_intervals} pairs)", o.coverage_90 * 100, "%", "coverage_90"),
        ("mean width of the intervals", o.interval_width_mm_mean / 1000, "m", ""),
    ]  # fmt: skip
    shares = ("detection_rate", "false_discovery_rate", "pair_recall", "coverage_90")
    lines = [] if o.n_pairs else ["no answer: no pair of people was placed, so there is no error"]
    for name, value, unit, key in rows:
        if not math.isfinite(value):
            continue
        low, high = (bound * (100 if key in shares else 1) for bound in o.ci95.get(key, (math.nan, math.nan)))
        interval = f"  [{low:.1f}, {high:.1f}]" if math.isfinite(low) else ""
        lines.append(f"{name:<42}{value:>8.2f} {unit:<2}{interval}".rstrip())
    return [*lines, "(in brackets: 95 % bootstrap intervals over photos)"]


def _groups(score: Score) -> list[str]:
    lines = [
        f"{'group':<22}{'photos':>7}{'unscored':>9}{'error %':>9}{'1.70 m %':>9}{'bias %':>8}{'found':>7}{'false':>7}"
    ]
    for group in score.groups:
        s = group.summary
        name = f"{group.name} mm" if group.by == "focal_mm" else group.name
        error = _answered(s, s.pair_error_pct_mean_over_images)
        shown = (error, 9), (s.baseline_constant_pct, 9), (s.signed_bias_pct, 8), (s.detection_rate, 7)
        cells = "".join(_two_decimals(v).rjust(width) for v, width in (*shown, (s.false_discovery_rate, 7)))
        lines.append(f"{name:<22}{s.n_images:>7}{s.n_unscored:>9}{cells}")
    return lines


def _by_distance(summary: Summary) -> list[str]:
    lines = [f"{'true distance':<22}{'pairs':>7}{'mean %':>9}{'median %':>9}{'bias %':>8}"]
    for b in summary.by_distance:
        if b.n_pairs:
            name = f"{b.low_mm / 1000:g} to {b.high_mm / 1000:g} m" if math.isfinite(b.high_mm) else (
                f"{b.low_mm / 1000:g} m and more")  # fmt: skip
            lines.append(
                f"{name:<22}{b.n_pairs:>7}{b.error_pct_mean:>9.2f}{b.error_pct_median:>9.2f}{b.bias_pct:>8.2f}"
            )
    return lines


def _zones(summary: Summary) -> list[str]:
    lines = [f"{'true zone, answered:':<22}" + "".join(f"{zone:>10}" for zone in ZONES)]
    for zone, row in zip(ZONES, summary.confusion, strict=True):
        if sum(row):
            lines.append(f"{zone:<22}" + "".join(f"{count:>10}" for count in row))
    return lines


def _answered(summary: Summary, value: float) -> float:
    """Return a figure, NaN without a single pair: the published protocol counts that as an error of 0."""
    return value if summary.n_pairs else math.nan


def _two_decimals(value: float) -> str:
    return f"{value:.2f}" if math.isfinite(value) else "-"


def comparison(scores: Mapping[str, Score], width: int = WIDTH) -> str:
    """Return one line a method: the figures to choose by, under the protocol and the labels they were scored on."""
    (reference, first), *others = scores.items()
    heads = (
        "method", "pairs", "unscored", "error %", "95 %", "median %", "bias %", "found", "false", "cover", "width m",
        *([f"against {reference} %"] if others else []),
    )  # fmt: skip
    rows: list[tuple[str, ...]] = [heads]
    for name, score in scores.items():
        o = score.overall
        low, high = (_answered(o, end) for end in o.ci95.get("pair_error_pct_mean_over_images", (math.nan, math.nan)))
        rows.append((
            name, str(o.n_pairs), str(o.n_unscored), _two_decimals(_answered(o, o.pair_error_pct_mean_over_images)),
            f"{low:.1f}-{high:.1f}" if math.isfinite(low) else "-", _two_decimals(o.pair_error_pct_median_over_pairs),
            _two_decimals(o.signed_bias_pct), _two_decimals(o.detection_rate), _two_decimals(o.false_discovery_rate),
            _two_decimals(o.coverage_90), _two_decimals(o.interval_width_mm_mean / 1000),
            *([_difference(score, first)] if others else []),
        ))  # fmt: skip
    baseline = ["-"] * len(heads)
    pairs, error = str(first.overall.n_annotated_pairs), _two_decimals(first.overall.baseline_constant_pct)
    baseline[:4] = ["1.70 m for all", pairs, "-", error]
    rows.append(tuple(baseline))
    columns = list(zip(*rows, strict=True))
    names, *figures = [Columns("", (column[0],), tuple((cell,) for cell in column[1:])) for column in columns]
    caption = f"protocol {first.protocol}; labels {first.labels}; {first.overall.n_images} photos"
    explained = "error: mean over photos; median, bias: over pairs; cover: of the 90 % intervals"
    paired = f"; against {reference}: over the photos that both score" if others else ""
    note = textwrap.wrap(f"({explained}{paired}; -: no answer)", width)
    return "\n".join([*textwrap.wrap(caption, width), *in_blocks(names, figures, width), *note]) + "\n"


def _difference(score: Score, first: Score) -> str:
    """Return how much more a method errs than the first, with its 95 % interval."""
    apart = difference(score, first)
    if score is first or not apart.n_images:
        return "-"
    low, high = apart.ci95
    return f"{apart.pair_error_pct_mean_over_images:+.1f} [{low:+.1f}, {high:+.1f}]"
