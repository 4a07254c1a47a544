"""Taped lengths on the floor: what they add to what is known of a camera's place, or determine alone."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..arrays import FloatArray
from ..camera import Mount
from ..camera.floor_view import to_floor
from ..errors import CameraError
from .least_squares import minimise
from .points import CLICK_SD_PX, TAPE_SD_M

#: What is known of a camera of which nothing is: pitch, roll (radians), log height (about 2.5 m), log focal length.
_OPEN_MEAN, _OPEN_SD = np.array([0.35, 0.0, math.log(2.5), 0.0]), np.array([0.5, 0.04, 1.0, 1e-6])
#: Pitches to begin from where none is known.
_STARTS_RAD = np.radians([5.0, 15.0, 30.0, 50.0])


@dataclass(frozen=True)
class Length:
    """A straight line on the floor between two pixels, metres long. Raises CameraError for what is no length."""

    u0: float
    v0: float
    u1: float
    v1: float
    metres: float

    def __post_init__(self) -> None:
        values = (self.u0, self.v0, self.u1, self.v1, self.metres)
        if not all(map(math.isfinite, values)) or self.metres <= 0 or (self.u0, self.v0) == (self.u1, self.v1):
            raise CameraError(
                f"length {','.join(f'{v:g}' for v in values)}: it must be u,v,u,v,METRES: two pixels and their distance"
            )

    @classmethod
    def parsed(cls, text: str) -> Length:
        """Read u,v,u,v,METRES."""
        try:
            return cls(*map(float, text.split(",")))
        except (TypeError, ValueError):
            raise CameraError(f"length {text!r}: write u,v,u,v,METRES, like 120,540,610,530,6.2") from None

    @property
    def ends_px(self) -> FloatArray:
        """Shape (2, 2)."""
        return np.array([(self.u0, self.v0), (self.u1, self.v1)])


def with_lengths(
    mount: Mount, lengths: Sequence[Length], click_sd_px: float = CLICK_SD_PX, tape_sd_m: float = TAPE_SD_M
) -> tuple[Mount, FloatArray]:
    """Return a mount with what taped lengths add to it, and how much longer each was taped than it comes out, metres.

    The mount may know nothing but its camera: two lengths or more then determine its pitch and height, the better the
    more one of them runs away from the camera. Raises CameraError where there are too few, or an end is no floor.
    """
    if mount.camera is None:
        raise CameraError("lengths need a focal length: state one, or give four points of the floor")
    known = mount.known
    if not len(lengths) or (len(lengths) < 2 and not {0, 2} & set(known.tolist())):
        raise CameraError(
            "one length alone determines no camera: two in different directions are needed, or people too"
        )
    mean, precision = _beforehand(mount)
    root = np.linalg.cholesky(precision).T

    def whitened(unknowns: FloatArray) -> FloatArray:
        at = _moved(mount, unknowns)
        missed = [_missed(at, length, click_sd_px, tape_sd_m) for length in lengths]
        return np.concatenate([np.array(missed), root @ (unknowns - mean)])

    starts = [mean] if 0 in known else [np.array([pitch, *mean[1:]]) for pitch in _STARTS_RAD]
    found = [minimise(whitened, start) for start in starts]
    unknowns, normal = min(found, key=lambda f: float((whitened(f[0]) ** 2).sum()))
    result = _moved(mount, unknowns)
    away = np.array([length.metres - _long(result, length.ends_px) for length in lengths])
    if not np.isfinite(away).all():
        raise CameraError("an end of a length lies at the horizon or above it: both must be points of the floor")
    covariance = np.linalg.inv(normal)
    if 3 not in known:
        covariance[3, :] = covariance[:, 3] = np.nan
    assert result.camera is not None
    camera = replace(result.camera, focal_rel_sd=math.sqrt(covariance[3, 3])) if 3 in known else result.camera
    source = f"{len(lengths)} taped lengths" + (f" and {mount.source}" if len(known) else "")
    return replace(result, covariance=tuple(map(tuple, covariance.tolist())), camera=camera, source=source), away


def _beforehand(mount: Mount) -> tuple[FloatArray, FloatArray]:
    """Return the mean (4,) and precision (4, 4) of pitch, roll, log height and log focal length relative to its own."""
    known = mount.known
    stated = np.array([mount.pitch_rad, mount.roll_rad, math.log(mount.height_m), 0.0])
    mean, precision = _OPEN_MEAN.copy(), np.diag(_OPEN_SD**-2.0)
    mean[known] = stated[known]
    block = np.array(mount.covariance)[np.ix_(known, known)] + np.eye(len(known)) * 1e-12
    precision[np.ix_(known, known)] = np.linalg.inv(block)
    return mean, precision


def _moved(mount: Mount, unknowns: FloatArray) -> Mount:
    pitch, roll, log_height, log_focal = map(float, unknowns)
    assert mount.camera is not None
    camera = mount.camera.with_focal(mount.camera.f_px * math.exp(log_focal), source=mount.camera.source)
    pitch = max(-math.pi / 2, min(math.pi / 2, pitch))
    height = math.exp(max(-5.0, min(7.0, log_height)))
    return Mount.stated(pitch, roll, height, camera=camera, floor_frame=mount.floor_frame)


def _long(mount: Mount, ends_px: FloatArray) -> float:
    a, b = to_floor(mount, ends_px)
    return float(np.linalg.norm(a - b))


def _missed(mount: Mount, length: Length, click_sd_px: float, tape_sd_m: float) -> float:
    """Return how much longer a length was taped than it comes out, in standard deviations of tape and clicks."""
    ends = length.ends_px
    comes_out = _long(mount, ends)
    if not math.isfinite(comes_out):
        return 1e6
    by = [_long(mount, ends + step) - comes_out for step in 0.1 * np.eye(4).reshape(4, 2, 2)]
    sway = 10 * click_sd_px * float(np.linalg.norm(np.nan_to_num(by, nan=1e3)))
    return (length.metres - comes_out) / math.hypot(tape_sd_m, sway)
