"""From a photo's metadata and the user's word to a camera, with its source and uncertainty (METHOD section 7).

Every candidate is kept. The first in this order is chosen: the user's word; EXIF focal length with the focal plane
resolution; the 35 mm equivalent; EXIF focal length with the camera's crop factor; an assumption that was asked for.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any, cast

from ..errors import SettingsError
from ..intervals import HALF_WIDTH_SD
from ..photo import Photo
from .camera import Camera
from .estimate import CameraEstimate, Candidate
from .frame import Frame, frame_of
from .sources import Doubt, Flag, FocalSource, Source
from .table import CameraRow, CameraTable

__all__ = ["Camera", "CameraEstimate", "Candidate", "FocalRequest", "estimate_camera"]

#: The diagonal of the 36 x 24 mm frame to which the 35 mm equivalent refers.
_FULL_FRAME_DIAGONAL_MM = math.hypot(36, 24)
# Relative standard deviations. A lens is within 2 % of the focal length engraved on it, and so is what EXIF rounds to.
_LENS_SD = 0.02
_EQUIVALENT_SD = 0.025  # some makers scale the width, not the diagonal; the rounding to whole mm comes on top
_CROP_FACTOR_SD = 0.03
_ASSUMED_EQUIVALENT_SD = 0.1
_ASSUMED_FOV_SD = 0.2


@dataclass(frozen=True)
class FocalRequest:
    """What the user states of the camera, for all photos of a run; None where nothing is stated.

    focal_mm with sensor_mm (width, height of the sensor in millimetres), focal_35mm, or focal_px; sensor_mm alone
    goes with each photo's own focal length. assume_fov_deg is the field of view, across the photo's long side, to
    assume where nothing else is known. camera_table: what is known of single photos or cameras, which comes before
    the rest.

    Raises SettingsError where two statements contradict each other or a value is not positive.
    """

    focal_mm: float | None = None
    focal_35mm: float | None = None
    focal_px: float | None = None
    sensor_mm: tuple[float, float] | None = None
    assume_fov_deg: float | None = None
    camera_table: CameraTable | None = None

    def __post_init__(self) -> None:
        for name in ("focal_mm", "focal_35mm", "focal_px", "sensor_mm", "assume_fov_deg"):
            object.__setattr__(self, name, _plain(getattr(self, name)))
        stated = {"--focal-mm": self.focal_mm, "--focal-35mm": self.focal_35mm, "--focal-px": self.focal_px}
        stated = {option: value for option, value in stated.items() if value is not None}
        for option, value in stated.items():
            if not _is_positive(value):
                raise SettingsError(f"{option} is {value!r}: it must be a positive number")
        if len(stated) > 1:
            raise SettingsError(f"{' and '.join(stated)} state the focal length twice: leave one out")
        if self.sensor_mm is not None:
            if not _are_sides(self.sensor_mm):
                raise SettingsError(f"--sensor-mm is {self.sensor_mm!r}: it must be two positive numbers, WxH")
            if stated and "--focal-mm" not in stated:
                raise SettingsError(f"--sensor-mm means nothing beside {next(iter(stated))}: leave one out")
        if self.assume_fov_deg is not None and not (
            _is_positive(self.assume_fov_deg) and 1 <= self.assume_fov_deg <= 170
        ):
            raise SettingsError(f"--assume-fov is {self.assume_fov_deg}: it must be 1 to 170 degrees")

    @property
    def states_focal(self) -> bool:
        """Whether a focal length is stated for all photos, and not only assumed."""
        return (self.focal_mm, self.focal_35mm, self.focal_px) != (None, None, None)


def _plain(value: Any) -> Any:
    """Return what an array or an element of one holds as Python's own numbers, anything else as it is."""
    value = value.tolist() if hasattr(value, "tolist") else value
    return tuple(map(_plain, value)) if isinstance(value, list | tuple) else value  # pyright: ignore[reportUnknownArgumentType,reportUnknownVariableType]


def _is_positive(value: object) -> bool:
    return isinstance(value, int | float) and math.isfinite(value) and value > 0


def _are_sides(value: object) -> bool:
    if not isinstance(value, Sequence) or isinstance(value, str):
        return False
    return len(sides := cast("Sequence[object]", value)) == 2 and all(map(_is_positive, sides))


def estimate_camera(photo: Photo, request: FocalRequest | None = None) -> CameraEstimate:
    """Return the camera of a photo, with every candidate for its focal length.

    The estimate's camera is None, with the reason, where neither the photo nor the request tells a focal length.
    """
    request = request or FocalRequest()
    row = row_of(photo, request.camera_table) if request.camera_table else None
    frame = frame_of(photo.width, photo.height, photo.metadata)
    found = _settle_zoom(photo, tuple(_found(photo, request, row, frame)))
    candidates = tuple(f.candidate for f in found)
    flags = tuple(Flag(Doubt.METADATA, remark) for remark in photo.metadata.remarks)
    stated_mm = (row and row.focal_mm) or request.focal_mm
    unusable = stated_mm is not None and not any(_is_by_user(c) for c in candidates)
    if unusable or not candidates:
        missing = _what_is_missing(photo, stated_mm)
        return CameraEstimate(None, candidates, flags, missing, mount=None if row is None else row.mount)
    chosen, frame, doubts = _weigh(photo, found, frame)
    camera = Camera.centred(
        chosen.focal_px, photo.width, photo.height, focal_rel_sd=chosen.rel_sd, source=chosen.source
    )
    camera = replace(camera, principal_sd_px=frame.principal_sd_px)
    if frame.principal_px is not None:
        camera = replace(camera, cx=frame.principal_px[0], cy=frame.principal_px[1])
    if chosen.source.is_assumed:
        doubts.append(Flag(Doubt.ASSUMED, f"focal length {chosen.source}"))
    if row is not None:
        camera = _with_row(camera, row)
    if frame.crop is not None:
        known = "as recorded" if frame.principal_px is not None else "unknown"
        where = known if camera.principal_sd_px else "as stated"
        doubts.append(Flag(Doubt.CROPPED, f"cropped ({frame.crop}): principal point {where}"))
    camera, lens, doubt = _with_lens(camera, photo, row, frame)
    if not _is_by_user(chosen):  # what is wrong with the metadata is no matter where nobody uses them
        doubts = [*flags, *doubts]
    if doubt:
        doubts.append(Flag(Doubt.LENS, doubt))
    mount = None if row is None else row.mount
    return CameraEstimate(camera, candidates, tuple(doubts), lens=lens, mount=mount)


def row_of(photo: Photo, table: CameraTable) -> CameraRow | None:
    """Return the row of a camera table that speaks of a photo, None where none does."""
    return table.row_for(photo.name, photo.metadata.make, photo.metadata.model)


def flags_beside_focal(flags: tuple[Flag, ...]) -> tuple[Flag, ...]:
    """Return the flags that stay true when the focal length is stated anew: crops, zooms, lenses."""
    return tuple(f for f in flags if not f.doubt.is_settled_by_focal)


def _is_by_user(candidate: Candidate) -> bool:
    return candidate.source.kind in (FocalSource.USER, FocalSource.CAMERA_TABLE)


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
    if frame.crop is not None or _zoom(photo) > 1 or photo.metadata.model is None:
        return camera, None, None
    from .lens import lens_correction

    correction, doubt = lens_correction(photo.metadata, camera.f_px, camera.width, camera.height)
    if correction is None:
        return camera, None, doubt or None
    return replace(camera, distortion=correction.distortion), str(correction), None


@dataclass(frozen=True)
class _Found:
    """A candidate, and what ties its pixels to the lens: where the user states millimetres, that is the file's word."""

    candidate: Candidate
    basis: FocalSource

    @classmethod
    def of(cls, f_px: float, rel_sd: float, kind: FocalSource, detail: str = "") -> _Found:
        """Return what is its own basis."""
        return cls(Candidate(f_px, rel_sd, Source(kind, detail)), kind)


def _found(photo: Photo, request: FocalRequest, row: CameraRow | None, frame: Frame) -> Iterator[_Found]:
    if row is not None:
        yield from _stated(photo, _request_of(row, photo), frame, FocalSource.CAMERA_TABLE, f"line {row.line}: ")
    yield from _stated(photo, request, frame, FocalSource.USER)
    yield from _recorded(photo, frame)
    if request.assume_fov_deg is not None:
        # Across the long side, as wide as the camera sees it: held upright it has the same lens.
        f_px = max(photo.width, photo.height) / 2 / math.tan(math.radians(request.assume_fov_deg) / 2)
        yield _Found.of(f_px, _ASSUMED_FOV_SD, FocalSource.ASSUMED_FOV, f"{request.assume_fov_deg:g} degrees")


def _request_of(row: CameraRow, photo: Photo) -> FocalRequest:
    """Return what a table's row states of the focal length; a sensor without a height has the photo's shape."""
    sensor_mm = None
    if row.sensor_width_mm is not None:
        shape = min(photo.width, photo.height) / max(photo.width, photo.height)
        sensor_mm = (row.sensor_width_mm, row.sensor_height_mm or row.sensor_width_mm * shape)
    if row.focal_px is not None or row.focal_35mm is not None:
        sensor_mm = None
    return FocalRequest(row.focal_mm, row.focal_35mm, row.focal_px, sensor_mm)


def _stated(photo: Photo, request: FocalRequest, frame: Frame, kind: FocalSource, where: str = "") -> Iterator[_Found]:
    """Yield what the user states for the run or in a row of a table, alone or with what the photo adds."""
    if request.focal_px is not None:
        yield _Found.of(request.focal_px, 0.0, kind, f"{where}focal length in pixels")
    elif request.focal_35mm is not None:
        # One equivalent for all photos of a run is nobody's measurement: it stays marked as what it is.
        f_px, mm = _from_equivalent(request.focal_35mm, frame), f"{request.focal_35mm:g} mm"
        if kind is FocalSource.USER:
            sd = math.hypot(_ASSUMED_EQUIVALENT_SD, frame.size_rel_sd)
            yield _Found.of(f_px, sd, FocalSource.ASSUMED_EQUIVALENT, mm)
        else:
            sd = math.hypot(_EQUIVALENT_SD, frame.size_rel_sd)
            yield _Found.of(f_px, sd, kind, f"{where}35 mm equivalent {mm}")
    elif request.sensor_mm is not None:
        focal_mm = request.focal_mm or photo.metadata.focal_mm
        if focal_mm is not None:
            what = "focal length" if request.focal_mm else "EXIF focal length"
            f_px, sd = _from_sensor(focal_mm * _zoom(photo), request.sensor_mm, frame)
            yield _Found.of(f_px, sd, kind, f"{where}{what} and sensor size")
    elif request.focal_mm is not None:
        for f_px, sd, basis, detail in _from_body(photo, request.focal_mm, frame):
            words = _BY_BODY[basis].format(detail)
            yield _Found(Candidate(f_px, sd, Source(kind, f"{where}focal length and {words}")), basis)


#: What gives a stated focal length its pixels, for print.
_BY_BODY = {
    FocalSource.FOCAL_PLANE: "focal plane resolution",
    FocalSource.CROP_FACTOR: "crop factor {}",
    FocalSource.EQUIVALENT: "the ratio of EXIF's two focal lengths",
}


def _recorded(photo: Photo, frame: Frame) -> Iterator[_Found]:
    """Yield what the photo's metadata say, the most trustworthy first."""
    focal_mm, focal_35mm = photo.metadata.focal_mm, photo.metadata.focal_35mm
    from_body = [
        _Found.of(*fields) for fields in (() if focal_mm is None else _from_body(photo, focal_mm, frame))
    ]  # fmt: skip
    yield from (f for f in from_body if f.basis is FocalSource.FOCAL_PLANE)
    if focal_35mm is not None:
        rounding = 0.29 / focal_35mm  # the standard deviation of rounding to whole millimetres
        sd = math.hypot(math.hypot(_EQUIVALENT_SD, rounding), frame.size_rel_sd)
        yield _Found.of(_from_equivalent(focal_35mm, frame), sd, FocalSource.EQUIVALENT)
    yield from (f for f in from_body if f.basis is not FocalSource.FOCAL_PLANE)


def _from_equivalent(focal_35mm: float, frame: Frame) -> float:
    return focal_35mm * frame.diagonal_px / _FULL_FRAME_DIAGONAL_MM


def _from_body(photo: Photo, focal_mm: float, frame: Frame) -> Iterator[tuple[float, float, FocalSource, str]]:
    """Yield pixels, relative sd, basis and its particulars of a focal length in millimetres on the camera's sensor."""
    from .lens import crop_factor

    metadata, focal_mm_zoomed = photo.metadata, focal_mm * _zoom(photo)
    if metadata.focal_plane_px_per_mm is not None:
        f_px = focal_mm_zoomed * metadata.focal_plane_px_per_mm * frame.scale
        yield f_px, math.hypot(_LENS_SD, frame.scale_rel_sd), FocalSource.FOCAL_PLANE, ""
    factor = crop_factor(metadata.make, metadata.model, focal_mm)
    if factor is not None:
        f_px = _from_equivalent(focal_mm_zoomed * factor, frame)
        sd = math.hypot(_CROP_FACTOR_SD, frame.size_rel_sd)
        yield f_px, sd, FocalSource.CROP_FACTOR, f"{factor:.4g} of {metadata.model}"
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
    sd = math.sqrt(_LENS_SD**2 + frame.size_rel_sd**2 + (shape_sd**2 if shape_sd > 0.01 else 0.0))
    return focal_mm * max(along, across), sd


def _zoom(photo: Photo) -> float:
    return photo.metadata.digital_zoom or 1.0


def _settle_zoom(photo: Photo, found: tuple[_Found, ...]) -> tuple[_Found, ...]:
    """Find out whether the 35 mm equivalent counts the digital zoom: the standard does not say, and makers differ."""
    zoom = _zoom(photo)
    tagged = [f for f in found if f.candidate.source.kind is FocalSource.EQUIVALENT]
    if zoom == 1.0 or not tagged:
        return found
    (tag,) = tagged
    tagged_px = tag.candidate.focal_px
    by_body = (FocalSource.FOCAL_PLANE, FocalSource.CROP_FACTOR)
    references = [f.candidate.focal_px for f in found if f.candidate.source.kind in by_body]
    if references:
        without = abs(math.log(tagged_px * zoom / references[0]))
        if without < abs(math.log(tagged_px / references[0])):
            source = replace(tag.candidate.source, detail=f"x digital zoom {zoom:g}")
            settled = replace(tag.candidate, focal_px=tagged_px * zoom, source=source)
        else:
            settled = tag.candidate
    else:
        settled = replace(tag.candidate, rel_sd=math.hypot(tag.candidate.rel_sd, math.log(zoom) / HALF_WIDTH_SD))
    return tuple(replace(f, candidate=settled) if f is tag else f for f in found)


def _weigh(photo: Photo, found: tuple[_Found, ...], frame: Frame) -> tuple[Candidate, Frame, list[Flag]]:
    """Return the first candidate, its interval wide enough to hold those that contradict it, and the doubts."""
    chosen, doubts, sd = found[0].candidate, list[Flag](), found[0].candidate.rel_sd
    if _zoom(photo) > 1:
        doubts.append(Flag(Doubt.ZOOMED, f"digital zoom {_zoom(photo):g}x"))
    for other in (f.candidate for f in found[1:]):
        if other.source.is_assumed:
            continue
        apart = math.log(other.focal_px / chosen.focal_px)
        if abs(apart) <= max(2 * math.hypot(chosen.rel_sd, other.rel_sd), 0.05):
            continue
        text = f"{other.source} says {other.focal_px:.0f} px, {chosen.source} {chosen.focal_px:.0f} px"
        doubts.append(Flag(Doubt.CONTRADICTED, text))
        if apart < 0 and found[0].basis is FocalSource.FOCAL_PLANE:  # it implies a smaller sensor than the camera has
            if frame.crop is not None:
                continue  # a crop is the explanation: the resolution still holds, the other does not
            room = (math.exp(-apart) - 1) * max(photo.width, photo.height) / math.sqrt(12)
            shift = min(room, 0.3 * max(photo.width, photo.height))
            frame = replace(frame, crop="sensor implied by the focal plane resolution", principal_sd_px=shift)
        if chosen.rel_sd > 0:  # what is stated in pixels is a calibration, and stands
            sd = max(sd, math.hypot(chosen.rel_sd, apart / HALF_WIDTH_SD))
    return replace(chosen, rel_sd=sd), frame, doubts


def _what_is_missing(photo: Photo, stated_mm: float | None) -> str:
    metadata = photo.metadata
    focal_mm = stated_mm or metadata.focal_mm
    if focal_mm is not None:
        camera = metadata.model or "the camera, which the photo does not name,"
        return (
            f"focal length {focal_mm:g} mm, but the sensor size of {camera} is unknown; "
            "state it with --sensor-mm WxH or --camera-table"
        )
    return (
        "no focal length in the photo; state one with --focal-35mm, --focal-mm and --sensor-mm, --focal-px or "
        "--camera-table, or assume one with --assume-fov"
    )
