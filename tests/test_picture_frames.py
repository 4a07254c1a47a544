"""Closed rectangles of straight edges, and who is inside one."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from proxemetry.arrays import FloatArray, RGBArray
from proxemetry.camera.choice import PictureLines
from proxemetry.camera.lines.picture_frames import _CLOSED, closed_rectangles, in_frames
from proxemetry.camera.lines.segments import Detected, detected_in
from proxemetry.errors import KeypointsError
from proxemetry.measure import measure
from proxemetry.people import People
from proxemetry.people.doubts import PersonDoubt, doubts_of, in_words
from proxemetry.people.rival import Rival
from proxemetry.people.skeleton import COCO_17
from proxemetry.photo import Photo
from proxemetry.scene_json import people_from_dict, people_to_dict
from proxemetry.settings import Settings

SIZE = (640, 480)
FRAME = (200.0, 100.0, 300.0, 240.0)
INSIDE = np.array([[215.0, 120.0, 285.0, 239.0]])


def sides(frame: tuple[float, ...], lean: float = 0.0) -> FloatArray:
    """Return the four sides as segments: top, bottom, left, right; leaning ones meet at the corners all the same."""
    x0, y0, x1, y1 = frame
    off = lean * (y1 - y0)
    return np.array([[x0, y0, x1, y0], [x0 + off, y1, x1 + off, y1], [x0, y0, x0 + off, y1], [x1 + off, y1, x1, y0]])


def detected(segments: FloatArray, to_photo: float = 1.0) -> Detected:
    return Detected(segments, SIZE, np.ones(4), np.full(4, to_photo))


@settings(max_examples=40, deadline=None)
@given(
    st.floats(5, 300), st.floats(5, 200), st.floats(40, 300), st.floats(40, 250), st.floats(-0.2, 0.2),
    st.integers(0, 3), st.integers(0, 2**32 - 1),
)  # fmt: skip
def test_four_sides_are_a_frame_and_three_are_none(
    x0: float, y0: float, width: float, height: float, lean: float, left_out: int, seed: int
) -> None:
    segments = sides((x0, y0, x0 + width, y0 + height), lean)
    if (
        (segments[:, ::2] < 2).any()
        or (segments[:, ::2] > SIZE[0] - 2).any()
        or (segments[:, 1::2] > SIZE[1] - 2).any()
    ):
        return  # a corner is outside of the picture
    order = np.random.default_rng(seed).permutation(4)
    turned = segments[order][:, [2, 3, 0, 1]]  # neither the order nor the direction of segments matters
    inside = closed_rectangles(turned, SIZE)
    area = width * height
    assert len(inside) == (area < 0.5 * SIZE[0] * SIZE[1] and width > abs(lean) * height)
    for found in inside:
        off = lean * height
        exact = [x0 + max(off, 0), y0, x0 + width + min(off, 0), y0 + height]
        np.testing.assert_allclose(found, exact, atol=1e-6)
    assert not len(closed_rectangles(np.delete(segments, left_out, axis=0), SIZE))


@settings(max_examples=30, deadline=None)
@given(st.floats(-12, 12), st.floats(60, 200), st.floats(60, 200))
def test_a_picture_that_hangs_askew_is_a_frame(turn_deg: float, width: float, height: float) -> None:
    turn = np.deg2rad(turn_deg)
    turned = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])
    half = np.array([width, height]) / 2
    corners = np.array([320.0, 240.0]) + half * [[-1, -1], [1, -1], [1, 1], [-1, 1]] @ turned.T
    segments = np.concatenate([corners, np.roll(corners, -1, axis=0)], axis=1)
    (found,) = closed_rectangles(segments, SIZE)
    (left_top, right_top, right_bottom, left_bottom) = corners
    exact = [max(left_top[0], left_bottom[0]), max(left_top[1], right_top[1])]
    exact += [min(right_top[0], right_bottom[0]), min(left_bottom[1], right_bottom[1])]
    np.testing.assert_allclose(found, exact, atol=1e-6)


@pytest.mark.parametrize("side", range(4))
def test_pieces_of_a_side_count_together_as_far_as_they_cover_it(side: int) -> None:
    whole = sides(FRAME)
    start, end = whole[side, :2], whole[side, 2:]
    rest = np.delete(whole, side, axis=0)
    for covered, framed in ((_CLOSED + 0.06, True), (_CLOSED - 0.06, False)):
        first, second = start + 0.3 * (end - start), start + (1.3 - covered) * (end - start)
        pieces = np.array([[*start, *first], [*second, *end]])
        assert bool(len(closed_rectangles(np.concatenate([rest, pieces]), SIZE))) is framed
    # the same piece twice covers no more
    half = np.array([[*start, *(start + end) / 2]])
    assert not len(closed_rectangles(np.concatenate([rest, half, half + 0.5]), SIZE))


@pytest.mark.parametrize("side", range(4))
@pytest.mark.parametrize(("before", "behind"), [(0.5, 0.5), (0.5, 0.0), (0.0, 0.5)])
def test_an_edge_that_goes_on_beyond_a_corner_is_a_walls(side: int, before: float, behind: float) -> None:
    whole = sides(FRAME)
    rest, (start, end) = np.delete(whole, side, axis=0), (whole[side, :2], whole[side, 2:])
    run = end - start
    for beyond, framed in (((0.0, 0.0), True), ((before, behind), False)):
        # a tenth is missing: what goes on takes the rest
        first, second = start + 0.4 * run, start + 0.5 * run
        pieces = np.array([[*(start - beyond[0] * run), *first], [*second, *(end + beyond[1] * run)]])
        assert bool(len(closed_rectangles(np.concatenate([rest, pieces]), SIZE))) is framed


def test_what_stands_on_a_corner_is_no_frame() -> None:
    diamond = np.array([[320.0, 140.0], [420.0, 240.0], [320.0, 340.0], [220.0, 240.0]])
    steep = diamond[0] + (diamond - diamond[0]) @ np.array([[0.9, -0.44], [0.44, 0.9]])
    for corners in (diamond, steep):
        assert not len(closed_rectangles(np.concatenate([corners, np.roll(corners, -1, axis=0)], axis=1), SIZE))


def test_who_is_inside_is_framed_in_pixels_of_the_photo() -> None:
    found = detected(sides(FRAME), to_photo=5.0)
    out_below, beside = INSIDE + [0, 0, 0, 40], INSIDE + [200, 0, 200, 0]
    tiny = np.array([[240.0, 190.0, 250.0, 230.0]])
    unknown = np.full((1, 4), np.nan)
    boxes = 5.0 * np.concatenate([INSIDE, out_below, beside, tiny, unknown])
    assert in_frames(found, boxes).tolist() == [True, False, False, False, False]
    assert not in_frames(found, boxes[4:]).any() and in_frames(found, boxes[:0]).shape == (0,)
    assert not in_frames(detected(np.zeros((0, 4))), boxes).any()


def test_the_border_of_a_scan_is_no_frame() -> None:
    assert not len(closed_rectangles(sides((20.0, 20.0, 620.0, 460.0)), SIZE))
    for cut in (
        (0.0, 50.0, 300.0, 240.0),
        (50.0, 0.0, 300.0, 240.0),
        (400.0, 50.0, 640.0, 240.0),
        (50.0, 300.0, 300.0, 480.0),
    ):
        assert not len(closed_rectangles(sides(cut), SIZE))


def _pixels(frame: bool) -> RGBArray:
    pixels = np.full((480, 640, 3), 190, dtype=np.uint8)
    if frame:
        pixels[90:250, 190:310] = 40
        pixels[100:240, 200:300] = 150
    return pixels


def _people(**stated: object) -> People:
    y = np.array([0.02, 0, 0, 0.03, 0.03, 0.2, 0.2, 0.35, 0.35, 0.5, 0.5, 0.5, 0.5, 0.75, 0.75, 1, 1])
    x = 250 + 12.0 * (np.arange(17) % 2 - 0.5) * (np.arange(17) > 0)
    points = np.stack([x, 122 + 115 * y], axis=1)
    both = np.stack([points, points + (260.0, 60.0)])
    return People(COCO_17, both, np.full((2, 17), 0.8), **stated)  # type: ignore[arg-type]


@pytest.mark.parametrize("frame", [True, False])
def test_a_person_on_a_poster_is_measured_and_marked(frame: bool) -> None:
    scene = measure(_pixels(frame), pose=lambda _: _people(), focal_px=700)
    expected = (PersonDoubt.IN_PICTURE,) if frame else ()
    assert scene.doubts == (expected, ())
    assert scene.bodies.placed.all()
    without = measure(_pixels(frame), pose=lambda _: _people(), focal_px=700, settings=Settings(lines=False))
    assert without.doubts == ((), ())


def test_without_pixels_nobody_is_framed() -> None:
    lines = PictureLines(Photo("away.jpg", 640, 480, ""), _people())
    assert lines.people_in_frames() == ()
    assert detected_in(Photo("away.jpg", 640, 480, "")) is None


def test_what_is_framed_travels_with_people() -> None:
    people = _people(framed=[True, False])
    assert people[[1, 0]].framed == (False, True) and people[1].framed == (False,)
    assert people_from_dict(people_to_dict(people)).framed == (True, False)
    assert "framed" not in people_to_dict(replace(people, framed=()))
    assert doubts_of(people) == ((PersonDoubt.IN_PICTURE,), ())
    with pytest.raises(KeypointsError, match=r"people\.framed has 1 entries for 2 people"):
        _people(framed=[True])


def test_a_frame_is_not_named_after_what_else_is_seen() -> None:
    people = _people(framed=[True, True], rivals=[Rival("kite", 2.0), Rival("tv", 0.6, shows=True)])
    first, second = doubts_of(people)
    assert in_words(people, 0, first) == "may be another kind of thing (kite), may be on a screen or in a picture"
    assert in_words(people, 1, second) == "may be on a screen or in a picture (tv)"
