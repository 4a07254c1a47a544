"""A photo's camera, its people being known: what is stated and recorded first, then what the picture shows."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import cached_property

from ..arrays import FloatArray
from ..errors import PhotoError
from ..people import People
from ..photo import Photo
from .drone import flight_mount
from .estimate import CameraEstimate, Testimony, Witness
from .focal import estimate_camera, row_of
from .layout import layout_of
from .lines.gravity import read_gravity
from .lines.picture_frames import in_frames
from .lines.segments import LONG_SIDE_PX, Detected, detected_in
from .mount import Mount
from .others import Others
from .request import FocalRequest
from .sources import Flag, FocalSource
from .unstated import without_statement


class PictureLines:
    """The straight segments of a photo, looked for when first asked for."""

    def __init__(self, photo: Photo, people: People) -> None:
        self._photo, self._people = photo, people

    @cached_property
    def segments_px(self) -> FloatArray | None:
        """Segments (N, 4) in full-size pixels, outside people; None where the photo's pixels are not at hand."""
        return None if self._detected is None else self._detected.outside(self._people.boxes_px)

    def people_in_frames(self) -> tuple[bool, ...]:
        """Return whether straight edges frame each person; no one where the pixels are not available."""
        return () if self._detected is None else tuple(in_frames(self._detected, self._people.boxes_px).tolist())

    def layout_flags(self) -> tuple[Flag, ...]:
        """Return the doubts of a picture that is no whole photo: several side by side, or one between bars.

        Only of those that name no camera: a camera's own file is whole.
        """
        photo = self._photo
        if photo.metadata.make or photo.metadata.model or not (photo.path or photo.has_pixels):
            return ()
        try:
            return layout_of(photo.pixels(LONG_SIDE_PX)).flags
        except PhotoError:
            return ()

    @cached_property
    def _detected(self) -> Detected | None:
        return detected_in(self._photo)


def choose_camera(
    photo: Photo, people: People, request: FocalRequest, mount: Mount | None, lines: PictureLines | None,
    others: Others | None = None,
) -> CameraEstimate:  # fmt: skip
    """Return the camera of a photo with people in it; mount, lines and others are those of `measure`.

    Raises CameraError where the mount is of photos of another size.
    """
    estimate = estimate_camera(photo, request, others)
    mount = estimate.mount or mount
    if mount is not None and mount.camera is not None:
        mount.check_size(photo.width, photo.height)
        return replace(estimate, camera=mount.camera, flags=(), reason=None, lens=None, mount=mount)
    by_fov = estimate.source is not None and estimate.source.kind is FocalSource.ASSUMED_FOV
    missing = estimate.camera is None and estimate.may_be_guessed and not _is_half_stated(photo, request)
    if missing or by_fov:
        segments_px = None if lines is None else lines.segments_px
        estimate = without_statement(estimate, photo, people, segments_px, request.assume, others)
    return estimate if lines is None else replace(estimate, flags=(*lines.layout_flags(), *estimate.flags))


def _is_half_stated(photo: Photo, request: FocalRequest) -> bool:
    """Return whether a focal length in millimetres is stated without a sensor: whoever knows one knows both."""
    row = row_of(photo, request.camera_table) if request.camera_table else None
    return request.focal_mm is not None or (row is not None and row.focal_mm is not None)


def with_flight(estimate: CameraEstimate, photo: Photo, mount: Mount | None) -> CameraEstimate:
    """Return the estimate with the place that a drone recorded in its photo's file, where none is stated.

    What is stated of the place comes first, part by part; a mount that was found with its lens is complete.
    """
    stated, told = estimate.mount or mount, flight_mount(photo.metadata.flight)
    if told is None or (stated is not None and stated.camera is not None):
        return estimate
    return replace(estimate, mount=told if stated is None else stated.completed_by(told))


def with_gravity(estimate: CameraEstimate, lines: PictureLines, mount: Mount | None) -> CameraEstimate:
    """Return the estimate with gravity as straight lines show it, where no mount states the pitch."""
    mount = estimate.mount or mount
    told = mount is not None and (mount.camera is not None or math.isfinite(mount.pitch_rad))
    if estimate.camera is None:
        return estimate
    if told:
        return _heard(estimate, "not asked: it is stated", counted=False)
    if lines.segments_px is None:
        return _heard(estimate, "none: the picture cannot be decoded", counted=False)
    gravity = read_gravity(lines.segments_px, estimate.camera)
    if isinstance(gravity, str):
        return _heard(estimate, f"none: {gravity}", counted=False)
    return _heard(replace(estimate, mount=gravity.mount(mount)), str(gravity), counted=True)


def _heard(estimate: CameraEstimate, words: str, counted: bool) -> CameraEstimate:
    testimony = Testimony(Witness.GRAVITY, words, counted)
    return replace(estimate, testimony=(*estimate.testimony, testimony))
