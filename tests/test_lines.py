"""Gravity and focal length from straight segments."""

from __future__ import annotations

import itertools
import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from proxemetry.arrays import FloatArray
from proxemetry.camera import Camera
from proxemetry.camera.lines import focal_from_lines, gravity_from_lines
from proxemetry.camera.lines.focal import (
    ONE_DIRECTION,
    WEAK_PRIOR,
    FocalProfile,
    _blurred,
    _distinct,
    _evidence,
    _moved,
    focal_profile,
    read_focal,
)
from proxemetry.camera.lines.gravity import TOO_FEW, _once
from proxemetry.camera.lines.mixture import Fitted, _worth, evaluate, lines_of
from proxemetry.camera.lines.model import AZIMUTH, N_PARAMETERS, PITCH, PRIOR, vanishing_points
from proxemetry.camera.lines.segments import _components, _merged, _outside
from proxemetry.camera.mount import Mount
from synthetic.line_scenes import STRAIGHT, WITHOUT, LineScene, exact_scene, line_scene


def corner(pitch_deg: float = 6.0, roll_deg: float = 1.0, focal_px: float = 700.0) -> LineScene:
    """Return two walls at right angles, seen by a camera of 640 x 480."""
    return exact_scene(pitch_deg, roll_deg, focal_px, 640, 480, azimuths_deg=(35.0, 125.0), each=25)


def camera_of(scene: LineScene) -> Camera:
    return Camera.centred(scene.focal_px, scene.width, scene.height)


@settings(max_examples=8, deadline=None)
@given(st.floats(-20, 25), st.floats(-4, 4), st.floats(500, 1500))
def test_exact_segments_give_gravity_back(pitch_deg: float, roll_deg: float, focal_px: float) -> None:
    scene = corner(pitch_deg, roll_deg, focal_px)
    found = gravity_from_lines(scene.segments_px, camera_of(scene))
    assert found is not None
    assert found.pitch_deg == pytest.approx(pitch_deg, abs=0.15)
    assert found.roll_deg == pytest.approx(roll_deg, abs=0.1)
    np.testing.assert_allclose(found.down, scene.down, atol=0.004)
    assert np.linalg.norm(found.down) == pytest.approx(1)


@pytest.mark.parametrize("focal_px", [450.0, 700.0, 1100.0])
def test_exact_segments_give_the_focal_length_back(focal_px: float) -> None:
    scene = corner(focal_px=focal_px)
    found = focal_from_lines(scene.segments_px, 640, 480)
    assert found is not None
    assert found.focal_px == pytest.approx(focal_px, rel=0.02)
    assert found.low_px < focal_px < found.high_px


def test_looking_down_converges_downwards() -> None:
    # two posts nearer to one another at their feet: the camera looks down, by hand, at atan(f / (vanishing point's v))
    scene = corner(pitch_deg=20.0, roll_deg=0.0)
    upright = scene.segments_px[:25]
    vanishing = 240 + 700 / math.tan(math.radians(20))
    at = upright[:, 0] + (upright[:, 2] - upright[:, 0]) * (vanishing - upright[:, 1]) / (upright[:, 3] - upright[:, 1])
    np.testing.assert_allclose(at, 320, atol=1e-6)


def test_a_resized_picture_has_the_same_gravity_and_a_larger_focal_length() -> None:
    scene = corner()
    small, large = scene.segments_px, 3 * scene.segments_px
    a, b = focal_from_lines(small, 640, 480), focal_from_lines(large, 1920, 1440)
    assert a is not None and b is not None
    assert (b.focal_px, b.low_px, b.high_px) == pytest.approx((3 * a.focal_px, 3 * a.low_px, 3 * a.high_px), rel=1e-3)
    camera = camera_of(scene)
    g, h = gravity_from_lines(small, camera), gravity_from_lines(large, camera.resized(1920, 1440))
    assert g is not None and h is not None
    assert (h.pitch_deg, h.roll_deg, h.pitch_sd_deg) == pytest.approx(
        (g.pitch_deg, g.roll_deg, g.pitch_sd_deg), rel=1e-3
    )


def test_neither_order_nor_ends_matter_and_mirroring_turns_the_roll() -> None:
    scene = corner()
    rng = np.random.default_rng(0)
    mixed = scene.segments_px[rng.permutation(len(scene.segments_px))][:, [2, 3, 0, 1]]
    mirrored = scene.segments_px * (-1, 1, -1, 1) + (640, 0, 640, 0)
    turned = (640, 480, 640, 480) - scene.segments_px
    as_is, again, flipped, upside_down = (
        gravity_from_lines(segments, camera_of(scene)) for segments in (scene.segments_px, mixed, mirrored, turned)
    )
    assert as_is and again and flipped and upside_down
    assert (again.pitch_deg, again.roll_deg) == pytest.approx((as_is.pitch_deg, as_is.roll_deg), abs=1e-3)
    assert (flipped.pitch_deg, flipped.roll_deg) == pytest.approx((as_is.pitch_deg, -as_is.roll_deg), abs=1e-3)
    # a picture on its head is taken as upright: what looked down looks up
    assert (upside_down.pitch_deg, upside_down.roll_deg) == pytest.approx((-as_is.pitch_deg, as_is.roll_deg), abs=1e-3)


def test_a_portrait_picture_is_no_other() -> None:
    scene = exact_scene(8.0, -1.0, 700.0, 480, 640, azimuths_deg=(35.0, 125.0), each=25)
    found = gravity_from_lines(scene.segments_px, camera_of(scene))
    assert found is not None
    assert (found.pitch_deg, found.roll_deg) == pytest.approx((8.0, -1.0), abs=0.2)


def test_what_the_camera_leaves_open_is_part_of_the_doubt() -> None:
    scene = corner(pitch_deg=15.0)
    exact = gravity_from_lines(scene.segments_px, camera_of(scene))
    cropped = gravity_from_lines(scene.segments_px, replace(camera_of(scene), principal_sd_px=60.0))
    unsure = gravity_from_lines(scene.segments_px, replace(camera_of(scene), focal_rel_sd=0.2))
    assert exact and cropped and unsure
    assert exact.pitch_sd_deg >= 1.0  # walls out of plumb, bent lenses
    assert cropped.pitch_sd_deg > 1.1 * exact.pitch_sd_deg
    assert cropped.roll_sd_deg > 1.5 * exact.roll_sd_deg
    assert unsure.pitch_sd_deg > exact.pitch_sd_deg


def test_pixels_that_are_not_square_and_bent_lenses_are_undone() -> None:
    scene = corner()
    wide = Camera(1400.0, 700.0, 640.0, 240.0, 1280, 480)
    stretched = scene.segments_px * (2, 1, 2, 1)
    found = gravity_from_lines(stretched, wide)
    assert found is not None
    assert (found.pitch_deg, found.roll_deg) == pytest.approx((6.0, 1.0), abs=0.3)


@pytest.mark.parametrize("segments", [[], np.zeros((0, 4)), np.full((9, 4), np.nan), np.ones((9, 4)), [[1, 2, 3, 4]]])
def test_nothing_to_go_by_tells_nothing(segments: FloatArray) -> None:
    assert gravity_from_lines(segments, Camera.centred(700, 640, 480)) is None
    assert focal_from_lines(segments, 640, 480) is None


@pytest.mark.parametrize(
    ("pitch_deg", "turned_deg", "explanations"),
    [(0, 0, 1), (0, 90, 1), (0, -180, 1), (0.2, 0, 1), (0, 0.5, 1), (0.4, 0, 2), (0, 45, 2), (0, 5, 2)],
)
def test_explanations_are_one_up_to_a_quarter_turn_of_the_walls(pitch_deg, turned_deg, explanations):
    """Walls at right angles are the same walls after a quarter turn; the likelier of two that are alike stays."""
    rows = np.zeros((2, N_PARAMETERS))
    rows[0, AZIMUTH] = 0.4
    rows[1] = rows[0]
    rows[1, [PITCH, AZIMUTH]] += np.radians([pitch_deg, turned_deg])
    fit = Fitted(rows, np.zeros((2, 6)), np.array([2.0, 1.0]), np.tile(np.eye(N_PARAMETERS), (2, 1, 1)))
    kept = _once(fit)
    assert len(kept.rows) == explanations
    assert kept.cost[0] == 1.0 and kept.rows[0] == pytest.approx(rows[1])


def test_gravity_is_a_mount_with_anothers_height():
    gravity = gravity_from_lines(corner().segments_px, camera_of(corner()))
    assert gravity is not None
    alone, tall = gravity.mount(), gravity.mount(Mount.stated(height_m=2.5, height_sd_m=0.1, size_px=(640, 480)))
    assert math.isnan(alone.height_m) and alone.size_px is None
    assert (tall.height_m, tall.size_px) == (2.5, (640, 480)) and tall.height_sd_m == pytest.approx(0.1)
    for mount in (alone, tall):
        assert np.degrees([mount.pitch_rad, mount.roll_rad]) == pytest.approx([gravity.pitch_deg, gravity.roll_deg])
        assert np.degrees(mount.sd[:2]) == pytest.approx([gravity.pitch_sd_deg, gravity.roll_sd_deg])


def test_another_shape_is_refused() -> None:
    with pytest.raises(ValueError, match=r"\(N, 4\)"):
        focal_from_lines(np.zeros((3, 2, 2)), 640, 480)


@pytest.mark.parametrize("kind", list(WITHOUT))
def test_things_without_straight_structure_tell_nothing(kind: str) -> None:
    rng = np.random.default_rng(7)
    scenes = [line_scene(kind, rng) for _ in range(6)]
    answers = [(s, f) for s in scenes if (f := focal_from_lines(s.segments_px, s.width, s.height)) is not None]
    assert len(answers) <= 1  # stripes that converge may look like a wall
    for s, f in answers:
        width = math.log(f.high_px / f.low_px)
        assert -width < math.log(f.high_px / s.focal_px) < 2 * width
    wrong = [
        g for s in scenes if (g := gravity_from_lines(s.segments_px, camera_of(s))) is not None
        and abs(g.pitch_deg - s.pitch_deg) > 5 * g.pitch_sd_deg
    ]  # fmt: skip
    assert not wrong


def test_one_wall_seen_by_a_level_camera_tells_no_focal_length() -> None:
    scene = exact_scene(0.0, 0.0, 700.0, 640, 480, azimuths_deg=(35.0,), each=40)
    assert focal_from_lines(scene.segments_px, 640, 480) is None


def test_intervals_hold() -> None:
    rng = np.random.default_rng(11)
    held, answers = 0, 0
    for kind in list(STRAIGHT)[:3] * 12:
        scene = line_scene(kind, rng)
        found = gravity_from_lines(scene.segments_px, camera_of(scene))
        if found is not None:
            answers += 1
            held += abs(found.pitch_deg - scene.pitch_deg) < 1.645 * found.pitch_sd_deg
    assert answers >= 12
    assert held >= 0.8 * answers


def test_derivatives_are_those_of_the_vanishing_points() -> None:
    rows = np.random.default_rng(0).normal(0, 0.3, (3, N_PARAMETERS))
    _, slope = vanishing_points(rows)
    for k in range(N_PARAMETERS):
        step = 1e-6 * np.eye(N_PARAMETERS)[k]
        difference = (vanishing_points(rows + step)[0] - vanishing_points(rows - step)[0]) / 2e-6
        np.testing.assert_allclose(slope[..., k], difference, atol=1e-8)


def test_the_cost_goes_down_its_slope() -> None:
    scene = corner()
    lines = lines_of((scene.segments_px - (320, 240, 320, 240)) / 800)
    rows = np.zeros((1, N_PARAMETERS))
    rows[0, :4] = np.radians(6.3), np.radians(-1.2), math.log(0.9), np.radians(36)
    shares = np.full((1, 6), 1 / 6)
    _, slope, _ = evaluate(lines, rows, shares, PRIOR)
    for k in range(N_PARAMETERS):
        # the segments' distances from a vanishing point are taken as fixed: a few percent for those far from it
        step = 3e-4 * np.eye(N_PARAMETERS)[k]  # single precision
        up, down = (evaluate(lines, rows + s, shares, PRIOR)[0].cost for s in (step, -step))
        assert float(slope[0, k]) == pytest.approx(float((up - down)[0] / 6e-4), rel=0.12, abs=0.7)


def test_walls_at_odd_angles_widen_the_interval() -> None:
    """A level camera between two walls that are not at right angles: the right angle is likely, and not certain."""
    odd = exact_scene(0.0, 0.0, 700.0, 640, 480, azimuths_deg=(20.0, 95.0), each=12)
    square = exact_scene(0.0, 0.0, 700.0, 640, 480, azimuths_deg=(35.0, 125.0), each=12)
    profiles = [focal_profile(scene.segments_px, 640, 480) for scene in (odd, square)]
    true = math.log(700 / 800)
    for profile in profiles:
        assert not isinstance(profile, str)
        # five degrees of skew and more cost little more than ten times as much: about ln(0.9 / 0.1 x density)
        lost = float(profile.log_likelihood.max() - profile.at(np.array([true]))[0])
        assert lost < 8


def test_a_long_lens_tells_the_pitch_less_surely() -> None:
    found = [
        gravity_from_lines(exact_scene(12.0, 0.0, f, 640, 480, (35.0, 125.0), each=40).segments_px,
                           Camera.centred(f, 640, 480)) for f in (700.0, 2800.0)
    ]  # fmt: skip
    assert found[0] is not None and found[1] is not None
    # 0.4 degrees a diagonal of focal length, 800 px here, beside one degree
    assert found[0].pitch_sd_deg >= math.hypot(1.0, 0.4 * 700 / 800)
    assert found[1].pitch_sd_deg >= math.hypot(1.0, 0.4 * 2800 / 800)


def test_a_focal_length_of_the_profile_is_one_explanation_followed() -> None:
    """Hypotheses that are moved to another focal length keep where their lines vanish, as far as they can."""
    rows = np.zeros((1, N_PARAMETERS))
    rows[0, [0, 1, 2, 3, 4]] = 0.1, 0.0, 0.0, 0.4, 0.05
    moved = _moved(rows, np.array([0.5]))
    before, after = vanishing_points(rows)[0][0], vanishing_points(moved)[0][0]
    for k in (0, 1, 2):
        at = before[k, :2] / before[k, 2], after[k, :2] / after[k, 2]
        np.testing.assert_allclose(at[0][1 if k == 0 else 0], at[1][1 if k == 0 else 0], rtol=0.06)


def test_why_the_focal_length_stays_open_is_said() -> None:
    wall = exact_scene(0.0, 0.0, 700.0, 640, 480, azimuths_deg=(35.0,), each=40)
    assert read_focal(wall.segments_px, 640, 480) == ONE_DIRECTION
    assert read_focal(np.zeros((0, 4)), 640, 480) == TOO_FEW


@settings(max_examples=40, deadline=None)
@given(st.integers(1, 12), st.lists(st.tuples(st.integers(0, 11), st.integers(0, 11)), max_size=14))
def test_nodes_go_by_the_lowest_that_they_are_linked_to(count: int, links: list[tuple[int, int]]) -> None:
    links = [(a, b) for a, b in links if a < count and b < count]
    ends = np.array(links, dtype=np.intp).reshape(-1, 2)
    together = np.eye(count, dtype=bool)
    together[ends[:, 0], ends[:, 1]] = together[ends[:, 1], ends[:, 0]] = True
    for _ in range(count):
        together = together @ together
    assert _components(count, ends[:, 0], ends[:, 1]).tolist() == together.argmax(axis=1).tolist()


@settings(max_examples=25, deadline=None)
@given(st.floats(0, math.pi), st.lists(st.floats(0.05, 0.95), min_size=1, max_size=4, unique=True), st.booleans())
def test_the_pieces_of_a_line_are_one_and_a_parallel_line_stays_another(
    angle: float, cuts: list[float], turned: bool
) -> None:
    along, across = np.array([math.cos(angle), math.sin(angle)]), np.array([-math.sin(angle), math.cos(angle)])
    at = [0.0, *sorted(cuts), 1.0]
    pieces = [np.concatenate([300 + 200 * a * along, 300 + 200 * b * along]) for a, b in itertools.pairwise(at)]
    beside = np.concatenate([300 + 3 * across, 300 + 3 * across + 200 * along])  # 3 px aside
    beyond = np.concatenate([300 + 220 * along, 300 + 260 * along])  # a gap of 20 px
    found = _merged(np.array([*(pieces[::-1] if turned else pieces), beside, beyond]))
    assert len(found) == 3
    lengths = np.sort(np.hypot(found[:, 2] - found[:, 0], found[:, 3] - found[:, 1]))
    np.testing.assert_allclose(lengths, [40, 200, 200], atol=1e-6)


@pytest.mark.parametrize(("aside_px", "segments"), [(0.0, 1), (1.1, 1), (1.3, 2)])
def test_pieces_are_of_one_line_up_to_a_pixel_and_a_fifth_aside(aside_px: float, segments: int) -> None:
    pieces = np.array([[100.0, 200, 200, 200], [205, 200 + aside_px, 300, 200 + aside_px]])
    assert len(_merged(pieces)) == len(_merged(pieces[::-1])) == segments


def test_a_segment_belongs_to_the_person_in_whose_box_its_middle_lies() -> None:
    boxes = np.array([[100.0, 100, 200, 300], [np.nan] * 4])
    segments = np.array(
        [
            [0, 200, 300, 200], [150, 110, 150, 290],  # middles in the box, whatever reaches out
            [150, 200, 450, 200], [150, 290, 150, 590], [0, 0, 20, 10],  # an end in it, or nothing
        ],
        float,
    )  # fmt: skip
    assert _outside(segments, boxes).tolist() == [False, False, True, True, True]
    assert _outside(segments, np.zeros((0, 4))).all()


def test_a_windows_many_lines_count_no_more_than_a_few() -> None:
    """A quarter each, for one of a twentieth of the diagonal; six for a cell of 6 x 6, sixty for a picture."""
    rng = np.random.default_rng(0)
    middle = np.zeros((200, 2)) + (0.05, 0.05)
    spread = rng.uniform(-0.49, 0.49, (4, 2))
    worth = _worth(np.concatenate([middle, spread[:0]]), np.full(200, 0.05))
    assert worth == pytest.approx(6.0 / 200) and worth.sum() == pytest.approx(6.0)
    apart = np.array([[-0.4, -0.4], [0.4, -0.4], [0.0, 0.4]])
    assert _worth(apart, np.array([0.05, 0.025, 1.0])) == pytest.approx([0.25, 0.125, 0.375])
    both = _worth(np.concatenate([middle, apart]), np.full(203, 0.05))
    assert both[:200].sum() == pytest.approx(6.0) and both[200:] == pytest.approx(0.25)
    everywhere = _worth(rng.uniform(-0.5, 0.5, (5000, 2)), np.full(5000, 0.05))
    assert everywhere.sum() == pytest.approx(60.0, rel=1e-6)


def test_support_is_how_many_independent_segments_run_along_a_direction() -> None:
    scene = corner()
    rays = camera_of(scene).rays(np.reshape(scene.segments_px, (-1, 2, 2)))[..., :2].reshape(-1, 4)
    lines = lines_of(rays * 700 / 800)
    shares = np.array([[0.1, 0.1, 0.2, 0.3, 0.2, 0.1]])
    fit = Fitted(np.zeros((1, N_PARAMETERS)), shares, np.zeros(1), np.eye(N_PARAMETERS)[None])
    assert fit.support(lines) == pytest.approx(np.array([[0.3, 0.2, 0.1]]) * lines.count)


def test_a_profile_is_read_between_its_steps_and_as_its_end_beyond() -> None:
    profile = FocalProfile(np.array([0.0, 1.0, 2.0]), np.array([-4.0, 0.0, -2.0]), 1.0, False)
    assert profile.at(np.array([-3.0, 0.0, 0.5, 1.0, 1.5, 9.0])) == pytest.approx([-4, -4, -2, 0, -1, -2])


def test_the_evidence_of_structure_is_that_of_all_focal_lengths_together() -> None:
    """A normal likelihood about the usual focal length: its height, times how narrow it is beside what is usual."""
    mean, usual = WEAK_PRIOR
    log_f = np.linspace(mean - 3, mean + 3, 601)
    for sd, height in ((0.1, 5.0), (0.3, -2.0)):
        found = _evidence(log_f, height - 0.5 * ((log_f - mean) / sd) ** 2)
        assert found == pytest.approx(height + math.log(sd / math.hypot(sd, usual)), abs=2e-3)


@pytest.mark.parametrize(
    ("pitch_deg", "turned_deg", "log_f", "ways"),
    [(0, 0, 0.0, 1), (1.5, 90, 0.15, 1), (3, 0, 0.0, 2), (0, 45, 0.0, 2), (0, 0, 0.3, 2), (0, 4, 0.0, 2)],
)
def test_ways_to_stand_to_the_walls_are_one_up_to_a_quarter_turn(pitch_deg, turned_deg, log_f, ways) -> None:
    rows = np.zeros((2, N_PARAMETERS))
    rows[1, [PITCH, AZIMUTH]] = np.radians([pitch_deg, turned_deg])
    rows[1, 2] = log_f
    fit = Fitted(rows, np.zeros((2, 6)), np.array([2.0, 1.0]), np.tile(np.eye(N_PARAMETERS), (2, 1, 1)))
    assert _distinct(fit) == [1, 0][:ways]


def test_a_doubt_about_the_focal_length_blurs_its_profile() -> None:
    """A normal density of 0.1 with a doubt of 0.2 is one of their sum in squares, and as probable on the whole."""
    log_f = np.linspace(-3, 3, 1201)
    blurred = _blurred(log_f, -0.5 * (log_f / 0.1) ** 2, 0.2)
    inner = np.abs(log_f) < 0.6
    expected = np.log(0.1 / math.hypot(0.1, 0.2)) - 0.5 * (log_f / math.hypot(0.1, 0.2)) ** 2
    assert blurred[inner] == pytest.approx(expected[inner], abs=1e-3)
