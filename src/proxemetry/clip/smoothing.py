"""From a chain of sightings to a path: where the person was at every frame, given all frames, before and after.

A Rauch-Tung-Striebel smoother. It keeps what is needed to draw whole paths from the posterior, since how long two
people were near each other is a question about paths, not about single moments.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ..arrays import FloatArray
from .motion import PLACE, first_state, transition
from .sightings import Chain, Sightings
from .tracking import SWAY_SD_M

#: Detectors put a walker's joints wrong the same way for as long as the posture and the view stay: this share of a
#: sighting's standard deviation stays with a person through the clip and does not average out over frames.
LASTING_SHARE = 0.5


@dataclass(frozen=True, eq=False)
class Track:
    """One person's smoothed path through a shot, over n consecutive frames from the first sighting to the last.

    number: its own in the clip. frames: shape (n,), frame numbers in the shot. t_s: shape (n,). states: shape (n, 4),
    x, y, vx, vy on the floor. covariance: shape (n, 4, 4). gains, kicks: shape (n, 4, 4): a drawn deviation from
    `states` is at each frame its gain times that of the next frame plus noise of covariance `kicks`; gains of the last
    are unused.
    lasting_m2: shape (n, 2, 2), the covariance of what does not average out: one error a track, part of every
    position's uncertainty besides `covariance`. people: shape (n,), the place in `sightings[frame]`, -1 where bridged.
    """

    number: int
    frames: NDArray[np.intp]
    t_s: FloatArray
    states: FloatArray
    covariance: FloatArray
    gains: FloatArray
    kicks: FloatArray
    lasting_m2: FloatArray
    people: NDArray[np.intp]

    def __len__(self) -> int:
        return len(self.t_s)

    @property
    def seen(self) -> NDArray[np.bool_]:
        """Shape (n,): whether the person was seen in the frame; else the path is bridged there."""
        return self.people >= 0

    @property
    def positions_m(self) -> FloatArray:
        """Shape (n, 2), on the floor."""
        return self.states[:, PLACE]

    @property
    def place_covariance_m2(self) -> FloatArray:
        """Shape (n, 2, 2): how uncertain each position is, given the camera."""
        return self.covariance[:, PLACE, PLACE] + self.lasting_m2

    def numbered(self, number: int) -> Track:
        """Return the same track under another number."""
        return replace(self, number=number)

    def drawn(self, rng: np.random.Generator, draws: int) -> FloatArray:
        """Return drawn paths, shape (n, draws, 2): whole ones, as smooth as people are."""
        count = len(self)
        roots = _roots(self.kicks)
        deviation = np.zeros((count, draws, 4))
        later = np.zeros((draws, 4))
        for k in range(count - 1, -1, -1):
            later = later @ self.gains[k].T if k < count - 1 else later
            later = later + rng.standard_normal((draws, 4)) @ roots[k].T
            deviation[k] = later
        lasting = np.einsum("nij,dj->ndi", _roots(self.lasting_m2), rng.standard_normal((draws, 2)))
        return self.positions_m[:, None] + deviation[..., PLACE] + lasting


def _roots(covariance: FloatArray) -> FloatArray:
    values, vectors = np.linalg.eigh(covariance)
    return vectors * np.sqrt(np.maximum(values, 0.0))[..., None, :]


@dataclass(frozen=True, eq=False)
class _Filtered:
    """What the filter knew at each of n frames, before and after its sighting; and how surprising each sighting was."""

    state: FloatArray
    covariance: FloatArray
    forecast: FloatArray
    forecast_covariance: FloatArray
    surprise: FloatArray


def smooth(
    chain: Chain, shot: Sequence[Sightings], times_s: FloatArray, number: int = 0, noise_scale: float = 1.0
) -> Track:
    """Return the smoothed path of one chain.

    times_s: shape (F,), the time of every frame of the shot. noise_scale: what the stated covariances are multiplied
    by (see `noise_scale_of`).
    """
    frames = np.arange(chain.frames[0], chain.frames[-1] + 1)
    people = np.full(len(frames), -1, dtype=np.intp)
    people[chain.frames - chain.frames[0]] = chain.people
    places, noise, lasting = _measured(chain, shot, people, noise_scale)
    times = np.asarray(times_s, dtype=float)[frames]
    filtered = _filter(times, places, noise, people >= 0)
    return Track(number, frames, times, *_backwards(times, filtered), LASTING_SHARE**2 * noise + lasting, people)


def surprises(chain: Chain, shot: Sequence[Sightings], times_s: FloatArray, noise_scale: float = 1.0) -> FloatArray:
    """Return the squared Mahalanobis distances between a track's forecasts and its sightings, but for the first two."""
    frames = np.arange(chain.frames[0], chain.frames[-1] + 1)
    people = np.full(len(frames), -1, dtype=np.intp)
    people[chain.frames - chain.frames[0]] = chain.people
    places, noise, _ = _measured(chain, shot, people, noise_scale)
    filtered = _filter(np.asarray(times_s, dtype=float)[frames], places, noise, people >= 0)
    return filtered.surprise[people >= 0][2:]


def noise_scale_of(surprise: FloatArray) -> float:
    """Return by what the stated covariances fall short, from the surprises of a whole clip; at least 1.

    The median of a chi-squared variable with two degrees of freedom is 2 ln 2; the median is robust against the
    odd false match.
    """
    return max(1.0, float(np.median(surprise)) / (2 * np.log(2))) if len(surprise) else 1.0


def _measured(
    chain: Chain, shot: Sequence[Sightings], people: NDArray[np.intp], noise_scale: float
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return places (n, 2), NaN where bridged, what is wrong with each by itself and with all alike, (n, 2, 2) each.

    The two are interpolated where bridged.
    """
    seen = np.flatnonzero(people >= 0)
    places, noise, lasting = np.full((len(people), 2), np.nan), *np.zeros((2, len(people), 2, 2))
    for row, frame, person in zip(seen, chain.frames, chain.people, strict=True):
        now = shot[frame]
        places[row], lasting[row] = now.positions_m[person], now.lasting_m2[person]
        noise[row] = noise_scale * (now.covariance_m2[person] - now.lasting_m2[person]) + SWAY_SD_M**2 * np.eye(2)
    bridged = np.flatnonzero(people < 0)
    for part in (noise, lasting) if len(bridged) else ():
        for i, j in np.ndindex(2, 2):
            part[bridged, i, j] = np.interp(bridged, seen, part[seen, i, j])
    return places, noise, lasting


def _filter(times: FloatArray, places: FloatArray, noise: FloatArray, seen: NDArray[np.bool_]) -> _Filtered:
    count = len(times)
    state, covariance = np.zeros((count, 4)), np.zeros((count, 4, 4))
    forecast, forecast_covariance = np.zeros((count, 4)), np.zeros((count, 4, 4))
    surprise = np.full(count, np.nan)
    first, spread = first_state(places[:1], noise[:1])
    state[0], covariance[0] = forecast[0], forecast_covariance[0] = first[0], spread[0]
    surprise[0] = 0.0
    for k in range(1, count):
        forward, kick = transition(float(times[k] - times[k - 1]))
        mean, wide = forward @ state[k - 1], forward @ covariance[k - 1] @ forward.T + kick
        forecast[k], forecast_covariance[k] = mean, wide
        if seen[k]:
            inverse = np.linalg.inv(wide[PLACE, PLACE] + noise[k])
            apart = places[k] - mean[PLACE]
            gain = wide[:, PLACE] @ inverse
            surprise[k] = apart @ inverse @ apart
            mean, wide = mean + gain @ apart, wide - gain @ wide[PLACE]
            wide = (wide + wide.T) / 2
        state[k], covariance[k] = mean, wide
    return _Filtered(state, covariance, forecast, forecast_covariance, surprise)


def _backwards(times: FloatArray, filtered: _Filtered) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Return smoothed states and covariances, and gains and kicks (see `Track`)."""
    count = len(times)
    states, covariance = filtered.state.copy(), filtered.covariance.copy()
    gains, kicks = np.zeros((count, 4, 4)), np.zeros((count, 4, 4))
    kicks[-1] = covariance[-1]
    for k in range(count - 2, -1, -1):
        forward, _ = transition(float(times[k + 1] - times[k]))
        before, ahead = filtered.covariance[k], filtered.forecast_covariance[k + 1]
        gain = np.linalg.solve(ahead, forward @ before).T
        states[k] = filtered.state[k] + gain @ (states[k + 1] - filtered.forecast[k + 1])
        kick = before - gain @ ahead @ gain.T
        gains[k], kicks[k] = gain, (kick + kick.T) / 2
        updated = kicks[k] + gain @ covariance[k + 1] @ gain.T
        covariance[k] = (updated + updated.T) / 2
    return states, covariance, gains, kicks
