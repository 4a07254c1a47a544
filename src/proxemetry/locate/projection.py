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
from .body_model import BodyModel
from .body_tables import LATENTS, SHOE_M

FloatArray = NDArray[np.float64]

POINT, DEPTH, HEADING, TURN = slice(0, 2), 2, 3, 4
LOG_LENGTHS = slice(5, 5 + len(LENGTHS))
POSTURE = slice(5 + len(LENGTHS), 5 + len(LENGTHS) + len(LATENTS))
N_LOCAL = POSTURE.stop
PITCH, ROLL, HEIGHT, FOCAL, PRINCIPAL = 0, 1, 2, 3, slice(4, 6)
N_SHARED = 6

_STATURE = LENGTHS.index("stature")


@dataclass(frozen=True, eq=False)
class BodyTables:
    """The body model's tables, row by row, for its K joints and, as one more, the sole below the torso's middle.

    table: shape (R, 3, K + 1, lengths + latents), metres per metre and statures; head: shape (R, 3, K + 1, lengths);
    rest: shape (R, 3, K + 1). See `body_model.BodyModel`.
    """

    table: FloatArray
    head: FloatArray
    rest: FloatArray

    @classmethod
    def of(cls, model: BodyModel, posture: NDArray[np.intp]) -> BodyTables:
        """Return the tables of rows in these postures (R,)."""
        postures, joints = model.rest.shape[:2]
        table = np.zeros((postures, 3, joints + 1, len(LENGTHS) + len(LATENTS)))
        table[:, :, :-1] = np.concatenate([model.body, model.latent], axis=-1).transpose(0, 2, 1, 3)
        table[:, 2, -1] = -np.concatenate([model.torso, model.torso_latent], axis=-1)
        head = np.zeros((postures, 3, joints + 1, len(LENGTHS)))
        head[:, :, :-1] = model.head.transpose(0, 2, 1, 3)
        rest = np.zeros((postures, 3, joints + 1))
        rest[:, :, :-1] = model.rest.transpose(0, 2, 1)
        rest[:, 2, -1] = -model.torso_rest
        return cls(table[posture], head[posture], rest[posture])

    def taken(self, index: NDArray[np.intp]) -> BodyTables:
        """Return the tables of some of the rows."""
        return BodyTables(self.table[index], self.head[index], self.rest[index])


@dataclass(frozen=True, eq=False)
class Projected:
    """Keypoints of R rows, with what their derivatives follow from.

    points: shape (R, 2, K). floor: shape (R,), how far the sole is above the floor in metres, floor_jacobian: shape
    (R, N_LOCAL + N_SHARED). ideal: shape (R, 2, K), at focal length 1; enlarged: at the estimated one.
    focal_over_depth: shape (R, 1, K). moved: shape (R, 3, K, N_LOCAL + N_SHARED), the derivatives of the joints in the
    camera frame.
    """

    points: FloatArray
    floor: FloatArray
    floor_jacobian: FloatArray
    ideal: FloatArray
    enlarged: FloatArray
    focal_over_depth: FloatArray
    moved: FloatArray

    def jacobian(self, weight: FloatArray) -> FloatArray:
        """Return the derivatives of the points (R, 2, K, N_LOCAL + N_SHARED), each point's times its weight (R, K)."""
        weight = weight[:, None]
        result = self.ideal[..., None] * self.moved[:, 2:]
        np.subtract(self.moved[:, :2], result, out=result)
        result *= (self.focal_over_depth * weight)[..., None]
        # focal length and principal point move the points themselves too
        result[..., N_LOCAL + FOCAL] += self.enlarged * weight
        result[:, 0, :, N_LOCAL + PRINCIPAL.start] += weight[:, 0]
        result[:, 1, :, N_LOCAL + PRINCIPAL.start + 1] += weight[:, 0]
        return result


def camera_axes(pitch: FloatArray, roll: FloatArray) -> FloatArray:
    """Return the matrices (R, 3, 3) from world to camera axes, of pitches and rolls (R,)."""
    cp, sp, cr, sr = np.cos(pitch), np.sin(pitch), np.cos(roll), np.sin(roll)
    matrix = np.zeros((len(cp), 3, 3))
    matrix[:, 0, 0], matrix[:, 0, 1], matrix[:, 0, 2] = cr, -sr * cp, sr * sp
    matrix[:, 1, 0], matrix[:, 1, 1], matrix[:, 1, 2] = sr, cr * cp, -cr * sp
    matrix[:, 2, 1], matrix[:, 2, 2] = sp, cp
    return matrix


def turns(matrix: FloatArray, roll: FloatArray) -> FloatArray:
    """Return what turning by heading, pitch and roll does to vectors of the camera frame: (R, 9, 3), in this order.

    Each turns about an axis: up, the camera's x before its roll, and the optical axis.
    """
    result = np.zeros((len(matrix), 9, 3))
    down = matrix[:, :, 1]
    result[:, 0, 1], result[:, 0, 2], result[:, 1, 2] = down[:, 2], -down[:, 1], down[:, 0]
    result[:, 1, 0], result[:, 2, 0], result[:, 2, 1] = -down[:, 2], down[:, 1], -down[:, 0]
    cr, sr = np.cos(roll), np.sin(roll)
    result[:, 3, 2], result[:, 4, 2], result[:, 5, 0], result[:, 5, 1] = sr, -cr, -sr, cr
    result[:, 6, 1], result[:, 7, 0] = -1.0, 1.0
    return result


def body_axes(heading: FloatArray) -> FloatArray:
    """Return the body's forward, left and up as columns of (..., 3, 3) in the world frame, of headings (...)."""
    sine, cosine = np.sin(heading), np.cos(heading)
    axes = np.zeros((*heading.shape, 3, 3))
    axes[..., 0, 0] = axes[..., 2, 1] = sine
    axes[..., 0, 1] = cosine
    axes[..., 2, 0] = -cosine
    axes[..., 1, 2] = -1.0
    return axes


def torso_position(local: FloatArray, shared: FloatArray) -> FloatArray:
    """Return the torso's middle (R, 3) in the camera frame; shared is (N_SHARED,) or (R, N_SHARED)."""
    result = np.empty((len(local), 3))
    depth = np.exp(local[:, DEPTH])
    plane = local[:, POINT] - shared[..., PRINCIPAL]
    result[:, :2] = plane * (np.exp(-shared[..., FOCAL]) * depth)[:, None]
    result[:, 2] = depth
    return result


def torso_jacobian(position: FloatArray, shared: FloatArray) -> FloatArray:
    """Return the derivatives of the torso's middle (R, 3) by all unknowns, shape (R, 3, N_LOCAL + N_SHARED)."""
    scale = position[:, 2] * np.exp(-shared[..., FOCAL])
    result = np.zeros((len(position), 3, N_LOCAL + N_SHARED))
    result[:, 0, 0] = result[:, 1, 1] = scale
    result[:, :, DEPTH] = position
    result[:, :2, N_LOCAL + FOCAL] = -position[:, :2]
    result[:, 0, N_LOCAL + PRINCIPAL.start] = result[:, 1, N_LOCAL + PRINCIPAL.start + 1] = -scale
    return result


def project(local: FloatArray, shared: FloatArray, bodies: BodyTables) -> Projected:
    """Project the rows' bodies, each with its own tables, under one camera (N_SHARED,) or one each (R, N_SHARED)."""
    count, joints = len(local), bodies.head.shape[2]
    shared = np.broadcast_to(shared, (count, N_SHARED))
    matrix = camera_axes(shared[:, PITCH], shared[:, ROLL])
    turn = turns(matrix, shared[:, ROLL])
    torso = torso_position(local, shared)
    lengths = np.exp(local[:, LOG_LENGTHS])
    stature = lengths[:, [_STATURE]]
    # a table's columns are log lengths and latents: here they come in the camera frame, metres per unit of either
    axes, head_axes = matrix @ body_axes(np.stack([local[:, HEADING], local[:, HEADING] + local[:, TURN]]))
    linear = (axes @ bodies.table.reshape(count, 3, -1)).reshape(count, 3, joints, -1)
    head = (head_axes @ bodies.head.reshape(count, 3, -1)).reshape(count, 3, joints, -1)
    linear[..., : len(LENGTHS)] += head
    linear *= np.concatenate([lengths, np.repeat(stature, len(LATENTS), axis=1)], axis=1)[:, None, None]
    head = (head @ lengths[:, None, :, None])[..., 0]
    # what the lengths and what the posture do, in one product
    parts = np.zeros((count, 1, linear.shape[-1], 2))
    parts[:, 0, : len(LENGTHS), 0], parts[:, 0, len(LENGTHS) :, 1] = 1.0, local[:, POSTURE]
    about, held = np.moveaxis(linear @ parts, -1, 0)
    held = held + axes @ bodies.rest * stature[..., None]
    about = about + held  # the torso's middle

    moved = np.empty((count, 3, joints, N_LOCAL + N_SHARED))
    moved[:] = torso_jacobian(torso, shared)[:, :, None]
    moved[..., LOG_LENGTHS.start : POSTURE.stop] = linear
    moved[..., LOG_LENGTHS.start + _STATURE] += held  # a body grows with its stature as a whole, posture and all
    turned = turn @ about
    moved[..., HEADING], moved[..., TURN] = turned[:, 0:3], turn[:, 0:3] @ head
    moved[..., N_LOCAL + PITCH] += turned[:, 3:6]
    moved[..., N_LOCAL + ROLL] += turned[:, 6:9]

    about += torso[:, :, None]
    focal = np.exp(shared[:, FOCAL])[:, None, None]
    depth = np.maximum(about[:, 2:, :-1], 0.05)  # a joint beside the lens must not divide by zero on the way
    ideal = about[:, :2, :-1] / depth
    enlarged = ideal * focal
    points = enlarged + shared[:, PRINCIPAL, None]
    floor, floor_jacobian = _above_floor(about[:, :, -1:], moved[:, :, -1], shared, matrix[:, None, :, 1], turn)
    return Projected(points, floor, floor_jacobian, ideal, enlarged, focal / depth, moved[:, :, :-1])


def _above_floor(
    sole: FloatArray, moved: FloatArray, shared: FloatArray, down: FloatArray, turn: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return how far each sole is above the floor (R,), and the derivatives (R, N_LOCAL + N_SHARED).

    sole: shape (R, 3, 1) in the camera frame; moved: shape (R, 3, N_LOCAL + N_SHARED), its derivatives; down: shape
    (R, 1, 3).
    """
    height = np.exp(shared[:, HEIGHT])
    above = height - (down @ sole)[:, 0, 0] - SHOE_M
    jacobian = -(down @ moved)[:, 0]
    # gravity turns in the camera frame too: its derivative times the sole is minus its own times the turned sole
    turned = (down @ (turn[:, 3:] @ sole).reshape(len(sole), 2, 3).swapaxes(1, 2))[:, 0]
    jacobian[:, N_LOCAL + PITCH] += turned[:, 0]
    jacobian[:, N_LOCAL + ROLL] += turned[:, 1]
    jacobian[:, N_LOCAL + HEIGHT] = height
    return above, jacobian
