"""Whether the picture contradicts what is stated: the camera's place by its mount, or a person's distance."""

from __future__ import annotations

import numpy as np

from ...arrays import FloatArray
from .batch import HypothesisBatch
from .camera_prior import SharedPrior
from .projection import DEPTH, N_LOCAL, N_SHARED
from .solver import Fit, evaluate_rows, schur_complement, solve_batch, stated_depth_precision

#: What is known of pitch, roll, log height, log focal length and principal point (in focal lengths) of a camera that
#: may be anywhere: so wide that it decides nothing, and the people's own equations stay solvable.
_ANYWHERE: FloatArray = np.array([1.0, 0.5, 1.5, 1.0, 0.1, 0.1])


def misfit(fit: Fit, prior: SharedPrior) -> float:
    """Return by how many standard deviations the people put the camera elsewhere than its place, root mean square.

    The deviation is theirs and the place's together. It is NaN where no place is stated.
    """
    which = prior.place.which
    if not len(which):
        return float("nan")
    alone = SharedPrior(prior.mean, np.where(np.isinf(prior.sd), _ANYWHERE, prior.sd))
    _, normal = alone.cost(fit.shared)
    # what pulls back to the place from where nothing is known is not the people's
    normal[which, -1] = 0.0
    _, reduced = schur_complement(fit.normal)
    normal += reduced.sum(axis=0)
    own = solve_batch(normal[:, :-1], np.column_stack([normal[:, -1], np.eye(N_SHARED)]))
    apart = (fit.shared + own[:, 0])[which] - prior.place.mean
    covariance = own[:, 1:][np.ix_(which, which)] + prior.place.covariance
    return float(np.sqrt(apart @ solve_batch(covariance, apart) / len(which)))


def depth_misfit(rows: HypothesisBatch, fit: Fit, elsewhere: FloatArray) -> FloatArray:
    """Return by how many standard deviations each stated depth is off all other evidence, shape (P,).

    rows: the fit's. elsewhere: shape (P,), what other explanations of a person add to the variance of the log depth.
    The deviation is that of both sides together, the depth's own part in the fit taken out again; positive where it is
    stated too far away, NaN where none is stated.
    """
    stated = rows.depth_precision > 0
    if not stated.any():
        return np.full(len(rows), np.nan)
    stated_precision, precision = stated_depth_precision(rows, fit.local), 1 / _depth_variance(rows, fit)
    rest = np.maximum(precision - stated_precision, 1e-6 * precision)  # never negative but for rounding
    sd = 1 / np.where(stated, rows.depth_precision, 1.0)
    away = (rows.log_depth - fit.local[:, DEPTH]) * precision / rest
    return np.where(stated, away / np.sqrt(1 / rest + elsewhere + sd**2), np.nan)


def _depth_variance(rows: HypothesisBatch, fit: Fit) -> FloatArray:
    """Return the variance of each person's log depth (P,), from the equations at the answer itself."""
    normal, _, _ = evaluate_rows(rows, fit.local, fit.shared)
    answer, reduced = schur_complement(normal)
    shared = reduced.sum(axis=0)[:, :-1] + fit.shared_normal[:, :-1]
    unit = np.zeros((N_LOCAL, 1))
    unit[DEPTH] = 1.0
    own = solve_batch(normal[:, :N_LOCAL, :N_LOCAL], unit)[:, DEPTH, 0]
    by_shared = answer[:, DEPTH, :N_SHARED]
    return own + (by_shared * solve_batch(shared, by_shared.T).T).sum(axis=1)
