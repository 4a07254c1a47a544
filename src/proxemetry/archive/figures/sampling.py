"""From a sample of photos to all of them: shares and medians of their pairs or people, for many groups at once.

Pairs of one photo are not independent, so photos are what is sampled: intervals are those of a ratio over clusters
(linearised variance, Cochran 1977, section 6.4), Wilson's for shares with the sample size that has this variance,
Woodruff's for medians (Woodruff 1952), all as wide as Student's distribution asks for where photos are few. Without
loops: an archive may have a group a folder.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...arrays import FloatArray, IntArray
from ...intervals import HALF_WIDTH_SD

#: A standard deviation of shares that rounding alone can make.
_NOTHING = 1e-9
#: Student's 95 % point with 1 to 5 degrees of freedom; beyond, its expansion is right to three digits.
_FEW = np.array([6.3138, 2.9200, 2.3534, 2.1318, 2.0150])


def _student(freedom: IntArray) -> FloatArray:
    """Return Student's 95 % point (Fisher's expansion, Abramowitz and Stegun 26.7.5).

    As `scipy.special.stdtrit`, whose import alone would take about as long as a whole summary may.
    """
    z, v = HALF_WIDTH_SD, freedom.astype(float)
    many = (
        z
        + (z**3 + z) / (4 * v)
        + (5 * z**5 + 16 * z**3 + 3 * z) / (96 * v**2)
        + (3 * z**7 + 19 * z**5 + 17 * z**3 - 15 * z) / (384 * v**3)
    )
    return np.where(freedom <= len(_FEW), _FEW[np.minimum(freedom, len(_FEW)) - 1], many)


def share_interval(share: FloatArray, sd: FloatArray, n_photos: IntArray) -> tuple[FloatArray, FloatArray]:
    """Return Wilson's interval of shares of these standard deviations over so many photos; NaN where sd is."""
    z = _width(n_photos)
    with np.errstate(divide="ignore", invalid="ignore"):
        # None or all: there is no variance to see, so no more is claimed than that many photos can show.
        size: Any = np.where(sd > _NOTHING, share * (1 - share) / sd**2, n_photos)
        middle = (share + z**2 / (2 * size)) / (1 + z**2 / size)
        half = z / (1 + z**2 / size) * np.sqrt(share * (1 - share) / size + z**2 / (4 * size**2))
    known = np.isfinite(sd)
    low, high = np.maximum(0.0, middle - half), np.minimum(1.0, middle + half)
    return np.where(known, low, np.nan), np.where(known, high, np.nan)


def median_levels(sd: FloatArray, n_photos: IntArray) -> tuple[FloatArray, FloatArray]:
    """Return the quantiles at which the interval of a median ends; sd: of the share of values up to the median."""
    with np.errstate(divide="ignore"):
        # Photos with half of their pairs on either side are worth no more than that many single pairs.
        sd = np.where(sd <= _NOTHING, 0.5 / np.sqrt(n_photos), sd)
    half = _width(n_photos) * sd
    return np.clip(0.5 - half, 0, 1), np.clip(0.5 + half, 0, 1)


def _width(n_photos: IntArray) -> FloatArray:
    """Return half the width of an interval in standard deviations: Student's with one photo less than there are."""
    return _student(np.maximum(n_photos - 1, 1))


@dataclass(frozen=True, eq=False)
class Estimates:
    """A figure of each group and the central 90 % of where it may lie, shape (G,) each; NaN where unknown."""

    value: FloatArray
    low: FloatArray
    high: FloatArray


@dataclass(frozen=True, eq=False)
class Sample:
    """Pairs by group and photo. group: shape (n,), numbers from 0 that never fall. photo: shape (n,), any numbers.

    A photo's pairs stand together in each group.
    """

    group: IntArray
    photo: IntArray
    n_groups: int

    @cached_property
    def size(self) -> IntArray:
        """How many pairs each group has."""
        return np.bincount(self.group, minlength=self.n_groups)

    @cached_property
    def start(self) -> IntArray:
        """Where each group begins."""
        return np.cumsum(self.size) - self.size

    @cached_property
    def _cluster(self) -> IntArray:
        """The pairs' photos, numbered from 0 and anew in each group."""
        if not len(self.group):
            return self.group
        begins = (np.diff(self.photo) != 0) | (np.diff(self.group) != 0)
        return np.concatenate([[0], np.cumsum(begins)])

    @cached_property
    def _group_of_cluster(self) -> IntArray:
        group = np.zeros(self._cluster[-1] + 1 if len(self._cluster) else 0, dtype=np.int64)
        group[self._cluster] = self.group
        return group

    @cached_property
    def n_photos(self) -> IntArray:
        """How many photos each group has."""
        return np.bincount(self._group_of_cluster, minlength=self.n_groups)

    def means(self, values: FloatArray) -> FloatArray:
        """Return the mean of values, shape (n,), in each group; NaN in an empty one."""
        with np.errstate(invalid="ignore"):
            return np.bincount(self.group, weights=values, minlength=self.n_groups) / self.size

    def _ratios(self, hits: FloatArray | NDArray[np.bool_]) -> tuple[FloatArray, FloatArray]:
        """Return the share of hits and its standard deviation, NaN for that with fewer than two photos."""
        share = self.means(np.asarray(hits, dtype=float))
        residual = np.bincount(self._cluster, weights=hits - share[self.group])
        squares = np.bincount(self._group_of_cluster, weights=residual**2, minlength=self.n_groups)
        with np.errstate(divide="ignore", invalid="ignore"):
            sd = np.sqrt(self.n_photos / (self.n_photos - 1) * squares) / self.size
        return share, np.where(self.n_photos < 2, np.nan, sd)

    def shares(self, hits: FloatArray | NDArray[np.bool_]) -> Estimates:
        """Return the share of what `hits`, shape (n,), picks: yes or no each, or with a probability from 0 to 1."""
        share, sd = self._ratios(hits)
        return Estimates(share, *share_interval(share, sd, self.n_photos))

    def medians(self, values: FloatArray) -> Estimates:
        """Return the median of values, its interval read off where the distribution's own share is certain."""
        ordered = self._ordered(values)
        median = self._quantiles(ordered, np.full(self.n_groups, 0.5))
        _, sd = self._ratios(values <= median[self.group])
        return Estimates(median, *(self._quantiles(ordered, level) for level in median_levels(sd, self.n_photos)))

    def _ordered(self, values: FloatArray) -> FloatArray:
        ordered = values.copy()
        for start, size in zip(self.start, self.size, strict=True):
            ordered[start : start + size].sort()
        return ordered

    def _quantiles(self, ordered: FloatArray, level: FloatArray) -> FloatArray:
        """Return a quantile of each group, linear between its values; level: shape (G,), NaN where there is none."""
        known = np.isfinite(level) & (self.size > 0)
        place = np.where(known, level, 0.0) * np.maximum(self.size - 1, 0)
        below = np.floor(place).astype(np.int64)
        above = np.minimum(below + 1, np.maximum(self.size - 1, 0))
        found = np.full(self.n_groups, np.nan)
        at, part = self.start[known], (place - below)[known]
        low, high = ordered[at + below[known]], ordered[at + above[known]]
        found[known] = low + (high - low) * part
        return found
