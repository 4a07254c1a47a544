"""One camera from people of many photos: their fits together, one body a person however often they are seen.

Rows of one person share the lengths of one body. Each row answers for its place, heading and posture, each person for
the lengths, and what is left tells the camera: three levels of the same normal equations. So the interval counts
people, not detections.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ...arrays import FloatArray
from ...camera import Camera
from ...people import People
from .. import LocateSettings
from .body_model import BodyModel, body_model
from .fit import explained_people, shared_prior
from .projection import LOG_LENGTHS, N_LOCAL, N_SHARED
from .solver import HypothesisBatch, SharedPrior, clip_step, evaluate_rows, solve_batch

#: How far a detector's idea of a joint may be from the body model's, of all people alike, in statures: as far as two
#: networks' ideas of one are apart (`body_tables.DEFINITIONS`, and how ears, hips and shoulders were found to differ).
HABIT_SD = 0.015
_ITERATIONS, _SETTLED = 30, 1e-4
_N_LENGTHS = LOG_LENGTHS.stop - LOG_LENGTHS.start
# The unknowns of a row but for its lengths; then the lengths, the camera, and the gradient.
_OWN = np.setdiff1d(np.arange(N_LOCAL), np.arange(LOG_LENGTHS.start, LOG_LENGTHS.stop))
_ABOVE = np.concatenate([np.arange(LOG_LENGTHS.start, LOG_LENGTHS.stop), np.arange(N_LOCAL, N_LOCAL + N_SHARED + 1)])
_B, _C = slice(0, _N_LENGTHS), slice(_N_LENGTHS, _N_LENGTHS + N_SHARED)


@dataclass(frozen=True, eq=False)
class Pooled:
    """What the people of many photos say of their one camera.

    shared: shape (N_SHARED,), in units of `camera`, with covariance (N_SHARED, N_SHARED); of it habits (N_SHARED,
    N_SHARED) is what a detector's habits may do. n_people, n_detections: how many it rests on.
    """

    camera: Camera
    shared: FloatArray
    covariance: FloatArray
    habits: FloatArray
    n_people: int
    n_detections: int


@dataclass(frozen=True, eq=False)
class _Bodies:
    """The prior of each person's log lengths: mean and precision, shape (T, L) and (T, L, L)."""

    mean: FloatArray
    precision: FloatArray


def pooled(people: People, camera: Camera, persons: NDArray[np.intp], settings: LocateSettings) -> Pooled | None:
    """Return the camera that people of many photos tell, or None where nobody is usable.

    people: everybody of all photos, in undistorted pixels of `camera`. persons: shape (P,), who each of them is.
    """
    model = body_model(people.skeleton)
    prior = shared_prior(camera)
    explained = explained_people(people, camera, prior, settings, model)
    if explained is None:
        return None
    rows, local, usable = explained.rows.taken(explained.first), explained.fit.local, explained.usable
    names, owner = np.unique(persons[usable], return_inverse=True)
    count, own = len(names), slice(LOG_LENGTHS.start, LOG_LENGTHS.stop)
    bodies = _bodies(rows, owner, count)
    free = rows.prior_precision.copy()
    free[:, own, :] = free[:, :, own] = 0.0
    rows = replace(rows, prior_precision=free)
    lengths = _mean_of(local[:, own], owner, count)
    local, lengths, shared = _solve(rows, owner, bodies, local, lengths, explained.fit.shared, prior)
    top, _ = _reduced(rows, owner, bodies, local, lengths, shared)
    _, prior_equations = prior.cost(shared)
    inverse = np.asarray(np.linalg.inv(top[:, :-1] + prior_equations[:, :-1]), dtype=float)
    habits = _habits(rows, owner, bodies, local, lengths, shared, inverse, model)
    return Pooled(camera, shared, inverse + habits, habits, count, len(usable))


def _bodies(rows: HypothesisBatch, owner: NDArray[np.intp], count: int) -> _Bodies:
    """Return each person's prior: that of the kind of body, grown-up or child, that most of their rows look like."""
    own = slice(LOG_LENGTHS.start, LOG_LENGTHS.stop)
    statures = rows.prior_mean[:, LOG_LENGTHS.start]
    mean, precision = np.zeros((count, _N_LENGTHS)), np.zeros((count, _N_LENGTHS, _N_LENGTHS))
    for person in range(count):
        mine = np.flatnonzero(owner == person)
        like = mine[np.argsort(statures[mine])[len(mine) // 2]]
        mean[person], precision[person] = rows.prior_mean[like, own], rows.prior_precision[like, own, own]
    return _Bodies(mean, precision)


def _mean_of(values: FloatArray, owner: NDArray[np.intp], count: int) -> FloatArray:
    total = np.zeros((count, values.shape[1]))
    np.add.at(total, owner, values)
    return total / np.bincount(owner, minlength=count)[:, None]


def _solve(
    rows: HypothesisBatch, owner: NDArray[np.intp], bodies: _Bodies, local: FloatArray, lengths: FloatArray,
    shared: FloatArray, prior: SharedPrior,
) -> tuple[FloatArray, FloatArray, FloatArray]:  # fmt: skip
    """Return the best local unknowns, lengths and camera, everybody's rows with one body."""
    for _ in range(_ITERATIONS):
        local = local.copy()
        local[:, LOG_LENGTHS] = lengths[owner]
        top, back = _reduced(rows, owner, bodies, local, lengths, shared)
        _, prior_equations = prior.cost(shared)
        total = top + prior_equations
        step = solve_batch(total[:, :-1], total[:, -1])
        _, step = clip_step(np.zeros((1, N_LOCAL)), step)
        longer = back.person[..., -1] - back.person[..., :-1] @ step
        above = np.concatenate([longer[owner], np.broadcast_to(step, (len(owner), N_SHARED))], axis=1)
        move = back.row[..., -1] - (back.row[..., :-1] @ above[..., None])[..., 0]
        moved = np.zeros_like(local)
        moved[:, _OWN] = move
        moved, _ = clip_step(moved, step)
        local, shared = local + moved, shared + step
        lengths = lengths + np.clip(longer, -0.1, 0.1)
        if np.abs(step).max() < _SETTLED and np.abs(longer).max() < 10 * _SETTLED:
            break
    local[:, LOG_LENGTHS] = lengths[owner]
    return local, lengths, shared


@dataclass(frozen=True, eq=False)
class _Back:
    """How what was eliminated answers: each row's own unknowns to (lengths, camera, gradient), each person's lengths to
    (camera, gradient)."""

    row: FloatArray
    person: FloatArray


def _reduced(
    rows: HypothesisBatch, owner: NDArray[np.intp], bodies: _Bodies, local: FloatArray, lengths: FloatArray,
    shared: FloatArray, normal: FloatArray | None = None,
) -> tuple[FloatArray, _Back]:  # fmt: skip
    """Return what all rows say of the camera, hessian and gradient (N_SHARED, N_SHARED + 1), and the way back.

    With `normal` equations (R, ..) given, they are those of the rows, and the bodies' own pull is left out.
    """
    pull = np.zeros_like(lengths)
    if normal is None:
        normal, _, _ = evaluate_rows(rows, local, shared)
        pull = (bodies.precision @ (bodies.mean - lengths)[..., None])[..., 0]
    by_row = solve_batch(normal[:, _OWN[:, None], _OWN], normal[:, _OWN[:, None], _ABOVE])
    left = normal[:, _ABOVE[:-1, None], _ABOVE] - normal[:, _ABOVE[:-1, None], _OWN] @ by_row
    person = np.zeros((len(lengths), *left.shape[1:]))
    np.add.at(person, owner, left)
    person[:, _B, _B] += bodies.precision
    person[:, _B, -1] += pull
    by_person = solve_batch(person[:, _B, _B], person[:, _B, _N_LENGTHS:])
    top = (person[:, _C, _N_LENGTHS:] - person[:, _C, _B] @ by_person).sum(axis=0)
    return top, _Back(by_row, by_person)


def _habits(
    rows: HypothesisBatch, owner: NDArray[np.intp], bodies: _Bodies, local: FloatArray, lengths: FloatArray,
    shared: FloatArray, inverse: FloatArray, model: BodyModel,
) -> FloatArray:  # fmt: skip
    """Return the covariance (N_SHARED, N_SHARED) of a detector's habits: each kind of joint seen too high or low."""
    normal, _, _ = evaluate_rows(rows, local, shared)
    result = np.zeros((N_SHARED, N_SHARED))
    for kind in model.kinds.values():
        table = rows.bodies.table.copy()
        table[:, 2, kind, -1] += HABIT_SD
        there, _, _ = evaluate_rows(replace(rows, bodies=replace(rows.bodies, table=table)), local, shared)
        other = normal.copy()
        other[..., -1] = there[..., -1] - normal[..., -1]
        top, _ = _reduced(rows, owner, bodies, local, lengths, shared, other)
        shift = inverse @ top[:, -1]
        result += np.outer(shift, shift)
    return result
