"""Encounters: when two people were within X metres of each other, from when to when.

An event begins where their distance falls below X and ends where it rises above `HYSTERESIS` times X, so that two
people who stand at X do not make a hundred of them; what lasts less than a minimum is no event.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from .exposure import PairOverTime

#: An encounter within X ends beyond this many times X.
HYSTERESIS = 1.15
#: Shorter ones are people who pass too fast for anything to happen; the user may state another value.
SHORTEST_S = 1.0


@dataclass(frozen=True)
class Event:
    """One encounter of tracks a and b within `within_m`, from begin_s to end_s; p_within is the mean over it."""

    a: int
    b: int
    within_m: float
    begin_s: float
    end_s: float
    closest_m: float
    closest_s: float
    p_within: float

    @property
    def seconds(self) -> float:
        """How long it lasted."""
        return self.end_s - self.begin_s


def events_of(pair: PairOverTime, limits_m: Sequence[float], shortest_s: float = SHORTEST_S) -> Iterator[Event]:
    """Yield a pair's events, limit by limit in order, each in order of time."""
    ends = pair.t_s[-1] + pair.weight_s[-1] / 2 if len(pair.t_s) else 0.0
    begins = np.concatenate([[pair.t_s[0] - pair.weight_s[0] / 2], (pair.t_s[1:] + pair.t_s[:-1]) / 2, [ends]])
    for column, limit in enumerate(limits_m):
        for first, last in _runs(pair.near.distance_m, limit):
            begin, end = float(max(begins[first], 0.0)), float(begins[last + 1])
            if end - begin < shortest_s - 1e-9:
                continue
            closest = first + int(pair.near.distance_m[first : last + 1].argmin())
            share = float(pair.near.p_within[first : last + 1, column].mean())
            yield Event(
                pair.a, pair.b, limit, begin, end, float(pair.near.distance_m[closest]), float(pair.t_s[closest]),
                share,
            )  # fmt: skip


def _runs(distance_m: np.ndarray, limit_m: float) -> Iterator[tuple[int, int]]:
    """Yield the first and last frame of every stretch that dips below the limit and stays below where it ends."""
    stays = distance_m < HYSTERESIS * limit_m
    edges = np.flatnonzero(np.diff(np.concatenate([[False], stays, [False]]).astype(int)))
    for begin, end in zip(edges[::2], edges[1::2], strict=True):
        below = np.flatnonzero(distance_m[begin:end] < limit_m)
        if len(below):
            yield int(begin + below[0]), int(end - 1)
