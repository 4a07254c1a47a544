"""The figures themselves: which panel goes where, and the words around them."""

from __future__ import annotations

import textwrap

from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from ..photo import Photo
from ..scene import Scene
from .choice import footnote, headline, pairs_shown
from .photo_panel import draw_photo
from .plan_panel import draw_plan

_INK, _FAINT = "#1A1A1A", "#555555"
_MARGIN_IN, _HEAD_IN, _FOOT_IN, _LINE_IN = 0.25, 0.62, 0.22, 0.17
_WIDE = 2.2
_TEXT_PT = 8.5

#: What text in a photo is drawn at, at most: a decoder may then skip most of a 24-megapixel file.
_LONG_SIDE_PX = 1800


def overlay_figure(scene: Scene, photo: Photo | None, faces: str, all_pairs: bool) -> Figure:
    """Return photo and plan side by side, or one above the other for a panorama."""
    shown = pairs_shown(scene.distances, all_pairs)
    aspect = _aspect(scene)
    if aspect <= _WIDE:
        tall = min(6.6, 10.5 / aspect)
        sizes = [(tall * aspect, tall), (max(4.6, min(6.2, tall)), tall)]
        width, height = sizes[0][0] + sizes[1][0] + 0.75, tall
        spots = [(0.0, 0.0), (sizes[0][0] + 0.75, 0.0)]
    else:
        wide = 12.0
        sizes = [(wide, wide / aspect), (wide - 0.45, 4.2)]
        width, height = wide, wide / aspect + 0.35 + 4.2
        spots = [(0.0, 4.2 + 0.35), (0.45, 0.0)]
    figure, panels = _sheet(scene, footnote(scene, shown), width, height, spots, sizes)
    pixels = None if photo is None else photo.pixels(_LONG_SIDE_PX)
    draw_photo(panels[0], scene, pixels, shown, faces == "blur")
    draw_plan(panels[1], scene, shown)
    return figure


def plan_figure(scene: Scene, all_pairs: bool) -> Figure:
    """Return the view from above alone."""
    shown = pairs_shown(scene.distances, all_pairs)
    figure, panels = _sheet(scene, footnote(scene, shown), 7.0, 6.4, [(0.45, 0.0)], [(6.55, 6.4)])
    draw_plan(panels[0], scene, shown)
    return figure


def _aspect(scene: Scene) -> float:
    return scene.width_px / scene.height_px if scene.width_px and scene.height_px else 1.5


def _sheet(
    scene: Scene,
    foot: str,
    width: float,
    height: float,
    spots: list[tuple[float, float]],
    sizes: list[tuple[float, float]],
) -> tuple[Figure, list[Axes]]:
    """Return a white figure with heading and footnote, and axes at `spots` (inches from the lower left of the body)."""
    per_line = int(width / (_TEXT_PT * 0.0073))
    lines = textwrap.wrap(foot, per_line)[:6]
    below = _MARGIN_IN + _FOOT_IN + _LINE_IN * len(lines)
    total_width, total_height = width + 2 * _MARGIN_IN, height + _HEAD_IN + below + _MARGIN_IN / 2
    figure = Figure(figsize=(total_width, total_height), facecolor="white")
    FigureCanvasAgg(figure)
    left = _MARGIN_IN / total_width
    title = _ending(scene.photo, int(per_line * 0.6))
    figure.text(left, 1 - 0.14 / total_height, _plain(title), size=12, weight="bold", color=_INK, va="top")
    line = textwrap.shorten(headline(scene), per_line, placeholder=" ...")
    figure.text(left, 1 - 0.37 / total_height, _plain(line), size=_TEXT_PT, color=_FAINT, va="top")
    start = (_MARGIN_IN * 0.8 + _LINE_IN * len(lines)) / total_height
    figure.text(left, start, _plain("\n".join(lines)), size=_TEXT_PT, color=_FAINT, va="top", linespacing=1.3)
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


def _ending(name: str, most: int) -> str:
    """Return the end of a photo's path, which is what tells it from others, where the whole is too long."""
    return name if len(name) <= most else f"...{name[3 - most :]}"


def _plain(text: str) -> str:
    """Return text in which matplotlib sees no formulas: a file name may hold dollar signs."""
    return text.replace("$", r"\$")
