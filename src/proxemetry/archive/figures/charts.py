"""The two figures of an archive that a paper needs: nearest others and zones by group, and over time (extra `plot`)."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ...distances import ZONE_LIMITS_M, ZONES
from ...errors import OutputError, SettingsError
from ...intervals import HIGH, LOW
from ...plots import save
from ...plots.zone_colours import ZONE_COLOURS
from .grouping import UNKNOWN
from .summary import Share, Summary

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_TIMES = ("year", "month")
#: More groups than this cannot be distinguished in one figure: those with most pairs are drawn.
_MAX_GROUPS = 24
#: The same of lines over time.
_MAX_LINES = 6


def draw(summary: Summary, folder: str | Path) -> list[Path]:
    """Draw the figures as PNG and PDF and return their paths.

    Raises SettingsError where matplotlib is missing, OutputError where they cannot be written.
    """
    folder = Path(folder)
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise OutputError(f"{folder}: figures cannot be written there ({error.strerror or error})") from error
    figures = {"distances_by_group": by_group(summary)}
    time = next((i for i, name in enumerate(summary.by) if name in _TIMES), None)
    if time is not None:
        figures["distances_over_time"] = over_time(summary, time)
    written: list[Path] = []
    for name, figure in figures.items():
        for ending in (".png", ".pdf"):
            written.append(folder / f"{name}{ending}")
            save(figure, written[-1])
    return written


def _new_figure(width_in: float, height_in: float, columns: int) -> tuple[Figure, Any]:
    try:
        from matplotlib.figure import Figure
    except ImportError as error:
        raise SettingsError("--figures needs matplotlib: pip install 'proxemetry[plot]'") from error
    figure = Figure(figsize=(width_in, height_in), layout="constrained")
    return figure, figure.subplots(1, columns, squeeze=False)[0]


def by_group(summary: Summary) -> Figure:
    """Return each group's distances to the nearest other as a box (quartiles, 5 % and 95 %) next to its zone shares."""
    with_pairs = [g for g, group in enumerate(summary.groups) if group.n_pairs]
    shown = sorted(sorted(with_pairs, key=lambda g: -summary.groups[g].n_pairs)[:_MAX_GROUPS])
    figure, (left, right) = _new_figure(9, 1.6 + 0.42 * max(len(shown), 1), 2)
    rows = np.arange(len(shown))[::-1]
    for row, g in zip(rows, shown, strict=True):
        start, end = np.searchsorted(summary.group_of_person, [g, g + 1])
        q05, q25, q50, q75, q95 = np.quantile(summary.nearest_m[start:end], [LOW, 0.25, 0.5, 0.75, HIGH])
        left.plot([q05, q95], [row, row], color="0.45", linewidth=1)
        left.barh(row, q75 - q25, left=q25, height=0.5, color="0.82", edgecolor="0.45")
        left.plot([q50, q50], [row - 0.25, row + 0.25], color="black", linewidth=2)
        _zone_points(right, row, summary.groups[g].zones)
    for limit in ZONE_LIMITS_M:
        left.axvline(limit, color="0.7", linewidth=0.8, linestyle=":")
    labels = [f"{_label(summary.groups[g].key)}  (n = {summary.groups[g].n_pairs})" for g in shown]
    left.set_yticks(rows, labels)
    left.set_xlabel(f"distance to the nearest other person, m{_left_out(len(with_pairs), len(shown))}")
    left.set_xlim(left=0)
    right.set_yticks(rows, [""] * len(rows))
    for axes in (left, right):
        axes.set_ylim(-0.6, max(len(shown), 1) - 0.4)
    right.set_xlim(0, 1)
    right.set_xlabel("share of all pairs in each of Hall's zones, 90 % intervals")
    right.set_xticks(np.linspace(0, 1, 6), [f"{share:.0%}" for share in np.linspace(0, 1, 6)])
    handles = [right.plot([], [], "o", color=ZONE_COLOURS[zone])[0] for zone in ZONES]
    figure.legend(handles, ZONES, loc="outside upper center", ncols=len(ZONES), frameon=False)
    return figure


def _left_out(there: int, shown: int) -> str:
    """Return how many groups a figure leaves out, as a line below its label."""
    return f"\nthe {shown} groups with the most pairs; {there - shown} more are in --csv" if there > shown else ""


def _zone_points(axes: Any, row: float, zones: Sequence[Share]) -> None:
    """Draw a group's zone shares as points with their intervals, each zone at a height of its own."""
    for k, (share, zone) in enumerate(zip(zones, ZONES, strict=True)):
        height = row + 0.24 - 0.16 * k
        if not math.isnan(share.low):
            axes.plot([share.low, share.high], [height, height], color=ZONE_COLOURS[zone], linewidth=1.6)
        axes.plot(share.value, height, "o", color=ZONE_COLOURS[zone], markersize=4.5, clip_on=False)


def over_time(summary: Summary, time: int) -> Figure:
    """Return the median distance to the nearest other over time with its 90 % band, a line a value of the rest."""
    figure, (axes,) = _new_figure(8, 4.2, 1)
    others: dict[str, list[Any]] = {}
    for group in summary.groups:
        if group.key[time] is not None and group.n_pairs:
            others.setdefault(_label(group.key[:time] + group.key[time + 1 :]), []).append(group)
    largest = sorted(others, key=lambda name: -sum(g.n_pairs for g in others[name]))[:_MAX_LINES]
    times = sorted({g.key[time] for name in largest for g in others[name]})
    place = {t: float(t) if summary.by[time] == "year" else i for i, t in enumerate(times)}
    step = min(np.diff(sorted(set(place.values()))), default=1.0)
    lines: list[Any] = []
    for name in largest:
        groups = sorted(others[name], key=lambda g: place[g.key[time]])
        # Bands of more than two lines hide each other: those get bars, side by side.
        many = len(largest) > 2
        x = np.array([place[g.key[time]] for g in groups]) + (largest.index(name) * 0.06 * step if many else 0)
        (line,) = axes.plot(x, [g.nearest_m.value for g in groups], marker="o", markersize=3)
        lines.append(line)
        low, high = ([getattr(g.nearest_m, end) for g in groups] for end in ("low", "high"))
        if many:
            axes.vlines(x, low, high, color=line.get_color(), linewidth=1)
        else:
            axes.fill_between(x, low, high, color=line.get_color(), alpha=0.18, linewidth=0)
    if summary.by[time] != "year":
        every = max(1, len(times) // 12)
        axes.set_xticks(range(0, len(times), every), times[::every], rotation=45, ha="right")
    else:
        axes.xaxis.get_major_locator().set_params(integer=True)
    axes.set_ylim(bottom=0)
    axes.set_ylabel("median distance to the nearest other person, m")
    axes.set_xlabel(
        f"{summary.by[time]} ({'bars' if len(largest) > 2 else 'band'}: 90 % interval of the median)"
        f"{_left_out(len(others), len(largest))}"
    )
    if any(largest):  # named one by one: by itself a legend leaves out names that begin with an underscore
        figure.legend(lines, largest, frameon=False, loc="outside right upper")
    return figure


def _label(key: tuple[str | None, ...]) -> str:
    from ...plots.fonts import drawable, without_formulas

    return without_formulas(drawable(", ".join(UNKNOWN if k is None else k for k in key)))
