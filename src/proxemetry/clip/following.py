"""Who is who through each shot of a clip: chains of sightings, their statures, and smoothed paths of them."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ..arrays import FloatArray
from ..locate import LocateSettings
from .joining import joined
from .measuring import Measured
from .placing import Placed
from .sightings import Chain, Sightings
from .smoothing import Track, noise_scale_of, smooth, surprises
from .statures import Known, Stature, known_statures, of_chain, told_again
from .tracking import MEMORY_S, track

#: In frames further apart no one can be followed: each is a picture of its own.
LONGEST_STEP_S = MEMORY_S


@dataclass(frozen=True, eq=False)
class FollowedShot:
    """The chains of one shot, and each one's stature, None where it is unknown."""

    chains: tuple[Chain, ...] = ()
    statures: tuple[Stature | None, ...] = ()


@dataclass(frozen=True, eq=False)
class Followed:
    """Who is who in a clip: an entry a shot; told: an entry a frame, the statures given to its people."""

    shots: tuple[FollowedShot, ...]
    told: list[Known]


def follow(
    measured: Measured, placed: Sequence[Placed], with_mount: Collection[int] = (),
    settings: LocateSettings | None = None,
) -> Followed:  # fmt: skip
    """Follow all people through every shot that does not move.

    with_mount: cameras whose place is held; with others a stature would depend as much on the camera as on the person.
    """
    shots: list[FollowedShot] = []
    known: list[Known] = [{} for _ in placed]
    for shot in measured.shots:
        if shot.moving:
            shots.append(FollowedShot())
            continue
        rows = slice(shot.first, shot.last + 1)
        seen = [p.sightings for p in placed[rows]]
        chains = tuple(chains_of(seen, np.array(measured.times_s[rows]), measured.width_px))
        statures = tuple(of_chain(c, seen, settings or LocateSettings()) for c in chains)
        shots.append(FollowedShot(chains, statures))
        if shot.camera in with_mount:
            known[rows] = known_statures(chains, statures, seen)
    return Followed(tuple(shots), known)


def chains_of(seen: Sequence[Sightings], times: FloatArray, width_px: float) -> list[Chain]:
    """Return each person's chain through the frames of a shot, whatever the order of people in each.

    Forecasts and sightings are compared as vaguely as single photos know them, floor and all.
    """
    if len(times) > 1 and float(np.median(np.diff(times))) > LONGEST_STEP_S:
        return [Chain(np.array([k]), np.array([p])) for k, s in enumerate(seen) for p in range(len(s))]
    ordered = [s.by_themselves().taken(np.lexsort(s.positions_m.T[::-1])) for s in seen]
    back = [np.lexsort(s.positions_m.T[::-1]) for s in seen]
    chains = track(ordered, width_px=width_px)
    scale = _noise_scale(chains, ordered, times)
    if scale > 1:
        chains = track(ordered, scale, width_px=width_px)
    return [_in_rows(c, back) for c in joined(chains, ordered, times, scale, width_px)]


def with_statures(
    measured: Measured, followed: Followed, before: Sequence[Placed], after: Sequence[Placed]
) -> tuple[list[Placed], Followed]:
    """Return the people as placed again with their statures, and the same chains through them."""
    placed = [
        replace(new, sightings=told_again(old.sightings, new.sightings, known))
        for old, new, known in zip(before, after, followed.told, strict=True)
    ]
    shots: list[FollowedShot] = []
    for shot, of_shot in zip(measured.shots, followed.shots, strict=True):
        rows = slice(shot.first, shot.last + 1)
        old, new = ([p.sightings for p in frames[rows]] for frames in (before, placed))
        kept = [(_through(c, old, new), s) for c, s in zip(of_shot.chains, of_shot.statures, strict=True)]
        found = [(c, s) for c, s in kept if len(c)]
        shots.append(FollowedShot(tuple(c for c, _ in found), tuple(s for _, s in found)))
    return placed, Followed(tuple(shots), followed.told)


def _through(chain: Chain, old: Sequence[Sightings], new: Sequence[Sightings]) -> Chain:
    """Return a chain through other sightings of the same frames, without those who have no place there."""
    frames: list[int] = []
    people: list[int] = []
    for frame, person in zip(chain.frames.tolist(), chain.people.tolist(), strict=True):
        there = np.flatnonzero(new[frame].rows == old[frame].rows[person])
        if len(there):
            frames.append(frame)
            people.append(int(there[0]))
    return Chain(np.array(frames, dtype=np.intp), np.array(people, dtype=np.intp))


def _in_rows(chain: Chain, order: Sequence[NDArray[np.intp]]) -> Chain:
    """Return a chain of sightings that were put in order as one of the sightings as they were."""
    people = [int(order[int(f)][int(k)]) for f, k in zip(chain.frames, chain.people, strict=True)]
    return Chain(chain.frames, np.array(people, dtype=np.intp))


def _noise_scale(chains: Sequence[Chain], seen: Sequence[Sightings], times: FloatArray) -> float:
    return noise_scale_of(np.concatenate([np.zeros(0), *(surprises(c, seen, times) for c in chains)]))


def smoothed(chains: Sequence[Chain], seen: Sequence[Sightings], times: FloatArray) -> tuple[list[Track], float]:
    """Return the smoothed tracks of a shot's chains, and by what the stated covariances fell short."""
    scale = _noise_scale(chains, seen, times)
    return [smooth(c, seen, times, noise_scale=scale) for c in chains], scale
