"""Numbers and labels on a panel, none over another.

Laid out in typographic points from the figure's lower left corner, y up, and drawn in data coordinates: the same on a
600-pixel photo and on one of 24 megapixels, at any resolution that the figure is saved at.
"""

from __future__ import annotations

import functools

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patheffects import Stroke, withStroke
from matplotlib.textpath import TextPath

from ..arrays import FloatArray
from .pair_selection import text_on
from .placement import along, place

_NOTHING = np.zeros((0, 4))
_BADGE_PT, _LABEL_PT = (8.0, 6.4), (8.5, 6.8)  # few people, many people
_MANY = 14
_PAD_PT = 2.6
_PILL = {"boxstyle": "round,pad=0.26", "facecolor": "white", "edgecolor": "#333333", "linewidth": 0.6, "alpha": 0.94}


def to_points(axes: Axes, data: FloatArray) -> FloatArray:
    """Return data coordinates (n, 2) as points from the figure's lower left corner."""
    display = axes.transData.transform(np.asarray(data, dtype=float).reshape(-1, 2))
    return np.asarray(display, dtype=float) * (72 / _dpi(axes))


def _to_data(axes: Axes, points: FloatArray) -> FloatArray:
    display = np.asarray(points, dtype=float).reshape(-1, 2) * (_dpi(axes) / 72)
    return np.asarray(axes.transData.inverted().transform(display), dtype=float)


def _dpi(axes: Axes) -> float:
    figure = axes.get_figure(root=True)
    assert figure is not None
    return float(figure.dpi)


def panel_box(axes: Axes) -> FloatArray:
    """Return a panel's rectangle x0, y0, x1, y1 in points."""
    return np.array(axes.bbox.extents, dtype=float) * (72 / _dpi(axes))


def badge_radius_pt(count: int) -> float:
    """Return the radius of the numbered discs where there are `count` people."""
    return 0.95 * _BADGE_PT[count > _MANY]


def draw_badges(
    axes: Axes, spots: list[FloatArray], numbers: list[int], colours: list[str], *, with_dots: bool = False
) -> FloatArray:
    """Draw each person's number in a disc at its first free spot; return the discs' boxes in points, shape (n, 4).

    spots: per person candidates in points, shape (c, 2); a disc that had to leave the first gets a line to it, and
    with_dots a dot there: a number beside its place must not be taken for the place.
    """
    if not spots:
        return _NOTHING
    radius, size_pt = badge_radius_pt(len(spots)), _BADGE_PT[len(spots) > _MANY]
    sizes = np.full((len(spots), 2), 2 * radius + 1)
    centres = place(spots, sizes, _NOTHING, _NOTHING, panel_box(axes))
    for centre, number, colour, options in zip(centres, numbers, colours, spots, strict=True):
        if not np.isfinite(centre).all():
            continue
        if np.linalg.norm(options[0] - centre) > 1.3 * radius:
            _leader(axes, centre, options[0])
        if with_dots and np.linalg.norm(options[0] - centre) > 0.5:
            axes.scatter(
                *_to_data(axes, options[0])[0], s=(0.6 * radius) ** 2, color=colour, edgecolors="#000000",
                linewidths=0.8, zorder=6.2,
            )  # fmt: skip
        x, y = _to_data(axes, centre)[0]
        axes.scatter(x, y, s=(2 * radius) ** 2, color=colour, edgecolors="#000000", linewidths=0.8, zorder=6)
        axes.text(
            x, y, str(number), fontsize=size_pt, weight="bold", color=text_on(colour), ha="center",
            va="center_baseline", zorder=6.1,
        )  # fmt: skip
    return np.concatenate([centres - sizes / 2, centres + sizes / 2], axis=1)[np.isfinite(centres).all(axis=1)]


def draw_pair_labels(
    axes: Axes, ends: list[tuple[FloatArray, FloatArray]], texts: list[str], taken: FloatArray, avoid: FloatArray
) -> FloatArray:
    """Write each text by its line, with a thin leader where it had to move; return the labels' boxes in points.

    ends: each line's two ends in points. taken, avoid: rectangles in points as in `placement.place`. A label for
    which the panel has no room is left out: its row of the answer, shape (n, 4), is NaN.
    """
    if not texts:
        return _NOTHING
    size_pt = _LABEL_PT[len(texts) > _MANY]
    sizes = np.array([_extent_pt(text, size_pt) for text in texts]) + 2 * _PAD_PT
    candidates = [along(start, end, sizes[0, 1] * 0.62) for start, end in ends]
    centres = place(candidates, sizes, taken, avoid, panel_box(axes) + np.array([2.0, 2.0, -2.0, -2.0]))
    for centre, text, (start, end), size in zip(centres, texts, ends, sizes, strict=True):
        if not np.isfinite(centre).all():
            continue
        foot = _nearest(centre, start, end)
        if np.linalg.norm(foot - centre) > 0.75 * size[1]:
            _leader(axes, centre, foot)
        x, y = _to_data(axes, centre)[0]
        axes.text(x, y, text, fontsize=size_pt, color="#111111", ha="center", va="center", zorder=7, bbox=_PILL)
    return np.concatenate([centres - sizes / 2, centres + sizes / 2], axis=1)


def _nearest(point: FloatArray, start: FloatArray, end: FloatArray) -> FloatArray:
    """Return the point of a segment nearest to another, kept off the segment's very ends."""
    way = end - start
    share = float((point - start) @ way / max(float(way @ way), 1e-9))
    return start + min(max(share, 0.15), 0.85) * way


def _leader(axes: Axes, start: FloatArray, end: FloatArray) -> None:
    line = _to_data(axes, np.stack([start, end]))
    dark = [Stroke(linewidth=1.9, foreground="#000000", alpha=0.6), withStroke(linewidth=0)]
    axes.plot(*line.T, color="#FFFFFF", linewidth=0.8, linestyle=(0, (2, 1.2)), path_effects=dark, zorder=5)


@functools.cache
def _extent_pt(text: str, size_pt: float) -> tuple[float, float]:
    """Return a text's width and height in points; the height is the font's, the same for every text."""
    width = TextPath((0, 0), text, size=size_pt, usetex=False).get_extents().width if text.strip() else 0.0
    return float(width), 1.05 * size_pt
