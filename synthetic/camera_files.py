"""Writes photographs with the metadata a test asks for."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image
from PIL.TiffImagePlugin import IFDRational

MAKE, MODEL, ORIENTATION = 0x010F, 0x0110, 0x0112
FOCAL, FOCAL_35, LENS, F_NUMBER, ZOOM = 0x920A, 0xA405, 0xA434, 0x829D, 0xA404
STORED_WIDTH, STORED_HEIGHT = 0xA002, 0xA003
PLANE_X, PLANE_UNIT, RENDERED, SOFTWARE = 0xA20E, 0xA210, 0xA401, 0x0131
_FIRST_DIRECTORY = (MAKE, MODEL, ORIENTATION, SOFTWARE, 0x013B, 0x010E)


def exif_of(tags: dict[int, Any], gps: dict[int, Any] | None = None) -> Image.Exif:
    """Return EXIF with these tags in the directory each belongs to; pairs are rationals."""
    exif = Image.Exif()
    for tag, value in tags.items():
        stored = IFDRational(*value) if isinstance(value, tuple) else value
        (exif if tag in _FIRST_DIRECTORY else exif.get_ifd(0x8769))[tag] = stored
    if gps:
        exif.get_ifd(0x8825).update(gps)
    return exif


def gradient(width: int, height: int) -> np.ndarray:
    """Return a picture with no two corners alike, shape (height, width, 3)."""
    y, x = np.mgrid[0:height, 0:width]
    return np.stack([255 * x / width, 255 * y / height, 255 * (x + y) / (width + height)], -1).astype(np.uint8)


def write(path: Path, width: int, height: int, tags: dict[int, Any] | None = None, **options: Any) -> Path:
    """Write a grey photo (its header is what counts) with EXIF tags and return its path."""
    if tags:
        options["exif"] = exif_of(tags)
    Image.new("L", (width, height), 90).save(path, **options)
    return path
