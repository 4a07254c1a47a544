"""People as verticals of nearly one length on one floor: where a camera shows them, and the camera solved for.

All lengths in a photo are in units of its long side, from its middle.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...arrays import FloatArray
from ...people import People
from ...people.keypoint_noise import people_sd_px
from ...photo.metadata import Metadata
from ..frame import frame_of

#: Focal lengths looked for, as parts of the long side: 9 mm to 430 mm on full frame.
F_RANGE = (0.25, 12.0)
#: Coefficient of variation of an adult's stature, sexes unknown (Bertoni et al., ICCV 2019).
STATURE_CV = 0.046
#: Standard deviation of how far a standing person's axis is off the vertical, per direction, radians.
LEAN_SD = 0.02
#: Lengths from the ankle, as parts of the stature (ANSUR II: eye height .936, acromion .821, malleolus .040).
_EYES_ABOVE_ANKLE, _SHOULDERS_ABOVE_ANKLE = 0.895, 0.775
_PRINCIPAL_SD = 0.005  # of the long side, for a photo that is no crop
_EACH_AXIS = np.eye(2)[:, :, None, None]
#: Where the top of a person that no camera could show is taken to be: far outside the photo.
_NOWHERE = 10.0


@dataclass(frozen=True)
class Segments:
    """People as segments from the ankles' middle up: the photo's middle is the origin, its long side the unit.

    rows: shape (N,), rows of `people`. feet, tops: shape (N, 2). lengths: shape (N,), as parts of the stature.
    feet_sd, tops_sd: shape (N,), per axis. principal_sd: per axis.
    """

    rows: NDArray[np.intp]
    feet: FloatArray
    tops: FloatArray
    lengths: FloatArray
    feet_sd: FloatArray
    tops_sd: FloatArray
    principal_sd: float
    long_side_px: float


def segments_of(people: People, width: int, height: int) -> Segments:
    """Return the people in a photo of `width` x `height` pixels who are seen from ankles to head or shoulders."""
    sd = people_sd_px(people)

    def middle_sd(left: str, right: str) -> FloatArray:
        a, b = people.skeleton.index(left), people.skeleton.index(right)
        return np.full(len(people), np.nan) if a is None or b is None else np.hypot(sd[:, a], sd[:, b]) / 2

    feet = (people.joint("left_ankle") + people.joint("right_ankle")) / 2
    ears = (people.joint("left_ear") + people.joint("right_ear")) / 2
    eyes = (people.joint("left_eye") + people.joint("right_eye")) / 2
    shoulders = (people.joint("left_shoulder") + people.joint("right_shoulder")) / 2
    tops, lengths = shoulders.copy(), np.full(len(people), _SHOULDERS_ABOVE_ANKLE)
    tops_sd = middle_sd("left_shoulder", "right_shoulder")
    for head, pair in ((eyes, ("left_eye", "right_eye")), (ears, ("left_ear", "right_ear"))):
        seen = np.isfinite(head).all(axis=1)
        tops[seen], lengths[seen], tops_sd[seen] = head[seen], _EYES_ABOVE_ANKLE, middle_sd(*pair)[seen]
    usable = np.isfinite(feet).all(axis=1) & np.isfinite(tops).all(axis=1) & _straight(people)
    rows = np.flatnonzero(usable)
    unit = float(max(width, height))
    centre = np.array([width, height]) / 2
    frame = frame_of(width, height, Metadata())
    feet_sd = middle_sd("left_ankle", "right_ankle")
    return Segments(
        rows, (feet[rows] - centre) / unit, (tops[rows] - centre) / unit, lengths[rows], feet_sd[rows] / unit,
        tops_sd[rows] / unit, max(_PRINCIPAL_SD, frame.principal_sd_px / unit), unit,
    )  # fmt: skip


def _straight(people: People) -> NDArray[np.bool_]:
    """Return which people are not bent: shoulders, hips, knees and ankles lie nearly on a line, as far as seen."""
    straight = np.ones(len(people), dtype=bool)
    for side in ("left", "right"):
        chain = np.stack([people.joint(f"{side}_{joint}") for joint in ("shoulder", "hip", "knee", "ankle")])
        walked = np.linalg.norm(np.diff(chain, axis=0), axis=-1).sum(axis=0)
        direct = np.linalg.norm(chain[-1] - chain[0], axis=-1)
        straight &= ~(direct < 0.93 * walked)  # NaN, a joint that is not seen, is no evidence
    return straight


@dataclass(frozen=True)
class Tops:
    """Where people's tops should be for G focal lengths and camera poses, and what a little more of anything moves.

    at: shape (2, G, N). by_parameter: shape (5, 2, G, N), derivatives by `parameters`. by_foot, by_lean: shape
    (2, 2, G, N), by the foot's place and by the lean to the side and towards the camera. A foot above the horizon or a
    top behind the camera is no explanation: such tops come out far away, where nothing moves them.
    """

    at: FloatArray
    by_parameter: FloatArray
    by_foot: FloatArray
    by_lean: FloatArray


def tops_of(feet: FloatArray, lengths: FloatArray, log_f: FloatArray, parameters: FloatArray) -> Tops:
    """Return where the tops of people with given feet (N, 2) and lengths (N,) should be.

    parameters: shape (G, 5): pitch, roll, log of stature over camera height, principal point. With X the foot and n
    up, n.X = -H, so the top is at X + l S n, which projects like x - (l S / H) (n.x) n for the foot's ray x.
    """
    pitch, roll, log_ratio, *_ = parameters.T
    f, centre = np.exp(log_f)[:, None], parameters.T[3:, :, None]
    axes = _axes(pitch, roll)
    flat, deep = axes[:, :2], axes[:, 2:]
    places = (feet.T[:, None] - centre) / f
    along = flat[:, 0] * places[0] + flat[:, 1] * places[1] + deep[:, 0]
    share = np.exp(log_ratio)[:, None] * lengths
    reach = share * along[0]
    depth = 1 - reach * deep[0, 0]
    possible = (along[0] < 0) & (depth > 1e-3)
    depth = np.maximum(depth, 1e-3)
    seen = (places - reach * flat[0]) / depth
    scale = np.where(possible, f / depth, 0.0)
    moved = scale * (flat - seen * deep)  # the picture, with a top that moves up, to the side or ahead
    by_lean = -reach * moved[1:]
    # Up leans too where the camera turns, and with it goes the floor.
    turned = by_lean - (share * along[1:])[:, None] * moved[0]
    by_foot = _EACH_AXIS * (scale / f) - flat[0][:, None] * (share / f * moved[0])
    by_parameter = np.empty((5, *seen.shape))
    by_parameter[0] = -turned[1]
    by_parameter[1] = np.cos(pitch)[:, None] * turned[0]
    by_parameter[2] = -reach * moved[0]
    by_parameter[3:] = _EACH_AXIS * possible - by_foot
    return Tops(np.where(possible, centre + f * seen, _NOWHERE), by_parameter, by_foot, by_lean)


def _axes(pitch: FloatArray, roll: FloatArray) -> FloatArray:
    """Return up in the camera frame (see `bodies.Floor`), to the side and ahead on the floor, shape (3, 3, G, 1)."""
    sin_p, cos_p, sin_r, cos_r = np.sin(pitch), np.cos(pitch), np.sin(roll), np.cos(roll)
    up = (sin_r * cos_p, -cos_r * cos_p, -sin_p)
    return np.array([up, (cos_r, sin_r, 0 * roll), (sin_p * sin_r, -sin_p * cos_r, cos_p)])[..., None]


def residuals_of(
    segments: Segments, log_f: FloatArray, parameters: FloatArray, scatter: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return residuals and their derivatives by the parameters, (6, 2, G, N), whitened, and log determinants (G, N).

    The determinant is of the covariance that whitens: the noise of foot and top, lean, and how much statures differ.
    scatter: shape (G,), factors on noise and lean.
    """
    tops = tops_of(segments.feet, segments.lengths, log_f, parameters)
    factor = scatter[:, None]
    feet, leans, statures = (
        tops.by_foot * (factor * segments.feet_sd),
        tops.by_lean * (factor * LEAN_SD),
        tops.by_parameter[2:3] * STATURE_CV,
    )
    spread = np.concatenate([feet, leans, statures])
    tops_variance = (factor * segments.tops_sd) ** 2
    # Cholesky's factor of the covariance [[xx, xy], [xy, yy]] is [[a, 0], [b, c]].
    xx, yy = np.einsum("kign,kign->ign", spread, spread) + tops_variance
    a = np.sqrt(xx)
    b = np.einsum("kgn,kgn->gn", spread[:, 0], spread[:, 1]) / a
    c = np.sqrt(np.maximum(yy - b**2, tops_variance))  # never less but for rounding
    white = np.concatenate([(tops.at - segments.tops.T[:, None])[None], tops.by_parameter])
    white[:, 0] /= a
    white[:, 1] -= b * white[:, 0]
    white[:, 1] /= c
    return white, 2 * np.log(a * c)


def distances_of(segments: Segments, log_f: float, parameters: FloatArray, scatter: float) -> FloatArray:
    """Return each person's squared Mahalanobis distance from where one camera would show them, shape (N,)."""
    white, _ = residuals_of(segments, np.array([log_f]), parameters[None], np.array([scatter]))
    return (white[0, :, 0] ** 2).sum(axis=0)


def direct_solutions(segments: Segments, rows: NDArray[np.intp]) -> tuple[FloatArray, FloatArray]:
    """Solve for the camera from groups of people of one stature, linearly: rows of shape (T, n), n people each.

    Return log f and parameters, shapes (S,) and (S, 5), of the S <= T groups that leave a camera, in their order.
    Each top is where the foot's point and the vertical vanishing point z mix: d t = e b + l z, with e the foot's
    depth in statures (Fei et al., ICCV 2021). t x (e b + l z) = 0 is linear in z and all e. The floor then gives
    z_1 b_1 / f^2 + z_2 b_2 / f^2 + z_3 = c / e, which is linear in 1 / f^2 and c.
    """
    groups, count = rows.shape
    one = np.ones((groups, count, 1))
    feet = np.concatenate([segments.feet[rows], one], axis=-1)
    tops = np.concatenate([segments.tops[rows], one], axis=-1)
    system = np.zeros((groups, count, 3, count + 3))
    person = np.arange(count)
    system[:, person, :, person] = np.cross(tops, feet).transpose(1, 0, 2)
    system[..., count:] = segments.lengths[rows][..., None, None] * np.cross(tops[..., None, :], -np.eye(3))
    solution = np.linalg.svd(system.reshape(groups, 3 * count, count + 3))[2][:, -1]
    solution = solution * np.where(solution[:, :count].sum(axis=1) < 0, -1.0, 1.0)[:, None]
    ahead = (solution[:, :count] > 0).all(axis=1)
    depths, vanishing, feet = solution[ahead, :count], solution[ahead, count:], feet[ahead]
    floor = np.stack([np.einsum("tni,ti->tn", feet[..., :2], vanishing[:, :2]), -1 / depths], axis=-1)
    fitted = np.linalg.pinv(floor) @ np.broadcast_to(-vanishing[:, 2, None, None], (*depths.shape, 1))
    inverse_f2, offset = np.maximum(fitted[:, 0, 0], 1e-9), fitted[:, 1, 0]
    seen = (F_RANGE[0] ** 2 < 1 / inverse_f2) & (1 / inverse_f2 < (2 * F_RANGE[1]) ** 2) & (offset < 0)
    f = 1 / np.sqrt(inverse_f2[seen])
    up = vanishing[seen] / np.column_stack([f, f, np.ones_like(f)])
    stature = np.linalg.norm(up, axis=1)
    up = up / stature[:, None]
    pitch, roll = np.arcsin(np.clip(-up[:, 2], -1, 1)), np.arctan2(up[:, 0], -up[:, 1])
    # n.X = -H with X = e K^-1 b and S n = K^-1 z gives S H = -c: so S / H = S^2 / (S H).
    nothing = np.zeros_like(f)
    return np.log(f), np.column_stack([pitch, roll, np.log(stature**2 / -offset[seen]), nothing, nothing])
