"""Alternative explanations of a person, each with the camera that the other people's evidence supports.

The other people's evidence about the camera is summed up as one Gaussian (the cavity distribution of expectation
propagation). With the camera held where the best explanation put it, an alternative would look worse than it is.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...arrays import FloatArray
from .batch import HypothesisBatch
from .projection import N_LOCAL, N_SHARED
from .solver import Fit, clip_step, evaluate_rows, schur_complement, solve_batch


@dataclass(frozen=True, eq=False)
class Explanations:
    """R rows, each explained with the camera free to move as far as the other people's evidence allows.

    local: shape (R, N_LOCAL). shared: shape (R, N_SHARED), the camera of each explanation. hessian: shape (R,
    N_LOCAL + N_SHARED, N_LOCAL + N_SHARED), the row's own part; precision: the same with the cavity's added. cost:
    shape (R,), the negative log posterior.
    """

    local: FloatArray
    shared: FloatArray
    hessian: FloatArray
    precision: FloatArray
    cost: FloatArray


@dataclass(frozen=True, eq=False)
class Cavity:
    """The camera as all people but one determine it, for each: mean (P, N_SHARED), precision (P, S, S)."""

    mean: FloatArray
    precision: FloatArray

    def taken(self, index: NDArray[np.intp]) -> Cavity:
        """Return the cavity of each row; index: shape (R,), the row's person."""
        return Cavity(self.mean[index], self.precision[index])


def leave_one_out(fit: Fit) -> Cavity:
    """Return for each of the fit's rows the camera that the others determine: Gaussian, linearised at the fit."""
    _, own = schur_complement(fit.normal)
    rest = own.sum(axis=0) - own + fit.shared_normal
    precision = rest[..., :-1]
    return Cavity(fit.shared + solve_batch(precision, rest[..., -1:])[..., 0], precision)


def at_fit(fit: Fit, cavity: Cavity) -> Explanations:
    """Return the fit's rows as explanations of their own, with the fit's camera; the cavity is row by row."""
    shared = np.broadcast_to(fit.shared, (len(fit.local), N_SHARED))
    return _explanation(fit.local, shared, fit.normal, fit.row_cost, cavity)[0]


def refine(rows: HypothesisBatch, local: FloatArray, shared: FloatArray, cavity: Cavity, *, steps: int) -> Explanations:
    """Return rows' best explanations some steps from a start (R, N_LOCAL), (R, N_SHARED), each for itself.

    The cavity is row by row.
    """
    normal, cost, _ = evaluate_rows(rows, local, shared)
    here, pull = _explanation(local, shared, normal, cost, cavity)
    best = here
    for _ in range(steps):
        gradient = normal[..., -1:].copy()
        gradient[:, N_LOCAL:, 0] += pull
        step = solve_batch(here.precision, gradient)[..., 0]
        local_step, shared_step = clip_step(step[:, :N_LOCAL], step[:, N_LOCAL:])
        local, shared = local + local_step, shared + shared_step
        normal, cost, _ = evaluate_rows(rows, local, shared)
        here, pull = _explanation(local, shared, normal, cost, cavity)
        best = _better(best, here)
    return best


def _explanation(
    local: FloatArray, shared: FloatArray, normal: FloatArray, cost: FloatArray, cavity: Cavity
) -> tuple[Explanations, FloatArray]:
    """Return rows with the cavity's information on the camera, and its gradient (R, N_SHARED)."""
    off = cavity.mean - shared
    pull = (cavity.precision @ off[..., None])[..., 0]
    hessian = normal[..., :-1]
    precision = hessian.copy()
    precision[:, N_LOCAL:, N_LOCAL:] += cavity.precision
    return Explanations(local, shared, hessian, precision, cost + 0.5 * (off * pull).sum(axis=1)), pull


def interleaved(own: NDArray[np.intp], a: Explanations, others: NDArray[np.intp], b: Explanations) -> Explanations:
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
