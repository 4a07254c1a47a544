"""The lens of a picture that a camera is calibrated on: as stated, as its file tells, or open."""

from __future__ import annotations

from dataclasses import replace

from ..camera import Camera
from ..camera.focal import FocalRequest, estimate_camera
from ..photo import Photo
from .points import PRINCIPAL_REL_SD, open_camera


def lens_of(photo: Photo, request: FocalRequest) -> tuple[Camera, bool]:
    """Return the lens of a photo, and whether its focal length is known; it is open where it would be assumed."""
    estimate = estimate_camera(photo, request)
    known = estimate.camera is not None and not estimate.is_assumed
    camera = estimate.camera if known and estimate.camera else open_camera(photo.width, photo.height)
    return with_open_principal(camera), known


def with_open_principal(camera: Camera) -> Camera:
    """Return a camera whose principal point is uncertain where it is just the middle of the picture."""
    if camera.principal_sd_px == 0 and (camera.cx, camera.cy) == (camera.width / 2, camera.height / 2):
        return replace(camera, principal_sd_px=PRINCIPAL_REL_SD * max(camera.width, camera.height))
    return camera
