"""Where a clip is cut, and whether its camera stays where it is.

The background of each frame is compared with that of the frame a shot began with: corners are followed by optical
flow, and the motion that most of them share is the camera's, since people are the smaller part of a picture and move
each in their own way. A camera that was moved is another camera; one that comes back is the same again.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from enum import StrEnum
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from ..arrays import FloatArray, RGBArray

GrayArray = NDArray[np.uint8]

#: The background is looked at in pictures of this width.
_WIDTH_PX = 480
#: A camera has moved when its picture has by this share of its width: a quarter of a degree of a usual lens, from which
#: on distances are wrong by more than 5 % (PETS 2009: half a degree is 6-7 % along the line of sight).
MOVED_SHARE = 0.0045
#: A camera that has moved again after a frame or two, so many times in a row, is held in a hand or follows a person.
_MOVING_SHOTS = 4
#: So many places are remembered to which a camera may come back.
_MOST_KNOWN = 12
#: Fewer corners than this share that are found again: another picture altogether.
_FOUND_AGAIN = 0.35
_FEWEST_CORNERS = 12
#: The frame that others are compared with is taken anew after this long, so that light may change over a day.
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


@dataclass(frozen=True)
class _Motion:
    """How a picture lies to another: the shift of its corners in pixels, and the share of points found again."""

    shift_px: float
    found: float
    matrix: FloatArray


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
        gray = _small(pixels)
        number, self._count = self._count, self._count + 1
        before, self._previous = self._previous, gray
        if before is None or before.shape != gray.shape:
            self._begin(number, gray, t_s, Change.START if before is None else Change.CUT, 0.0)
            return
        view = self._views[self._shots[-1].camera]
        motion = _motion(view.gray, view.corners, gray)
        limit = MOVED_SHARE * gray.shape[1]
        if motion is None or motion.found < _FOUND_AGAIN:
            step = _motion(before, _corners(before), gray)
            if step is not None and step.found >= _FOUND_AGAIN and step.shift_px < limit:
                # the light changed, or the reference has grown old
                self._views[self._shots[-1].camera] = _View(gray, _corners(gray), t_s, view.offset)
                self._extend(number)
                return
            if step is None and motion is None:  # nothing to hold on to: a blank wall, or darkness
                self._extend(number)
                return
            change = Change.MOVED if step is not None and step.found >= _FOUND_AGAIN else Change.CUT
            shift = math.nan if step is None else step.shift_px
            self._begin(number, gray, t_s, change, (0.0 if change is Change.CUT else shift) / gray.shape[1])
            return
        whole = _shift(view.offset @ motion.matrix, gray.shape)
        if whole > limit:
            self._begin(number, gray, t_s, Change.MOVED, whole / gray.shape[1])
            return
        self._extend(number)
        if t_s - view.t_s > _REFERENCE_S:
            self._views[self._shots[-1].camera] = _View(gray, _corners(gray), t_s, view.offset @ motion.matrix)

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
            self._views[known] = _View(gray, _corners(gray), t_s, np.eye(3))
        self._shots.append(Shot(number, number, known, change, share))

    def _known(self, gray: GrayArray) -> int | None:
        for number, view in list(self._views.items())[-_MOST_KNOWN:]:
            if view.gray.shape != gray.shape:
                continue
            motion = _motion(view.gray, view.corners, gray)
            if motion is None or motion.found < _FOUND_AGAIN:
                continue
            if _shift(view.offset @ motion.matrix, gray.shape) <= MOVED_SHARE * gray.shape[1]:
                return number
        return None

    def shots(self) -> tuple[Shot, ...]:
        """Return the shots of all frames seen: what a moving camera shows is one shot, cameras are numbered from 0."""
        merged: list[Shot] = []
        run: list[Shot] = []
        for shot in [*self._shots, None]:
            if shot is not None and (_is_short(shot) or (not run and shot.last - shot.first < 2)):
                if run and shot.began is not Change.MOVED:
                    merged += _as_moving(run)
                    run = []
                run.append(shot)
                continue
            merged += _as_moving(run)
            run = []
            if shot is not None:
                merged.append(shot)
        order = {camera: k for k, camera in enumerate(dict.fromkeys(s.camera for s in merged))}
        return tuple(replace(s, camera=order[s.camera]) for s in merged)


def _is_short(shot: Shot) -> bool:
    return shot.began is Change.MOVED and shot.last - shot.first < 2


def _as_moving(run: list[Shot]) -> list[Shot]:
    """Return a run of short shots as one of a moving camera, where it is long enough for that."""
    if len(run) < _MOVING_SHOTS:
        return run
    shift = max(s.shift_share for s in run)
    return [Shot(run[0].first, run[-1].last, run[0].camera, run[0].began, shift, moving=True)]


def _small(pixels: RGBArray) -> GrayArray:
    gray = cv2.cvtColor(pixels, cv2.COLOR_RGB2GRAY)
    height, width = gray.shape
    if width <= _WIDTH_PX:
        return gray.astype(np.uint8)
    size = (_WIDTH_PX, max(1, round(height * _WIDTH_PX / width)))
    return cv2.resize(gray, size, interpolation=cv2.INTER_AREA).astype(np.uint8)


def _corners(gray: GrayArray) -> NDArray[np.float32]:
    """Return well-spread corners, shape (n, 1, 2), so that no crowd in one place outvotes the background."""
    found: Any = cv2.goodFeaturesToTrack(gray, 200, 0.01, max(8.0, gray.shape[1] / 40))
    return np.zeros((0, 1, 2), np.float32) if found is None else found.astype(np.float32)


def _motion(before: GrayArray, corners: NDArray[np.float32], now: GrayArray) -> _Motion | None:
    """Return how `now` lies to `before` by most of its corners, None where there is nothing to go by."""
    if len(corners) < _FEWEST_CORNERS:
        return None
    moved, status, _ = cv2.calcOpticalFlowPyrLK(before, now, corners, None)  # pyright: ignore[reportCallIssue, reportArgumentType]
    back, status_back, _ = cv2.calcOpticalFlowPyrLK(now, before, moved, None)  # pyright: ignore[reportCallIssue, reportArgumentType]
    same = np.linalg.norm((back - corners).reshape(-1, 2), axis=1) < 1.0
    good = (status.ravel() > 0) & (status_back.ravel() > 0) & same
    if good.sum() < _FEWEST_CORNERS // 2:
        return _Motion(math.inf, 0.0, np.eye(3))
    fitted: Any = cv2.estimateAffinePartial2D(
        corners[good], moved[good], method=cv2.RANSAC, ransacReprojThreshold=1.0, confidence=0.999
    )
    matrix, inliers = fitted
    if matrix is None:
        return _Motion(math.inf, 0.0, np.eye(3))
    whole = np.vstack([matrix, [0.0, 0.0, 1.0]])
    return _Motion(_shift(whole, now.shape), float(inliers.sum()) / len(corners), whole)


def _shift(matrix: FloatArray, shape: tuple[int, ...]) -> float:
    """Return by how many pixels a motion moves the picture's inside, at most: turning and zooming count too."""
    height, width = shape[:2]
    # half way to the corners: what turns about the middle does not count as if only the corners mattered
    x, y = np.array([0.25, 0.75, 0.25, 0.75]) * width, np.array([0.25, 0.25, 0.75, 0.75]) * height
    points = np.stack([x, y, np.ones(4)])
    return float(np.linalg.norm((matrix @ points - points)[:2], axis=0).max())
