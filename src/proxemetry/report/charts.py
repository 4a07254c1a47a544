"""Charts as SVG text, by hand: they print sharp and need nothing but the page they are in."""

from __future__ import annotations

import math
from collections.abc import Callable
from html import escape

from ..distances import ZONE_LIMITS_M, ZONES
from .numbers import BIN_M, BINS, Distances, Share

#: From near to far, light to dark enough for black and white prints; told apart with any colour vision.
ZONE_COLOURS = ("#0B3C5D", "#3274A1", "#7FB2D3", "#CFE1EE")
_INK_ON_ZONE = ("#FFFFFF", "#FFFFFF", "#1C2126", "#1C2126")


def histogram(distances: Distances, title: str) -> str:
    """Return the histogram of distances, bars of half a metre, with Hall's limits, the median and its interval."""
    width, height, left, bottom, top = 720, 230, 46, 34, 26
    wide, tall = (width - left - 10) / (BINS + 1), height - bottom - top
    most = max(max(distances.counts), 1)
    bars = [
        f'<rect x="{left + k * wide + 1:.1f}" y="{top + tall * (1 - n / most):.1f}" width="{wide - 2:.1f}" '
        f'height="{tall * n / most:.1f}" fill="{_bar_colour(k)}"><title>{_bar_name(k)}: {n}</title></rect>'
        for k, n in enumerate(distances.counts)
    ]

    def at(metres: float) -> float:
        return left + min(metres / BIN_M, BINS + 0.5) * wide

    ticks = [
        f'<text x="{at(m):.1f}" y="{height - 18}" class="tick">{m:g}</text>'
        for m in range(0, int(BINS * BIN_M))
    ]  # fmt: skip
    ticks.append(f'<text x="{at(99):.1f}" y="{height - 18}" class="tick">{BINS * BIN_M:g} +</text>')
    limits = [
        f'<line x1="{at(m):.1f}" x2="{at(m):.1f}" y1="{top - 6}" y2="{top + tall}" class="limit"/>'
        for m in ZONE_LIMITS_M
    ]
    edges = (0.0, *ZONE_LIMITS_M, BINS * BIN_M)
    names = [
        f'<text x="{(at(a) + at(b)) / 2:.1f}" y="{top - 9}" class="zone">{name}</text>'
        for name, a, b in zip(ZONES, edges, edges[1:], strict=False)
        if at(b) - at(a) > 40
    ]
    return (
        f'<svg class="chart" viewBox="0 0 {width} {height}" role="img" aria-label="{escape(title, quote=True)}">'
        f'<line x1="{left}" x2="{width - 10}" y1="{top + tall}" y2="{top + tall}" class="axis"/>'
        f'<text x="{left - 6}" y="{top + 5}" class="count">{most}</text>'
        f"{''.join(bars)}{''.join(limits)}{''.join(names)}{''.join(ticks)}{_median(distances, at, top, tall)}"
        f'<text x="{(left + width) / 2:.0f}" y="{height - 3}" class="tick">metres between body centres</text></svg>'
    )


def _median(distances: Distances, at: Callable[[float], float], top: float, tall: float) -> str:
    if not math.isfinite(distances.median_m):
        return ""
    x = at(distances.median_m)
    band = ""
    if math.isfinite(distances.low_m) and math.isfinite(distances.high_m):
        low, high = at(distances.low_m), at(distances.high_m)
        band = f'<rect x="{low:.1f}" y="{top}" width="{max(high - low, 1):.1f}" height="{tall}" class="band"/>'
    return f'{band}<line x1="{x:.1f}" x2="{x:.1f}" y1="{top}" y2="{top + tall}" class="median"/>'


def _bar_colour(bar: int) -> str:
    middle = (bar + 0.5) * BIN_M
    return ZONE_COLOURS[sum(middle >= limit for limit in ZONE_LIMITS_M)]


def _bar_name(bar: int) -> str:
    return f"{bar * BIN_M:g} m and more" if bar == BINS else f"{bar * BIN_M:g} to {(bar + 1) * BIN_M:g} m"


def zone_bar(zones: tuple[Share, ...], title: str) -> str:
    """Return one bar divided by the zones' shares."""
    if not all(math.isfinite(z.value) for z in zones):
        return ""
    x, parts = 0.0, list[str]()
    for name, share, colour, ink in zip(ZONES, zones, ZONE_COLOURS, _INK_ON_ZONE, strict=True):
        wide = 300 * share.value
        label = f"{100 * share.value:.0f}" if wide > 22 else ""
        parts.append(
            f'<rect x="{x:.1f}" y="0" width="{wide:.1f}" height="18" fill="{colour}"><title>{name} '
            f'{100 * share.value:.1f} %</title></rect>'
            f'<text x="{x + wide / 2:.1f}" y="13" fill="{ink}" class="part">{label}</text>'
        )  # fmt: skip
        x += wide
    label = escape(title, quote=True)
    return f'<svg class="zones" viewBox="0 0 300 18" role="img" aria-label="{label}">{"".join(parts)}</svg>'


def legend() -> str:
    """Return which colour is which zone."""
    limits = ("below 0.46 m", "0.46 to 1.22 m", "1.22 to 3.66 m", "beyond 3.66 m")
    items = "".join(
        f'<span><svg viewBox="0 0 12 12" aria-hidden="true"><rect width="12" height="12" fill="{colour}"/></svg> '
        f"{name} ({limit})</span>"
        for name, colour, limit in zip(ZONES, ZONE_COLOURS, limits, strict=True)
    )
    return f'<p class="legend">{items}</p>'
