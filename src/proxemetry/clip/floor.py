"""From scenes in a camera's frame to people on the floor of a clip, and what they owe to the camera.

The camera is held while people are tracked: its error is the same in every frame, and would vanish by averaging if it
counted as each sighting's own. It comes back as one error for the whole clip where distances get their intervals.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from ..arrays import FloatArray
from ..bodies import Bodies
from ..camera import Camera, FloorFrame, Mount
from ..camera.floor_view import level_axes
from ..distances import ground_frame
from ..locate.scenefit.fit import FLOOR_SD_M, FLOOR_SLOPE_SD
from ..people import People
from .sightings import Sightings

_STEP = 1e-4
_N_CAMERA = 4
#: Over so many metres a floor is as high or as low: slopes and cambers stretch over a room or a street's width. An
#: assumption; people side by side stand on the same.
FLOOR_REACH_M = 3.0
#: What a body's size shows of its distance: statures spread by so much (ANSUR II, both sexes). Where feet show less,
#: the floor hardly matters.
_SIZE_SD = 0.06
#: So many waves make a floor.
_WAVES = 12


def sightings_of(t_s: float, people: People, bodies: Bodies, mount: Mount | None) -> Sightings:
    """Return the people of a frame who have a place, on the floor of the mount (the camera's own where it is None).

    Where the mount is held, what an uneven floor does is kept apart from each person's own uncertainty: it is the
    place's, the same in every frame and for all who stand there, and comes back with the camera's (`SharedError`).
    """
    rows = np.flatnonzero(bodies.placed)
    ground = ground_frame(bodies.up)
    axes = _floor_axes(ground, mount)
    frame = None if mount is None else mount.floor_frame
    turn = _turn(frame)
    floor = bodies.positions_m[rows] @ axes.T
    blocks = bodies.covariance_m2.reshape(len(bodies), 3, len(bodies), 3)
    own = np.array([blocks[k, :, k, :] for k in rows]).reshape(-1, 3, 3)
    spread = axes @ own @ axes.T
    uneven = np.zeros_like(spread)
    if mount is not None and bodies.method == "scene":
        uneven = _within(spread, uneven_m(floor, mount.height_m, FLOOR_SLOPE_SD))
    heading = bodies.heading_rad[rows]
    facing = np.stack([np.sin(heading), -np.cos(heading)], axis=-1) @ ground[:2] @ axes.T @ turn.T
    return Sightings(
        t_s,
        floor if frame is None else frame.to_user(floor),
        turn @ (spread - uneven) @ turn.T,
        people.person_scores[rows],
        people.boxes_px[rows],
        rows,
        np.arctan2(facing[:, 1], facing[:, 0]),
        bodies.heading_sd_rad[rows],
        bodies.stature_m[rows],
        bodies.stature_sd_m[rows],
        np.zeros((len(rows), 2, 2)),
        turn @ uneven @ turn.T,
    )


def _floor_axes(ground: FloatArray, mount: Mount | None) -> FloatArray:
    """Return right and ahead along the floor as vectors of the camera frame, shape (2, 3).

    ground: those of `ground_frame`, and up. They follow the camera's own x, which a rolled camera that is pitched
    carries about; the floor coordinates of a mount are counted from its level frame (`camera.floor_view`).
    """
    if mount is None or not np.isfinite([mount.pitch_rad, mount.roll_rad]).all():
        return ground[:2]
    up, right = ground[2], level_axes(mount.pitch_rad, mount.roll_rad)[:, 0]
    right = right - (right @ up) * up
    right = right / np.linalg.norm(right)
    return np.array([right, np.cross(up, right)])


def uneven_m(own_m: FloatArray, height_m: float, slope_sd: float = 0.0) -> FloatArray:
    """Return by how much an uneven floor puts people at places (n, 2) wrong, one standard deviation, shape (n, 2).

    own_m: metres to the right and ahead of the camera's foot. slope_sd: how far the floor is from level beyond that,
    metres a metre: of a mount that was found on this floor that is in its pitch and roll. The error lies along the line
    of sight: a floor that is higher by e looks nearer by e times distance over height. Feet and size together show the
    distance, each by its certainty, so that the floor's part of the error is the feet's weight times the feet's error.
    """
    away = np.linalg.norm(own_m, axis=1)
    ahead = own_m / np.maximum(away, 1e-9)[:, None]
    range_m = np.hypot(away, height_m)
    feet = away / height_m * np.hypot(FLOOR_SD_M, slope_sd * range_m)
    size = _SIZE_SD * range_m
    return ahead * (feet * size**2 / (size**2 + feet**2))[:, None]


def _within(covariance_m2: FloatArray, shift_m: FloatArray) -> FloatArray:
    """Return what shifts (n, 2) contribute to covariances (n, 2, 2), as far as these hold it."""
    inside = np.linalg.solve(covariance_m2, shift_m[..., None])[..., 0]
    share = (shift_m * inside).sum(axis=1)  # of the variance along the shift; beyond one it is not in there
    kept = np.minimum(1.0, _MOST_OF_IT / np.maximum(share, 1e-12))
    return kept[:, None, None] * shift_m[:, :, None] * shift_m[:, None, :]


#: A floor's part of a person's uncertainty is never all of it.
_MOST_OF_IT = 0.95


def _turn(frame: FloorFrame | None) -> FloatArray:
    """Return what turns a step to the right and ahead into the user's coordinates, shape (2, 2)."""
    if frame is None:
        return np.eye(2)
    return (frame.to_user(np.eye(2)) - frame.to_user(np.zeros(2))).T


def held(mount: Mount) -> Mount:
    """Return the mount as if it were exactly known."""
    return mount.widened(0.0)


def is_complete(mount: Mount | None) -> bool:
    """Return whether a mount has all that the floor's place follows from."""
    return mount is not None and bool(np.isfinite([mount.pitch_rad, mount.roll_rad, mount.height_m]).all())


@dataclass(frozen=True)
class SharedError:
    """What the places of a clip owe to their camera and to their floor, for all people alike: a `Sensitivity`.

    The camera is off in four ways. The floor is a field over places: independent waves of amplitudes drawn once.
    """

    mount: Mount
    camera: Camera

    def __call__(self, places_m: FloatArray) -> FloatArray:
        """Return the shift of places (n, 2) on the floor per standard deviation of each cause, shape (n, 2, K)."""
        frame = self.mount.floor_frame
        own = places_m if frame is None else frame.from_user(places_m)
        slopes = np.stack([self._slope(own, k) for k in range(_N_CAMERA)], axis=-1) @ self._root()
        uneven = uneven_m(own, self.mount.height_m)
        return _turn(frame) @ np.concatenate([slopes, uneven[:, :, None] * _waves(own)[:, None]], axis=-1)

    def _root(self) -> FloatArray:
        covariance = np.nan_to_num(np.array(self.mount.covariance))
        covariance[3, 3] += self.camera.focal_rel_sd**2 if not np.isfinite(self.mount.sd[3]) else 0.0
        values, vectors = np.linalg.eigh(covariance)
        kept = values > 1e-14
        return vectors[:, kept] * np.sqrt(values[kept])

    def _slope(self, own: FloatArray, which: int) -> FloatArray:
        """Return how places move with one of pitch, roll, log height and log focal length, shape (n, 2)."""
        step = np.zeros(_N_CAMERA)
        step[which] = _STEP
        return (self._seen_again(own, step) - self._seen_again(own, -step)) / (2 * _STEP)

    def _seen_again(self, own: FloatArray, off: FloatArray) -> FloatArray:
        """Return where places would be put that are seen where they are, by a camera that is off by so much."""
        pitch, roll, height = self.mount.pitch_rad, self.mount.roll_rad, self.mount.height_m
        level = np.column_stack([own[:, 0], np.full(len(own), height), own[:, 1]])  # right, down, ahead
        seen = level @ level_axes(pitch, roll).T
        seen = seen * (1.0, 1.0, np.exp(off[3]))  # a longer lens puts the same pixel nearer to the axis
        moved = seen @ level_axes(pitch + off[0], roll + off[1])
        return moved[:, [0, 2]] * (height * np.exp(off[2]) / moved[:, 1])[:, None]


def _waves(own_m: FloatArray) -> FloatArray:
    """Return waves over the floor, shape (n, 2 * _WAVES), whose products sum to exp(-d^2 / (2 FLOOR_REACH_M^2)).

    d is how far two places are apart. Random Fourier features of that kernel (Rahimi and Recht 2007), their frequencies
    spread evenly instead of drawn.
    """
    k = np.arange(_WAVES)
    size = np.sqrt(-2 * np.log1p(-(k + 0.5) / _WAVES)) / FLOOR_REACH_M
    turn = k * math.pi * (3 - math.sqrt(5))
    phase = own_m @ np.stack([size * np.cos(turn), size * np.sin(turn)])
    return np.concatenate([np.cos(phase), np.sin(phase)], axis=1) / math.sqrt(_WAVES)


def without_frame(mount: Mount) -> Mount:
    """Return the mount in the camera's own floor coordinates."""
    return replace(mount, floor_frame=None)
