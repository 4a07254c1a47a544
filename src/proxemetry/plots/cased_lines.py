"""Lines between darker and lighter edges that stand out from any photo, drawn by matplotlib as one collection.

Its path effects draw the same, but every line by itself: slow where there are hundreds.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.colors import to_rgba

from ..arrays import FloatArray
from ..distances import Distances
from .pair_selection import Dashes, line_colours, line_styles

#: Lengths of dashes and gaps in widths of the line, as matplotlib draws "dashed" and "dotted" by default.
DASHED, DOTTED = (3.7, 1.6), (1.0, 1.65)


@dataclass(frozen=True)
class Line:
    """A straight line between two points (2, 2) of a panel's data; dashes: in its widths, None for an unbroken one."""

    ends: FloatArray
    colour: str
    dashes: Dashes = None


@dataclass(frozen=True)
class Casing:
    """What is drawn below a line, `extra_pt` wider than it."""

    extra_pt: float
    colour: str
    opacity: float = 1.0


def pair_lines(distances: Distances, places: FloatArray, shown: list[tuple[int, int]]) -> list[Line]:
    """Return the pairs' lines between the people's places, shape (P, 2)."""
    styles = line_styles(distances, shown)
    return [
        Line(places[[a, b]], colour, dashes)
        for (a, b), colour, dashes in zip(shown, line_colours(distances, shown), styles, strict=True)
    ]


def draw_cased(
    axes: Axes,
    groups: Sequence[Sequence[Line]],
    width_pt: float,
    casings: Sequence[Casing],
    *,
    zorder: float,
    caps: Literal["butt", "projecting", "round"] | None = None,
) -> None:
    """Draw groups of lines, the later ones on top; within a group all casings lie below all lines.

    casings: the lowest first. They are broken where their line is.
    """
    layers = [*casings, Casing(0.0, "")]
    drawn = [(line, layer) for group in groups for layer in layers for line in group]
    if not drawn:
        return
    widths = [width_pt + layer.extra_pt for _, layer in drawn]
    lines = LineCollection(
        [line.ends for line, _ in drawn],
        colors=[to_rgba(layer.colour or line.colour, layer.opacity) for line, layer in drawn],
        linewidths=widths,
        linestyles=[_style(line, width_pt / width) for (line, _), width in zip(drawn, widths, strict=True)],
        capstyle=caps, zorder=zorder,
    )  # fmt: skip
    axes.add_collection(lines, autolim=False)


def _style(line: Line, share: float) -> tuple[float, tuple[float, ...] | None]:
    """Return matplotlib's pattern, which grows with what is drawn: of a casing it is to be that of its line."""
    return 0.0, None if line.dashes is None else tuple(length * share for length in line.dashes)
