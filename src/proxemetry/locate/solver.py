"""Maximum a posteriori by Gauss-Newton with robust weights, everybody at once.

The normal equations are an arrow: each row has its own unknowns and all share the camera's, so a step costs one small
solve a row and one for the shared (Schur complement): linear in people. Keypoints have Student-t noise, as do the
floor's distance and what is known of the camera beforehand: an outlier loses its pull instead of moving the rest.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from .projection import DEPTH, FOCAL, HEADING, N_LOCAL, N_SHARED, BodyTables, project

FloatArray = NDArray[np.float64]

_KEYPOINT_DOF = 5.0
_FLOOR_DOF = 3.0
_SHARED_DOF = 3.0
#: Depths and shared unknowns that move by less end the search.
_SETTLED = 5e-3
#: No unknown moves further in one step: the model is only locally linear.
_LOCAL_STEP, _SHARED_STEP = 0.3, 0.12


@dataclass(frozen=True, eq=False)
class Rows:
    """R rows to be explained, a person under a hypothesis each.

    person: shape (R,). points (R, 2, K), precision (R, K), one over the standard deviation and 0 where unseen: the
    evidence. bodies: the tables of each row's posture. prior_mean (R, N_LOCAL), prior_precision (R, N_LOCAL, N_LOCAL):
    what is known of each body beforehand; prior_log_volume (R,): the log determinant of that precision.
    floor_precision: shape (R,), one over the standard deviation of soles about the floor, 0 for rows off it.
    """

    person: NDArray[np.intp]
    points: FloatArray
    precision: FloatArray
    bodies: BodyTables
    prior_mean: FloatArray
    prior_precision: FloatArray
    prior_log_volume: FloatArray
    floor_precision: FloatArray

    def __len__(self) -> int:
        return len(self.person)

    def taken(self, index: NDArray[np.intp]) -> Rows:
        """Return some of the rows."""
        return Rows(
            self.person[index], self.points[index], self.precision[index], self.bodies.taken(index),
            self.prior_mean[index], self.prior_precision[index], self.prior_log_volume[index],
            self.floor_precision[index],
        )  # fmt: skip

    def with_precision(self, precision: FloatArray) -> Rows:
        """Return the rows with other keypoint noise (R, K)."""
        return replace(self, precision=precision)

    def with_floor(self, factor: float | FloatArray) -> Rows:
        """Return the rows with the floor's precision multiplied."""
        return replace(self, floor_precision=self.floor_precision * factor)


@dataclass(frozen=True, eq=False)
class SharedPrior:
    """What is known of the camera beforehand: mean and scale (N_SHARED,), Student-t but for focal and principal."""

    mean: FloatArray
    sd: FloatArray

    def weights(self, shared: FloatArray) -> FloatArray:
        """Return the precision of each unknown at this estimate."""
        z2 = ((shared - self.mean) / self.sd) ** 2
        robust = (_SHARED_DOF + 1) / (_SHARED_DOF + z2)
        robust[FOCAL:] = 1.0
        return robust / self.sd**2

    def cost(self, shared: FloatArray) -> float:
        """Return the negative log density, up to a constant."""
        z2 = ((shared - self.mean) / self.sd) ** 2
        heavy = (_SHARED_DOF + 1) / 2 * np.log1p(z2[:FOCAL] / _SHARED_DOF)
        return float(heavy.sum() + 0.5 * z2[FOCAL:].sum())


@dataclass(frozen=True, eq=False)
class Fit:
    """An explanation: local (R, N_LOCAL), shared (N_SHARED,), with its normal equations and its cost.

    hessian: shape (R, N_LOCAL + N_SHARED, N_LOCAL + N_SHARED), each row's part without the shared prior, whose
    precision is shared_precision, shape (N_SHARED,). gradient: shape (R, N_LOCAL + N_SHARED), downhill, of the same.
    row_cost: shape (R,), negative log posterior of each row given the
    shared. shared_cost: that of the shared prior. weights: shape (R, K), about 1 for a keypoint fully believed, 0 for
    an outlier. floor_weight: shape (R,), likewise.
    """

    local: FloatArray
    shared: FloatArray
    hessian: FloatArray
    gradient: FloatArray
    shared_precision: FloatArray
    row_cost: FloatArray
    shared_cost: float
    weights: FloatArray
    floor_weight: FloatArray

    @property
    def cost(self) -> float:
        """The negative log posterior of all."""
        return float(self.row_cost.sum()) + self.shared_cost


def solve(rows: Rows, local: FloatArray, shared: FloatArray, prior: SharedPrior, *, iterations: int) -> Fit:
    """Return the best explanation found from a start (R, N_LOCAL), (N_SHARED,)."""
    best: Fit | None = None
    for _ in range(iterations):
        fit = evaluate(rows, local, shared, prior)
        best = fit if best is None or fit.cost <= best.cost else best
        local_step, shared_step = bounded(*_step(fit, prior))
        local, shared = local + local_step, shared + shared_step
        if max(np.abs(local_step[:, DEPTH]).max(initial=0.0), np.abs(shared_step).max()) < _SETTLED and best is fit:
            return _stepped(fit, local_step, shared_step, prior)
    fit = evaluate(rows, local, shared, prior)
    return fit if best is None or fit.cost <= best.cost else best


def _stepped(fit: Fit, local_step: FloatArray, shared_step: FloatArray, prior: SharedPrior) -> Fit:
    """Return the fit after a step so small that the normal equations stay as they are."""
    step = np.concatenate([local_step, np.broadcast_to(shared_step, (len(local_step), N_SHARED))], axis=1)
    bent = (fit.hessian @ step[..., None])[..., 0]
    shared = fit.shared + shared_step
    return replace(
        fit, local=fit.local + local_step, shared=shared, gradient=fit.gradient - bent,
        row_cost=fit.row_cost - (step * (fit.gradient - 0.5 * bent)).sum(axis=1), shared_cost=prior.cost(shared),
    )  # fmt: skip


def approach(
    rows: Rows, local: FloatArray, shared: FloatArray, prior: SharedPrior, *, iterations: int
) -> tuple[FloatArray, FloatArray]:
    """Return local and shared unknowns some steps nearer to an explanation, for another search to begin at."""
    for _ in range(iterations):
        local_step, shared_step = bounded(*_step(evaluate(rows, local, shared, prior), prior))
        local, shared = local + local_step, shared + shared_step
    return local, shared


def bounded(local_step: FloatArray, shared_step: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return steps of local and shared unknowns no longer than the model's linearity carries."""
    return np.clip(local_step, -_LOCAL_STEP, _LOCAL_STEP), np.clip(shared_step, -_SHARED_STEP, _SHARED_STEP)


def evaluate(rows: Rows, local: FloatArray, shared: FloatArray, prior: SharedPrior) -> Fit:
    """Return the fit at this point."""
    hessian, gradient, cost, weights, floor_weight = evaluate_rows(rows, local, shared)
    return Fit(
        local, shared, hessian, gradient, prior.weights(shared), cost, prior.cost(shared), weights, floor_weight
    )  # fmt: skip


def evaluate_rows(
    rows: Rows, local: FloatArray, shared: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray, FloatArray]:
    """Return hessian, gradient, cost, keypoint and floor weights of each row, without what is known of the camera."""
    projected = project(local, shared, rows.bodies)
    residual = (rows.points - projected.points) * rows.precision[:, None]
    squared = residual[:, 0] ** 2 + residual[:, 1] ** 2
    weights = (_KEYPOINT_DOF + 2) / (_KEYPOINT_DOF + squared) * (rows.precision > 0)
    above = projected.floor * rows.floor_precision
    floor_weight = (_FLOOR_DOF + 1) / (_FLOOR_DOF + above**2) * (rows.floor_precision > 0)
    cost = (_KEYPOINT_DOF + 2) / 2 * np.log1p(squared / _KEYPOINT_DOF).sum(axis=1)
    cost += (_FLOOR_DOF + 1) / 2 * np.log1p(above**2 / _FLOOR_DOF)

    count = len(local)
    root, floor_root = np.sqrt(weights), np.sqrt(floor_weight)
    jacobian = np.empty((count, 2 * residual.shape[2] + 1, N_LOCAL + N_SHARED))
    jacobian[:, :-1] = projected.jacobian(root * rows.precision).reshape(count, -1, N_LOCAL + N_SHARED)
    jacobian[:, -1] = projected.floor_jacobian * (floor_root * rows.floor_precision)[:, None]
    stacked = np.concatenate([(residual * root[:, None]).reshape(count, -1), (-above * floor_root)[:, None]], axis=1)
    transposed = jacobian.transpose(0, 2, 1)
    hessian = transposed @ jacobian
    gradient = (transposed @ stacked[..., None])[..., 0]

    off = rows.prior_mean - local
    off[:, HEADING] = (off[:, HEADING] + np.pi) % (2 * np.pi) - np.pi
    pull = (rows.prior_precision @ off[..., None])[..., 0]
    hessian[:, :N_LOCAL, :N_LOCAL] += rows.prior_precision
    gradient[:, :N_LOCAL] += pull
    cost += 0.5 * (off * pull).sum(axis=1)
    return hessian, gradient, cost, weights, floor_weight


def damped(matrix: FloatArray) -> FloatArray:
    """Return normal equations whose local unknowns can all be solved for, whatever was seen."""
    result, index = matrix.copy(), np.arange(N_LOCAL)
    result[:, index, index] += 1e-6 * result[:, index, index] + 1e-9
    return result


def _step(fit: Fit, prior: SharedPrior) -> tuple[FloatArray, FloatArray]:
    own, gradient = damped(fit.hessian[:, :N_LOCAL, :N_LOCAL]), fit.gradient
    cross = fit.hessian[:, :N_LOCAL, N_LOCAL:]
    answer = solved(own, np.concatenate([cross, gradient[:, :N_LOCAL, None]], axis=2))
    by_shared, alone = answer[..., :N_SHARED], answer[..., N_SHARED]
    # Schur complement: what the shared unknowns see once every row has answered
    matrix = schur(fit, by_shared)
    pull = gradient[:, N_LOCAL:].sum(axis=0) - np.einsum("rls,rl->s", cross, alone)
    pull = pull + fit.shared_precision * (prior.mean - fit.shared)
    shared_step = solved(matrix, pull[:, None])[:, 0]
    return alone - by_shared @ shared_step, shared_step


def solved(matrix: FloatArray, right: FloatArray) -> FloatArray:
    """Return matrix^-1 right, for stacks of both."""
    return np.asarray(np.linalg.solve(matrix, right), dtype=float)


def schur(fit: Fit, by_shared: FloatArray) -> FloatArray:
    """Return the precision (N_SHARED, N_SHARED) of the shared unknowns; by_shared is own^-1 cross (R, N_LOCAL, S)."""
    cross = fit.hessian[:, :N_LOCAL, N_LOCAL:]
    own = fit.hessian[:, N_LOCAL:, N_LOCAL:].sum(axis=0)
    return own - np.einsum("rls,rlt->st", cross, by_shared) + np.diag(fit.shared_precision)
