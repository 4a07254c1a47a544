"""What lensfun's database knows of cameras and lenses: crop factors and lens distortion."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from ..arrays import FloatArray
from ..errors import SettingsError
from ..photo.metadata import Metadata

#: Mounts of cameras without a mirror, which correct their lenses in the JPEGs they write, or may have done so.
_MOUNTS_CORRECTED_IN_CAMERA = frozenset(
    (
        "Canon EF-M", "Canon RF", "Fujifilm G", "Fujifilm X", "Leica L", "Micro 4/3 System", "Nikon CX", "Nikon Z",
        "Pentax Q", "Samsung NX", "Samsung NX mini", "Sony E",
    )
)  # fmt: skip
#: Mounts of bodies that may use a part of their sensor alone, and single bodies of another mount that do.
_MOUNTS_WITH_CROP_MODES = frozenset(
    ("Canon RF", "Fujifilm G", "Leica L", "Nikon F AF", "Nikon Z", "Pentax KAF2", "Pentax KAF4", "Sony Alpha", "Sony E")
)
_WITH_CROP_MODES = frozenset(("Canon EOS 5DS", "Canon EOS 5DS R"))
#: How far a photo's shape may be from that of a variant.
_SHAPE_TOLERANCE = 0.03
#: Points along the long side at which lensfun's mapping is taken; it is smooth, and a fit to 10^4 points is stable.
_GRID = 121


@dataclass(frozen=True)
class LensCorrection:
    """A lens's distortion as OpenCV's k1, k2, p1, p2, k3, and how well these repeat lensfun's mapping.

    residual_px, worst_px: root mean square and largest difference over the picture, in pixels of the photo.
    """

    lens: str
    distortion: tuple[float, float, float, float, float]
    residual_px: float
    worst_px: float

    def __str__(self) -> str:
        return f"{self.lens} (lensfun; repeated within {self.residual_px:.1f} px, {self.worst_px:.1f} px at worst)"


@lru_cache(maxsize=1)
def _database() -> Any:
    """Return lensfun's database; reading it takes a tenth of a second, so only where a photo needs it."""
    return _lensfun().Database()


def _lensfun() -> Any:
    try:
        import lensfunpy
    except ImportError as error:
        raise SettingsError(
            f"the database of cameras and lenses cannot be loaded ({error}); on Linux it needs the system's GLib: "
            "`apt install libglib2.0-0` or `dnf install glib2`"
        ) from error
    return lensfunpy


def require_lens_database() -> None:
    """Raise SettingsError where lensfun cannot be loaded: its package brings no copy of GLib, which a system may lack.

    Without it crop factors and distortion would be missing, and distances would be others than elsewhere.
    """
    _lensfun()


@lru_cache(maxsize=256)
def _cameras(make: str, model: str) -> tuple[Any, ...]:
    """Return lensfun's entries of a camera named as EXIF names it: several where one name stands for several."""
    for name in (model, f"{make} {model}"):
        found = _database().find_cameras(make, name)
        if found:
            return tuple(found)
    return ()


#: The shapes after which lensfun names variants of a camera.
_VARIANT = re.compile(r"(\d+):(\d+)")


def _variants(make: str | None, model: str | None, aspect: float | None) -> tuple[Any, ...]:
    """Return the entries that a photo of a shape (long side to short; None where unknown) may be of.

    Some cameras are listed once for each shape of their pictures, whose diagonals differ.
    """
    cameras = _cameras(make or "", model) if model else ()
    shapes = [_VARIANT.fullmatch(camera.variant or "") for camera in cameras]
    if aspect is None or len(cameras) < 2 or not all(shapes):
        return cameras
    apart = [abs(math.log(int(s[1]) / int(s[2]) / aspect)) for s in shapes if s]
    best = min(apart)
    return cameras if best > _SHAPE_TOLERANCE else (cameras[apart.index(best)],)


def _has_fixed_lens(camera: Any) -> bool:
    """Whether it is a compact camera or a phone: lensfun gives each a mount of its own, in small letters."""
    return bool(camera.mount) and camera.mount[0].islower()


@lru_cache(maxsize=1024)
def crop_factors(make: str | None, model: str | None, focal_mm: float, aspect: float | None) -> tuple[float, ...]:
    """Return the ratios of 43.267 mm to the diagonals of the sensors that a camera of this name may have.

    aspect: the photo's long side to its short one, None where it is an unknown part of the picture. Empty where the
    camera is unknown. A phone has several sensors behind one model name: an entry counts only where its lens has that
    focal length.
    """
    cameras = _variants(make, model, aspect)
    fixed = [camera for camera in cameras if _has_fixed_lens(camera)]
    lenses = [lens for camera in fixed for lens in _database().find_lenses(camera)]
    if lenses and not any(_covers(lens, focal_mm) for lens in lenses):
        return ()
    return tuple(sorted({float(camera.crop_factor) for camera in cameras}))


def may_crop_in_camera(make: str | None, model: str | None) -> bool:
    """Whether a camera can use a part of its sensor alone, as if it had a smaller one (DX mode, 1.6x crop)."""
    return any(c.mount in _MOUNTS_WITH_CROP_MODES or c.model in _WITH_CROP_MODES for c in _variants(make, model, None))


def lens_correction(metadata: Metadata, f_px: float, width: int, height: int) -> tuple[LensCorrection | None, str]:
    """Return the distortion of a photo's lens where body and lens are known, else None; and the doubt, or "".

    f_px, width, height: of the upright photo, which must not be a crop. A camera without a mirror corrects its own
    JPEGs, an editor may have done it: then there is nothing to correct any more.
    """
    if metadata.focal_mm is None or metadata.model is None or metadata.lens_corrected:
        return None, ""
    camera = next(iter(_variants(metadata.make, metadata.model, max(width, height) / min(width, height))), None)
    if camera is None:
        return None, ""
    lens = _lens(metadata.make or "", metadata.model, metadata.lens or "", metadata.focal_mm)
    if lens is None:
        return None, ""
    if "FISHEYE" in str(lens.type).upper():
        return None, f"fisheye lens ({lens.model}): distances away from the middle are wrong"
    corrected = _has_fixed_lens(camera) or camera.mount in _MOUNTS_CORRECTED_IN_CAMERA
    if corrected and not metadata.raw:
        return None, ""
    grid = _mapping(lens, float(camera.crop_factor), metadata.focal_mm, metadata.f_number or 8.0, width / height)
    if grid is None:
        return None, ""
    correction = _fit(lens.model, *grid, f_px / max(width, height), max(width, height))
    if correction is None:
        return None, f"distortion of {lens.model} cannot be corrected: OpenCV's model does not follow it"
    return correction, ""


@lru_cache(maxsize=256)
def _lens(make: str, model: str, name: str, focal_mm: float) -> Any | None:
    """Return lensfun's entry of a lens named as EXIF names it, where exactly one fits best; else None.

    lensfun matches words loosely (a 300 mm f/4 finds a 70-300 mm f/4-5.6), so the numbers and the generation in the
    two names must agree as well.
    """
    camera = _cameras(make, model)[0]
    if _has_fixed_lens(camera):
        lenses = [lens for lens in _database().find_lenses(camera) if _covers(lens, focal_mm)]
        return lenses[0] if len(lenses) == 1 else None
    if not name:
        return None
    lenses = _database().find_lenses(camera, None, name)
    if not lenses or (len(lenses) > 1 and lenses[0].score <= lenses[1].score):
        return None
    lens = lenses[0]
    return lens if _covers(lens, focal_mm) and _signature(name) == _signature(lens.model) else None


def _covers(lens: Any, focal_mm: float) -> bool:
    return 0.97 * lens.min_focal <= focal_mm <= 1.03 * max(lens.max_focal or 0.0, lens.min_focal)


def _signature(name: str) -> tuple[frozenset[float], int]:
    """Return the numbers of a lens's name and its generation: "EF 50mm f/1.8 II" gives {50, 1.8} and 2."""
    numbers = frozenset(float(number) for number in re.findall(r"\d+(?:\.\d+)?", name))
    roman = re.search(r"\b(?:Mk\s?)?(II|III|IV|V)\b", name)
    return numbers, {"II": 2, "III": 3, "IV": 4, "V": 5}[roman[1]] if roman else 1


def _mapping(
    lens: Any, factor: float, focal_mm: float, f_number: float, aspect: float
) -> tuple[FloatArray, FloatArray] | None:
    """Return points of an undistorted picture and where the lens puts them, shape (n, 2), or None.

    Measured from the middle in units of the long side. The mapping does not depend on the resolution, so a small
    grid of the photo's shape stands for all of it.
    """
    import lensfunpy

    width = _GRID if aspect >= 1 else round(_GRID * aspect)
    height = round(_GRID / aspect) if aspect >= 1 else _GRID
    modifier = lensfunpy.Modifier(lens, factor, width, height)  # pyright: ignore[reportAttributeAccessIssue]
    flags = lensfunpy.ModifyFlags.DISTORTION  # pyright: ignore[reportAttributeAccessIssue]
    modifier.initialize(focal_mm, f_number, 1000.0, 1.0, flags=flags)
    bent = modifier.apply_geometry_distortion()
    if bent is None:
        return None
    ideal = np.stack(np.meshgrid(np.arange(width), np.arange(height)), axis=-1)
    middle = ((width - 1) / 2, (height - 1) / 2)
    return ((ideal - middle) / _GRID).reshape(-1, 2), ((bent - middle) / _GRID).reshape(-1, 2).astype(float)


def _fit(name: str, ideal: FloatArray, bent: FloatArray, f: float, long_side_px: int) -> LensCorrection | None:
    """Fit OpenCV's model to a mapping; lengths and f in units of the long side. None where the result folds over.

    lensfun keeps the scale at its unit radius, OpenCV at the optical axis, where a lens has the focal length that is
    engraved on it. So the scale `s` between the two is fitted along, and then taken into the undistorted picture.
    """
    (x, y), seen = ideal.T / f, bent.T / f
    r2 = x * x + y * y
    model = [(x, y), (x * r2, y * r2), (x * r2**2, y * r2**2), (x * r2**3, y * r2**3)]
    model += [(2 * x * y, r2 + 2 * y * y), (r2 + 2 * x * x, 2 * x * y)]
    columns = np.stack([np.concatenate(pair) for pair in model], axis=1)
    target = np.concatenate(list(seen))
    terms, *_ = np.linalg.lstsq(columns, target)
    s, a1, a2, a3, q1, q2 = (float(term) for term in terms)
    error = np.hypot(*(columns @ terms - target).reshape(2, -1)) * f * long_side_px
    k1, k2, k3 = a1 / s**3, a2 / s**5, a3 / s**7
    radius2 = np.linspace(0, float(r2.max()) * s * s * 1.1, 200)
    slope = 1 + radius2 * (3 * k1 + radius2 * (5 * k2 + radius2 * 7 * k3))
    if s <= 0 or slope.min() <= 0:
        return None
    return LensCorrection(
        name, (k1, k2, q1 / s**2, q2 / s**2, k3), math.sqrt(float(np.mean(error**2))), float(error.max())
    )
