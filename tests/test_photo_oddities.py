"""What programs write where nobody looks: metadata in odd places, pages in odd order, pictures of odd size."""

from __future__ import annotations

import io
import struct
import zlib
from pathlib import Path

import numpy as np
import pytest
from PIL import Image, TiffImagePlugin
from PIL.TiffImagePlugin import ImageFileDirectory_v2
from test_photo import digital_negative
from test_photo_metadata import iim, xmp_of

from proxemetry.errors import PhotoError
from proxemetry.photo import EXTENSIONS, Photo, formats
from proxemetry.photo.raw import raw_header
from synthetic.camera_files import FOCAL, FOCAL_35, MAKE, exif_of, gradient, write

EXIF = exif_of({FOCAL: (50, 1), FOCAL_35: 75}).tobytes()[6:]


def chunk(kind: bytes, content: bytes) -> bytes:
    return struct.pack(">I", len(content)) + kind + content + struct.pack(">I", zlib.crc32(kind + content))


def png_with_tail(path: Path, *chunks: bytes) -> Path:
    """Write a PNG whose metadata stand behind the pixels."""
    buffer = io.BytesIO()
    Image.fromarray(gradient(60, 40)).save(buffer, "PNG")
    content = buffer.getvalue()
    end = content.index(b"IEND") - 4
    path.write_bytes(content[:end] + b"".join(chunks) + content[end:])
    return path


def test_what_stands_behind_a_pngs_pixels(tmp_path: Path) -> None:
    packet = xmp_of("<photoshop:City>Oulu</photoshop:City>")
    text = b"XML:com.adobe.xmp\0\0\0\0\0" + packet
    photo = Photo.open(png_with_tail(tmp_path / "a.png", chunk(b"eXIf", EXIF), chunk(b"iTXt", text)))
    assert (photo.metadata.focal_mm, photo.metadata.focal_35mm, photo.metadata.city) == (50, 75, "Oulu")
    packed = b"XML:com.adobe.xmp\0\1\0\0\0" + zlib.compress(packet)
    assert Photo.open(png_with_tail(tmp_path / "b.png", chunk(b"iTXt", packed))).metadata.city == "Oulu"
    assert photo.pixels().shape == (40, 60, 3)


def test_what_stands_in_front_comes_first_and_an_orientation_behind_turns_nothing(tmp_path: Path) -> None:
    buffer = io.BytesIO()
    Image.fromarray(gradient(60, 40)).save(buffer, "PNG", exif=exif_of({FOCAL_35: 28, MAKE: "Acme"}))
    late = exif_of({FOCAL_35: 75, 0x0112: 6}).tobytes()[6:]
    content = buffer.getvalue()
    end = content.index(b"IEND") - 4
    path = tmp_path / "a.png"
    path.write_bytes(content[:end] + chunk(b"eXIf", late) + content[end:])
    photo = Photo.open(path)
    assert photo.metadata.focal_35mm == 28 and (photo.width, photo.height) == (60, 40)


@pytest.mark.parametrize("size", [0xFFFFFFFF, 0x7FFFFFFF, 10**6])
def test_hostile_chunks_are_not_there(size: int, tmp_path: Path) -> None:
    path = png_with_tail(tmp_path / "a.png", struct.pack(">I", size) + b"eXIf" + b"\xff" * 30)
    assert Photo.open(path).metadata.focal_mm is None


BLOCK = iim((2, 55, "19870614"), (2, 101, "Finland"), (2, 90, "Oulu"), (2, 115, "Archive X"))


@pytest.mark.parametrize("turned", [False, True])
def test_iptc_of_a_tiff_declared_as_integers(turned: bool, tmp_path: Path) -> None:
    block = BLOCK + b"\0" * (-len(BLOCK) % 4)
    numbers = struct.unpack(f"{'>' if turned else '<'}{len(block) // 4}I", block)
    directory = ImageFileDirectory_v2()
    directory[65000] = numbers
    directory.tagtype[65000] = 4
    path = tmp_path / "a.tif"
    Image.new("L", (60, 40)).save(path, tiffinfo=directory)
    path.write_bytes(path.read_bytes().replace(struct.pack("<HH", 65000, 4), struct.pack("<HH", 33723, 4)))
    metadata = Photo.open(path).metadata
    assert (metadata.date, metadata.country, metadata.city, metadata.source) == (
        "1987-06-14", "Finland", "Oulu", "Archive X"
    )  # fmt: skip


@pytest.mark.parametrize("codec", ["utf-8", "utf-8-sig", "utf-16", "utf-16-le", "utf-16-be", "utf-32"])
@pytest.mark.parametrize("declared", [False, True])
def test_xmp_in_every_encoding(codec: str, declared: bool, tmp_path: Path) -> None:
    text = xmp_of("<photoshop:City>Jyväskylä</photoshop:City>").decode()
    if declared:
        text = f'<?xml version="1.0" encoding="{codec.removesuffix("-sig")}"?>{text}'
    path = tmp_path / "a.jpg"
    Image.new("L", (60, 40)).save(path, xmp=text.encode(codec))
    metadata = Photo.open(path).metadata
    assert metadata.city == "Jyväskylä" and not metadata.remarks


class RawWithPreview:
    """Stands for LibRaw's view of a raw file: no camera data of its own but a preview."""

    sizes = type("Sizes", (), {"width": 128, "height": 96, "flip": 0})()

    def __init__(self, focal_mm: float) -> None:
        preview = io.BytesIO()
        Image.new("L", (32, 24)).save(preview, "JPEG", exif=exif_of({FOCAL: (focal_mm, 1), FOCAL_35: 75}))
        self.preview = preview.getvalue()

    def extract_thumb(self) -> object:
        from rawpy import ThumbFormat

        return type("Thumbnail", (), {"format": ThumbFormat.JPEG, "data": self.preview})()


@pytest.mark.parametrize(("focal_mm", "expected"), [(50, 75), (35, None)])
def test_a_raws_equivalent_may_be_in_its_preview_alone(focal_mm: int, expected: int | None, tmp_path: Path) -> None:
    """But a preview of another lens's photo tells nothing."""
    pytest.importorskip("rawpy", reason="rawpy is not installed")
    path = tmp_path / "a.dng"
    path.write_bytes(digital_negative(128, 96).replace(struct.pack("<HHIHH", 0xA405, 3, 1, 75, 0), bytes(12)))
    metadata = raw_header(RawWithPreview(focal_mm), path, False, False).metadata
    assert (metadata.focal_mm, metadata.focal_35mm) == (50, expected)


def pages(path: Path, *sizes: tuple[int, int, int]) -> Path:
    """Write a TIFF of pages of these widths, heights and subfile types."""
    with TiffImagePlugin.AppendingTiffWriter(str(path), new=True) as file:
        for number, (width, height, kind) in enumerate(sizes):
            directory = ImageFileDirectory_v2()
            directory[254] = kind
            if number == 0:
                directory[271] = "Acme"
            Image.new("RGB", (width, height), (40 * number, 0, 0)).save(file, "TIFF", tiffinfo=directory)
            file.newFrame()
    return path


@pytest.mark.parametrize(
    ("sizes", "expected"),
    [
        ([(160, 107, 1), (3000, 2000, 0)], (3000, 2000)),  # the first says that it is a reduced copy
        ([(160, 107, 0), (3000, 2000, 0)], (3000, 2000)),  # it does not say so, but looks like one
        ([(3000, 2000, 0), (160, 107, 1)], (3000, 2000)),
        ([(600, 400, 0), (700, 466, 0)], (600, 400)),  # two scans
        ([(600, 400, 0), (3000, 3000, 0)], (600, 400)),
        ([(600, 400, 1)], (600, 400)),  # nothing better is there
    ],
)
def test_a_reduced_first_page_is_not_the_photo(
    sizes: list[tuple[int, int, int]], expected: tuple[int, int], tmp_path: Path
) -> None:
    photo = Photo.open(pages(tmp_path / "a.tif", *sizes))
    assert (photo.width, photo.height) == expected
    assert photo.pixels().shape == (expected[1], expected[0], 3)
    assert photo.metadata.make == "Acme"  # the camera is named on the first page


def test_jpeg_2000_is_read_and_reduced(tmp_path: Path) -> None:
    path = tmp_path / "a.jp2"
    Image.fromarray(gradient(400, 300)).save(path, quality_mode="rates", quality_layers=[20])
    content = path.read_bytes()
    at = content.index(b"jp2c") - 4
    box = b"uuid" + b"JpgTiffExif->JP2" + EXIF
    path.write_bytes(content[:at] + struct.pack(">I", len(box) + 4) + box + content[at:])
    photo = Photo.open(path)
    assert (photo.width, photo.height, photo.metadata.focal_35mm) == (400, 300, 75)
    assert photo.pixels().shape == (300, 400, 3)
    assert photo.pixels(100).shape == (75, 100, 3)
    np.testing.assert_allclose(photo.pixels(100)[::20, ::20], gradient(100, 75)[::20, ::20], atol=25)
    assert photo.pixels(3).shape[1] >= 3  # no more halvings than the file has


def test_a_picture_larger_than_the_librarys_limit_is_read_at_half_its_size(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = write(tmp_path / "a.jpg", 1600, 1200, {FOCAL_35: 23})
    monkeypatch.setattr(Image, "MAX_IMAGE_PIXELS", 200_000)
    monkeypatch.setattr(formats, "MEMORY_BUDGET_BYTES", 4 * 800 * 600)
    photo = Photo.open(path)
    assert (photo.width, photo.height, photo.metadata.focal_35mm) == (1600, 1200, 23)
    assert photo.pixels().shape == photo.pixels(1500).shape == (600, 800, 3)
    assert Photo.open(path).pixels(200).shape == (150, 200, 3)
    assert Image.MAX_IMAGE_PIXELS == 200_000  # other users of the library keep theirs
    grey = tmp_path / "a.png"
    Image.new("L", (1600, 1200)).save(grey)
    with pytest.raises(PhotoError, match="make it smaller first"):
        Photo.open(grey).pixels()


@pytest.mark.parametrize("ending", [".jfif", ".jpe", ".pjpeg", ".jpg_large", ".jp2"])
def test_endings(ending: str) -> None:
    assert ending in EXTENSIONS
