"""Which people belong together: a probability for each pair of paths, and the groups that follow from all pairs.

People who walk or stand together stay near each other, hold their place relative to each other, and side by side
rather than in file, for as long as they are seen. How much each of these counts was fitted to the annotated groups of
three public scenes (`benchmarks/accuracy/clip_groups.py`); how common companions are in a clip is estimated from the
clip itself, since near strangers are rare in an empty street and everywhere in a crowd.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ..arrays import FloatArray
from .motion import PLACE, VELOCITY
from .smoothing import Track

#: Pairs that are never nearer are not considered.
REACH_M = 4.0
#: Time together beyond this adds nothing, nor do higher speeds.
_LONGEST_S, _FASTEST_M_S = 15.0, 1.5
#: Over so many seconds it is measured how two people hold their place relative to each other.
_DRIFT_S = 2.0
_SHORTEST_S = 0.75

FEATURES = ("log distance", "log drift", "log in file", "log time", "speed")


@dataclass(frozen=True)
class Model:
    """A logistic regression on standardised `FEATURES`: their mean and sd, intercept first among the weights.

    rate: the share of companions among the pairs that it was fitted to.
    """

    mean: tuple[float, ...]
    sd: tuple[float, ...]
    weights: tuple[float, ...]
    rate: float


#: Fitted to ETH seq_eth, UCY zara01 and students03 together (9,300 pairs, 425 of them companions; Pellegrini et al.
#: 2009, Lerner et al. 2007) by benchmarks/accuracy/clip_groups.py, which prints these numbers.
FITTED = Model(
    mean=(1.6349, 0.0463, 0.9445, 2.1678, 0.8054),
    sd=(0.5950, 0.6536, 0.6369, 0.6503, 0.3537),
    weights=(-6.5648, -2.0148, -0.5421, -0.5495, 1.0573, 0.5010),
    rate=0.0457,
)
#: So many pairs at the fitted rate are added to those of the clip: a short clip shows little of how common groups are.
_PRIOR_PAIRS = 20.0


@dataclass(frozen=True, eq=False)
class Together:
    """Two people's time in common: n moments, their places (n, 2) and velocities (n, 2), step_s apart."""

    t_s: FloatArray
    a_m: FloatArray
    b_m: FloatArray
    a_m_s: FloatArray
    b_m_s: FloatArray


def together(a: Track, b: Track) -> Together | None:
    """Return what two paths have in common in time, None where that is nothing."""
    first, last = max(int(a.frames[0]), int(b.frames[0])), min(int(a.frames[-1]), int(b.frames[-1]))
    if last < first:
        return None
    i, j = (
        slice(first - int(a.frames[0]), last - int(a.frames[0]) + 1),
        slice(first - int(b.frames[0]), last - int(b.frames[0]) + 1),
    )
    return Together(a.t_s[i], a.states[i, PLACE], b.states[j, PLACE], a.states[i, VELOCITY], b.states[j, VELOCITY])


def features(pair: Together) -> FloatArray | None:
    """Return `FEATURES` of a pair, shape (5,), None where they are never near or hardly together at all."""
    apart = pair.a_m - pair.b_m
    distance = np.linalg.norm(apart, axis=1)
    seconds = float(pair.t_s[-1] - pair.t_s[0]) if len(pair.t_s) else 0.0
    if distance.min(initial=math.inf) > REACH_M or seconds < _SHORTEST_S:
        return None
    later = np.searchsorted(pair.t_s, pair.t_s + min(_DRIFT_S, seconds) - 1e-6)
    now = np.flatnonzero(later < len(pair.t_s))
    lag = pair.t_s[later[now]] - pair.t_s[now]
    drift = np.linalg.norm(apart[later[now]] - apart[now], axis=1) / lag
    velocity = (pair.a_m_s + pair.b_m_s) / 2
    ahead = velocity / np.maximum(np.linalg.norm(velocity, axis=1, keepdims=True), 1e-6)
    in_file = np.abs((apart * ahead).sum(axis=1))
    speed = np.median(np.linalg.norm(pair.a_m_s, axis=1) + np.linalg.norm(pair.b_m_s, axis=1)) / 2
    return np.array([
        np.log(max(float(np.quantile(distance, 0.75)), 0.1)),
        np.log(0.05 + np.sqrt((drift**2).mean())),
        np.log(0.2 + np.median(in_file)),
        np.log(min(seconds, _LONGEST_S)),
        min(speed, _FASTEST_M_S),
    ])  # fmt: skip


def group_probabilities(paths: Sequence[Track], model: Model = FITTED) -> dict[tuple[int, int], float]:
    """Return the probability of being together for every pair that is ever near, by track numbers (a, b), a first."""
    pairs: list[tuple[int, int]] = []
    described: list[FloatArray] = []
    in_time = sorted(paths, key=lambda p: (int(p.frames[0]), p.number))
    for k, first in enumerate(in_time):
        for other in in_time[k + 1 :]:
            if other.frames[0] > first.frames[-1]:
                break
            a, b = (first, other) if first.number < other.number else (other, first)
            shared = together(a, b)
            found = None if shared is None else features(shared)
            if found is not None:
                pairs.append((a.number, b.number))
                described.append(found)
    if not pairs:
        return {}
    probability = adjusted(predicted(np.array(described), model), model.rate)
    return {pair: float(p) for pair, p in zip(pairs, probability, strict=True)}


def predicted(described: FloatArray, model: Model) -> FloatArray:
    """Return the model's probability for rows of features (n, 5), companions as common as in the model's own data."""
    standard = (described - np.array(model.mean)) / np.array(model.sd)
    score = model.weights[0] + standard @ np.array(model.weights[1:])
    return 1 / (1 + np.exp(-np.clip(score, -30, 30)))


def adjusted(probability: FloatArray, rate: float) -> FloatArray:
    """Return the probabilities for a clip in which companions are more or less common than `rate`.

    How common they are is estimated from the probabilities themselves by expectation maximisation (Saerens, Latinne
    and Decaestecker 2002).
    """
    odds, here, result = probability / (1 - probability), rate, probability
    for _ in range(200):
        scaled = odds * (here / (1 - here)) / (rate / (1 - rate))
        result = scaled / (1 + scaled)
        now = (result.sum() + _PRIOR_PAIRS * rate) / (len(result) + _PRIOR_PAIRS)
        if abs(now - here) < 1e-9:
            break
        here = now
    return result


def groups_of(tracks: Sequence[int], probability: Mapping[tuple[int, int], float]) -> list[list[int]]:
    """Return the tracks in groups, those of one alone too, each sorted and in the order of their first.

    The two clusters likeliest to belong together are joined until none is likelier than not (average linkage over
    all their pairs): one doubtful link does not chain two groups.
    """
    known = {(min(pair), max(pair)): p for pair, p in probability.items()}
    return sorted(group for some in _connected(tracks, known) for group in _clustered(some, known))


def _connected(tracks: Sequence[int], known: Mapping[tuple[int, int], float]) -> list[list[int]]:
    """Return the tracks in parts between which no pair is likelier together than not: nothing joins across them.

    An hour of a busy place has thousands of tracks, and hardly any part has ten.
    """
    leader = {t: t for t in tracks}

    def first(track: int) -> int:
        while leader[track] != track:
            leader[track] = track = leader[leader[track]]
        return track

    for (a, b), p in known.items():
        if p > 0.5 and a in leader and b in leader:
            leader[first(a)] = first(b)
    parts: dict[int, list[int]] = {}
    for track in sorted(tracks):
        parts.setdefault(first(track), []).append(track)
    return list(parts.values())


def _clustered(tracks: Sequence[int], known: Mapping[tuple[int, int], float]) -> list[list[int]]:
    clusters, here = [[t] for t in tracks], set(tracks)
    near = [pair for pair, p in known.items() if p > 0.5 and pair[0] in here] if len(tracks) > 1 else []

    def linked(a: list[int], b: list[int]) -> float:
        return sum(known.get((min(i, j), max(i, j)), 0.0) for i in a for j in b) / (len(a) * len(b))

    while near:
        where = {t: k for k, cluster in enumerate(clusters) for t in cluster}
        touching = {(min(where[a], where[b]), max(where[a], where[b])) for a, b in near if where[a] != where[b]}
        best = max(touching, key=lambda k: (linked(clusters[k[0]], clusters[k[1]]), -k[0], -k[1]), default=None)
        if best is None or linked(clusters[best[0]], clusters[best[1]]) <= 0.5:
            break
        merged = sorted(clusters[best[0]] + clusters[best[1]])
        clusters = [c for k, c in enumerate(clusters) if k not in best] + [merged]
    return clusters
