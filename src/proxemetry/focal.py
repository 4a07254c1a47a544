"""From a photo's metadata and the user's word to a camera, with its source and uncertainty (METHOD section 7)."""

from __future__ import annotations

from dataclasses import dataclass

from .camera import Camera
from .photo import Photo

#: The source that every assumption carries.
ASSUMED = "ASSUMED"


@dataclass(frozen=True)
class FocalRequest:
    """What the user states of the camera, for all photos of a run; None where nothing is stated.

    focal_mm with sensor_mm (width, height of the sensor in millimetres), focal_35mm, or focal_px; assume_fov_deg is
    the horizontal field of view to assume where nothing else is known.
    """

    focal_mm: float | None = None
    focal_35mm: float | None = None
    focal_px: float | None = None
    sensor_mm: tuple[float, float] | None = None
    assume_fov_deg: float | None = None


@dataclass(frozen=True)
class Candidate:
    """One answer to what the focal length is: pixels of the full-size photo, relative sd, and where it came from."""

    focal_px: float
    rel_sd: float
    source: str


@dataclass(frozen=True)
class CameraEstimate:
    """The camera chosen for a photo, every candidate, and what is doubtful.

    camera is None where no focal length is known; reason then says so and what to do. flags are short texts.
    """

    camera: Camera | None
    candidates: tuple[Candidate, ...] = ()
    flags: tuple[str, ...] = ()
    reason: str | None = None


def estimate_camera(photo: Photo, request: FocalRequest | None = None) -> CameraEstimate:
    """Return the camera of a photo."""
    raise NotImplementedError
