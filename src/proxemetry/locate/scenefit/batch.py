"""The rows that the solver works on: each a person under one hypothesis, with evidence and prior."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ...arrays import FloatArray
from .projection import HEADING, BodyTables


@dataclass(frozen=True, eq=False)
class HypothesisBatch:
    """R rows to be explained, a person under a hypothesis each.

    person: shape (R,). points (R, 2, K), precision (R, K), one over the standard deviation and 0 where unseen: the
    evidence. bodies: the tables of each row's posture. prior_mean (R, N_LOCAL), prior_precision (R, N_LOCAL, N_LOCAL):
    the prior of each body; prior_log_volume (R,): the log determinant of that precision.
    floor_precision: shape (R,), one over the standard deviation of soles about the floor, 0 for rows off it.
    log_depth, depth_precision: shape (R,), the stated depth and one over its standard deviation, 0 where none is.
    """

    person: NDArray[np.intp]
    points: FloatArray
    precision: FloatArray
    bodies: BodyTables
    prior_mean: FloatArray
    prior_precision: FloatArray
    prior_log_volume: FloatArray
    floor_precision: FloatArray
    log_depth: FloatArray
    depth_precision: FloatArray

    def __len__(self) -> int:
        return len(self.person)

    def taken(self, index: NDArray[np.intp]) -> HypothesisBatch:
        """Return some of the rows."""
        return HypothesisBatch(
            self.person[index], self.points[index], self.precision[index], self.bodies.taken(index),
            self.prior_mean[index], self.prior_precision[index], self.prior_log_volume[index],
            self.floor_precision[index], self.log_depth[index], self.depth_precision[index],
        )  # fmt: skip

    def with_heading_near(self, heading: FloatArray) -> HypothesisBatch:
        """Return the rows with each prior heading moved by whole turns to where it is nearest to a heading (R,)."""
        mean = self.prior_mean.copy()
        mean[:, HEADING] = heading + np.angle(np.exp(1j * (mean[:, HEADING] - heading)))
        return replace(self, prior_mean=mean)

    @classmethod
    def joined(cls, parts: Sequence[HypothesisBatch]) -> HypothesisBatch:
        """Return all rows of several."""
        fields = [name for name in cls.__dataclass_fields__ if name != "bodies"]
        joined = {name: np.concatenate([getattr(part, name) for part in parts]) for name in fields}
        return cls(**joined, bodies=BodyTables.joined([part.bodies for part in parts]))

    def with_precision(self, precision: FloatArray) -> HypothesisBatch:
        """Return the rows with other keypoint noise (R, K)."""
        return replace(self, precision=precision)

    def with_tilt(self, tilt: FloatArray) -> HypothesisBatch:
        """Return the rows with their bodies seen at a tilt (R, 2), see `BodyTables`."""
        return replace(self, bodies=replace(self.bodies, tilt=tilt))

    def with_floor(self, factor: float | FloatArray) -> HypothesisBatch:
        """Return the rows with the floor's precision multiplied."""
        return replace(self, floor_precision=self.floor_precision * factor)

    def with_depth(self, factor: float) -> HypothesisBatch:
        """Return the rows with the stated depths' precision multiplied."""
        return replace(self, depth_precision=self.depth_precision * factor)
