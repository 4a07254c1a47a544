"""The user's coordinates on the floor that a mounted camera sees."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ..arrays import FloatArray


@dataclass(frozen=True)
class FloorFrame:
    """The user's floor coordinates: where the camera stands in them, metres, and which way it looks.

    x_m, y_m: the point of the floor below the camera. yaw_rad: the angle from the x axis to the camera's right,
    counted towards the y axis. mirrored: whether x, y are left-handed as seen from above.
    """

    x_m: float = 0.0
    y_m: float = 0.0
    yaw_rad: float = 0.0
    mirrored: bool = False

    def to_user(self, floor_m: FloatArray) -> FloatArray:
        """Return points (..., 2) given as metres to the camera's right and ahead of it in the user's coordinates."""
        return (self.x_m, self.y_m) + np.asarray(floor_m, dtype=float) @ self._axes

    def from_user(self, points_m: FloatArray) -> FloatArray:
        """Return points (..., 2) of the user's coordinates as metres to the camera's right and ahead of it."""
        return (np.asarray(points_m, dtype=float) - (self.x_m, self.y_m)) @ self._axes.T

    @property
    def _axes(self) -> FloatArray:
        """The user's x and y of a metre to the right and of a metre ahead, as rows."""
        c, s = math.cos(self.yaw_rad), math.sin(self.yaw_rad)
        ahead = (s, -c) if self.mirrored else (-s, c)
        return np.array([(c, s), ahead])
