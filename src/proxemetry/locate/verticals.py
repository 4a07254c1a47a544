"""People as verticals of nearly one length on one floor: where a camera shows them, and the camera solved for.

All lengths in a photo are in units of its long side, from its middle.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ..frame import frame_of
from ..keypoint_noise import people_sd_px
from ..metadata import Metadata
from ..people import People

FloatArray = NDArray[np.float64]

#: Focal lengths looked for, as parts of the long side: 9 mm to 430 mm on full frame.
F_RANGE = (0.25, 12.0)
#: Coefficient of variation of an adult's stature, sexes unknown (Bertoni et al., ICCV 2019).
STATURE_CV = 0.046
#: Standard deviation of how far a standing person's axis is off the vertical, per direction, radians.
LEAN_SD = 0.02
#: Lengths from the ankle, as parts of the stature (ANSUR II: eye height .936, acromion .821, malleolus .040).
_EYES_ABOVE_ANKLE, _SHOULDERS_ABOVE_ANKLE = 0.895, 0.775
_PRINCIPAL_SD = 0.005  # of the long side, for a photo that is no crop


@dataclass(frozen=True)
class Segments:
    """People as segments from the ankles' middle up: the photo's middle is the origin, its long side the unit.

    rows: shape (N,), rows of `people`. feet, tops: shape (N, 2). lengths: shape (N,), as parts of the stature.
    feet_sd, tops_sd: shape (N,), per axis. principal_sd: per axis. lean_sd: radians.
    """

    rows: NDArray[np.intp]
    feet: FloatArray
    tops: FloatArray
    lengths: FloatArray
    feet_sd: FloatArray
    tops_sd: FloatArray
    principal_sd: float
    long_side_px: float
    lean_sd: float = LEAN_SD

    def scattered(self, factor: float) -> Segments:
        """Return the same people with that much more lean and noise."""
        return replace(
            self, feet_sd=self.feet_sd * factor, tops_sd=self.tops_sd * factor, lean_sd=self.lean_sd * factor
        )


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
    """Tell who is not seen to be bent: shoulders, hips, knees and ankles lie nearly on a line, as far as seen."""
    straight = np.ones(len(people), dtype=bool)
    for side in ("left", "right"):
        chain = np.stack([people.joint(f"{side}_{joint}") for joint in ("shoulder", "hip", "knee", "ankle")])
        walked = np.linalg.norm(np.diff(chain, axis=0), axis=-1).sum(axis=0)
        direct = np.linalg.norm(chain[-1] - chain[0], axis=-1)
        straight &= ~(direct < 0.93 * walked)  # NaN, a joint that is not seen, is no evidence
    return straight


def _up(pitch: FloatArray, roll: FloatArray) -> FloatArray:
    """Up in the camera frame, shape (..., 3); see `bodies.Floor`."""
    return np.stack([np.sin(roll) * np.cos(pitch), -np.cos(roll) * np.cos(pitch), -np.sin(pitch)], axis=-1)


def _predicted(
    segments: Segments, log_f: FloatArray, parameters: FloatArray, feet: FloatArray, tilt: FloatArray
) -> FloatArray:
    """Return where the tops should be, shape (G, N, 2), for G focal lengths and parameters of shape (G, 5).

    Parameters: pitch, roll, log of stature over camera height, principal point. tilt: shape (2,), the lean of every
    person to the side and towards the camera, radians. With X the foot and n up, n.X = -H, so the top is at
    X + l S n, which projects like x - (l S / H) (n.x) n for the foot's ray x.
    """
    pitch, roll, log_ratio = parameters[:, 0], parameters[:, 1], parameters[:, 2]
    up = _up(pitch, roll)
    side = np.stack([np.cos(roll), np.sin(roll), np.zeros_like(roll)], axis=-1)
    axis = up + tilt[0] * side + tilt[1] * np.cross(up, side)
    f, centre = np.exp(log_f)[:, None, None], parameters[:, None, 3:5]
    rays = np.concatenate([(feet - centre) / f, np.ones((len(log_f), len(segments.rows), 1))], axis=-1)
    depth_below = np.einsum("gni,gi->gn", rays, up)
    reach = np.exp(log_ratio)[:, None] * segments.lengths * depth_below
    top = rays - reach[..., None] * axis[:, None, :]
    # A foot above the horizon or a top behind the camera is no explanation: it comes out far away, and smoothly so.
    possible = (depth_below < 0) & (top[..., 2] > 1e-3)
    return np.where(possible[..., None], centre + f * top[..., :2] / np.maximum(top[..., 2:], 1e-3), 10.0)


def residuals_of(
    segments: Segments, log_f: FloatArray, parameters: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Return residuals (G, N, 2), Jacobian (G, N, 2, 5), precision (G, N, 2, 2), log determinant of its inverse (G, N).

    The inverse of the precision has the noise of foot and top in it, lean, and how much statures differ.
    """
    step, upright, steps = 1e-5, np.zeros(2), np.eye(2) * 1e-5
    moved = np.concatenate([parameters, *(parameters + step * e for e in np.eye(5))])
    at, *by_parameter = _predicted(segments, np.tile(log_f, 6), moved, segments.feet, upright).reshape(
        6, len(log_f), -1, 2
    )
    by_foot = [_predicted(segments, log_f, parameters, segments.feet + e, upright) for e in steps]
    by_lean = [_predicted(segments, log_f, parameters, segments.feet, e) for e in steps]
    jacobian = (np.stack(by_parameter, axis=-1) - at[..., None]) / step
    spread = np.concatenate(
        [
            (np.stack(by_foot, axis=-1) - at[..., None]) * (segments.feet_sd[:, None, None] / step),
            (np.stack(by_lean, axis=-1) - at[..., None]) * (segments.lean_sd / step),
            jacobian[..., 2:3] * STATURE_CV,
        ],
        axis=-1,
    )
    covariance = spread @ np.swapaxes(spread, -1, -2) + np.eye(2) * segments.tops_sd[:, None, None] ** 2
    determinant = covariance[..., 0, 0] * covariance[..., 1, 1] - covariance[..., 0, 1] ** 2
    adjugate = covariance[..., ::-1, ::-1] * np.array([[1.0, -1.0], [-1.0, 1.0]])
    return at - segments.tops, jacobian, adjugate / determinant[..., None, None], np.log(determinant)


def distances_of(segments: Segments, log_f: float, parameters: FloatArray) -> FloatArray:
    """Return everybody's squared Mahalanobis distance from where one camera would show them, shape (N,)."""
    residual, _, precision, _ = residuals_of(segments, np.array([log_f]), parameters[None])
    return mahalanobis(residual, precision)[0]


def mahalanobis(residual: FloatArray, precision: FloatArray) -> FloatArray:
    """Return the squared Mahalanobis distances, shape (G, N), of residuals (G, N, 2)."""
    return np.einsum("gni,gnij,gnj->gn", residual, precision, residual)


def direct_solution(segments: Segments, rows: NDArray[np.intp]) -> tuple[float, FloatArray] | None:
    """Solve for the camera from a few people of one stature, linearly; None where they leave no camera.

    Each top is where the foot's point and the vertical vanishing point z mix: d t = e b + l z, with e the foot's
    depth in statures (Fei et al., ICCV 2021). t x (e b + l z) = 0 is linear in z and all e. The floor then says
    z_1 b_1 / f^2 + z_2 b_2 / f^2 + z_3 = c / e, which is linear in 1 / f^2 and c.
    """
    count = len(rows)
    feet = np.column_stack([segments.feet[rows], np.ones(count)])
    tops = np.column_stack([segments.tops[rows], np.ones(count)])
    system = np.zeros((3 * count, count + 3))
    for i in range(count):
        system[3 * i : 3 * i + 3, i] = np.cross(tops[i], feet[i])
        system[3 * i : 3 * i + 3, count:] = segments.lengths[rows[i]] * _cross_matrix(tops[i])
    solution = np.linalg.svd(system)[2][-1]
    depths, vanishing = solution[:count], solution[count:]
    if depths.sum() < 0:
        depths, vanishing = -depths, -vanishing
    if (depths <= 0).any():
        return None
    floor = np.column_stack([feet[:, :2] @ vanishing[:2], -1 / depths])
    inverse_f2, offset = np.linalg.lstsq(floor, np.full(count, -vanishing[2]), rcond=None)[0]
    if not F_RANGE[0] ** 2 < 1 / max(inverse_f2, 1e-9) < (2 * F_RANGE[1]) ** 2 or offset >= 0:
        return None
    f = 1 / math.sqrt(inverse_f2)
    up = vanishing / (f, f, 1.0)
    stature = float(np.linalg.norm(up))
    up = up / stature
    pitch, roll = math.asin(np.clip(-up[2], -1, 1)), math.atan2(up[0], -up[1])
    # n.X = -H with X = e K^-1 b and S n = K^-1 z gives S H = -c: so S / H = S^2 / (S H).
    return math.log(f), np.array([pitch, roll, math.log(stature**2 / -offset), 0.0, 0.0])


def _cross_matrix(a: FloatArray) -> FloatArray:
    return np.array([[0.0, -a[2], a[1]], [a[2], 0.0, -a[0]], [-a[1], a[0], 0.0]])
