"""The focal length from straight segments: right angles fix it, where two directions vanish in the picture."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ...arrays import FloatArray
from .gravity import TOO_FEW, checked
from .mixture import Fitted, lines_of, nothing_cost, refined
from .model import AZIMUTH, CENTRE, LOG_F, N_PARAMETERS, PITCH, PRIOR, SKEW, Prior
from .search import starts
from .trust import HOPELESS, trust_of

#: Focal lengths of the profile, in diagonals: 12 to 350 mm on the 36 x 24 mm frame. Every third is started from tables.
_GRID: FloatArray = np.log(np.geomspace(0.28, 8.0, 16))
_STARTED = _GRID[1::3]
_TILTS, _REFINED, _FIRST_STEPS, _ROUGH_STEPS = 8, 6, 4, 3
#: So many explanations are followed through all focal lengths; nearer ones are the same.
_WAYS, _SAME_RAD, _SAME_LOG_F = 4, math.radians(2.0), 0.2
#: Around the likeliest, steps this fine.
_FINE: FloatArray = np.linspace(-0.3, 0.3, 11)
#: What alone would be expected of a photo, log diagonals: 35 mm within a factor of two, so that nearly flat evidence
#: does not run to the ends of the grid. The photo's own prior takes its place where everything is weighed together.
WEAK_PRIOR = (math.log(35 / 43.267), 0.7)
#: An explanation less probable than this is none: a wrong one costs more here than in gravity, which people contradict.
TRUSTED = 0.95
#: 90 % intervals of log f wider than this say hardly more than that it is a photo.
WIDEST = 0.6
#: A level direction of fewer independent segments than this does not count.
_SECOND = 1.5
#: A few walls may all be out of true, which more segments on them do not reveal: this further uncertainty of log f
#: (synthetic scenes of odd walls, `benchmarks/accuracy/picture_lines.py`) where one level direction is alone, or where
#: the log evidence is less than this; it falls off with the square of more (York Urban's median is 66).
_DOUBT_SD, _MUCH = 0.08, 30.0
OPEN = "the lines leave the focal length open"
NO_STRUCTURE = "no straight structure that shows the focal length"
ONE_DIRECTION = "level lines run along one direction alone"


@dataclass(frozen=True)
class FocalFromLines:
    """The focal length as the picture's straight segments show it: median and central 90 % interval, pixels."""

    focal_px: float
    low_px: float
    high_px: float


@dataclass(frozen=True, eq=False)
class FocalProfile:
    """How probable segments make every focal length: log f in diagonals, rising, and the log likelihood, both (G,).

    trust: the probability that what they show is gravity's frame; the likelihood counts with that. one_direction:
    whether level lines run along one direction alone, so that a level camera's focal length stays open.
    """

    log_f: FloatArray
    log_likelihood: FloatArray
    trust: float
    one_direction: bool

    def at(self, log_f: FloatArray) -> FloatArray:
        """Return the log likelihood of log focal lengths in diagonals; what is outside the profile is as its end."""
        return np.interp(log_f, self.log_f, self.log_likelihood)

    def quantiles(self, mean: float, sd: float) -> tuple[float, float, float]:
        """Return the 5th, 50th and 95th percentile of log f, given a normal prior."""
        dense = np.linspace(self.log_f[0], self.log_f[-1], 801)
        log = self.at(dense) - 0.5 * ((dense - mean) / sd) ** 2
        density = np.exp(log - log.max())
        cumulative = np.append(0.0, np.cumsum((density[1:] + density[:-1]) / 2))
        low, middle, high = np.interp([0.05, 0.5, 0.95], cumulative / cumulative[-1], dense)
        return float(low), float(middle), float(high)


def focal_from_lines(segments_px: ArrayLike, width: int, height: int) -> FocalFromLines | None:
    """Return the focal length from straight segments (N, 4), u0 v0 u1 v1 in pixels of a photo of `width` x `height`.

    None where the segments do not show it: no straight structure, one direction alone, or an interval too wide to be of
    use. Raises ValueError for another shape.
    """
    found = read_focal(segments_px, width, height)
    return None if isinstance(found, str) else found


def read_focal(segments_px: ArrayLike, width: int, height: int) -> FocalFromLines | str:
    """Return the focal length from straight segments as `focal_from_lines` does, or why there is none."""
    profile = focal_profile(segments_px, width, height)
    if isinstance(profile, str):
        return profile
    if profile.trust < TRUSTED:
        return NO_STRUCTURE
    low, middle, high = profile.quantiles(*WEAK_PRIOR)
    if high - low > WIDEST:
        return ONE_DIRECTION if profile.one_direction else OPEN
    diagonal = math.hypot(width, height)
    return FocalFromLines(*(math.exp(value) * diagonal for value in (middle, low, high)))


def focal_profile(
    segments_px: ArrayLike, width: int, height: int, centre_sd_px: float = 0.0
) -> FocalProfile | str:  # fmt: skip
    """Return how probable straight segments (N, 4) make every focal length, or why they do not.

    centre_sd_px: how far the principal point may be from the middle, beyond what it is in any photo.
    """
    diagonal = math.hypot(width, height)
    ends = checked(segments_px).reshape(-1, 2, 2) - (width / 2, height / 2)
    lines = lines_of(ends.reshape(-1, 4) / diagonal)
    if len(lines.length) < 4:
        return TOO_FEW
    usual = float(PRIOR.sd[CENTRE][0])
    prior = PRIOR.with_centre_sd(math.hypot(usual, centre_sd_px / diagonal))
    rows = np.concatenate([starts(lines, value, _TILTS, _REFINED) for value in _STARTED.tolist()])
    first = refined(lines, rows, prior, None, _FIRST_STEPS)
    if float((nothing_cost(lines) - first.marginal()).max()) < HOPELESS:
        return NO_STRUCTURE
    # each of the best explanations is followed through all focal lengths
    ways = first.rows[_distinct(first)]
    begin = _moved(ways[None], _GRID[:, None])
    rough = refined(lines, begin.reshape(-1, N_PARAMETERS), prior, LOG_F, _ROUGH_STEPS)
    leading = rough.cost.reshape(len(_GRID), -1).argmin(axis=1) + np.arange(len(_GRID)) * len(ways)
    coarse = refined(lines, rough.rows[leading], prior, LOG_F)
    cost, kept = _without_focal(coarse, prior), coarse.rows
    # in small steps around the likeliest: from its horizon, and from the next in the first profile
    best = int(cost.argmin())
    fine = _GRID[best] + _FINE
    own, next_to = _moved(kept[[best]], fine), _moved(kept[np.abs(_GRID - fine[:, None]).argmin(axis=1)], fine)
    finer = refined(lines, np.concatenate([own, next_to]), prior, LOG_F)
    fine_cost = _without_focal(finer, prior)
    outside = np.abs(_GRID - _GRID[best]) > _FINE[-1]
    log_f = np.concatenate([_GRID[outside], fine])
    lowest = np.concatenate([cost[outside], fine_cost.reshape(2, -1).min(axis=0)])
    order = np.argsort(log_f)
    log_f, log = log_f[order], nothing_cost(lines) - lowest[order]
    evidence, likeliest = _evidence(log_f, log), int(fine_cost.argmin())
    one_direction = bool(finer.support(lines)[likeliest, 1:].min() < _SECOND)
    doubt = 1.0 if one_direction else min(1.0, (_MUCH / max(evidence, 1.0)) ** 2)
    log = _blurred(log_f, log, _DOUBT_SD * doubt)
    return FocalProfile(log_f, log, trust_of(lines, finer, evidence, likeliest), one_direction)


def _blurred(log_f: FloatArray, log: FloatArray, sd: float) -> FloatArray:
    """Return a log likelihood (G,) with a further doubt of log f."""
    weight = np.exp(-0.5 * ((log_f[:, None] - log_f) / sd) ** 2) * np.gradient(log_f)
    return np.log(weight @ np.exp(log - log.max()) / weight.sum(axis=1)) + log.max()


def _moved(rows: FloatArray, log_f: FloatArray) -> FloatArray:
    """Return hypotheses (..., 9) with other focal lengths (...): lines vanish where they did, as far as they can."""
    moved = np.broadcast_to(rows, (*np.broadcast_shapes(rows.shape[:-1], log_f.shape), rows.shape[-1])).copy()
    ratio = np.exp(log_f - rows[..., LOG_F])
    moved[..., PITCH] = np.arctan(np.tan(rows[..., PITCH]) * ratio)
    first, second = rows[..., AZIMUTH], rows[..., AZIMUTH] + rows[..., SKEW] + math.pi / 2
    first, second = (np.arctan2(np.sin(turn), np.cos(turn) * ratio) for turn in (first, second))
    moved[..., AZIMUTH], moved[..., SKEW] = first, np.mod(second - first, math.pi) - math.pi / 2
    moved[..., LOG_F] = log_f
    return moved


def _distinct(fit: Fitted) -> list[int]:
    """Return the best hypotheses, no two of one way to stand to the walls."""
    kept: list[int] = []
    for k in np.argsort(fit.cost).tolist():
        apart = np.abs(fit.rows[kept] - fit.rows[k])
        turn = np.abs(np.sin(2 * apart[:, AZIMUTH]))
        same = (apart[:, PITCH] < _SAME_RAD) & (apart[:, LOG_F] < _SAME_LOG_F) & (turn < 2 * _SAME_RAD)
        if not same.any():
            kept.append(k)
    return kept[:_WAYS]


def _without_focal(fit: Fitted, prior: Prior) -> FloatArray:
    """Return the negative log evidence (H,) of each focal length, which its own prior is no part of."""
    return fit.marginal(LOG_F) - prior.costs(fit.rows)[:, LOG_F]


def _evidence(log_f: FloatArray, log: FloatArray) -> float:
    """Return the log evidence of straight structure, all focal lengths together."""
    mean, sd = WEAK_PRIOR
    dense = np.linspace(log_f[0], log_f[-1], 401)
    weighed = np.interp(dense, log_f, log) - 0.5 * ((dense - mean) / sd) ** 2
    step = float(dense[1] - dense[0]) / (sd * math.sqrt(2 * math.pi))
    return float(weighed.max()) + math.log(float(np.exp(weighed - weighed.max()).sum()) * step)
