"""Maximum a posteriori by Gauss-Newton with robust weights, all people at once.

The normal equations are an arrow: each row has its own unknowns and all share the camera's, so a step costs one small
solve a row and one for the shared (Schur complement): linear in people. Keypoints have Student-t noise, as do the
floor's distance, stated depths and the camera's prior: an outlier loses its pull instead of moving the rest.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...arrays import FloatArray
from .batch import HypothesisBatch
from .camera_prior import SharedPrior
from .projection import DEPTH, HEADING, N_LOCAL, N_SHARED, TURN, project

#: Degrees of freedom of Student's distribution (docs/method.md, "Evidence"): keypoints, floor, stated depths.
_KEYPOINT_DOF = 5.0
_FLOOR_DOF = 3.0
_DEPTH_DOF = 3.0
#: Depths and shared unknowns that move by less end the search; the last step itself is still taken.
_SETTLED = 1e-2
#: No unknown moves further in one step: the model is only locally linear. The log of the camera's height bends little.
_LOCAL_STEP = 0.3
_SHARED_STEP: FloatArray = np.array([0.12, 0.12, 0.4, 0.12, 0.12, 0.12])
#: Headings that swing to and fro, as they do between two outliers, move by this much of the last swing at most.
_SWING = 0.5
_FACING = slice(HEADING, TURN + 1)


@dataclass(frozen=True, eq=False)
class Fit:
    """An explanation: local (R, N_LOCAL), shared (N_SHARED,), with its normal equations and its cost.

    normal: shape (R, N_LOCAL + N_SHARED, N_LOCAL + N_SHARED + 1), each row's hessian and, downhill, its gradient,
    without the shared prior, whose own is shared_normal, shape (N_SHARED, N_SHARED + 1). row_cost: shape (R,), negative
    log posterior of each row given the shared. shared_cost: that of the shared prior. weights: shape (R, K), about 1
    for a keypoint fully believed, 0 for an outlier; without meaning for those not seen.
    """

    local: FloatArray
    shared: FloatArray
    normal: FloatArray
    shared_normal: FloatArray
    row_cost: FloatArray
    shared_cost: float
    weights: FloatArray

    @property
    def hessian(self) -> FloatArray:
        """The rows' hessians, shape (R, N_LOCAL + N_SHARED, N_LOCAL + N_SHARED)."""
        return self.normal[..., :-1]

    @property
    def gradient(self) -> FloatArray:
        """Downhill, shape (R, N_LOCAL + N_SHARED)."""
        return self.normal[..., -1]

    @property
    def cost(self) -> float:
        """The negative log posterior of all."""
        return float(self.row_cost.sum()) + self.shared_cost


def solve(rows: HypothesisBatch, local: FloatArray, shared: FloatArray, prior: SharedPrior, *, iterations: int) -> Fit:
    """Return the best explanation found from a start (R, N_LOCAL), (N_SHARED,)."""
    best: Fit | None = None
    last, longest = np.zeros((len(local), 2)), np.full((len(local), 2), _LOCAL_STEP)
    for _ in range(iterations):
        fit = evaluate(rows, local, shared, prior)
        best = fit if best is None or fit.cost <= best.cost else best
        local_step, shared_step = clip_step(*_step(fit))
        longest = np.where(local_step[:, _FACING] * last < 0, _SWING * np.abs(last), longest)
        last = local_step[:, _FACING] = np.clip(local_step[:, _FACING], -longest, longest)
        local, shared = local + local_step, shared + shared_step
        if max(np.abs(local_step[:, DEPTH]).max(initial=0.0), np.abs(shared_step).max()) < _SETTLED and best is fit:
            return _stepped(fit, local_step, shared_step, prior)
    fit = evaluate(rows, local, shared, prior)
    return fit if best is None or fit.cost <= best.cost else best


def _stepped(fit: Fit, local_step: FloatArray, shared_step: FloatArray, prior: SharedPrior) -> Fit:
    """Return the fit after a step so small that the hessians stay as they are."""
    step = np.concatenate([local_step, np.broadcast_to(shared_step, (len(local_step), N_SHARED))], axis=1)
    bent, normal = (fit.hessian @ step[..., None])[..., 0], fit.normal.copy()
    row_cost = fit.row_cost - (step * (normal[..., -1] - 0.5 * bent)).sum(axis=1)
    normal[..., -1] -= bent
    shared = fit.shared + shared_step
    shared_cost, shared_normal = prior.cost(shared)
    return Fit(fit.local + local_step, shared, normal, shared_normal, row_cost, float(shared_cost), fit.weights)


def gauss_newton_step(
    rows: HypothesisBatch, local: FloatArray, shared: FloatArray, prior: SharedPrior,
    leading: NDArray[np.intp],
) -> Fit:  # fmt: skip
    """Return the fit one step nearer to an explanation, in which only the leading rows move the camera."""
    fit = evaluate(rows, local, shared, prior)
    local_step, shared_step = _step(fit, leading)
    return _stepped(fit, *clip_step(local_step, shared_step), prior)


def clip_step(local_step: FloatArray, shared_step: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return steps of local and shared unknowns no longer than the model's linearity carries."""
    return np.clip(local_step, -_LOCAL_STEP, _LOCAL_STEP), np.clip(shared_step, -_SHARED_STEP, _SHARED_STEP)


def evaluate(rows: HypothesisBatch, local: FloatArray, shared: FloatArray, prior: SharedPrior) -> Fit:
    """Return the fit at this point."""
    normal, cost, weights = evaluate_rows(rows, local, shared)
    shared_cost, shared_normal = prior.cost(shared)
    return Fit(local, shared, normal, shared_normal, cost, float(shared_cost), weights)


def evaluate_rows(
    rows: HypothesisBatch, local: FloatArray, shared: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return normal equations, cost and keypoint weights of each row, without what is known of the camera."""
    equations, noise, cost, weights = weighted_equations(rows, local, shared)
    normal = (equations[..., :-1] * noise[..., None]).transpose(0, 2, 1) @ equations

    precision, pull, known = known_of_rows(rows, local)
    normal[:, :N_LOCAL, :N_LOCAL] += precision
    normal[:, :N_LOCAL, -1] += pull
    cost += known
    return normal, cost, weights


def weighted_equations(
    rows: HypothesisBatch, local: FloatArray, shared: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Return each row's equations of keypoints and sole, their robust precision, their cost, and keypoint weights.

    equations: shape (R, 2 K + 1, N_LOCAL + N_SHARED + 1), derivatives and, last, residuals, as `project` orders them;
    precision: shape (R, 2 K + 1).
    """
    projected = project(local, shared, rows.bodies)
    count, joints = rows.precision.shape
    residual = rows.points - projected.points
    off_keypoints = 1 + ((residual * rows.precision[:, None]) ** 2).sum(axis=1) / _KEYPOINT_DOF
    off_floor = 1 + (projected.floor * rows.floor_precision) ** 2 / _FLOOR_DOF
    weights = (1 + 2 / _KEYPOINT_DOF) / off_keypoints
    cost = (_KEYPOINT_DOF + 2) / 2 * np.log(off_keypoints).sum(axis=1) + (_FLOOR_DOF + 1) / 2 * np.log(off_floor)

    noise = np.empty((count, 2 * joints + 1))
    noise[:, :joints] = noise[:, joints:-1] = weights * rows.precision**2
    noise[:, -1] = (1 + 1 / _FLOOR_DOF) / off_floor * rows.floor_precision**2
    equations = projected.equations
    equations[:, :-1, -1], equations[:, -1, -1] = residual.reshape(count, -1), -projected.floor
    return equations, noise, cost, weights


def known_of_rows(rows: HypothesisBatch, local: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return what is known of each row's unknowns apart from its keypoints: precision (R, N_LOCAL, N_LOCAL), pull
    (R, N_LOCAL) and cost (R,), of the prior and of a stated depth."""
    off = rows.prior_mean - local
    pull = (rows.prior_precision @ off[..., None])[..., 0]
    cost = 0.5 * (off * pull).sum(axis=1)
    away = rows.log_depth - local[:, DEPTH]
    depth_precision = stated_depth_precision(rows, local)
    precision = rows.prior_precision.copy()
    precision[:, DEPTH, DEPTH] += depth_precision
    pull[:, DEPTH] += depth_precision * away
    return precision, pull, cost + (_DEPTH_DOF + 1) / 2 * np.log1p((away * rows.depth_precision) ** 2 / _DEPTH_DOF)


def stated_depth_precision(rows: HypothesisBatch, local: FloatArray) -> FloatArray:
    """Return what the stated depths add to the precision of the rows' log depths (R,): little where one is far off."""
    off = 1 + ((rows.log_depth - local[:, DEPTH]) * rows.depth_precision) ** 2 / _DEPTH_DOF
    return (1 + 1 / _DEPTH_DOF) / off * rows.depth_precision**2


def _step(fit: Fit, leading: NDArray[np.intp] | slice = slice(None)) -> tuple[FloatArray, FloatArray]:
    """Return the step of local (R, N_LOCAL) and shared unknowns (N_SHARED,); the leading rows decide the latter."""
    answer, reduced = schur_complement(fit.normal)
    # what the shared unknowns see once every row has answered
    equations = reduced[leading].sum(axis=0) + fit.shared_normal
    shared_step = solve_batch(equations[:, :-1], equations[:, -1])
    return answer[..., -1] - answer[..., :-1] @ shared_step, shared_step


def schur_complement(normal: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return how each row's unknowns answer, and what is left for the shared ones (the Schur complement).

    The answer, shape (R, N_LOCAL, N_SHARED + 1), is to the shared unknowns and, last, to the row's own gradient; what
    is left, shape (R, N_SHARED, N_SHARED + 1), is a hessian and a gradient.
    """
    answer = solve_batch(normal[:, :N_LOCAL, :N_LOCAL], normal[:, :N_LOCAL, N_LOCAL:])
    return answer, normal[:, N_LOCAL:, N_LOCAL:] - normal[:, N_LOCAL:, :N_LOCAL] @ answer


def solve_batch(matrix: FloatArray, right: FloatArray) -> FloatArray:
    """Return matrix^-1 right, for stacks of both."""
    return np.asarray(np.linalg.solve(matrix, right), dtype=float)
