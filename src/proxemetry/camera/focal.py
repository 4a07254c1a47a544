"""From a photo's metadata and the user's statements to a camera, with its source and uncertainty (METHOD section 7).

The order of what decides:

1. what the user states of this photo or camera in a table, then what is stated for the run (`candidates`);
2. what the file records, weighed against each other and against the sensors that exist (`weighing`);
3. an assumption that was asked for.

Every candidate is kept, and each that contradicts the chosen one is named in a flag.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import groupby

from ..photo import Photo
from .camera import Camera
from .candidates import Found, found, zoom_of
from .estimate import CameraEstimate, Candidate
from .frame import Frame, frame_of
from .others import Others
from .perspective import fisheye, is_strip, projection_of
from .request import FocalRequest
from .sensors import WIDEST_EQUIVALENT_MM, equivalent_mm
from .sources import Doubt, Flag, FocalSource
from .table import CameraRow, CameraTable
from .weighing import Verdict, agree, weigh

__all__ = ["Camera", "CameraEstimate", "Candidate", "FocalRequest", "estimate_camera"]


def estimate_camera(photo: Photo, request: FocalRequest | None = None, others: Others | None = None) -> CameraEstimate:
    """Return the camera of a photo, with every candidate for its focal length. others: what other photos show about it.

    The estimate's camera is None, with the reason, where neither the photo nor the request gives a focal length, or
    where the file is no picture of one perspective.
    """
    request = request or FocalRequest()
    row = row_of(photo, request.camera_table) if request.camera_table else None
    frame = frame_of(photo.width, photo.height, photo.metadata)
    answers = found(photo, request, row, frame, others)
    candidates = tuple(f.candidate for f in answers)
    remarks = tuple(Flag(Doubt.METADATA, remark) for remark in photo.metadata.remarks)
    stated_mm = (row and row.focal_mm) or request.focal_mm
    unusable = stated_mm is not None and not any(_is_by_user(c) for c in candidates)
    mount = None if row is None else row.mount
    projection = projection_of(photo)
    if projection is not None and not any(c.source.kind is FocalSource.CAMERA_TABLE for c in candidates):
        reason = f"not a picture with one perspective ({projection}): there is no focal length to measure by"
        flags = (*remarks, *_on_perspective(photo))
        return CameraEstimate(None, candidates, flags, reason, mount=mount, one_perspective=False)
    verdict = None if unusable else _verdict(photo, answers, frame)
    if verdict is None:
        missing = _what_is_missing(photo, stated_mm)
        flags = (*remarks, *_on_perspective(photo), *_on_fisheye(fisheye(photo.metadata)))
        return CameraEstimate(None, candidates, flags, missing, mount=mount)
    if verdict.made:
        candidates = (verdict.chosen, *candidates)
    camera = _camera_of(photo, verdict, row)
    camera, lens, doubt = _with_lens(camera, photo, row, verdict.frame)
    # What is wrong with the metadata does not matter where they are not used.
    flags = [*(() if _is_by_user(verdict.chosen) else remarks), *_flags(photo, verdict, camera)]
    flags += [*_on_perspective(photo), *_on_lens(photo, verdict, doubt)]
    return CameraEstimate(camera, candidates, tuple(flags), lens=lens, mount=mount, why=verdict.why)


def row_of(photo: Photo, table: CameraTable) -> CameraRow | None:
    """Return the row of a camera table that speaks of a photo, None where none does."""
    return table.row_for(photo.name, photo.metadata.make, photo.metadata.model)


def flags_beside_focal(flags: tuple[Flag, ...]) -> tuple[Flag, ...]:
    """Return the flags that stay true when the focal length is stated anew: crops, zooms, lenses."""
    return tuple(f for f in flags if not f.doubt.is_settled_by_focal)


def _is_by_user(candidate: Candidate) -> bool:
    return candidate.source.kind in (FocalSource.USER, FocalSource.CAMERA_TABLE)


def _verdict(photo: Photo, answers: Sequence[Found], frame: Frame) -> Verdict | None:
    """Return the verdict of the first source, its interval wide enough to hold those that contradict it."""
    verdict: Verdict | None = None
    for _, group in groupby(answers, key=_rank):
        answers_of = list(group)
        later = _verdict_of(photo, answers_of, frame)
        if verdict is None:
            verdict = later
        elif later is not None and not _is_a_guess(later.chosen) and not agree(verdict.chosen, later.chosen):
            # What is stated in pixels is a calibration, and stands.
            held = verdict.holding(later.chosen) if verdict.chosen.rel_sd > 0 else verdict
            verdict = held.against(later.chosen)
    return verdict


def _rank(found: Found) -> int:
    """Return the first source: the table, the user (a guess for all photos included), the file, the assumption."""
    kind = found.candidate.source.kind
    if kind is FocalSource.CAMERA_TABLE:
        return 0
    if kind in (FocalSource.USER, FocalSource.ASSUMED_EQUIVALENT):
        return 1
    return 2 if kind.is_recorded else 3


def _is_a_guess(candidate: Candidate) -> bool:
    return candidate.source.is_assumed


def _verdict_of(photo: Photo, answers: Sequence[Found], frame: Frame) -> Verdict | None:
    first = answers[0]
    if first.basis.is_recorded:
        return weigh(photo, answers, frame)
    return Verdict(first.candidate, frame, "assumed" if first.candidate.source.is_assumed else "stated")


def _camera_of(photo: Photo, verdict: Verdict, row: CameraRow | None) -> Camera:
    chosen, frame = verdict.chosen, verdict.frame
    camera = Camera.centred(
        chosen.focal_px, photo.width, photo.height, focal_rel_sd=chosen.rel_sd, source=chosen.source
    )
    camera = replace(camera, principal_sd_px=frame.principal_sd_px)
    if frame.principal_px is not None:
        camera = replace(camera, cx=frame.principal_px[0], cy=frame.principal_px[1])
    return camera if row is None else _with_row(camera, row)


def _flags(photo: Photo, verdict: Verdict, camera: Camera) -> list[Flag]:
    """Return the doubts about the camera but for those about its lens in lensfun's database."""
    zoom, chosen, frame = zoom_of(photo.metadata), verdict.chosen, verdict.frame
    flags = [Flag(Doubt.ZOOMED, f"digital zoom {zoom:g}x")] if zoom > 1 else []
    flags += verdict.flags
    if chosen.source.is_assumed:
        flags.append(Flag(Doubt.ASSUMED, f"focal length {chosen.source}"))
    if frame.crop is not None:
        known = "as recorded" if frame.principal_px is not None else "unknown"
        where = known if camera.principal_sd_px else "as stated"
        flags.append(Flag(Doubt.CROPPED, f"cropped ({frame.crop}): principal point {where}"))
    return flags


def _on_perspective(photo: Photo) -> list[Flag]:
    projection = projection_of(photo)
    if projection is not None:
        return [Flag(Doubt.PROJECTION, f"{projection}: not a picture of one perspective")]
    if is_strip(photo.width, photo.height):
        return [
            Flag(Doubt.PROJECTION, f"{photo.width} x {photo.height}: perhaps a panorama stitched from several photos")
        ]
    return []


def _on_lens(photo: Photo, verdict: Verdict, doubt: str | None) -> list[Flag]:
    """Return the doubt about the lens: what the database knows, the lens's own name, or a view no other lens has."""
    if doubt is not None:
        return [Flag(Doubt.LENS, doubt)]
    what = fisheye(photo.metadata)
    if what is None and verdict.chosen.source.kind.is_recorded:
        equivalent = equivalent_mm(verdict.chosen.focal_px, verdict.frame.diagonal_px) / zoom_of(photo.metadata)
        what = f"no other has an equivalent of {equivalent:.1f} mm" if equivalent < WIDEST_EQUIVALENT_MM else None
    return _on_fisheye(what)


def _on_fisheye(what: str | None) -> list[Flag]:
    return (
        [] if what is None else [Flag(Doubt.LENS, f"fisheye lens ({what}): distances away from the middle are wrong")]
    )


def _with_row(camera: Camera, row: CameraRow) -> Camera:
    """Return the camera with the principal point, the pixels' shape and the distortion that a table's row states."""
    if row.focal_y_px is not None:
        camera = replace(camera, fy=row.focal_y_px)
    if row.cx_px is not None and row.cy_px is not None:
        camera = replace(camera, cx=row.cx_px, cy=row.cy_px, principal_sd_px=0.0)
    return replace(camera, distortion=row.distortion or camera.distortion)


def _with_lens(
    camera: Camera, photo: Photo, row: CameraRow | None, frame: Frame
) -> tuple[Camera, str | None, str | None]:
    """Return the camera with its lens's distortion, that lens, and a doubt about it."""
    if row is not None and row.distortion is not None:
        return camera, f"camera table line {row.line}", None
    # The middle of a crop is not the lens's axis, and a digital zoom is a crop that was made larger again.
    if frame.crop is not None or zoom_of(photo.metadata) > 1 or photo.metadata.model is None:
        return camera, None, None
    from .lens import lens_correction

    correction, doubt = lens_correction(photo.metadata, camera.f_px, camera.width, camera.height)
    if correction is None:
        return camera, None, doubt or None
    return replace(camera, distortion=correction.distortion), str(correction), None


def _what_is_missing(photo: Photo, stated_mm: float | None) -> str:
    metadata = photo.metadata
    focal_mm = stated_mm or metadata.focal_mm
    if focal_mm is not None:
        camera = metadata.model or "the camera, which the photo does not name,"
        return (
            f"focal length {focal_mm:g} mm, but the sensor size of {camera} is unknown; "
            "state it with --sensor-mm WxH or --camera-table"
        )
    strip = ", which may be a panorama" if _on_perspective(photo) else ""
    return (
        f"no focal length in the photo{strip}; state one with --focal-35mm, --focal-mm and --sensor-mm, --focal-px or "
        "--camera-table, or assume one with --assume-fov"
    )
