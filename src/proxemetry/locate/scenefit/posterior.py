"""From the solver's explanations to positions, covariances, headings, statures and modes."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from itertools import product

import numpy as np
from numpy.typing import NDArray

from ...arrays import FloatArray
from ...bodies import MOST_DEPTH_MISFIT, Bodies, Floor, Intrinsics, Mode
from .alternatives import Explanations
from .batch import HypothesisBatch
from .body_model import BodyModel
from .contradiction import depth_misfit
from .explained import Explained
from .mirror import Mirrored
from .projection import (
    DEPTH,
    FOCAL,
    HEADING,
    HEIGHT,
    LOG_LENGTHS,
    N_LOCAL,
    N_SHARED,
    PITCH,
    PRINCIPAL,
    ROLL,
    camera_axes,
    torso_jacobian,
    torso_position,
)  # fmt: skip
from .solver import Fit, solve_batch

#: An explanation less likely than this is not reported: by judgement, as are the next (docs/method.md, "Other
#: explanations").
_LEAST_WEIGHT = 0.03
#: Explanations further apart than this many standard deviations of depth stay apart.
_APART = 1.5
#: People with explanations that stay apart, at most: the modes are all combinations of these.
_MOST_AMBIGUOUS = 3
#: A floor is stated where the camera's height is surer than this: a little wider than its prior (`fit.HEIGHT_LOG_SD`).
_FOUND_FLOOR_REL_SD = 0.35
#: A joint counts among those that the answer rests on where its robust weight is above this; 1 is fully believed.
_BELIEVED = 0.3
#: Trunks twist, and the body model's do not: so far are shoulders turned against hips in 2,502 upright frames of motion
#: capture (mocap.cs.cmu.edu, subjects 1 to 3).
_TWIST_SD = np.deg2rad(9.0)
_STATURE = LOG_LENGTHS.start
#: Beyond this relative standard deviation of depth nothing is stated: the 90 % interval would span a factor of five.
_MOST_REL_SD = 0.5


@dataclass(frozen=True, eq=False)
class Placed:
    """All usable people, placed: the fields of `Bodies` for them alone."""

    positions_m: FloatArray
    covariance_m2: FloatArray
    basis: tuple[str, ...]
    up: FloatArray
    heading_rad: FloatArray
    heading_sd_rad: FloatArray
    stature_m: FloatArray
    stature_sd_m: FloatArray
    floor: Floor | None
    modes: tuple[Mode, ...]
    depth_misfit: FloatArray
    mount_misfit: float = float("nan")
    intrinsics: Intrinsics = field(default_factory=Intrinsics)

    def bodies(self, count: int, rows: NDArray[np.intp], reason: str) -> Bodies:
        """Return them among all `count` people, at `rows`; the others are unplaced for that reason.

        So is, for a reason of its own, whose depth is open by more than `_MOST_REL_SD`.
        """
        basis: list[str] = [""] * count
        reasons: list[str | None] = [reason] * count
        depth_rel_sd = np.sqrt(np.diag(self.covariance_m2)[2::3]) / self.positions_m[:, 2]
        known = depth_rel_sd < _MOST_REL_SD
        for row, used, rel_sd in zip(rows, self.basis, depth_rel_sd, strict=True):
            if rel_sd < _MOST_REL_SD:
                basis[row], reasons[row] = used, None
            else:
                reasons[row] = (
                    f"only {used} seen, too little to determine the distance: uncertain by {100 * rel_sd:.0f} %"
                )
        return self._kept(known)._among(count, rows[known], tuple(basis), tuple(reasons))

    def _kept(self, known: NDArray[np.bool_]) -> Placed:
        """Return some of the people."""
        if known.all():
            return self
        index = np.flatnonzero(np.repeat(known, 3))
        modes = tuple(Mode(m.weight, m.positions_m[known], m.covariance_m2[np.ix_(index, index)]) for m in self.modes)
        return replace(
            self, positions_m=self.positions_m[known], covariance_m2=self.covariance_m2[np.ix_(index, index)],
            heading_rad=self.heading_rad[known], heading_sd_rad=self.heading_sd_rad[known],
            stature_m=self.stature_m[known], stature_sd_m=self.stature_sd_m[known], modes=modes,
            depth_misfit=self.depth_misfit[known],
        )  # fmt: skip

    def _among(
        self, count: int, rows: NDArray[np.intp], basis: tuple[str, ...], reasons: tuple[str | None, ...]
    ) -> Bodies:
        modes = tuple(
            Mode(m.weight, _spread(m.positions_m, count, rows), _spread_square(m.covariance_m2, count, rows))
            for m in self.modes
        )
        return Bodies(
            _spread(self.positions_m, count, rows), _spread_square(self.covariance_m2, count, rows), "scene",
            basis, reasons, self.up, _spread(self.heading_rad, count, rows),
            _spread(self.heading_sd_rad, count, rows), _spread(self.stature_m, count, rows),
            _spread(self.stature_sd_m, count, rows), self.floor, modes, self.mount_misfit,
            _spread(self.depth_misfit, count, rows), self.intrinsics,
        )  # fmt: skip


def placed_people(explained: Explained, model: BodyModel) -> Placed:
    """Return all people's places from the joint fit of their best rows and the alternatives' weights."""
    rows, explanations, first, fit = explained.rows, explained.explanations, explained.first, explained.fit
    weights = _normalised(rows.person, explained.weight, len(first))
    alike = min(explained.evidence.alike, float(len(first)))  # many never weigh less than one of them
    local_sd, covariance, shared_covariance = _covariance(fit, alike)
    choices = _ambiguous(rows, explanations, weights, first)
    shift = _merged_spread(rows, explanations, weights, first, choices)
    blocks = np.arange(3 * len(first)).reshape(-1, 3)
    covariance[blocks[:, :, None], blocks[:, None, :]] += shift
    heading, heading_sd = _headings(rows, explanations, weights, local_sd, fit, explained.mirrored)
    stature = np.exp(fit.local[:, _STATURE])
    elsewhere = shift[:, 2, 2] * np.exp(-2 * fit.local[:, DEPTH])
    misfit = depth_misfit(rows.taken(first), fit, elsewhere)
    return Placed(
        positions_m=torso_position(fit.local, fit.shared),
        covariance_m2=covariance,
        basis=_basis(explained, model, misfit),
        up=-camera_axes(fit.shared[None, PITCH : ROLL + 1])[0, :, 1],
        heading_rad=heading,
        heading_sd_rad=heading_sd,
        stature_m=stature,
        stature_sd_m=stature * local_sd[:, _STATURE],
        floor=_floor(fit, shared_covariance) if explained.on_floor.any() else None,
        modes=_modes(choices, explanations, weights, first, fit, alike),
        depth_misfit=misfit,
        mount_misfit=explained.mount_misfit,
        intrinsics=_intrinsics(fit.shared),
    )


def _intrinsics(shared: FloatArray) -> Intrinsics:
    right, down = shared[PRINCIPAL].tolist()
    return Intrinsics(float(np.exp(shared[FOCAL])), (right, down))


def _normalised(person: NDArray[np.intp], log_weight: FloatArray, count: int) -> FloatArray:
    highest = np.full(count, -np.inf)
    np.maximum.at(highest, person, log_weight)
    weight = np.exp(log_weight - highest[person])
    return weight / np.bincount(person, weight, minlength=count)[person]


def _covariance(fit: Fit, alike: float = 1.0) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return the standard deviations of the local unknowns (P, N_LOCAL), and the joint covariances of the positions
    (3 P, 3 P) and of the shared unknowns (N_SHARED, N_SHARED).

    alike: people's errors are shared, so their joint evidence on pitch, roll and height is divided by this.
    """
    own = fit.hessian[:, :N_LOCAL, :N_LOCAL]
    inverse = np.linalg.inv(own)
    cross = fit.hessian[:, :N_LOCAL, N_LOCAL:]
    by_shared = inverse @ cross
    left = (fit.hessian[:, N_LOCAL:, N_LOCAL:] - cross.transpose(0, 2, 1) @ by_shared).sum(axis=0)
    worth = np.ones(N_SHARED)
    worth[:FOCAL] = alike**-0.5
    shared = np.asarray(np.linalg.inv(left * np.outer(worth, worth) + fit.shared_normal[:, :-1]), dtype=float)
    variance = np.einsum("rii->ri", inverse) + (by_shared @ shared * by_shared).sum(axis=2)
    jacobian = torso_jacobian(torso_position(fit.local, fit.shared), fit.shared)
    by_local = jacobian[..., :3]
    sensitivity = jacobian[..., N_LOCAL:] - by_local @ by_shared[:, :3]
    flat = sensitivity.reshape(-1, N_SHARED)
    covariance = flat @ shared @ flat.T
    blocks = np.arange(len(flat)).reshape(-1, 3)
    covariance[blocks[:, :, None], blocks[:, None, :]] += by_local @ inverse[:, :3, :3] @ by_local.transpose(0, 2, 1)
    return np.sqrt(variance), (covariance + covariance.T) / 2, shared


def _ambiguous(
    rows: HypothesisBatch, explanations: Explanations, weights: FloatArray, first: NDArray[np.intp]
) -> dict[int, list[int]]:  # fmt: skip
    """Return the people whose explanations stay apart: person -> its rows, the best first. The likeliest few only.

    Those stay apart that put their person elsewhere than its best row does, beyond their own uncertainty.
    """
    likely = np.flatnonzero(weights > _LEAST_WEIGHT)
    likely = likely[likely != first[rows.person[likely]]]
    best = first[rows.person[likely]]
    apart = np.abs(explanations.local[likely, DEPTH] - explanations.local[best, DEPTH])
    unit = np.zeros((N_LOCAL + N_SHARED, 1))
    unit[DEPTH] = 1.0
    variance = solve_batch(explanations.precision[np.concatenate([likely, best])], unit)[:, DEPTH, 0]
    far = likely[apart > _APART * np.sqrt(variance.reshape(2, -1).max(axis=0))]
    choices: dict[int, list[int]] = {}
    for row in far[np.argsort(-weights[far], kind="stable")]:
        person = int(rows.person[row])
        if person in choices or len(choices) < _MOST_AMBIGUOUS:
            choices.setdefault(person, [int(first[person])]).append(int(row))
    return choices


def _merged_spread(
    rows: HypothesisBatch, explanations: Explanations, weights: FloatArray, first: NDArray[np.intp],
    choices: dict[int, list[int]],
) -> FloatArray:  # fmt: skip
    """Return what the explanations that are no modes of their own add to each person's covariance (P, 3, 3)."""
    position = torso_position(explanations.local, explanations.shared)
    apart_rows = [row for chosen in choices.values() for row in chosen[1:]]
    kept = weights.copy()
    kept[apart_rows] = 0.0
    apart = position - position[first[rows.person]]
    result = np.zeros((len(first), 3, 3))
    np.add.at(result, rows.person, kept[:, None, None] * apart[:, :, None] * apart[:, None, :])
    return result


def _modes(
    choices: dict[int, list[int]], explanations: Explanations, weights: FloatArray, first: NDArray[np.intp], fit: Fit,
    alike: float = 1.0,
) -> tuple[Mode, ...]:  # fmt: skip
    """Return the joint explanations where people have alternatives apart from their best; empty where none has."""
    if not choices:
        return ()
    by_shared = _by_shared(fit.hessian)
    modes: list[Mode] = []
    for combination in product(*choices.values()):
        chosen = first.copy()
        chosen[list(choices)] = combination
        weight = float(np.prod([weights[row] for row in combination]))
        moved = np.flatnonzero(chosen != first)
        # the camera follows each alternative, and all others the camera
        shift = (explanations.shared[chosen[moved]] - fit.shared).sum(axis=0)
        local = fit.local - by_shared @ shift
        normal = fit.normal.copy()
        for person in moved:
            row = chosen[person]
            rest = shift - (explanations.shared[row] - fit.shared)
            local[person] = explanations.local[row] - _by_shared(explanations.hessian[row]) @ rest
            normal[person, :, :-1] = explanations.hessian[row]
        mode = replace(fit, local=local, shared=fit.shared + shift, normal=normal)
        modes.append(Mode(weight, torso_position(local, mode.shared), _covariance(mode, alike)[1]))
    total = sum(m.weight for m in modes)
    modes = [Mode(m.weight / total, m.positions_m, m.covariance_m2) for m in modes]
    return tuple(sorted(modes, key=lambda m: -m.weight))


def _by_shared(hessian: FloatArray) -> FloatArray:
    """Return how the local unknowns follow the shared ones, own^-1 cross, shape (..., N_LOCAL, N_SHARED)."""
    return solve_batch(hessian[..., :N_LOCAL, :N_LOCAL], hessian[..., :N_LOCAL, N_LOCAL:])


def _headings(
    rows: HypothesisBatch, explanations: Explanations, weights: FloatArray, local_sd: FloatArray, fit: Fit,
    mirrored: Mirrored,
) -> tuple[FloatArray, FloatArray]:  # fmt: skip
    """Return the heading of the best explanation, and the spread of all about it, radians (P,).

    Every explanation may be mirrored about the line of sight as the best one may.
    """
    share, found = mirrored.share, fit.local[:, HEADING]
    turned = mirrored.local[:, HEADING] - found
    heading = np.where(share > 0.5, found + turned, found)
    off = explanations.local[:, HEADING] - heading[rows.person]
    squared, other_squared = _wrapped(off) ** 2, _wrapped(off + turned[rows.person]) ** 2
    spread = weights * (squared + share[rows.person] * (other_squared - squared))
    variance = local_sd[:, HEADING] ** 2 + _TWIST_SD**2 + np.bincount(rows.person, spread, minlength=len(share))
    return _wrapped(heading), np.minimum(np.sqrt(variance), np.pi / np.sqrt(3))  # no wider than knowing nothing


def _wrapped(angle: FloatArray) -> FloatArray:
    return np.angle(np.exp(1j * angle))


def _floor(fit: Fit, covariance: FloatArray) -> Floor | None:
    """Return the floor, if the people show how far below the camera it is; covariance: (N_SHARED, N_SHARED)."""
    sd = np.sqrt(np.diag(covariance))
    if sd[HEIGHT] > _FOUND_FLOOR_REL_SD:
        return None
    height = float(np.exp(fit.shared[HEIGHT]))
    return Floor(
        height, float(fit.shared[PITCH]), float(fit.shared[ROLL]), float(height * sd[HEIGHT]), float(sd[PITCH]),
        float(sd[ROLL]),
    )  # fmt: skip


def _basis(explained: Explained, model: BodyModel, depth_misfit: FloatArray) -> tuple[str, ...]:
    believed = explained.evidence.seen & (explained.fit.weights > _BELIEVED)
    used = believed @ np.stack(list(model.kinds.values()), axis=1)
    used[:, list(model.kinds).index("feet")] &= explained.on_floor
    used = np.column_stack([used, np.abs(depth_misfit) <= MOST_DEPTH_MISFIT])
    kinds = (*model.kinds, "depth")
    return tuple("+".join(kind for kind, true in zip(kinds, row, strict=True) if true) for row in used.tolist())


def _spread(values: FloatArray, count: int, rows: NDArray[np.intp]) -> FloatArray:
    result = np.full((count, *values.shape[1:]), np.nan)
    result[rows] = values
    return result


def _spread_square(values: FloatArray, count: int, rows: NDArray[np.intp]) -> FloatArray:
    result = np.full((3 * count, 3 * count), np.nan)
    index = (3 * rows[:, None] + np.arange(3)).ravel()
    result[np.ix_(index, index)] = values
    return result
