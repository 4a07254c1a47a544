"""From how many people per square metre on others come too near: the critical density, and rates over time.

Yang et al. 2020 (arXiv 2007.03578) regress density on the number of pairs that are too near and call the density at
which that number reaches zero critical; they publish the lower end of the regression's 95 % prediction interval
there. Frames of a clip are not independent, so the intercept gets an interval from a bootstrap over blocks of time;
and where the published number is negative, or there is too little to regress, the answer is refused with the reason.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..arrays import FloatArray
from ..intervals import HIGH, LOW

#: A block must be longer than people stay: how many belong to one frame's accident.
BLOCK_S = 10.0
#: Fewer blocks do not show how a rate varies.
FEWEST_BLOCKS = 6
_DRAWS = 1000
#: The normal quantile of a two-sided 95 % interval, with which Yang et al. publish their bound.
_Z_95 = 1.959963984540054


@dataclass(frozen=True)
class CriticalDensity:
    """The intercept in persons per square metre with its 90 % interval, and Yang's published bound; or a reason.

    reason: why the numbers mean nothing, None where they do. The numbers are given either way where they exist.
    """

    intercept: float = math.nan
    low: float = math.nan
    high: float = math.nan
    prediction_low: float = math.nan
    n_blocks: int = 0
    reason: str | None = None


def blocks(t_s: FloatArray, block_s: float = BLOCK_S) -> NDArray[np.intp]:
    """Return the block of time of each moment, numbered from 0 without gaps, shape (n,)."""
    _, number = np.unique(np.floor(np.asarray(t_s) / block_s).astype(np.intp), return_inverse=True)
    return number.astype(np.intp)


def critical_density(density: FloatArray, too_near: FloatArray, t_s: FloatArray, seed: int = 0) -> CriticalDensity:
    """Return the density at which the number of pairs that are too near reaches zero.

    density, too_near, t_s: shape (n,), one a frame: persons per square metre, pairs within the limit, seconds.
    """
    density, too_near = np.asarray(density, dtype=float), np.asarray(too_near, dtype=float)
    number = blocks(t_s)
    count = int(number.max(initial=-1)) + 1
    if count < FEWEST_BLOCKS:
        return CriticalDensity(
            n_blocks=count, reason=f"the clip has {count} stretches of {BLOCK_S:.0f} s; {FEWEST_BLOCKS} are needed"
        )
    if too_near.std() < 1e-9:
        why = "no two people came within the limit" if too_near.max() < 0.5 else "as many were too near at every moment"
        return CriticalDensity(n_blocks=count, reason=f"{why}: there is nothing to regress on")
    intercept, slope = _line(too_near, density)
    bound = _prediction_low(density, too_near, intercept, slope)
    low, high = _block_interval(density, too_near, number, count, seed)
    reason = None
    if slope <= 0:
        reason = "density does not grow with the number of pairs too near: the floor was not crowded enough"
    elif low <= 0:
        reason = "the interval of the intercept reaches below zero"
    elif bound <= 0:
        reason = "the lower end of the 95 % prediction interval, which is the number published, is below zero"
    return CriticalDensity(intercept, low, high, bound, count, reason)


def _line(x: FloatArray, y: FloatArray) -> tuple[float, float]:
    slope = float(np.mean((x - x.mean()) * (y - y.mean())) / max(float(x.var()), 1e-12))
    return float(y.mean() - slope * x.mean()), slope


def _prediction_low(density: FloatArray, too_near: FloatArray, intercept: float, slope: float) -> float:
    """Return the lower end of the 95 % prediction interval at no pair too near (Yang et al. 2020, section 4.3)."""
    count = len(density)
    left = density - intercept - slope * too_near
    variance = float(left @ left) / max(count - 2, 1)
    leverage = 1 + 1 / count + too_near.mean() ** 2 / max(count * too_near.var(), 1e-12)
    return intercept - _Z_95 * math.sqrt(variance * leverage)


def _block_interval(
    density: FloatArray, too_near: FloatArray, number: NDArray[np.intp], count: int, seed: int
) -> tuple[float, float]:
    """Return the central 90 % of the intercept over clips put together from resampled blocks of this one."""
    sums = np.stack([
        np.bincount(number, weights=v, minlength=count)
        for v in (np.ones(len(density)), too_near, density, too_near**2, too_near * density)
    ])  # fmt: skip
    drawn = np.random.default_rng(seed).multinomial(count, np.full(count, 1 / count), size=_DRAWS)
    n, x, y, xx, xy = sums @ drawn.T.astype(float)
    spread = xx - x * x / n
    known = spread > 1e-9
    slope = np.where(known, (xy - x * y / n) / np.where(known, spread, 1.0), 0.0)
    low, high = np.quantile(((y - slope * x) / n)[known], [LOW, HIGH])
    return float(low), float(high)


@dataclass(frozen=True)
class Rate:
    """A ratio of sums over time with its 90 % block bootstrap interval; NaN ends where blocks are too few."""

    value: float
    low: float
    high: float


def rate(amount: FloatArray, per: FloatArray, t_s: FloatArray, seed: int = 0) -> Rate:
    """Return sum(amount) / sum(per), of frames at t_s; all of shape (n,). Blocks of time are drawn, not frames."""
    amount, per = np.asarray(amount, dtype=float), np.asarray(per, dtype=float)
    total = float(per.sum())
    if total <= 0:
        return Rate(math.nan, math.nan, math.nan)
    value = float(amount.sum()) / total
    number = blocks(t_s)
    count = int(number.max(initial=-1)) + 1
    if count < FEWEST_BLOCKS:
        return Rate(value, math.nan, math.nan)
    above, below = (np.bincount(number, weights=v, minlength=count) for v in (amount, per))
    drawn = np.random.default_rng(seed).multinomial(count, np.full(count, 1 / count), size=_DRAWS).astype(float)
    ratios = (drawn @ above) / np.maximum(drawn @ below, 1e-12)
    low, high = np.quantile(ratios[drawn @ below > 0], [LOW, HIGH])
    return Rate(value, float(low), float(high))
