"""Which segments run along which direction: the likelihood of hypotheses, and many of them refined at once.

A segment on the line n, of unit normal, strays from a vanishing point v by the angle n . v / |v_xy - m v_z|, seen from
its middle m (its sine, to be exact). It belongs to one of the directions, with Student's t about zero, or to clutter.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ...arrays import FloatArray, SingleArray
from .model import LOG_F, N_DIRECTIONS, N_PARAMETERS, SLOPE, Prior, log_peak, vanishing_points

#: A segment's angle is uncertain by its ends' noise (diagonals: 0.8 px of 640 x 480) over its length, and by what is
#: not quite straight or parallel in the world, radians, as York Urban's segments are about their labelled vanishing
#: points. Tails are heavy (degrees of freedom; the code below takes the density's power for granted).
_END_NOISE, _STRAY_RAD, _TAIL = 0.0010, math.radians(0.35), 3.0
_PEAK = math.exp(log_peak(_TAIL))
#: Segments are not independent (both edges of a frame, pieces of one line, all windows of one wall): one of `_FULL`
#: diagonals counts for this part of one, longer ones for half as much again, a picture for `_MOST_WORTH` at most.
_WORTH, _FULL, _MOST_WORTH = 0.25, 0.05, 60.0
#: What lies close together is one thing: cells to a diagonal, and what a cell's segments are worth at most.
_CELLS, _MOST_A_CELL = 6, 6.0
#: Segments beyond this many, the shortest, are left out.
_MOST_SEGMENTS = 200
#: Clutter runs anywhere, roughly upright, or roughly level (trees, limbs, slopes).
_ROUGH_SD_RAD = math.radians(9.0)
#: Pseudo-counts of the shares of clutter (anywhere, upright, level) and of the directions.
_SHARES: FloatArray = np.array([3.0, 1.5, 1.5, 1.5, 1.5, 1.5])
N_CLUTTER = 3
_STEPS, _IDLE = 12, 1e-2


@dataclass(frozen=True, eq=False)
class Lines:
    """N segments as lines: normal (N, 3), homogeneous with unit normals; middle (N, 2); length, sd_rad, worth: (N,).

    In single precision: their ends are known to 0.001, and half the memory is half the time.

    clutter (3, N) is the density of the segment's angle, per radian, where it belongs to no direction. worth is how
    many independent segments it counts for.
    """

    normal: SingleArray
    middle: SingleArray
    length: SingleArray
    sd_rad: SingleArray
    clutter: SingleArray
    worth: SingleArray

    @cached_property
    def products(self) -> SingleArray:
        """Products of the normals' elements, (N, 9)."""
        return (self.normal[:, :, None] * self.normal[:, None]).reshape(-1, 9)

    @property
    def count(self) -> float:
        """How many independent segments these count for."""
        return float(self.worth.sum())

    def longest(self, count: int) -> Lines:
        """Return the `count` longest segments."""
        kept = np.sort(np.argsort(-self.length, kind="stable")[:count])
        return Lines(
            self.normal[kept], self.middle[kept], self.length[kept], self.sd_rad[kept], self.clutter[:, kept],
            self.worth[kept],
        )  # fmt: skip


def lines_of(segments: FloatArray) -> Lines:
    """Return segments (N, 4) in diagonals from the principal point as lines."""
    ends = segments.reshape(-1, 2, 2)
    length = np.hypot(*(ends[:, 1] - ends[:, 0]).T)
    kept = np.sort(np.argsort(-length, kind="stable")[:_MOST_SEGMENTS])
    kept = kept[length[kept] > 0]
    ends, length = ends[kept], length[kept]
    along = (ends[:, 1] - ends[:, 0]) / length[:, None]
    middle = ends.mean(axis=1)
    normal = np.stack([along[:, 1], -along[:, 0]], axis=1)
    normal = np.column_stack([normal, -(normal * middle).sum(axis=1)])
    angle = np.arctan2(along[:, 1], along[:, 0])
    anywhere = np.full(len(length), 1 / math.pi)
    clutter = np.stack([anywhere, _rough(angle - math.pi / 2), _rough(angle)])
    sd_rad, worth = np.hypot(_END_NOISE / length, _STRAY_RAD), _worth(middle, length)
    return Lines(*(a.astype(np.float32) for a in (normal, middle, length, sd_rad, clutter, worth)))


def _rough(angle: FloatArray) -> FloatArray:
    """Return the density, per radian, of undirected angles that are roughly zero."""
    near = (angle + math.pi / 2) % math.pi - math.pi / 2
    return np.exp(-0.5 * (near / _ROUGH_SD_RAD) ** 2) / (_ROUGH_SD_RAD * math.sqrt(2 * math.pi))


def _worth(middle: FloatArray, length: FloatArray) -> FloatArray:
    worth = _WORTH * np.minimum(length / _FULL, 1.5)
    cell = (np.floor((middle + 0.5) * _CELLS).clip(0, _CELLS - 1) @ (1, _CELLS)).astype(int)
    crowd = np.bincount(cell, worth, _CELLS**2)
    worth = worth * np.minimum(1.0, _MOST_A_CELL / np.maximum(crowd, 1e-9))[cell]
    return worth * min(1.0, _MOST_WORTH / max(float(worth.sum()), 1e-9))


def strays(lines: Lines, v: FloatArray | SingleArray) -> tuple[SingleArray, SingleArray]:
    """Return the sines of the angles between segments and vanishing points v (..., 3), and the distances: (..., N)."""
    across, away2 = across_and_away2(lines, v)
    away = np.sqrt(away2, out=away2)
    across /= away
    return across, away


def across_and_away2(lines: Lines, v: FloatArray | SingleArray) -> tuple[SingleArray, SingleArray]:
    """Return how far vanishing points v (..., 3) lie from lines, and the squared distances from middles, (..., N).

    Both are times v_z, and the distance is at least 1e-6, so that a sine is there in any case.
    """
    v = v.astype(np.float32)
    across = v @ lines.normal.T
    dx = v[..., :1] - v[..., 2:] * lines.middle[:, 0]
    dy = v[..., 1:2] - v[..., 2:] * lines.middle[:, 1]
    dx *= dx
    dy *= dy
    dx += dy
    return across, np.maximum(dx, 1e-12, out=dx)


def nothing_cost(lines: Lines) -> float:
    """Return the cost of a picture of clutter alone."""
    counts = _SHARES[:N_CLUTTER]
    shares = counts / counts.sum()
    for _ in range(12):
        parts = shares[:, None] * lines.clutter
        members = (parts / parts.sum(axis=0)) @ lines.worth + counts - 1
        shares = members / members.sum()
    return -float(lines.worth @ np.log(shares @ lines.clutter) + (counts - 1) @ np.log(shares))


@dataclass(frozen=True, eq=False)
class Fitted:
    """Refined hypotheses: rows (H, 9), shares (H, 6) of clutter and directions, cost (H,), hessian (H, 9, 9)."""

    rows: FloatArray
    shares: FloatArray
    cost: FloatArray
    hessian: FloatArray

    def taken(self, index: NDArray[np.intp]) -> Fitted:
        """Return some of the hypotheses."""
        return Fitted(self.rows[index], self.shares[index], self.cost[index], self.hessian[index])

    def support(self, lines: Lines) -> FloatArray:
        """Return how many independent segments run along each direction, (H, 3)."""
        return self.shares[:, N_CLUTTER:] * lines.count

    def where(self, chosen: NDArray[np.bool_], other: Fitted) -> Fitted:
        """Return these where chosen (H,), the others elsewhere."""
        pick = chosen[:, None]
        return Fitted(
            np.where(pick, self.rows, other.rows), np.where(pick, self.shares, other.shares),
            np.where(chosen, self.cost, other.cost), np.where(pick[..., None], self.hessian, other.hessian),
        )  # fmt: skip

    def marginal(self, fixed: int | None = None) -> FloatArray:
        """Return the negative log evidence (H,): parameters, all but `fixed`, integrated out by Laplace's method."""
        kept = [k for k in range(N_PARAMETERS) if k != fixed]
        log_det = np.linalg.slogdet(self.hessian[:, kept][:, :, kept])[1]
        return self.cost + log_det / 2 - len(kept) / 2 * math.log(2 * math.pi)


def evaluate(lines: Lines, rows: FloatArray, shares: FloatArray, prior: Prior) -> tuple[Fitted, FloatArray, FloatArray]:
    """Return hypotheses as they are, with the slope (H, 9) of their cost, and the shares (H, 6) that would suit better.

    The hessian is Gauss and Newton's, reweighted by which direction each segment belongs to.
    """
    v, by = vanishing_points(rows)
    stray, away = strays(lines, v)
    heavy = stray / (lines.sd_rad * math.sqrt(_TAIL))
    heavy *= heavy
    heavy += 1
    single = shares.astype(np.float32)
    parts = single[:, N_CLUTTER:, None] * (_PEAK / lines.sd_rad)
    parts /= heavy * heavy
    total = parts.sum(axis=1) + single[:, :N_CLUTTER] @ lines.clutter
    of_prior = prior.costs(rows)
    cost = -(np.log(total) @ lines.worth) - ((_SHARES - 1) * np.log(shares)).sum(axis=1) + of_prior.sum(axis=1)
    per_total = lines.worth / total
    belongs = parts * per_total[:, None]
    # d stray / d parameter = n . dv / away: the segments add up before the parameters are looked at
    heavy *= away
    pull = belongs * ((_TAIL + 1) / _TAIL / lines.sd_rad**2)
    pull /= heavy
    slope = ((pull * stray) @ lines.normal).astype(float)[:, :, None] @ by
    pull /= away
    squares = (pull @ lines.products).astype(float).reshape(-1, N_DIRECTIONS, 3, 3)
    hessian = (by.swapaxes(-1, -2) @ squares @ by).sum(axis=1)
    precision, prior_slope = prior.pull(rows, of_prior)
    hessian[:, np.arange(N_PARAMETERS), np.arange(N_PARAMETERS)] += precision
    clutter = shares[:, :N_CLUTTER] * (per_total @ lines.clutter.T)
    better = np.concatenate([clutter, belongs.sum(axis=2)], axis=1) + _SHARES - 1
    better /= better.sum(axis=1, keepdims=True)
    return Fitted(rows, shares, cost, hessian), slope.sum(axis=1)[:, 0] + prior_slope, better


def refined(lines: Lines, rows: FloatArray, prior: Prior, held: int | None = None, steps: int = _STEPS) -> Fitted:
    """Return hypotheses (H, 9) after damped Gauss-Newton steps; the parameter `held` stays as it is."""
    shares = np.tile(_SHARES / _SHARES.sum(), (len(rows), 1))
    now, slope, better = evaluate(lines, rows, shares, prior)
    damping = np.full(len(rows), 1e-2)
    most = np.full(N_PARAMETERS, 0.1)
    most[:2], most[LOG_F : SLOPE.stop] = 0.2, 0.3
    fixed = np.diag([1e12 if k == held else 0.0 for k in range(N_PARAMETERS)])
    for _ in range(steps):
        damped = now.hessian * (1 + damping[:, None, None] * np.eye(N_PARAMETERS)) + fixed
        step = np.clip(np.linalg.solve(damped, slope[..., None])[..., 0], -most, most)
        trial, trial_slope, trial_better = evaluate(lines, now.rows - step, better, prior)
        down = trial.cost < now.cost
        moved = np.abs(trial.cost - now.cost)
        now = trial.where(down, now)
        slope, better = np.where(down[:, None], trial_slope, slope), np.where(down[:, None], trial_better, better)
        damping = np.where(down, np.maximum(damping / 5, 1e-6), damping * 8)
        # what is much less likely than the best may still be on its way
        if (moved * np.exp((now.cost.min() - now.cost) / 2)).max() < _IDLE:
            break
    return now
