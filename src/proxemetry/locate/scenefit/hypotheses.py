"""Several explanations of a person: standing or seated, facing this way or that, adult or child.

The start ranks them; `alternatives` explains each; Laplace's approximation weighs them. What moves a
person by less than its own uncertainty is folded into the covariance, what moves it further stays a mode of its own.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cache

import numpy as np
from numpy.typing import NDArray

from ...anthropometry import Population, moments, populations
from ...arrays import FloatArray
from .alternatives import Explanations
from .batch import HypothesisBatch
from .body_model import BodyModel
from .body_tables import POSTURE_WEIGHTS
from .evidence import Evidence, SeenLengths
from .projection import (
    DEPTH,
    HEADING,
    LOG_LENGTHS,
    N_LOCAL,
    PITCH,
    POINT,
    POSTURE,
    ROLL,
    TURN,
    BodyTables,
    camera_axes,
)  # fmt: skip
from .start import HEADINGS, Start

#: An alternative this much worse than the best at the start (negative log posterior) is not pursued.
_WORTH_PURSUING = 6.0
#: So many postures after the best are.
_MOST_POSTURES = 2
#: How far heads turn against trunks, radians: an assumption, 26 degrees.
_TURN_SD = 0.45
#: Mean and standard deviation of log depth in metres: an assumption, people are photographed from 0.8 to 45 m away.
#: It decides only where next to nothing is seen.
_DEPTH_PRIOR = (np.log(6.0), 1.2)


@dataclass(frozen=True, eq=False)
class Hypotheses:
    """R rows to try: whose, the posture, which group of bodies, the log prior weight; and a start each.

    group: shape (R,), an index into the `body_types` of that person's body size; mean: shape (R, L), that group's log
    lengths. local: shape (R, N_LOCAL). Each person's first row is of the first group, and so are all but one a group.
    """

    person: NDArray[np.intp]
    posture: NDArray[np.intp]
    group: NDArray[np.intp]
    mean: FloatArray
    log_prior: FloatArray
    local: FloatArray

    def with_local(self, rows: NDArray[np.intp], local: FloatArray) -> Hypotheses:
        """Return the same with other starts for some rows."""
        starts = self.local.copy()
        starts[rows] = local
        return replace(self, local=starts)


@dataclass(frozen=True, eq=False)
class Bodytype:
    """One Gaussian of log lengths with its prior weight: the adults of a body size, or its children.

    mean: shape (L,). precision: shape (L, L). log_volume: the log determinant of the precision.
    """

    weight: float
    mean: FloatArray
    precision: FloatArray
    log_volume: float


@cache
def body_types(body_size: str, child_weight: float, seen: SeenLengths = ()) -> tuple[Bodytype, ...]:
    """Return the adults and the children of a body size as one Gaussian each, the more likely first.

    seen: what the back end makes of their lengths; as they are without it.
    """
    groups = populations(body_size, child_weight)
    children = tuple(g for g in groups if g.name.startswith("children") and g.weight > 0)
    adults = tuple(g for g in groups if not g.name.startswith("children"))
    types = [_body_type(part, seen) for part in (adults, children) if part]
    return tuple(sorted(types, key=lambda t: -t.weight))


def _body_type(groups: tuple[Population, ...], seen: SeenLengths) -> Bodytype:
    mean, covariance = moments(groups)
    if seen:
        scale, common = np.array(seen).T
        mean, covariance = mean + np.log(scale), covariance + np.diag(common**2)
    precision = np.asarray(np.linalg.inv(covariance), dtype=float)
    return Bodytype(sum(g.weight for g in groups), mean, precision, float(np.linalg.slogdet(precision)[1]))


#: However far a stated stature is from a group of bodies: it stays a possibility.
_LEAST_WEIGHT = 1e-9


def with_stature(types: tuple[Bodytype, ...], stature: tuple[float, float] | None) -> tuple[Bodytype, ...]:
    """Return the types of a person whose stature is known, metres and their standard deviation; as they are for None.

    The other lengths follow by their correlations, and a person 1.2 m tall is more likely a child.
    """
    if stature is None:
        return types
    log_stature, variance = np.log(stature[0]), (stature[1] / stature[0]) ** 2
    known: list[Bodytype] = []
    for kind in types:
        covariance = np.asarray(np.linalg.inv(kind.precision), dtype=float)
        total, off = float(covariance[0, 0]) + variance, log_stature - kind.mean[0]
        precision = kind.precision.copy()
        precision[0, 0] += 1 / variance
        weight = kind.weight * float(np.exp(-0.5 * off**2 / total) / np.sqrt(total))
        mean = kind.mean + covariance[:, 0] / total * off
        known.append(Bodytype(weight, mean, precision, float(np.linalg.slogdet(precision)[1])))
    total = sum(k.weight for k in known) or 1.0
    return tuple(sorted(
        (replace(k, weight=max(k.weight / total, _LEAST_WEIGHT)) for k in known), key=lambda k: -k.weight
    ))  # fmt: skip


def hypotheses_of(
    start: Start, types: list[tuple[Bodytype, ...]], model: BodyModel
) -> tuple[Hypotheses, NDArray[np.intp]]:
    """Return every row worth trying, best first for each person, and the row of each person's best."""
    chosen, first = _ranked(start.cost, [len(groups) for groups in types])
    table = np.array(chosen, dtype=np.intp).reshape(-1, 4)
    person, posture, heading, group = table.T
    mean = np.array([types[p][g].mean for p, _, _, g in chosen]).reshape(len(table), -1)
    weight = np.array([types[p][g].weight for p, _, _, g in chosen])
    local = np.zeros((len(table), N_LOCAL))
    local[:, POINT] = start.point[person, posture, heading]
    grown = mean[np.array(first)[person], 0]  # each person's first row is of the first group
    local[:, DEPTH] = start.log_depth[person, posture, heading] + mean[:, 0] - grown
    local[:, HEADING] = HEADINGS[heading]
    local[:, LOG_LENGTHS] = mean
    local[:, POSTURE] = model.prior_mean[posture]
    log_prior = np.log(weight * np.array(POSTURE_WEIGHTS)[posture])
    return Hypotheses(person, posture, group, mean, log_prior, local), np.array(first, dtype=np.intp)


def scaled_to_group(hypotheses: Hypotheses, first: NDArray[np.intp]) -> Hypotheses:
    """Return every row of another group of bodies starting from its person's first row, made as large as its group."""
    rows = np.flatnonzero(hypotheses.group > 0)
    alike = first[hypotheses.person[rows]]
    larger = hypotheses.mean[rows] - hypotheses.mean[alike]
    local = hypotheses.local[alike]
    local[:, LOG_LENGTHS] += larger
    local[:, DEPTH] += larger[:, 0]
    return hypotheses.with_local(rows, local)


def _ranked(cost: FloatArray, groups: list[int]) -> tuple[list[tuple[int, int, int, int]], list[int]]:
    """Return person, posture, heading and group of bodies of what is worth trying, and the place of each person's best.

    cost: shape (P, postures, headings). Each person's best comes first.
    """
    heading, by_posture = cost.argmin(axis=2), cost.min(axis=2)
    order = by_posture.argsort(axis=1)
    best, others = order[:, 0], order[:, 1 : 1 + _MOST_POSTURES]
    everyone = np.arange(len(cost))
    limit = by_posture[everyone, best] + _WORTH_PURSUING
    worth = by_posture[everyone[:, None], others] < limit[:, None]
    facing = heading[everyone, best]
    turned, by_turned = _other_headings(cost[everyone, best], facing)
    chosen: list[tuple[int, int, int, int]] = []
    first: list[int] = []
    for person in range(len(cost)):
        first.append(len(chosen))
        chosen.append((person, best[person], facing[person], 0))
        chosen += [(person, p, heading[person, p], 0) for p in others[person, worth[person]]]
        chosen += [(person, best[person], turned[person], 0)] * bool(by_turned[person] < limit[person])
        chosen += [(person, best[person], facing[person], g) for g in range(1, groups[person])]
    return chosen, first


def _other_headings(cost: FloatArray, best: NDArray[np.intp]) -> tuple[NDArray[np.intp], FloatArray]:
    """Return the best local minimum around the circle of headings (P, H) but for the overall one, and its cost."""
    around = cost[:, np.arange(-1, cost.shape[1] + 1) % cost.shape[1]]
    apart = np.abs(np.arange(cost.shape[1]) - best[:, None])
    minima = (cost <= around[:, :-2]) & (cost <= around[:, 2:]) & (np.minimum(apart, cost.shape[1] - apart) > 1)
    left = np.where(minima, cost, np.inf)
    return left.argmin(axis=1), left.min(axis=1)


def batch_of(
    hypotheses: Hypotheses, evidence: Evidence, types: list[tuple[Bodytype, ...]], floor_sd: FloatArray,
    model: BodyModel, scale: FloatArray,
) -> HypothesisBatch:  # fmt: skip
    """Return the solver's rows; scale (P,) is each person's stature over depth, for the noise."""
    person = hypotheses.person
    mean, precision, log_volume = _priors(hypotheses, evidence, types, model)
    stated = np.isfinite(evidence.log_depth)
    return HypothesisBatch(
        person=person,
        points=evidence.points[person].transpose(0, 2, 1),
        precision=keypoint_precision(evidence, model, scale)[person],
        bodies=BodyTables.of(model, hypotheses.posture),
        prior_mean=mean,
        prior_precision=precision,
        prior_log_volume=log_volume,
        floor_precision=1 / floor_sd[person],
        log_depth=np.where(stated, evidence.log_depth, 0.0)[person],
        depth_precision=np.where(stated, 1 / evidence.depth_rel_sd, 0.0)[person],
    )


def _priors(
    hypotheses: Hypotheses, evidence: Evidence, types: list[tuple[Bodytype, ...]], model: BodyModel
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return what is known of each row's unknowns: mean, precision and the precision's log determinant."""
    types_of = [types[p][g] for p, g in zip(hypotheses.person, hypotheses.group, strict=True)]
    known = np.isfinite(evidence.heading_rad) & (evidence.heading_sd_rad > 0)
    heading = np.where(known, evidence.heading_rad, 0.0)
    heading_sd = np.where(known, np.maximum(evidence.heading_sd_rad, 0.05), np.inf)
    mean = np.zeros((len(types_of), N_LOCAL))
    diagonal = np.full((len(types_of), N_LOCAL), 1e-4)  # of place nothing is known, but the equations stay solvable
    mean[:, DEPTH], diagonal[:, DEPTH] = _DEPTH_PRIOR[0], _DEPTH_PRIOR[1] ** -2
    # headings are alike by whole turns: the one nearest to where the search begins
    off = heading[hypotheses.person] - hypotheses.local[:, HEADING]
    mean[:, HEADING] = hypotheses.local[:, HEADING] + off - 2 * np.pi * np.rint(off / (2 * np.pi))
    diagonal[:, HEADING] = heading_sd[hypotheses.person] ** -2 + 1e-4
    diagonal[:, TURN] = _TURN_SD**-2
    mean[:, POSTURE], diagonal[:, POSTURE] = (
        model.prior_mean[hypotheses.posture],
        model.prior_sd[hypotheses.posture] ** -2,
    )
    precision = diagonal[:, :, None] * np.eye(N_LOCAL)
    mean[:, LOG_LENGTHS] = hypotheses.mean
    precision[:, LOG_LENGTHS, LOG_LENGTHS] = [body.precision for body in types_of]
    volume = np.array([body.log_volume for body in types_of]) + np.log(diagonal[:, POSTURE]).sum(axis=1)
    return mean, precision, volume


def keypoint_precision(
    evidence: Evidence, model: BodyModel, scale: FloatArray, shared: FloatArray | None = None
) -> FloatArray:
    """Return one over the noise of every keypoint (P, K), 0 where unseen: a share of the body's size, never below what
    a detector resolves, and the more the further from above the camera looks at the person.

    shared: the camera as it is known, shape (N_SHARED,); level without it.
    """
    above = np.zeros(len(scale)) if shared is None else np.maximum(_sine_from_above(evidence, shared), 0.0)
    noise = evidence.score_noise * (1 + above[:, None] * evidence.from_above)
    sd = np.hypot(np.hypot(model.spread, noise) * scale[:, None], evidence.resolution)
    return evidence.seen / sd


def _sine_from_above(evidence: Evidence, shared: FloatArray) -> FloatArray:
    """Return the sine of the angle at which each person is looked down at, shape (P,)."""
    seen = evidence.seen[..., None]
    middle = np.where(seen, evidence.points, 0.0).sum(axis=1) / np.maximum(seen.sum(axis=1), 1)
    sight = np.column_stack([middle, np.ones(len(middle))])
    down = camera_axes(shared[None, PITCH : ROLL + 1])[0, :, 1]
    return (sight @ down) / np.linalg.norm(sight, axis=1)


def log_evidence(explanations: Explanations, rows: HypothesisBatch, log_prior: FloatArray) -> FloatArray:
    """Return the log of each row's posterior weight (R,), up to a constant of its person (Laplace)."""
    _, volume = np.linalg.slogdet(explanations.precision)
    return log_prior - explanations.cost + 0.5 * (rows.prior_log_volume - volume)
