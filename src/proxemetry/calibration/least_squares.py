"""Least squares for a handful of unknowns: Levenberg and Marquardt with differences for derivatives."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ..arrays import FloatArray

#: Whitened residuals of unknowns: what is measured less what is expected, in standard deviations.
Residuals = Callable[[FloatArray], FloatArray]

_STEP = 1e-6
_ITERATIONS = 200
_SETTLED = 1e-13


def minimise(
    residuals: Residuals, start: FloatArray, derivatives: Residuals | None = None
) -> tuple[FloatArray, FloatArray]:
    """Return the unknowns (N,) of the least sum of squares near a start, and the normal matrix (N, N) there.

    derivatives: those of the residuals, shape (M, N), at given unknowns; by differences where None.
    """
    slope = derivatives or (lambda unknowns: _jacobian(residuals, unknowns))
    at, damping = start.copy(), 1e-4
    here = residuals(at)
    jacobian = slope(at)
    for _ in range(_ITERATIONS):
        normal, pull = jacobian.T @ jacobian, -jacobian.T @ here
        step = np.linalg.solve(normal + damping * np.diag(np.diag(normal) + 1e-12), pull)
        there = residuals(at + step)
        if np.isfinite(there).all() and there @ there <= here @ here:
            at, here, damping = at + step, there, max(damping / 10, 1e-12)
            jacobian = slope(at)
            if np.abs(step).max() < _SETTLED * max(1.0, float(np.abs(at).max())):
                break
        elif damping > 1e12:
            break
        else:
            damping *= 10
    return at, jacobian.T @ jacobian


def _jacobian(residuals: Residuals, at: FloatArray) -> FloatArray:
    """Return the derivatives of the residuals (M, N) by central differences."""
    columns: list[FloatArray] = []
    for k in range(len(at)):
        by = np.zeros(len(at))
        by[k] = _STEP * max(1.0, abs(float(at[k])))
        columns.append((residuals(at + by) - residuals(at - by)) / (2 * by[k]))
    return np.stack(columns, axis=1)
