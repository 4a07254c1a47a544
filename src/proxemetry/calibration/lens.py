"""The lens of a picture that a camera is calibrated on: as stated, as recorded in its file, or open.

What the user states for all photos (`--focal-35mm`, `--assume-fov`) is rough, and known within its standard deviation.
"""

from __future__ import annotations

from dataclasses import replace

from ..camera import Camera
from ..camera.focal import FocalRequest, estimate_camera
from ..photo import Photo
from .points import PRINCIPAL_REL_SD, open_camera


def lens_of(photo: Photo, request: FocalRequest) -> tuple[Camera, bool]:
    """Return the lens of a photo, and whether its focal length is known; it is open where nothing shows it."""
    camera = estimate_camera(photo, request).camera
    known = camera is not None
    return with_open_principal(camera or open_camera(photo.width, photo.height)), known


def with_open_principal(camera: Camera) -> Camera:
    """Return a camera whose principal point is uncertain where it is just the middle of the picture."""
    if camera.principal_sd_px == 0 and (camera.cx, camera.cy) == (camera.width / 2, camera.height / 2):
        return replace(camera, principal_sd_px=PRINCIPAL_REL_SD * max(camera.width, camera.height))
    return camera
