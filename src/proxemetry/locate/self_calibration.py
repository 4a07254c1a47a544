"""The focal length from the people themselves, for photos that say nothing of their camera.

Upright people on one floor are verticals of nearly one length. Where they converge lies the vertical vanishing point,
where their size would shrink to nothing the horizon, and the two lie f^2 apart as seen from the principal point (on
either side of it). A level camera has the one at infinity and the other in the middle: then every focal length fits,
and this module says so.

RANSAC over triples of people with a direct linear solution finds who stands upright; the posterior of the focal
length then takes in everybody, with statures that differ, people who lean, noise of the keypoints and a principal
point that is not quite in the middle.
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ..camera import Camera, CameraEstimate, Candidate
from ..focal import ASSUMED_FIELD_OF_VIEW
from ..frame import SD_OF_90, frame_of
from ..metadata import Metadata
from ..people import People
from .verticals import F_RANGE, Segments, direct_solutions, distances_of, residuals_of, segments_of

FloatArray = NDArray[np.float64]

#: Photos differ in how still people stand and how well they are seen: factors on lean and keypoint noise, with the
#: prior probability of each. The people's own scatter about the fit decides between them.
_SCATTER, _SCATTER_PRIOR = np.array([0.4, 0.8, 1.6]), np.array([0.3, 0.4, 0.3])
#: Widest central 90 % interval that is still an answer: plus or minus this part of the focal length.
WIDEST = 0.30
_ROLL_SD = 0.035  # two degrees
_TAIL = 5.0  # degrees of freedom of the residuals: one in a dozen people is not as modelled
_MAX_TRIPLES = 120
#: A person is part of the explanation where the squared Mahalanobis distance is below this (99 % of a chi-square, 2).
_INLIER = 9.2
#: Two steps in a row that lower no cost by more than this (negative log posterior) end the search.
_IDLE = 1e-3


@dataclass(frozen=True)
class FocalPosterior:
    """What people say of the focal length.

    f_px, low_px, high_px: median and central 90 % interval. log_sd: standard deviation of its logarithm.
    pitch_rad: of the camera, positive where it looks down. upright: shape (P,), who supports it.
    """

    f_px: float
    low_px: float
    high_px: float
    log_sd: float
    pitch_rad: float
    upright: NDArray[np.bool_]


def calibrate(people: People, width: int, height: int) -> CameraEstimate:
    """Return the camera that people in a photo of `width` x `height` pixels tell of, or the reason why they do not.

    It takes three or more upright people with feet and head or shoulders in view, and a camera that looks down (or
    up) at them by some five degrees or more. The estimate's camera is None where the interval of the focal length is
    wider than `WIDEST`; the candidate then still says what was found.
    """
    posterior = focal_posterior(people, width, height)
    if isinstance(posterior, str):
        return CameraEstimate(None, reason=f"none from the people: {posterior}")
    count, pitch = int(posterior.upright.sum()), math.degrees(posterior.pitch_rad)
    source = f"people: {count} upright, camera pitched {pitch:.0f} degrees"
    candidate = Candidate(posterior.f_px, posterior.log_sd, source)
    interval = f"{posterior.low_px:.0f} to {posterior.high_px:.0f} px"
    if SD_OF_90 * posterior.log_sd > math.log1p(WIDEST):
        reason = f"the people leave it open from {interval}: too wide"
        return CameraEstimate(None, (candidate,), reason=reason)
    camera = Camera.centred(posterior.f_px, width, height, focal_rel_sd=posterior.log_sd, source=source)
    camera = replace(camera, principal_sd_px=frame_of(width, height, Metadata()).principal_sd_px)
    return CameraEstimate(camera, (candidate,), (f"focal length from the people: {interval}",))


def with_people(estimate: CameraEstimate, people: People, width: int, height: int) -> CameraEstimate:
    """Return an estimate that lacks a focal length with what the people tell of it; any other as it is.

    What the people tell goes before an assumed field of view, which is for photos that nothing else is known of.
    """
    assumed = estimate.camera is not None and estimate.camera.source.startswith(ASSUMED_FIELD_OF_VIEW)
    if estimate.camera is not None and not assumed:
        return estimate
    found = calibrate(people, width, height)
    candidates = (*found.candidates, *estimate.candidates)
    if found.camera is not None:
        kept = tuple(flag for flag in estimate.flags if ASSUMED_FIELD_OF_VIEW not in flag)
        return CameraEstimate(found.camera, candidates, (*kept, *found.flags))
    if assumed:
        return replace(estimate, candidates=candidates)
    return replace(estimate, candidates=candidates, reason=f"{estimate.reason}; {found.reason}")


def focal_posterior(people: People, width: int, height: int) -> FocalPosterior | str:
    """Return the posterior of the focal length in pixels, or why there is none."""
    segments = segments_of(people, width, height)
    if len(segments.rows) < 3:
        return f"{len(segments.rows)} upright people with feet and head in view, and it takes 3"
    start, agreeing = _consensus(segments)
    if agreeing < 3:
        return "fewer than 3 people agree on how the camera looks"
    log_f = np.linspace(math.log(F_RANGE[0]), math.log(F_RANGE[1]), 40)
    costs, best = _profile(segments, log_f, start)
    low, _, high = _quantiles(log_f, costs)
    if high - low < 8 * math.log1p(WIDEST):  # else no finer grid makes an answer of it
        fine = np.linspace(best.log_f - 0.4, best.log_f + 0.4, 33)
        fine_costs, best = _profile(segments, fine, best)
        outside = (log_f < fine[0]) | (log_f > fine[-1])
        log_f = np.concatenate([log_f[outside], fine])
        costs = np.concatenate([costs[:, outside], fine_costs], axis=1)
        order = np.argsort(log_f)
        log_f, costs = log_f[order], costs[:, order]
    low, middle, high = _quantiles(log_f, costs)
    likeliest = float(_SCATTER[np.argmin(costs.min(axis=1))])
    fits = distances_of(segments, best.log_f, best.parameters, likeliest) < _INLIER
    if fits.sum() < 3:
        return "fewer than 3 people agree on how the camera looks"
    upright = np.zeros(len(people), dtype=bool)
    upright[segments.rows[fits]] = True
    f_px, low_px, high_px = (math.exp(value) * segments.long_side_px for value in (middle, low, high))
    return FocalPosterior(f_px, low_px, high_px, (high - low) / (2 * SD_OF_90), float(best.parameters[0]), upright)


@dataclass(frozen=True)
class _Pose:
    """A camera: the logarithm of its focal length and the parameters of `verticals.tops_of`, shape (5,)."""

    log_f: float
    parameters: FloatArray

    def with_focal(self, log_f: FloatArray) -> FloatArray:
        """Return parameters, shape (G, 5), for other focal lengths that keep the horizon where it is in the photo."""
        moved = np.tile(self.parameters, (len(log_f), 1))
        moved[:, 0] = np.arctan(math.exp(self.log_f) * math.tan(self.parameters[0]) / np.exp(log_f))
        return moved


def _quantiles(log_f: FloatArray, costs: FloatArray) -> tuple[float, float, float]:
    """Return the 5th, 50th and 95th percentile of log f; costs: shape (scatters, G), negative log densities."""
    density = np.exp(costs.min() - costs).sum(axis=0)
    steps = np.diff(log_f) * (density[1:] + density[:-1]) / 2
    cumulative = np.concatenate([[0.0], np.cumsum(steps)]) / steps.sum()
    low, middle, high = np.interp([0.05, 0.5, 0.95], cumulative, log_f)
    return float(low), float(middle), float(high)


def _prior_sd(segments: Segments) -> FloatArray:
    """Pitch and size have wide priors that only keep the equations regular; level horizons are the rule."""
    return np.array([1.0, _ROLL_SD, 1.5, segments.principal_sd, segments.principal_sd])


@dataclass(frozen=True)
class _Fit:
    """What people say of G cameras: the cost (negative log posterior), shape (G,), and how it goes down.

    hessian: shape (G, 5, 5), Gauss and Newton's, reweighted. slope: shape (G, 5).
    """

    cost: FloatArray
    hessian: FloatArray
    slope: FloatArray


def _fit(segments: Segments, log_f: FloatArray, parameters: FloatArray, scatter: FloatArray) -> _Fit:
    """Weigh cameras: Student's t for each person, normal priors."""
    residual, jacobian, log_det = residuals_of(segments, log_f, parameters, scatter)
    distance, prior = (residual**2).sum(axis=0), 1 / _prior_sd(segments)
    cost = ((_TAIL + 2) / 2 * np.log1p(distance / _TAIL) + log_det / 2).sum(axis=1)
    weight = np.sqrt((_TAIL + 2) / (_TAIL + distance))
    rows = len(log_f)
    # the priors are residuals as well: five more rows
    jacobian = np.concatenate(
        [
            (jacobian * weight).transpose(2, 1, 3, 0).reshape(rows, -1, 5),
            np.broadcast_to(np.diag(prior), (rows, 5, 5)),
        ],
        axis=1,
    )
    residual = np.concatenate([(residual * weight).transpose(1, 0, 2).reshape(rows, -1), parameters * prior], axis=1)
    transposed = jacobian.transpose(0, 2, 1)
    return _Fit(
        cost + ((parameters * prior) ** 2).sum(axis=1) / 2, transposed @ jacobian, (transposed @ residual[..., None])
    )


def _refined(
    segments: Segments, log_f: FloatArray, parameters: FloatArray, scatter: FloatArray, iterations: int = 12
) -> tuple[FloatArray, _Fit]:
    """Return parameters that fit better, after reweighted, damped Gauss-Newton, and how they fit."""
    fit, damping, idle = _fit(segments, log_f, parameters, scatter), np.full(len(log_f), 1e-3), 0
    for _ in range(iterations):
        damped = fit.hessian * (1 + damping[:, None, None] * np.eye(5))
        trial = parameters - np.linalg.solve(damped, fit.slope)[..., 0]
        tried = _fit(segments, log_f, trial, scatter)
        better = tried.cost < fit.cost
        # once may be a damping that was too weak
        idle = idle + 1 if (fit.cost - tried.cost).max() < _IDLE else 0
        parameters = np.where(better[:, None], trial, parameters)
        fit = _Fit(
            np.where(better, tried.cost, fit.cost),
            np.where(better[:, None, None], tried.hessian, fit.hessian),
            np.where(better[:, None, None], tried.slope, fit.slope),
        )
        damping = np.where(better, damping / 5, damping * 5)
        if idle == 2:
            break
    return parameters, fit


def _profile(segments: Segments, log_f: FloatArray, start: _Pose) -> tuple[FloatArray, _Pose]:
    """Return the negative log marginals of log f, shape (scatters, G), and the likeliest camera.

    The other parameters are integrated out by Laplace's approximation. Every focal length starts from the horizon
    that the consensus found, and from a fan of pitches besides.
    """
    starts = [start.with_focal(log_f)]
    for degrees in (-25, -10, -3, 3, 10, 25, 45):
        fan = np.tile(start.parameters, (len(log_f), 1))
        fan[:, 0], fan[:, 1] = math.radians(degrees), 0.0
        starts.append(fan)
    count, scatters = len(log_f), len(_SCATTER)
    at, fan = np.arange(count), np.stack(starts)
    shape = (scatters, len(starts), count)
    costs = _fit(
        segments, np.tile(log_f, scatters * len(starts)), np.tile(fan.reshape(-1, 5), (scatters, 1)),
        np.repeat(_SCATTER, len(starts) * count),
    ).cost.reshape(shape)  # fmt: skip
    chosen = np.argsort(costs, axis=1)[:, :2]
    begin = fan[chosen, at].reshape(-1, 5)
    parameters, fit = _refined(segments, np.tile(log_f, 2 * scatters), begin, np.repeat(_SCATTER, 2 * count))
    cost = (fit.cost + np.linalg.slogdet(fit.hessian)[1] / 2).reshape(scatters, 2, count)
    better = np.argmin(fit.cost.reshape(scatters, 2, count), axis=1)
    s = np.arange(scatters)[:, None]
    cost = cost[s, better, at] - np.log(_SCATTER_PRIOR)[:, None]
    parameters = parameters.reshape(scatters, 2, count, 5)[s, better, at]
    scatter, place = np.unravel_index(int(np.argmin(cost)), cost.shape)
    return cost, _Pose(float(log_f[place]), parameters[scatter, place])


def _consensus(segments: Segments) -> tuple[_Pose, int]:
    """Return the camera out of triples solved directly that explains people best, and how many."""
    count = len(segments.rows)
    triples = np.array(list(itertools.combinations(range(count), 3)))
    if len(triples) > _MAX_TRIPLES:
        triples = triples[np.random.default_rng(0).permutation(len(triples))[:_MAX_TRIPLES]]
    level = np.array([0.05, 0.0, -0.1, 0.0, 0.0])
    log_f, parameters = direct_solutions(segments, triples)
    log_f, parameters = np.append(0.0, log_f), np.vstack([level, parameters])
    parameters, fit = _refined(segments, log_f, parameters, np.full(len(log_f), _SCATTER[-1]), iterations=4)
    best = int(np.argmin(fit.cost))
    agreeing = distances_of(segments, float(log_f[best]), parameters[best], float(_SCATTER[-1])) < _INLIER
    return _Pose(float(log_f[best]), parameters[best]), int(agreeing.sum())
