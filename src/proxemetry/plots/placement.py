"""Where labels go: each to the free place nearest to what it names, none over another."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..arrays import FloatArray

_ALONG = (0.5, 0.42, 0.58, 0.34, 0.66, 0.26, 0.74)
_RINGS = 9
_GRID = 40


def place(candidates: list[FloatArray], sizes: FloatArray, taken: FloatArray, avoid: FloatArray, bounds: FloatArray):
    """Return a centre for each of n labels, shape (n, 2), NaN where there is no room left.

    candidates: per label its centres in order of preference, shape (c, 2). sizes: (n, 2) width and height. taken:
    (m, 4) rectangles x0, y0, x1, y1 that no label may touch; avoid: rectangles that it touches only where every
    candidate does. bounds: the rectangle that holds all labels. Labels are placed in the order given.
    """
    occupied = [np.asarray(r, dtype=float) for r in taken]
    centres = np.full((len(sizes), 2), np.nan)
    for i, size in enumerate(sizes):
        half = size / 2
        low, high = bounds[:2] + half, bounds[2:] - half
        if (low > high).any():
            continue
        options = np.concatenate([candidates[i], _grid(low, high, candidates[i][0])])
        options = np.clip(options, low, high)
        boxes = np.concatenate([options - half, options + half], axis=1)
        free = ~_touches(boxes, np.array(occupied).reshape(-1, 4))
        polite = free & ~_touches(boxes, avoid)
        polite[len(candidates[i]) :] = False  # rather over a head than across the picture
        chosen = polite if polite.any() else free
        if chosen.any():
            centres[i] = options[chosen.argmax()]
            occupied.append(boxes[chosen.argmax()])
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
