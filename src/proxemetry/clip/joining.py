"""Two tracks that are one person: a person who was hidden for longer than a forecast reaches.

Both sides of a gap together show more than the one before it: where the person was going, and from where they came.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..arrays import FloatArray
from ..assignment import assign
from .motion import SPEED_SD_M_S, VELOCITY, transition
from .sightings import Chain, Sightings
from .smoothing import Track, smooth
from .tracking import at_picture_edge

#: Longer gaps are not bridged: too many others may have come in between.
LONGEST_GAP_S = 5.0
#: How long people who were seen long enough to be followed are hidden, on average; longer ever more rarely. With
#: two seconds ETH's and UCY's people are followed as well (`benchmarks/accuracy/clip_tracking.py`: IDF1 0.93, 0.92).
_HIDDEN_S = 1.0
_ROUNDS = 5
#: Even those who walk on one line take up room to their sides.
_ROOM_SD_M = 1.0
#: 99 % of a chi-squared with four degrees of freedom.
_GATE = 13.28
_NEVER = 1e6


def joined(
    chains: Sequence[Chain], shot: Sequence[Sightings], times_s: FloatArray, noise_scale: float = 1.0,
    width_px: float = np.inf,
) -> list[Chain]:  # fmt: skip
    """Return the chains, those joined that are likelier one person than two, in the order of first sight."""
    chains = list(chains)
    if len(chains) < 2:
        return chains
    paths = [smooth(c, shot, times_s, noise_scale=noise_scale) for c in chains]
    leaves = [at_picture_edge(shot[c.frames[-1]].boxes_px[c.people[-1]], width_px) for c in chains]
    enters = [at_picture_edge(shot[c.frames[0]].boxes_px[c.people[0]], width_px) for c in chains]
    evidence = np.full((len(chains), len(chains)), _NEVER)
    for i, before in enumerate(paths):
        for j, after in enumerate(paths):
            gap = float(after.t_s[0] - before.t_s[-1])
            if 0 < gap <= LONGEST_GAP_S and not leaves[i] and not enters[j]:
                evidence[i, j] = _evidence(
                    before.states[-1], before.covariance[-1], after.states[0], after.covariance[0], gap
                )
    if not (evidence < _NEVER).any():
        return chains
    appeared = sum(not enters[k] and path.frames[0] > 0 for k, path in enumerate(paths))
    after_of = _pairs(evidence, appeared, _area_m2(paths) * float(times_s[-1] - times_s[0]))
    begun = set(range(len(chains))) - set(after_of.values())
    answer: list[Chain] = []
    for first in begun:
        links = [first]
        while links[-1] in after_of:
            links.append(after_of[links[-1]])
        answer.append(Chain.joined(chains[k] for k in links))
    return sorted(answer, key=lambda c: (int(c.frames[0]), int(c.people[0])))


def _pairs(evidence: FloatArray, appeared: int, area_time_m2_s: float) -> dict[int, int]:
    """Return which chain follows which, given how many of them begin amid the picture.

    How often people appear there is read off the clip: those that begin and follow no other, per area and second. In an
    alley that is hardly ever; before a door it happens as often as a person is hidden for a moment.
    """
    found: dict[int, int] = {}
    for _ in range(_ROUNDS):
        new_m2_s = max(appeared - len(found), 1) / area_time_m2_s
        cost = np.where(evidence < _NEVER, evidence + 2 * np.log(new_m2_s * _HIDDEN_S), _NEVER)
        before, found = found, {i: j for i, j in assign(cost) if cost[i, j] < 0}
        if found == before:
            break
    return found


def _area_m2(paths: Sequence[Track]) -> float:
    """Return the area over which people walk: of a rectangle whose points are spread like them, who take up room."""
    places = np.concatenate([path.positions_m for path in paths])
    return 12 * float(np.sqrt(np.linalg.det(np.cov(places.T) + _ROOM_SD_M**2 * np.eye(2))))


def _evidence(
    before: FloatArray, spread_before: FloatArray, after: FloatArray, spread_after: FloatArray, gap_s: float
) -> float:
    """Return minus twice the log odds that two ends of tracks are one person's, but for how often people appear.

    The other explanation is that a new person appeared there, at whatever speed people walk. `_NEVER` beyond the gate.
    """
    forward, kick = transition(gap_s)
    spread = forward @ spread_before @ forward.T + kick + spread_after
    apart = after - forward @ before
    distance2 = float(apart @ np.linalg.solve(spread, apart))
    if distance2 > _GATE:
        return _NEVER
    one = distance2 + float(np.linalg.slogdet(spread)[1]) + 4 * np.log(2 * np.pi) + 2 * gap_s / _HIDDEN_S
    moving = spread_after[VELOCITY, VELOCITY] + SPEED_SD_M_S**2 * np.eye(2)
    speed = after[VELOCITY]
    two = float(speed @ np.linalg.solve(moving, speed)) + float(np.linalg.slogdet(moving)[1]) + 2 * np.log(2 * np.pi)
    return one - two
