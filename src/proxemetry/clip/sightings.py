"""What one frame shows of the people on the floor: the input of the tracker."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ..arrays import FloatArray


@dataclass(frozen=True, eq=False)
class Sightings:
    """P people seen in one frame.

    t_s: when, in seconds of the clip. positions_m: shape (P, 2), on the floor. covariance_m2: shape (P, 2, 2), each
    person's own uncertainty, given the camera; of it lasting_m2 is one and the same error in all sightings of a person,
    besides `smoothing.LASTING_SHARE`. floor_m2: shape (P, 2, 2), what the floor's unevenness adds. scores:
    shape (P,), 0..1. boxes_px: shape (P, 4), NaN where there is no picture. rows: shape (P,), each person's row in the
    frame's scene. heading_rad, heading_sd_rad, stature_m, stature_sd_m: shape (P,), NaN where unknown; a heading is an
    angle on the floor, from x towards y.
    """

    t_s: float
    positions_m: FloatArray
    covariance_m2: FloatArray
    scores: FloatArray
    boxes_px: FloatArray
    rows: NDArray[np.intp]
    heading_rad: FloatArray
    heading_sd_rad: FloatArray
    stature_m: FloatArray
    stature_sd_m: FloatArray
    lasting_m2: FloatArray
    floor_m2: FloatArray

    def __len__(self) -> int:
        return len(self.positions_m)

    @classmethod
    def of_places(cls, t_s: float, positions_m: FloatArray, sd_m: float | FloatArray = 0.1) -> Sightings:
        """Return people from places (P, 2) with a standard deviation alone: trajectories as data."""
        positions = np.asarray(positions_m, dtype=float).reshape(-1, 2)
        count = len(positions)
        unknown = np.full(count, np.nan)
        variance = np.broadcast_to(np.asarray(sd_m, dtype=float) ** 2, (count,))
        return cls(
            t_s, positions, variance[:, None, None] * np.eye(2), np.ones(count), np.full((count, 4), np.nan),
            np.arange(count), unknown, unknown, unknown, unknown, *np.zeros((2, count, 2, 2)),
        )  # fmt: skip

    def by_themselves(self) -> Sightings:
        """Return the people as single photos know them: the floor's unevenness is part of each one's uncertainty."""
        return replace(self, covariance_m2=self.covariance_m2 + self.floor_m2, floor_m2=np.zeros_like(self.floor_m2))

    def taken(self, order: NDArray[np.intp]) -> Sightings:
        """Return some of the people, in this order."""
        return Sightings(
            self.t_s, self.positions_m[order], self.covariance_m2[order], self.scores[order], self.boxes_px[order],
            self.rows[order], self.heading_rad[order], self.heading_sd_rad[order], self.stature_m[order],
            self.stature_sd_m[order], self.lasting_m2[order], self.floor_m2[order],
        )  # fmt: skip


@dataclass(frozen=True, eq=False)
class Chain:
    """One person's sightings through a shot: the frame numbers in it, in order, and the person's place in each.

    frames, people: shape (n,): `sightings[frames[k]]` shows this person as its entry `people[k]`.
    """

    frames: NDArray[np.intp]
    people: NDArray[np.intp]

    def __len__(self) -> int:
        return len(self.frames)

    @classmethod
    def joined(cls, chains: Iterable[Chain]) -> Chain:
        """Return one chain of several that follow each other."""
        parts = sorted(chains, key=lambda c: int(c.frames[0]))
        return cls(np.concatenate([c.frames for c in parts]), np.concatenate([c.people for c in parts]))
