"""What the user states of the cameras of a run."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, cast

from ..errors import SettingsError
from .table import LENGTH_BOUNDS, CameraTable


@dataclass(frozen=True)
class FocalRequest:
    """What the user states about the camera, for all photos of a run; None where nothing is stated.

    focal_mm with sensor_mm (width, height of the sensor in millimetres), focal_35mm, or focal_px; sensor_mm alone
    goes with each photo's own focal length. assume_fov_deg is the field of view, across the photo's long side, to
    assume where nothing else is known. camera_table: what is known about single photos or cameras, which takes
    precedence over the rest. assume: whether a photo of unknown focal length is taken to be like published photos
    are, with an interval to match; without it such a photo has no distances.

    Raises SettingsError where two statements contradict each other or a value is not positive.
    """

    focal_mm: float | None = None
    focal_35mm: float | None = None
    focal_px: float | None = None
    sensor_mm: tuple[float, float] | None = None
    assume_fov_deg: float | None = None
    camera_table: CameraTable | None = None
    assume: bool = True

    def __post_init__(self) -> None:
        for name in ("focal_mm", "focal_35mm", "focal_px", "sensor_mm", "assume_fov_deg"):
            object.__setattr__(self, name, _as_python(getattr(self, name)))
        stated = {"--focal-mm": self.focal_mm, "--focal-35mm": self.focal_35mm, "--focal-px": self.focal_px}
        stated = {option: value for option, value in stated.items() if value is not None}
        for option, value in stated.items():
            if not _is_positive(value):
                raise SettingsError(
                    f"{option} is {value!r}: it must be a positive number, {LENGTH_BOUNDS[0]:g} to {LENGTH_BOUNDS[1]:g}"
                )
        if len(stated) > 1:
            raise SettingsError(f"{' and '.join(stated)} state the focal length twice: leave one out")
        if self.sensor_mm is not None:
            if not _are_sides(self.sensor_mm):
                raise SettingsError(f"--sensor-mm is {self.sensor_mm!r}: it must be two positive numbers, WxH")
            if stated and "--focal-mm" not in stated:
                raise SettingsError(f"--sensor-mm means nothing together with {next(iter(stated))}: leave one out")
        if self.assume_fov_deg is not None and not (
            _is_positive(self.assume_fov_deg) and 1 <= self.assume_fov_deg <= 170
        ):
            raise SettingsError(f"--assume-fov is {self.assume_fov_deg}: it must be 1 to 170 degrees")

    @property
    def states_focal(self) -> bool:
        """Whether a focal length is stated for all photos, and not only assumed."""
        return (self.focal_mm, self.focal_35mm, self.focal_px) != (None, None, None)


def _as_python(value: Any) -> Any:
    """Return what an array or an element of one holds as Python's own numbers, anything else as it is."""
    value = value.tolist() if hasattr(value, "tolist") else value
    return tuple(map(_as_python, value)) if isinstance(value, list | tuple) else value  # pyright: ignore[reportUnknownArgumentType,reportUnknownVariableType]


def _is_positive(value: object) -> bool:
    return isinstance(value, int | float) and math.isfinite(value) and LENGTH_BOUNDS[0] <= value <= LENGTH_BOUNDS[1]


def _are_sides(value: object) -> bool:
    if not isinstance(value, Sequence) or isinstance(value, str):
        return False
    return len(sides := cast("Sequence[object]", value)) == 2 and all(map(_is_positive, sides))
