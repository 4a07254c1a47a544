"""A photo's camera, place and date as its file states them: EXIF, IPTC and XMP as plain values.

Anything in a file may be absent, damaged or nonsense. What cannot be used becomes None, with a remark where that
matters to the focal length; nothing here raises.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, fields, replace
from enum import StrEnum
from typing import TYPE_CHECKING, Any

from .about import About
from .exif_values import Numbers, date_of, number_of, position_of, text_of
from .xmp_iptc import first, iptc_of, xmp_of

if TYPE_CHECKING:
    from PIL import Image

_EXIF_IFD, _GPS_IFD = 0x8769, 0x8825
#: FocalPlaneResolutionUnit -> units in a millimetre (EXIF 2.32, 4.6.5; 4 and 5 are in use though not in the standard).
_UNITS_PER_MM = {1: 1 / 25.4, 2: 1 / 25.4, 3: 1 / 10, 4: 1.0, 5: 1000.0}


#: No rectilinear lens is wider than 9 mm equivalent; the tag is rounded. Below, cameras write their own millimetres.
_WIDEST_MM = 8.5
#: CustomRendered (0xA401): what Apple's cameras write for a swept panorama.
_SWEPT = 6


class Projection(StrEnum):
    """How the space in front of the camera lies on the picture, where the file states that it is not by one lens."""

    SPHERE = "a photo sphere"
    PANORAMA = "a swept panorama"


@dataclass(frozen=True)
class Crop:
    """The rectangle that an editor kept of the picture as the sensor has it, before it was turned upright.

    left, top and right, bottom: the rectangle's upper left and lower right corner, shares of the picture's width and
    height. angle_deg: how far the rectangle is turned (XMP Camera Raw schema, CropLeft to CropAngle).
    """

    left: float
    top: float
    right: float
    bottom: float
    angle_deg: float


@dataclass(frozen=True)
class Flight:
    """What a drone recorded about its camera; None where it did not.

    height_m: above the take-off point. gimbal_pitch_deg: negative looks down. gimbal_roll_deg: as the drone has it.
    """

    height_m: float | None = None
    gimbal_pitch_deg: float | None = None
    gimbal_roll_deg: float | None = None


@dataclass(frozen=True)
class Metadata:
    """A file's statements as numbers and short texts; None where there is none or none that is usable.

    Of the camera: make, model, lens; focal_mm; focal_35mm (the 35 mm equivalent); f_number; focal_plane_px_per_mm
    (FocalPlaneXResolution in pixels per millimetre); stored_width_px, stored_height_px (PixelXDimension and
    PixelYDimension, turned upright as the orientation tag states); digital_zoom (above 1); cropped (an editor's crop is
    recorded, and made); crop (what was cut, where that is recorded too); lens_corrected (an editor has corrected the
    lens); raw (a sensor's raw file); edited_by (the editing program that wrote the file, where it is named);
    projection (None for a picture of one perspective); flight (a drone's height and angles); orientation
    (EXIF's, 1 to 8, applied on reading).
    Of the picture: date (ISO 8601), city, country, source.
    Only on request: creator, caption, people (names of those shown); gps (latitude, longitude in degrees).
    remarks: what was there but could not be used.
    """

    make: str | None = None
    model: str | None = None
    lens: str | None = None
    focal_mm: float | None = None
    focal_35mm: float | None = None
    f_number: float | None = None
    focal_plane_px_per_mm: float | None = None
    stored_width_px: int | None = None
    stored_height_px: int | None = None
    digital_zoom: float | None = None
    cropped: bool = False
    crop: Crop | None = None
    lens_corrected: bool = False
    raw: bool = False
    edited_by: str | None = None
    projection: Projection | None = None
    flight: Flight | None = None
    orientation: int = 1
    date: str | None = None
    city: str | None = None
    country: str | None = None
    source: str | None = None
    creator: str | None = None
    caption: str | None = None
    people: tuple[str, ...] = ()
    gps: tuple[float, float] | None = None
    remarks: tuple[str, ...] = ()

    def completed_by(self, other: Metadata) -> Metadata:
        """Return these metadata with what they lack from another place of the same file."""
        names = (field.name for field in fields(self) if not getattr(self, field.name) and getattr(other, field.name))
        return replace(self, **{name: getattr(other, name) for name in names})

    def about(self) -> About:
        """Return what the metadata state of the picture itself, which is copied into the results."""
        latitude, longitude = (None, None) if self.gps is None else (round(degrees, 6) for degrees in self.gps)
        return About(
            self.date, self.country, self.city, self.source, self.creator, self.caption, self.people, latitude,
            longitude, self.make, self.model, self.focal_mm, self.digital_zoom,
        )  # fmt: skip


def orientation_of(image: Image.Image) -> int:
    """Return the EXIF orientation (1 to 8) that is still to be applied to an opened image; 1 where none is given."""
    from PIL import Image

    if image.format == "TIFF":  # Pillow turns a TIFF itself
        return 1
    try:
        # The base class's method: the PNG plugin's own decodes all pixels to look for a late EXIF chunk.
        value = Image.Image.getexif(image).get(0x0112, 1)
    except Exception:  # a hostile file may break the parser in any way; see `_tags`
        return 1
    return int(value) if isinstance(value, int) and 1 <= value <= 8 else 1


def read_metadata(
    image: Image.Image, *, with_names: bool = False, with_gps: bool = False, raw: bool = False
) -> Metadata:
    """Return the metadata of an opened image: EXIF, XMP and IPTC.

    Names and captions are read only with `with_names`, the place's coordinates only with `with_gps`.
    """
    remarks: list[str] = []
    exif, gps = _tags(image, with_gps, remarks)
    xmp = xmp_of(image, exif, remarks)
    iptc = iptc_of(image, exif)
    numbers = Numbers(exif, xmp, remarks)
    stored = (
        _pixels(numbers.within("stored width", 0xA002, "exif:PixelXDimension", 16, 10**6)),
        _pixels(numbers.within("stored height", 0xA003, "exif:PixelYDimension", 16, 10**6)),
    )
    if (image.info.get("original_orientation") or exif.get(0x0112)) in (5, 6, 7, 8):
        stored = stored[::-1]
    cropped = _is_cropped(xmp)
    return Metadata(
        make=text_of(exif.get(0x010F), *xmp.get("tiff:Make", ())),
        model=text_of(exif.get(0x0110), *xmp.get("tiff:Model", ())),
        lens=text_of(exif.get(0xA434), *xmp.get("exifEX:LensModel", ()), *xmp.get("aux:Lens", ())),
        focal_mm=numbers.within("focal length", 0x920A, "exif:FocalLength", 0.5, 5000),
        focal_35mm=numbers.within("35 mm equivalent", 0xA405, "exif:FocalLengthIn35mmFilm", _WIDEST_MM, 5000),
        f_number=numbers.within("aperture", 0x829D, "exif:FNumber", 0.3, 200),
        focal_plane_px_per_mm=_focal_plane(numbers),
        stored_width_px=stored[0],
        stored_height_px=stored[1],
        digital_zoom=_zoom(numbers.within("digital zoom", 0xA404, "exif:DigitalZoomRatio", 1, 200)),
        cropped=cropped,
        crop=_crop(xmp) if cropped else None,
        lens_corrected=first(xmp, "crs:LensProfileEnable") == "1",
        raw=raw,
        edited_by=_editor(exif, xmp),
        projection=_projection(numbers, xmp),
        flight=_flight(xmp),
        orientation=_orientation(exif),
        gps=position_of(gps),
        remarks=tuple(remarks),
        **_of_the_picture(exif, xmp, iptc, with_names),
    )


def _of_the_picture(
    exif: dict[int, Any], xmp: dict[str, tuple[str, ...]], iptc: dict[int, tuple[str, ...]], with_names: bool
) -> dict[str, Any]:
    """Return the fields of `Metadata` that are about the picture itself; names and captions only with `with_names`."""
    stated = {
        "date": date_of(*iptc.get(55, ()), *xmp.get("photoshop:DateCreated", ()), exif.get(0x9003)),
        "city": text_of(*iptc.get(90, ()), *xmp.get("photoshop:City", ())),
        "country": text_of(*iptc.get(101, ()), *xmp.get("photoshop:Country", ())),
        "source": text_of(
            *iptc.get(115, ()), *xmp.get("photoshop:Source", ()), *iptc.get(110, ()), *xmp.get("photoshop:Credit", ())
        ),
    }
    if not with_names:
        return stated
    people = (*iptc.get(122, ()), *xmp.get("iptcExt:PersonInImage", ()))
    return {
        **stated,
        "creator": text_of(*iptc.get(80, ()), *xmp.get("dc:creator", ()), exif.get(0x013B)),
        "caption": text_of(*iptc.get(120, ()), *xmp.get("dc:description", ()), exif.get(0x010E)),
        "people": tuple(dict.fromkeys(name for name in map(text_of, people) if name)),
    }


def _orientation(exif: dict[int, Any]) -> int:
    value = exif.get(0x0112)
    return value if isinstance(value, int) and 1 <= value <= 8 else 1


def _flight(xmp: dict[str, tuple[str, ...]]) -> Flight | None:
    """Return what DJI's schema says, whose numbers carry a sign: "+30.10"."""
    names = ("RelativeAltitude", "GimbalPitchDegree", "GimbalRollDegree")
    values = [number_of(first(xmp, f"drone-dji:{name}").removeprefix("+") or None) for name in names]
    known = [value if value is not None and math.isfinite(value) else None for value in values]
    return None if known == [None] * len(names) else Flight(*known)


def _projection(numbers: Numbers, xmp: dict[str, tuple[str, ...]]) -> Projection | None:
    """Return the projection of a picture stitched from many, by Google's panorama schema or the camera's own tag."""
    kind = first(xmp, "GPano:ProjectionType").lower()
    if kind == "equirectangular" or first(xmp, "GSpherical:Spherical").lower() == "true":
        return Projection.SPHERE
    if kind in ("cylindrical", "cubemap") or numbers.number(0xA401, "exif:CustomRendered") == _SWEPT:
        return Projection.PANORAMA
    stitched = first(xmp, "GPano:UsePanoramaViewer").lower() == "true" or "GPano:FullPanoWidthPixels" in xmp
    return Projection.PANORAMA if stitched and kind != "rectilinear" else None


#: Words by which programs that resize photos name themselves; cameras write their firmware's version instead.
_EDITORS = (
    "acdsee", "adobe", "affinity", "aperture", "canva", "capture one", "darktable", "digikam", "digital photo pro",
    "dxo", "faststone", "gimp", "google", "imagemagick", "iphoto", "irfanview", "lightroom", "luminar", "microsoft",
    "nx studio", "paint", "photo gallery", "photoscape", "photoshop", "picasa", "pixelmator", "pixlr", "polarr",
    "rawtherapee", "snapseed", "viewnx", "xnview", "zoner",
)  # fmt: skip


def _editor(exif: dict[int, Any], xmp: dict[str, tuple[str, ...]]) -> str | None:
    """Return the program that wrote the file, where it names itself and is an editor."""
    name = text_of(exif.get(0x0131), *xmp.get("xmp:CreatorTool", ()), *xmp.get("tiff:Software", ()))
    return name if name is not None and any(word in name.lower() for word in _EDITORS) else None


def _is_cropped(xmp: dict[str, tuple[str, ...]]) -> bool:
    """Return whether an editor's crop is recorded; one that is recorded as still to be made is none."""
    pending = first(xmp, "crs:AlreadyApplied").lower() == "false"
    return first(xmp, "crs:HasCrop").lower() == "true" and not pending


def _crop(xmp: dict[str, tuple[str, ...]]) -> Crop | None:
    """Return the rectangle that was cut out, None where it is not recorded or makes no sense."""
    if first(xmp, "crs:AlreadyApplied").lower() != "true":
        return None
    try:
        left, top, right, bottom, angle = (
            float(first(xmp, f"crs:Crop{name}")) for name in ("Left", "Top", "Right", "Bottom", "Angle")
        )
    except ValueError:
        return None
    sides = (left, top, right, bottom)
    sensible = all(-0.01 <= side <= 1.01 for side in sides) and left < right and top < bottom and abs(angle) <= 45
    return Crop(*sides, angle) if sensible else None


def _tags(image: Image.Image, with_gps: bool, remarks: list[str]) -> tuple[dict[int, Any], dict[int, Any]]:
    """Return the EXIF tags of the first and the Exif directory in one dict, and those of the GPS directory."""
    from PIL import Image

    tags: dict[int, Any] = {}
    gps: dict[int, Any] = {}
    try:
        exif = Image.Image.getexif(image)
        tags.update(exif)
        tags.update(exif.get_ifd(_EXIF_IFD))  # where FocalLength is: `getexif()` alone does not show it
        if with_gps:
            gps.update(exif.get_ifd(_GPS_IFD))
    except Exception as error:  # Pillow's parser meets hostile bytes here: any exception means damaged EXIF
        remarks.append(f"EXIF is damaged ({type(error).__name__})")
    return tags, gps


def _focal_plane(numbers: Numbers) -> float | None:
    unit = _UNITS_PER_MM.get(int(numbers.number(0xA210, "exif:FocalPlaneResolutionUnit") or 2))
    value = numbers.number(0xA20E, "exif:FocalPlaneXResolution")
    if value is None or unit is None:
        return None
    # 0.8 to 100 micrometres a pixel: what photographic sensors and their reduced files can have
    if not 10 <= value * unit <= 1250:
        numbers.remarks.append(f"focal plane resolution {value:g} in the metadata is unusable")
        return None
    return value * unit


def _pixels(value: float | None) -> int | None:
    return None if value is None else int(value)


def _zoom(value: float | None) -> float | None:
    return value if value is not None and value > 1.001 else None
