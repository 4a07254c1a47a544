"""Bodies to keypoints and back: residuals of a photo's explanation, with their analytic derivatives.

Unknowns of a row (one person under one hypothesis), in this order:
- the torso's middle as a point of the photo (2, in units of the nominal focal length) and the log of its depth in m;
- the heading, and the head's turn relative to it, radians (positive to the person's left);
- the logarithms of the body lengths (`anthropometry.LENGTHS`);
- the latent posture (`body_model.LATENTS`).
Unknowns that all rows share: pitch and roll (as in `bodies.Floor`), log camera height above the floor, log focal length
relative to the nominal one, and the principal point's error (2, in units of the nominal focal length).

The world frame is the camera's, turned so that y points along gravity; a row's heading h faces (sin h, 0, -cos h).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..anthropometry import LENGTHS
from .body_model import LATENTS, SHOE_M, BodyModel

FloatArray = NDArray[np.float64]

POINT, DEPTH, HEADING, TURN = slice(0, 2), 2, 3, 4
LOG_LENGTHS = slice(5, 5 + len(LENGTHS))
POSTURE = slice(5 + len(LENGTHS), 5 + len(LENGTHS) + len(LATENTS))
N_LOCAL = POSTURE.stop
PITCH, ROLL, HEIGHT, FOCAL, PRINCIPAL = 0, 1, 2, 3, slice(4, 6)
N_SHARED = 6

_STATURE = LENGTHS.index("stature")
_CROUCH = POSTURE.start + LATENTS.index("crouch")
_SLUMP = POSTURE.start + LATENTS.index("slump")


@dataclass(frozen=True, eq=False)
class BodyTables:
    """The body model's tables, row by row.

    table: shape (R, 3, K, lengths + latents), metres per metre and statures; head: shape (3, K, lengths); rest: shape
    (R, 3, K); torso: shape (R, lengths); torso_rest: shape (R,). See `body_model.BodyModel`.
    """

    table: FloatArray
    head: FloatArray
    rest: FloatArray
    torso: FloatArray
    torso_rest: FloatArray

    @classmethod
    def of(cls, model: BodyModel, posture: NDArray[np.intp]) -> BodyTables:
        """Return the tables of rows in these postures (R,)."""
        table = np.concatenate([model.body, model.latent], axis=-1).transpose(0, 2, 1, 3)
        head, rest = np.ascontiguousarray(model.head.transpose(1, 0, 2)), model.rest.transpose(0, 2, 1)
        return cls(table[posture], head, rest[posture], model.torso[posture], model.torso_rest[posture])

    def taken(self, index: NDArray[np.intp]) -> BodyTables:
        """Return the tables of some of the rows."""
        return BodyTables(self.table[index], self.head, self.rest[index], self.torso[index], self.torso_rest[index])


@dataclass(frozen=True, eq=False)
class Projected:
    """Keypoints of R rows with derivatives.

    points: shape (R, 2, K). jacobian: shape (R, 2, K, N_LOCAL + N_SHARED). floor: shape (R,), how far the sole is
    above the floor in metres, floor_jacobian: shape (R, N_LOCAL + N_SHARED).
    """

    points: FloatArray
    jacobian: FloatArray
    floor: FloatArray
    floor_jacobian: FloatArray


def camera_axes(pitch: float, roll: float) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return the matrix (3, 3) from world to camera axes, and its derivatives by pitch and by roll."""
    cp, sp, cr, sr = np.cos(pitch), np.sin(pitch), np.cos(roll), np.sin(roll)
    matrix = np.array([[cr, -sr * cp, sr * sp], [sr, cr * cp, -cr * sp], [0.0, sp, cp]])
    by_pitch = np.array([[0.0, sr * sp, sr * cp], [0.0, -cr * sp, -cr * cp], [0.0, cp, -sp]])
    by_roll = np.array([[-sr, -cr * cp, cr * sp], [cr, -sr * cp, sr * sp], [0.0, 0.0, 0.0]])
    return matrix, by_pitch, by_roll


def body_axes(heading: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the body's forward, left and up as columns of (R, 3, 3) in the world frame, and the derivative."""
    sine, cosine = np.sin(heading), np.cos(heading)
    axes, by_heading = np.zeros((2, len(heading), 3, 3))
    axes[:, 0, 0], axes[:, 2, 0], axes[:, 0, 1], axes[:, 2, 1] = sine, -cosine, cosine, sine
    by_heading[:, 0, 0], by_heading[:, 2, 0], by_heading[:, 0, 1], by_heading[:, 2, 1] = cosine, sine, -sine, cosine
    axes[:, 1, 2] = -1.0
    return axes, by_heading


def torso_position(local: FloatArray, shared: FloatArray) -> FloatArray:
    """Return the torso's middle (R, 3) in the camera frame."""
    depth = np.exp(local[:, DEPTH])
    plane = (local[:, POINT] - shared[PRINCIPAL]) * np.exp(-shared[FOCAL])
    return np.concatenate([plane * depth[:, None], depth[:, None]], axis=1)


def torso_jacobian(local: FloatArray, shared: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return derivatives of `torso_position` by the row's point and log depth (R, 3, 3), by the shared (R, 3, S)."""
    position = torso_position(local, shared)
    scale = position[:, 2] * np.exp(-shared[FOCAL])
    by_local = np.zeros((len(local), 3, 3))
    by_local[:, 0, 0] = by_local[:, 1, 1] = scale
    by_local[:, :, 2] = position
    by_shared = np.zeros((len(local), 3, N_SHARED))
    by_shared[:, :2, FOCAL] = -position[:, :2]
    by_shared[:, 0, PRINCIPAL.start] = by_shared[:, 1, PRINCIPAL.start + 1] = -scale
    return by_local, by_shared


def project(local: FloatArray, shared: FloatArray, bodies: BodyTables) -> Projected:
    """Project the rows' bodies, each with its own tables."""
    lengths = np.exp(local[:, LOG_LENGTHS])
    stature = lengths[:, _STATURE, None]
    # a table's columns are log lengths and latents: what they multiply, and what their derivatives are scaled by
    values = np.concatenate([lengths, stature * local[:, POSTURE]], axis=1)
    scales = np.concatenate([lengths, np.repeat(stature, len(LATENTS), axis=1)], axis=1)
    sized = (bodies.table[..., : len(LENGTHS)] @ lengths[:, None, :, None])[..., 0]
    held = (bodies.table[..., len(LENGTHS) :] @ values[:, None, len(LENGTHS) :, None])[..., 0]
    held += bodies.rest * stature[:, :, None]
    body, head = sized + held, (bodies.head @ lengths[:, None, :, None])[..., 0]

    matrix, by_pitch, by_roll = camera_axes(float(shared[PITCH]), float(shared[ROLL]))
    axes, by_heading = body_axes(local[:, HEADING])
    head_axes, by_turn = body_axes(local[:, HEADING] + local[:, TURN])
    to_camera, head_to_camera = matrix @ axes, matrix @ head_axes
    world = axes @ body + head_axes @ head
    turned = matrix @ by_turn @ head
    torso = torso_position(local, shared)
    by_point, by_shared = torso_jacobian(local, shared)

    # derivatives of the joints in the camera frame, shape (R, 3, K, unknowns)
    rows, _, count = head.shape
    moved = np.zeros((rows, 3, count, N_LOCAL + N_SHARED))
    moved[..., 0:3] = by_point[:, :, None]
    moved[..., HEADING] = matrix @ by_heading @ body + turned
    moved[..., TURN] = turned
    linear = moved[..., LOG_LENGTHS.start : POSTURE.stop]
    linear[:] = (to_camera @ bodies.table.reshape(rows, 3, -1)).reshape(rows, 3, count, -1)
    linear[..., : len(LENGTHS)] += (head_to_camera @ bodies.head.reshape(3, -1)).reshape(rows, 3, count, -1)
    linear *= scales[:, None, None]
    linear[..., _STATURE] += to_camera @ held  # a body grows with its stature as a whole, posture and all
    moved[..., N_LOCAL:] = by_shared[:, :, None]
    moved[..., N_LOCAL + PITCH] += by_pitch @ world
    moved[..., N_LOCAL + ROLL] += by_roll @ world
    points, jacobian = _perspective(torso[:, :, None] + matrix @ world, moved, shared)
    floor, floor_jacobian = _above_floor(local, shared, bodies, torso, by_point, by_shared)
    return Projected(points, jacobian, floor, floor_jacobian)


def _perspective(joints: FloatArray, moved: FloatArray, shared: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Divide by depth: joints (R, 3, K) and their derivatives (R, 3, K, N) to points (R, 2, K) and (R, 2, K, N)."""
    focal = float(np.exp(shared[FOCAL]))
    depth = np.maximum(joints[:, 2:], 0.05)  # a joint beside the lens must not divide by zero on the way
    ideal = joints[:, :2] / depth
    jacobian = (moved[:, :2] - ideal[..., None] * moved[:, 2:]) * (focal / depth)[..., None]
    points = ideal * focal
    jacobian[..., N_LOCAL + FOCAL] += points
    jacobian[:, 0, :, N_LOCAL + PRINCIPAL.start] += 1.0
    jacobian[:, 1, :, N_LOCAL + PRINCIPAL.start + 1] += 1.0
    return points + shared[PRINCIPAL][:, None], jacobian


def _above_floor(
    local: FloatArray, shared: FloatArray, bodies: BodyTables, torso: FloatArray, by_point: FloatArray,
    by_shared: FloatArray,
) -> tuple[FloatArray, FloatArray]:  # fmt: skip
    lengths = np.exp(local[:, LOG_LENGTHS])
    stature = lengths[:, _STATURE]
    held = stature * (bodies.torso_rest - local[:, _CROUCH] - 0.5 * local[:, _SLUMP])
    matrix, by_pitch, by_roll = camera_axes(shared[PITCH], shared[ROLL])
    down = matrix[:, 1]
    height = np.exp(shared[HEIGHT])
    parts = bodies.torso * lengths
    above = height - torso @ down - parts.sum(axis=1) - held - SHOE_M
    jacobian = np.zeros((len(local), N_LOCAL + N_SHARED))
    jacobian[:, 0:3] = -down @ by_point
    jacobian[:, LOG_LENGTHS] = -parts
    jacobian[:, LOG_LENGTHS.start + _STATURE] -= held
    jacobian[:, _CROUCH] = stature
    jacobian[:, _SLUMP] = 0.5 * stature
    jacobian[:, N_LOCAL:] = -down @ by_shared
    jacobian[:, N_LOCAL + PITCH] -= torso @ by_pitch[:, 1]
    jacobian[:, N_LOCAL + ROLL] -= torso @ by_roll[:, 1]
    jacobian[:, N_LOCAL + HEIGHT] = height
    return above, jacobian
