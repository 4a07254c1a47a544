"""The file formats a photo comes in: opening a header safely, and decoding to upright RGB within a memory budget."""

from __future__ import annotations

import math
import threading
import warnings
from collections.abc import Generator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..arrays import RGBArray
from ..errors import PhotoError
from ..files import open_file, reason_of
from .embedded import embedded
from .metadata import Metadata, orientation_of, read_metadata
from .raw import MEMORY_BUDGET_BYTES, RAW_EXTENSIONS, Header, raw_header, raw_pixels

if TYPE_CHECKING:
    from PIL import Image


#: Of a JPEG: two bits for a block of 64 pixels in one colour, one of them spared by a progressive file's runs.
_FEWEST_BYTES_PER_PX = 1 / 8 / 64 * 0.8
_HEIC_BRANDS = (b"heic", b"heix", b"heim", b"heis", b"hevc", b"hevx", b"mif1", b"msf1")
#: Pillow reads 40 formats, one of them by running another program; these are the ones photographs come in.
_PILLOW_FORMATS = ("JPEG", "PNG", "TIFF", "WEBP", "AVIF", "GIF", "BMP", "JPEG2000")
#: Converted at once: little enough to stay in a processor's cache on the way.
_STRIP_PX = 50_000


def read_header(path: Path, *, with_names: bool = False, with_gps: bool = False) -> Header:
    """Return a file's upright size and metadata; raises PhotoError where it is no photo."""
    with _opened(path) as source:
        if not _is_image(source):
            return raw_header(source, path, with_names, with_gps)
        metadata = _metadata(source, path, with_names, with_gps)
        width, height = source.size
        if orientation_of(source) >= 5:
            width, height = height, width
        return Header(width, height, metadata)


def _metadata(source: Any, path: Path, with_names: bool, with_gps: bool) -> Metadata:
    """Return the file's metadata, also where the image library does not look; the page in front of the photo's too."""
    found = read_metadata(source, with_names=with_names, with_gps=with_gps)
    if source.format in ("PNG", "JPEG2000"):
        from PIL import Image

        holder = Image.new("L", (1, 1))
        holder.info.update(embedded(path))
        found = found.completed_by(read_metadata(holder, with_names=with_names, with_gps=with_gps))
    elif source.format == "TIFF" and source.tell():
        page = source.tell()
        source.seek(0)
        found = found.completed_by(read_metadata(source, with_names=with_names, with_gps=with_gps))
        source.seek(page)
    return found


def decode(path: Path, long_side_px: int | None = None) -> RGBArray:
    """Return upright RGB pixels of shape (H, W, 3), reduced where the answer still has `long_side_px` or more.

    A JPEG or JPEG 2000 too large for the memory budget is reduced as far as that takes, whatever is asked for. Raises
    PhotoError where decoding fails, stops before the end, or would take more than the memory budget.
    """
    with _opened(path) as source:
        if not _is_image(source):
            return raw_pixels(source, path, long_side_px)
        # Before anything is decoded: afterwards nothing may show any more how the file was turned.
        orientation = orientation_of(source)
        _check_length(source, path)
        _reduce(source, long_side_px)
        _check_memory(source, path)
        source.load()
        return _upright(_rgb(source, path), orientation)


def _is_image(source: Any) -> bool:
    from PIL import Image  # here, as wherever it is needed: what only reads results needs no image library

    return isinstance(source, Image.Image)


@contextmanager
def _opened(path: Path) -> Generator[Any]:
    """Open a file as a Pillow image or a rawpy object; whatever a decoder throws leaves as a PhotoError."""
    try:
        with open_file(path) as file:
            start = file.read(12)
    except (OSError, ValueError) as error:
        raise PhotoError(f"{path}: {reason_of(error)}") from error
    try:
        if not start:
            raise PhotoError(f"{path}: the file is empty")
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # the decoders' warnings are for their developers
            with _source(path, start) as source:
                yield source
    except (PhotoError, MemoryError):
        raise
    except Exception as error:  # the decoders meet hostile bytes here and raise nearly anything
        reason = error.args[0] if error.args else ""
        text = reason.decode("utf-8", "replace") if isinstance(reason, bytes) else str(error)
        text = " ".join(text.split())[:150] or type(error).__name__
        if "cannot identify image file" in text:
            text = "no image format that is known"
        elif "image file is truncated" in text:
            text = "truncated: the file ends before the picture does"
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
    with _any_size():
        image = Image.open(path, formats=formats)
    if image.format == "TIFF":
        image.seek(_page(image))
    return image


_SIZE_LOCK = threading.Lock()


@contextmanager
def _any_size() -> Generator[None]:
    """Let the image library open headers of any size: how large a decoded picture may be is decided here."""
    from PIL import Image

    with _SIZE_LOCK:
        limit = Image.MAX_IMAGE_PIXELS
        Image.MAX_IMAGE_PIXELS = None
        try:
            yield
        finally:
            Image.MAX_IMAGE_PIXELS = limit


#: Tag of a TIFF's page: bit 0 marks a reduced copy of another (TIFF 6.0, NewSubfileType).
_SUBFILE_TYPE, _REDUCED = 254, 1
#: So much larger is a page of the same shape of which an unmarked first one is the thumbnail.
_THUMBNAIL = 3
_MOST_PAGES = 50


def _page(image: Any) -> int:
    """Return which page of a TIFF is the photo: the first, unless it is a reduced copy of a larger one."""
    if getattr(image, "n_frames", 1) < 2:
        return 0
    pages: list[tuple[int, int, bool]] = []
    for number in range(min(image.n_frames, _MOST_PAGES)):
        image.seek(number)
        kind = image.tag_v2.get(_SUBFILE_TYPE, 0)
        pages.append((*image.size, isinstance(kind, int) and bool(kind & _REDUCED)))
    image.seek(0)
    width, height, is_reduced = pages[0]
    least = 1 if is_reduced else _THUMBNAIL
    larger = [
        (w * h, -number)
        for number, (w, h, reduced) in enumerate(pages)
        if not reduced and w > least * width and abs(math.log(w / h * height / width)) < (0.5 if is_reduced else 0.03)
    ]
    return -max(larger)[1] if larger else 0


def _reduce(source: Any, long_side_px: int | None) -> None:
    """Have the decoder make the picture smaller: as far as is asked for, and as far as the memory budget takes."""
    longest = max(source.size)
    wanted = longest if long_side_px is None else min(long_side_px, longest)
    fitting = next((n for n in range(4) if _needed(source, 2**n) <= MEMORY_BUDGET_BYTES), 0)
    if source.format == "JPEG2000":
        halvings = min(max(fitting, int(math.log2(longest / wanted))), _most_halvings(source))
        # The image library rounds to the nearest pixel where the decoder rounds up; where they differ it fails.
        while halvings and any(side % 2**halvings and side % 2**halvings < 2 ** (halvings - 1) for side in source.size):
            halvings -= 1
        source.reduce = halvings
        return
    wanted = min(wanted, -(-longest // 2**fitting))
    if wanted < longest:
        width, height = (-(-side * wanted // longest) for side in source.size)
        source.draft("RGB", (width, height))


def _most_halvings(source: Any) -> int:
    """Return how often a JPEG 2000 picture may be halved, by its coding style (ISO 15444-1, A.6.1)."""
    file = source.fp
    at = file.tell()
    file.seek(0)
    start = file.read(65536)
    file.seek(at)
    marker = start.find(b"\xff\x52", start.find(b"\xff\x4f\xff\x51"))
    return start[marker + 9] if 0 <= marker < len(start) - 9 else 0


def _check_memory(image: Image.Image, path: Path) -> None:
    """Refuse what would not fit: the decoder's pixels, our three bytes, a progressive JPEG's coefficients."""
    needed = _needed(image, 1)
    if needed > MEMORY_BUDGET_BYTES:
        raise PhotoError(
            f"{path}: {image.width} x {image.height} pixels would take {needed / 1e6:,.0f} MB to decode, more than "
            f"{MEMORY_BUDGET_BYTES / 1e6:,.0f} MB; make it smaller first"
        )


def _check_length(image: Image.Image, path: Path) -> None:
    """Refuse a JPEG with fewer bytes than its pixels take when all are alike: the decoder would fill in grey."""
    width, height = image.size
    if image.format == "JPEG" and path.stat().st_size < _FEWEST_BYTES_PER_PX * width * height:
        raise PhotoError(
            f"{path}: not a photo that can be read (truncated: too few bytes for {width} x {height} pixels)"
        )


def _needed(image: Any, reduction: int) -> int:
    """Return the bytes that decoding takes with both sides made smaller by a factor, as the decoder is set now."""
    halved = 2 ** getattr(image, "_reduce", 0) * reduction
    per_pixel = 3 + (1 if image.mode in ("L", "P", "1") else 2 if image.mode.startswith("I;16") else 4)
    needed = per_pixel * image.width * image.height // halved**2
    if image.info.get("progressive"):
        full = getattr(image, "decoderconfig", (1, 0)) or (1, 0)
        needed += 6 * image.width * image.height * max(full[0], 1) ** 2
    return needed


def _rgb(image: Image.Image, path: Path) -> RGBArray:
    """Convert a decoded image strip by strip, so that it is never held twice; transparent parts become white."""
    from PIL import Image

    if image.mode == "F":
        raise PhotoError(f"{path}: floating point pixels have no defined white; save the photo with 8 or 16 bits")
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
