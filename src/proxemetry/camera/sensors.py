"""Sensors that exist: their sizes, and how many pixels cameras have put on them.

A focal plane resolution implies a sensor. One that was never built shows that the pixels are not those the camera
stored: the photo was scaled down, or the tag is wrong.

Sizes and the smallest and largest long sides are those of makers' data sheets from 1999 to 2024, as gathered in
lensfun's database, Wikipedia's "Image sensor format" and dpreview's camera timeline; of a pixel-shift composite the
composite's. Formats are named as they are traded.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

#: How far a size by metadata may be from a sensor's: makers count rows that they do not record (Canon's are 3 % off).
TOLERANCE = 0.035
#: For sensors below 13 mm formats lie so close that nearly every size would be one.
_SMALL_TOLERANCE = 0.025
_SMALL_MM = 13.0
#: The widest rectilinear lenses made (Laowa 9 mm, 2023), as 35 mm equivalents, with the rounding of the tag.
WIDEST_EQUIVALENT_MM = 8.7
#: The longest lens in use with people in the picture, and then some: superzooms reach 3000 mm.
LONGEST_EQUIVALENT_MM = 5000.0
#: The diagonal of the 36 x 24 mm frame to which the 35 mm equivalent refers.
FULL_FRAME_DIAGONAL_MM = math.hypot(36, 24)


@dataclass(frozen=True)
class Sensor:
    """A format: width and height in millimetres, and the fewest and most pixels along its long side."""

    name: str
    width_mm: float
    height_mm: float
    fewest_px: int
    most_px: int

    def holds(self, long_mm: float, short_mm: float) -> bool:
        """Whether a picture of this size is the whole of the sensor, or all of one side of it (16:9 out of 3:2)."""
        tolerance = TOLERANCE if self.width_mm >= _SMALL_MM else _SMALL_TOLERANCE
        fills = max(long_mm / self.width_mm, short_mm / self.height_mm)
        return abs(math.log(fills)) <= tolerance


FULL_FRAME = Sensor("35 mm", 36.0, 24.0, 3000, 9600)
SENSORS = (
    Sensor("medium format 54 x 40", 53.7, 40.2, 5000, 14300),
    Sensor("medium format 49 x 37", 48.9, 36.8, 4000, 8000),
    Sensor("medium format 45 x 30", 45.0, 30.0, 7400, 7600),
    Sensor("medium format 44 x 33", 43.9, 33.0, 5400, 11700),
    Sensor("medium format 37 x 37", 36.9, 36.9, 4000, 4100),
    FULL_FRAME,
    Sensor("APS-H", 28.1, 18.8, 2400, 5000),
    Sensor("APS-H", 26.7, 17.8, 3900, 6300),
    Sensor("APS-C", 23.6, 15.7, 2000, 7800),
    Sensor("APS-C (Canon)", 22.5, 15.0, 2100, 7000),
    Sensor("Foveon", 20.7, 13.8, 2200, 2700),
    Sensor("1.5 inch", 18.7, 14.0, 4300, 4400),
    Sensor("4/3 inch", 17.6, 13.2, 2500, 10400),
    Sensor("1 inch", 13.2, 8.8, 3600, 8300),
    Sensor("1/1.12 inch", 11.4, 8.6, 4000, 8200),
    Sensor("1/1.28 inch", 10.0, 7.5, 3900, 12100),
    Sensor("1/1.33 inch", 9.6, 7.2, 3900, 16400),
    Sensor("2/3 inch", 8.8, 6.6, 1200, 4200),
    Sensor("1/1.56 inch", 8.2, 6.1, 3900, 8200),
    Sensor("1/1.7 inch", 7.5, 5.6, 2000, 9300),
    Sensor("1/1.8 inch", 7.18, 5.32, 1600, 8200),
    Sensor("1/2 inch", 6.4, 4.8, 1200, 8100),
    Sensor("1/2.3 inch", 6.17, 4.55, 2500, 5400),
    Sensor("1/2.5 inch", 5.75, 4.3, 1900, 6600),
    Sensor("1/2.7 inch", 5.35, 4.0, 1200, 5200),
    Sensor("1/3 inch", 4.8, 3.6, 600, 4700),
    Sensor("1/3.2 inch", 4.54, 3.4, 1600, 4300),
    Sensor("1/3.6 inch", 4.0, 3.0, 2500, 3700),
    Sensor("1/4 inch", 3.6, 2.7, 600, 3700),
)
#: The most pixels along the long side that a maker has put on a 35 mm sensor, where that is less than any maker has.
MOST_PX_ON_35MM = {"canon": 8800, "nikon": 8300, "panasonic": 8400, "pentax": 7400}


def sensor_of(size_mm: tuple[float, float], size_px: tuple[float, float]) -> Sensor | None:
    """Return the sensor whose whole picture has this size in millimetres and in pixels, None where none was built."""
    long_mm, short_mm = max(size_mm), min(size_mm)
    found = (s for s in SENSORS if s.holds(long_mm, short_mm) and _may_have(s, max(size_px) / long_mm))
    return next(found, None)


def sensors_of_pixels(px_per_mm: float, at_least_mm: float) -> Iterator[Sensor]:
    """Yield the sensors on which pixels of a size have been put and that are no smaller than a part that is known."""
    for sensor in SENSORS:
        if sensor.width_mm >= at_least_mm / (1 + TOLERANCE) and _may_have(sensor, px_per_mm):
            yield sensor


def _may_have(sensor: Sensor, px_per_mm: float) -> bool:
    pixels = px_per_mm * sensor.width_mm
    return sensor.fewest_px / (1 + TOLERANCE) <= pixels <= sensor.most_px * (1 + TOLERANCE)


def may_be_full_frame(make: str | None, long_side_px: float) -> bool:
    """Whether a maker has put so many pixels along the long side of a 35 mm sensor."""
    most = next((m for name, m in MOST_PX_ON_35MM.items() if name in (make or "").lower()), FULL_FRAME.most_px)
    return long_side_px <= most * (1 + TOLERANCE)


def equivalent_mm(f_px: float, diagonal_px: float) -> float:
    """Return the 35 mm equivalent of a focal length in pixels of a picture with this diagonal."""
    return f_px / diagonal_px * FULL_FRAME_DIAGONAL_MM
