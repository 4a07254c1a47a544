"""A photo's lens for the label files: what the file records, or what the annotator states."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from ..archive.review.actions import camera_request
from ..camera.focal import estimate_camera
from ..camera.sensors import FULL_FRAME_DIAGONAL_MM
from ..errors import SettingsError
from ..photo import Photo
from .state import Lens

#: 35 mm equivalents and sensors that exist (`camera.sensors`), with room.
_EQUIVALENT_MM, _SENSOR_MM = (1.0, 10_000.0), (1.0, 300.0)


def stated_lens(value: Any) -> Lens:
    """Return what an annotator states: {focal_35mm}, or {focal_mm, sensor_mm: [w, h]}; raises SettingsError."""
    if not isinstance(value, Mapping):
        raise SettingsError("annotation: a lens is {focal_35mm} or {focal_mm, sensor_mm}")
    request = camera_request(value)  # pyright: ignore[reportUnknownArgumentType]
    if (request.focal_mm is None) == (request.focal_35mm is None) or request.focal_px is not None:
        raise SettingsError("annotation: state one focal length, in mm with the sensor's size or as 35 mm equivalent")
    if request.focal_35mm is not None:
        lens = Lens(request.focal_35mm, (36.0, 24.0), equivalent=True)
    elif request.focal_mm is None or request.sensor_mm is None:
        raise SettingsError("annotation: a focal length in mm needs the sensor's size")
    else:
        lens = Lens(request.focal_mm, (max(request.sensor_mm), min(request.sensor_mm)))
    equivalent = lens.focal_mm * FULL_FRAME_DIAGONAL_MM / (lens.sensor_mm[0] ** 2 + lens.sensor_mm[1] ** 2) ** 0.5
    if not _EQUIVALENT_MM[0] <= equivalent <= _EQUIVALENT_MM[1]:
        raise SettingsError(f"annotation: {equivalent:g} mm is not the 35 mm equivalent of any lens")
    if not _SENSOR_MM[0] <= lens.sensor_mm[1] <= lens.sensor_mm[0] <= _SENSOR_MM[1]:
        raise SettingsError(f"annotation: no sensor is {lens.sensor_mm[0]:g} x {lens.sensor_mm[1]:g} mm large")
    return lens


def recorded_lens(photo: Photo) -> Lens | None:
    """Return what a photo's file records, None where it does not say; sensor sides are those of the whole picture."""
    estimate = estimate_camera(photo)
    camera, metadata = estimate.camera, photo.metadata
    if camera is None or not camera.source.kind.is_recorded:
        return None
    focal_mm = metadata.focal_mm or metadata.focal_35mm
    if focal_mm is None:
        return None
    per_px = focal_mm / camera.f_px
    long, short = max(photo.width, photo.height), min(photo.width, photo.height)
    return Lens(focal_mm, (round(long * per_px, 2), round(short * per_px, 2)), equivalent=metadata.focal_mm is None)


def for_shape(lens: Lens, width: int, height: int) -> Lens:
    """Return a lens with the sensor that a photo of this shape had; an equivalent refers to the diagonal."""
    if not lens.equivalent:
        return lens
    long, short = max(width, height), min(width, height)
    per_px = FULL_FRAME_DIAGONAL_MM / (long**2 + short**2) ** 0.5
    return Lens(lens.focal_mm, (round(long * per_px, 2), round(short * per_px, 2)), True)
