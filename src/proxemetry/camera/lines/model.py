"""A camera among straight things: one vertical and two horizontal directions, and where they vanish in the picture.

Lengths are in diagonals of the picture from its middle (or from a known principal point), so that the picture's size
does not matter. A hypothesis is a row of `N_PARAMETERS` numbers: the camera's pitch (positive looking down) and roll
(positive where down leans to the right), radians; the log of its focal length in diagonals; the azimuth of the first
horizontal direction; how far the second is from being at right angles to it, radians; how far both slope (2, positive
downwards), since streets do; and the principal point's shift (2).
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ...arrays import FloatArray

PITCH, ROLL, LOG_F, AZIMUTH, SKEW, SLOPE, CENTRE = 0, 1, 2, 3, 4, slice(5, 7), slice(7, 9)
N_PARAMETERS = 9
#: The vertical and the two horizontals.
N_DIRECTIONS = 3


def log_peak(tail: float) -> float:
    """Return the log density of Student's t at its middle, in units of its scale; inf is the normal distribution."""
    if not math.isfinite(tail):
        return -0.5 * math.log(2 * math.pi)
    return math.lgamma((tail + 1) / 2) - math.lgamma(tail / 2) - 0.5 * math.log(tail * math.pi)


#: The density of skews, per radian, of walls at any angle.
_ANY_ANGLE = 2 / math.pi


@dataclass(frozen=True, eq=False)
class Prior:
    """What is known of the parameters beforehand: Student's t, each with its own tails (inf: normal), shape (9,).

    odd: the probability that walls are at any angle to one another instead, up to half a right angle off.
    """

    mean: FloatArray
    sd: FloatArray
    tail: FloatArray
    odd: float

    def costs(self, rows: FloatArray) -> FloatArray:
        """Return the negative log density of each parameter of rows (H, 9), (H, 9)."""
        z2 = ((rows - self.mean) / self.sd) ** 2
        heavy = np.isfinite(self.tail)
        tail = np.where(heavy, self.tail, 1.0)
        costs = np.where(heavy, (tail + 1) / 2 * np.log1p(z2 / tail), z2 / 2) + np.log(self.sd) - self._peaks
        costs[:, SKEW] = -np.log((1 - self.odd) * np.exp(-costs[:, SKEW]) + self.odd * _ANY_ANGLE)
        return costs

    def pull(self, rows: FloatArray, costs: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return precision and slope of the cost, both (H, 9), reweighted; costs: those of the rows."""
        away = rows - self.mean
        heavy = np.isfinite(self.tail)
        tail = np.where(heavy, self.tail, 1.0)
        weight = np.where(heavy, (tail + 1) / (tail + (away / self.sd) ** 2), 1.0)
        precision = weight / self.sd**2
        # a skew counts as far as the walls are held for being at right angles
        precision[:, SKEW] *= 1 - self.odd * _ANY_ANGLE * np.exp(costs[:, SKEW])
        return precision, precision * away

    @cached_property
    def _peaks(self) -> FloatArray:
        return np.array([log_peak(tail) for tail in self.tail])

    def with_focal(self, log_f: float, sd: float) -> Prior:
        """Return the prior with a known log focal length in diagonals."""
        mean, sds = self.mean.copy(), self.sd.copy()
        mean[LOG_F], sds[LOG_F] = log_f, sd
        return replace(self, mean=mean, sd=sds)

    def with_centre_sd(self, sd: float) -> Prior:
        """Return the prior with another doubt about the principal point, in diagonals."""
        sds = self.sd.copy()
        sds[CENTRE] = sd
        return replace(self, sd=sds)


#: Photographers hold cameras about level, mostly, and roll them less than they pitch them. Buildings have right angles,
#: mostly (Cauchy's tails: one in five pairs of walls is more than 2 degrees off), and streets slope by a degree. The
#: principal point of an uncropped picture lies within a percent of the diagonal from its middle.
PRIOR = Prior(
    mean=np.zeros(N_PARAMETERS),
    sd=np.array([*np.radians([10.0, 1.5]), 10.0, math.pi / 2, *np.radians([1.0, 0.7, 0.7]), 0.008, 0.008]),
    tail=np.array([1.0, 1.5, np.inf, np.inf, 1.0, 2.0, 2.0, np.inf, np.inf]),
    odd=0.1,
)


def down_of(pitch_rad: float, roll_rad: float) -> FloatArray:
    """Return gravity's direction in the camera frame, a unit vector."""
    return _axes(np.array([[pitch_rad, roll_rad]]))[0][0]


def _axes(tilt: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return down, right and ahead in the camera frame, (H, 3) each: the world's axes at azimuth 0."""
    (sp, sr), (cp, cr) = np.sin(tilt).T, np.cos(tilt).T
    down = np.stack([sr * cp, cr * cp, sp], axis=1)
    right = np.stack([cr, -sr, 0 * sr], axis=1)
    ahead = np.stack([-sr * sp, -cr * sp, cp], axis=1)
    return down, right, ahead


def directions(rows: FloatArray) -> FloatArray:
    """Return the vertical and the horizontals, (H, 3, 3: direction, axis)."""
    down, right, ahead = _axes(rows[:, :2])
    result = np.empty((len(rows), N_DIRECTIONS, 3))
    result[:, 0] = down
    for k, turn in enumerate(_turns(rows), 1):
        slope = rows[:, SLOPE][:, k - 1, None]
        result[:, k] = np.sin(turn)[:, None] * right + np.cos(turn)[:, None] * ahead + slope * down
    return result


def _turns(rows: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the azimuths of both horizontals, (H,) each."""
    return rows[:, AZIMUTH], rows[:, AZIMUTH] + rows[:, SKEW] + math.pi / 2


def directions_with_slopes(rows: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the vertical and the horizontals (H, 3, 3: direction, axis), and their derivatives (H, 3, 3, 7).

    These are by all parameters up to the slopes; by the focal length they are zero.
    """
    down, right, ahead = _axes(rows[:, :2])
    sr, cr = np.sin(rows[:, ROLL]), np.cos(rows[:, ROLL])
    right_by_roll = np.stack([-sr, -cr, 0 * sr], axis=1)
    down_by_roll = np.cos(rows[:, PITCH])[:, None] * right
    ahead_by_roll = -np.sin(rows[:, PITCH])[:, None] * right
    result = np.empty((len(rows), N_DIRECTIONS, 3))
    by = np.zeros((len(rows), N_DIRECTIONS, 3, CENTRE.start))
    result[:, 0], by[:, 0, :, PITCH], by[:, 0, :, ROLL] = down, ahead, down_by_roll
    for k, turn in enumerate(_turns(rows), 1):
        sine, cosine = np.sin(turn)[:, None], np.cos(turn)[:, None]
        slope = rows[:, SLOPE][:, k - 1, None]
        result[:, k] = sine * right + cosine * ahead + slope * down
        by[:, k, :, PITCH] = slope * ahead - cosine * down
        by[:, k, :, ROLL] = sine * right_by_roll + cosine * ahead_by_roll + slope * down_by_roll
        by[:, k, :, AZIMUTH] = cosine * right - sine * ahead
        by[:, k, :, SLOPE.start + k - 1] = down
    by[:, 2, :, SKEW] = by[:, 2, :, AZIMUTH]
    return result, by


def vanishing_points(rows: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the homogeneous vanishing points (H, 3, 3), unit vectors, and their derivatives (H, 3, 3, 9).

    A direction d vanishes at (f d_x + c_x d_z, f d_y + c_y d_z, d_z).
    """
    d, by = directions_with_slopes(rows)
    f = np.exp(rows[:, LOG_F])[:, None]
    centre = rows[:, CENTRE]
    v = np.empty_like(d)
    v[..., :2] = f[..., None] * d[..., :2] + centre[:, None] * d[..., 2:]
    v[..., 2] = d[..., 2]
    slope = np.zeros((*d.shape, N_PARAMETERS))
    slope[..., :2, : CENTRE.start] = f[..., None, None] * by[..., :2, :] + centre[:, None, :, None] * by[..., 2:, :]
    slope[..., 2, : CENTRE.start] = by[..., 2, :]
    slope[..., :2, LOG_F] = f[..., None] * d[..., :2]
    slope[..., 0, CENTRE.start] = slope[..., 1, CENTRE.start + 1] = d[..., 2]
    # a vanishing point's scale moves nothing
    size = np.linalg.norm(v, axis=-1, keepdims=True)
    v /= size
    slope /= size[..., None]
    slope -= v[..., None] * (v[..., None, :] @ slope)
    return v, slope
