"""Distances of one kind in a report: median, quartiles, zones and histogram, with intervals over photos."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..archive.figures.sampling import median_levels, share_interval
from ..archive.figures.summary import Share
from ..arrays import FloatArray
from ..distances import ZONE_LIMITS_M, ZONES

#: Histogram: edges in metres, each about a quarter above the one before, so that Hall's limits are among them; what
#: lies before the first or beyond the last is a bar of its own.
EDGES_M = (
    *(round(ZONE_LIMITS_M[0] * 1.3**k, 3) for k in range(-5, 0)),
    *(round(low * (high / low) ** (k / 4), 3) for low, high in itertools.pairwise(ZONE_LIMITS_M) for k in range(4)),
    *(round(ZONE_LIMITS_M[-1] * 1.3**k, 3) for k in range(10)),
)


@dataclass(frozen=True)
class Distances:
    """Distances of one kind in some photos.

    n: how many. median_m with low_m, high_m: its central 90 % interval over photos. quartiles_m: lower and upper.
    zones: for each of Hall's zones the share of the distances, each counted by its probability of lying there.
    counts: the histogram, one more than `EDGES_M`.
    """

    n: int
    n_photos: int
    median_m: float
    low_m: float
    high_m: float
    quartiles_m: tuple[float, float]
    zones: tuple[Share, ...]
    counts: tuple[int, ...]


def distances_in(duck: Any, source: str) -> Distances:
    """Return what is known of the distances of a query: its rows have `photo`, `distance_m` and the zones' `p_`."""
    n, median, lower, upper = duck.execute(
        f"SELECT count(*), quantile_cont(distance_m, 0.5), quantile_cont(distance_m, 0.25), "
        f"quantile_cont(distance_m, 0.75) FROM {source}"
    ).fetchone()
    if not n:
        nothing = Share(math.nan, math.nan, math.nan)
        return Distances(
            0, 0, math.nan, math.nan, math.nan, (math.nan, math.nan), (nothing,) * len(ZONES), (0,) * (len(EDGES_M) + 1)
        )
    sums = ", ".join(f"sum(p_{zone})" for zone in ZONES)
    table = np.array(
        duck.execute(
            f"SELECT count(*), sum(CAST(distance_m <= {median!r} AS INTEGER)), {sums} FROM {source} GROUP BY photo"
        ).fetchall(),
        dtype=float,
    )
    zones = [ratio_over_photos(table[:, k], table[:, 0]) for k in range(2, table.shape[1])]
    low, high = _median_interval(duck, source, _ratio(table[:, 1], table[:, 0])[1], len(table))
    bars = dict(
        duck.execute(
            f"SELECT {' + '.join(f'CAST(distance_m >= {edge} AS INTEGER)' for edge in EDGES_M)} AS bar, count(*) "
            f"FROM {source} GROUP BY bar"
        ).fetchall()
    )
    return Distances(
        int(n), len(table), float(median), low, high, (float(lower), float(upper)), tuple(zones),
        tuple(int(bars.get(k, 0)) for k in range(len(EDGES_M) + 1)),
    )  # fmt: skip


def _median_interval(duck: Any, source: str, below_sd: float, n_photos: int) -> tuple[float, float]:
    """Return the median's interval (Woodruff 1952); below_sd: of the share of distances up to the median."""
    levels = [float(level[0]) for level in median_levels(np.array([below_sd]), np.array([n_photos]))]
    if not all(map(math.isfinite, levels)):
        return math.nan, math.nan
    low, high = duck.execute(
        f"SELECT quantile_cont(distance_m, {levels[0]!r}), quantile_cont(distance_m, {levels[1]!r}) FROM {source}"
    ).fetchone()
    return float(low), float(high)


def ratio_over_photos(parts: FloatArray, totals: FloatArray) -> Share:
    """Return the sum of `parts` over that of `totals`, one of each a photo, with its central 90 % interval.

    The interval is that of `sampling.share_interval`, as in a summary; NaN with a single photo.
    """
    value, sd = _ratio(parts, totals)
    low, high = share_interval(np.array([value]), np.array([sd]), np.array([len(parts)]))
    return Share(value, float(low[0]), float(high[0]))


def _ratio(parts: FloatArray, totals: FloatArray) -> tuple[float, float]:
    """Return a ratio over photos and its standard deviation, a ratio estimator's (Cochran 1977, section 6.4).

    NaN for that of a single photo.
    """
    parts, totals, n = np.asarray(parts, dtype=float), np.asarray(totals, dtype=float), len(parts)
    value = float(parts.sum() / totals.sum())
    if n < 2:
        return value, math.nan
    return value, math.sqrt(float(((parts - value * totals) ** 2).sum()) * n / (n - 1)) / float(totals.sum())


def names_of(shares: Sequence[Share]) -> list[tuple[str, Share]]:
    """Return Hall's zones with their shares."""
    return list(zip(ZONES, shares, strict=True))
