"""The view from above: where people stand on the ground, how surely, and where they face."""

from __future__ import annotations

import math

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.colors import to_rgba
from matplotlib.patches import Polygon

from ..arrays import FloatArray
from ..scene import Scene
from .cased_lines import Casing, draw_cased, pair_lines
from .geometry import camera_as_fitted, field_of_view, ground_positions, ground_regions
from .lettering import badge_radius_pt, draw_badges, draw_pair_labels, panel_box, to_points
from .pair_selection import colour_of, line_colours, number_text, short_pair_text
from .placement import Obstacles, around

_PAPER, _GRID, _INK = "#FBFBF9", "#DEDEDA", "#555555"
_STEPS_M = (1, 2, 5, 10, 20, 50, 100, 200, 500)
_MOST_LINES = 26
_ARROW_M = 0.55
#: Between a panel and its metres.
_GAP_PT = 2.0
#: Above the field of view and below its edges.
_GRID_ORDER = 0.55
#: Where people may stand reaches out of the picture beyond this share of how far apart they stand.
_REGION_SHARE = 0.3


def draw_plan(axes: Axes, scene: Scene, shown: list[tuple[int, int]]) -> None:
    """Draw the plan: metres to the right of the camera and forward from it."""
    axes.set_facecolor(_PAPER)
    for side in axes.spines.values():
        side.set(color=_GRID, linewidth=0.8)
    placed = [int(i) for i in np.flatnonzero(scene.bodies.placed)]
    if not placed:
        draw_nobody(axes, scene)
        return
    positions, regions = ground_positions(scene.bodies), ground_regions(scene.bodies)
    set_limits(axes, positions[placed], regions[placed])
    draw_grid(axes)
    draw_camera(axes, scene)
    draw_regions(axes, regions[placed], [colour_of(person) for person in placed])
    for person in placed:
        draw_heading(axes, positions[person], float(scene.bodies.heading_rad[person]))
    lines = pair_lines(scene.distances, positions, shown[::-1])
    draw_cased(axes, [lines], 1.8, [Casing(1.0, "#333333")], zorder=3)
    points = to_points(axes, positions)
    reach = 2 * badge_radius_pt(len(placed))
    spots = [np.concatenate([points[[i]], around(points[i], reach, 3.0)]) for i in placed]
    numbers, colours = [number_text(scene, i) for i in placed], [colour_of(i) for i in placed]
    taken = draw_badges(axes, spots, numbers, colours, with_dots=True)
    texts = [short_pair_text(scene.distances, a, b) for a, b in shown]
    ends = [(points[a], points[b]) for a, b in shown]
    draw_pair_labels(axes, ends, texts, line_colours(scene.distances, shown), taken, Obstacles.none())


def draw_nobody(axes: Axes, scene: Scene) -> None:
    """Draw a line of text where there is nobody to draw."""
    axes.set(xticks=[], yticks=[])
    text = "no people found" if not len(scene) else "no person could be placed"
    axes.text(0.5, 0.5, text, transform=axes.transAxes, ha="center", va="center", size=10, color=_INK)


def set_limits(axes: Axes, positions: FloatArray, regions: FloatArray) -> None:
    """Fit all people with the nearer part of where they may stand, and the camera unless people would be dots by it."""
    spread = max(float(np.ptp(positions, axis=0).max()), 2.0)
    reach = max(_REGION_SHARE * spread, 1.0)
    outlines = np.where(np.isfinite(regions), regions, positions[:, None])
    near = np.clip(outlines, positions[:, None] - reach, positions[:, None] + reach)
    low, high = near.min(axis=(0, 1)) - _ARROW_M, near.max(axis=(0, 1)) + _ARROW_M
    if low[1] < 1.5 * (high[1] - low[1]) + 2.0:
        low, high = np.minimum(low, (-0.6, -0.6)), np.maximum(high, (0.6, 0.6))
    x0, y0, x1, y1 = panel_box(axes)
    middle, size = (low + high) / 2, (high - low) * 1.06
    metre_per_point = max(size[0] / (x1 - x0), size[1] / (y1 - y0))
    half = np.array([x1 - x0, y1 - y0]) * metre_per_point / 2
    axes.set(xlim=(middle[0] - half[0], middle[0] + half[0]), ylim=(middle[1] - half[1], middle[1] + half[1]))


def draw_grid(axes: Axes, colour: str = _GRID, opacity: float = 1.0) -> None:
    """Draw a grid of whole metres, as fine as can be told apart, and say how fine it is.

    Lines and numbers as matplotlib's ticks would be, which make five artists of each.
    """
    x_limits, y_limits = axes.get_xlim(), axes.get_ylim()
    step = next((s for s in _STEPS_M if max(x_limits[1] - x_limits[0], y_limits[1] - y_limits[0]) / s <= _MOST_LINES),
                _STEPS_M[-1])  # fmt: skip
    axes.set(xticks=[], yticks=[])
    columns, rows = (np.arange(math.ceil(low / step) * step, high, step) for low, high in (x_limits, y_limits))
    upright = [[(x, y) for y in y_limits] for x in columns]
    level = [[(x, y) for x in x_limits] for y in rows]
    grid = LineCollection(
        [*upright, *level], colors=[to_rgba(colour, opacity)], linewidths=0.7, capstyle="projecting", zorder=_GRID_ORDER
    )
    axes.add_collection(grid, autolim=False)
    below, va, ha = axes.get_xaxis_text1_transform(_GAP_PT)
    for x in columns:
        axes.text(x, 0.0, _whole(x), transform=below, va=va, ha=ha, size=7, color=_INK)
    beside, va, ha = axes.get_yaxis_text1_transform(_GAP_PT)
    for y in rows:
        axes.text(0.0, y, _whole(y), transform=beside, va=va, ha=ha, size=7, color=_INK)
    axes.set_title(f"View from above, metres, grid {step} m", size=9, color=_INK, loc="left", pad=4)


def _whole(metres: float) -> str:
    return f"{metres:.0f}".replace("-", "\N{MINUS SIGN}")


def draw_camera(axes: Axes, scene: Scene) -> None:
    """Draw the field of view, and the camera itself where it is in the picture."""
    camera = scene.camera.camera
    if camera is None:
        return
    far = 3 * max(abs(v) for v in (*axes.get_xlim(), *axes.get_ylim()))
    edges = field_of_view(camera_as_fitted(camera, scene.bodies), scene.bodies.up) * far
    axes.add_patch(Polygon([(0, 0), *edges], closed=True, facecolor="#3B6EA8", alpha=0.06, linewidth=0, zorder=0.5))
    for edge in edges:
        axes.plot([0, edge[0]], [0, edge[1]], color="#3B6EA8", linewidth=0.9, linestyle=(0, (5, 3)), zorder=0.6)
    bottom = axes.get_ylim()[0]
    if bottom < 0:
        axes.scatter(0, 0, marker="^", s=70, color="#222222", zorder=4)
        axes.annotate("camera", (0, 0), (7, -3), textcoords="offset points", size=8, color="#222222", zorder=4)
    else:
        text = f"camera {bottom:.0f} m further down"
        paper = {"facecolor": _PAPER, "edgecolor": "none", "alpha": 0.8, "pad": 1.5}
        axes.text(
            0.5, 0.012, text, transform=axes.transAxes, ha="center", va="bottom", size=8, color="#222222", bbox=paper
        )


def draw_regions(axes: Axes, outlines: FloatArray, colours: list[str]) -> None:
    """Draw where people may stand, 90 %; outlines: shape (P, K, 2)."""
    known = [int(i) for i in np.flatnonzero(np.isfinite(outlines).all(axis=(1, 2)))]
    if not known:
        return
    faces = [to_rgba(colours[i], 0.22) for i in known]
    nothing, edge = to_rgba("none"), to_rgba("#333333", 0.7)
    drawn = PolyCollection(  # each person's area and then its edge, below those of the next
        list(np.repeat(outlines[known], 2, axis=0)), closed=True, linewidths=0.7, zorder=1.5,
        facecolors=[c for face in faces for c in (face, nothing)], edgecolors=[nothing, edge] * len(faces),
    )  # fmt: skip
    axes.add_collection(drawn, autolim=False)


def draw_heading(axes: Axes, position: FloatArray, heading_rad: float) -> None:
    """Draw an arrow to where a person faces."""
    if not math.isfinite(heading_rad):
        return
    tip = position + 1.6 * _ARROW_M * np.array([math.sin(heading_rad), -math.cos(heading_rad)])
    axes.annotate(
        "", tuple(tip), tuple(position), zorder=4,
        arrowprops={"arrowstyle": "-|>", "color": "#222222", "linewidth": 1.2, "mutation_scale": 9, "shrinkA": 6,
                    "shrinkB": 0},
    )  # fmt: skip
