"""Where a drone's photo was taken from, as the drone recorded it in the file: its height and its gimbal's angles."""

from __future__ import annotations

import math

from ..photo.metadata import Flight
from .mount import Mount

#: A gimbal holds its angle to about a degree against gravity; a barometer drifts by a metre or so in a flight, and
#: ground is not level with the place of the start.
ANGLE_SD_RAD, HEIGHT_SD_M, HEIGHT_REL_SD = math.radians(1.0), 1.0, 0.03
#: A smaller height above the take-off point is ignored: the drone is in a hand, or people stand lower than it started.
LEAST_HEIGHT_M = 1.0
#: A gimbal holds its camera level: a roll beyond this is one held for an upright picture, or looks straight down and
#: calls a turn a roll. A smaller one, whose sign makers do not state, is how far off level it may be.
_MOST_ROLL_DEG, _LEAST_PITCH_DEG, _MOST_PITCH_DEG = 30.0, -90.5, 60.0
#: The source that a mount made of it states.
SOURCE = "the drone's file"


def flight_mount(flight: Flight | None) -> Mount | None:
    """Return the camera's place from a file's flight data, None where they have none that is possible.

    Pitch, roll and height may each be missing. The height is the one above the take-off point: where people stand
    higher or lower, they contradict it, and prevail.
    """
    if flight is None:
        return None
    pitch, roll, height = flight.gimbal_pitch_deg, flight.gimbal_roll_deg, flight.height_m
    if pitch is None or not _LEAST_PITCH_DEG <= pitch <= _MOST_PITCH_DEG:
        return None  # height alone, from a camera that looks anywhere, is not worth the risk of a broken record
    known = height is not None and height >= LEAST_HEIGHT_M
    height_m = height if known and height is not None else math.nan
    level = roll is not None and abs(roll) <= _MOST_ROLL_DEG
    return Mount.stated(
        math.radians(max(-90.0, min(90.0, -pitch))),
        0.0 if level else math.nan,
        height_m,
        pitch_sd_rad=ANGLE_SD_RAD, roll_sd_rad=max(ANGLE_SD_RAD, math.radians(abs(roll or 0.0))),
        height_sd_m=max(HEIGHT_SD_M, HEIGHT_REL_SD * height_m) if known else None, source=SOURCE,
    )  # fmt: skip
