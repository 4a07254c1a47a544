"""Bodies to keypoints and back: residuals of a photo's explanation, with their analytic derivatives.

Unknowns of a row (one person under one hypothesis), in this order:
- the torso's middle as a point of the photo (2, in units of the nominal focal length) and the log of its depth in m;
- the heading, and the head's turn relative to it, radians (positive to the person's left);
- the logarithms of the body lengths (`anthropometry.LENGTHS`);
- the latent posture (`body_model.LATENTS`).
Unknowns that all rows share: pitch and roll (as in `bodies.Floor`), log camera height above the floor, log focal length
relative to the nominal one, and the principal point's error (2, in units of the nominal focal length).

The world frame is the camera's, turned so that y points along gravity; a row's heading h faces (sin h, 0, -cos h).

Columns of the unknowns, of a row (local) and of the camera (shared, after the local ones in a row's equations):

    local   0    1    2          3        4     5 ........... 10  11 ........... 23
            point     log depth  heading  turn  log lengths       latent posture
    shared  0      1     2           3          4    5
            pitch  roll  log height  log focal  principal point
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...anthropometry import LENGTHS
from ...arrays import FloatArray
from .body_model import BodyModel
from .body_tables import LATENTS, SHOE_M

POINT, DEPTH, HEADING, TURN = slice(0, 2), 2, 3, 4
LOG_LENGTHS = slice(5, 5 + len(LENGTHS))
POSTURE = slice(5 + len(LENGTHS), 5 + len(LENGTHS) + len(LATENTS))
N_LOCAL = POSTURE.stop
PITCH, ROLL, HEIGHT, FOCAL, PRINCIPAL = 0, 1, 2, 3, slice(4, 6)
N_SHARED = 6

_STATURE = LENGTHS.index("stature")
#: From more steeply above people are seen at the tilt that they have from here: nothing was measured beyond 53 degrees
#: (`tilt`), and a body that is looked at along its axis has no length to keep.
_STEEPEST_RAD = float(np.deg2rad(53.0))


# Columns of a body's tables: one a length and one a latent, as the unknowns have them, and one for what neither moves.
_COLUMNS = len(LENGTHS) + len(LATENTS) + 1
_LENGTHS, _LATENTS = slice(0, len(LENGTHS)), slice(len(LENGTHS), _COLUMNS - 1)
# Which log length each column grows with: its own, or the stature.
_GROWN_BY: FloatArray = np.eye(len(LENGTHS), _COLUMNS)
_GROWN_BY[_STATURE, len(LENGTHS) :] = 1.0
# Heading and turn to the headings of trunk and head.
_FACING: FloatArray = np.array([[1.0, 1.0], [0.0, 1.0]])
# The cross products with the unit vectors from the left, as matrices (3, 3 x 3).
_CROSS: FloatArray = np.cross(np.eye(3)[:, None], np.eye(3)).swapaxes(1, 2).reshape(3, 9)


@dataclass(frozen=True, eq=False)
class BodyTables:
    """The body model's tables, row by row, for its K joints.

    Their columns are lengths, latents and, last, the rest: metres per metre and statures. table: shape (R, 3, K,
    columns); head, of the lengths only: (R, 3, K, lengths); torso, the height of the torso's middle above the sole:
    (R, columns). See `body_model.BodyModel`. tilt: shape (R, 2), radians: a body is seen as by a camera that is pitched
    and rolled by so much more, but stands where it stands and looks as long as it is.
    """

    table: FloatArray
    head: FloatArray
    torso: FloatArray
    tilt: FloatArray

    @classmethod
    def of(cls, model: BodyModel, posture: NDArray[np.intp]) -> BodyTables:
        """Return the tables of rows in these postures (R,)."""
        table = np.concatenate([model.body, model.latent, model.rest[..., None]], axis=-1).swapaxes(1, 2)
        torso = np.concatenate([model.torso, model.torso_latent, model.torso_rest[:, None]], axis=-1)
        # in one piece, for the products to take them as they lie
        flat, head = (np.ascontiguousarray(part[posture]) for part in (table, model.head.swapaxes(1, 2)))
        return cls(flat, head, torso[posture], np.zeros((len(posture), 2)))

    @classmethod
    def joined(cls, parts: Sequence[BodyTables]) -> BodyTables:
        """Return the tables of all rows of several."""
        names = ("table", "head", "torso", "tilt")
        return cls(*(np.concatenate([getattr(part, name) for part in parts]) for name in names))

    def taken(self, index: NDArray[np.intp]) -> BodyTables:
        """Return the tables of some of the rows."""
        return BodyTables(self.table[index], self.head[index], self.torso[index], self.tilt[index])


@dataclass(frozen=True, eq=False)
class Projected:
    """Keypoints and soles of R rows, with their derivatives.

    points: shape (R, 2, K), in units of the nominal focal length. floor: shape (R,), how far the sole is above the
    floor in metres. equations: shape (R, 2 K + 1, N_LOCAL + N_SHARED + 1), the derivatives by all unknowns: first of
    all x, then of all y, then of the floor. Its last column is free, for the residuals.
    """

    points: FloatArray
    floor: FloatArray
    equations: FloatArray


def camera_axes(tilt: FloatArray) -> FloatArray:
    """Return the matrices (R, 3, 3) from world to camera axes; tilt: shape (R, 2), pitch and roll."""
    (cp, cr), (sp, sr) = np.cos(tilt).T, np.sin(tilt).T
    matrix = np.zeros((len(tilt), 3, 3))
    matrix[:, 0, 0], matrix[:, 0, 1], matrix[:, 0, 2] = cr, -sr * cp, sr * sp
    matrix[:, 1, 0], matrix[:, 1, 1], matrix[:, 1, 2] = sr, cr * cp, -cr * sp
    matrix[:, 2, 1], matrix[:, 2, 2] = sp, cp
    return matrix


def turns(matrix: FloatArray) -> FloatArray:
    """Return what turning by heading, pitch and roll does to vectors of the camera frame: (R, 9, 3), in this order.

    Each turns about an axis: up, the camera's x before its roll, and the optical axis.
    """
    axes = np.zeros((len(matrix), 3, 3))
    axes[:, 0], axes[:, 1], axes[:, 2, 2] = -matrix[:, :, 1], matrix[:, :, 0], 1.0
    return (axes @ _CROSS).reshape(-1, 9, 3)


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


def angle_from_above(local: FloatArray, shared: FloatArray) -> FloatArray:
    """Return how steeply each row's torso is looked down at, radians (R,), no more than `_STEEPEST_RAD`.

    shared is (N_SHARED,) or (R, N_SHARED).
    """
    down = camera_axes(shared.reshape(-1, N_SHARED)[:, PITCH : ROLL + 1])[:, :, 1]
    return _from_above(torso_position(local, shared), down)


def _from_above(sight: FloatArray, down: FloatArray) -> FloatArray:
    sine = np.einsum("ri,ri->r", sight, np.broadcast_to(down, sight.shape))
    angle = np.arcsin(sine / np.sqrt(np.einsum("ri,ri->r", sight, sight)))
    return np.clip(angle, -_STEEPEST_RAD, _STEEPEST_RAD)


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
    camera = shared.reshape(-1, N_SHARED)
    level = camera_axes(camera[:, PITCH : ROLL + 1])
    torso = torso_position(local, camera)
    matrix, shortened, shorter_by_pitch = _at_tilt(torso, camera, bodies.tilt, level)
    turn = turns(matrix)
    axes = matrix[:, None] @ body_axes(local[:, HEADING : TURN + 1] @ _FACING)
    # the tables in the camera frame, metres per unit of log length and latent
    scale = np.exp(local[:, LOG_LENGTHS] @ _GROWN_BY)
    linear = (axes[:, 0] @ bodies.table.reshape(count, 3, -1)).reshape(count, 3 * joints, -1)
    head = (axes[:, 1] @ bodies.head.reshape(count, 3, -1)).reshape(count, 3 * joints, -1)
    linear[..., _LENGTHS] += head
    seen_scale = scale * shortened
    linear *= seen_scale[:, None]
    # where the joints are from the torso's middle: what the lengths do, and what the posture does
    parts = np.zeros((count, _COLUMNS, 2))
    parts[:, _LENGTHS, 0] = parts[:, -1, 1] = 1.0
    parts[:, _LATENTS, 1] = local[:, POSTURE]
    about = linear @ parts
    linear[..., -1] = about[..., 1]  # a body grows with its stature as a whole, posture and all
    body = (about[..., 0] + about[..., 1]).reshape(count, 3, joints)
    turned = np.empty((count, 12, joints))  # by heading, pitch, roll and the head's turn
    turned[:, :9] = turn @ body
    turned[:, 3:6] += shorter_by_pitch * body
    turned[:, 9:] = turn[:, :3] @ (head @ seen_scale[:, _LENGTHS, None]).reshape(count, 3, joints)

    sideways = torso[:, 2:] * np.exp(-camera[:, FOCAL, None])  # metres per nominal focal length in the photo
    body += torso[..., None]
    equations = np.zeros((count, 2 * joints + 1, N_LOCAL + N_SHARED + 1))
    points = _onto_image(
        equations[:, :-1].reshape(count, 2, joints, -1), body, torso, sideways, camera,
        linear.reshape(count, 3, joints, -1), turned.reshape(count, 4, 3, joints),
    )  # fmt: skip
    upright = bodies.torso * scale
    height = upright[:, None] @ parts
    upright[:, -1] = height[:, 0, 1]
    floor = _above_floor(
        equations[:, -1],
        torso,
        sideways,
        camera,
        level[:, :, 1],
        (turn if matrix is level else turns(level))[:, 3:],
        upright,
    )
    return Projected(points, floor - height.sum(axis=(1, 2)), equations)


def _at_tilt(
    torso: FloatArray, camera: FloatArray, tilt: FloatArray, level: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return how bodies at a tilt (R, 2) are seen: the matrices from world to camera axes, `level` without one; and by
    what they are shortened, since looked at from less far above they would look longer, (R, 1), and the derivative of
    its logarithm by pitch, (R, 1, 1)."""
    if not tilt.any():
        return level, np.ones((1, 1)), np.zeros((1, 1, 1))
    matrix = camera_axes(camera[:, PITCH : ROLL + 1] + tilt)
    above = _from_above(torso, level[:, :, 1])
    instead = above + tilt[:, 0]
    return (
        matrix, (np.cos(above) / np.cos(instead))[:, None], (np.tan(instead) - np.tan(above))[:, None, None],
    )  # fmt: skip


def _onto_image(
    jacobian: FloatArray, joints: FloatArray, torso: FloatArray, sideways: FloatArray, camera: FloatArray,
    tabled: FloatArray, turned: FloatArray,
) -> FloatArray:  # fmt: skip
    """Return the points (R, 2, K) of joints (R, 3, K) in the camera frame; write their derivatives, (R, 2, K, all).

    torso: shape (R, 3); sideways: shape (R, 1). tabled: shape (R, 3, K, columns), the joints' derivatives by lengths
    and latents and, of posture alone, by the logarithm of the stature; turned: shape (R, 4, 3, K), those by heading,
    pitch, roll and turn.
    """
    focal = np.exp(camera[:, FOCAL, None, None])
    depth = np.maximum(joints[:, 2:], 0.05)  # a joint level with the lens must not divide by zero on the way
    ideal, enlarged_by = joints[:, :2] / depth, focal / depth
    enlarged = ideal * focal

    flat = ideal[..., None] * tabled[:, 2:]
    np.subtract(tabled[:, :2], flat, out=flat)
    flat *= enlarged_by[..., None]
    jacobian[..., LOG_LENGTHS.start : POSTURE.stop] = flat[..., :-1]
    jacobian[..., LOG_LENGTHS.start + _STATURE] += flat[..., -1]
    flat = ideal[:, None] * turned[:, :, 2:]
    np.subtract(turned[:, :, :2], flat, out=flat)
    flat *= enlarged_by[:, None]
    jacobian[..., HEADING], jacobian[..., TURN] = flat[:, 0], flat[:, 3]
    jacobian[..., N_LOCAL + PITCH], jacobian[..., N_LOCAL + ROLL] = flat[:, 1], flat[:, 2]

    # the torso's middle carries the body; focal length and principal point move the points themselves too
    across, aside = torso[:, :2, None] * enlarged_by, sideways * enlarged_by[:, 0]
    jacobian[:, 0, :, 0] = jacobian[:, 1, :, 1] = aside
    jacobian[..., DEPTH] = across - ideal * (torso[:, 2:, None] * enlarged_by)
    jacobian[..., N_LOCAL + FOCAL] = enlarged - across
    jacobian[:, 0, :, N_LOCAL + PRINCIPAL.start] = jacobian[:, 1, :, N_LOCAL + PRINCIPAL.start + 1] = 1.0 - aside
    return enlarged + camera[:, PRINCIPAL, None]


def _above_floor(
    jacobian: FloatArray, torso: FloatArray, sideways: FloatArray, camera: FloatArray, down: FloatArray,
    turn: FloatArray, upright: FloatArray,
) -> FloatArray:  # fmt: skip
    """Return how far the torso's middle is above where soles lie on the floor (R,); write the soles' derivatives.

    down: shape (1 or R, 3), along gravity; turn: shape (1 or R, 6, 3), what pitch and roll do to it. upright: shape (R,
    columns), what lengths, latents and, by posture alone, the logarithm of the stature add to the torso's own height.
    """
    by_place = down * torso
    aside = down[:, :2] * sideways
    below, height = by_place.sum(axis=1), np.exp(camera[:, HEIGHT])
    jacobian[:, POINT], jacobian[:, DEPTH] = -aside, -below
    np.negative(upright[:, :-1], out=jacobian[:, LOG_LENGTHS.start : POSTURE.stop])
    jacobian[:, LOG_LENGTHS.start + _STATURE] -= upright[:, -1]
    # a body turns with gravity: only the torso's middle, which the photo holds, comes nearer to the floor or further
    gravity = (turn @ down[..., None]).reshape(-1, 2, 3)
    jacobian[:, N_LOCAL + PITCH : N_LOCAL + ROLL + 1] = -(gravity @ torso[..., None])[..., 0]
    jacobian[:, N_LOCAL + HEIGHT], jacobian[:, N_LOCAL + FOCAL] = height, by_place[:, :2].sum(axis=1)
    jacobian[:, N_LOCAL + PRINCIPAL.start : N_LOCAL + PRINCIPAL.stop] = aside
    return height - below - SHOE_M
