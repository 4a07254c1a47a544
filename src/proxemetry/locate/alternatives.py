"""Other explanations of a person, each with the camera as everybody else's evidence would have it.

What the others say of the camera stands in as one Gaussian (the cavity of expectation propagation): with the camera
held where the best explanation had put it, an alternative would look worse than it is.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .projection import N_LOCAL, N_SHARED
from .solver import Fit, Rows, SharedPrior, bounded, damped, evaluate_rows, solved

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Explanations:
    """R rows, each explained with the camera free to move as far as everybody else's evidence lets it.

    local: shape (R, N_LOCAL). shared: shape (R, N_SHARED), the camera that each row would have. hessian: shape (R,
    N_LOCAL + N_SHARED, N_LOCAL + N_SHARED), the row's own part; precision: the same with everybody else's knowledge of
    the camera. cost: shape (R,), the negative log posterior.
    """

    local: FloatArray
    shared: FloatArray
    hessian: FloatArray
    precision: FloatArray
    cost: FloatArray


@dataclass(frozen=True, eq=False)
class Others:
    """What everybody but one says of the camera, person by person: mean (P, N_SHARED), precision (P, S, S)."""

    mean: FloatArray
    precision: FloatArray

    def taken(self, index: NDArray[np.intp]) -> Others:
        """Return them row by row."""
        return Others(self.mean[index], self.precision[index])


def others_of(fit: Fit, prior: SharedPrior) -> Others:
    """Return what everybody else says of the camera, for each of the fit's rows: Gaussian, about the fit."""
    own, cross = fit.hessian[:, :N_LOCAL, :N_LOCAL], fit.hessian[:, :N_LOCAL, N_LOCAL:]
    answer = solved(own, np.concatenate([cross, fit.gradient[:, :N_LOCAL, None]], axis=2))
    crossed = cross.transpose(0, 2, 1) @ answer
    matrix = fit.hessian[:, N_LOCAL:, N_LOCAL:] - crossed[..., :N_SHARED]
    pull = fit.gradient[:, N_LOCAL:] - crossed[..., N_SHARED]
    precision = matrix.sum(axis=0) - matrix + np.diag(fit.shared_precision)
    total = pull.sum(axis=0) - pull + fit.shared_precision * (prior.mean - fit.shared)
    return Others(fit.shared + solved(precision, total[..., None])[..., 0], precision)


def explained(fit: Fit, others: Others) -> Explanations:
    """Return the fit's rows as explanations of their own, the camera being the fit's; `others` row by row."""
    shared = np.broadcast_to(fit.shared, (len(fit.local), N_SHARED))
    return _explanation(fit.local, shared, fit.hessian, fit.row_cost, others)[0]


def explain(rows: Rows, local: FloatArray, shared: FloatArray, others: Others, *, iterations: int) -> Explanations:
    """Return rows' best explanations from a start (R, N_LOCAL), (R, N_SHARED), each for itself; `others` row by row."""
    best: Explanations | None = None
    for iteration in range(iterations + 1):
        hessian, gradient, cost, _, _ = evaluate_rows(rows, local, shared)
        here, pull = _explanation(local, shared, hessian, cost, others)
        best = here if best is None else _better(best, here)
        if iteration < iterations:
            gradient[:, N_LOCAL:] += pull
            step = solved(damped(here.precision), gradient[..., None])[..., 0]
            local_step, shared_step = bounded(step[:, :N_LOCAL], step[:, N_LOCAL:])
            local, shared = local + local_step, shared + shared_step
    assert best is not None
    return best


def _explanation(
    local: FloatArray, shared: FloatArray, hessian: FloatArray, cost: FloatArray, others: Others
) -> tuple[Explanations, FloatArray]:
    """Return rows with what the others know of the camera, and how that pulls at it (R, N_SHARED)."""
    off = others.mean - shared
    pull = (others.precision @ off[..., None])[..., 0]
    precision = hessian.copy()
    precision[:, N_LOCAL:, N_LOCAL:] += others.precision
    return Explanations(local, shared, hessian, precision, cost + 0.5 * (off * pull).sum(axis=1)), pull


def joined(own: NDArray[np.intp], a: Explanations, others: NDArray[np.intp], b: Explanations) -> Explanations:
    """Return explanations `a` at the rows `own` and `b` at the rows `others`."""
    order = np.argsort(np.concatenate([own, others]))
    return Explanations(*(
        np.concatenate([x, y])[order]
        for x, y in ((a.local, b.local), (a.shared, b.shared), (a.hessian, b.hessian), (a.precision, b.precision),
                     (a.cost, b.cost))
    ))  # fmt: skip


def _better(a: Explanations, b: Explanations) -> Explanations:
    """Return the better of two explanations row by row."""
    keep = a.cost < b.cost
    if not keep.any():
        return b

    def mixed(x: FloatArray, y: FloatArray) -> FloatArray:
        return np.where(keep.reshape(-1, *([1] * (x.ndim - 1))), x, y)

    return Explanations(
        mixed(a.local, b.local), mixed(a.shared, b.shared), mixed(a.hessian, b.hessian),
        mixed(a.precision, b.precision), mixed(a.cost, b.cost),
    )  # fmt: skip
