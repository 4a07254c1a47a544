"""Gravity from straight segments, the focal length known."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ...arrays import FloatArray
from ...intervals import HALF_WIDTH_SD
from ..camera import Camera
from ..mount import Mount
from .mixture import Fitted, Lines, lines_of, nothing_cost, refined
from .model import AZIMUTH, LOG_F, PRIOR, down_of
from .search import starts
from .trust import HOPELESS, trust_of

#: How many ways to hold the camera are looked at with all azimuths, and how many of all these are refined.
_TILTS, _REFINED, _FIRST_STEPS = 20, 8, 4
#: Doubts that more segments do not lessen: walls out of plumb, bent lenses, standard deviations of pitch and roll.
#: Pitch counts as York Urban's labels do: their vertical and their horizon differ by a degree in the median.
SYSTEMATIC_RAD: FloatArray = np.radians([1.0, 0.15])
#: And of pitch for each diagonal of focal length: a wall that leans sideways by a quarter of a degree converges with
#: the next as if the camera were pitched, the more so the narrower the view (`benchmarks/accuracy/long_lenses.py`).
LEANING_RAD = math.radians(0.4)
#: An explanation less probable than this is none.
TRUSTED = 0.9
#: Explanations nearer than this, in degrees of pitch and roll, and in azimuth, are one.
_SAME_RAD, _SAME_AZIMUTH = math.radians(0.3), 0.03
#: The source that a mount made of it states.
SOURCE = "straight lines"
TOO_FEW, NO_STRUCTURE = "fewer than 4 straight segments", "no straight structure that shows which way is up"


@dataclass(frozen=True, eq=False)
class Gravity:
    """Gravity as the picture's straight segments show it.

    down: unit vector in the camera frame (x right, y down, z ahead). pitch_deg: positive where the camera looks down.
    roll_deg: as in `bodies.Floor`, positive where down leans to the left of the picture. pitch_sd_deg, roll_sd_deg:
    standard deviations.
    """

    down: FloatArray
    pitch_deg: float
    roll_deg: float
    pitch_sd_deg: float
    roll_sd_deg: float

    def __str__(self) -> str:
        """What it says, with central 90 % intervals."""
        pitch, roll = (HALF_WIDTH_SD * sd for sd in (self.pitch_sd_deg, self.roll_sd_deg))
        way = "down" if self.pitch_deg >= 0 else "up"
        return (
            f"it looks {way} by {abs(self.pitch_deg):.1f} degrees (+-{pitch:.1f}), "
            f"rolled by {self.roll_deg:.1f} (+-{roll:.1f})"
        )

    def mount(self, height_of: Mount | None = None) -> Mount:
        """Return it as what is known of the camera's place; the height, if any, is that of another mount."""
        angles = np.radians([self.pitch_deg, self.roll_deg, self.pitch_sd_deg, self.roll_sd_deg]).tolist()
        height_m = math.nan if height_of is None else height_of.height_m
        sd_m = None if height_of is None else height_of.height_sd_m
        size = None if height_of is None else height_of.size_px
        return Mount.stated(
            angles[0], angles[1], height_m, pitch_sd_rad=angles[2], roll_sd_rad=angles[3], height_sd_m=sd_m,
            size_px=size, source=SOURCE,
        )  # fmt: skip


def gravity_from_lines(segments_px: ArrayLike, camera: Camera) -> Gravity | None:
    """Return gravity's direction from straight segments (N, 4), u0 v0 u1 v1 in pixels of `camera`.

    None where the segments do not show it. Up is taken to be upwards in the picture: a photo that stands on its head
    looks the same. Raises ValueError for another shape.
    """
    found = read_gravity(segments_px, camera)
    return None if isinstance(found, str) else found


def read_gravity(segments_px: ArrayLike, camera: Camera) -> Gravity | str:
    """Return gravity from straight segments (N, 4) as `gravity_from_lines` does, or why there is none."""
    diagonal = math.hypot(camera.width, camera.height)
    f_px = camera.f_px
    rays = camera.rays(checked(segments_px).reshape(-1, 2, 2))[..., :2]
    lines = lines_of(rays.reshape(-1, 4) * (f_px / diagonal))
    if len(lines.length) < 4:
        return TOO_FEW
    centre_sd = max(camera.principal_sd_px / diagonal, 1e-4)
    prior = PRIOR.with_focal(math.log(f_px / diagonal), max(camera.focal_rel_sd, 1e-3)).with_centre_sd(centre_sd)
    first = refined(lines, starts(lines, math.log(f_px / diagonal), _TILTS, _REFINED), prior, None, _FIRST_STEPS)
    if float((nothing_cost(lines) - first.marginal()).max()) < HOPELESS:
        return NO_STRUCTURE
    return _answer(lines, _once(refined(lines, first.rows, prior)))


def checked(segments_px: ArrayLike) -> FloatArray:
    """Return finite segments as an array (N, 4); raises ValueError for another shape."""
    segments = np.asarray(segments_px, dtype=float)
    if segments.ndim != 2 or segments.shape[1] != 4:
        if segments.size == 0:
            return np.zeros((0, 4))
        raise ValueError(f"segments_px has shape {segments.shape}: it must be (N, 4), u0 v0 u1 v1 each")
    return segments[np.isfinite(segments).all(axis=1)]


def _once(fit: Fitted) -> Fitted:
    """Return the hypotheses without those that came to the same answer; a quarter turn in azimuth is none."""
    kept: list[int] = []
    for k in np.argsort(fit.cost).tolist():
        tilts = np.abs(fit.rows[kept, :2] - fit.rows[k, :2])
        turn = np.abs(np.sin(2 * (fit.rows[kept, AZIMUTH] - fit.rows[k, AZIMUTH])))
        if not ((tilts < _SAME_RAD).all(axis=1) & (turn < _SAME_AZIMUTH)).any():
            kept.append(k)
    return fit.taken(np.array(kept))


def _answer(lines: Lines, fit: Fitted) -> Gravity | str:
    """Return what the hypotheses say together: their mean about the best, as far apart as they are."""
    evidence = nothing_cost(lines) - fit.marginal()
    best = int(evidence.argmax())
    weight = np.exp(evidence - evidence[best])
    total = float(weight.sum())
    covariance = np.linalg.inv(fit.hessian)[:, :2, :2]
    covariance[:, [0, 1], [0, 1]] += SYSTEMATIC_RAD**2
    covariance[:, 0, 0] += (LEANING_RAD * np.exp(fit.rows[:, LOG_F])) ** 2
    tilt = fit.rows[:, :2]
    apart = np.abs(tilt - tilt[best]) / np.sqrt(np.diagonal(covariance[best]))
    near = weight * (apart < 2).all(axis=1)
    trust = trust_of(lines, fit, float(evidence[best]) + math.log(total), best) * float(near.sum()) / total
    if trust < TRUSTED:
        return NO_STRUCTURE
    near /= near.sum()
    pitch, roll = (near @ tilt).tolist()
    about = tilt - (pitch, roll)
    spread = np.einsum("h,hij->ij", near, covariance + about[:, :, None] * about[:, None])
    pitch_sd, roll_sd = np.degrees(np.sqrt(np.diagonal(spread))).tolist()
    # the model's roll turns the other way
    return Gravity(down_of(pitch, roll), math.degrees(pitch), -math.degrees(roll), pitch_sd, roll_sd)
