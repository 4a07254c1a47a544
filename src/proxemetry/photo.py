"""A photo: upright RGB pixels, what its metadata say, and its hash. Formats and orientation end here."""

from __future__ import annotations

import hashlib
import io
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageOps, UnidentifiedImageError

from .errors import PhotoError

RGBArray = NDArray[np.uint8]

#: File name endings that a folder is searched for.
EXTENSIONS = (".jpg", ".jpeg", ".png", ".tif", ".tiff", ".webp")


@dataclass(frozen=True)
class Metadata:
    """What a file says of its camera, as numbers; None where it says nothing or nothing usable."""

    make: str | None = None
    model: str | None = None
    focal_mm: float | None = None
    focal_35mm: float | None = None

    def about(self) -> dict[str, str]:
        """Return date, country, city and source as far as the metadata say; these travel into the results."""
        return {}


@dataclass(frozen=True, eq=False)
class Photo:
    """One photo, upright. Pixels are decoded when asked for, at the scale asked for.

    name: as results call it. width, height: of the upright full-size photo, pixels. sha256: of the file's bytes.
    """

    name: str
    width: int
    height: int
    sha256: str
    metadata: Metadata = field(default_factory=Metadata)
    path: Path | None = None
    _pixels: RGBArray | None = None

    @classmethod
    def open(cls, path: str | Path, name: str | None = None) -> Photo:
        """Read a file's header, metadata and hash; raises PhotoError where it is no photo."""
        path = Path(path)
        try:
            content = path.read_bytes()
            with Image.open(io.BytesIO(content)) as image:
                width, height = image.size
                if image.getexif().get(0x0112, 1) in (5, 6, 7, 8):
                    width, height = height, width
        except FileNotFoundError as error:
            raise PhotoError(f"{path}: no such file") from error
        except (UnidentifiedImageError, OSError, ValueError) as error:
            raise PhotoError(f"{path}: not a photo that can be read ({error})") from error
        return cls(name or path.name, width, height, hashlib.sha256(content).hexdigest(), Metadata(), path)

    @classmethod
    def from_array(cls, pixels: RGBArray, name: str = "array", metadata: Metadata | None = None) -> Photo:
        """Return a photo of upright RGB pixels of shape (H, W, 3), uint8; raises PhotoError for any other."""
        if pixels.ndim != 3 or pixels.shape[2] != 3 or pixels.dtype != np.uint8:
            raise PhotoError(f"{name}: pixels must be uint8 of shape (H, W, 3), not {pixels.dtype} {pixels.shape}")
        frozen = pixels.view()
        frozen.setflags(write=False)
        digest = hashlib.sha256(np.ascontiguousarray(pixels).tobytes()).hexdigest()
        return cls(name, pixels.shape[1], pixels.shape[0], digest, metadata or Metadata(), None, frozen)

    def pixels(self, long_side_px: int | None = None) -> RGBArray:
        """Return upright RGB pixels of shape (H, W, 3), read-only.

        With `long_side_px` the decoder may answer with a smaller photo whose long side is still at least that (the
        whole photo where it is not larger): scale by the answer's own shape. Raises PhotoError where decoding fails.
        """
        if self._pixels is not None:
            return self._pixels
        assert self.path is not None
        try:
            with Image.open(self.path) as image:
                if long_side_px is not None and max(image.size) > long_side_px:
                    factor = long_side_px / max(image.size)
                    image.draft("RGB", (int(image.width * factor) + 1, int(image.height * factor) + 1))
                upright = ImageOps.exif_transpose(image).convert("RGB")
                pixels = np.asarray(upright)
        except (OSError, ValueError, SyntaxError) as error:
            raise PhotoError(f"{self.name}: cannot be decoded ({error})") from error
        pixels.setflags(write=False)
        return pixels
