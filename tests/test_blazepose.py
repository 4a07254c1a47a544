"""The embedded back end: squares of a photo map to pixels and back, and real photos are counted by hand labels."""

from __future__ import annotations

import importlib.util
import json
import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from proxemetry import weights
from proxemetry.errors import ModelError, SettingsError
from proxemetry.photo import Photo
from proxemetry.pose import PoseOptions, backend_named
from proxemetry.pose.blazepose.detectors import Boxes, merged, windows_near, windows_of
from proxemetry.pose.blazepose.duplicates import agree, are_same, without_duplicates
from proxemetry.pose.blazepose.landmarks import Candidate
from proxemetry.pose.blazepose.pruning import without_output
from proxemetry.pose.blazepose.regions import Picture, Region

SHARED = Path(__file__).resolve().parents[2] / "shared"
PHOTOS = SHARED / "data" / "photos"
lengths = st.floats(20, 400)
angles = st.floats(-math.pi, math.pi)


@given(x=lengths, y=lengths, size=lengths, angle=angles, u=st.floats(0, 1), v=st.floats(0, 1))
def test_a_point_goes_from_the_square_to_the_photo_and_back(x, y, size, angle, u, v):
    region = Region(x, y, size, angle)
    np.testing.assert_allclose(region.from_photo(region.to_photo(np.array([u, v]))), (u, v), atol=1e-9)


@given(x=lengths, y=lengths, radius=lengths, angle=angles)
def test_the_point_above_the_hips_is_straight_up_in_the_square(x, y, radius, angle):
    hips = np.array([x, y])
    above = hips + radius * np.array([math.sin(angle), -math.cos(angle)])
    region = Region.around(hips, above, 1.25)
    assert region.size == pytest.approx(2.5 * radius)
    np.testing.assert_allclose(region.from_photo(above), (0.5, 0.5 - 1 / 2.5), atol=1e-9)


def test_a_crop_samples_where_the_region_says():
    # Brightness is the position itself, so what a pixel shows says where it was taken.
    height, width = 120, 200
    y, x = np.mgrid[0.5:height, 0.5:width]
    picture = Picture(np.stack([x, y, 0 * x], axis=-1).astype(np.uint8))
    region = Region(100, 60, 64, 0.3)
    crop = picture.crop(region, 64).astype(float)
    for column, row in ((10, 10), (32, 40), (60, 5)):
        expected = region.to_photo(np.array([(column + 0.5) / 64, (row + 0.5) / 64])) - 0.5  # uint8 rounds down
        np.testing.assert_allclose(crop[row, column, :2], expected, atol=1.0)


@pytest.mark.parametrize("size", [64, 256, 1024])
def test_a_large_region_is_shrunk_without_moving(size):
    pixels = np.zeros((1200, 1200, 3), np.uint8)
    pixels[600:, :] = 200  # an edge through the middle stays in the middle at every level of the pyramid
    crop = Picture(pixels).crop(Region(600, 600, size), 64)
    assert crop[20, 32, 0] < 10 and crop[44, 32, 0] > 190
    assert abs(crop[:, 32, 0].astype(float).sum() / 200 - 32) < 0.6


@given(width=st.integers(1, 3000), height=st.integers(1, 3000), fraction=st.sampled_from([1.0, 0.5, 0.3, 0.2]))
def test_windows_cover_the_photo(width, height, fraction):
    windows = list(windows_of(width, height, fraction, 0.25))
    assert len(windows) <= 400
    for length, low, size in ((width, 0, 2), (height, 1, 3)):
        reached = 0
        for begin, end in sorted({(w[low], w[low] + w[size]) for w in windows}):
            assert begin <= reached, "a gap between windows"
            reached = max(reached, end)
        assert reached == length


def test_overlapping_boxes_become_their_weighted_mean():
    boxes = Boxes(
        np.array([[0.0, 0, 10, 10], [2, 0, 12, 10], [100, 100, 110, 110]]),
        np.zeros((3, 1, 2)),
        np.array([0.9, 0.3, 0.5]),
    )
    one, other = merged(boxes).boxes_px
    np.testing.assert_allclose(one, [0.5, 0, 10.5, 10])
    np.testing.assert_allclose(other, [100, 100, 110, 110])


def _standing(x: float, scale: float = 1.0) -> Candidate:
    """Somebody upright at x: head at 40, shoulders at 60, hips at 120, ankles at 220, and a silhouette to match."""
    points = np.full((33, 2), (x, 40.0))
    for joints, (aside, down) in (
        ((11, 12), (16, 60)), ((13, 14), (20, 90)), ((15, 16), (22, 115)), ((23, 24), (10, 120)),
        ((25, 26), (10, 170)), ((27, 28), (10, 220)),
    ):  # fmt: skip
        points[joints[0]], points[joints[1]] = (x + aside, down), (x - aside, down)
    points = (points - (x, 40)) * scale + (x, 40)
    region = Region(x, 40 + 90 * scale, 260 * scale)
    cells = region.to_photo((np.stack(np.meshgrid(np.arange(64), np.arange(64)), axis=-1) + 0.5) / 64)
    mask = ((np.abs(cells[..., 0] - x) < 24 * scale) & (np.abs(cells[..., 1] - region.y) < 100 * scale)).astype(float)
    ones = np.ones(33)
    return Candidate(points, ones, ones, ones, 1.0, np.zeros((33, 3)), mask, region, region)


def test_two_people_side_by_side_are_two_and_two_looks_at_one_are_one():
    assert not are_same(_standing(100), _standing(150))
    assert are_same(_standing(100), _standing(103))
    assert are_same(_standing(100), _standing(100, 0.5))  # half a person within a person
    assert agree(_standing(100), _standing(101)) and not agree(_standing(100), _standing(150))


def test_of_two_looks_the_better_stays_whatever_their_order():
    candidates = [_standing(100), _standing(150), _standing(102)]
    assert without_duplicates(candidates, np.array([0.6, 0.7, 0.9])) == [2, 1]
    assert without_duplicates(candidates[::-1], np.array([0.9, 0.7, 0.6])) == [0, 1]


def test_the_embedded_back_end_takes_no_argument():
    with pytest.raises(SettingsError, match="no argument"):
        backend_named("blazepose:x", PoseOptions(offline=True))


@given(
    st.integers(40, 1200), st.integers(40, 1200), st.floats(0, 1), st.floats(0, 1), st.integers(0, 60)
)  # fmt: skip
def test_windows_near_a_level_begin_there_and_stay_in_the_photo(width, height, low, span, most):
    levels = low * height, (low + span * (1 - low)) * height
    windows = windows_near(width, height, (0.3, 0.2), 0.25, levels, most)
    assert len(windows) <= most and len(set(windows)) == len(windows)
    for x, y, across, down in windows:
        assert x >= 0 and y >= 0 and x + across <= width and y + down <= height
    aside = [max(abs(y + down / 2 - sum(levels) / 2) - (levels[1] - levels[0]) / 2, 0.0) for _, y, _, down in windows]
    assert aside == sorted(aside)
    everywhere = windows_near(width, height, (0.3,), 0.25, levels, 10_000)
    covered = np.zeros((height, width), bool)
    for x, y, across, down in everywhere:
        covered[y : y + down, x : x + across] = True
    assert covered.all()


def test_a_network_that_is_none_or_lacks_the_output_is_refused(embedded):
    with pytest.raises(ModelError, match="no TFLite file"):
        without_output(b"nothing", 4)
    content = weights.verify("pose_landmark_full.tflite").path.read_bytes()
    with pytest.raises(ModelError, match="no output of 12345 elements"):
        without_output(content, 12345)


def test_a_quick_look_sees_what_a_whole_one_sees_but_no_silhouette(embedded):
    """The layers left out feed nothing but the silhouette: all other answers are the same numbers."""
    pixels = np.random.default_rng(3).integers(0, 256, (300, 300, 3), dtype=np.uint8)
    picture, region = Picture(pixels), Region(140, 150, 260)
    whole = embedded._landmarks.look(picture, region)
    quick = embedded._landmarks.look(picture, region, quick=True)
    assert whole.mask is not None and quick.mask is None
    for name in ("keypoints_px", "visibility", "presence", "peaks", "flag", "world_m"):
        assert np.allclose(getattr(whole, name), getattr(quick, name), atol=1e-5), name


@pytest.fixture(scope="module")
def embedded():
    try:
        weights.fetch(weights.EMBEDDED)
    except ModelError as error:
        pytest.skip(str(error))
    if not PHOTOS.is_dir():
        pytest.skip("the labelled photos are not beside this checkout")
    return backend_named("blazepose", PoseOptions(offline=True))


def test_the_labelled_people_are_found(embedded):
    """The promise, with the count of the published tool: 48 of 52 clear people and 6 of 27 hard, 1 double, 0 invented.

    One fewer may be found: another processor's rounding moves a look by a little, and an unsure person with it.
    """
    total = {"clear_found": 0, "hard_found": 0, "duplicates": 0, "false": 0}
    counter = _counter()
    for name, truth in json.loads((PHOTOS / "people.json").read_text())["images"].items():
        people = embedded.detect(Photo.open(PHOTOS / name))
        shoulders = people.part("Shoulder")
        results = [
            (tuple(h), tuple(s), 2 * float(np.hypot(*(s - t))))
            for h, s, t in zip(people.part("Head"), shoulders, people.part("Torso"), strict=True)
        ]
        _count(counter, results, truth, total)
    assert total["clear_found"] >= 47, total
    assert total["hard_found"] >= 5, total
    assert total["duplicates"] <= 2, total
    assert total["false"] == 0, total


def _counter():
    specification = importlib.util.spec_from_file_location("count_people", SHARED / "tools" / "count_people.py")
    assert specification and specification.loader
    module = importlib.util.module_from_spec(specification)
    specification.loader.exec_module(module)
    return module


def _count(counter, results, truth, total):
    labels = truth["people"]
    taken = counter.match(results, labels)
    for j in taken.values():
        total[f"{labels[j]['difficulty']}_found"] += 1
    for i, (head, shoulder, length) in enumerate(results):
        ignored = any(
            z[0] <= head[0] <= z[2] and z[1] <= head[1] <= z[3] and not length >= z[4] for z in truth["ignore"]
        )
        if i not in taken and not ignored:
            boxes = [label["box"] for label in labels]
            inside = any(b[0] <= shoulder[0] <= b[2] and b[1] <= shoulder[1] <= b[3] for b in boxes)
            total["duplicates" if inside else "false"] += 1


@pytest.mark.parametrize(
    ("photo", "box"),
    [
        ("COCO_val2014_000000000328.jpg", (10, 160, 130, 290)),  # a backpack on a bench
        ("raising_hand.jpg", (640, 100, 1280, 600)),  # a car, and a play tower behind it
        ("COCO_val2014_000000000257.jpg", (200, 0, 640, 290)),  # a monument with statues, and clouds
        ("COCO_val2014_000000000192.jpg", (0, 0, 640, 170)),  # a lawn
    ],
)
def test_nobody_in_a_part_without_people(embedded, photo, box):
    x0, y0, x1, y1 = box
    pixels = np.ascontiguousarray(Photo.open(PHOTOS / photo).pixels()[y0:y1, x0:x1])
    assert len(embedded.detect(Photo.from_array(pixels))) == 0


def test_a_teddy_bear_is_nobody(embedded):
    """Drawn: brown discs with ears, eyes and a snout, sitting."""
    import cv2

    pixels = np.full((480, 480, 3), (210, 205, 190), np.uint8)
    for centre, radius, colour in (
        ((240, 330), 110, (140, 90, 50)), ((240, 170), 80, (150, 98, 55)), ((175, 105), 30, (140, 90, 50)),
        ((305, 105), 30, (140, 90, 50)), ((240, 195), 32, (200, 160, 120)), ((210, 155), 8, (20, 15, 10)),
        ((270, 155), 8, (20, 15, 10)), ((240, 183), 9, (30, 20, 15)), ((140, 300), 42, (140, 90, 50)),
        ((340, 300), 42, (140, 90, 50)), ((165, 425), 48, (140, 90, 50)), ((315, 425), 48, (140, 90, 50)),
    ):  # fmt: skip
        cv2.circle(pixels, centre, radius, colour, -1, cv2.LINE_AA)
    assert len(embedded.detect(Photo.from_array(pixels))) == 0


def test_pupils_stand_where_eyes_are(embedded):
    """Three women look at the camera: eye distances in pixels agree with those of the face detector within 15 %."""
    people = embedded.detect(Photo.open(PHOTOS / "COCO_val2014_000000000536.jpg"))
    eyes = np.linalg.norm(people.joint("left_eye") - people.joint("right_eye"), axis=1)
    ears = np.linalg.norm(people.joint("left_ear") - people.joint("right_ear"), axis=1)
    assert len(people) == 3
    assert (eyes > 0.25 * ears).all() and (eyes < 0.75 * ears).all()  # 63 mm of about 140 mm, less where turned
