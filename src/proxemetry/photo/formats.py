"""The file formats a photo comes in: opening a header safely, and decoding to upright RGB within a memory budget."""

from __future__ import annotations

import io
import warnings
from collections.abc import Generator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..arrays import RGBArray
from ..errors import PhotoError
from .metadata import Metadata, orientation_of, read_metadata

if TYPE_CHECKING:
    from PIL import Image


RAW_EXTENSIONS = (
    ".3fr",
    ".arw",
    ".cr2",
    ".cr3",
    ".dng",
    ".iiq",
    ".nef",
    ".nrw",
    ".orf",
    ".pef",
    ".raf",
    ".rw2",
    ".srw",
)
_HEIC_BRANDS = (b"heic", b"heix", b"heim", b"heis", b"hevc", b"hevx", b"mif1", b"msf1")
#: Pillow reads 40 formats, one of them by running another program; these are the ones photographs come in.
_PILLOW_FORMATS = ("JPEG", "PNG", "TIFF", "WEBP", "AVIF", "GIF", "BMP")
#: What decoding one photo may take. It holds a 108-megapixel JPEG, and keeps a hostile file from taking the machine.
MEMORY_BUDGET_BYTES = 800_000_000
#: Converted at once: little enough to stay in a processor's cache on the way.
_STRIP_PX = 50_000
_RAW_EXIF_BYTES = 64_000_000


@dataclass(frozen=True)
class Header:
    """What is known of a file before its pixels are decoded; the size is the upright photo's, in pixels."""

    width: int
    height: int
    metadata: Metadata


def read_header(path: Path, *, with_names: bool = False, with_gps: bool = False) -> Header:
    """Return a file's upright size and metadata; raises PhotoError where it is no photo."""
    with _opened(path) as source:
        if not _is_image(source):
            return _raw_header(source, path, with_names, with_gps)
        metadata = read_metadata(source, with_names=with_names, with_gps=with_gps)
        width, height = source.size
        if orientation_of(source) >= 5:
            width, height = height, width
        return Header(width, height, metadata)


def decode(path: Path, long_side_px: int | None = None) -> RGBArray:
    """Return upright RGB pixels of shape (H, W, 3), reduced where the answer still has `long_side_px` or more.

    Raises PhotoError where decoding fails, stops before the end, or would take more than the memory budget.
    """
    with _opened(path) as source:
        if not _is_image(source):
            return _raw_pixels(source, path, long_side_px)
        # Before anything is decoded: afterwards nothing may tell any more how the file was turned.
        orientation = orientation_of(source)
        longest = max(source.size)
        if long_side_px is not None and longest > long_side_px:
            width, height = (-(-side * long_side_px // longest) for side in source.size)
            source.draft("RGB", (width, height))
        _check_memory(source, path)
        source.load()
        return _upright(_rgb(source, path), orientation)


def _is_image(source: Any) -> bool:
    from PIL import Image  # here, as wherever it is needed: what only reads results needs no image library

    return isinstance(source, Image.Image)


@contextmanager
def _opened(path: Path) -> Generator[Any]:
    """Open a file as a Pillow image or a rawpy object; whatever a decoder throws leaves as a PhotoError."""
    if not path.is_file():  # a device or a pipe would block for ever
        raise PhotoError(f"{path}: {'not a file' if path.exists() else 'no such file'}")
    try:
        with path.open("rb") as file:
            start = file.read(12)
        if not start:
            raise PhotoError(f"{path}: the file is empty")
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # the decoders' warnings are for their developers
            with _source(path, start) as source:
                yield source
    except (PhotoError, MemoryError):
        raise
    except Exception as error:  # the decoders meet hostile bytes here and raise nearly anything
        said = error.args[0] if error.args else ""
        text = said.decode("utf-8", "replace") if isinstance(said, bytes) else str(error)
        text = " ".join(text.split())[:150] or type(error).__name__
        if "cannot identify image file" in text:
            text = "no image format that is known"
        raise PhotoError(f"{path}: not a photo that can be read ({text})") from error


def _source(path: Path, start: bytes) -> Any:
    from PIL import Image

    formats = _PILLOW_FORMATS
    if start[4:8] == b"ftyp" and start[8:12] in _HEIC_BRANDS:
        try:
            import pi_heif
        except ImportError as error:
            raise PhotoError(f"{path}: HEIC needs an extra: pip install 'proxemetry[heic]'") from error
        pi_heif.register_heif_opener()
        formats = ("HEIF",)
    elif path.suffix.lower() in RAW_EXTENSIONS:
        try:
            import rawpy
        except ImportError as error:
            raise PhotoError(f"{path}: a raw file needs an extra: pip install 'proxemetry[raw]'") from error
        return rawpy.imread(str(path))
    return Image.open(path, formats=formats)


def _check_memory(image: Image.Image, path: Path) -> None:
    """Refuse what would not fit: the decoder's pixels, our three bytes, a progressive JPEG's coefficients."""
    per_pixel = 3 + (1 if image.mode in ("L", "P", "1") else 2 if image.mode.startswith("I;16") else 4)
    needed = per_pixel * image.width * image.height
    if image.info.get("progressive"):
        full = getattr(image, "decoderconfig", (1, 0)) or (1, 0)
        needed += 6 * image.width * image.height * max(full[0], 1) ** 2
    if needed > MEMORY_BUDGET_BYTES:
        raise PhotoError(
            f"{path}: {image.width} x {image.height} pixels would take {needed / 1e9:.1f} GB to decode, more than "
            f"{MEMORY_BUDGET_BYTES / 1e9:.1f} GB; make it smaller first"
        )


def _rgb(image: Image.Image, path: Path) -> RGBArray:
    """Convert a decoded image strip by strip, so that it is never held twice; transparent parts become white."""
    from PIL import Image

    if image.mode == "F":
        raise PhotoError(f"{path}: floating point pixels have no known white; save the photo with 8 or 16 bits")
    pixels = np.empty((image.height, image.width, 3), dtype=np.uint8)
    depth = _depth(image)
    step = max(1, _STRIP_PX // image.width)
    for top in range(0, image.height, step):
        strip = image.crop((0, top, image.width, min(top + step, image.height)))
        if depth is not None:
            pixels[top : top + step] = (np.asarray(strip).astype(np.int64) >> depth)[..., None].clip(0, 255)
        elif image.has_transparency_data:
            shown = strip.convert("RGBA")
            white = Image.new("RGBA", shown.size, "white")
            pixels[top : top + step] = np.asarray(Image.alpha_composite(white, shown).convert("RGB"))
        else:
            # "RGB" to "RGB" would be one more copy
            pixels[top : top + step] = np.asarray(strip if strip.mode == "RGB" else strip.convert("RGB"))
    return pixels


def _depth(image: Image.Image) -> int | None:
    """Return by how many bits a deep grey image is to be shifted to eight, or None for any other image."""
    if image.mode.startswith("I;16"):
        return 8
    if image.mode == "I":  # 32 bits declared, of which files use 8, 16 or all
        used = int(np.max(image.getextrema()))
        return 0 if used < 256 else 8 if used < 65536 else 24
    return None


def _upright(pixels: RGBArray, orientation: int) -> RGBArray:
    """Undo an EXIF orientation (1 to 8)."""
    if orientation in (5, 6, 7, 8):
        pixels = pixels.transpose(1, 0, 2)
    if orientation in (3, 4, 7, 8):
        pixels = pixels[::-1]
    if orientation in (2, 3, 6, 7):
        pixels = pixels[:, ::-1]
    return np.ascontiguousarray(pixels)


def _raw_header(raw: Any, path: Path, with_names: bool, with_gps: bool) -> Header:
    sizes = raw.sizes
    width, height = int(sizes.width), int(sizes.height)
    if sizes.flip in (5, 6):
        width, height = height, width
    return Header(width, height, _raw_metadata(raw, path, with_names, with_gps))


def _raw_metadata(raw: Any, path: Path, with_names: bool, with_gps: bool) -> Metadata:
    """Read the EXIF of a raw file: its own where it is built like a TIFF, else its preview's, else LibRaw's word."""
    import rawpy
    from PIL import Image

    found = Metadata(raw=True)
    start = path.read_bytes()[:_RAW_EXIF_BYTES]
    if start[:2] in (b"II", b"MM"):  # some makers write another number where a TIFF has 42
        holder = Image.new("L", (1, 1))
        holder.info["exif"] = (b"II*\0" if start[:2] == b"II" else b"MM\0*") + start[4:]
        found = read_metadata(holder, with_names=with_names, with_gps=with_gps, raw=True)
    if found.focal_mm is None:
        try:
            preview = raw.extract_thumb()
            if preview.format == rawpy.ThumbFormat.JPEG:
                with Image.open(io.BytesIO(preview.data), formats=("JPEG",)) as image:
                    found = read_metadata(image, with_names=with_names, with_gps=with_gps, raw=True)
        except Exception:  # a raw file need not have a preview, nor the preview any EXIF
            pass
    focal_mm = float(getattr(getattr(raw, "other", None), "focal_length", 0.0))
    return found if found.focal_mm is not None or not focal_mm > 0.5 else replace(found, focal_mm=focal_mm)


def _raw_pixels(raw: Any, path: Path, long_side_px: int | None) -> RGBArray:
    width, height = int(raw.sizes.width), int(raw.sizes.height)
    half = long_side_px is not None and max(width, height) // 2 >= long_side_px
    # LibRaw holds the sensor's values (2 bytes), four 16-bit colours and our three bytes at once.
    needed = width * height * (2 + (8 + 3) / (4 if half else 1))
    if needed > MEMORY_BUDGET_BYTES:
        raise PhotoError(f"{path}: {width} x {height} raw pixels would take {needed / 1e9:.1f} GB to decode")
    return np.ascontiguousarray(raw.postprocess(half_size=half, use_camera_wb=True))
