"""What a drone records about its camera: height above the start and the gimbal's angles, in XMP or in subtitles."""

from __future__ import annotations

import math
import re
from pathlib import Path

from ..camera import Camera, Mount
from ..camera.drone import ANGLE_SD_RAD, HEIGHT_REL_SD, HEIGHT_SD_M
from ..errors import CameraError
from ..files import open_file, read_bytes

#: DJI's XMP as attributes or elements (`drone-dji:RelativeAltitude="+30.10"`).
_XMP = re.compile(
    rb"drone-dji:(RelativeAltitude|GimbalPitchDegree|GimbalRollDegree)\s*(?:=\s*\"|>)\s*([+-]?\d+(?:\.\d+)?)"
)
#: DJI's subtitles: `[rel_alt: 30.100 abs_alt: 95.2]`, `[gb_yaw: 12.0 gb_pitch: -90.0 gb_roll: 0.0]`.
_SRT = re.compile(r"(rel_alt|gb_pitch|gb_roll)\s*[:=]\s*([+-]?\d+(?:\.\d+)?)")
_XMP_WITHIN = 1 << 20


def from_xmp(path: str | Path, camera: Camera | None = None) -> Mount | None:
    """Return where a drone's photo was taken from, or None where its file does not state it."""
    with open_file(path) as file:
        found = dict(_XMP.findall(file.read(_XMP_WITHIN)))
    height, pitch = found.get(b"RelativeAltitude"), found.get(b"GimbalPitchDegree")
    if height is None or pitch is None:
        return None
    return _mount(float(height), float(pitch), float(found.get(b"GimbalRollDegree", b"0")), camera, "drone's XMP")


def from_subtitles(path: str | Path, camera: Camera | None = None) -> Mount:
    """Return where a drone hovered while it filmed, from its .SRT file.

    Raises CameraError where the file does not state it, or the drone moved: then there is no one place.
    """
    try:
        text = read_bytes(path).decode(errors="replace")
    except OSError as error:
        raise CameraError(f"{path}: cannot be read ({error.strerror})") from error
    values: dict[str, list[float]] = {"rel_alt": [], "gb_pitch": [], "gb_roll": []}
    for name, value in _SRT.findall(text):
        values[name].append(float(value))
    if not values["rel_alt"] or not values["gb_pitch"]:
        raise CameraError(f"{path}: no rel_alt and gb_pitch in it: state --height-m and --pitch-deg")
    if _range(values["rel_alt"]) > 1.0 or _range(values["gb_pitch"]) > 2.0:
        raise CameraError(
            f"{path}: the drone moved (height by {_range(values['rel_alt']):.1f} m, pitch by "
            f"{_range(values['gb_pitch']):.1f} degrees): a mount is for a camera that does not move"
        )
    height, pitch, roll = (sum(v) / len(v) if v else 0.0 for v in values.values())
    return _mount(height, pitch, roll, camera, "drone's subtitles")


def _range(values: list[float]) -> float:
    return max(values) - min(values)


def _mount(height_m: float, gimbal_pitch_deg: float, roll_deg: float, camera: Camera | None, source: str) -> Mount:
    if not height_m > 0:
        raise CameraError(f"{source}: the height above the start is {height_m:g} m: state --height-m above the floor")
    pitch = max(-90.0, min(90.0, -gimbal_pitch_deg))
    return Mount.stated(
        math.radians(pitch), math.radians(roll_deg), height_m, pitch_sd_rad=ANGLE_SD_RAD, roll_sd_rad=ANGLE_SD_RAD,
        height_sd_m=max(HEIGHT_SD_M, HEIGHT_REL_SD * height_m), camera=camera, source=source,
    )  # fmt: skip
