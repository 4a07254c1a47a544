"""A photo: upright RGB pixels, its metadata, and its hash. Formats and orientation end here."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from ..arrays import RGBArray
from ..errors import PhotoError
from ..files import sha256_of
from .formats import RAW_EXTENSIONS, decode, read_header
from .metadata import Metadata

__all__ = ["EXTENSIONS", "LARGEST_PX", "Metadata", "Photo", "RGBArray"]


#: Longest side of a photo, pixels: JPEG ends at 65,535, stitched panoramas do not come near a million.
LARGEST_PX = 1_000_000

#: File name endings that a folder is searched for.
EXTENSIONS = (
    ".jpg", ".jpeg", ".jpe", ".jfif", ".jif", ".jfi", ".pjpeg", ".pjp", ".jpg_large", ".jpg_orig", ".jpg-large", ".mpo",
    ".jp2", ".j2k", ".jpf", ".jpx", ".png", ".tif", ".tiff", ".webp", ".avif", ".bmp", ".gif", ".heic", ".heif",
    ".hif", *RAW_EXTENSIONS,
)  # fmt: skip


#: What was decoded last is kept up to this size, since several stages look at one photo: 2000 x 3000 pixels twice over.
_KEPT_BYTES = 36_000_000


@dataclass(frozen=True, eq=False)
class Photo:
    """One photo, upright. Pixels are decoded on request, at the requested scale.

    name: as results call it. width, height: of the upright full-size photo, pixels. sha256: of the file's bytes.
    """

    name: str
    width: int
    height: int
    sha256: str
    metadata: Metadata = field(default_factory=Metadata)
    path: Path | None = None
    _pixels: RGBArray | None = None
    _reduced: list[RGBArray] = field(default_factory=list["RGBArray"], repr=False)

    @classmethod
    def open(
        cls, path: str | Path, name: str | None = None, *, with_names: bool = False, with_gps: bool = False
    ) -> Photo:
        """Read a file's header, metadata and hash; raises PhotoError where it is no photo.

        The names of people, the creator and the caption are read only with `with_names`, the coordinates of the
        place only with `with_gps`.
        """
        path = Path(path)
        header = read_header(path, with_names=with_names, with_gps=with_gps)
        try:
            digest = sha256_of(path)
        except OSError as error:
            raise PhotoError(f"{path}: cannot be read ({error.strerror})") from error
        if max(header.width, header.height) > LARGEST_PX:
            raise PhotoError(
                f"{path}: its header claims {header.width} x {header.height} pixels; no photo is wider or taller than "
                f"{LARGEST_PX:,}"
            )
        return cls(name or path.name, header.width, header.height, digest, header.metadata, path)

    @classmethod
    def from_array(cls, pixels: RGBArray, name: str = "array", metadata: Metadata | None = None) -> Photo:
        """Return a photo of upright RGB pixels of shape (H, W, 3), uint8; raises PhotoError for any other."""
        if pixels.ndim != 3 or pixels.shape[2] != 3 or pixels.dtype != np.uint8:
            raise PhotoError(f"{name}: pixels must be uint8 of shape (H, W, 3), not {pixels.dtype} {pixels.shape}")
        if not pixels.size:
            raise PhotoError(f"{name}: a photo of {pixels.shape[1]} x {pixels.shape[0]} pixels has nothing to see")
        frozen = pixels.view()
        frozen.setflags(write=False)
        digest = hashlib.sha256(np.ascontiguousarray(pixels).tobytes()).hexdigest()
        return cls(name, pixels.shape[1], pixels.shape[0], digest, metadata or Metadata(), None, frozen)

    def pixels(self, long_side_px: int | None = None) -> RGBArray:
        """Return upright RGB pixels of shape (H, W, 3), read-only.

        With `long_side_px` the decoder may answer with a smaller photo whose long side is still at least that (the
        whole photo where it is not larger), and of a photo too large for the memory budget with less: scale by the
        answer's own shape. Raises PhotoError where decoding fails.
        """
        if self._pixels is not None:
            return self._pixels
        assert self.path is not None
        if long_side_px is not None:
            for kept in self._reduced:
                if min(long_side_px, max(self.width, self.height)) <= max(kept.shape):
                    return kept
        pixels = decode(self.path, long_side_px)
        pixels.setflags(write=False)
        if long_side_px is not None and pixels.nbytes <= _KEPT_BYTES:
            self._reduced[:] = [pixels]
        return pixels

    @property
    def has_pixels(self) -> bool:
        """Whether its pixels were given, rather than a file to decode."""
        return self._pixels is not None
