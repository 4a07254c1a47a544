"""A camera's place from what is clicked and typed on a picture: found, and returned in pixels for the page to draw."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, cast

import numpy as np

from ..archive.review.actions import camera_request
from ..arrays import FloatArray
from ..calibration.lengths import Length, with_lengths
from ..calibration.lens import lens_of, with_open_principal
from ..calibration.points import FloorPoints, from_points, open_camera
from ..calibration.report import TAKE_POINTS, grid_lines, is_poor, lines_of
from ..camera import Camera, Mount
from ..camera.floor_view import horizon, to_floor, to_pixels
from ..errors import CameraError, SettingsError
from ..photo import Photo
from ..scene import Scene

#: What one picture is clicked at most, and how finely the page draws grid lines.
MOST_MARKS = 200
_REACH_M, _SAMPLES = 40.0, 81
_FEWEST_POINTS, _FEWEST_LENGTHS = 4, 2


@dataclass(frozen=True, eq=False)
class Clicked:
    """What the page sends: points, shape (N, 4), of u, v, x, y; lengths; what is stated of the lens, or None."""

    points: FloatArray
    lengths: tuple[Length, ...] = ()
    lens: Mapping[str, Any] | None = None

    @classmethod
    def parsed(cls, fields: Mapping[str, Any]) -> Clicked:
        """Read {points: [[u, v, x, y], ...], lengths: [[u, v, u, v, metres], ...], lens: {focal_px: ...} or null}.

        Raises SettingsError for anything else, CameraError for numbers that are no length.
        """
        points, lengths = (_rows(fields.get(name), name, width) for name, width in (("points", 4), ("lengths", 5)))
        lens = fields.get("lens")
        if lens is not None and not isinstance(lens, Mapping):
            raise SettingsError("calibration: lens is what a focal length is stated as, or null")
        return cls(
            np.array(points, dtype=float).reshape(-1, 4), tuple(Length(*row) for row in lengths),
            cast("Mapping[str, Any] | None", lens),
        )  # fmt: skip


def _rows(value: object, name: str, width: int) -> list[list[float]]:
    rows = [] if value is None else value
    if not isinstance(rows, list) or len(cast("list[object]", rows)) > MOST_MARKS:
        raise SettingsError(f"calibration: {name} is a list of at most {MOST_MARKS}")
    for row in cast("list[object]", rows):
        numbers = isinstance(row, list) and all(
            isinstance(v, int | float) and not isinstance(v, bool) and math.isfinite(v) and abs(v) < 1e7
            for v in cast("list[object]", row)
        )
        if not numbers or len(cast("list[object]", row)) != width:
            raise SettingsError(f"calibration: each of {name} is {width} finite numbers")
    return cast("list[list[float]]", rows)


def lens(scene: Scene, stated: Mapping[str, Any] | None) -> tuple[Camera, bool]:
    """Return the lens of a scene's photo, as stated or as it was measured with, and whether its focal length is known.

    Raises SettingsError for an invalid statement.
    """
    if stated is not None:
        return lens_of(Photo(scene.photo, scene.width_px, scene.height_px, scene.sha256), camera_request(stated))
    camera = scene.camera.camera
    known = camera is not None and not scene.camera.is_assumed
    return with_open_principal(camera if known and camera else open_camera(scene.width_px, scene.height_px)), known


def found(scene: Scene, clicked: Clicked) -> dict[str, Any]:
    """Return what was found as JSON values: the mount, what it says, and everything to draw.

    Of less than it takes the status is "waiting", with what is missing. Raises CameraError where points and lengths
    determine no camera.
    """
    camera, known = lens(scene, clicked.lens)
    about = {"focal_px": round(camera.f_px, 1) if known else None, "source": str(camera.source) if known else None}
    missing = _missing(clicked, known)
    if missing:
        return {"status": "waiting", "text": missing, "lens": about}
    mount, wrong, notes, away = _mount(clicked, camera, known)
    if is_poor(mount):
        notes.append("not good enough for distances along the line of sight: add points, near and far, left and right")
    return {
        "status": "found",
        "lens": about,
        "lines": [line for line in lines_of(mount) if line != TAKE_POINTS],
        "notes": notes,
        "points": _points(mount, clicked.points, wrong),
        "lengths": [
            {"metres": length.metres, "comes_out_m": _number(length.metres - off, 3)}
            for length, off in zip(clicked.lengths, away, strict=True)
        ],
        "grid": [
            {"line": np.round(line, 1).tolist(), "tenth": tenth}
            for line, tenth in grid_lines(mount, (scene.width_px, scene.height_px), _REACH_M, _SAMPLES)
        ],
        "horizon": horizon(mount),
        "mount": mount.to_dict(),
    }


def _missing(clicked: Clicked, known: bool) -> str | None:
    """Return what it still takes, None where there is enough."""
    points, lengths = len(clicked.points), len(clicked.lengths)
    if points >= _FEWEST_POINTS or (points == 0 and lengths >= _FEWEST_LENGTHS and known):
        return None
    more = _FEWEST_POINTS - points
    said = f"{more} more point{'' if more == 1 else 's'} of the floor"
    if points == 0 and lengths >= _FEWEST_LENGTHS:
        return f"{said}, or state the focal length: lengths do not determine it"
    if points == 0 and lengths:
        return f"{said}, or one more taped length"
    return said


def _mount(clicked: Clicked, camera: Camera, known: bool) -> tuple[Mount, tuple[int, ...], list[str], Sequence[float]]:
    """Return the mount, which points (from 0) are wrong, what is to be said, and how much longer lengths were taped."""
    wrong: tuple[int, ...] = ()
    notes: list[str] = []
    if len(clicked.points):
        fit = from_points(FloorPoints(clicked.points[:, :2], clicked.points[:, 2:]), camera, focal_known=known)
        mount, wrong = fit.mount, tuple(k - 1 for k in fit.wrong)
        if fit.spread > 1.5:
            notes.append(
                f"the points are off by {fit.spread:.1f} times what click and tape explain: the intervals are wider"
            )
        if len(clicked.points) == _FEWEST_POINTS:
            notes.append("four points always fit nearly: a fifth one shows whether they are right")
    else:
        mount = Mount(camera=camera, size_px=(camera.width, camera.height))
    if not clicked.lengths:
        return mount, wrong, notes, ()
    mount, away = with_lengths(mount, clicked.lengths)
    return mount, wrong, notes, away.tolist()


def _points(mount: Mount, points: FloatArray, wrong: Sequence[int]) -> list[dict[str, Any]]:
    frame = mount.floor_frame
    if frame is None:
        return []
    seen = to_pixels(mount, frame.from_user(points[:, 2:]))
    there = frame.to_user(to_floor(mount, points[:, :2]))
    off_px, off_m = (np.linalg.norm(d, axis=1) for d in (points[:, :2] - seen, there - points[:, 2:]))
    return [
        {
            "seen": [_number(v, 1) for v in at],
            "off_px": _number(px, 1),
            "off_m": _number(m, 3),
            "wrong": k in wrong,
        }
        for k, (at, px, m) in enumerate(zip(seen.tolist(), off_px.tolist(), off_m.tolist(), strict=True))
    ]


def _number(value: float, digits: int) -> float | None:
    return round(value, digits) if math.isfinite(value) else None


def mount_of(scene: Scene, clicked: Clicked) -> Mount:
    """Return the mount alone, to be written; raises CameraError where there is none yet."""
    fields = found(scene, clicked)
    if fields["status"] != "found":
        raise CameraError(f"there is no camera yet: {fields['text']}")
    return Mount.from_dict(fields["mount"])
