"""How long two people were within X metres of each other, from their smoothed paths.

Seconds within X are the integral over time of the probability of being within X. Counting single noisy frames instead
finds too few, since noise only ever adds distance to two people side by side. The interval comes from draws of the
whole clip: one camera, one lasting error and one path a person in each, so that what is wrong for all people at once
does not average out.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..arrays import FloatArray
from ..intervals import HIGH, LOW
from .nearness import Nearness, nearness
from .smoothing import Track

#: Takes places on the floor (n, 2) and returns what they owe to the camera, shape (n, 2, K): a place's shift per
#: standard deviation of each of the K things about the camera that are not exactly known.
Sensitivity = Callable[[FloatArray], FloatArray]

#: Draws of the whole clip: an interval's ends are then good to a tenth of a standard deviation.
DRAWS = 200
#: Pairs less likely to be within the widest limit at any moment need no draws: they were not.
_NEVER = 1e-3


def exactly_known(places_m: FloatArray) -> FloatArray:
    """The `Sensitivity` of a camera without error."""
    return np.zeros((*places_m.shape, 0))


@dataclass(frozen=True, eq=False)
class PairOverTime:
    """Two tracks, a < b, at the n moments at which both were there.

    frames: shape (n,), frame numbers in the shot. t_s, weight_s: shape (n,), the moment and how long it stands for.
    seen: shape (n,), whether both were seen, not bridged. seconds: shape (L,), expected seconds within each limit;
    drawn_seconds: shape (draws, L). closest_m: the smallest distance, with its interval.
    """

    a: int
    b: int
    frames: NDArray[np.intp]
    t_s: FloatArray
    weight_s: FloatArray
    near: Nearness
    seen: NDArray[np.bool_]
    seconds: FloatArray
    drawn_seconds: FloatArray
    closest_m: float
    closest_low_m: float
    closest_high_m: float

    @property
    def seconds_together(self) -> float:
        """How long both were there."""
        return float(self.weight_s.sum())

    def interval_s(self) -> tuple[FloatArray, FloatArray]:
        """Return the 90 % interval of `seconds`, two arrays of shape (L,)."""
        return interval(self.drawn_seconds, self.seconds)


def interval(drawn: FloatArray, around: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the central 90 % of draws (D, ...), widened where need be so that the answer lies in it."""
    low, high = np.quantile(drawn, [LOW, HIGH], axis=0)
    return np.minimum(low, around), np.maximum(high, around)


def weights_s(times_s: FloatArray, step_s: float) -> FloatArray:
    """Return how long each frame stands for: half way to the frames on either side, shape (n,).

    step_s: the distance of frames, of which the outer ones get half on their outer side.
    """
    times = np.asarray(times_s, dtype=float)
    if not len(times):
        return np.zeros(0)
    middles = (times[1:] + times[:-1]) / 2
    edges = np.concatenate([[times[0] - step_s / 2], middles, [times[-1] + step_s / 2]])
    return np.diff(edges)


def pairs_over_time(
    paths: Sequence[Track], weight_s: FloatArray, limits_m: Sequence[float],
    sensitivity: Sensitivity = exactly_known, draws: int = DRAWS, seed: int = 0,
) -> Iterator[PairOverTime]:  # fmt: skip
    """Yield every pair of paths that overlap in time, in the order of the later one's beginning.

    weight_s: shape (F,), how long each frame of the shot stands for. Memory is bounded by the people who are there at
    one time, however long the clip.
    """
    camera: FloatArray | None = None
    there: list[_Drawn] = []
    for path in sorted(paths, key=lambda p: (int(p.frames[0]), p.number)):
        there = [d for d in there if d.path.frames[-1] >= path.frames[0]]
        shift = sensitivity(path.positions_m)
        if camera is None:
            camera = np.random.default_rng([seed]).standard_normal((draws, shift.shape[-1]))
        newcomer = _Drawn(path, shift, camera, seed)
        for other in there:
            first, second = (other, newcomer) if other.path.number < path.number else (newcomer, other)
            yield _pair(first, second, weight_s, limits_m)
        there.append(newcomer)


class _Drawn:
    """A path with its draws, made when the first other person comes near."""

    def __init__(self, path: Track, shift: FloatArray, camera: FloatArray, seed: int) -> None:
        self.path, self.shift, self.draws = path, shift, len(camera)
        self._camera, self._seed = camera, seed
        self._places: NDArray[np.float32] | None = None

    @property
    def places(self) -> NDArray[np.float32]:
        places = self._places
        if places is None:
            rng = np.random.default_rng([self._seed, 1, self.path.number])
            own = self.path.drawn(rng, self.draws)
            places = (own + np.einsum("nik,dk->ndi", self.shift, self._camera)).astype(np.float32)
            self._places = places
        return places


def _pair(a: _Drawn, b: _Drawn, weight_s: FloatArray, limits_m: Sequence[float]) -> PairOverTime:
    first = max(int(a.path.frames[0]), int(b.path.frames[0]))
    last = min(int(a.path.frames[-1]), int(b.path.frames[-1]))
    i, j = (slice(first - int(p.frames[0]), last - int(p.frames[0]) + 1) for p in (a.path, b.path))
    frames = np.arange(first, last + 1)
    gap = a.path.positions_m[i] - b.path.positions_m[j]
    shared = a.shift[i] - b.shift[j]
    spread = a.path.place_covariance_m2[i] + b.path.place_covariance_m2[j] + shared @ shared.transpose(0, 2, 1)
    near = nearness(gap, spread, limits_m)
    weight = weight_s[frames]
    seconds = weight @ near.p_within
    closest = float(near.distance_m.min())
    moment = int(near.distance_m.argmin())
    drawn = np.zeros((a.draws, len(limits_m)))
    low, high = float(near.low_m[moment]), float(near.high_m[moment])
    if len(limits_m) and near.p_within.max(initial=0.0) > _NEVER:
        lengths = np.linalg.norm(a.places[i] - b.places[j], axis=-1)
        drawn = np.stack([weight @ (lengths < limit) for limit in limits_m], axis=-1)
        drawn_low, drawn_high = np.quantile(lengths.min(axis=0), [LOW, HIGH])
        low, high = min(float(drawn_low), closest), max(float(drawn_high), closest)
    return PairOverTime(
        a.path.number, b.path.number, frames, a.path.t_s[i], weight, near, a.path.seen[i] & b.path.seen[j],
        seconds, drawn, closest, low, high,
    )  # fmt: skip


@dataclass(frozen=True, eq=False)
class Totals:
    """Person-pairs' seconds within each limit, summed over a clip, with 90 % intervals; each array has shape (L,).

    The second three leave out pairs of one group, each by its probability of being one.
    """

    seconds: FloatArray
    low_s: FloatArray
    high_s: FloatArray
    apart_seconds: FloatArray
    apart_low_s: FloatArray
    apart_high_s: FloatArray


class TotalExposure:
    """Sums over pairs as they come, draw by draw."""

    def __init__(self, n_limits: int, draws: int = DRAWS, seed: int = 0) -> None:
        self._seconds, self._apart = np.zeros(n_limits), np.zeros(n_limits)
        self._drawn, self._drawn_apart = np.zeros((draws, n_limits)), np.zeros((draws, n_limits))
        self._seed = seed

    def add(self, pair: PairOverTime, p_same_group: float) -> None:
        """Count a pair in."""
        rng = np.random.default_rng([self._seed, 2, pair.a, pair.b])
        strangers = rng.random(len(self._drawn)) >= p_same_group
        self._seconds += pair.seconds
        self._apart += (1 - p_same_group) * pair.seconds
        self._drawn += pair.drawn_seconds
        self._drawn_apart += strangers[:, None] * pair.drawn_seconds

    def totals(self) -> Totals:
        """Return what was counted."""
        return Totals(
            self._seconds.copy(), *interval(self._drawn, self._seconds),
            self._apart.copy(), *interval(self._drawn_apart, self._apart),
        )  # fmt: skip


def same_group(probability: Mapping[tuple[int, int], float], a: int, b: int) -> float:
    """Return the probability that two tracks belong together; 0 for those never near each other."""
    return probability.get((a, b), probability.get((b, a), 0.0))
