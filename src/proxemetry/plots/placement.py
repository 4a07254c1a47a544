"""Where labels go: each beside what it names, off people where there is room, none over another."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..arrays import FloatArray

_ALONG = (0.5, 0.42, 0.58, 0.34, 0.66, 0.26, 0.74)
_RINGS = 9
#: How many candidates a ring of `along` and of `around` has.
RING = len(_ALONG)
_GRID = 40


@dataclass(frozen=True)
class Obstacles:
    """What labels should not cover: rectangles x0, y0, x1, y1, shape (m, 4), and what covering each costs, shape (m,).

    A label that lies wholly on a rectangle of cost c goes up to c of its own heights out of its way to leave it.
    """

    boxes: FloatArray
    costs: FloatArray

    @classmethod
    def none(cls) -> Obstacles:
        """Return no obstacles."""
        return cls(np.zeros((0, 4)), np.zeros(0))

    def within(self, bounds: FloatArray) -> Obstacles:
        """Return those that touch a rectangle."""
        near = _touches(self.boxes, bounds[None])
        return Obstacles(self.boxes[near], self.costs[near])

    def cost(self, boxes: FloatArray) -> FloatArray:
        """Return what it costs to write a label in each of some boxes (c, 4), shape (c,)."""
        if not len(self.boxes):
            return np.zeros(len(boxes))
        sides = [
            np.minimum(boxes[:, None, k + 2], self.boxes[None, :, k + 2])
            - np.maximum(boxes[:, None, k], self.boxes[None, :, k])
            for k in (0, 1)
        ]
        areas = (boxes[:, 2] - boxes[:, 0]) * (boxes[:, 3] - boxes[:, 1])
        return (np.maximum(sides[0], 0) * np.maximum(sides[1], 0)) @ self.costs / areas


def place(
    candidates: list[FloatArray],
    sizes: FloatArray,
    taken: FloatArray,
    avoid: Obstacles,
    bounds: FloatArray,
    reach: float = math.inf,
) -> FloatArray:
    """Return a centre for each of n labels, shape (n, 2), NaN where there is no room left.

    candidates: per label its centres in order of preference, shape (c, 2), the best ring of `RING` of them first.
    sizes: (n, 2) width and height. taken: (m, 4) rectangles x0, y0, x1, y1 that no label may touch. bounds: the
    rectangle that holds all labels. reach: how far from the best ring a label may be, in its own heights; it goes where
    this way and the obstacles that it covers cost least. Labels are placed in the order given.
    """
    occupied = [np.asarray(r, dtype=float) for r in taken]
    centres = np.full((len(sizes), 2), np.nan)
    for i, size in enumerate(sizes):
        half = size / 2
        low, high = bounds[:2] + half, bounds[2:] - half
        if (low > high).any():
            continue
        best = candidates[i][:RING]
        options = np.clip(np.concatenate([candidates[i], _grid(low, high, best[0])]), low, high)
        away = np.linalg.norm(options[:, None] - best, axis=-1).min(axis=1) / size[1]
        options, away = options[away <= reach], away[away <= reach]
        boxes = np.concatenate([options - half, options + half], axis=1)
        free = ~_touches(boxes, np.array(occupied).reshape(-1, 4))
        if not free.any():
            continue
        options, away, boxes = options[free], away[free], boxes[free]
        around_it = np.concatenate([boxes[:, :2].min(axis=0), boxes[:, 2:].max(axis=0)])
        chosen = int((away + avoid.within(around_it).cost(boxes)).argmin())
        centres[i] = options[chosen]
        occupied.append(boxes[chosen])
    return centres


def along(start: FloatArray, end: FloatArray, step: float) -> FloatArray:
    """Return centres on the segment, the middle first, then ever further to both sides of it, shape (c, 2)."""
    way = end - start
    length = float(np.linalg.norm(way))
    normal = np.array([-way[1], way[0]]) / length if length > 0 else np.array([0.0, 1.0])
    on_line = start + np.array(_ALONG)[:, None] * way
    shifts = [0.0, *(sign * k * step for k in range(1, _RINGS) for sign in (1.0, -1.0))]
    return np.concatenate([on_line + shift * normal for shift in shifts])


def around(point: FloatArray, radius: float, step: float) -> FloatArray:
    """Return centres around a point: above it first, then to the sides, ever further out, shape (c, 2); y is up."""
    angles = np.deg2rad([90, 60, 120, 30, 150, 0, 180])
    directions = np.stack([np.cos(angles), np.sin(angles)], axis=-1)
    return np.concatenate([point + (radius + k * step) * directions for k in range(_RINGS)])


def _grid(low: FloatArray, high: FloatArray, near: FloatArray) -> FloatArray:
    """Return centres all over the bounds, the nearest to a point first."""
    x, y = (np.linspace(low[k], high[k], _GRID) for k in (0, 1))
    points = np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)
    return points[np.argsort(np.linalg.norm(points - near, axis=1), kind="stable")]


def _touches(boxes: FloatArray, others: FloatArray) -> NDArray[np.bool_]:
    """Return which boxes (c, 4) overlap any of the others (m, 4)."""
    if not len(others):
        return np.zeros(len(boxes), dtype=bool)
    apart = (
        (boxes[:, None, 2] <= others[None, :, 0])
        | (boxes[:, None, 0] >= others[None, :, 2])
        | (boxes[:, None, 3] <= others[None, :, 1])
        | (boxes[:, None, 1] >= others[None, :, 3])
    )
    return np.asarray(~apart.all(axis=1))
