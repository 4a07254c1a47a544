"""Where a clip is cut, and whether its camera stays where it is.

The background of each frame is compared with that of the frame a shot began with (`calibration.background`). A camera
that was moved is another camera; one that comes back is the same again.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from enum import StrEnum
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..arrays import FloatArray, RGBArray
from ..calibration.background import (
    FOUND_AGAIN,
    MOVED_SHARE,
    GrayArray,
    corners_of,
    motion_between,
    shift_of,
    small_gray,
)

#: A camera that has moved again after a frame or two, so many times in a row, is hand-held or follows a person.
_MOVING_SHOTS = 4
#: So many places are remembered to which a camera may come back.
_MOST_KNOWN = 12
#: The frame that others are compared with is replaced after this long, so that light may change over a day.
_REFERENCE_S = 20.0


class Change(StrEnum):
    """Why a shot began."""

    START = "start"
    CUT = "cut"
    MOVED = "camera moved"


@dataclass(frozen=True)
class Shot:
    """A stretch of frames of one camera at one place.

    first, last: frame numbers, both included. camera: shots with the same number are of a camera at the same place.
    began: why. shift_share: how far the picture had moved by then, as a share of its width. moving: the camera was
    moving all the time, so that its frames are single photos.
    """

    first: int
    last: int
    camera: int
    began: Change
    shift_share: float = 0.0
    moving: bool = False

    def to_dict(self) -> dict[str, Any]:
        """Return the shot as JSON values."""
        return {
            "first": self.first, "last": self.last, "camera": self.camera, "began": str(self.began),
            "shift_share": round(self.shift_share, 5), "moving": self.moving,
        }  # fmt: skip

    @classmethod
    def from_dict(cls, fields: Mapping[str, Any]) -> Shot:
        """Read what `to_dict` wrote."""
        return cls(
            int(fields["first"]), int(fields["last"]), int(fields["camera"]), Change(fields["began"]),
            float(fields["shift_share"]), bool(fields["moving"]),
        )  # fmt: skip


@dataclass
class _View:
    """A camera's background as last seen, and where it lay to where it was first seen."""

    gray: GrayArray
    corners: NDArray[np.float32]
    t_s: float
    offset: FloatArray


class ShotFinder:
    """Call `see` with every frame in turn, then `shots`."""

    def __init__(self) -> None:
        self._views: dict[int, _View] = {}
        self._next = 0
        self._shots: list[Shot] = []
        self._previous: GrayArray | None = None
        self._count = 0

    def see(self, pixels: RGBArray, t_s: float) -> None:
        """Look at one frame, pixels (H, W, 3)."""
        gray = small_gray(pixels)
        number, self._count = self._count, self._count + 1
        before, self._previous = self._previous, gray
        if before is None or before.shape != gray.shape:
            self._begin(number, gray, t_s, Change.START if before is None else Change.CUT, 0.0)
            return
        view = self._views[self._shots[-1].camera]
        motion = motion_between(view.gray, view.corners, gray)
        limit = MOVED_SHARE * gray.shape[1]
        if motion is None or motion.found < FOUND_AGAIN:
            step = motion_between(before, corners_of(before), gray)
            if step is not None and step.found >= FOUND_AGAIN and step.shift_px < limit:
                # the light changed, or the reference has grown old
                self._views[self._shots[-1].camera] = _View(gray, corners_of(gray), t_s, view.offset)
                self._extend(number)
                return
            if step is None and motion is None:  # nothing to hold on to: a blank wall, or darkness
                self._extend(number)
                return
            change = Change.MOVED if step is not None and step.found >= FOUND_AGAIN else Change.CUT
            shift = math.nan if step is None else step.shift_px
            self._begin(number, gray, t_s, change, (0.0 if change is Change.CUT else shift) / gray.shape[1])
            return
        whole = shift_of(view.offset @ motion.matrix, gray.shape)
        if whole > limit:
            self._begin(number, gray, t_s, Change.MOVED, whole / gray.shape[1])
            return
        self._extend(number)
        if t_s - view.t_s > _REFERENCE_S:
            self._views[self._shots[-1].camera] = _View(gray, corners_of(gray), t_s, view.offset @ motion.matrix)

    def _extend(self, number: int) -> None:
        last = self._shots[-1]
        self._shots[-1] = Shot(last.first, number, last.camera, last.began, last.shift_share, last.moving)

    def _begin(self, number: int, gray: GrayArray, t_s: float, change: Change, share: float) -> None:
        """Begin a shot, of a camera seen before where the picture lies as it did then."""
        if self._shots and _is_short(self._shots[-1]):
            before = self._shots[-1].camera
            if not any(s.camera == before for s in self._shots[:-1]):
                self._views.pop(before, None)  # a camera in motion: nothing comes back to that
        known = None if change is Change.START else self._known(gray)
        if known is None:
            known, self._next = self._next, self._next + 1
            self._views[known] = _View(gray, corners_of(gray), t_s, np.eye(3))
        self._shots.append(Shot(number, number, known, change, share))

    def _known(self, gray: GrayArray) -> int | None:
        for number, view in list(self._views.items())[-_MOST_KNOWN:]:
            if view.gray.shape != gray.shape:
                continue
            motion = motion_between(view.gray, view.corners, gray)
            if motion is None or motion.found < FOUND_AGAIN:
                continue
            if shift_of(view.offset @ motion.matrix, gray.shape) <= MOVED_SHARE * gray.shape[1]:
                return number
        return None

    def shots(self) -> tuple[Shot, ...]:
        """Return the shots of all frames seen: what a moving camera shows is one shot, cameras are numbered from 0."""
        merged: list[Shot] = []
        run: list[Shot] = []
        for shot in [*self._shots, None]:
            if shot is not None and (_is_short(shot) or (not run and shot.last - shot.first < 2)):
                run.append(shot)
                continue
            merged += _as_moving(run)
            run = []
            if shot is not None:
                merged.append(shot)
        order = {camera: k for k, camera in enumerate(dict.fromkeys(s.camera for s in merged))}
        return tuple(replace(s, camera=order[s.camera]) for s in merged)


def _is_short(shot: Shot) -> bool:
    """Return whether a shot ended at once: the camera keeps moving, or its pictures cannot be compared (noise)."""
    return shot.began is not Change.START and shot.last - shot.first < 2


def _as_moving(run: list[Shot]) -> list[Shot]:
    """Return a run of short shots as one of a moving camera, where it is long enough for that."""
    if len(run) < _MOVING_SHOTS:
        return run
    shift = max(s.shift_share for s in run)
    return [Shot(run[0].first, run[-1].last, run[0].camera, run[0].began, shift, moving=True)]
