"""The figures themselves: which panel goes where, and the words around them."""

from __future__ import annotations

import io
import math
import textwrap
from typing import Any

from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from ..distances import UNCERTAIN, ZONES
from ..photo import Photo
from ..scene import Scene
from .fonts import drawable, known_letters, without_formulas
from .geometry import known_horizon_px
from .pair_selection import footnote, headline, pairs_shown
from .photo_panel import draw_photo, horizon_style
from .plan_panel import draw_plan
from .zone_colours import ZONE_COLOURS

_INK, _FAINT = "#1A1A1A", "#555555"
_MARGIN_IN, _HEAD_IN, _FOOT_IN, _LINE_IN = 0.25, 0.62, 0.22, 0.17
_WIDE = 2.2
_TEXT_PT = 8.5
#: How wide an entry of the legend is.
_LEGEND_ENTRY_IN = 1.62
_KEY_ROW_IN = 0.21

#: What text in a photo is drawn at, at most: a decoder may then skip most of a 24-megapixel file.
_LONG_SIDE_PX = 1800
#: Of a figure in a notebook, whose page is about a thousand pixels wide.
_SHOWN_DPI = 72


class ShownFigure(Figure):
    """A figure that a notebook shows by itself: pyplot, which teaches notebooks to, is never loaded."""

    def _repr_png_(self) -> bytes:
        buffer = io.BytesIO()
        self.savefig(buffer, format="png", dpi=_SHOWN_DPI)
        return buffer.getvalue()

    def savefig(self, *arguments: Any, **options: Any) -> None:
        """Write the figure, as matplotlib has it; names may be in letters that its font lacks."""
        with known_letters(self):
            super().savefig(*arguments, **options)


def overlay_figure(scene: Scene, photo: Photo | None, faces: str, all_pairs: bool) -> Figure:
    """Return photo and plan side by side, or one above the other for a panorama."""
    shown = pairs_shown(scene.distances, all_pairs)
    aspect = aspect_of(scene)
    if aspect <= _WIDE:
        tall = min(6.6, 10.5 / aspect)
        sizes = [(tall * aspect, tall), (max(4.6, min(6.2, tall)), tall)]
        width, height = sizes[0][0] + sizes[1][0] + 0.75, tall
        spots = [(0.0, 0.0), (sizes[0][0] + 0.75, 0.0)]
    else:
        wide = 12.0
        deep = 4.2 if scene.bodies.placed.any() else 0.9
        sizes = [(wide, wide / aspect), (7.5, deep)]  # people stand in a strip as deep as it is wide
        width, height = wide, wide / aspect + 0.35 + deep
        spots = [(0.0, deep + 0.35), (0.45, 0.0)]
    handles = _legend_handles()
    if known_horizon_px(scene) is not None:
        handles.append(Line2D([], [], label="horizon", **horizon_style()))
    figure, panels = sheet(scene, footnote(scene, shown), width, height, spots, sizes, handles)
    pixels = None if photo is None else photo.pixels(_LONG_SIDE_PX)
    draw_photo(panels[0], scene, pixels, shown, faces == "blur")
    draw_plan(panels[1], scene, shown)
    return figure


def plan_figure(scene: Scene, all_pairs: bool) -> Figure:
    """Return the view from above alone."""
    shown = pairs_shown(scene.distances, all_pairs)
    figure, panels = sheet(scene, footnote(scene, shown), 7.0, 6.4, [(0.45, 0.0)], [(6.55, 6.4)])
    draw_plan(panels[0], scene, shown)
    return figure


def aspect_of(scene: Scene) -> float:
    """Return a photo's width over its height, 3:2 where its size is unknown."""
    return scene.width_px / scene.height_px if scene.width_px and scene.height_px else 1.5


def sheet(
    scene: Scene,
    foot: str,
    width: float,
    height: float,
    spots: list[tuple[float, float]],
    sizes: list[tuple[float, float]],
    handles: list[Artist] | None = None,
) -> tuple[Figure, list[Axes]]:
    """Return a white figure with heading and footnote, and axes at `spots` (inches from the lower left of the body).

    handles: what the legend explains, the signs of overlays where None.
    """
    per_line = int(width / (_TEXT_PT * 0.0073))
    lines = textwrap.wrap(drawable(foot), per_line)[:6]
    handles = _legend_handles() if handles is None else handles
    handles = handles if scene.distances.below(math.inf) or scene.bodies.placed.any() else []
    key_rows = -(-len(handles) // max(1, int(width / _LEGEND_ENTRY_IN)))
    columns = -(-len(handles) // max(1, key_rows))
    below = _MARGIN_IN + _FOOT_IN + _LINE_IN * len(lines) + _KEY_ROW_IN * key_rows
    total_width, total_height = width + 2 * _MARGIN_IN, height + _HEAD_IN + below + _MARGIN_IN / 2
    figure = ShownFigure(figsize=(total_width, total_height), facecolor="white")
    FigureCanvasAgg(figure)
    left = _MARGIN_IN / total_width
    title = _ending(drawable(scene.photo), int(per_line * 0.6))
    figure.text(left, 1 - 0.14 / total_height, without_formulas(title), size=12, weight="bold", color=_INK, va="top")
    line = textwrap.shorten(drawable(headline(scene)), per_line, placeholder=" ...")
    figure.text(left, 1 - 0.37 / total_height, without_formulas(line), size=_TEXT_PT, color=_FAINT, va="top")
    start = (_MARGIN_IN * 0.8 + _LINE_IN * len(lines)) / total_height
    figure.text(left, start, without_formulas("\n".join(lines)), size=_TEXT_PT, color=_FAINT, va="top", linespacing=1.3)
    if handles:
        figure.legend(
            handles=handles, loc="lower left", ncols=columns, frameon=False, fontsize=_TEXT_PT - 0.5,
            bbox_to_anchor=(left * 0.6, start + 0.04 / total_height), labelcolor=_FAINT,
            borderpad=0, borderaxespad=0.2, labelspacing=0.25, handlelength=1.6, columnspacing=1.2,
        )  # fmt: skip
    panels = [
        figure.add_axes(
            (
                (_MARGIN_IN + x) / total_width,
                (below + y) / total_height,
                panel_width / total_width,
                panel_height / total_height,
            )
        )
        for (x, y), (panel_width, panel_height) in zip(spots, sizes, strict=True)
    ]
    return figure, panels


def _legend_handles() -> list[Artist]:
    """Return what explains the figure's signs: zones, facing, where a person may stand, field of view."""
    limits = ("to 0.46 m", "to 1.22 m", "to 3.66 m", "beyond")
    zones: list[Artist] = [
        Line2D([], [], color=ZONE_COLOURS[zone], linewidth=2.6, label=f"{zone} ({limit})")
        for zone, limit in zip(ZONES, limits, strict=True)
    ]
    return [
        *zones,
        Line2D([], [], color=ZONE_COLOURS[UNCERTAIN], linewidth=2.6, label="zone uncertain"),
        Line2D([], [], color="#222222", marker=">", markersize=5, linewidth=1.2, label="faces this way"),
        Patch(facecolor="#D9E2EA", edgecolor="#333333", linewidth=0.7, label="90 %: may stand here"),
        Line2D([], [], color="#3B6EA8", linewidth=0.9, linestyle=(0, (5, 3)), label="edge of the photo"),
    ]


def _ending(name: str, most: int) -> str:
    """Return the end of a photo's path, which distinguishes it from others, where the whole is too long."""
    return name if len(name) <= most else f"...{name[3 - most :]}"
