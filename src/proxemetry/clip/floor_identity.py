"""Who is who in frames of a camera whose place is roughly known: people followed over the floor, not in the picture."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ..arrays import FloatArray
from ..camera import Mount
from ..camera.floor_view import to_floor
from ..people import People
from .sightings import Sightings
from .tracking import track

#: How well feet are seen, in pixels: the place of a person on the floor is as uncertain as this makes it.
_FEET_SD_PX = 3.0
#: A person farther away than this, or beyond the horizon, is not followed.
_FARTHEST_M = 200.0


def followed(frames: Sequence[People], times_s: Sequence[float], mount: Mount) -> list[NDArray[np.intp]]:
    """Return for every frame who each of its people is, shape (P,): numbers from 0, the same for the same person.

    A person in no track counts as a different person each time. mount: with its camera, of frames of this size.
    """
    assert mount.camera is not None
    shot = [_sightings(people, now, mount) for people, now in zip(frames, times_s, strict=True)]
    who = [np.full(len(people), -1, dtype=np.intp) for people in frames]
    chains = track(shot, width_px=mount.camera.width)
    for number, chain in enumerate(chains):
        for frame, place in zip(chain.frames.tolist(), chain.people.tolist(), strict=True):
            who[frame][shot[frame].rows[place]] = number
    met = len(chains)
    for persons in who:
        alone = np.flatnonzero(persons < 0)
        persons[alone] = met + np.arange(len(alone))
        met += len(alone)
    return who


def _sightings(people: People, now: float, mount: Mount) -> Sightings:
    """Return the people on the floor in a frame, with the effect of a few pixels on their places."""
    assert mount.camera is not None
    flat = replace(mount, camera=mount.camera.without_distortion())
    feet = mount.camera.undistorted(_feet(people))
    places = to_floor(flat, feet)
    moved = np.stack([to_floor(flat, feet + _FEET_SD_PX * side) - places for side in np.eye(2)], axis=-1)
    rows = np.flatnonzero(np.isfinite(moved).all(axis=(1, 2)) & (np.linalg.norm(places, axis=1) < _FARTHEST_M))
    covariance = moved[rows] @ moved[rows].transpose(0, 2, 1)
    return replace(
        Sightings.of_places(now, places[rows]), covariance_m2=covariance, scores=people.person_scores[rows],
        boxes_px=people.boxes_px[rows], rows=rows,
    )  # fmt: skip


def _feet(people: People) -> FloatArray:
    """Return where each stands in the picture, shape (P, 2): the middle of the ankles that are seen, else the box's
    lower edge."""
    ankles = np.stack([people.joint("left_ankle"), people.joint("right_ankle")])
    seen = np.isfinite(ankles).all(axis=-1, keepdims=True)
    middle = np.where(seen, ankles, 0.0).sum(axis=0) / np.maximum(seen.sum(axis=0), 1)
    below = np.column_stack([people.boxes_px[:, [0, 2]].mean(axis=1), people.boxes_px[:, 3]])
    return np.where(seen.any(axis=0), middle, below)
