"""Where a camera is: its pitch, roll and height above the floor, each known or not, and how well.

A mount is stated by hand or by a phone's sensor, measured by `proxemetry calibrate`, or found from straight lines. It
enters the scene fit as what is known of the camera before the people are seen.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from ..arrays import FloatArray
from ..errors import CameraError
from ..files import read_json
from .camera import Camera
from .floor_frame import FloorFrame
from .mount_fields import camera_of, finite, floor_frame_of, nan_if_unknown, radians, significant, size_of

#: Name and version of the JSON form; the version changes when the meaning of a field does.
SCHEMA = "proxemetry.mount/1"

#: The unknowns that a mount's covariance is about, in this order.
UNKNOWNS = ("pitch", "roll", "log height", "log focal length")

#: Standard deviations where a number is stated without one: a phone's or a bubble level's angle, a height by tape.
STATED_ANGLE_SD_RAD = math.radians(1.0)
STATED_HEIGHT_REL_SD = 0.03

_N = len(UNKNOWNS)
_PARTS = ("pitch_rad", "roll_rad", "height_m")
#: Heights that no camera is below or above, metres (an airliner flies at ten thousand), and what no angle or logarithm
#: is uncertain by.
_LOWEST_M, _HIGHEST_M, _LARGEST_SD = 0.01, 1e5, 10.0
_NOTHING = ((math.nan,) * _N,) * _N


@dataclass(frozen=True)
class Mount:
    """A camera's place above a level floor; NaN where a part of it is unknown.

    pitch_rad, roll_rad: as in `bodies.Floor`, a positive pitch looks down. height_m: of the camera above the floor.
    covariance: shape (4, 4), of pitch and roll (radians), the logarithm of the height and that of the focal length;
    NaN in the rows and columns of what is unknown. camera: the intrinsics that were found together with the place, or
    used to find it; None if it was stated without any. The last of `UNKNOWNS` is known only where `camera`
    is. size_px: width and height of the photos that it applies to, None for any. source: where it came from.
    floor_frame: the user's floor coordinates, where points of the floor were given.

    Raises CameraError where a number is not finite, a height not positive, or a covariance no covariance.
    """

    pitch_rad: float = math.nan
    roll_rad: float = math.nan
    height_m: float = math.nan
    covariance: tuple[tuple[float, ...], ...] = _NOTHING
    camera: Camera | None = None
    size_px: tuple[int, int] | None = None
    source: str = "stated"
    floor_frame: FloorFrame | None = None

    def __post_init__(self) -> None:
        for name in ("pitch_rad", "roll_rad", "height_m"):
            value = float(getattr(self, name))
            if math.isinf(value):
                raise CameraError(f"mount {name} is {value}: it must be a finite number, or NaN where it is unknown")
            object.__setattr__(self, name, math.nan if math.isnan(value) else value)
        if self.height_m <= 0:
            raise CameraError(f"mount height is {self.height_m:g} m: the camera must be above the floor")
        if self.height_m < _LOWEST_M or self.height_m > _HIGHEST_M or abs(self.roll_rad) > math.radians(360):
            raise CameraError(
                f"mount height is {self.height_m:g} m, roll {self.roll_rad:g} rad: no camera is placed like that"
            )
        if abs(self.pitch_rad) > math.radians(90.001):
            raise CameraError(f"mount pitch is {math.degrees(self.pitch_rad):g} degrees: it must be -90 to 90")
        if self.camera is not None:
            size = (self.camera.width, self.camera.height)
            if self.size_px not in (None, size):
                raise CameraError(f"mount of {self.size_px} pixels with a camera of {size}: they must be one size")
            object.__setattr__(self, "size_px", size)
        self._check_covariance()

    def _check_covariance(self) -> None:
        matrix = np.array(self.covariance, dtype=float)
        if matrix.shape != (_N, _N):
            raise CameraError(f"mount covariance has shape {matrix.shape}: it must be {_N} x {_N}")
        known = np.isfinite(np.diag(matrix))
        stated = np.isfinite([self.pitch_rad, self.roll_rad, self.height_m, 0.0 if self.camera else math.nan])
        if (stated[:3] != known[:3]).any() or (known[3] and not stated[3]):
            name = UNKNOWNS[int(np.flatnonzero(stated != known)[0])]
            raise CameraError(f"mount covariance: the {name} is stated without its variance, or the other way round")
        block = matrix[np.ix_(known, known)]
        if np.diag(block).max(initial=0) > _LARGEST_SD**2:
            raise CameraError("mount: a standard deviation is larger than anything it could be about")
        if (
            not np.isfinite(block).all()
            or not np.allclose(block, block.T)
            or np.linalg.eigvalsh(block).min(initial=0) < -1e-12
        ):
            raise CameraError("mount covariance: it must be symmetric and positive")
        matrix = np.where(known[:, None] & known, (matrix + matrix.T) / 2, np.nan)
        rows = cast("list[list[float]]", matrix.tolist())
        plain = tuple(tuple(math.nan if math.isnan(v) else v for v in row) for row in rows)
        object.__setattr__(self, "covariance", plain)

    @classmethod
    def stated(
        cls, pitch_rad: float = math.nan, roll_rad: float = math.nan, height_m: float = math.nan, *,
        pitch_sd_rad: float = STATED_ANGLE_SD_RAD, roll_sd_rad: float = STATED_ANGLE_SD_RAD,
        height_sd_m: float | None = None, camera: Camera | None = None, size_px: tuple[int, int] | None = None,
        source: str = "stated", floor_frame: FloorFrame | None = None,
    ) -> Mount:  # fmt: skip
        """Return the mount of independent values, each with its standard deviation; the lens is given separately."""
        height_sd = STATED_HEIGHT_REL_SD if height_sd_m is None or not height_m else height_sd_m / height_m
        sd = [
            value if math.isfinite(stated) else math.nan
            for value, stated in ((pitch_sd_rad, pitch_rad), (roll_sd_rad, roll_rad), (height_sd, height_m))
        ]
        if any(value < 0 or math.isinf(value) for value in sd):
            raise CameraError("mount: a standard deviation is a finite number, 0 or more")
        matrix = np.full((_N, _N), np.nan)
        known = np.flatnonzero(np.isfinite(sd))
        matrix[np.ix_(known, known)] = np.diag(np.square(np.array(sd)[known]))
        rows = tuple(tuple(row) for row in matrix.tolist())
        return cls(pitch_rad, roll_rad, height_m, rows, camera, size_px, source, floor_frame)

    @property
    def known(self) -> NDArray[np.intp]:
        """Which of `UNKNOWNS` are known."""
        return np.flatnonzero(np.isfinite(np.diag(np.array(self.covariance))))

    @property
    def sd(self) -> FloatArray:
        """Standard deviations of `UNKNOWNS`, shape (4,): radians and relative; NaN where unknown."""
        return np.sqrt(np.diag(np.array(self.covariance)))

    @property
    def height_sd_m(self) -> float:
        """The standard deviation of the height, metres."""
        return self.height_m * float(self.sd[2])

    def completed_by(self, other: Mount) -> Mount:
        """Return the mount with its unknown pitch, roll and height taken from another, independent mount."""
        missing = [k for k in other.known.tolist() if k < _N - 1 and k not in self.known]
        if not missing:
            return self
        mine, theirs = np.array(self.covariance), np.array(other.covariance)
        known = self.known
        for k in missing:
            mine[k, known] = mine[known, k] = 0.0
        mine[np.ix_(missing, missing)] = theirs[np.ix_(missing, missing)]
        taken = {name: getattr(other, name) for k, name in enumerate(_PARTS) if k in missing}
        source = f"{self.source}, and {other.source}" if len(known) else other.source
        return replace(self, **taken, covariance=tuple(map(tuple, mine.tolist())), source=source)

    def resized(self, width: int, height: int) -> Mount:
        """Return the mount of the same photos resized."""
        camera = None if self.camera is None else self.camera.resized(width, height)
        return replace(self, camera=camera, size_px=(width, height))

    def mirrored(self) -> Mount:
        """Return the mount of the photos flipped left to right."""
        flip = np.array([1.0, -1.0, 1.0, 1.0])
        turned = np.array(self.covariance) * flip * flip[:, None]
        frame = self.floor_frame
        if frame is not None:  # what was to the right is to the left
            yaw = math.remainder(frame.yaw_rad + math.pi, 2 * math.pi)
            frame = replace(frame, yaw_rad=yaw, mirrored=not frame.mirrored)
        camera = None if self.camera is None else self.camera.mirrored()
        rows = tuple(tuple(row) for row in turned.tolist())
        return replace(self, roll_rad=-self.roll_rad, covariance=rows, camera=camera, floor_frame=frame)

    def widened(self, factor: float) -> Mount:
        """Return the mount with every standard deviation multiplied."""
        rows = tuple(tuple(v * factor**2 for v in row) for row in self.covariance)
        return replace(self, covariance=rows)

    def check_size(self, width: int, height: int) -> None:
        """Raise CameraError if the mount belongs to photos of another size."""
        if self.size_px is not None and self.size_px != (width, height):
            raise CameraError(
                f"the mount is of photos of {self.size_px[0]} x {self.size_px[1]} pixels, this one has {width} x "
                f"{height}: calibrate the camera at that size, or give mount.resized({width}, {height}) if the photo "
                "was only resized"
            )

    def to_dict(self) -> dict[str, Any]:
        """Return the mount as JSON values, angles in degrees; unknown parts are None."""
        sd = self.sd
        covariance = np.array(self.covariance)
        scale = np.where(sd > 0, sd, 1.0)
        correlation = [[significant(v) for v in row] for row in (covariance / scale / scale[:, None]).tolist()]
        size = self.size_px or (None, None)
        camera = None if self.camera is None else asdict(self.camera)
        frame = self.floor_frame
        return {
            "schema": SCHEMA,
            "source": self.source,
            "width_px": size[0],
            "height_px": size[1],
            "pitch_deg": significant(math.degrees(self.pitch_rad)),
            "roll_deg": significant(math.degrees(self.roll_rad)),
            "height_m": significant(self.height_m),
            "pitch_sd_deg": significant(math.degrees(sd[0])),
            "roll_sd_deg": significant(math.degrees(sd[1])),
            "height_sd_m": significant(self.height_sd_m),
            "focal_rel_sd": significant(float(sd[3])),
            "correlation": correlation,
            "camera": camera,
            "floor_frame": None if frame is None else {
                "x_m": frame.x_m, "y_m": frame.y_m, "yaw_deg": significant(math.degrees(frame.yaw_rad)),
                "mirrored": frame.mirrored,
            },
        }  # fmt: skip

    @classmethod
    def from_dict(cls, fields: Mapping[str, Any]) -> Mount:
        """Read what `to_dict` wrote, or the few fields that another program knows; raises CameraError for any other.

        Standard deviations that are left out are those of `stated`, correlations that are left out are 0.
        """
        schema = fields.get("schema")
        if schema != SCHEMA:
            raise CameraError(f"mount of schema {schema!r}: this version reads {SCHEMA!r}")
        if unknown := [name for name in fields if name not in _FIELDS]:
            raise CameraError(f"field {unknown[0]!r} is unknown; fields are {', '.join(_FIELDS)}")
        value = {name: finite(fields, name) for name in _NUMBERS}
        mount = cls.stated(
            radians(value["pitch_deg"]), radians(value["roll_deg"]), nan_if_unknown(value["height_m"]),
            pitch_sd_rad=radians(value["pitch_sd_deg"], STATED_ANGLE_SD_RAD),
            roll_sd_rad=radians(value["roll_sd_deg"], STATED_ANGLE_SD_RAD),
            height_sd_m=value["height_sd_m"], camera=camera_of(fields.get("camera")),
            size_px=size_of(fields), source=str(fields.get("source") or "stated"),
        )  # fmt: skip
        mount = replace(mount, floor_frame=floor_frame_of(fields.get("floor_frame")))
        return replace(mount, covariance=_covariance(mount, value["focal_rel_sd"], fields.get("correlation")))

    def write(self, path: str | Path) -> None:
        """Write the mount as a JSON file."""
        text = json.dumps(self.to_dict(), indent=2, allow_nan=False)
        Path(path).write_text(text + "\n", encoding="utf-8")

    @classmethod
    def read(cls, path: str | Path) -> Mount:
        """Read a JSON file; raises CameraError, in one line that names the file, where it is no mount."""
        try:
            fields = read_json(path)
        except OSError as error:
            raise CameraError(f"{path}: cannot be read ({error.strerror})") from error
        except ValueError as error:
            raise CameraError(f"{path}: no JSON ({error})") from error
        if not isinstance(fields, dict):
            raise CameraError(f"{path}: no mount of a camera: it must be one JSON object")
        try:
            return cls.from_dict(cast("dict[str, Any]", fields))
        except CameraError as error:
            raise CameraError(f"{path}: {error}") from error


_NUMBERS = ("pitch_deg", "roll_deg", "height_m", "pitch_sd_deg", "roll_sd_deg", "height_sd_m", "focal_rel_sd")
_FIELDS = ("schema", "source", "width_px", "height_px", *_NUMBERS, "correlation", "camera", "floor_frame")


def _covariance(mount: Mount, focal_rel_sd: float | None, correlation: Any) -> tuple[tuple[float, ...], ...]:
    """Return the covariance of a mount's standard deviations with the correlations and the focal length's own."""
    sd = mount.sd
    if focal_rel_sd is not None and mount.camera is not None:
        sd[3] = focal_rel_sd
    try:
        between = np.eye(_N) if correlation is None else np.array(cast("Sequence[Any]", correlation), dtype=float)
    except (TypeError, ValueError) as error:
        raise CameraError(f"correlation: {error}") from error
    if between.shape != (_N, _N):
        raise CameraError(f"correlation has shape {between.shape}: it must be {_N} x {_N}")
    matrix = np.where(np.isfinite(between), between, np.eye(_N)) * sd * sd[:, None]
    return tuple(tuple(row) for row in matrix.tolist())
