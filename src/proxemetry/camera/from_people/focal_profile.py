"""Every focal length given upright people: the best camera at each, and the marginal posterior along them.

Cameras are fitted many at a time: rows of arrays differ in focal length, scatter and start.
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...arrays import FloatArray
from ...intervals import HIGH, LOW
from .verticals import F_RANGE, Segments, direct_solutions, distances_of, residuals_of

#: Photos differ in how still people stand and how well they are seen: factors on lean and keypoint noise, with the
#: prior probability of each. The people's own scatter about the fit decides between them: a crowd that walks leans by
#: three to five degrees, one that waits by one.
_SCATTER, _SCATTER_PRIOR = np.array([0.4, 0.8, 1.6, 3.2]), np.array([0.3, 0.35, 0.25, 0.1])
_ROLL_SD = 0.035  # two degrees
_TAIL = 5.0  # degrees of freedom of the residuals: one in a dozen people is not as modelled
#: Triples that are solved for a camera, and how many of these cameras, those that explain people best, are refined.
_MAX_TRIPLES, _MAX_REFINED = 120, 24
#: People whose triples are all listed before some are drawn: 20,000 triples.
_MOST_LISTED = 50
#: A person is part of the explanation where the squared Mahalanobis distance is below this (99 % of a chi-square, 2).
_INLIER = 9.2
#: The search ends when no cost moves by more than this. What lies higher up matters less (see `_refined`).
_IDLE = 1e-2
#: Focal lengths of the first profile, a step of 0.2 in log f; those of the second, and how far it reaches.
_COARSE, _FINE, _REACH = 20, 33, 0.4
_FAN = np.radians((-25, -10, -3, 3, 10, 25, 45))


@dataclass(frozen=True)
class Pose:
    """A camera: the logarithm of its focal length and the parameters of `verticals.tops_of`, shape (5,).

    scatter: the factor on people's lean and noise under which it was found.
    """

    log_f: float
    parameters: FloatArray
    scatter: float

    def with_focal(self, log_f: FloatArray) -> FloatArray:
        """Return parameters, shape (G, 5), for other focal lengths that keep the horizon where it is in the photo."""
        moved = np.tile(self.parameters, (len(log_f), 1))
        moved[:, 0] = np.arctan(math.exp(self.log_f) * math.tan(self.parameters[0]) / np.exp(log_f))
        return moved

    def explains(self, segments: Segments) -> NDArray[np.bool_]:
        """Return which people look as this camera would show an upright person, shape (N,)."""
        return distances_of(segments, self.log_f, self.parameters, self.scatter) < _INLIER


@dataclass(frozen=True)
class Profile:
    """The marginal posterior of log f, shape (G,), rising, by scatter: costs (negative log densities), shape (S, G).

    parameters: the likeliest of each, shape (S, G, 5).
    """

    log_f: FloatArray
    costs: FloatArray
    parameters: FloatArray

    @property
    def best(self) -> Pose:
        """The likeliest camera."""
        scatter, at = np.unravel_index(int(np.argmin(self.costs)), self.costs.shape)
        return Pose(float(self.log_f[at]), self.parameters[scatter, at], float(_SCATTER[scatter]))

    def with_finer(self, other: Profile) -> Profile:
        """Return the other where it reaches, and this one outside."""
        outside = (self.log_f < other.log_f[0]) | (self.log_f > other.log_f[-1])
        log_f = np.concatenate([self.log_f[outside], other.log_f])
        order = np.argsort(log_f)
        costs = np.concatenate([self.costs[:, outside], other.costs], axis=1)
        parameters = np.concatenate([self.parameters[:, outside], other.parameters], axis=1)
        return Profile(log_f[order], costs[:, order], parameters[:, order])

    @property
    def log_likelihood(self) -> FloatArray:
        """The log density of each focal length given the people, over all scatters, shape (G,), up to a constant."""
        least = self.costs.min()
        return np.log(np.exp(least - self.costs).sum(axis=0) + 1e-300) - least

    def quantiles(self) -> tuple[float, float, float]:
        """Return the 5th, 50th and 95th percentile of log f; between the steps the density runs exponentially."""
        dense = np.linspace(self.log_f[0], self.log_f[-1], 801)
        log = self.log_likelihood
        density = np.exp(np.interp(dense, self.log_f, log) - log.max())
        cumulative = np.append(0.0, np.cumsum((density[1:] + density[:-1]) / 2))
        low, middle, high = np.interp([LOW, 0.5, HIGH], cumulative / cumulative[-1], dense)
        return float(low), float(middle), float(high)


def consensus(segments: Segments) -> Pose:
    """Return the camera out of triples solved directly that explains people best."""
    triples = _triples(len(segments.rows))
    level = np.array([0.05, 0.0, -0.1, 0.0, 0.0])
    log_f, parameters = direct_solutions(segments, triples)
    log_f, parameters = np.append(0.0, log_f), np.vstack([level, parameters])
    scatter = np.full(len(log_f), _SCATTER[-1])
    promising = np.argsort(_fit(segments, log_f, parameters, scatter).cost)[:_MAX_REFINED]
    log_f, scatter = log_f[promising], scatter[promising]
    parameters, fit = _refined(segments, log_f, parameters[promising], scatter, iterations=4)
    best = int(np.argmin(fit.cost))
    return Pose(float(log_f[best]), parameters[best], float(scatter[best]))


def _triples(count: int) -> NDArray[np.intp]:
    """Return three people each, shape (T, 3): all of them, or so many drawn at random as are worth solving for."""
    generator = np.random.default_rng(0)
    if count > _MOST_LISTED:  # of a crowd's triples there are too many to list
        return np.array([generator.choice(count, 3, replace=False) for _ in range(_MAX_TRIPLES)])
    triples = np.array(list(itertools.combinations(range(count), 3)))
    if len(triples) > _MAX_TRIPLES:
        triples = triples[generator.permutation(len(triples))[:_MAX_TRIPLES]]
    return triples


def profile_everywhere(segments: Segments, start: Pose) -> Profile:
    """Return the profile over `F_RANGE`: every focal length starts from a camera's horizon or from a fan of pitches."""
    log_f = np.linspace(math.log(F_RANGE[0]), math.log(F_RANGE[1]), _COARSE)
    fan = np.tile(start.parameters, (len(_FAN), len(log_f), 1))
    fan[..., 0], fan[..., 1] = _FAN[:, None], 0.0
    starts = np.concatenate([start.with_focal(log_f)[None], fan])
    every = np.tile(log_f, len(starts))
    costs = _fit(segments, every, starts.reshape(-1, 5), np.full(len(every), _SCATTER[-1])).cost
    best_two = np.argsort(costs.reshape(len(starts), -1), axis=0)[:2]
    starts = np.take_along_axis(starts, best_two[..., None], axis=0)
    return _profile(segments, log_f, np.repeat(starts[:, None], len(_SCATTER), axis=1))


def profile_around(segments: Segments, coarse: Profile) -> Profile:
    """Return the profile in small steps around the likeliest camera: from its horizon, or between what was found."""
    best = coarse.best
    log_f = np.linspace(best.log_f - _REACH, best.log_f + _REACH, _FINE)
    above = np.searchsorted(coarse.log_f, log_f).clip(1, len(coarse.log_f) - 1)
    below = coarse.log_f[above - 1]
    share = ((log_f - below) / (coarse.log_f[above] - below))[:, None]
    between = coarse.parameters[:, above - 1] * (1 - share) + coarse.parameters[:, above] * share
    horizon = np.repeat(best.with_focal(log_f)[None], len(_SCATTER), axis=0)
    return _profile(segments, log_f, np.stack([horizon, between]))


def _profile(segments: Segments, log_f: FloatArray, starts: FloatArray) -> Profile:
    """Return the profile at given log f, from the starts of shape (K, S, G, 5) that lead lowest.

    The other parameters are integrated out by Laplace's approximation.
    """
    tries, scatters, count, _ = starts.shape
    every, scatter = np.tile(log_f, tries * scatters), np.tile(np.repeat(_SCATTER, count), tries)
    parameters, fit = _refined(segments, every, starts.reshape(-1, 5), scatter)
    lowest = np.argmin(fit.cost.reshape(tries, scatters, count), axis=0)[None]
    marginal = (fit.cost + np.linalg.slogdet(fit.hessian)[1] / 2).reshape(tries, scatters, count)
    costs = np.take_along_axis(marginal, lowest, axis=0)[0] - np.log(_SCATTER_PRIOR)[:, None]
    return Profile(log_f, costs, np.take_along_axis(parameters.reshape(starts.shape), lowest[..., None], axis=0)[0])


@dataclass(frozen=True)
class _Fit:
    """G cameras given the people: the cost (negative log posterior), shape (G,), and how it goes down.

    hessian: shape (G, 5, 5), Gauss and Newton's, reweighted. slope: shape (G, 5).
    """

    cost: FloatArray
    hessian: FloatArray
    slope: FloatArray

    def where(self, chosen: NDArray[np.bool_], other: _Fit) -> _Fit:
        """Return these where chosen, the others elsewhere."""
        return _Fit(
            np.where(chosen, self.cost, other.cost),
            np.where(chosen[:, None, None], self.hessian, other.hessian),
            np.where(chosen[:, None], self.slope, other.slope),
        )


def _fit(segments: Segments, log_f: FloatArray, parameters: FloatArray, scatter: FloatArray) -> _Fit:
    """Weigh cameras: Student's t for each person, normal priors.

    Pitch and size have wide priors that only keep the equations regular; level horizons are the rule.
    """
    white, log_det = residuals_of(segments, log_f, parameters, scatter)
    distance = (white[0] ** 2).sum(axis=0)
    cost = ((_TAIL + 2) / 2 * np.log1p(distance / _TAIL) + log_det / 2).sum(axis=1)
    weighted = white * np.sqrt((_TAIL + 2) / (_TAIL + distance))
    weighted = weighted.transpose(2, 0, 1, 3).reshape(len(log_f), 6, -1)
    products = weighted @ weighted.transpose(0, 2, 1)  # of residuals and derivatives, each with each
    information = 1 / np.array([1.0, _ROLL_SD, 1.5, segments.principal_sd, segments.principal_sd]) ** 2
    pulled = parameters * information
    cost += (parameters * pulled).sum(axis=1) / 2
    return _Fit(cost, products[:, 1:, 1:] + np.diag(information), products[:, 1:, 0] + pulled)


def _refined(
    segments: Segments, log_f: FloatArray, parameters: FloatArray, scatter: FloatArray, iterations: int = 12
) -> tuple[FloatArray, _Fit]:
    """Return parameters that fit better, after reweighted, damped Gauss-Newton, and how they fit."""
    fit, damping = _fit(segments, log_f, parameters, scatter), np.full(len(log_f), 1e-3)
    for _ in range(iterations):
        damped = fit.hessian * (1 + damping[:, None, None] * np.eye(5))
        trial = parameters - np.linalg.solve(damped, fit.slope[..., None])[..., 0]
        tried = _fit(segments, log_f, trial, scatter)
        moved, better = np.abs(tried.cost - fit.cost), tried.cost < fit.cost
        parameters, fit = np.where(better[:, None], trial, parameters), tried.where(better, fit)
        damping = np.where(better, damping / 5, damping * 5)
        # Most rows are focal lengths that nothing speaks for, and the last to settle. A row as much less likely as e^c
        # may move e^(c/2) times as much: what it adds to the posterior is small then, and it may still come down.
        if (moved * np.exp((fit.cost.min() - fit.cost) / 2)).max() < _IDLE:
            break
    return parameters, fit
