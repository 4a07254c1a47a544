"""Pictures that are not one whole photo: collages and screenshots, told from photos with plain skies and walls."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from proxemetry.arrays import RGBArray
from proxemetry.camera.choice import PictureLines, choose_camera
from proxemetry.camera.focal import FocalRequest
from proxemetry.camera.layout import layout_of
from proxemetry.camera.sources import Doubt
from proxemetry.people import People
from proxemetry.people.skeleton import COCO_17
from proxemetry.photo import Photo
from proxemetry.photo.metadata import Metadata


def texture(height: int, width: int, seed: int = 0) -> RGBArray:
    """Return coarse random blocks, as busy as a street."""
    blocks = np.random.default_rng(seed).integers(0, 256, (-(-height // 24), -(-width // 24), 3), dtype=np.uint8)
    return np.ascontiguousarray(blocks.repeat(24, axis=0).repeat(24, axis=1)[:height, :width])


def collage(rows: int, columns: int, gap: int, grey: int) -> RGBArray:
    height, width = rows * 200 + (rows - 1) * gap, columns * 260 + (columns - 1) * gap
    page = np.full((height, width, 3), grey, np.uint8)
    for row in range(rows):
        for column in range(columns):
            top, left = row * (200 + gap), column * (260 + gap)
            page[top : top + 200, left : left + 260] = texture(200, 260, 10 * row + column)
    return page


@settings(deadline=None, max_examples=20)
@given(st.integers(1, 2), st.integers(1, 3), st.integers(8, 20), st.sampled_from([0, 128, 255]))
def test_a_collage_has_the_gaps_that_it_was_laid_out_with(rows: int, columns: int, gap: int, grey: int) -> None:
    found = layout_of(collage(rows, columns, gap, grey))
    assert found.gaps == rows - 1 + columns - 1
    assert layout_of(np.ascontiguousarray(collage(rows, columns, gap, grey).swapaxes(0, 1))).gaps == found.gaps


@settings(deadline=None, max_examples=20)
@given(st.integers(100, 400), st.integers(100, 400), st.booleans())
def test_a_screenshot_s_photo_is_measured(above: int, below: int, text: bool) -> None:
    screen = np.full((above + 300 + below, 400, 3), 20, np.uint8)
    screen[above : above + 300] = texture(300, 400)
    if text:
        screen[above // 2 : above // 2 + 12, 20:120:3] = 255
    found = layout_of(screen)
    assert found.gaps == 0 and found.part[0] == 1
    assert found.part[1] == pytest.approx(300 / len(screen), abs=0.02)


def test_a_plain_sky_or_wall_is_no_bar() -> None:
    sky = texture(400, 600)
    sky[:180] = 225  # a grey sky down to a level horizon
    assert layout_of(sky).part == (1, 1)
    wall = np.full((400, 600, 3), 235, np.uint8)
    wall[120:400, 220:380] = texture(280, 160)  # a person before a white wall, cut by the lower edge
    assert layout_of(wall).part == (1, 1) and layout_of(wall).gaps == 0
    studio = np.full((400, 600, 3), 250, np.uint8)
    studio[100:300, 250:350] = texture(200, 100)  # a person before white paper that runs along the floor
    assert layout_of(studio).part == (1, 1)
    winter = texture(400, 600)
    winter[:120], winter[280:] = 215, 245  # sky and snow, a forest between them
    assert layout_of(winter).part == (1, 1)
    doorway = texture(400, 600)
    doorway[:350, 290:310] = 40  # a post that does not reach the lower edge
    assert layout_of(doorway).gaps == 0


@pytest.mark.parametrize("pixels", [np.zeros((1, 1, 3)), np.zeros((5, 900, 3)), np.full((480, 640, 3), 255)])
def test_tiny_and_empty_pictures_are_no_collages(pixels: RGBArray) -> None:
    assert layout_of(pixels.astype(np.uint8)).flags == ()


def test_the_camera_s_doubts_name_it() -> None:
    nobody = People.none(COCO_17)
    page = collage(2, 2, 12, 255)

    def doubts(pixels: RGBArray, metadata: Metadata | None = None) -> list[Doubt]:
        photo = Photo.from_array(pixels, metadata=metadata)
        estimate = choose_camera(photo, nobody, FocalRequest(), None, PictureLines(photo, nobody))
        return [flag.doubt for flag in estimate.flags]

    assert doubts(page) == [Doubt.PROJECTION, Doubt.ASSUMED]
    assert Doubt.PROJECTION not in doubts(page, Metadata(model="X100", focal_35mm=35.0))
    screen = np.full((900, 400, 3), 20, np.uint8)
    screen[300:600] = texture(300, 400)
    assert doubts(screen) == [Doubt.CROPPED, Doubt.ASSUMED]
    assert doubts(texture(480, 640)) == [Doubt.ASSUMED]
