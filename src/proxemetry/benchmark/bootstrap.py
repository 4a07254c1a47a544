"""95 % intervals from photos drawn again with replacement: photos, not pairs, for a photo's pairs share its errors."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping

import numpy as np
from numpy.typing import NDArray

from ..arrays import FloatArray

Interval = tuple[float, float]

_RESAMPLES, _SEED = 1000, 20210306
_CELLS_AT_ONCE = 4_000_000  # keeps the memory of a hundred thousand pairs at some tens of megabytes


def ratio_intervals(ratios: Mapping[str, tuple[FloatArray, FloatArray]], count: int) -> dict[str, Interval]:
    """Return the interval of each ratio of sums over `count` photos, from what each adds above and below, shape (n,).

    NaN where nothing was ever added below.
    """
    sums: dict[str, list[tuple[FloatArray, FloatArray]]] = {name: [] for name in ratios}
    for weights in _resamples(count, count):
        for name, (above, below) in ratios.items():
            sums[name].append((weights @ above, weights @ below))
    return {
        name: _ratio_interval(*(np.concatenate(s) for s in zip(*parts, strict=True))) for name, parts in sums.items()
    }


def median_interval(values: FloatArray, photo: NDArray[np.intp], count: int) -> Interval:
    """Return the interval of the median of values, shape (n,), each from photo number `photo` of `count`."""
    order = np.argsort(values, kind="stable")
    ordered, photo = values[order], photo[order]
    medians: list[FloatArray] = []
    for weights in _resamples(count, len(values)):
        running = np.cumsum(weights[:, photo], axis=1)
        if running.shape[1]:
            running = running[running[:, -1] > 0]
            half = running[:, -1:] / 2  # where a value ends just there, the median is midway to the next
            middle = [ordered[below.sum(axis=1)] for below in (running < half, running <= half)]
            medians.append((middle[0] + middle[1]) / 2)
    return _quantiles(np.concatenate([np.zeros(0), *medians]))


def _resamples(count: int, width: int) -> Iterator[FloatArray]:
    """Yield how often each photo was drawn, shape (some resamples, count), the same draws whatever the width."""
    rng = np.random.default_rng(_SEED)
    left, at_once = _RESAMPLES, max(1, _CELLS_AT_ONCE // max(width, count, 1))
    while left:
        rows = min(at_once, left)
        draws = rng.integers(0, count, (rows, count)) + count * np.arange(rows)[:, None]
        yield np.bincount(draws.ravel(), minlength=rows * count).reshape(rows, count).astype(float)
        left -= rows


def _ratio_interval(above: FloatArray, below: FloatArray) -> Interval:
    return _quantiles(above[below > 0] / below[below > 0])


def _quantiles(values: FloatArray) -> Interval:
    if not len(values):
        return math.nan, math.nan
    low, high = np.quantile(values, (0.025, 0.975))
    return float(low), float(high)
