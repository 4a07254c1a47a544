"""A first layout of marks from the distances between them: by crossing arcs, one mark after the other."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from ...arrays import FloatArray

#: Marks that nothing places are put this far apart, metres: least squares begins from there.
_ASIDE_M = 1.0
#: Pairs of neighbours whose arcs are crossed for one mark, at most.
_MOST_ARCS = 40


def laid_out(count: int, links: list[tuple[int, int, float]]) -> FloatArray:
    """Return positions (N, 2) for links (row, row, metres); marks that hang on too few are put where these allow."""
    beside: list[dict[int, float]] = [{} for _ in range(count)]
    for a, b, metres in links:
        beside[a][b] = beside[b][a] = metres
    at = np.full((count, 2), np.nan)
    if not count:
        return at
    for first, second in _base(beside):
        at[first], at[second] = (0.0, 0.0), (beside[first][second], 0.0)
    if not np.isfinite(at).any():
        at[0] = 0.0
    while (k := _next(beside, at)) is not None:
        at[k] = _placed(k, beside[k], at)
    return at


def _base(beside: list[dict[int, float]]) -> Iterator[tuple[int, int]]:
    """Yield the pair to begin with: of the linked pairs the one with most common neighbours, then the longest."""
    pairs = [(a, b) for a, near in enumerate(beside) for b in near if a < b]
    if pairs:
        yield max(pairs, key=lambda p: (len(beside[p[0]].keys() & beside[p[1]].keys()), beside[p[0]][p[1]]))


def _next(beside: list[dict[int, float]], at: FloatArray) -> int | None:
    """Return the mark with most neighbours that are laid out, None where all are."""
    known = np.isfinite(at[:, 0])
    open_rows = [k for k in range(len(at)) if not known[k]]
    return max(open_rows, key=lambda k: (sum(bool(known[n]) for n in beside[k]), -k), default=None)


def _placed(row: int, near: dict[int, float], at: FloatArray) -> FloatArray:
    """Return where a mark fits best: of the crossings of two arcs each, that nearest to all its distances."""
    known = [n for n in near if math.isfinite(at[n, 0])]
    if not known:
        return np.nanmax(at, axis=0) + _ASIDE_M
    if len(known) == 1:
        turn = 2.4 * row  # golden angle: no two of a mark's neighbours in one line
        return at[known[0]] + near[known[0]] * np.array([math.cos(turn), math.sin(turn)])
    centres, radii = at[known], np.array([near[n] for n in known])
    pairs = [(i, j) for i in range(len(known)) for j in range(i)][:_MOST_ARCS]
    candidates = np.concatenate([_crossings(centres[i], radii[i], centres[j], radii[j]) for i, j in pairs])
    misfit = (np.linalg.norm(candidates[:, None] - centres, axis=-1) - radii) ** 2
    return candidates[int(np.argmin(np.median(misfit, axis=1) + 1e-3 * misfit.mean(axis=1)))]


def _crossings(one: FloatArray, r_one: float, other: FloatArray, r_other: float) -> FloatArray:
    """Return where two circles cross, shape (2, 2); where they do not, the point between them twice."""
    apart = other - one
    length = max(float(np.linalg.norm(apart)), 1e-9)
    along = (length**2 + r_one**2 - r_other**2) / (2 * length)
    across = math.sqrt(max(r_one**2 - along**2, 0.0))
    unit = apart / length
    normal = np.array([-unit[1], unit[0]])
    foot = one + along * unit
    return np.stack([foot + across * normal, foot - across * normal])
