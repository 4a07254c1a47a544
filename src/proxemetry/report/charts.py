"""Charts as SVG text, by hand: they print sharp and need nothing but the page they are in."""

from __future__ import annotations

import math
from collections.abc import Callable
from html import escape

from ..distances import UNCERTAIN, ZONE_LIMITS_M, ZONES, zone_of
from ..plots.pair_selection import text_on
from ..plots.zone_colours import ZONE_COLOURS
from .distance_figures import EDGES_M, Distances, Share

#: The picture's size and its margins, and the tick marks of the logarithmic axis, metres.
_WIDTH, _HEIGHT, _LEFT, _RIGHT, _TOP, _BOTTOM = 720, 250, 58, 14, 30, 40
_TICKS_M = (0.2, 0.3, 0.5, 0.7, 1, 1.5, 2, 3, 5, 7, 10, 15, 20, 30)


def histogram(distances: Distances, title: str, of: str) -> str:
    """Return the histogram of distances on a logarithmic axis, its bars ending at Hall's limits, with the median.

    of: what is counted ("people", "pairs"), for the axis.
    """
    edges = (EDGES_M[0] / 1.3, *EDGES_M, EDGES_M[-1] * 1.3)
    tall, most = _HEIGHT - _TOP - _BOTTOM, _round_up(max(*distances.counts, 1))
    floor = _TOP + tall

    def at(metres: float) -> float:
        share = math.log(min(max(metres, edges[0]), edges[-1]) / edges[0]) / math.log(edges[-1] / edges[0])
        return _LEFT + share * (_WIDTH - _LEFT - _RIGHT)

    bars = [
        f'<rect x="{at(low) + 0.5:.1f}" y="{floor - tall * n / most:.1f}" width="{at(high) - at(low) - 1:.1f}" '
        f'height="{tall * n / most:.1f}" fill="{ZONE_COLOURS[zone_of(low * 1.001) or UNCERTAIN]}">'
        f"<title>{_bar_name(k)}: {n:,} {of}</title></rect>"
        for k, (low, high, n) in enumerate(zip(edges, edges[1:], distances.counts, strict=False))
    ]
    ticks = [f'<text x="{at(m):.1f}" y="{floor + 14}" class="tick">{m:g}</text>' for m in _TICKS_M]
    limits = [
        f'<line x1="{at(m):.1f}" x2="{at(m):.1f}" y1="{_TOP - 6}" y2="{floor}" class="limit"/>' for m in ZONE_LIMITS_M
    ]
    ends = (edges[0], *ZONE_LIMITS_M, edges[-1])
    names = [
        f'<text x="{(at(a) + at(b)) / 2:.1f}" y="{_TOP - 12}" class="zone">{name}</text>'
        for name, a, b in zip(ZONES, ends, ends[1:], strict=False)
    ]
    counts = [
        f'<line x1="{_LEFT}" x2="{_WIDTH - _RIGHT}" y1="{floor - tall * share:.1f}" y2="{floor - tall * share:.1f}" '
        'class="rule"/>'
        f'<text x="{_LEFT - 6}" y="{floor - tall * share + 4:.1f}" class="count">{most * share:,.0f}</text>'
        for share in ((0.0, 0.5, 1.0) if most > 1 else (0.0, 1.0))
    ]
    middle = _TOP + tall / 2
    return (
        f'<svg class="chart" viewBox="0 0 {_WIDTH} {_HEIGHT}" role="img" aria-label="{escape(title, quote=True)}">'
        f"{''.join([*counts, *bars, *limits, *names, *ticks])}{_median(distances, at, floor)}"
        f'<text x="14" y="{middle:.0f}" transform="rotate(-90 14 {middle:.0f})" class="tick">{of}</text>'
        f'<text x="{(_LEFT + _WIDTH) / 2:.0f}" y="{_HEIGHT - 6}" class="tick">metres between body centres '
        "(logarithmic); line and band: median with its 90 % interval</text></svg>"
    )


def _round_up(most: int) -> int:
    """Return a count that an axis ends at: 1, 2, 4, 6, 8 or 10 times a power of ten."""
    if most <= 1:
        return 1
    power = 10 ** (len(str(most)) - 1)
    return next(step * power for step in (1, 2, 4, 6, 8, 10) if step * power >= most)


def _median(distances: Distances, at: Callable[[float], float], floor: float) -> str:
    if not math.isfinite(distances.median_m):
        return ""
    x = at(distances.median_m)
    band = ""
    if math.isfinite(distances.low_m) and math.isfinite(distances.high_m):
        low, high = at(distances.low_m), at(distances.high_m)
        band = f'<rect x="{low:.1f}" y="{_TOP}" width="{max(high - low, 1):.1f}" height="{floor - _TOP}" class="band"/>'
    return f'{band}<line x1="{x:.1f}" x2="{x:.1f}" y1="{_TOP}" y2="{floor}" class="median"/>'


def _bar_name(bar: int) -> str:
    if bar == 0:
        return f"below {EDGES_M[0]:g} m"
    return f"{EDGES_M[-1]:g} m and more" if bar == len(EDGES_M) else f"{EDGES_M[bar - 1]:g} to {EDGES_M[bar]:g} m"


def zone_bar(zones: tuple[Share, ...], title: str) -> str:
    """Return one bar divided by the zones' shares."""
    if not all(math.isfinite(z.value) for z in zones):
        return ""
    x, parts = 0.0, list[str]()
    for name, share in zip(ZONES, zones, strict=True):
        colour = ZONE_COLOURS[name]
        ink = text_on(colour)
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
        '<span><svg viewBox="0 0 12 12" aria-hidden="true">'
        f'<rect width="12" height="12" fill="{ZONE_COLOURS[name]}"/></svg> '
        f"{name} ({limit})</span>"
        for name, limit in zip(ZONES, limits, strict=True)
    )
    return f'<p class="legend">{items}</p>'
