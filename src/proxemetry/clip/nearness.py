"""How far two uncertain places are apart: distances, intervals and the probability of being within a limit.

For hours of clips: many pairs at many moments, in two dimensions. Far apart the distance is Gaussian; near by, and
wherever it is not, it is taken from the fixed points that photos' distances come from.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import erf

import numpy as np

from ..arrays import FloatArray
from ..distances import least_error_and_interval, planar_lengths
from ..intervals import HALF_WIDTH_SD

#: From so many standard deviations on a distance is as good as Gaussian (the skewness that is left is below 0.1).
_GAUSSIAN_FROM = 10.0
_BLOCK = 2000

_phi = np.vectorize(lambda z: 0.5 * (1 + erf(z / 2**0.5)), otypes=[float])


@dataclass(frozen=True, eq=False)
class Nearness:
    """Of n moments: the distance, its 90 % interval, shape (n,), and the probability of each limit, shape (n, L)."""

    distance_m: FloatArray
    low_m: FloatArray
    high_m: FloatArray
    p_within: FloatArray


def nearness(gap_m: FloatArray, covariance_m2: FloatArray, limits_m: Sequence[float]) -> Nearness:
    """Return what is known of the distances between pairs of places.

    gap_m: shape (n, 2), one place minus the other. covariance_m2: shape (n, 2, 2), of that gap. limits_m: metres.
    """
    gap, covariance = np.asarray(gap_m, dtype=float), np.asarray(covariance_m2, dtype=float)
    length = np.linalg.norm(gap, axis=1)
    variance = np.trace(covariance, axis1=1, axis2=2)
    far = length > _GAUSSIAN_FROM * np.sqrt(variance)
    result = _gaussian(gap, covariance, length, limits_m)
    near = np.flatnonzero(~far)
    for k in range(0, len(near), _BLOCK):
        some = near[k : k + _BLOCK]
        lengths, shares = planar_lengths(gap[some], covariance[some])
        answer, low, high = least_error_and_interval(lengths, shares)
        result.distance_m[some] = answer
        result.low_m[some], result.high_m[some] = np.minimum(low, answer), np.maximum(high, answer)
        for j, limit in enumerate(limits_m):
            result.p_within[some, j] = ((lengths < limit) * shares).sum(axis=1)
    return result


def _gaussian(gap: FloatArray, covariance: FloatArray, length: FloatArray, limits_m: Sequence[float]) -> Nearness:
    """Return the same to second order in the spread over the length."""
    along = gap / np.maximum(length, 1e-12)[:, None]
    ahead = np.einsum("ni,nij,nj->n", along, covariance, along)
    aside = np.maximum(np.trace(covariance, axis1=1, axis2=2) - ahead, 0.0)
    middle = length + aside / (2 * np.maximum(length, 1e-12))
    sd = np.sqrt(np.maximum(ahead, 1e-12))
    p_within = np.zeros((len(gap), len(limits_m)))
    for j, limit in enumerate(limits_m):
        p_within[:, j] = _phi((limit - middle) / sd)
    # the answer of least relative error lies below the middle by variance over length
    answer = middle - sd**2 / np.maximum(middle, 1e-12)
    return Nearness(answer, np.maximum(middle - HALF_WIDTH_SD * sd, 0.0), middle + HALF_WIDTH_SD * sd, p_within)
