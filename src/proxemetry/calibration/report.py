"""A calibration for the user to judge: its numbers, what half a degree does, and the floor drawn on the picture."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from ..arrays import FloatArray
from ..camera import Mount
from ..camera.floor_view import horizon, reach, to_floor, to_pixels
from ..photo import RGBArray

#: Distances ahead of the camera at which the pitch's effect is stated, and by how much it is off there for example.
TOLD_AT_M = (10.0, 25.0)
HALF_A_DEGREE_RAD = math.radians(0.5)
#: A pitch that puts people so much further or nearer, as a part of their distance, should be measured with points.
POOR_REL = 0.05
TAKE_POINTS = "not good enough for distances along the line of sight: take four points on the floor (--points)"

_GRID_RGB, _TEN_RGB, _HORIZON_RGB, _POINT_RGB = (64, 200, 255), (255, 214, 64), (255, 80, 80), (80, 255, 120)
_NEAREST_CELLS_PX = 6.0


def lines_of(mount: Mount, distances_m: tuple[float, ...] = ()) -> Iterator[str]:
    """Yield what was found in words; distances_m: how far away people are, nearest first, if that is known."""
    yield f"height  {_pm(mount.height_m, mount.height_sd_m, 'm above the floor')}"
    yield f"pitch   {_pm(math.degrees(mount.pitch_rad), math.degrees(mount.sd[0]), 'degrees down')}"
    yield f"roll    {_pm(math.degrees(mount.roll_rad), math.degrees(mount.sd[1]), 'degrees')}"
    if mount.camera is not None:
        sd = mount.sd[3] if math.isfinite(mount.sd[3]) else mount.camera.focal_rel_sd
        yield f"lens    {mount.camera.f_px:.0f} px +- {100 * sd:.1f} % ({mount.camera.source})"
    yield f"from    {mount.source}"
    if not (math.isfinite(mount.pitch_rad) and math.isfinite(mount.height_m)):
        return
    for away in TOLD_AT_M:
        half = abs(reach(mount, away, -HALF_A_DEGREE_RAD))
        yield (
            f"at {away:.0f} m  half a degree of pitch moves a person by {_metres(half)}; this calibration's own "
            f"uncertainty of pitch and height together by {_metres(doubt_m(mount, away))}"
        )
    if is_poor(mount, distances_m):
        yield TAKE_POINTS


def is_poor(mount: Mount, distances_m: tuple[float, ...] = ()) -> bool:
    """Return whether a mount's doubt puts people more than `POOR_REL` of their distance wrong.

    They are taken to be at the middle of the distances given, or where the middle of the lower half of the picture is.
    """
    away = [d for d in distances_m if math.isfinite(d)]
    middle = away[len(away) // 2] if away else _lower_middle(mount)
    return math.isfinite(middle) and doubt_m(mount, middle) > POOR_REL * middle


def doubt_m(mount: Mount, distance_m: float) -> float:
    """Return the error of a place so far ahead from the uncertainty of pitch and height, one sd.

    They go together: before a measured floor a camera may be higher and look down more steeply, or less of both.
    With h cot(b) for the distance, b the angle below the horizon, its slopes are -h / sin(b)^2 and, by log h, itself.
    """
    covariance = np.array(mount.covariance)[np.ix_([0, 2], [0, 2])]
    if not math.isfinite(covariance[1, 1]):
        covariance = np.diag([covariance[0, 0], 0.0])
    slopes = np.array([-(mount.height_m**2 + distance_m**2) / mount.height_m, distance_m])
    return math.sqrt(max(0.0, float(slopes @ covariance @ slopes)))


def _lower_middle(mount: Mount) -> float:
    if mount.camera is None or not math.isfinite(mount.roll_rad):
        return math.nan
    return float(np.linalg.norm(to_floor(mount, (mount.camera.width / 2, 0.75 * mount.camera.height))))


def _pm(value: float, sd: float, unit: str) -> str:
    return f"{value:.2f} +- {sd:.2f} {unit}" if math.isfinite(value) else "unknown"


def _metres(value: float) -> str:
    return f"{value:.2f} m" if math.isfinite(value) else "any distance"


def floor_drawn(pixels: RGBArray, mount: Mount, points_px: FloatArray | None = None, reach_m: float = 40.0) -> RGBArray:
    """Return a picture with the floor's metre grid, every tenth line stronger, the horizon, and points that were given.

    Grid lines are those of the user's floor coordinates where the mount has them. Lines too close together to tell
    apart are left out: only every tenth is drawn there.
    """
    from PIL import Image, ImageDraw

    image = Image.fromarray(pixels)
    draw = ImageDraw.Draw(image)
    width = max(1, round(max(pixels.shape[:2]) / 900))
    for line, tenth in grid_lines(mount, (pixels.shape[1], pixels.shape[0]), reach_m):
        colour = _TEN_RGB if tenth else _GRID_RGB
        draw.line([tuple(p) for p in line.tolist()], fill=colour, width=width * (2 if tenth else 1))
    ends = horizon(mount)
    if ends is not None:
        draw.line(ends, fill=_HORIZON_RGB, width=2 * width)
    for u, v in () if points_px is None else np.asarray(points_px).reshape(-1, 2):
        r = 5 * width
        draw.ellipse((u - r, v - r, u + r, v + r), outline=_POINT_RGB, width=2 * width)
    return np.asarray(image)


def grid_lines(
    mount: Mount, size_px: tuple[int, int], reach_m: float = 40.0, samples: int = 321
) -> Iterator[tuple[FloatArray, bool]]:
    """Yield the stretches (N, 2) of the floor's metre lines that lie near a picture of this size, in pixels, and
    whether each is a tenth line.

    Lines that are too close together to tell apart are left out: only every tenth is there. Raises CameraError where
    the mount does not know the floor's place.
    """
    for line, tenth in _grid(mount, reach_m, samples):
        for part in _runs(line, *size_px):
            yield part, tenth


def _grid(mount: Mount, reach_m: float, samples: int) -> Iterator[tuple[FloatArray, bool]]:
    """Yield the pixels (N, 2) of every grid line, NaN behind the camera, and whether it is a tenth one."""
    frame = mount.floor_frame
    middle = np.zeros(2) if frame is None else np.array([frame.x_m, frame.y_m])
    along = np.linspace(-reach_m, reach_m, samples)
    for axis in (0, 1):
        for k in range(math.ceil(middle[axis] - reach_m), math.floor(middle[axis] + reach_m) + 1):
            line = np.empty((len(along), 2))
            line[:, axis], line[:, 1 - axis] = k, middle[1 - axis] + along
            next_line = line.copy()
            next_line[:, axis] += 1.0
            seen, next_seen = (to_pixels(mount, p if frame is None else frame.from_user(p)) for p in (line, next_line))
            tenth = k % 10 == 0
            if not tenth:
                seen[np.linalg.norm(seen - next_seen, axis=1) < _NEAREST_CELLS_PX] = np.nan
            yield seen, tenth


def _runs(line: FloatArray, width: int, height: int) -> Iterator[FloatArray]:
    """Yield the stretches of a line that lie near the picture."""
    margin = max(width, height)
    good = (
        np.isfinite(line).all(axis=1)
        & (line > -margin).all(axis=1)
        & (line < (width + margin, height + margin)).all(axis=1)
    )
    edges = np.flatnonzero(np.diff(np.concatenate([[0], good.astype(int), [0]])))
    for begin, end in edges.reshape(-1, 2):
        if end - begin > 1:
            yield line[begin:end]
