"""Fixed draws of uncertain positions, which intervals and probabilities are taken from: the same on every run."""

from __future__ import annotations

import functools
import itertools
import math
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from .arrays import FloatArray
from .bodies import Bodies

_DRAWS = 512
#: So many draws are held at a time, 16 MB an array.
_MOST_DRAWS = 2_000_000
_GOLDEN, _SILVER = (math.sqrt(5) - 1) / 2, math.sqrt(2) - 1


@functools.cache
def standard_normal(dimension: int) -> FloatArray:
    """Return fixed standard normal points of shape (_DRAWS, dimension), spread evenly, with exactly unit covariance.

    They are symmetric in every axis, so that neither the order of two people nor a mirrored photo changes a quantile.
    """
    signs = np.array(list(itertools.product((1.0, -1.0), repeat=dimension)))
    count, pairs = _DRAWS // len(signs), (dimension + 1) // 2
    index = np.arange(count)
    # Radii are the quantiles of the Rayleigh distribution, every pair of axes in an order of its own; angles follow
    # the golden ratio within a quarter turn.
    columns: list[FloatArray] = []
    for k in range(pairs):
        order = np.argsort((index * _SILVER) % 1.0) if k else index
        radius = np.sqrt(-2 * np.log((order + 0.5) / count))
        angle = ((index * _GOLDEN * (k + 1)) % 1.0) * np.pi / 2
        columns += [radius * np.cos(angle), radius * np.sin(angle)]
    points = (np.abs(np.stack(columns[:dimension], axis=1))[:, None] * signs).reshape(-1, dimension)
    return points / np.sqrt((points**2).mean(axis=0))


def pair_covariance(covariance: FloatArray, a: NDArray[np.intp], b: NDArray[np.intp]) -> FloatArray:
    """Return the covariance of position a minus position b, shape (n, 3, 3), from the joint one."""
    blocks = covariance.reshape(len(covariance) // 3, 3, -1, 3).transpose(0, 2, 1, 3)
    return blocks[a, a] + blocks[b, b] - blocks[a, b] - blocks[b, a]


def blocks(count: int, draws: int) -> Iterator[slice]:
    """Yield slices of `count` rows of so many draws each: crowds have more pairs than fit into memory at once."""
    rows = max(1, _MOST_DRAWS // draws)
    yield from (slice(k, k + rows) for k in range(0, count, rows))


def spread_out(points: FloatArray, covariance: FloatArray) -> FloatArray:
    """Return standard normal points (draws, d) spread out by covariances (n, d, d): shape (n, draws, d)."""
    values, vectors = np.linalg.eigh(covariance)
    root = vectors * np.sqrt(np.maximum(values, 0.0))[:, None, :]
    return points @ root.transpose(0, 2, 1)


def pairs_within(
    reach_m: float, bodies: Bodies, plane: FloatArray, a: NDArray[np.intp], b: NDArray[np.intp]
) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Return which of the pairs (a, b) any explanation places within reach of each other."""
    nearest = np.full(len(a), np.inf)
    for positions in (bodies.positions_m, *(mode.positions_m for mode in bodies.modes)):
        flat = positions @ plane.T
        for some in blocks(len(a), 16):
            gap = np.linalg.norm(flat[a[some]] - flat[b[some]], axis=-1)
            nearest[some] = np.minimum(nearest[some], gap)
    close = nearest <= reach_m
    return a[close], b[close]


_STEPS = 40  # of Newton: with the most, at a deviation of a million, it has converged


def log_sd(relative_sd: FloatArray | float) -> FloatArray:
    """Return the logarithm's standard deviation of what lies about its median with this relative deviation.

    Of a log-normal distribution with median 1, E (x - 1)^2 = w^4 - 2 w + 1 with w = exp(sd^2 / 2).
    """
    squared = np.square(np.asarray(relative_sd, dtype=float))
    above = squared / 2  # w - 1, from above: the function is convex
    for _ in range(_STEPS):
        value = above * (2 + above * (6 + above * (4 + above))) - squared
        above = above - value / (2 + above * (12 + above * (12 + above * 4)))
    return np.sqrt(2 * np.log1p(np.maximum(above, 0.0)))
