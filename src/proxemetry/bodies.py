"""Where the people are: positions in metres with their joint uncertainty, from whichever method placed them."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .arrays import FloatArray, freeze

#: People contradict a camera's stated place where they put it further off than this many standard deviations, theirs
#: and the place's together: by chance in one photo of a thousand, if both were as normal as stated.
MOST_MISFIT = 2.6
#: The picture contradicts a person's stated depth where it is off by more than this many standard deviations, its own
#: and the picture's together: by chance of one person in a thousand (two-sided normal).
MOST_DEPTH_MISFIT = 3.3


@dataclass(frozen=True)
class Floor:
    """The shared floor as the camera sees it, with standard deviations.

    `height_m` is the camera's above the floor. With pitch p (positive: the camera looks down) and roll r, up in the
    camera frame is (sin r cos p, -cos r cos p, -sin p).
    """

    height_m: float
    pitch_rad: float
    roll_rad: float
    height_sd_m: float = float("nan")
    pitch_sd_rad: float = float("nan")
    roll_sd_rad: float = float("nan")


@dataclass(frozen=True)
class Intrinsics:
    """The camera's intrinsics as adjusted by the people, with which they are placed.

    focal_factor: their focal length over the camera's. shift: of the principal point, right and down, in the camera's
    focal lengths.
    """

    focal_factor: float = 1.0
    shift: tuple[float, float] = (0.0, 0.0)

    def seen(self, points_m: FloatArray) -> FloatArray:
        """Return points (..., 3) of the camera frame moved to where the stated camera sees them in the same pixel."""
        across = points_m[..., :2] * self.focal_factor + np.array(self.shift) * points_m[..., 2:]
        return np.concatenate([across, points_m[..., 2:]], axis=-1)


@dataclass(frozen=True, eq=False)
class Mode:
    """One of several explanations of a photo: its weight and where it puts people.

    positions_m: shape (P, 3). covariance_m2: shape (3P, 3P), persons' x, y, z in turn.
    """

    weight: float
    positions_m: FloatArray
    covariance_m2: FloatArray

    def __post_init__(self) -> None:
        freeze(self)


def _nothing() -> FloatArray:
    return np.zeros(0)


@dataclass(frozen=True, eq=False)
class Bodies:
    """P people placed in the camera frame (x right, y down, z forward, metres).

    positions_m: shape (P, 3), the middle of the torso (of the shoulders or the eyes, if the paper's estimators used
    those); NaN rows where a person could not be placed.
    covariance_m2: shape (3P, 3P), the joint covariance, persons' x, y, z in turn; NaN for people who were not placed.
    method: the option's name. basis: per person the evidence used ("torso", "feet+torso"), "" where not placed.
    reasons: per person why there is no position, or None.
    up: unit vector of shape (3,) against gravity in the camera frame, or None where gravity is unknown.
    heading_rad, heading_sd_rad: shape (P,), facing (sin h, 0, -cos h): 0 is against the camera's axis, positive
    turns to the image's right. stature_m, stature_sd_m: shape (P,). NaN where unknown.
    floor: the shared floor, where one was found.
    modes: several explanations with weights that sum to one; empty where one is enough.
    mount_misfit: by how many standard deviations the camera's place found from the people differs from its mount (root
        mean square over what the mount states); NaN without a mount.
    depth_misfit: shape (P,), by how many standard deviations a person's stated depth differs from all other evidence,
        positive if the stated depth is too large; NaN where none is stated.
    intrinsics: those with which the positions project onto the keypoints, if the method fits them.
    """

    positions_m: FloatArray
    covariance_m2: FloatArray
    method: str
    basis: tuple[str, ...]
    reasons: tuple[str | None, ...]
    up: FloatArray | None = None
    heading_rad: FloatArray = field(default_factory=_nothing)
    heading_sd_rad: FloatArray = field(default_factory=_nothing)
    stature_m: FloatArray = field(default_factory=_nothing)
    stature_sd_m: FloatArray = field(default_factory=_nothing)
    floor: Floor | None = None
    modes: tuple[Mode, ...] = ()
    mount_misfit: float = float("nan")
    depth_misfit: FloatArray = field(default_factory=_nothing)
    intrinsics: Intrinsics = field(default_factory=Intrinsics)

    def __post_init__(self) -> None:
        count = len(self.basis)
        self._set("positions_m", self.positions_m, (count, 3))
        self._set("covariance_m2", self.covariance_m2, (3 * count, 3 * count))
        for name in ("heading_rad", "heading_sd_rad", "stature_m", "stature_sd_m", "depth_misfit"):
            value = getattr(self, name)
            self._set(name, value if np.size(value) else np.full(count, np.nan), (count,))
        if self.up is not None:
            up = np.asarray(self.up, dtype=float)
            self._set("up", up / np.linalg.norm(up), (3,))
        if len(self.reasons) != count:
            raise ValueError(f"bodies.reasons has {len(self.reasons)} entries for {count} people")

    def _set(self, name: str, value: ArrayLike, shape: tuple[int, ...]) -> None:
        array = np.array(value, dtype=float).reshape(shape)
        array.setflags(write=False)
        object.__setattr__(self, name, array)

    @classmethod
    def unplaced(cls, count: int, method: str, reason: str) -> Bodies:
        """Return `count` people without a position, all for the same reason."""
        return cls(
            np.full((count, 3), np.nan),
            np.full((3 * count, 3 * count), np.nan),
            method,
            ("",) * count,
            (reason,) * count,
        )

    def __len__(self) -> int:
        return len(self.positions_m)

    def __repr__(self) -> str:
        return f"Bodies({int(self.placed.sum())} of {len(self)} people placed by {self.method or 'no method'})"

    @property
    def placed(self) -> NDArray[np.bool_]:
        """Shape (P,): which people have a position."""
        return np.asarray(np.isfinite(self.positions_m).all(axis=1))

    @cached_property
    def position_sd_m(self) -> FloatArray:
        """Shape (P, 3): the standard deviation of each coordinate about `positions_m`, including all modes."""
        variance = np.diag(self.covariance_m2).reshape(-1, 3)
        if self.modes:
            apart = [
                np.diag(m.covariance_m2).reshape(-1, 3) + (m.positions_m - self.positions_m) ** 2 for m in self.modes
            ]
            variance = np.average(apart, axis=0, weights=[m.weight for m in self.modes])
        sd = np.sqrt(variance)
        sd.setflags(write=False)
        return sd
