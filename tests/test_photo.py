"""A photo is upright RGB, whatever its format, its orientation tag and its pixel type."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from camera_files import ORIENTATION, exif_of, gradient
from PIL import Image, ImageOps

from proxemetry.errors import PhotoError
from proxemetry.photo import Photo

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
