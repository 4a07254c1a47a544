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
from .verticals import F_RANGE, Segments, direct_solution, distances_of, mahalanobis, residuals_of, segments_of

FloatArray = NDArray[np.float64]

#: Photos differ in how still people stand and how well they are seen: factors on lean and keypoint noise, with the
#: prior probability of each. The people's own scatter about the fit decides between them.
_SCATTER = ((0.4, 0.3), (0.8, 0.4), (1.6, 0.3))
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
    scattered = [(segments.scattered(factor), -math.log(weight)) for factor, weight in _SCATTER]
    start, agreeing = _consensus(scattered[-1][0])
    if agreeing < 3:
        return "fewer than 3 people agree on how the camera looks"
    log_f = np.linspace(math.log(F_RANGE[0]), math.log(F_RANGE[1]), 40)
    costs, (best, parameters) = _profiles(scattered, log_f, start)
    low, _, high = _quantiles(log_f, costs)
    if high - low < 8 * math.log1p(WIDEST):  # else no finer grid makes an answer of it
        fine = np.linspace(best - 0.4, best + 0.4, 33)
        fine_costs, (best, parameters) = _profiles(scattered, fine, (best, parameters))
        outside = (log_f < fine[0]) | (log_f > fine[-1])
        log_f = np.concatenate([log_f[outside], fine])
        costs = np.concatenate([costs[:, outside], fine_costs], axis=1)
        order = np.argsort(log_f)
        log_f, costs = log_f[order], costs[:, order]
    low, middle, high = _quantiles(log_f, costs)
    likeliest = scattered[int(np.argmin(costs.min(axis=1)))][0]
    fits = distances_of(likeliest, best, parameters) < _INLIER
    if fits.sum() < 3:
        return "fewer than 3 people agree on how the camera looks"
    upright = np.zeros(len(people), dtype=bool)
    upright[segments.rows[fits]] = True
    f_px, low_px, high_px = (math.exp(value) * segments.long_side_px for value in (middle, low, high))
    return FocalPosterior(f_px, low_px, high_px, (high - low) / (2 * SD_OF_90), float(parameters[0]), upright)


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


def _cost(
    segments: Segments, parameters: FloatArray, residual: FloatArray, precision: FloatArray, log_det: FloatArray
) -> FloatArray:
    """Return the negative log posterior, shape (G,): Student's t for each person, normal priors."""
    people = (_TAIL + 2) / 2 * np.log1p(mahalanobis(residual, precision) / _TAIL) + log_det / 2
    return people.sum(axis=1) + ((parameters / _prior_sd(segments)) ** 2).sum(axis=1) / 2


def _refined(
    segments: Segments, log_f: FloatArray, parameters: FloatArray, iterations: int = 12
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return parameters, costs and half log determinants of the Hessian after reweighted, damped Gauss-Newton."""
    information = np.diag(1 / _prior_sd(segments) ** 2)
    residual, jacobian, precision, log_det = residuals_of(segments, log_f, parameters)
    cost, damping = _cost(segments, parameters, residual, precision, log_det), np.full(len(log_f), 1e-3)
    hessian, idle = np.broadcast_to(information, (len(log_f), 5, 5)), 0
    for _ in range(iterations):
        weight = (_TAIL + 2) / (_TAIL + mahalanobis(residual, precision))
        weighted = (precision @ jacobian) * weight[..., None, None]
        hessian = np.einsum("gnij,gnik->gjk", jacobian, weighted) + information
        slope = np.einsum("gnij,gni->gj", weighted, residual) + parameters @ information
        damped = hessian + damping[:, None, None] * np.einsum("gii->gi", hessian)[:, :, None] * np.eye(5)
        trial = parameters - np.linalg.solve(damped, slope[..., None])[..., 0]
        tried = residuals_of(segments, log_f, trial)
        trial_cost = _cost(segments, trial, tried[0], tried[2], tried[3])
        better = trial_cost < cost
        # once may be a damping that was too weak
        idle = idle + 1 if (cost - trial_cost).max() < _IDLE else 0
        parameters, cost = np.where(better[:, None], trial, parameters), np.where(better, trial_cost, cost)
        residual = np.where(better[:, None, None], tried[0], residual)
        jacobian = np.where(better[:, None, None, None], tried[1], jacobian)
        precision = np.where(better[:, None, None, None], tried[2], precision)
        damping = np.where(better, damping / 5, damping * 5)
        if idle == 2:
            break
    return parameters, cost, np.linalg.slogdet(hessian)[1] / 2


def _profiles(
    scattered: list[tuple[Segments, float]], log_f: FloatArray, start: tuple[float, FloatArray]
) -> tuple[FloatArray, tuple[float, FloatArray]]:
    """Return the negative log marginals of log f, shape (scatters, G), and the best log f with its parameters."""
    found = [_profile(segments, log_f, start) for segments, _ in scattered]
    costs = np.stack([cost + penalty for (cost, _), (_, penalty) in zip(found, scattered, strict=True)])
    scatter, at = np.unravel_index(int(np.argmin(costs)), costs.shape)
    return costs, (float(log_f[at]), found[scatter][1][at])


def _profile(segments: Segments, log_f: FloatArray, start: tuple[float, FloatArray]) -> tuple[FloatArray, FloatArray]:
    """Return the negative log of the marginal posterior, shape (G,), and the best parameters at each, shape (G, 5).

    The other parameters are integrated out by Laplace's approximation. Every focal length starts from the horizon
    that the consensus found, and from a fan of pitches besides.
    """
    starts = [_with_horizon(start, log_f)]
    for degrees in (-25, -10, -3, 3, 10, 25, 45):
        fan = np.tile(start[1], (len(log_f), 1))
        fan[:, 0], fan[:, 1] = math.radians(degrees), 0.0
        starts.append(fan)
    costs = _refined(segments, np.tile(log_f, len(starts)), np.concatenate(starts), iterations=0)[1]
    costs = costs.reshape(len(starts), -1)
    chosen = np.argsort(costs, axis=0)[:2]
    begin = np.stack(starts)[chosen, np.arange(len(log_f))].reshape(-1, 5)
    parameters, cost, half_log_det = (
        found.reshape(2, len(log_f), -1) for found in _refined(segments, np.tile(log_f, 2), begin)
    )
    better, at = np.argmin(cost[..., 0], axis=0), np.arange(len(log_f))
    return (cost + half_log_det)[better, at, 0], parameters[better, at]


def _with_horizon(start: tuple[float, FloatArray], log_f: FloatArray) -> FloatArray:
    """Return parameters for other focal lengths that keep the horizon where it is in the photo."""
    horizon = math.exp(start[0]) * math.tan(start[1][0])
    moved = np.tile(start[1], (len(log_f), 1))
    moved[:, 0] = np.arctan(horizon / np.exp(log_f))
    return moved


def _consensus(segments: Segments) -> tuple[tuple[float, FloatArray], int]:
    """Return the start (log f, parameters) out of triples solved directly that explains people best, and how many."""
    count = len(segments.rows)
    triples = list(itertools.combinations(range(count), 3))
    if len(triples) > _MAX_TRIPLES:
        order = np.random.default_rng(0).permutation(len(triples))[:_MAX_TRIPLES]
        triples = [triples[i] for i in order]
    level = np.array([0.05, 0.0, -0.1, 0.0, 0.0])
    solved = [(0.0, level), *filter(None, (direct_solution(segments, np.array(t)) for t in triples))]
    log_f, parameters = np.array([s[0] for s in solved]), np.stack([s[1] for s in solved])
    parameters, cost, _ = _refined(segments, log_f, parameters, iterations=4)
    best = int(np.argmin(cost))
    agreeing = distances_of(segments, float(log_f[best]), parameters[best]) < _INLIER
    return (float(log_f[best]), parameters[best]), int(agreeing.sum())
