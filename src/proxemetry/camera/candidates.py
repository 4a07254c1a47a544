"""Every candidate for a photo's focal length, from the user's statements, the file's metadata and lens data."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace

from ..intervals import HALF_WIDTH_SD
from ..photo import Photo
from ..photo.metadata import Metadata
from .estimate import Candidate
from .frame import Frame
from .others import Others
from .request import FocalRequest
from .sensors import FULL_FRAME_DIAGONAL_MM
from .sources import FocalSource, Source
from .table import CameraRow

# Relative standard deviations. A lens is within 2 % of the focal length engraved on it, and so is what EXIF rounds to.
LENS_SD = 0.02
_EQUIVALENT_SD = 0.025  # some makers scale the width, not the diagonal; the rounding to whole mm comes on top
_CROP_FACTOR_SD = 0.03  # of a database's crop factors, rounded to one decimal place at worst
# What a user states without a doubt of their own: an equivalent to a tenth, a field of view to a fifth.
_ASSUMED_EQUIVALENT_SD = 0.1
_ASSUMED_FOV_SD = 0.2
_ROUNDING_SD = 1 / math.sqrt(12)  # of a tag in whole millimetres
#: Makers whose 35 mm equivalent counts a digital zoom (Apple: 77 mm at 3x of a 26 mm lens), and whose does not.
_COUNTS_ZOOM = {"apple": True, "google": False}


@dataclass(frozen=True)
class Found:
    """A candidate, and what ties its pixels to the lens: where the user states millimetres, that is the file.

    basis is the candidate's own kind where it needs nothing else.
    """

    candidate: Candidate
    basis: FocalSource

    @classmethod
    def of(cls, f_px: float, rel_sd: float, kind: FocalSource, detail: str = "") -> Found:
        """Return what is its own basis."""
        return cls(Candidate(f_px, rel_sd, Source(kind, detail)), kind)


def found(
    photo: Photo, request: FocalRequest, row: CameraRow | None, frame: Frame, others: Others | None = None
) -> tuple[Found, ...]:
    """Return every candidate: those of the camera table, of the user, of the file, and the assumptions asked for."""
    return _with_zoom_settled(photo, tuple(_found(photo, request, row, frame, others or Others())))


def _found(photo: Photo, request: FocalRequest, row: CameraRow | None, frame: Frame, others: Others) -> Iterator[Found]:
    if row is not None:
        yield from _stated(photo, _request_of(row, photo), frame, FocalSource.CAMERA_TABLE, f"line {row.line}: ")
    yield from _stated(photo, request, frame, FocalSource.USER)
    recorded = list(_recorded(photo, frame))
    yield from recorded
    if not any(f.basis is FocalSource.CROP_FACTOR for f in recorded):  # a database that knows the sensor knows better
        yield from _by_others(photo, frame, others)
    if request.assume_fov_deg is not None:
        # Across the long side, as wide as the camera sees it: held upright it has the same lens.
        f_px = max(photo.width, photo.height) / 2 / math.tan(math.radians(request.assume_fov_deg) / 2)
        yield Found.of(f_px, _ASSUMED_FOV_SD, FocalSource.ASSUMED_FOV, f"{request.assume_fov_deg:g} degrees")


def _request_of(row: CameraRow, photo: Photo) -> FocalRequest:
    """Return what a table's row states of the focal length; a sensor without a height has the photo's shape."""
    sensor_mm = None
    if row.sensor_width_mm is not None:
        shape = min(photo.width, photo.height) / max(photo.width, photo.height)
        sensor_mm = (row.sensor_width_mm, row.sensor_height_mm or row.sensor_width_mm * shape)
    if row.focal_px is not None or row.focal_35mm is not None:
        sensor_mm = None
    return FocalRequest(row.focal_mm, row.focal_35mm, row.focal_px, sensor_mm)


def _stated(photo: Photo, request: FocalRequest, frame: Frame, kind: FocalSource, where: str = "") -> Iterator[Found]:
    """Yield what the user states for the run or in a row of a table, alone or with what the photo adds."""
    if request.focal_px is not None:
        yield Found.of(request.focal_px, 0.0, kind, f"{where}focal length in pixels")
    elif request.focal_35mm is not None:
        # One equivalent for all photos of a run is no measurement: it stays marked as an assumption.
        f_px, mm = _from_equivalent(request.focal_35mm, frame), f"{request.focal_35mm:g} mm"
        if kind is FocalSource.USER:
            sd = math.hypot(_ASSUMED_EQUIVALENT_SD, frame.size_rel_sd)
            yield Found.of(f_px, sd, FocalSource.ASSUMED_EQUIVALENT, mm)
        else:
            sd = math.hypot(_EQUIVALENT_SD, frame.size_rel_sd)
            yield Found.of(f_px, sd, kind, f"{where}35 mm equivalent {mm}")
    elif request.sensor_mm is not None:
        focal_mm = request.focal_mm or photo.metadata.focal_mm
        if focal_mm is not None:
            what = "focal length" if request.focal_mm else "EXIF focal length"
            f_px, sd = _from_sensor(focal_mm * zoom_of(photo.metadata), request.sensor_mm, frame)
            yield Found.of(f_px, sd, kind, f"{where}{what} and sensor size")
    elif request.focal_mm is not None:
        for f_px, sd, basis, detail in _from_body(photo, request.focal_mm, frame):
            words = _BY_BODY[basis].format(detail)
            yield Found(Candidate(f_px, sd, Source(kind, f"{where}focal length and {words}")), basis)


#: What gives a stated focal length its pixels, for print.
_BY_BODY = {
    FocalSource.FOCAL_PLANE: "focal plane resolution",
    FocalSource.CROP_FACTOR: "crop factor {}",
    FocalSource.EQUIVALENT: "the ratio of EXIF's two focal lengths",
}


def _recorded(photo: Photo, frame: Frame) -> Iterator[Found]:
    """Yield the answers of the photo's metadata, the most trustworthy first."""
    focal_mm, focal_35mm = photo.metadata.focal_mm, photo.metadata.focal_35mm
    from_body = [
        Found.of(*fields) for fields in (() if focal_mm is None else _from_body(photo, focal_mm, frame))
    ]  # fmt: skip
    yield from (f for f in from_body if f.basis is FocalSource.FOCAL_PLANE)
    if focal_35mm is not None:
        rounding = _ROUNDING_SD / focal_35mm
        sd = math.hypot(math.hypot(_EQUIVALENT_SD, rounding), frame.size_rel_sd)
        yield Found.of(_from_equivalent(focal_35mm, frame), sd, FocalSource.EQUIVALENT)
    yield from (f for f in from_body if f.basis is not FocalSource.FOCAL_PLANE)


def _by_others(photo: Photo, frame: Frame, others: Others) -> Iterator[Found]:
    """Yield the photo's focal length by the sensor that other photos of the same model show."""
    focal_mm = photo.metadata.focal_mm
    crop = None if others.model is None or focal_mm is None else others.model.crop_at(focal_mm)
    if crop is None or focal_mm is None:
        return
    f_px = _from_equivalent(focal_mm * zoom_of(photo.metadata) * math.sqrt(crop.low * crop.high), frame)
    spread = math.log(crop.high / crop.low) / 2 / HALF_WIDTH_SD
    sd = math.hypot(_CROP_FACTOR_SD, math.hypot(frame.size_rel_sd, spread))
    source = Source(FocalSource.SAME_CAMERA, f"{crop.photos} of {photo.metadata.model}")
    yield Found(Candidate(f_px, sd, source), FocalSource.CROP_FACTOR)


def _from_equivalent(focal_35mm: float, frame: Frame) -> float:
    return focal_35mm * frame.diagonal_px / FULL_FRAME_DIAGONAL_MM


def _from_body(photo: Photo, focal_mm: float, frame: Frame) -> Iterator[tuple[float, float, FocalSource, str]]:
    """Yield pixels, relative sd, basis and its particulars of a focal length in millimetres on the camera's sensor."""
    from .lens import crop_factors

    metadata, focal_mm_zoomed = photo.metadata, focal_mm * zoom_of(photo.metadata)
    if metadata.focal_plane_px_per_mm is not None:
        f_px = focal_mm_zoomed * metadata.focal_plane_px_per_mm * frame.scale
        yield f_px, math.hypot(LENS_SD, frame.scale_rel_sd), FocalSource.FOCAL_PLANE, ""
    factors = crop_factors(metadata.make, metadata.model, focal_mm, frame.aspect if frame.is_whole_known else None)
    if factors:
        # Several sensors behind one name: all of them are in the interval.
        low, high = min(factors), max(factors)
        f_px = _from_equivalent(focal_mm_zoomed * math.sqrt(low * high), frame)
        sd = math.sqrt(_CROP_FACTOR_SD**2 + frame.size_rel_sd**2 + (math.log(high / low) / 2 / HALF_WIDTH_SD) ** 2)
        shown = f"{low:.4g}" if low == high else f"{low:.4g} to {high:.4g}"
        yield f_px, sd, FocalSource.CROP_FACTOR, f"{shown} of {metadata.model}"
    if metadata.focal_mm is not None and metadata.focal_35mm is not None and focal_mm != metadata.focal_mm:
        f_px = _from_equivalent(metadata.focal_35mm * focal_mm / metadata.focal_mm, frame)
        yield f_px, math.hypot(_CROP_FACTOR_SD, frame.size_rel_sd), FocalSource.EQUIVALENT, ""


def _from_sensor(focal_mm: float, sensor_mm: tuple[float, float], frame: Frame) -> tuple[float, float]:
    """Return pixels and relative sd by a sensor size; its long side follows the photo's, whichever way it is turned."""
    long_mm, short_mm = max(sensor_mm), min(sensor_mm)
    along = max(frame.width_px, frame.height_px) / long_mm
    across = min(frame.width_px, frame.height_px) / short_mm
    # Where the shapes differ, the photo was cut from the smallest frame of the sensor's shape that holds it.
    shape_sd = abs(math.log(along / across)) / 2
    sd = math.sqrt(LENS_SD**2 + frame.size_rel_sd**2 + (shape_sd**2 if shape_sd > 0.01 else 0.0))
    return focal_mm * max(along, across), sd


def zoom_of(metadata: Metadata) -> float:
    """Return the digital zoom, 1 where there was none."""
    return metadata.digital_zoom or 1.0


def _with_zoom_settled(photo: Photo, found: tuple[Found, ...]) -> tuple[Found, ...]:
    """Find out whether the 35 mm equivalent counts the digital zoom: the standard leaves it open, and makers differ.

    The camera's sensor decides, else what is known of the maker; else the interval holds both.
    """
    zoom = zoom_of(photo.metadata)
    tag = next((f for f in found if f.candidate.source.kind is FocalSource.EQUIVALENT), None)
    if zoom == 1.0 or tag is None:
        return found
    as_tagged = tag.candidate
    source = replace(as_tagged.source, detail=f"x digital zoom {zoom:g}")
    zoomed = replace(as_tagged, focal_px=as_tagged.focal_px * zoom, source=source)
    by_body = (FocalSource.FOCAL_PLANE, FocalSource.CROP_FACTOR, FocalSource.SAME_CAMERA)
    references = [f.candidate.focal_px for f in found if f.candidate.source.kind in by_body]
    make = (photo.metadata.make or "").lower()
    counted = next((counts for name, counts in _COUNTS_ZOOM.items() if name in make), None)
    if references:
        apart = [abs(math.log(c.focal_px / references[0])) for c in (as_tagged, zoomed)]
        settled = as_tagged if apart[0] <= apart[1] else zoomed
    elif counted is None:
        settled = replace(as_tagged, rel_sd=math.hypot(as_tagged.rel_sd, math.log(zoom) / HALF_WIDTH_SD))
    else:
        settled = as_tagged if counted else zoomed
    return tuple(replace(f, candidate=settled) if f is tag else f for f in found)
