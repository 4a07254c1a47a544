"""From scenes in a camera's frame to people on the floor of a clip, and what they owe to the camera.

The camera is held while people are tracked: its error is the same in every frame, and would vanish by averaging if it
counted as each sighting's own. It comes back as one error for the whole clip where distances get their intervals.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ..arrays import FloatArray
from ..bodies import Bodies
from ..camera import Camera, FloorFrame, Mount
from ..distances import ground_frame
from ..people import People
from .sightings import Sightings

_STEP = 1e-4
_N_CAMERA = 4


def sightings_of(t_s: float, people: People, bodies: Bodies, frame: FloorFrame | None) -> Sightings:
    """Return the people of a frame who have a place, on the floor of `frame` (the camera's own where it is None)."""
    rows = np.flatnonzero(bodies.placed)
    axes = ground_frame(bodies.up)[:2]
    turn = _turn(frame)
    floor = bodies.positions_m[rows] @ axes.T
    blocks = bodies.covariance_m2.reshape(len(bodies), 3, len(bodies), 3)
    own = np.array([blocks[k, :, k, :] for k in rows]).reshape(-1, 3, 3)
    heading = bodies.heading_rad[rows]
    facing = np.stack([np.sin(heading), -np.cos(heading)], axis=-1) @ turn.T
    return Sightings(
        t_s,
        floor if frame is None else frame.to_user(floor),
        turn @ (axes @ own @ axes.T) @ turn.T,
        people.person_scores[rows],
        people.boxes_px[rows],
        rows,
        np.arctan2(facing[:, 1], facing[:, 0]),
        bodies.heading_sd_rad[rows],
        bodies.stature_m[rows],
        bodies.stature_sd_m[rows],
        np.zeros((len(rows), 2, 2)),
    )


def _turn(frame: FloorFrame | None) -> FloatArray:
    """Return what turns a step to the right and ahead into the user's coordinates, shape (2, 2)."""
    if frame is None:
        return np.eye(2)
    return (frame.to_user(np.eye(2)) - frame.to_user(np.zeros(2))).T


def held(mount: Mount) -> Mount:
    """Return the mount as if it were exactly known."""
    return mount.widened(0.0)


def is_complete(mount: Mount | None) -> bool:
    """Return whether a mount says all that the floor's place follows from."""
    return mount is not None and bool(np.isfinite([mount.pitch_rad, mount.roll_rad, mount.height_m]).all())


@dataclass(frozen=True)
class CameraError:
    """What the places of a clip owe to their camera: one error for all of them (an `exposure.Sensitivity`)."""

    mount: Mount
    camera: Camera

    def __call__(self, places_m: FloatArray) -> FloatArray:
        """Return the shift of places (n, 2) on the floor per standard deviation of the camera, shape (n, 2, K)."""
        root = self._root()
        frame = self.mount.floor_frame
        own = places_m if frame is None else frame.from_user(places_m)
        slopes = np.stack([self._slope(own, k) for k in range(_N_CAMERA)], axis=-1)
        return _turn(frame) @ slopes @ root

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
        axes = ground_frame(_up(pitch, roll))
        seen = np.column_stack([own, np.full(len(own), -height)]) @ axes
        seen = seen * (1.0, 1.0, np.exp(off[3]))  # a longer lens puts the same pixel nearer to the axis
        moved = seen @ ground_frame(_up(pitch + off[0], roll + off[1])).T
        return moved[:, :2] * (-height * np.exp(off[2]) / moved[:, 2])[:, None]


def _up(pitch_rad: float, roll_rad: float) -> FloatArray:
    """Up in the camera frame, as `bodies.Floor` has it."""
    return np.array([
        np.sin(roll_rad) * np.cos(pitch_rad), -np.cos(roll_rad) * np.cos(pitch_rad), -np.sin(pitch_rad)
    ])  # fmt: skip


def without_frame(mount: Mount) -> Mount:
    """Return the mount in the camera's own floor coordinates."""
    return replace(mount, floor_frame=None)
