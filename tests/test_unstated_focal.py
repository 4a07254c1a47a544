"""Photos that nothing states the focal length of: what published photos, lines and people tell together."""

from __future__ import annotations

import math
import warnings
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from proxemetry import measure
from proxemetry.camera import Camera, Doubt, FocalSource
from proxemetry.camera.choice import PictureLines, choose_camera, with_gravity
from proxemetry.camera.focal import FocalRequest, estimate_camera
from proxemetry.camera.from_people import self_calibration
from proxemetry.camera.from_people.self_calibration import FocalPosterior
from proxemetry.camera.lines import gravity_from_lines
from proxemetry.camera.lines.segments import halved, segments_of, straight_segments, without_graphics
from proxemetry.camera.others import SameShoot
from proxemetry.camera.published import quantile_mm
from proxemetry.camera.unstated import _GRID, _information, _of_people, _posterior, without_statement
from proxemetry.errors import AssumedFocalWarning
from proxemetry.people import People
from proxemetry.people.skeleton import COCO_17
from proxemetry.photo import Photo
from proxemetry.photo.metadata import Metadata
from synthetic.line_scenes import exact_scene

WIDTH, HEIGHT = 640, 480
NOBODY = People.none(COCO_17)


def drawn(pitch_deg: float = 8.0, focal_px: float = 600.0, roll_deg: float = 0.0) -> Photo:
    """Return a picture of two walls at right angles, as white lines on black."""
    import cv2

    pixels = np.zeros((HEIGHT, WIDTH, 3), np.uint8)
    scene = exact_scene(pitch_deg, roll_deg, focal_px, WIDTH, HEIGHT, azimuths_deg=(35.0, 125.0), each=16)
    for u0, v0, u1, v1 in scene.segments_px.tolist():
        ends = [(round(16 * (u - 0.5)), round(16 * (v - 0.5))) for u, v in ((u0, v0), (u1, v1))]
        cv2.line(pixels, ends[0], ends[1], (255, 255, 255), 2, cv2.LINE_AA, shift=4)
    return Photo.from_array(pixels)


def blank() -> Photo:
    return Photo.from_array(np.zeros((HEIGHT, WIDTH, 3), np.uint8))


def equivalent_mm(f_px: float) -> float:
    return f_px / math.hypot(WIDTH, HEIGHT) * math.hypot(36, 24)


def test_quantiles_are_those_of_the_docs() -> None:
    assert [round(quantile_mm(share)) for share in (0.05, 0.25, 0.5, 0.75, 0.95)] == [19, 27, 37, 54, 101]


def test_what_the_file_states_and_is_unusable_stays_named_beside_the_assumption() -> None:
    metadata = Metadata(remarks=("35 mm equivalent 8 in the metadata is unusable",))
    estimate = choose_camera(replace(blank(), metadata=metadata), NOBODY, FocalRequest(), None, None)
    assert [(flag.doubt, flag.text) for flag in estimate.flags if flag.doubt is not Doubt.ASSUMED] == [
        (Doubt.METADATA, metadata.remarks[0])
    ]


def test_an_action_camera_whose_focal_length_is_assumed_is_still_a_fisheye() -> None:
    worn = replace(blank(), metadata=Metadata(make="GoPro", model="HERO4 Session"))
    estimate = choose_camera(worn, NOBODY, FocalRequest(), None, None)
    assert [flag.doubt for flag in estimate.flags] == [Doubt.LENS, Doubt.ASSUMED]


def test_a_suspected_panorama_is_assumed_and_nothing_denies_it() -> None:
    strip = Photo.from_array(np.zeros((200, 1000, 3), np.uint8))
    estimate = choose_camera(strip, NOBODY, FocalRequest(), None, None)
    assert estimate.is_assumed
    assert "no focal length in the photo, which may be a panorama" in [t.words for t in estimate.testimony]


def test_nothing_told_is_assumed_as_wide_as_published_photos_are() -> None:
    estimate = choose_camera(blank(), NOBODY, FocalRequest(), None, None)
    assert estimate.camera is not None and estimate.is_assumed
    assert estimate.camera.source.kind is FocalSource.ASSUMED_PRIOR
    assert [flag.doubt for flag in estimate.flags] == [Doubt.ASSUMED]
    assert 35 < equivalent_mm(estimate.camera.f_px) < 42
    low, high = (estimate.camera.f_px * math.exp(s * 1.645 * estimate.camera.focal_rel_sd) for s in (-1, 1))
    assert equivalent_mm(low) < 21 and equivalent_mm(high) > 85


def test_refusing_to_assume_leaves_no_camera_and_says_what_to_state() -> None:
    estimate = choose_camera(blank(), NOBODY, FocalRequest(assume=False), None, None)
    assert estimate.camera is None
    assert "--focal-35mm" in (estimate.reason or "")


def test_half_a_statement_is_not_made_whole_by_an_assumption() -> None:
    estimate = choose_camera(blank(), NOBODY, FocalRequest(focal_mm=50), None, None)
    assert estimate.camera is None and "sensor size" in (estimate.reason or "")


@pytest.mark.parametrize("assume", [True, False])
def test_lines_tell_the_focal_length(assume: bool) -> None:
    photo = drawn()
    estimate = choose_camera(photo, NOBODY, FocalRequest(assume=assume), None, PictureLines(photo, NOBODY))
    assert estimate.camera is not None and not estimate.is_assumed
    assert estimate.camera.source.kind is FocalSource.LINES
    assert estimate.camera.f_px == pytest.approx(600, rel=0.06)
    assert abs(math.log(estimate.camera.f_px / 600)) < 2 * estimate.camera.focal_rel_sd < 0.3
    assert [flag.doubt for flag in estimate.flags] == [Doubt.ESTIMATED]


def test_what_is_stated_is_not_looked_for() -> None:
    stated = FocalRequest(focal_px=900)
    photo = drawn()
    assert choose_camera(photo, NOBODY, stated, None, PictureLines(photo, NOBODY)) == estimate_camera(photo, stated)


def test_a_field_of_view_that_was_allowed_goes_before_the_assumption_and_after_the_lines() -> None:
    request = FocalRequest(assume_fov_deg=60)
    kinds = [
        estimate.camera.source.kind
        for photo in (blank(), drawn())
        if (estimate := choose_camera(photo, NOBODY, request, None, PictureLines(photo, NOBODY))).camera is not None
    ]
    assert kinds == [FocalSource.ASSUMED_FOV, FocalSource.LINES]


def test_lines_that_are_not_believed_change_little() -> None:
    """Segments in no order: the interval stays about as wide as without them."""
    rng = np.random.default_rng(3)
    middle, angle = rng.uniform(0, 480, (60, 2)), rng.uniform(0, math.pi, 60)
    half = 15 * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    photo = blank()
    without = without_statement(estimate_camera(photo), photo, NOBODY, None, True)
    with_lines = without_statement(
        estimate_camera(photo), photo, NOBODY, np.concatenate([middle - half, middle + half], axis=1), True
    )
    assert without.camera is not None and with_lines.camera is not None
    assert with_lines.camera.focal_rel_sd == pytest.approx(without.camera.focal_rel_sd, rel=0.1)
    assert with_lines.is_assumed


def test_gravity_of_a_drawn_picture_becomes_a_mount_without_height() -> None:
    photo = drawn(pitch_deg=12.0, roll_deg=3.0)
    lines = PictureLines(photo, NOBODY)
    estimate = estimate_camera(photo, FocalRequest(focal_px=600))
    assert estimate.camera is not None and lines.segments_px is not None
    mount = with_gravity(estimate, lines, None).mount
    assert mount is not None and math.isnan(mount.height_m)
    assert math.degrees(mount.pitch_rad) == pytest.approx(12, abs=0.6)
    assert math.degrees(mount.roll_rad) == pytest.approx(3, abs=0.3)
    gravity = gravity_from_lines(lines.segments_px, estimate.camera)
    p, r = mount.pitch_rad, mount.roll_rad
    up = (math.sin(r) * math.cos(p), -math.cos(r) * math.cos(p), -math.sin(p))  # as docs/conventions.md has it
    assert gravity is not None
    np.testing.assert_allclose(-gravity.down, up, atol=1e-6)


def test_segments_are_where_the_lines_are_and_not_in_people() -> None:
    pixels = np.zeros((300, 400, 3), np.uint8)
    pixels[100:, :] = 255  # an edge at v = 100
    pixels[:, 200:] = pixels[:, 200:] // 2
    found = straight_segments(pixels, np.zeros((0, 4)))
    level = found[np.abs(found[:, 1] - found[:, 3]) < 1]
    np.testing.assert_allclose(level[:, [1, 3]], 100, atol=0.7)
    assert not len(straight_segments(pixels, np.array([[-10.0, -10.0, 410.0, 310.0]])))
    larger = np.repeat(np.repeat(pixels, 4, axis=0), 4, axis=1)
    again = straight_segments(larger, np.zeros((0, 4)))
    np.testing.assert_allclose(again[np.abs(again[:, 1] - again[:, 3]) < 4][:, [1, 3]], 400, atol=3)


@given(st.integers(2560, 2700), st.integers(150, 900), st.booleans(), st.floats(0.2, 0.8))
@settings(max_examples=12, deadline=None)
def test_segments_of_large_pictures_are_where_the_lines_are(long: int, short: int, upright: bool, part: float) -> None:
    # halved once before, whatever is odd about its sides
    pixels = np.zeros((short, long, 3), np.uint8)
    edge = round(part * long)
    pixels[:, edge:] = 255
    found = straight_segments(pixels.swapaxes(0, 1) if upright else pixels, np.zeros((0, 4)))
    across = found[:, [1, 3]] if upright else found[:, [0, 2]]
    assert len(found)
    np.testing.assert_allclose(across, edge, atol=0.4 * long / 640)


def test_pictures_are_halved_while_they_stay_twice_as_large_as_they_are_to_be() -> None:
    for side, left, times in ((2559, 2559, 1), (2560, 1280, 2), (5119, 2559, 2), (5121, 1280, 4)):
        grey, found = halved(np.zeros((8, side), np.uint8))
        assert (grey.shape[1], found) == (left, times)
    squares = np.array([[10, 20], [30, 41]], np.uint8)
    grey, _ = halved(np.tile(squares, (2, 1300)))
    assert grey.shape == (2, 1300) and (grey == 25).all()  # the mean of 2 x 2, rounded


def test_pieces_of_one_line_are_one_and_those_of_a_bend_are_not() -> None:
    pixels = np.zeros((300, 400, 3), np.uint8)
    pixels[150:153, 40:180] = pixels[150:153, 188:360] = 255
    lengths = np.ptp(straight_segments(pixels, np.zeros((0, 4)))[:, [0, 2]], axis=1)
    assert lengths.max() > 300


def test_boxes_drawn_into_a_picture_are_no_building() -> None:
    scene = exact_scene(8.0, 2.0, 600.0, WIDTH, HEIGHT, azimuths_deg=(35.0, 125.0), each=10)
    corners = np.random.default_rng(1).uniform(20, 400, (12, 2))
    sides = [(0, 0, 60, 0), (60, 0, 60, 70), (60, 70, 0, 70), (0, 70, 0, 0)]
    boxes = np.array([np.tile(corner, 2) + side for corner in corners for side in sides])
    both = np.concatenate([scene.segments_px, boxes])
    left = without_graphics(both)
    assert len(scene.segments_px) - 1 <= len(left) <= len(scene.segments_px)  # one of its own runs so too
    assert not np.isclose(left, boxes[:, None]).all(axis=-1).any()
    np.testing.assert_array_equal(without_graphics(np.concatenate([scene.segments_px, boxes[:2]]))[-2:], boxes[:2])


def test_a_photo_that_is_not_at_hand_has_no_segments() -> None:
    assert segments_of(Photo("away.jpg", 640, 480, ""), np.zeros((0, 4))) is None


def test_the_library_says_loudly_what_it_assumed() -> None:
    points = np.random.default_rng(0).uniform(100, 300, (1, 17, 2))
    person = People(COCO_17, points, np.ones((1, 17)))
    with pytest.warns(AssumedFocalWarning, match=r"focal_35mm=35"):
        scene = measure(blank(), pose=lambda pixels: person)
    assert scene.camera.is_assumed
    with warnings.catch_warnings():
        warnings.simplefilter("error", AssumedFocalWarning)
        refused = measure(blank(), pose=lambda pixels: person, camera=FocalRequest(assume=False))
        measure(blank(), pose=lambda pixels: person, camera=Camera.centred(600, WIDTH, HEIGHT))
    assert refused.status == "no_camera"


def test_people_are_heard_at_the_focal_length_that_they_say() -> None:
    """Their likelihood is of pixels, the grid's of millimetres: a peak at 1,200 px of 30 px a millimetre is 40 mm."""
    log_f = np.linspace(math.log(200), math.log(8000), 400)
    likelihood = -0.5 * ((log_f - math.log(1200.0)) / 0.05) ** 2
    told = FocalPosterior(1200.0, 1100.0, 1310.0, 0.05, 0.3, np.ones(4, dtype=bool), log_f, likelihood)
    assert math.exp(_GRID[_of_people(told, 30.0).said.argmax()]) == pytest.approx(40.0, rel=0.02)


def test_an_uncertainty_with_long_tails_is_not_taken_for_its_middle() -> None:
    """Of 97 % within a few per cent and 3 % far away the standard deviation is that of all."""
    near, far = math.log(35.0), math.log(400.0)
    bump = [np.exp(-0.5 * ((_GRID - at) / 0.05) ** 2) for at in (near, far)]
    _, _, mean, sd = _posterior(0.97 * bump[0] + 0.03 * bump[1], [])
    assert mean == pytest.approx(0.97 * near + 0.03 * far, abs=0.01)
    assert sd == pytest.approx(math.sqrt(0.05**2 + 0.97 * 0.03 * (far - near) ** 2), rel=0.02)


def test_a_part_of_a_picture_is_as_unsure_as_its_size_besides() -> None:
    nobody = People.none(COCO_17)

    def spread(width: int, height: int) -> float:
        photo = Photo("scan.jpg", width, height, "")
        found = without_statement(estimate_camera(photo), photo, nobody, None, assume=True)
        assert found.camera is not None
        return found.camera.focal_rel_sd

    # 3:2 is a sensor's shape; 5:4 is none, and a crop's diagonal is unsure by a fifth
    assert spread(1000, 800) == pytest.approx(math.hypot(spread(1500, 1000), 0.2))


def test_evidence_tells_as_much_as_it_changes_what_is_expected() -> None:
    """The divergence of one normal density from another (Kullback and Leibler 1951), and nothing where it is flat."""
    prior = np.exp(-0.5 * ((_GRID - 3.6) / 0.5) ** 2)
    likelihood = np.exp(-0.5 * ((_GRID - 3.9) / 0.2) ** 2)
    precision = 0.5**-2 + 0.2**-2
    mean, variance = (3.6 * 0.5**-2 + 3.9 * 0.2**-2) / precision, 1 / precision
    expected = 0.5 * (variance / 0.25 + (mean - 3.6) ** 2 / 0.25 - 1 - math.log(variance / 0.25))
    assert _information(prior, likelihood) == pytest.approx(expected, rel=0.02)
    assert _information(prior, np.full_like(prior, 0.3)) == pytest.approx(0, abs=1e-12)


def test_the_interval_of_a_shoot_is_said_in_pixels() -> None:
    shoot = SameShoot(math.log(1000.0), 0.1, 40, 60)
    half = math.exp(0.16449)
    assert shoot.text.endswith(f"of 40 photos: {1000 / half:.0f} to {1000 * half:.0f} px")


@pytest.mark.parametrize(("log_sd", "answers"), [(0.155, True), (0.165, False)])
def test_people_answer_within_thirty_per_cent_or_not_at_all(monkeypatch, log_sd, answers) -> None:
    """Half an interval is 1.645 sd of the logarithm: ln 1.3 = 0.262 is at 0.1595."""
    found = self_calibration.FocalPosterior(
        1500.0, 1200.0, 1900.0, log_sd, 0.2, np.ones(4, dtype=bool), np.zeros(2), np.zeros(2)
    )
    monkeypatch.setattr(self_calibration, "focal_posterior", lambda *_: found)
    estimate = self_calibration.calibrate(People.none(COCO_17), 1800, 1200)
    assert (estimate.camera is not None) == answers
    assert estimate.candidates[0].focal_px == 1500 and estimate.candidates[0].rel_sd == log_sd
    if estimate.camera is not None:
        assert (estimate.camera.f_px, estimate.camera.focal_rel_sd) == (1500, log_sd)
    else:
        assert "1200 to 1900 px: too wide" in estimate.reason
