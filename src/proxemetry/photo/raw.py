"""Raw files, by LibRaw; and what is known of any file before its pixels are decoded."""

from __future__ import annotations

import io
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from ..arrays import RGBArray
from ..errors import PhotoError
from ..files import open_file
from .metadata import Metadata, read_metadata

RAW_EXTENSIONS = (
    ".3fr", ".arw", ".cr2", ".cr3", ".dng", ".iiq", ".nef", ".nrw", ".orf", ".pef", ".raf", ".rw2", ".srw"
)  # fmt: skip
#: What decoding one photo may take. It holds a 108-megapixel JPEG, and keeps a hostile file from taking the machine.
MEMORY_BUDGET_BYTES = 800_000_000
_EXIF_BYTES = 64_000_000


@dataclass(frozen=True)
class Header:
    """What is known of a file before its pixels are decoded; the size is the upright photo's, in pixels."""

    width: int
    height: int
    metadata: Metadata


def raw_header(raw: Any, path: Path, with_names: bool, with_gps: bool) -> Header:
    """Return the upright size and the metadata of a raw file."""
    sizes = raw.sizes
    width, height = int(sizes.width), int(sizes.height)
    if sizes.flip in (5, 6):
        width, height = height, width
    return Header(width, height, _raw_metadata(raw, path, with_names, with_gps))


def _raw_metadata(raw: Any, path: Path, with_names: bool, with_gps: bool) -> Metadata:
    """Read the EXIF of a raw file: its own where it is built like a TIFF, else its preview's, else LibRaw's word.

    Some makers write the 35 mm equivalent into the preview alone.
    """
    import rawpy
    from PIL import Image

    found = Metadata(raw=True)
    with open_file(path) as file:
        start = file.read(_EXIF_BYTES)
    if start[:2] in (b"II", b"MM"):  # some makers write another number where a TIFF has 42
        holder = Image.new("L", (1, 1))
        holder.info["exif"] = (b"II*\0" if start[:2] == b"II" else b"MM\0*") + start[4:]
        found = read_metadata(holder, with_names=with_names, with_gps=with_gps, raw=True)
    if found.focal_mm is None or found.focal_35mm is None:
        try:
            thumbnail = raw.extract_thumb()
            if thumbnail.format == rawpy.ThumbFormat.JPEG:
                with Image.open(io.BytesIO(thumbnail.data), formats=("JPEG",)) as image:
                    preview = read_metadata(image, with_names=with_names, with_gps=with_gps, raw=True)
                if found.focal_mm is None:
                    found = preview
                elif preview.focal_mm is None or abs(preview.focal_mm - found.focal_mm) < 0.5:  # of the same lens
                    found = replace(found, focal_35mm=preview.focal_35mm)
        except Exception:  # a raw file need not have a preview, nor the preview any EXIF
            pass
    focal_mm = float(getattr(getattr(raw, "other", None), "focal_length", 0.0))
    return found if found.focal_mm is not None or not focal_mm > 0.5 else replace(found, focal_mm=focal_mm)


def raw_pixels(raw: Any, path: Path, long_side_px: int | None) -> RGBArray:
    """Return upright RGB pixels, at half the size where that is still `long_side_px`; raises PhotoError."""
    width, height = int(raw.sizes.width), int(raw.sizes.height)
    half = long_side_px is not None and max(width, height) // 2 >= long_side_px
    # LibRaw holds the sensor's values (2 bytes), four 16-bit colours and our three bytes at once.
    needed = width * height * (2 + (8 + 3) / (4 if half else 1))
    if needed > MEMORY_BUDGET_BYTES:
        raise PhotoError(
            f"{path}: {width} x {height} raw pixels would take {needed / 1e9:.1f} GB to decode; make it smaller first"
        )
    return np.ascontiguousarray(raw.postprocess(half_size=half, use_camera_wb=True))
