"""Other layouts that the same measurements allow: mirrored parts, and parts that nothing holds."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from ...arrays import FloatArray
from .network import Network

#: A layout counts as another answer where its sum of squares is larger by no more than this: 3 standard deviations.
_AS_GOOD = 9.0
#: Distances that differ by less are one answer, metres; and those within so many standard deviations.
_SAME_M, _SAME_SD = 0.03, 4.0
_RANDOM_STARTS = 8
#: Of larger networks only the orderly layout is tried, for there random ones find nothing in the time one waits.
_MOST_FOR_RANDOM = 12
#: How far what nothing holds is moved to look, as shares of the layout's size.
_MOVES = (0.15, -0.4)
#: Marks at the ends of a line over which the rest is turned, and of layouts tried, at most.
_MOST_REFLECTIONS = 60


@dataclass(frozen=True, eq=False)
class Layouts:
    """The best layout (N, 2), its sum of squares, and for every pair the distances of the layouts as good as it.

    low_m, high_m: shape (N, N). same: shape (N, N), whether all of them agree on that pair.
    """

    best_m: FloatArray
    cost: float
    low_m: FloatArray
    high_m: FloatArray
    same: FloatArray


def distances_of(positions_m: FloatArray) -> FloatArray:
    """Return the distances between positions, shape (N, N)."""
    return np.linalg.norm(positions_m[:, None] - positions_m[None], axis=-1)


def layouts(network: Network) -> Layouts:
    """Return the best layout of a network that is linked, and what others as good as it say of every pair."""
    random = np.random.default_rng(len(network.tags))
    start = network.start()
    size = max(float(np.ptp(start, axis=0).max(initial=0.0)), 0.5)
    tried = [network.settled(start + random.normal(0, 0.02 * size, start.shape))]
    tried += [
        network.settled(start + random.normal(0, 0.5 * size, start.shape))
        for _ in range(_RANDOM_STARTS if 2 < len(network.tags) <= _MOST_FOR_RANDOM else 0)
    ]
    best, cost = min(tried, key=lambda found: found[1])
    for other in _moved(network, best, size):
        tried.append(network.settled(other))
    better, lower = min(tried, key=lambda found: found[1])
    if lower < cost - 1e-6:  # a reflection fits better: look around that one
        best, cost = better, lower
        tried += [network.settled(other) for other in _moved(network, best, size)]
    as_good = [distances_of(found) for found, sum_of_squares in tried if sum_of_squares <= cost + _AS_GOOD]
    low, high = np.min(as_good, axis=0), np.max(as_good, axis=0)
    sd = distance_sd(network, best)
    same = np.asarray(high - low <= np.maximum(_SAME_M, _SAME_SD * sd), dtype=float)
    return Layouts(best, cost, low, high, same)


def distance_sd(network: Network, positions_m: FloatArray) -> FloatArray:
    """Return the standard deviations of the distances, shape (N, N), by propagation from the measurements'."""
    n = len(positions_m)
    covariance = network.covariance(positions_m).reshape(n, 2, n, 2)
    apart = positions_m[:, None] - positions_m[None]
    unit = apart / np.maximum(distances_of(positions_m), 1e-9)[..., None]
    blocks = covariance.transpose(0, 2, 1, 3)  # (N, N, 2, 2)
    own = blocks[np.arange(n), np.arange(n)]
    of_difference = own[:, None] + own[None] - blocks - blocks.transpose(0, 1, 3, 2)
    variance = np.einsum("abi,abij,abj->ab", unit, of_difference, unit)
    return np.sqrt(np.maximum(variance, 0.0))


def _moved(network: Network, best_m: FloatArray, size: float) -> Iterator[FloatArray]:
    """Yield layouts that may be as good: parts turned over a line, and what nothing holds moved along."""
    for k, (line, part) in enumerate(_hinges(network)):
        if k == _MOST_REFLECTIONS:
            break
        yield _reflected(best_m, line, part)
    for direction in network.null_directions(best_m):
        for share in _MOVES:
            yield best_m + share * size * direction / max(float(np.abs(direction).max()), 1e-12)


def _hinges(network: Network) -> Iterator[tuple[tuple[int, int], list[int]]]:
    """Yield pairs of marks, and each part of the network that hangs on that pair alone."""
    n = len(network.tags)
    beside: list[set[int]] = [set() for _ in range(n)]
    for a, b, _ in network.links():
        beside[a].add(b)
        beside[b].add(a)
    for a in range(n):
        for b in range(a):
            left = set(range(n)) - {a, b}
            parts: list[list[int]] = []
            while left:
                part, waiting = [], [min(left)]
                left.discard(waiting[0])
                while waiting:
                    here = waiting.pop()
                    part.append(here)
                    near = beside[here] & left
                    left -= near
                    waiting += sorted(near)
                parts.append(sorted(part))
            if len(parts) > 1:
                yield from (((a, b), part) for part in sorted(parts, key=len)[:-1] or parts)


def _reflected(positions_m: FloatArray, line: tuple[int, int], part: list[int]) -> FloatArray:
    """Return a layout with a part mirrored over the line through two marks."""
    origin, end = positions_m[line[0]], positions_m[line[1]]
    along = end - origin
    along = along / max(float(np.linalg.norm(along)), 1e-9)
    moved = positions_m.copy()
    across = moved[part] - origin
    moved[part] = origin + 2 * np.outer(across @ along, along) - across
    return moved
