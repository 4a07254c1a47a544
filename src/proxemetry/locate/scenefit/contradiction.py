"""Whether the people say that the camera is not where its mount has it."""

from __future__ import annotations

import numpy as np

from ...arrays import FloatArray
from .projection import N_SHARED
from .solver import Fit, SharedPrior, schur_complement, solve_batch

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
