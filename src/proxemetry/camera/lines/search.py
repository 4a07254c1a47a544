"""Where to begin: a coarse look at every pitch, roll and azimuth, by the longest segments."""

from __future__ import annotations

import math

import numpy as np

from ...arrays import FloatArray, SingleArray
from .mixture import Lines, across_and_away2
from .model import AZIMUTH, LOG_F, N_PARAMETERS, PITCH, PRIOR, ROLL, directions

_PITCHES = np.radians(np.concatenate([np.arange(-72.0, -30, 6), np.arange(-30.0, 30.1, 3), np.arange(36.0, 73, 6)]))
_ROLLS = np.radians([-42.0, -34, -26, -18, -11, -6, -3, 0, 3, 6, 11, 18, 26, 34, 42])
_AZIMUTHS = np.radians(np.arange(0.0, 90.0, 4.0))
#: Half a cell of the tables, by which the segments' own spread is widened; and what makes another cell, in pitch, roll
#: and azimuth.
_CELL_RAD = math.radians(1.6)
_APART = np.radians([4.5, 4.5, 9.0])
#: Shares of clutter and of each direction, and of the kinds of clutter.
_CLUTTER, _DIRECTION, _KINDS = 0.4, 0.2, np.array([0.5, 0.25, 0.25], dtype=np.float32)
_LONGEST = 60


#: Every pitch and roll of the tables, (T, 9), which way is down in each, and what the prior has against it.
_HELD = np.zeros((len(_PITCHES) * len(_ROLLS), N_PARAMETERS))
_HELD[:, PITCH], _HELD[:, ROLL] = np.repeat(_PITCHES, len(_ROLLS)), np.tile(_ROLLS, len(_PITCHES))
_DOWN: FloatArray = directions(_HELD)[:, 0]
_HELD_COST: FloatArray = PRIOR.costs(_HELD)[:, [PITCH, ROLL]].sum(axis=1)


def starts(lines: Lines, log_f: float, tilts: int, count: int) -> FloatArray:
    """Return hypotheses (count, 9), the likeliest of the tables at a focal length in diagonals.

    tilts: for how many ways to hold the camera all azimuths are looked at.
    """
    few = lines.longest(_LONGEST)
    clutter = _KINDS @ few.clutter
    upright = _DIRECTION * _along(few, _DOWN, log_f)
    cost = _HELD_COST - np.log(upright + (1 - _DIRECTION) * clutter) @ few.worth
    best = np.argpartition(cost, tilts)[:tilts]
    every = np.repeat(_HELD[best], len(_AZIMUTHS), axis=0)
    every[:, AZIMUTH], every[:, LOG_F] = np.tile(_AZIMUTHS, len(best)), log_f
    level = _DIRECTION * _along(few, directions(every)[:, 1:], log_f).sum(axis=1)
    total = np.repeat(upright[best] + _CLUTTER * clutter, len(_AZIMUTHS), axis=0) + level
    return _distinct(every, np.repeat(_HELD_COST[best], len(_AZIMUTHS)) - np.log(total) @ few.worth, count)


def _along(lines: Lines, d: FloatArray, log_f: float) -> SingleArray:
    """Return the density of segments along directions d (..., 3), (..., N), as blurred as the tables are coarse."""
    f = math.exp(log_f)
    blurred = lines.sd_rad + np.float32(_CELL_RAD)
    across, away2 = across_and_away2(lines, d * (f, f, 1.0))
    across *= across
    away2 *= blurred * blurred
    across /= away2  # the square of how many deviations the line is off
    across += 1
    across *= np.sqrt(across)
    across *= blurred / np.float32(0.55)
    return np.reciprocal(across, out=across)


def _distinct(rows: FloatArray, cost: FloatArray, count: int) -> FloatArray:
    """Return the best rows, no two of one cell; the best again where there are too few."""
    order = np.argsort(cost)[: 40 * count]
    places = rows[order][:, [PITCH, ROLL, AZIMUTH]]
    left = np.ones(len(order), dtype=bool)
    chosen: list[int] = []
    while left.any() and len(chosen) < count:
        at = int(left.argmax())
        chosen.append(at)
        left &= (np.abs(places - places[at]) >= _APART).any(axis=1)
    return rows[order[(chosen * count)[:count]]]
