"""People inside a closed rectangle of straight edges: in a picture, on a screen or a poster, in a mirror or window."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...arrays import FloatArray
from .segments import Detected

#: Edges lean by this much (tangent) from the picture's axes at most: 15 degrees.
_LEAN = 0.27
#: Pieces this near to a line lie on it; a line's own piece is this part of the picture's long side at least; so many
#: lines of each direction, the longest, are looked at. Pixels of the reduced picture.
_ON_LINE_PX, _SHORTEST, _MOST = 2.0, 0.03, 80
#: A rectangle's sides are this long at least, in pixels of the reduced picture, and it covers this part of it at most:
#: what surrounds more is the border of a scan, or a room.
_LEAST_SIDE_PX, _MOST_AREA = 8.0, 0.5
#: A person may reach beyond the rectangle by this part of its sides, and it is this many times as high as the person
#: at most: people small inside a large one stand behind a window or before a wall.
_BEYOND, _MOST_HEIGHT = 0.06, 3.0
#: Lines are followed for so many pixels beyond the reduced picture, where nothing is.
_AROUND = 30
#: A side is a frame's where this much of it is edge, less `_GOES_ON` of what goes on beyond its corners (a quarter of
#: its length to each side): a wall's edges do, a frame's do not. Looked at on half of the photos of
#: `benchmarks/networks/doubtful.py`: from 0.6 on none of 58 real people there is framed, at 0.5 three are, two of them
#: in the open back of a truck; of the people on posters as many are up to 0.7.
_CLOSED, _GOES_ON, _FURTHER = 0.7, 0.3, 0.25


def in_frames(found: Detected, boxes_px: FloatArray) -> NDArray[np.bool_]:
    """Return whose boxes (P, 4), in full-size pixels, lie inside a closed rectangle of straight edges, shape (P,)."""
    boxes = found.reduced(boxes_px)
    if not np.isfinite(boxes).all(axis=1).any():
        return np.zeros(len(boxes), dtype=bool)
    frames = closed_rectangles(found.segments, found.size)
    sides = frames[:, 2:] - frames[:, :2]
    low, high = frames[:, :2] - _BEYOND * sides, frames[:, 2:] + _BEYOND * sides
    inside = ((boxes[:, None, :2] > low) & (boxes[:, None, 2:] < high)).all(axis=-1)
    fits = sides[:, 1] < _MOST_HEIGHT * (boxes[:, 3] - boxes[:, 1])[:, None]
    return np.asarray((inside & fits).any(axis=1), dtype=bool)


def closed_rectangles(segments: FloatArray, size: tuple[int, int]) -> FloatArray:
    """Return the insides (F, 4), x0 y0 x1 y1, of closed rectangles among segments (N, 4) of a picture of a size."""
    upright, level = _lines(segments, 0, size), _lines(segments, 1, size)
    x = (upright.offset[:, None] + upright.slope[:, None] * level.offset) / (1 - upright.slope[:, None] * level.slope)
    y = level.offset + level.slope * x
    seen = (x > 1) & (x < size[0] - 1) & (y > 1) & (y < size[1] - 1)
    across, down = _closed(level, x.T, seen.T), _closed(upright, y, seen)
    frames = [np.zeros((0, 4))]
    for left, right in np.argwhere(across.sum(axis=0) >= 2):
        rows = np.flatnonzero(across[:, left, right])
        both = down[left][np.ix_(rows, rows)] & down[right][np.ix_(rows, rows)]
        top, bottom = rows[np.argwhere(both)].T
        low = np.maximum(x[left, top], x[left, bottom]), np.maximum(y[left, top], y[right, top])
        high = np.minimum(x[right, top], x[right, bottom]), np.minimum(y[left, bottom], y[right, bottom])
        frames.append(np.stack([*low, *high], axis=1))
    found = np.concatenate(frames)
    sides = found[:, 2:] - found[:, :2]
    return found[(sides > 0).all(axis=1) & (sides.prod(axis=1) < _MOST_AREA * size[0] * size[1])]


@dataclass(frozen=True, eq=False)
class _Lines:
    """M lines of one direction, upright or level.

    offset, slope: shape (M,); across = offset + slope * along. edge: shape (M, L), how many pixels along the line
    before each are edge, from `_AROUND` before the picture to `_AROUND` behind it.
    """

    offset: FloatArray
    slope: FloatArray
    edge: FloatArray

    def edges(self, line: NDArray[np.intp], start: FloatArray, end: FloatArray) -> FloatArray:
        """Return how many pixels of lines are edge from start to end along them; all of one shape."""
        before = [self.edge[line, _pixel(at, self.edge.shape[1])] for at in (start, end)]
        return before[1] - before[0]


def _pixel(along: FloatArray, count: int) -> NDArray[np.intp]:
    return np.clip(np.round(along) + _AROUND, 0, count - 1).astype(np.intp)


def _lines(segments: FloatArray, across: int, size: tuple[int, int]) -> _Lines:
    """Return the longest lines whose coordinate `across` (0: x, upright lines) hardly changes along them."""
    along = 1 - across
    start, end = segments[:, :2], segments[:, 2:]
    start, end = (np.where(start[:, [along]] <= end[:, [along]], *pair) for pair in ((start, end), (end, start)))
    run = end - start
    mine = np.flatnonzero(np.abs(run[:, across]) < _LEAN * run[:, along])
    mine = mine[np.argsort(-run[mine, along], kind="stable")]
    start, end, run = start[mine], end[mine], run[mine]
    slope = run[:, across] / run[:, along]
    offset = start[:, across] - slope * start[:, along]
    long = int((run[:, along] > _SHORTEST * max(size)).sum())
    taken, kept, edges = np.zeros(len(mine), dtype=bool), list[int](), list[FloatArray]()
    for row in range(long):
        if taken[row] or len(kept) == _MOST:
            continue
        away = [p[:, across] - offset[row] - slope[row] * p[:, along] for p in (start, end)]
        on_it = np.maximum(*np.abs(away)) < _ON_LINE_PX
        taken |= on_it
        kept.append(row)
        edges.append(_edge(start[on_it, along], end[on_it, along], size[along]))
    return _Lines(offset[kept], slope[kept], np.array(edges).reshape(len(kept), size[along] + 2 * _AROUND + 1))


def _edge(start: FloatArray, end: FloatArray, length: int) -> FloatArray:
    """Return for each pixel along a line how many before it lie on pieces from start to end (K,)."""
    covered = np.zeros(length + 2 * _AROUND)
    for first, last in zip(_pixel(start, len(covered)), _pixel(end, len(covered)), strict=True):
        covered[first:last] = 1.0
    return np.concatenate([[0.0], np.cumsum(covered)])


def _closed(lines: _Lines, at: FloatArray, seen: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Return whether each line is an edge from one crossing to the other, and not much further, shape (M, K, K).

    at: shape (M, K), where K lines of the other direction cross it, along it. seen: which of these are in the picture.
    """
    count = len(lines.offset)
    before = lines.edge[np.arange(count)[:, None], _pixel(at, lines.edge.shape[1])]
    length = at[:, None, :] - at[:, :, None]
    closed = seen[:, :, None] & seen[:, None, :] & (length >= _LEAST_SIDE_PX)
    closed &= before[:, None, :] - before[:, :, None] > _CLOSED * length
    line, first, last = np.nonzero(closed)
    start, end, side = at[line, first], at[line, last], length[line, first, last]
    further = np.maximum(_FURTHER * side, _ON_LINE_PX + 1)
    outside = [
        lines.edges(line, start - further, start - _ON_LINE_PX),
        lines.edges(line, end + _ON_LINE_PX, end + further),
    ]
    goes_on = np.maximum(*outside) / (further - _ON_LINE_PX)
    closed[line, first, last] = lines.edges(line, start, end) / side - _GOES_ON * goes_on > _CLOSED
    return closed
