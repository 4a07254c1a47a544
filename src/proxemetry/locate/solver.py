"""Maximum a posteriori by Gauss-Newton with robust weights, everybody at once.

The normal equations are an arrow: each row has its own unknowns and all share the camera's, so a step costs one small
solve a row and one for the shared (Schur complement): linear in people. Keypoints have Student-t noise, as do the
floor's distance and what is known of the camera beforehand: an outlier loses its pull instead of moving the rest.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from .body_model import BodyModel
from .projection import DEPTH, FOCAL, HEADING, LOG_LENGTHS, N_LOCAL, N_SHARED, POSTURE, TURN, project

FloatArray = NDArray[np.float64]

_KEYPOINT_DOF = 5.0
_FLOOR_DOF = 3.0
_SHARED_DOF = 3.0
_TURN_SD = 0.45
#: No step moves an unknown further than this: the model is only locally linear.
_LOCAL_STEP, _SHARED_STEP = 0.3, 0.12


@dataclass(frozen=True, eq=False)
class Rows:
    """R rows to be explained, a person under a hypothesis each.

    person: shape (R,). points (R, K, 2), sd (R, K), infinite where unseen: the evidence. posture: shape (R,).
    length_mean (R, L), length_precision (R, L, L): the prior of the log lengths. heading (R,), heading_precision (R,):
    what is known of the heading beforehand. floor_sd: shape (R,), infinite for rows off the floor.
    """

    person: NDArray[np.intp]
    points: FloatArray
    sd: FloatArray
    posture: NDArray[np.intp]
    length_mean: FloatArray
    length_precision: FloatArray
    heading: FloatArray
    heading_precision: FloatArray
    floor_sd: FloatArray

    def __len__(self) -> int:
        return len(self.person)

    def taken(self, index: NDArray[np.intp]) -> Rows:
        """Return some of the rows."""
        return Rows(*(getattr(self, name)[index] for name in self.__dataclass_fields__))

    def with_sd(self, sd: FloatArray) -> Rows:
        """Return the rows with other keypoint noise (R, K)."""
        return replace(self, sd=sd)


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
    precision is shared_precision, shape (N_SHARED,). row_cost: shape (R,), negative log posterior of each row given the
    shared. shared_cost: that of the shared prior. weights: shape (R, K), about 1 for a keypoint fully believed, 0 for
    an outlier. floor_weight: shape (R,), likewise.
    """

    local: FloatArray
    shared: FloatArray
    hessian: FloatArray
    shared_precision: FloatArray
    row_cost: FloatArray
    shared_cost: float
    weights: FloatArray
    floor_weight: FloatArray

    @property
    def cost(self) -> float:
        """The negative log posterior of all."""
        return float(self.row_cost.sum()) + self.shared_cost


def solve(
    rows: Rows, local: FloatArray, shared: FloatArray, prior: SharedPrior, model: BodyModel, *, iterations: int,
    shared_moves: bool = True,
) -> Fit:  # fmt: skip
    """Return the best explanation found from a start (R, N_LOCAL), (N_SHARED,); without `shared_moves` rows only."""
    best: Fit | None = None
    for _ in range(iterations):
        fit, gradient = _evaluate(rows, local, shared, prior, model)
        best = fit if best is None else _better(best, fit, shared_moves)
        local_step, shared_step = _step(fit, gradient, prior, shared_moves)
        local = local + np.clip(local_step, -_LOCAL_STEP, _LOCAL_STEP)
        shared = shared + np.clip(shared_step, -_SHARED_STEP, _SHARED_STEP)
        if max(np.abs(local_step).max(initial=0.0), np.abs(shared_step).max()) < 1e-4:
            break
    fit, _ = _evaluate(rows, local, shared, prior, model)
    return fit if best is None else _better(best, fit, shared_moves)


def _better(a: Fit, b: Fit, shared_moves: bool) -> Fit:
    if shared_moves or not len(a.row_cost):
        return a if a.cost < b.cost else b
    keep = a.row_cost < b.row_cost  # with the shared held, every row stands alone
    if not keep.any():
        return b

    def mixed(x: FloatArray, y: FloatArray) -> FloatArray:
        return np.where(keep.reshape(-1, *([1] * (x.ndim - 1))), x, y)

    return Fit(
        mixed(a.local, b.local), b.shared, mixed(a.hessian, b.hessian), b.shared_precision,
        mixed(a.row_cost, b.row_cost), b.shared_cost, mixed(a.weights, b.weights),
        mixed(a.floor_weight, b.floor_weight),
    )  # fmt: skip


def _evaluate(
    rows: Rows, local: FloatArray, shared: FloatArray, prior: SharedPrior, model: BodyModel
) -> tuple[Fit, FloatArray]:
    """Return the fit at this point and its gradient (R, N_LOCAL + N_SHARED), downhill, without the shared prior."""
    projected = project(local, shared, rows.posture, model)
    residual = (rows.points - projected.points) / rows.sd[..., None]
    squared = (residual**2).sum(axis=-1)
    seen = np.isfinite(rows.sd)
    weights = np.where(seen, (_KEYPOINT_DOF + 2) / (_KEYPOINT_DOF + squared), 0.0)
    cost = np.where(seen, (_KEYPOINT_DOF + 2) / 2 * np.log1p(squared / _KEYPOINT_DOF), 0.0).sum(axis=1)

    above = projected.floor / rows.floor_sd
    on_floor = np.isfinite(rows.floor_sd)
    floor_weight = np.where(on_floor, (_FLOOR_DOF + 1) / (_FLOOR_DOF + above**2), 0.0)
    cost = cost + np.where(on_floor, (_FLOOR_DOF + 1) / 2 * np.log1p(above**2 / _FLOOR_DOF), 0.0)

    count = len(local)
    root = np.sqrt(weights)[..., None]
    jacobian = np.empty((count, 2 * residual.shape[1] + 1, N_LOCAL + N_SHARED))
    jacobian[:, :-1] = (projected.jacobian * (root / rows.sd[..., None])[..., None]).reshape(
        count, -1, N_LOCAL + N_SHARED
    )
    jacobian[:, -1] = projected.floor_jacobian * (np.sqrt(floor_weight) / rows.floor_sd)[:, None]
    stacked = np.concatenate([(residual * root).reshape(count, -1), (-above * np.sqrt(floor_weight))[:, None]], axis=1)
    transposed = jacobian.transpose(0, 2, 1)
    hessian = transposed @ jacobian
    gradient = (transposed @ stacked[..., None])[..., 0]
    cost = cost + _add_priors(rows, local, model, hessian, gradient)
    fit = Fit(
        local, shared, hessian, prior.weights(shared), cost, prior.cost(shared), weights, floor_weight
    )  # fmt: skip
    return fit, gradient


def _add_priors(
    rows: Rows, local: FloatArray, model: BodyModel, hessian: FloatArray, gradient: FloatArray
) -> FloatArray:
    """Add what is known of each body beforehand to the normal equations, and return its cost (R,)."""
    diagonal = np.zeros((len(local), N_LOCAL))
    off = np.zeros((len(local), N_LOCAL))
    diagonal[:, DEPTH] = 1e-4  # nothing is known of depth, but the equations stay solvable
    diagonal[:, HEADING] = rows.heading_precision + 1e-4
    off[:, HEADING] = np.angle(np.exp(1j * (rows.heading - local[:, HEADING])))
    diagonal[:, TURN] = _TURN_SD**-2
    off[:, TURN] = -local[:, TURN]
    diagonal[:, POSTURE] = model.prior_sd[rows.posture] ** -2
    off[:, POSTURE] = model.prior_mean[rows.posture] - local[:, POSTURE]
    index = np.arange(N_LOCAL)
    hessian[:, index, index] += diagonal
    gradient[:, :N_LOCAL] += diagonal * off
    cost = 0.5 * (diagonal * off**2).sum(axis=1)
    apart = rows.length_mean - local[:, LOG_LENGTHS]
    pull = (rows.length_precision @ apart[..., None])[..., 0]
    hessian[:, LOG_LENGTHS, LOG_LENGTHS] += rows.length_precision
    gradient[:, LOG_LENGTHS] += pull
    return cost + 0.5 * (apart * pull).sum(axis=1)


def _step(fit: Fit, gradient: FloatArray, prior: SharedPrior, shared_moves: bool) -> tuple[FloatArray, FloatArray]:
    own = fit.hessian[:, :N_LOCAL, :N_LOCAL].copy()
    index = np.arange(N_LOCAL)
    own[:, index, index] += 1e-6 * own[:, index, index] + 1e-9
    if not shared_moves:
        return solved(own, gradient[:, :N_LOCAL, None])[..., 0], np.zeros(N_SHARED)
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
