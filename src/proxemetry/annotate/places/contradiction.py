"""Measurements that contradict each other, and which of them is wrong where that can be determined (Baarda 1968)."""

from __future__ import annotations

import math
from dataclasses import dataclass
from statistics import NormalDist

import numpy as np

from ...arrays import FloatArray
from .ambiguity import distance_sd
from .measurements import Measurement, Tape
from .network import Network

#: A normalised residual beyond this is a gross error: one in a thousand right measurements exceeds it (Baarda 1968).
GROSS_SD = 3.29
#: The chance of a sum of squares as large where all is right, below which measurements contradict each other.
_CHANCE = 0.001
#: Gross errors that are looked for one after the other.
_MOST = 3
#: Measurements left out in turn, the worst first: a gross error spreads, but is among the largest residuals.
_MOST_TRIED = 15
#: Residuals of less redundancy check nothing.
CHECKED = 1e-6


@dataclass(frozen=True)
class Suspect:
    """A measurement that contradicts the others, and what these say instead (NaN where they do not say)."""

    measurement: Measurement
    expected_m: float
    expected_sd_m: float


@dataclass(frozen=True)
class Contradiction:
    """Measurements that do not fit together. suspects: each, left out, makes the rest agree; one: it is the wrong one.

    settled: whether the rest agrees then; else more is wrong than can be identified.
    """

    suspects: tuple[Suspect, ...]
    settled: bool


def agrees(network: Network, positions_m: FloatArray, cost: float) -> bool:
    """Whether a network's measurements agree within their uncertainty."""
    freedom = network.free
    if freedom > 0 and cost > chi2_bound(freedom):
        return False
    return not bool((np.abs(normalised(network, positions_m)) > GROSS_SD).any())


def chi2_bound(freedom: int) -> float:
    """Return what a sum of squares exceeds by chance once in a thousand times (Wilson and Hilferty 1931)."""
    if freedom == 1:
        return NormalDist().inv_cdf(1 - _CHANCE / 2) ** 2
    if freedom == 2:
        return -2 * math.log(_CHANCE)
    z = NormalDist().inv_cdf(1 - _CHANCE)
    part = 2 / (9 * freedom)
    return freedom * (1 - part + z * math.sqrt(part)) ** 3


def normalised(network: Network, positions_m: FloatArray) -> FloatArray:
    """Return the residuals over their own standard deviations; 0 of those that nothing checks."""
    left, redundancy = network.residuals(positions_m.ravel()), network.redundancy(positions_m)
    return np.where(redundancy > CHECKED, left / np.sqrt(np.maximum(redundancy, CHECKED)), 0.0)


def contradiction(network: Network, positions_m: FloatArray, cost: float) -> Contradiction | None:
    """Return what contradicts what, None where all agrees."""
    if agrees(network, positions_m, cost):
        return None
    found: list[Suspect] = []
    rest, at = network, positions_m
    for _ in range(_MOST):
        tried = [(m, *_left_out(rest, m, at)) for m in _checked(rest, at)]
        if not tried:
            break
        settling = [(m, smaller, there) for m, smaller, there, cost in tried if agrees(smaller, there, cost)]
        if settling:
            last = tuple(_suspect(m, smaller, there) for m, smaller, there in settling)
            return Contradiction((*found, *last), len(last) == 1 or not found)
        measurement, rest, at, _ = min(tried, key=lambda t: t[3])
        found.append(_suspect(measurement, rest, at))
    return Contradiction(tuple(found), False)


def _checked(network: Network, positions_m: FloatArray) -> list[Measurement]:
    """Return the measurements that may be wrong: those that others check, the worst first."""
    redundancy, z = network.redundancy(positions_m), np.abs(normalised(network, positions_m))
    checked = [m for m in network.measurements if redundancy[network.rows(m)].max() > CHECKED]
    return sorted(checked, key=lambda m: -float(z[network.rows(m)].max()))[:_MOST_TRIED]


def _left_out(network: Network, measurement: Measurement, positions_m: FloatArray) -> tuple[Network, FloatArray, float]:
    """Return the network without a measurement, its layout and sum of squares.

    A gross error bends the layout with it: the search begins again, and also from where it is.
    """
    smaller = network.without(measurement)
    tried = [smaller.settled(at) for at in (positions_m, smaller.start())]
    # Of layouts as good as each other, the one that is nearest to what was measured.
    there, cost = min(tried, key=lambda f: (round(f[1], 3), float(np.square(network.residuals(f[0].ravel())).sum())))
    return smaller, there, cost


def _suspect(measurement: Measurement, rest: Network, positions_m: FloatArray) -> Suspect:
    if not isinstance(measurement, Tape):
        return Suspect(measurement, math.nan, math.nan)
    a, b = rest.tags.index(measurement.a), rest.tags.index(measurement.b)
    apart = float(np.linalg.norm(positions_m[a] - positions_m[b]))
    return Suspect(measurement, apart, float(distance_sd(rest, positions_m)[a, b]))
