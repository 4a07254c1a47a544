"""From a photo's metadata and the user's word to a camera, with its source and uncertainty (METHOD section 7)."""

from __future__ import annotations

from dataclasses import dataclass

from .camera import Camera, CameraEstimate, Candidate
from .photo import Photo

__all__ = ["ASSUMED", "Camera", "CameraEstimate", "Candidate", "FocalRequest", "estimate_camera"]

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


def estimate_camera(photo: Photo, request: FocalRequest | None = None) -> CameraEstimate:
    """Return the camera of a photo."""
    raise NotImplementedError
