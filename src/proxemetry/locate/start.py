"""Where to begin: a coarse look at every heading, posture and pitch at once, in closed form.

For each, the mean body's image under weak perspective is laid over the keypoints by scale and shift (weighted least
squares), which gives everybody's depth; the pitch is the one that the bodies, the floor and the prior like best.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .body_model import POSTURE_WEIGHTS, SHOE_M, BodyModel
from .evidence import Evidence
from .projection import HEIGHT, N_SHARED, PITCH, ROLL, body_axes, camera_axes
from .solver import SharedPrior

FloatArray = NDArray[np.float64]

HEADINGS: FloatArray = np.linspace(0.0, 2 * np.pi, 8, endpoint=False)
_PITCHES = np.deg2rad([0.0, -12.0, 12.0, 24.0, 36.0, 50.0, 65.0])
_DEPTH_REL_SD = 0.07
_FLOOR_SD_M = 0.1
_DOF = 4.0


@dataclass(frozen=True, eq=False)
class Start:
    """The coarse answer for P people.

    shared: shape (N_SHARED,). cost: shape (P, postures, headings), log_depth: the same, point: the same and 2.
    """

    shared: FloatArray
    cost: FloatArray
    log_depth: FloatArray
    point: FloatArray


def look(
    evidence: Evidence, lengths_m: FloatArray, prior: SharedPrior, model: BodyModel, on_floor: FloatArray
) -> Start:
    """Return the coarse answer; lengths_m (P, L) are the mean bodies, on_floor (P,) is 1 for those on the floor."""
    spread = np.maximum(1.5 * model.spread, 0.025)
    spread = np.where(model.kinds["feet"] | model.kinds["legs"], 0.06, spread)
    weights = np.where(evidence.seen, (spread * evidence.noise_scale) ** -2, 0.0)
    bodies, torso = _mean_bodies(lengths_m, model)
    best: tuple[float, Start] | None = None
    log_prior = np.log(POSTURE_WEIGHTS)
    for pitch in _PITCHES:
        cost, scale, shift = _lay(evidence.points, weights, bodies, float(pitch), lengths_m[:, 0])
        cost = cost - log_prior[:, None]
        depth = lengths_m[:, 0, None, None] / scale
        people = np.arange(len(cost))
        posture, heading = np.unravel_index(cost.reshape(len(cost), -1).argmin(axis=1), cost.shape[1:])
        z = depth[people, posture, heading]
        position = np.concatenate([shift[people, posture, heading] * z[:, None], z[:, None]], axis=1)
        shared = np.zeros(N_SHARED)
        shared[PITCH], shared[ROLL] = pitch, prior.mean[ROLL]
        floor_cost, shared[HEIGHT] = _floor(position, torso[people, posture] + SHOE_M, float(pitch), prior, on_floor)
        total = float(cost[people, posture, heading].sum()) + floor_cost + prior.cost(shared)
        if best is None or total < best[0] - 1e-9:
            best = total, Start(shared, cost, np.log(depth), shift)
    assert best is not None
    return best[1]


def _mean_bodies(lengths_m: FloatArray, model: BodyModel) -> tuple[FloatArray, FloatArray]:
    """Return the joints (P, postures, K, 3) in statures and the torso's height above the sole (P, postures) in m."""
    stature = lengths_m[:, None, None, None, :1]
    tables = model.body + model.head
    held = model.rest + (model.latent @ model.prior_mean[:, None, :, None])[..., 0]
    joints = (tables[None] * (lengths_m[:, None, None, None, :] / stature)).sum(axis=-1) + held
    torso = lengths_m @ model.torso.T + lengths_m[:, :1] * model.torso_rest
    return joints, torso


def _lay(
    points: FloatArray, weights: FloatArray, bodies: FloatArray, pitch: float, stature_m: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return cost, scale (statures over depth) (P, postures, headings) and the torso's point (..., 2)."""
    axes = camera_axes(pitch, 0.0)[0] @ body_axes(HEADINGS)[0]
    offsets = np.einsum("hij,pqkj->pqhki", axes, bodies)
    total = np.maximum(weights.sum(axis=1), 1e-12)
    centre = (weights[..., None] * points).sum(axis=1) / total[:, None]
    flat = offsets[..., :2] - centre[:, None, None, None, :] * offsets[..., 2:]
    share = (weights / total[:, None])[:, None, None, :, None]
    middle = (share * flat).sum(axis=-2)
    about = flat - middle[..., None, :]
    seen = (points - centre[:, None])[:, None, None]
    power = (share * about**2).sum(axis=(-2, -1))
    scale = (share * about * seen).sum(axis=(-2, -1)) / np.maximum(power, 1e-12)
    scale = np.maximum(scale, 1e-5)
    squared = ((seen / scale[..., None, None] - about) ** 2).sum(axis=-1) * weights[:, None, None]
    cost = ((_DOF + 2) / 2 * np.log1p(squared / _DOF)).sum(axis=-1)
    return cost, scale, centre[:, None, None] - scale[..., None] * middle


def _floor(
    position: FloatArray, torso_m: FloatArray, pitch: float, prior: SharedPrior, on_floor: FloatArray
) -> tuple[float, float]:
    """Return how badly the people fit one floor at this pitch, and the log of the camera's height above it."""
    down = camera_axes(pitch, 0.0)[0][:, 1]
    below = position @ down
    heights = below + torso_m
    variance = (_DEPTH_REL_SD * below) ** 2 + (0.06 * torso_m) ** 2 + _FLOOR_SD_M**2
    typical = float(np.exp(prior.mean[HEIGHT]))
    weights = on_floor / variance
    # the prior counts as one person seen badly
    anchor = 1.0 / (prior.sd[HEIGHT] * 2 * typical) ** 2
    height = typical
    for _ in range(3):
        z2 = (heights - height) ** 2 / variance
        robust = weights * (_DOF + 1) / (_DOF + z2)
        height = float((robust @ heights + anchor * typical) / (robust.sum() + anchor))
    z2 = (heights - height) ** 2 / variance
    cost = float((on_floor * (_DOF + 1) / 2 * np.log1p(z2 / _DOF)).sum())
    return cost, float(np.log(np.clip(height, 0.2, 50.0)))
