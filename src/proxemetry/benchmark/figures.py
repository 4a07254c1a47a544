"""Drawings of scores; the one place of the benchmark that needs matplotlib."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..errors import SettingsError
from .image_score import relative_errors
from .metrics import CONSTANT_MM

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from .scores import Score
    from .tables import Table


#: Errors are drawn up to here.
_HIGHEST_PCT = 100.0


def _figure(width: float, height: float) -> Figure:
    try:
        from matplotlib.figure import Figure
    except ImportError as error:
        raise SettingsError("drawing needs matplotlib: install proxemetry[plot]") from error
    return Figure(figsize=(width, height), layout="constrained")


def plot_score(score: Score) -> Figure:
    """Draw estimated over true distance, and the error over the true distance (Seker et al. 2021, figure 7)."""
    none = np.zeros(0)
    true = np.concatenate([none, *(image.true_mm for image in score.images)]) / 1000
    estimated = np.concatenate([none, *(image.estimated_mm for image in score.images)]) / 1000
    figure = _figure(10, 4.5)
    left, right = figure.subplots(1, 2)
    reach = 1.03 * float(max(true.max(initial=1.0), np.quantile(estimated, 0.99) if len(estimated) else 1.0))
    left.plot([0, reach], [0, reach], color="0.6", linewidth=1)
    left.scatter(true, estimated, s=8, alpha=0.5)
    left.set(xlabel="true distance (m)", ylabel="estimated distance (m)", xlim=(0, reach), ylim=(0, reach))
    errors = relative_errors(estimated, true)
    right.scatter(true, errors, s=8, alpha=0.3)
    _say_beyond(left, int((estimated > reach).sum()))
    _say_beyond(right, int((errors > _HIGHEST_PCT).sum()))
    bins = [b for b in score.overall.by_distance if b.n_pairs]
    middles = [(b.low_mm + min(b.high_mm, b.low_mm + 1000)) / 2000 for b in bins]
    right.plot(middles, [b.error_pct_mean for b in bins], marker="o", color="black", label="mean")
    right.plot(middles, [b.error_pct_median for b in bins], marker="s", color="tab:red", label="median")
    distances = np.linspace(CONSTANT_MM / 4000, max(true.max(initial=1.0), 2.0), 300)
    constant = relative_errors(np.full_like(distances, CONSTANT_MM / 1000), distances)
    right.plot(distances, constant, color="0.6", linestyle="--", label=f"{CONSTANT_MM / 1000:.2f} m for every pair")
    right.set(xlabel="true distance (m)", ylabel="error (%)", ylim=(0, _HIGHEST_PCT))
    right.legend(loc="upper right")
    figure.suptitle(score.caption, fontsize=8, wrap=True)
    return figure


def _say_beyond(axes: Axes, count: int) -> None:
    """Write how many pairs lie above the axis: what is cut off is not forgotten."""
    if count:
        white = {"facecolor": "white", "edgecolor": "none", "pad": 1.5}
        axes.text(0.02, 0.98, f"{count} above", transform=axes.transAxes, va="top", fontsize=8, color="0.3", bbox=white)


def plot_table(table: Table) -> Figure:
    """Draw the figures of a table's methods by row, the published ones as hollow markers; a total stands apart."""
    figure = _figure(8, 4.5)
    axes = figure.subplots()
    positions = np.arange(len(table.rows), dtype=float)
    total = [row.name == "all" for row in table.rows]
    for k, method in enumerate(table.methods):
        colour = f"C{k % 10}"
        ours = np.array([row.cells[method].value for row in table.rows])
        published = np.array([row.cells[method].published_value for row in table.rows])
        for values, line, face, label in (
            (ours, "-", colour, method),
            (published, ":", "none", f"{method}, published"),
        ):
            if np.isfinite(values).any():
                joined = np.where(total, np.nan, values)
                axes.plot(positions, joined, line, marker="o", color=colour, markerfacecolor=face, label=label)
                axes.plot(positions[total], values[total], marker="o", color=colour, markerfacecolor=face)
    axes.set_xticks(positions, [row.name for row in table.rows])
    axes.set(xlabel=table.row_header, ylabel="F1" if table.name == "f1" else f"pair error ({table.quantity})")
    axes.legend(fontsize=8)
    figure.suptitle(table.caption, fontsize=8, wrap=True)
    return figure
