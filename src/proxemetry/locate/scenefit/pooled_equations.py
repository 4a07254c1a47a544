"""The normal equations of the people of many photos before one lens, solved level by level.

Unknowns, each level eliminated before the next: a row's own (place, heading, posture), a person's log lengths, a view's
pitch, roll and log height, and what all share: the lens (log focal length and the principal point's error) and, where
it is sought, the tilt at which all bodies are seen. Right-hand sides are the gradient and, after it, those of any
departures from the model that are asked about.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...arrays import FloatArray
from .batch import HypothesisBatch
from .camera_prior import SharedPrior
from .projection import FOCAL, LOG_LENGTHS, N_LOCAL, N_SHARED, angle_from_above
from .solver import known_of_rows, solve_batch, weighted_equations
from .tilt import TILT_SD_RAD, by_tilt, expected_tilt

#: Unknowns of a view and of the lens: pitch, roll and log height come first among the shared ones.
N_VIEW = FOCAL
N_LENS = N_SHARED - N_VIEW
N_LENGTHS = LOG_LENGTHS.stop - LOG_LENGTHS.start
#: A row's unknowns but for its lengths, which are the person's.
OWN: NDArray[np.intp] = np.setdiff1d(np.arange(N_LOCAL), np.arange(LOG_LENGTHS.start, LOG_LENGTHS.stop))


@dataclass(frozen=True, eq=False)
class Crowd:
    """R rows of T people in V views.

    person: shape (R,), whose each row is. view: shape (T,), where each person is. mean (T, L), precision (T, L, L):
    what is known of their log lengths beforehand. too_level_rad: by how much less from above bodies are expected to be
    seen.
    """

    rows: HypothesisBatch
    person: NDArray[np.intp]
    view: NDArray[np.intp]
    mean: FloatArray
    precision: FloatArray
    too_level_rad: float = 0.0


@dataclass(frozen=True, eq=False)
class State:
    """Where the search is: local (R, N_LOCAL), lengths (T, L), places (V, N_VIEW), lens (N_LENS,).

    tilt: how much more in pitch and in roll all bodies are tilted than expected, in units of `TILT_SD_RAD`; shape (2,),
    or (0,) where it is not sought.
    """

    local: FloatArray
    lengths: FloatArray
    places: FloatArray
    lens: FloatArray
    tilt: FloatArray

    def cameras(self, view: NDArray[np.intp]) -> FloatArray:
        """Return the cameras (.., N_SHARED) of views (..)."""
        return np.concatenate([self.places[view], np.broadcast_to(self.lens, (*view.shape, N_LENS))], axis=-1)

    def tilted(self, crowd: Crowd) -> HypothesisBatch:
        """Return the crowd's rows with their bodies at the tilt of this state."""
        expected = expected_tilt(crowd.too_level_rad, angle_from_above(self.local, self.cameras_of(crowd)))
        return crowd.rows.with_tilt(expected + self.tilt * TILT_SD_RAD if len(self.tilt) else expected)

    def cameras_of(self, crowd: Crowd) -> FloatArray:
        """Return the camera of each row, shape (R, N_SHARED)."""
        return self.cameras(crowd.view[crowd.person])


@dataclass(frozen=True, eq=False)
class Level:
    """One level eliminated: how its unknowns answer to those above and to each right-hand side, and what is left.

    answer: shape (N, unknowns, above + sides). left: shape (N, above, above + sides).
    """

    answer: FloatArray
    left: FloatArray

    @classmethod
    def of(cls, normal: FloatArray, own: NDArray[np.intp]) -> Level:
        """Eliminate the unknowns `own` from normal equations (N, n, n + sides)."""
        above = np.setdiff1d(np.arange(normal.shape[1]), own)
        right = np.append(above, np.arange(normal.shape[1], normal.shape[2]))
        answer = solve_batch(normal[:, own[:, None], own], normal[:, own[:, None], right])
        return cls(answer, normal[:, above[:, None], right] - normal[:, above[:, None], own] @ answer)

    @property
    def response(self) -> FloatArray:
        """How its unknowns go with those above, but for the sign: shape (N, unknowns, above)."""
        return self.answer[..., : self.left.shape[1]]

    def step(self, above: FloatArray) -> FloatArray:
        """Return its unknowns' step (N, unknowns) downhill, where those above take steps (N, above)."""
        return self.answer[..., self.left.shape[1]] - (self.response @ above[..., None])[..., 0]


@dataclass(frozen=True, eq=False)
class Equations:
    """All levels of a Gauss-Newton step.

    by_view: shape (V, N_SHARED + tilts, N_SHARED + tilts + sides), the normal equations of each view's people, without
    any prior of camera and tilt. lens: shape (N_LENS + tilts, N_LENS + tilts + sides), what is left for lens and tilt,
    priors included. cost: negative log posterior.
    """

    rows: Level
    people: Level
    by_view: FloatArray
    views: Level
    lens: FloatArray
    cost: float


def equations_of(crowd: Crowd, state: State, prior: SharedPrior, departures: FloatArray | None = None) -> Equations:
    """Return the equations at a state. departures: shape (D, R, 2 K + 1), what else the residuals of each row might be,
    in the order of `project`: D more right-hand sides."""
    normal, cost = _of_rows(crowd, state, departures)
    rows = Level.of(normal, OWN)
    of_people = _summed(rows.left, crowd.person, len(state.lengths))
    apart = crowd.mean - state.lengths
    pull = (crowd.precision @ apart[..., None])[..., 0]
    _add(of_people, crowd.precision, pull)
    people = Level.of(of_people, np.arange(N_LENGTHS))
    by_view = _summed(people.left, crowd.view, len(state.places))
    cameras = state.cameras(np.arange(len(state.places)))
    prior_cost, prior_normal = prior.cost(cameras)
    with_prior = by_view.copy()
    _add(with_prior, prior_normal[:, :N_VIEW, :N_VIEW], prior_normal[:, :N_VIEW, -1])
    views = Level.of(with_prior, np.arange(N_VIEW))
    lens = views.left.sum(axis=0)
    _add(lens[None], prior_normal[:1, N_VIEW:, N_VIEW:-1], prior_normal[:1, N_VIEW:, -1])
    lens[N_LENS:, N_LENS : len(lens) + 1] += np.column_stack([np.eye(len(state.tilt)), -state.tilt])
    off = ((prior.mean - cameras[0]) / prior.sd)[N_VIEW:]
    repeated = (len(cameras) - 1) * 0.5 * float(off @ off)  # of one lens: what is known of it counts once
    cost += 0.5 * float((apart * pull).sum() + (state.tilt**2).sum()) + float(prior_cost.sum()) - repeated
    return Equations(rows, people, by_view, views, lens, cost)


def _of_rows(crowd: Crowd, state: State, departures: FloatArray | None) -> tuple[FloatArray, float]:
    """Return the rows' normal equations (R, n, n + sides), and what rows cost."""
    rows = state.tilted(crowd)
    cameras, tilts = state.cameras_of(crowd), len(state.tilt)
    equations, precision, cost, _ = weighted_equations(rows, state.local, cameras)
    if tilts:
        tilted = by_tilt(equations, angle_from_above(state.local, cameras)) * TILT_SD_RAD
        equations = np.concatenate([equations[..., :-1], tilted, equations[..., -1:]], axis=-1)
    if departures is not None:
        equations = np.concatenate([equations, departures.transpose(1, 2, 0)], axis=-1)
    unknowns = N_LOCAL + N_SHARED + tilts
    normal = (equations[..., :unknowns] * precision[..., None]).transpose(0, 2, 1) @ equations
    known, pull, apart = known_of_rows(rows, state.local)
    _add(normal, known, pull)
    return normal, float(cost.sum() + apart.sum())


def _add(normal: FloatArray, precision: FloatArray, pull: FloatArray) -> None:
    """Add what is known of the first unknowns of each to normal equations (N, n, n + sides) just made, in place."""
    count = precision.shape[1]
    normal[:, :count, :count] += precision
    normal[:, :count, normal.shape[1]] += pull


def _summed(parts: FloatArray, of: NDArray[np.intp], count: int) -> FloatArray:
    result = np.zeros((count, *parts.shape[1:]))
    np.add.at(result, of, parts)
    return result
