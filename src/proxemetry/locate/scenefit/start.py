"""The start: a coarse search over every heading, posture and pitch at once, in closed form.

For each, the mean body's image under weak perspective is laid over the keypoints by scale and shift (weighted least
squares), which gives each person's depth; the pitch is the likeliest one given bodies, floor and prior.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...arrays import FloatArray
from .body_model import BodyModel
from .body_tables import N_COMMON, N_TELLING, POSTURE_WEIGHTS, SHOE_M
from .camera_prior import SharedPrior
from .evidence import Evidence
from .projection import HEIGHT, PITCH, ROLL, body_axes, camera_axes

HEADINGS: FloatArray = np.linspace(0.0, 2 * np.pi, 8, endpoint=False)
_PITCHES: FloatArray = np.deg2rad([0.0, -12.0, 12.0, 24.0, 36.0, 50.0, 65.0])
_BODY_AXES: FloatArray = body_axes(HEADINGS)
#: How far from a pitch of the table its bodies still look right.
_CELL_RAD = np.deg2rad(5.0)
#: Bodies are mean ones in mean postures here: how much further joints stray from them than from fitted ones, and by how
#: much at least, in statures. Set by hand, for the start alone: every answer is fitted again.
_STRAY_FACTOR, _LEAST_STRAY, _LEG_STRAY = 1.5, 0.025, 0.06
#: How far a mean body's depth and the floor under it are off, its torso's height as a share of itself, and the degrees
#: of freedom of both kinds of residual: wider than the fit's own, by hand, for the start alone.
_DEPTH_REL_SD, _FLOOR_SD_M, _TORSO_REL_SD = 0.07, 0.1, 0.06
_DOF = 4.0
#: Where half of the trunks lean to one side by so much in the picture and no more, the camera may be turned instead.
#: By hand: less is found from a level start, and more is a photo on its side.
_TURNED_RAD = np.deg2rad([6.0, 45.0])


@dataclass(frozen=True, eq=False)
class Tilts:
    """The G pitches that are tried, at one roll.

    pitches: shape (G,). down: shape (G, 3), gravity's direction in the camera frame, and by_pitch its derivative. axes:
    shape (G, headings, 3, 3), from a body at each heading to the camera.
    """

    pitches: FloatArray
    roll: float
    down: FloatArray
    by_pitch: FloatArray
    axes: FloatArray

    @classmethod
    def of(cls, pitches: FloatArray, roll: float) -> Tilts:
        """Return the tables of these pitches."""
        camera = camera_axes(np.stack([pitches, np.full_like(pitches, roll)], axis=1))
        sine, cosine = np.sin(pitches), np.cos(pitches)
        by_pitch = np.stack([np.sin(roll) * sine, -np.cos(roll) * sine, cosine], axis=1)
        return cls(pitches, roll, camera[:, :, 1], by_pitch, camera[:, None] @ _BODY_AXES)

    @classmethod
    def worth_trying(cls, prior: SharedPrior, roll: float) -> Tilts:
        """Return the tilts that the prior leaves open at one roll: a stated pitch is the only one, or one more."""
        mean, sd = prior.marginal_mean, prior.marginal_sd
        if PITCH not in prior.place.which:
            return _LEVEL if roll == 0.0 else cls.of(_PITCHES, roll)
        stated = mean[PITCH : PITCH + 1]
        near = np.abs(_PITCHES - stated) < 2 * sd[PITCH]
        return cls.of(np.concatenate([stated, _PITCHES[near]]), roll)


_LEVEL = Tilts.of(_PITCHES, 0.0)


@dataclass(frozen=True, eq=False)
class Start:
    """The coarse answer for P people.

    shared: shape (N_SHARED,). cost: shape (P, postures, headings), log_depth: the same, point: the same and 2.
    shared_cost: how unlikely the camera is, with everyone on its floor.
    """

    shared: FloatArray
    cost: FloatArray
    log_depth: FloatArray
    point: FloatArray
    shared_cost: float

    @property
    def total_cost(self) -> float:
        """The negative log posterior of each person's best posture and heading, summed, up to a constant."""
        return self.shared_cost + float(self.cost.min(axis=(1, 2)).sum())


def initialise(
    evidence: Evidence, lengths_m: FloatArray, prior: SharedPrior, model: BodyModel, on_floor: FloatArray
) -> Start:
    """Return the coarse answer; lengths_m (P, L) are the mean bodies, on_floor (P,) is 1 for those on the floor.

    Bodies that lean all the same way are tried before a camera that is turned as well.
    """
    roll = float(prior.marginal_mean[ROLL])
    start = _at_roll(evidence, lengths_m, prior, model, on_floor, roll)
    leaning = _common_lean(evidence, model)
    if ROLL in prior.place.which or not _TURNED_RAD[0] < abs(leaning - roll) < _TURNED_RAD[1]:
        return start
    turned = _at_roll(evidence, lengths_m, prior, model, on_floor, leaning)
    return turned if turned.total_cost < start.total_cost else start


def _common_lean(evidence: Evidence, model: BodyModel) -> float:
    """Return how far trunks lean to the right in the picture, as the roll that would explain it: the median, radians.

    0 where no one shows shoulders and hips.
    """
    upper, lower = (evidence.seen & model.kinds[name] for name in ("shoulders", "torso"))
    known = upper.any(axis=1) & lower.any(axis=1)
    if not known.any():
        return 0.0
    shoulders, hips = (
        (evidence.points[known] * part[known, :, None]).sum(axis=1) / part[known].sum(axis=1)[:, None]
        for part in (upper, lower)
    )
    across, down = (hips - shoulders).T
    return float(np.median(np.arctan2(-across, down)))


def _at_roll(
    evidence: Evidence, lengths_m: FloatArray, prior: SharedPrior, model: BodyModel, on_floor: FloatArray, roll: float
) -> Start:  # fmt: skip
    """Return the coarse answer at one roll."""
    spread = np.maximum(_STRAY_FACTOR * model.spread, _LEAST_STRAY)
    spread = np.where(model.kinds["feet"] | model.kinds["legs"], _LEG_STRAY, spread)
    weights = np.where(evidence.seen, (spread**2 + evidence.score_noise**2) ** -1, 0.0)
    bodies, torso = _mean_bodies(lengths_m, model)
    unlikely = -np.log(POSTURE_WEIGHTS)[:, None] + np.zeros((len(weights), 1, 1))
    unlikely[~_shows_full_body(evidence, model), N_COMMON:] = np.inf
    # some postures determine the pitch, the others are tried at that pitch alone
    tilts = Tilts.worth_trying(prior, roll)
    cost, scale, shift = _fit_scale_shift(evidence.points, weights, bodies[:, :N_TELLING], tilts.axes)
    cost = cost + unlikely[:, :N_TELLING, None]
    depth = lengths_m[:, 0, None, None, None] / scale
    best, shared, shared_cost = _pitch(tilts, cost, depth, shift, torso, prior, on_floor)
    at = tilts.axes[best : best + 1]
    rare_cost, rare_scale, rare_shift = _fit_scale_shift(evidence.points, weights, bodies[:, N_TELLING:], at)
    rare_cost = rare_cost + unlikely[:, N_TELLING:, None]
    size = np.concatenate([scale[:, :, best], rare_scale[:, :, 0]], axis=1)
    return Start(
        shared, np.concatenate([cost[:, :, best], rare_cost[:, :, 0]], axis=1),
        np.log(lengths_m[:, 0, None, None] / size),
        np.concatenate([shift[:, :, best], rare_shift[:, :, 0]], axis=1), shared_cost,
    )  # fmt: skip


def _pitch(
    tilts: Tilts, cost: FloatArray, depth: FloatArray, shift: FloatArray, torso: FloatArray, prior: SharedPrior,
    on_floor: FloatArray,
) -> tuple[int, FloatArray, float]:  # fmt: skip
    """Return the likeliest pitch's place in the table, the shared unknowns (N_SHARED,) there, and their cost.

    cost, depth: shape (P, postures, pitches, headings); shift: the same and 2; torso: shape (P, postures or more).
    """
    # each person's best posture and heading at each pitch
    people = np.arange(len(cost))[:, None]
    pitch = np.arange(len(tilts.pitches))
    by_pitch = cost.swapaxes(1, 2).reshape(len(cost), len(pitch), -1)
    posture, heading = np.divmod(by_pitch.argmin(axis=-1), len(HEADINGS))
    chosen = (people, posture, pitch, heading)
    z = depth[chosen][..., None]
    position = np.concatenate([shift[chosen] * z, z], axis=-1).swapaxes(0, 1)
    standing = torso[people, posture].T + SHOE_M
    shared = np.tile(prior.marginal_mean, (len(pitch), 1))
    shared[:, ROLL] = tilts.roll
    floor_cost, shared[:, PITCH], shared[:, HEIGHT] = _floor(tilts, position, standing, prior, on_floor)
    shared_cost = floor_cost + prior.cost(shared)[0]
    best = int((cost[chosen].sum(axis=0) + shared_cost).argmin())
    return best, shared[best], float(shared_cost[best])


def _shows_full_body(evidence: Evidence, model: BodyModel) -> NDArray[np.bool_]:
    """Return who shows shoulders, hips and legs, shape (P,): only of these is a rare posture believed."""
    legs = model.kinds["feet"] | model.kinds["legs"]
    parts = (model.kinds["shoulders"], model.kinds["torso"], legs)
    return np.all([(evidence.seen & part).any(axis=1) for part in parts], axis=0)


def _mean_bodies(lengths_m: FloatArray, model: BodyModel) -> tuple[FloatArray, FloatArray]:
    """Return the joints (P, postures, K, 3) in statures and the torso's height above the sole (P, postures) in m."""
    stature = lengths_m[:, None, None, None, :1]
    tables = model.body + model.head
    held = model.rest + (model.latent @ model.prior_mean[:, None, :, None])[..., 0]
    joints = (tables[None] * (lengths_m[:, None, None, None, :] / stature)).sum(axis=-1) + held
    torso = lengths_m @ model.torso.T + lengths_m[:, :1] * model.torso_rest
    return joints, torso


def _fit_scale_shift(
    points: FloatArray, weights: FloatArray, bodies: FloatArray, axes: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return cost, scale (statures over depth) (P, postures, pitches, headings) and the torso's point (..., 2).

    bodies: shape (P, postures, K, 3). axes: shape (pitches, headings, 3, 3), from the body's frame to the camera's.
    """
    people, postures, joints = bodies.shape[:3]
    offsets = (axes.reshape(-1, 3) @ bodies.swapaxes(-1, -2)).reshape(people, -1, 3, joints)
    share = weights / np.maximum(weights.sum(axis=1, keepdims=True), 1e-12)
    centre = (share[..., None] * points).sum(axis=1)
    seen = (points - centre[:, None]).transpose(0, 2, 1)
    # about the middle of what is seen, x of all joints and then y
    flat = offsets[:, :, :2] - centre[:, None, :, None] * offsets[:, :, 2:]
    middle = (flat.reshape(people, -1, joints) @ share[..., None]).reshape(people, -1, 2, 1)
    flat -= middle
    about = flat.reshape(people, -1, 2 * joints)
    power = about**2 @ np.tile(share, 2)[..., None]
    reach = about @ (share[:, None] * seen).reshape(people, -1, 1)
    scale = np.maximum(reach / np.maximum(power, 1e-12), 1e-5)
    about -= seen.reshape(people, 1, -1) / scale
    about *= about
    apart = (about[..., :joints] + about[..., joints:]) * (weights[:, None] / _DOF)
    cost = (_DOF + 2) / 2 * np.log1p(apart, out=apart).sum(axis=-1)
    shape = (people, postures, *axes.shape[:2])
    shift = centre[:, None] - scale * middle[..., 0]
    return cost.reshape(shape), scale.reshape(shape), shift.reshape(*shape, 2)


def _floor(
    tilts: Tilts, position: FloatArray, torso_m: FloatArray, prior: SharedPrior, on_floor: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return how badly the people fit one floor near each pitch (G,), that pitch made finer, and log camera height.

    position: shape (G, P, 3). torso_m: shape (G, P), the torso's height above the floor. Heights and a small change of
    pitch follow by robust least squares; both are held near the prior.
    """
    below = np.einsum("gpi,gi->gp", position, tilts.down)
    by_pitch = np.einsum("gpi,gi->gp", position, tilts.by_pitch)
    variance = (_DEPTH_REL_SD * below) ** 2 + (_TORSO_REL_SD * torso_m) ** 2 + _FLOOR_SD_M**2
    mean, sd = prior.marginal_mean, prior.marginal_sd
    typical = float(np.exp(mean[HEIGHT]))
    height_precision = (2 * sd[HEIGHT] * typical) ** -2
    pitch_precision, cell_precision = (2 * sd[PITCH]) ** -2, _CELL_RAD**-2
    expected = mean[PITCH] - tilts.pitches
    height, step = np.full((len(position), 1), typical), np.zeros((len(position), 1))
    for _ in range(4):
        apart = below + torso_m + step * by_pitch - height
        robust = on_floor / variance * (_DOF + 1) / (_DOF + apart**2 / variance)
        # normal equations of (height, step)
        hh = robust.sum(axis=1) + height_precision
        hs = -(robust * by_pitch).sum(axis=1)
        ss = (robust * by_pitch**2).sum(axis=1) + pitch_precision + cell_precision
        h = (robust * (below + torso_m)).sum(axis=1) + height_precision * typical
        s = -(robust * by_pitch * (below + torso_m)).sum(axis=1) + pitch_precision * expected
        determinant = hh * ss - hs**2
        height = ((h * ss - s * hs) / determinant)[:, None]
        step = ((s * hh - h * hs) / determinant)[:, None]
    apart = below + torso_m + step * by_pitch - height
    cost = (on_floor * (_DOF + 1) / 2 * np.log1p(apart**2 / variance / _DOF)).sum(axis=1)
    cost += 0.5 * cell_precision * step[:, 0] ** 2
    return cost, tilts.pitches + step[:, 0], np.log(np.clip(height[:, 0], 0.3, 50.0))
