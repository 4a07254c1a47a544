"""Other explanations of a person, each with the camera as everybody else's evidence would have it.

What the others say of the camera stands in as one Gaussian (the cavity of expectation propagation): with the camera
held where the best explanation had put it, an alternative would look worse than it is.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...arrays import FloatArray
from .projection import N_LOCAL, N_SHARED
from .solver import Fit, Rows, bounded, eliminated, evaluate_rows, solved


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


def others_of(fit: Fit) -> Others:
    """Return what everybody else says of the camera, for each of the fit's rows: Gaussian, about the fit."""
    _, own = eliminated(fit.normal)
    rest = own.sum(axis=0) - own + fit.shared_normal
    precision = rest[..., :-1]
    return Others(fit.shared + solved(precision, rest[..., -1:])[..., 0], precision)


def explained(fit: Fit, others: Others) -> Explanations:
    """Return the fit's rows as explanations of their own, the camera being the fit's; `others` row by row."""
    shared = np.broadcast_to(fit.shared, (len(fit.local), N_SHARED))
    return _explanation(fit.local, shared, fit.normal, fit.row_cost, others)[0]


def explain(rows: Rows, local: FloatArray, shared: FloatArray, others: Others, *, steps: int) -> Explanations:
    """Return rows' best explanations some steps from a start (R, N_LOCAL), (R, N_SHARED), each for itself.

    `others` row by row.
    """
    normal, cost, _ = evaluate_rows(rows, local, shared)
    here, pull = _explanation(local, shared, normal, cost, others)
    best = here
    for _ in range(steps):
        gradient = normal[..., -1:].copy()
        gradient[:, N_LOCAL:, 0] += pull
        step = solved(here.precision, gradient)[..., 0]
        local_step, shared_step = bounded(step[:, :N_LOCAL], step[:, N_LOCAL:])
        local, shared = local + local_step, shared + shared_step
        normal, cost, _ = evaluate_rows(rows, local, shared)
        here, pull = _explanation(local, shared, normal, cost, others)
        best = _better(best, here)
    return best


def _explanation(
    local: FloatArray, shared: FloatArray, normal: FloatArray, cost: FloatArray, others: Others
) -> tuple[Explanations, FloatArray]:
    """Return rows with what the others know of the camera, and how that pulls at it (R, N_SHARED)."""
    off = others.mean - shared
    pull = (others.precision @ off[..., None])[..., 0]
    hessian = normal[..., :-1]
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
