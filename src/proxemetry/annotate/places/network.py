"""Marks and measurements as one least-squares problem in the plane.

Residuals are measured less computed over the standard deviation. A network without coordinates floats: its solutions
differ by a shift, a turn and a mirror image, none of which changes a distance.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ...arrays import FloatArray, IntArray
from ...calibration.least_squares import minimise
from .layout import laid_out
from .measurements import Measurement, Spot, Tape

#: Directions in which no measurement changes: singular values below this share of the largest.
_NULL = 1e-7
#: Two marks that fall together have no direction to each other.
_LEAST_M = 1e-9


@dataclass(frozen=True, eq=False)
class Network:
    """N marks (`tags`) and what was measured of them: tapes first, then spots, as `measurements` lists them."""

    tags: tuple[str, ...]
    tapes: tuple[Tape, ...]
    spots: tuple[Spot, ...]

    @property
    def measurements(self) -> tuple[Measurement, ...]:
        """All of them, in the order of their rows."""
        return (*self.tapes, *self.spots)

    def without(self, measurement: Measurement) -> Network:
        """Return the network that lacks one measurement."""
        tapes = tuple(t for t in self.tapes if t is not measurement)
        return Network(self.tags, tapes, tuple(s for s in self.spots if s is not measurement))

    @cached_property
    def _ends(self) -> IntArray:
        row = {tag: k for k, tag in enumerate(self.tags)}
        return np.array([(row[t.a], row[t.b]) for t in self.tapes], dtype=np.int64).reshape(-1, 2)

    @cached_property
    def _at(self) -> IntArray:
        return np.array([self.tags.index(s.tag) for s in self.spots], dtype=np.int64)

    @cached_property
    def _tape_sd(self) -> FloatArray:
        return np.array([t.sd_m for t in self.tapes])

    @cached_property
    def _metres(self) -> FloatArray:
        return np.array([t.metres for t in self.tapes])

    @cached_property
    def _spots_m(self) -> FloatArray:
        return np.array([(s.x_m, s.y_m) for s in self.spots]).reshape(-1, 2)

    @cached_property
    def _spot_sd(self) -> FloatArray:
        return np.array([s.sd_m for s in self.spots])

    def rows(self, measurement: Measurement) -> list[int]:
        """Return the rows of the residuals that a measurement has: one of a tape, two of a spot."""
        if isinstance(measurement, Tape):
            return [self.tapes.index(measurement)]
        first = len(self.tapes) + 2 * self.spots.index(measurement)
        return [first, first + 1]

    def residuals(self, flat_m: FloatArray) -> FloatArray:
        """Return measured less computed in standard deviations, shape (T + 2 S,); flat_m: positions, shape (2 N,)."""
        at = flat_m.reshape(-1, 2)
        apart = at[self._ends[:, 0]] - at[self._ends[:, 1]]
        taped = (self._metres - np.hypot(apart[:, 0], apart[:, 1])) / self._tape_sd
        placed = (self._spots_m - at[self._at]) / self._spot_sd[:, None] if len(self.spots) else np.zeros((0, 2))
        return np.concatenate([taped, placed.ravel()])

    def derivatives(self, flat_m: FloatArray) -> FloatArray:
        """Return the residuals' derivatives, shape (T + 2 S, 2 N)."""
        at = flat_m.reshape(-1, 2)
        count, n = len(self.tapes), len(self.tags)
        slope = np.zeros((count + 2 * len(self.spots), n, 2))
        apart = at[self._ends[:, 0]] - at[self._ends[:, 1]]
        towards = apart / np.maximum(np.hypot(apart[:, 0], apart[:, 1]), _LEAST_M)[:, None] / self._tape_sd[:, None]
        rows = np.arange(count)
        slope[rows, self._ends[:, 0]] -= towards
        slope[rows, self._ends[:, 1]] += towards
        for k, tag in enumerate(self._at):
            for axis in (0, 1):
                slope[count + 2 * k + axis, tag, axis] = -1 / self._spot_sd[k]
        return slope.reshape(len(slope), 2 * n)

    def settled(self, start_m: FloatArray) -> tuple[FloatArray, float]:
        """Return the positions (N, 2) of the least sum of squares near a start, and that sum."""
        found, _ = minimise(self.residuals, start_m.ravel(), self.derivatives)
        left = self.residuals(found)
        return found.reshape(-1, 2), float(left @ left)

    def null_directions(self, positions_m: FloatArray) -> FloatArray:
        """Return what may move without any measurement changing at first order, shape (K, N, 2)."""
        _, sizes, directions = np.linalg.svd(self.derivatives(positions_m.ravel()))
        rank = int((sizes > _NULL * max(float(sizes.max(initial=0.0)), 1e-30)).sum())
        return directions[rank:].reshape(-1, len(self.tags), 2)

    def covariance(self, positions_m: FloatArray) -> FloatArray:
        """Return the covariance of the positions, shape (2 N, 2 N), as far as measured."""
        slope = self.derivatives(positions_m.ravel())
        return np.asarray(np.linalg.pinv(slope.T @ slope, rcond=_NULL**2, hermitian=True), dtype=float)

    def redundancy(self, positions_m: FloatArray) -> FloatArray:
        """Return each residual's redundancy number, 0 (nothing checks it) to 1, shape (T + 2 S,) (Baarda 1968)."""
        slope = self.derivatives(positions_m.ravel())
        hat = np.einsum("ij,jk,ik->i", slope, self.covariance(positions_m), slope)
        return np.clip(1 - hat, 0, 1)

    @property
    def free(self) -> int:
        """How many measurements there are beyond the unknowns of a network that holds together."""
        floats = 3 if not self.spots else 1 if len(self.spots) == 1 else 0
        return len(self.tapes) + 2 * len(self.spots) - (2 * len(self.tags) - floats)

    def links(self) -> Iterator[tuple[int, int, float]]:
        """Yield the pairs of rows whose distance is known, with it: those taped, and all between coordinates."""
        for (a, b), metres in zip(self._ends.tolist(), self._metres.tolist(), strict=True):
            yield a, b, metres
        for k, a in enumerate(self._at.tolist()):
            for m in range(k):
                yield int(self._at[m]), a, float(np.linalg.norm(self._spots_m[k] - self._spots_m[m]))

    def start(self) -> FloatArray:
        """Return positions (N, 2) to begin from: each mark laid out from those before it, on the coordinates."""
        return self._moved_to_spots(laid_out(len(self.tags), list(self.links())))

    def _moved_to_spots(self, laid_m: FloatArray) -> FloatArray:
        """Return a layout shifted, turned and, where that fits better, mirrored to lie on the coordinates."""
        if not self.spots:
            return laid_m
        own, there = laid_m[self._at], self._spots_m
        u, _, vt = np.linalg.svd((own - own.mean(axis=0)).T @ (there - there.mean(axis=0)))
        return (laid_m - own.mean(axis=0)) @ (u @ vt) + there.mean(axis=0)


def components(tags: Iterable[str], tapes: Iterable[Tape], spots: Iterable[Spot]) -> list[frozenset[str]]:
    """Return the marks that measurements link, the largest group first; coordinates link all that have them."""
    groups = [{tag} for tag in tags]
    links = [set(tape.ends) for tape in tapes]
    placed = {spot.tag for spot in spots}
    for link in (*links, placed):
        touched = [group for group in groups if group & link]
        groups = [group for group in groups if not group & link]
        groups.append(set[str]().union(*touched))
    return sorted((frozenset(group) for group in groups if group), key=lambda g: (-len(g), min(g)))
