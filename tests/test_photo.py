"""A photo is upright RGB, whatever its format, its orientation tag and its pixel type."""

from __future__ import annotations

import base64
import struct
import sys
from pathlib import Path

import numpy as np
import pytest
from PIL import Image, ImageOps

from proxemetry.errors import PhotoError
from proxemetry.photo import Photo
from synthetic.camera_files import ORIENTATION, exif_of, gradient

FORMATS = {"jpg": {"quality": 95, "subsampling": 0}, "png": {}, "tif": {}, "webp": {"lossless": True}}
TURNS = (1, 2, 3, 4, 5, 6, 7, 8)
#: What a file must hold so that a viewer who applies the orientation sees the upright picture.
INVERSE = {
    2: Image.Transpose.FLIP_LEFT_RIGHT, 3: Image.Transpose.ROTATE_180, 4: Image.Transpose.FLIP_TOP_BOTTOM,
    5: Image.Transpose.TRANSPOSE, 6: Image.Transpose.ROTATE_90, 7: Image.Transpose.TRANSVERSE,
    8: Image.Transpose.ROTATE_270,
}  # fmt: skip


@pytest.mark.parametrize("suffix", FORMATS)
@pytest.mark.parametrize("turn", TURNS)
def test_orientation_is_applied_once(suffix: str, turn: int, tmp_path: Path) -> None:
    upright = gradient(64, 48)
    stored = Image.fromarray(upright)
    if turn != 1:
        stored = stored.transpose(INVERSE[turn])
    path = tmp_path / f"photo.{suffix}"
    stored.save(path, exif=exif_of({ORIENTATION: turn}), **FORMATS[suffix])
    photo = Photo.open(path)
    assert (photo.width, photo.height) == (64, 48)
    pixels = photo.pixels()
    assert pixels.shape == (48, 64, 3) and not pixels.flags.writeable
    assert np.abs(pixels.astype(int) - upright).max() <= (12 if suffix == "jpg" else 0)
    with Image.open(path) as image:  # and a second reader agrees
        np.testing.assert_array_equal(pixels, np.asarray(ImageOps.exif_transpose(image).convert("RGB")))


@pytest.mark.parametrize("long_side", [1, 100, 200, 399, 400, 401, 800, 5000])
def test_reduced_decoding_keeps_at_least_what_was_asked_for(long_side: int, tmp_path: Path) -> None:
    path = tmp_path / "photo.jpg"
    Image.fromarray(gradient(800, 600)).save(path, quality=95, exif=exif_of({ORIENTATION: 6}))
    photo = Photo.open(path)
    pixels = photo.pixels(long_side)
    assert (photo.width, photo.height) == (600, 800)
    assert min(long_side, 800) <= pixels.shape[0] <= 800
    assert pixels.shape[0] / pixels.shape[1] == pytest.approx(800 / 600, rel=0.02)
    if long_side <= 100:
        assert pixels.shape[0] == 100  # an eighth, the decoder's smallest


def test_truncated_jpeg_is_an_error_and_not_a_grey_picture(tmp_path: Path) -> None:
    whole = tmp_path / "whole.jpg"
    Image.fromarray(np.random.default_rng(0).integers(0, 255, (300, 400, 3), dtype=np.uint8)).save(whole)
    cut = tmp_path / "cut.jpg"
    cut.write_bytes(whole.read_bytes()[: whole.stat().st_size // 2])
    for long_side in (None, 100):
        with pytest.raises(PhotoError, match=r"cut\.jpg.*truncated"):
            Photo.open(cut).pixels(long_side)


def reading(path: Path) -> np.ndarray:
    """Return the mean colour of a photo."""
    return Photo.open(path).pixels().reshape(-1, 3).mean(axis=0)


def test_pixel_types_become_rgb(tmp_path: Path) -> None:
    """Black, white and a grey of two thirds come out as such from whatever a file stores them in."""
    levels = np.array([0.0, 2 / 3, 1.0])
    expected = np.round(levels * 255)[None, :, None] * np.ones((2, 1, 3))
    grey8 = np.tile(np.round(levels * 255), (2, 1)).astype(np.uint8)
    grey16 = np.tile(np.round(levels * 65535), (2, 1)).astype(np.uint16)
    images = {
        "grey.png": Image.fromarray(grey8), "grey16.png": Image.fromarray(grey16),
        "grey16.tif": Image.fromarray(grey16),
        "deep.tif": Image.fromarray(grey16.astype(np.int32)), "palette.png": Image.fromarray(grey8).convert("P"),
        "alpha.png": Image.fromarray(grey8).convert("RGBA"), "cmyk.tif": Image.fromarray(grey8).convert("CMYK"),
        "one.bmp": Image.fromarray(grey8),
    }  # fmt: skip
    for name, image in images.items():
        image.save(tmp_path / name)
        np.testing.assert_allclose(Photo.open(tmp_path / name).pixels(), expected, atol=1, err_msg=name)


def test_colour_of_16_bits_keeps_its_upper_8(tmp_path: Path) -> None:
    import cv2

    deep = (gradient(60, 40).astype(np.uint16) << 8) | 0x55
    assert cv2.imwrite(str(tmp_path / "deep.png"), deep[..., ::-1])
    np.testing.assert_array_equal(Photo.open(tmp_path / "deep.png").pixels(), gradient(60, 40))


def test_press_files_are_converted(tmp_path: Path) -> None:
    path = tmp_path / "press.jpg"
    Image.new("CMYK", (64, 48), (0, 255, 255, 0)).save(path, quality=95)  # full magenta and yellow are red
    np.testing.assert_allclose(reading(path), (255, 0, 0), atol=6)


def test_what_shines_through_is_white(tmp_path: Path) -> None:
    clear = np.zeros((10, 10, 4), dtype=np.uint8)
    clear[..., 0], clear[:5, :, 3] = 200, 255
    Image.fromarray(clear).save(tmp_path / "cut_out.png")
    pixels = Photo.open(tmp_path / "cut_out.png").pixels()
    assert (pixels[:5] == (200, 0, 0)).all() and (pixels[5:] == 255).all()


def test_progressive_jpeg_and_wrong_ending(tmp_path: Path) -> None:
    path = tmp_path / "photo.png"
    Image.fromarray(gradient(64, 48)).save(path, "JPEG", progressive=True, quality=95)
    assert np.abs(Photo.open(path).pixels().astype(int) - gradient(64, 48)).max() <= 16


#: A HEIC file of 64 x 96 stored pixels with a rotation by its container, EXIF orientation 6 and a 26 mm equivalent:
#: red, green, blue and white quarters when upright. Nothing installed with this package can write one.
TURNED_HEIC = (
    "AAAAHGZ0eXBoZWljAAAAAG1pZjFoZWljbWlhZgAAAaFtZXRhAAAAAAAAACFoZGxyAAAAAAAAAABwaWN0AAAAAAAAAAAAAAAAAAAAADRpbG9j"
    "AAAAAERAAAIAAQAAAAABxQABAAAAAAAAAOoAAgAAAAACrwABAAAAAAAAAEIAAAA4aWluZgAAAAAAAgAAABVpbmZlAgAAAAABAABodmMxAAAA"
    "ABVpbmZlAgAAAQACAABFeGlmAAAAAA5waXRtAAAAAAABAAAA4GlwcnAAAADAaXBjbwAAAHhodmNDAQNwAAAAkAAAAAAAHvAA/P34+AAADwNg"
    "AAEAGEABDAH//wNwAAADAJAAAAMAAAMAHroCQGEAAQArQgEBA3AAAAMAkAAAAwAAAwAeoCCBhZbqSSmubgIaDAgAAAMAyAAAAwAIQGIAAQAH"
    "RAHBcrAiQAAAABNjb2xybmNseAABAA0ABoAAAAAUaXNwZQAAAAAAAABAAAAAYAAAABBwaXhpAAAAAAMICAgAAAAJaXJvdAMAAAAYaXBtYQAA"
    "AAAAAAABAAEFgQIDBIUAAAAaaXJlZgAAAAAAAAAOY2RzYwACAAEAAQAAATRtZGF0AAAA5igBrwngITl1X1/5lX//+mbX//ycx1nnn8/vjnf0"
    "+RN/7mvOqFEf/5yUQHsc93/KMSShBIIFlgWv5xtpKC6/Jq0dteQn04M+0ZbJvrXh2tdJ/u9/ew1lifZWGSsVzuIJD15OmLM5oGRAxvrFXUkF"
    "s6HMelptWwkpPMjUUUi6OgFec3z/73dYfuoF37ug5XKZQqQP11WMHmfX7Xscs5w4RgDvAbW/sKw3gsm+FKpOztTghD3qkQW9uhYekizclMkf"
    "y3dDazKl3a13sF4DHfhXm8zj6qWht7jAlTp8St5aKMhintcvPPt/AAAABkV4aWYAAE1NACoAAAAIAAIBEgADAAAAAQAGAACHaQAEAAAAAQAA"
    "ACYAAAAAAAGkBQADAAAAAQAaAAAAAAAA"
)


def test_heic_is_turned_once(tmp_path: Path) -> None:
    pytest.importorskip("pi_heif", reason="pi-heif is not installed")
    path = tmp_path / "photo.heic"
    path.write_bytes(base64.b64decode(TURNED_HEIC))
    photo = Photo.open(path)
    pixels = photo.pixels()
    assert (photo.width, photo.height) == (96, 64) and pixels.shape == (64, 96, 3)
    corners = pixels[[5, 5, -5, -5], [5, -5, 5, -5]]
    np.testing.assert_allclose(corners, [(255, 0, 0), (0, 255, 0), (0, 0, 255), (255, 255, 255)], atol=8)
    assert photo.metadata.focal_35mm == 26
    path.write_bytes(path.read_bytes()[:600])
    with pytest.raises(PhotoError, match=r"photo\.heic"):
        Photo.open(path).pixels()


def digital_negative(width: int, height: int) -> bytes:
    """Return a minimal DNG: a 2x2 RGGB mosaic of one grey, with a make and an Exif directory."""
    mosaic = np.full((height, width), 8000, dtype="<u2").tobytes()
    exif = b"".join(
        [
            struct.pack("<H", 2),
            struct.pack("<HHII", 0x920A, 5, 1, 4000),
            struct.pack("<HHIHH", 0xA405, 3, 1, 75, 0),
            bytes(4),
        ]
    )
    tags = [
        (254, 4, 1, 0), (256, 4, 1, width), (257, 4, 1, height), (258, 3, 1, 16), (259, 3, 1, 1), (262, 3, 1, 32803),
        (271, 2, 4, int.from_bytes(b"Acm\0", "little")), (272, 2, 4, int.from_bytes(b"Box\0", "little")),
        (273, 4, 1, 8192), (274, 3, 1, 1), (277, 3, 1, 1), (278, 4, 1, height), (279, 4, 1, len(mosaic)),
        (33421, 3, 2, 2 | 2 << 16), (33422, 1, 4, int.from_bytes(bytes([0, 1, 1, 2]), "little")),
        (34665, 4, 1, 3000), (50706, 1, 4, int.from_bytes(bytes([1, 4, 0, 0]), "little")),
        (50721, 10, 9, 5000), (50778, 3, 1, 21),
    ]  # fmt: skip
    directory = struct.pack("<H", len(tags)) + b"".join(struct.pack("<HHII", *tag) for tag in tags) + bytes(4)
    content = bytearray(8192)
    content[:8] = b"II*\0" + struct.pack("<I", 8)
    content[8 : 8 + len(directory)] = directory
    content[3000 : 3000 + len(exif)] = exif
    content[4000:4008] = struct.pack("<II", 50, 1)
    content[5000:5072] = b"".join(struct.pack("<ii", int(i % 4 == 0), 1) for i in range(9))
    return bytes(content) + mosaic


def test_raw(tmp_path: Path) -> None:
    pytest.importorskip("rawpy", reason="rawpy is not installed")
    path = tmp_path / "photo.dng"
    path.write_bytes(digital_negative(128, 96))
    photo = Photo.open(path)
    assert (photo.width, photo.height) == (128, 96)
    assert photo.pixels().shape == (96, 128, 3) and photo.pixels(64).shape == (48, 64, 3)
    assert (photo.metadata.focal_mm, photo.metadata.focal_35mm, photo.metadata.raw) == (50, 75, True)
    assert photo.metadata.make == "Acm"


def test_an_extra_that_is_not_installed_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for name, module, content in (
        ("a.heic", "pi_heif", b"\0\0\0\x18ftypheic" + bytes(50)),
        ("a.nef", "rawpy", bytes(50)),
    ):
        (tmp_path / name).write_bytes(content)
        monkeypatch.setitem(sys.modules, module, None)
        with pytest.raises(PhotoError, match=r"needs an extra: pip install 'proxemetry\[(heic|raw)\]'"):
            Photo.open(tmp_path / name)


def test_what_is_no_photo(tmp_path: Path) -> None:
    for path, said in ((tmp_path, "not a file"), (tmp_path / "none.jpg", "no such file")):
        with pytest.raises(PhotoError, match=said):
            Photo.open(path)
    Image.fromarray(np.zeros((4, 4), dtype=np.float32)).save(tmp_path / "float.tif")
    with pytest.raises(PhotoError, match="floating point"):
        Photo.open(tmp_path / "float.tif").pixels()
