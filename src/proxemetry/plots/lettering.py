"""Numbers and labels on a panel, none over another.

Laid out in typographic points from the figure's lower left corner, y up, and drawn in data coordinates: the same on a
600-pixel photo and on one of 24 megapixels, at any resolution that the figure is saved at.
"""

from __future__ import annotations

import functools
from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.path import Path
from matplotlib.textpath import TextPath

from ..arrays import FloatArray
from .cased_lines import Casing, Line, draw_cased
from .pair_selection import text_on
from .placement import Obstacles, along, place

_NOTHING = np.zeros((0, 4))
_BADGE_PT, _LABEL_PT = (8.0, 6.4), (8.5, 6.8)  # few people, many people
_MANY = 14
_PAD_PT = 2.6
#: How far from its line a label may be, in its own heights, and the share of a panel that labels cover at most.
_REACH, _MOST_COVERED = 12.0, 0.1
_INK = "#333333"
_PILL = {"boxstyle": "round,pad=0.26", "facecolor": "white", "linewidth": 1.2}


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
    axes: Axes, spots: list[FloatArray], numbers: Sequence[int | str], colours: list[str], *, with_dots: bool = False
) -> FloatArray:
    """Draw each person's number in a disc at its first free spot; return the discs' boxes in points, shape (n, 4).

    spots: per person candidates in points, shape (c, 2); a disc that had to leave the first gets a line to it, and
    with_dots a dot there: a number beside its place must not be taken for the place.
    """
    if not spots:
        return _NOTHING
    radius, size_pt = badge_radius_pt(len(spots)), _BADGE_PT[len(spots) > _MANY]
    sizes = np.full((len(spots), 2), 2 * radius + 1)
    centres = place(spots, sizes, _NOTHING, Obstacles.none(), panel_box(axes))
    placed = [int(i) for i in np.flatnonzero(np.isfinite(centres).all(axis=1))]
    if not placed:
        return _NOTHING
    firsts = np.stack([options[0] for options in spots])
    away = np.linalg.norm(firsts - centres, axis=1)
    _draw_leaders(axes, [(centres[i], firsts[i]) for i in placed if away[i] > 1.3 * radius])
    if with_dots:
        dotted = [i for i in placed if away[i] > 0.5]
        _discs(axes, firsts[dotted], 0.6 * radius, [colours[i] for i in dotted], 6.2)
    _discs(axes, centres[placed], 2 * radius, [colours[i] for i in placed], 6)
    for i, (x, y) in zip(placed, _to_data(axes, centres[placed]), strict=True):
        axes.text(
            x, y, str(numbers[i]), fontsize=size_pt, weight="bold", color=text_on(colours[i]), ha="center",
            va="center_baseline", zorder=6.1,
        )  # fmt: skip
    return np.concatenate([centres - sizes / 2, centres + sizes / 2], axis=1)[np.isfinite(centres).all(axis=1)]


def _discs(axes: Axes, centres: FloatArray, across_pt: float, colours: list[str], zorder: float) -> None:
    """Draw discs around centres in points, shape (n, 2)."""
    if colours:
        axes.scatter(
            *_to_data(axes, centres).T, s=across_pt**2, color=colours, edgecolors="#000000", linewidths=0.8,
            zorder=zorder,
        )  # fmt: skip


def draw_pair_labels(
    axes: Axes,
    ends: list[tuple[FloatArray, FloatArray]],
    texts: list[str],
    colours: list[str],
    taken: FloatArray,
    avoid: Obstacles,
) -> FloatArray:
    """Write each text beside its line, with a thin leader where it had to move; return the labels' boxes in points.

    ends: each line's two ends in points. colours: of the labels' frames. taken, avoid: in points, as in
    `placement.place`. Labels are written in the order given until they fill a share of the panel; one without a place
    near its line is left out, its row of the answer, shape (n, 4), is NaN, and a corner of the panel counts them.
    """
    if not texts:
        return _NOTHING
    size_pt = _LABEL_PT[len(texts) > _MANY]
    sizes = _sizes_pt(texts, size_pt)
    centres, corner = _laid_out(axes, ends, sizes, size_pt, taken, avoid)
    if len(corner):
        left_out = int(np.isnan(centres).all(axis=1).sum())
        _write(axes, (corner[0, :2] + corner[0, 2:]) / 2, _left_out_text(left_out), size_pt, _INK)
    leaders: list[tuple[FloatArray, FloatArray]] = []
    for centre, text, colour, (start, end), size in zip(centres, texts, colours, ends, sizes, strict=True):
        if not np.isfinite(centre).all():
            continue
        foot = _nearest(centre, start, end)
        if np.linalg.norm(foot - centre) > 0.75 * size[1]:
            leaders.append((centre, foot))
        _write(axes, centre, text, size_pt, colour)
    _draw_leaders(axes, leaders)
    return np.concatenate([centres - sizes / 2, centres + sizes / 2], axis=1)


def _laid_out(
    axes: Axes,
    ends: list[tuple[FloatArray, FloatArray]],
    sizes: FloatArray,
    size_pt: float,
    taken: FloatArray,
    avoid: Obstacles,
) -> tuple[FloatArray, FloatArray]:
    """Return the labels' centres, shape (n, 2), and the box of the corner's text, shape (1, 4), (0, 4) without one."""
    candidates = [along(start, end, sizes[0, 1] * 0.62) for start, end in ends]
    bounds = panel_box(axes) + np.array([2.0, 2.0, -2.0, -2.0])
    fit = int((sizes.prod(axis=1).cumsum() < _MOST_COVERED * (bounds[2:] - bounds[:2]).prod()).sum())
    centres, corner = np.full((len(sizes), 2), np.nan), _NOTHING
    centres[:fit] = place(candidates[:fit], sizes[:fit], taken, avoid, bounds, _REACH)
    if not np.isfinite(centres).all():  # the corner's text needs room as well
        corner = _corner(_left_out_text(len(sizes)), size_pt, taken, avoid, bounds)
        taken = np.concatenate([taken, corner])
        centres[:fit] = place(candidates[:fit], sizes[:fit], taken, avoid, bounds, _REACH)
    return centres, corner


def _write(axes: Axes, centre: FloatArray, text: str, size_pt: float, colour: str) -> None:
    x, y = _to_data(axes, centre)[0]
    pill = {**_PILL, "edgecolor": colour}
    axes.text(x, y, text, fontsize=size_pt, color="#111111", ha="center", va="center", zorder=7, bbox=pill)


def _sizes_pt(texts: list[str], size_pt: float) -> FloatArray:
    """Return the labels' widths and heights in points, shape (n, 2)."""
    return np.array([_extent_pt(text, size_pt) for text in texts]) + 2 * _PAD_PT


def _left_out_text(count: int) -> str:
    return f"+ {count} more without room for a label"


def _corner(text: str, size_pt: float, taken: FloatArray, avoid: Obstacles, bounds: FloatArray) -> FloatArray:
    """Return the box, shape (1, 4), of a text in the corner where it covers least; (0, 4) where all are taken."""
    size = _sizes_pt([text], size_pt)[0]
    low, high = bounds[:2] + size / 2, bounds[2:] - size / 2
    if (low > high).any():
        return _NOTHING
    corners = np.array([(x, y) for y in (low[1], high[1]) for x in (low[0], high[0])])
    corners = corners[np.argsort(avoid.cost(np.concatenate([corners - size / 2, corners + size / 2], axis=1)))]
    for corner in corners:
        box = place([corner[None]], size[None], taken, Obstacles.none(), bounds, reach=0.0)
        if np.isfinite(box).all():
            return np.concatenate([box - size / 2, box + size / 2], axis=1)
    return _NOTHING


def _nearest(point: FloatArray, start: FloatArray, end: FloatArray) -> FloatArray:
    """Return the point of a segment nearest to another, kept off the segment's very ends."""
    way = end - start
    share = float((point - start) @ way / max(float(way @ way), 1e-9))
    return start + min(max(share, 0.15), 0.85) * way


def _draw_leaders(axes: Axes, leaders: list[tuple[FloatArray, FloatArray]]) -> None:
    """Draw thin lines between two points each, in points from the figure's lower left corner."""
    lines = [[Line(_to_data(axes, np.stack(ends)), "#FFFFFF")] for ends in leaders]
    draw_cased(axes, lines, 1.0, [Casing(1.2, "#000000", 0.75)], zorder=5, caps="projecting")


@functools.cache
def _extent_pt(text: str, size_pt: float) -> tuple[float, float]:
    """Return a text's width and height in points; the height is the font's, the same for every text."""
    if not text.strip():
        return 0.0, 1.05 * size_pt
    path = TextPath((0, 0), text, size=size_pt, usetex=False)
    # A font's curves have points wherever they are leftmost or rightmost, so no curve has to be followed.
    x = np.asarray(path.vertices)[np.asarray(path.codes) != Path.CLOSEPOLY, 0]
    return float(np.ptp(x)), 1.05 * size_pt
