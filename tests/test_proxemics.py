"""Nearest others, viewing angles, shot sizes, orientations and groups: closed forms and laws."""

import math
from statistics import NormalDist

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from proxemetry.bodies import Bodies, Mode
from proxemetry.camera import Camera
from proxemetry.distances import measure_distances
from proxemetry.draws import log_sd
from proxemetry.people import People
from proxemetry.people.skeleton import COCO_17
from proxemetry.proxemics import ORIENTATIONS, Proxemics, _shots, _turned, measure_proxemics, phase_of

CAMERA = Camera.centred(1000, 1600, 1200, focal_rel_sd=0.0, source="test")
LEVEL = np.array([0.0, -1.0, 0.0])


def bodies_at(places, headings_deg=None, *, sd_m=0.01, heading_sd_deg=1.0, up=LEVEL, stature_m=1.7, modes=()):
    count = len(places)
    return Bodies(
        np.array(places, dtype=float), np.eye(3 * count) * sd_m**2, "scene", ("torso",) * count, (None,) * count, up,
        np.radians(headings_deg if headings_deg is not None else [0.0] * count),
        np.full(count, math.radians(heading_sd_deg)),
        np.full(count, stature_m), np.full(count, 0.05), modes=modes,
    )  # fmt: skip


def people_seen(bodies, camera=CAMERA):
    """Return people whose head and torso lie where upright bodies of 1.7 m have them."""
    keypoints = np.full((len(bodies), 17, 2), np.nan)
    parts = {"nose": -0.62, "left_shoulder": -0.25, "right_shoulder": -0.25, "left_hip": 0.24, "right_hip": 0.24}
    for i, (x, y, z) in enumerate(bodies.positions_m):
        for name, below in parts.items():
            keypoints[i, COCO_17.joints.index(name)] = (
                camera.cx + camera.fx * x / z, camera.cy + camera.fy * (y + below) / z,
            )  # fmt: skip
    return People(COCO_17, keypoints, np.where(np.isnan(keypoints[..., 0]), 0.0, 0.9))


def measured(bodies, camera=CAMERA) -> Proxemics:
    return measure_proxemics(people_seen(bodies), bodies, measure_distances(bodies), camera, 1200)


def test_the_nearest_other_on_a_three_four_five_triangle():
    found = measured(bodies_at([(0, 0, 5), (3, 0, 5), (3, 0, 9)], sd_m=1e-4))
    assert found.nearest.tolist() == [1, 0, 1]
    assert found.nearest_m == pytest.approx([3, 3, 4], abs=1e-3)
    assert (found.nearest_low_m <= found.nearest_m).all() and (found.nearest_m <= found.nearest_high_m).all()


def test_one_person_has_no_nearest_other():
    found = measured(bodies_at([(0, 0, 5)]))
    assert found.nearest.tolist() == [-1] and math.isnan(found.nearest_m[0])
    assert found.group.tolist() == [-1] and found.group_size.tolist() == [1]


def test_nobody_is_a_valid_answer():
    found = measured(Bodies.unplaced(0, "scene", "nobody"))
    assert found.shots == () and found.nearest.shape == (0,) and found.group_size.shape == (0,)


def test_the_distance_from_the_camera_is_uncertain_along_the_line_of_sight():
    found = measured(bodies_at([(3, 0, 4)], sd_m=0.2))
    assert found.camera_distance_m[0] == pytest.approx(5)
    assert [found.camera_low_m[0], found.camera_high_m[0]] == pytest.approx([5 - 0.329, 5 + 0.329], abs=0.02)


@given(relative_sd=st.floats(0.01, 3.0))
def test_nobody_is_behind_the_camera_however_unsure_depth_is(relative_sd: float):
    found = measured(bodies_at([(0, 0, 5)], sd_m=5 * relative_sd))
    sd = float(log_sd(relative_sd))
    low, high = found.camera_low_m[0], found.camera_high_m[0]
    assert 0 < low < 5 < high
    if relative_sd < 0.3:
        normal = NormalDist()
        assert normal.cdf(math.log(high / 5) / sd) - normal.cdf(math.log(low / 5) / sd) == pytest.approx(0.9, abs=0.012)
        # The shortest interval of a log-normal distribution lies about its mode, exp(-sd^2). Others about there are
        # hardly longer, so the ends of the shortest among draws say less than its length.
        first, last = 5 * np.exp(-(sd**2) + 1.645 * sd * np.array([-1, 1]))
        assert high - low == pytest.approx(last - first, rel=0.04)


@given(sd=st.floats(1e-4, 2.0))
def test_the_logarithms_deviation_is_that_of_the_factor(sd: float):
    assert float(log_sd(math.sqrt(math.expm1(2 * sd**2) - 2 * math.expm1(sd**2 / 2)))) == pytest.approx(sd, rel=1e-6)


def test_the_distance_from_the_camera_holds_every_explanation():
    own = np.eye(3) * 1e-4
    modes = (Mode(0.5, np.array([[0, 0, 4.0]]), own), Mode(0.5, np.array([[0, 0, 6.0]]), own))
    found = measured(bodies_at([(0, 0, 4)], modes=modes))
    assert found.camera_low_m[0] < 4.05 and found.camera_high_m[0] > 5.95


@pytest.mark.parametrize(
    ("place", "heading", "angle"),
    [((0, 0, 5), 0, 0), ((0, 0, 5), 90, 90), ((0, 0, 5), 180, 180), ((5, 0, 5), -45, 0),
     ((-5, 0, 5), 45, 0), ((5, 0, 5), 45, 90)],
)  # fmt: skip
def test_the_horizontal_angle_is_between_front_and_camera(place, heading, angle):
    assert measured(bodies_at([place], [heading])).horizontal_deg[0] == pytest.approx(angle, abs=1e-6)


def test_the_vertical_angle_is_that_of_the_ray_to_the_head():
    low = measured(bodies_at([(0, 0.62, 1.0)]))  # the head at the height of the camera
    assert low.vertical_deg[0] == pytest.approx(0, abs=1e-6)
    above = measured(bodies_at([(0, 1.62, 1.0)]))  # the head one metre below it, one metre away
    assert above.vertical_deg[0] == pytest.approx(45, abs=1e-6)


@pytest.mark.parametrize(
    ("depth", "torso_down", "shot"),
    [
        (0.3, 0.7, "extreme close-up"), (0.42, 0.6, "close-up"), (1.0, 0.8, "medium close-up"),
        (1.5, 0.7, "medium shot"), (2.2, 0.9, "medium long shot"),
        (2.0, 0.0, "full shot"), (4.0, 0.0, "long shot"), (12.0, 0.0, "very long shot"),
        # 1,700 px at 1 m: two thirds of the picture's 1,200 at 2.125 m, a quarter at 5.667 m
        (2.10, 0.0, "full shot"), (2.15, 0.0, "long shot"), (5.64, 0.0, "long shot"), (5.69, 0.0, "very long shot"),
    ],
)  # fmt: skip
def test_shot_sizes_go_from_the_face_to_the_crowd(depth, torso_down, shot):
    assert measured(bodies_at([(0, torso_down, depth)])).shots[0] == shot


def test_shot_sizes_need_no_camera():
    bodies = bodies_at([(0, 0, 4)])
    unplaced = Bodies.unplaced(1, "scene", "no focal length")
    found = measure_proxemics(people_seen(bodies), unplaced, measure_distances(unplaced), None, 1200)
    assert found.shots == ("long shot",) and math.isnan(found.camera_distance_m[0])


# One stands at 0 m and one at 1 m to the right, 5 m away; headings turn to the photo's right.
@pytest.mark.parametrize(
    ("headings", "turned"),
    [((90, -90), "facing"), ((0, 0), "side by side"), ((180, 180), "side by side"), ((-90, 90), "back to back"),
     ((90, 90), "one behind the other"), ((-90, -90), "one behind the other"), ((30, -30), "uncertain")],
)  # fmt: skip
def test_how_two_people_are_turned(headings, turned):
    found = measured(bodies_at([(0, 0, 5), (1, 0, 5)], headings))
    assert found.orientation(0, 1) == found.orientation(1, 0) == turned


def test_an_uncertain_heading_makes_an_uncertain_orientation():
    found = measured(bodies_at([(0, 0, 5), (1, 0, 5)], [90, -90], heading_sd_deg=70))
    assert found.orientation(0, 1) == "uncertain"
    assert 0.2 < found.orientation_probability[0, 1, 0] < 0.5
    # each is within 60 degrees of the other with erf(60 / 70 / sqrt 2), wrapped once
    within = sum(
        0.5 * (math.erf((60 + 360 * k) / 70 / math.sqrt(2)) - math.erf((-60 + 360 * k) / 70 / math.sqrt(2)))
        for k in (-1, 0, 1)
    )
    assert found.orientation_probability[0, 1, 0] == pytest.approx(within**2, abs=0.02)


def test_people_far_apart_have_no_orientation():
    assert measured(bodies_at([(0, 0, 5), (4, 0, 5)], [90, -90])).orientation(0, 1) is None


@given(
    # places on a grid of their own size apart, headings off the sectors' edges
    st.lists(
        st.tuples(st.integers(-3, 3), st.integers(3, 8), st.integers(-17, 17)),
        min_size=2,
        max_size=5,
        unique_by=lambda p: p[:2],
    ),
    st.randoms(use_true_random=False),
)
def test_who_comes_first_and_which_side_does_not_matter(drawn, chance):
    places = [(0.9 * x + 0.01 * z, 0.0, float(z)) for x, z, _ in drawn]
    headings = [10.0 * h + 3.7 for *_, h in drawn]
    found = measured(bodies_at(places, headings, heading_sd_deg=20))
    order = list(range(len(places)))
    chance.shuffle(order)
    shuffled = measured(bodies_at([places[i] for i in order], [headings[i] for i in order], heading_sd_deg=20))
    assert shuffled.nearest_m == pytest.approx(found.nearest_m[order], nan_ok=True)
    expected = found.orientation_probability[np.ix_(order, order)]
    assert shuffled.orientation_probability == pytest.approx(expected, abs=0.01, nan_ok=True)  # draws at an edge
    assert shuffled.group_size.tolist() == found.group_size[order].tolist()
    mirrored = measured(bodies_at([(-x, y, z) for x, y, z in places], [-h for h in headings], heading_sd_deg=20))
    assert mirrored.horizontal_deg == pytest.approx(found.horizontal_deg, abs=1e-6)
    assert mirrored.orientation_probability == pytest.approx(found.orientation_probability, abs=0.03, nan_ok=True)
    total = np.nansum(found.orientation_probability, axis=-1)
    assert ((total >= 0) & (total <= 1 + 1e-9)).all()
    assert len(ORIENTATIONS) == found.orientation_probability.shape[-1]


def test_people_who_face_each_other_are_one_group_and_chains_join():
    close = bodies_at(
        [(0, 0, 5), (0.9, 0, 5), (6, 0, 5), (6.9, 0, 5), (-6, 0, 5)], [90, -90, 90, -90, 0], heading_sd_deg=3
    )
    found = measured(close)
    assert found.group.tolist() == [0, 0, 1, 1, -1]
    assert found.group_size.tolist() == [2, 2, 2, 2, 1]


@pytest.mark.parametrize(
    ("zone", "metres", "phase"),
    [("intimate", 0.1, "close"), ("intimate", 0.3, "far"), ("personal", 0.7, "close"), ("personal", 0.8, "far"),
     ("social", 2.1, "close"), ("social", 2.2, "far"), ("public", 7, "close"), ("public", 8, "far"),
     ("uncertain", 1, None), (None, math.nan, None)],
)  # fmt: skip
def test_halls_phases(zone, metres, phase):
    assert phase_of(zone, metres) == phase


def _kinds(one_deg, other_deg, between_deg):
    turned = _turned(*(np.array([math.radians(v)]) for v in (one_deg, other_deg, between_deg)))
    return [name for name, drawn in zip(ORIENTATIONS, turned, strict=True) if drawn[0]]


@pytest.mark.parametrize(
    ("one", "other", "between", "kinds"),
    [
        (59, 59, 118, ["facing"]), (61, 59, 120, []), (59, 61, 120, []),
        (121, 121, 118, ["back to back"]), (119, 121, 120, []), (121, 119, 120, []), (130, 130, 100, ["back to back"]),
        (46, 134, 0, ["side by side"]), (44, 136, 0, ["one behind the other"]), (90, 90, 44, ["side by side"]),
        (90, 90, 46, []), (10, 170, 0, ["one behind the other"]), (170, 10, 0, ["one behind the other"]),
        (46, 136, 2, ["one behind the other"]), (136, 46, 2, ["one behind the other"]),  # one of them not aside
    ],
)  # fmt: skip
def test_the_sectors_of_orientations_end_where_they_are_said_to(one, other, between, kinds):
    assert _kinds(one, other, between) == kinds


def test_no_two_orientations_hold_at_once():
    turns = np.radians(np.arange(-179.5, 180))  # of either's front from the line to the other
    one, other = (turn.ravel() for turn in np.meshgrid(turns, turns))
    between = (one - other) % (2 * np.pi) - np.pi  # the other looks along the line from its far end
    assert np.sum(_turned(np.abs(one), np.abs(other), between), axis=0).max() == 1


def test_a_shot_counts_what_the_picture_shows_of_a_body():
    """A body of 1,000 px whose head is unseen: its top lies 180 px above the shoulders, and what is above the picture
    is not shown."""

    def shot(shoulder_v, height_px, head_v=math.nan):
        keypoints = np.full((1, 17, 2), np.nan)
        for name, v in (("shoulder", shoulder_v), ("hip", shoulder_v + 290)):
            for side in ("left", "right"):
                keypoints[0, COCO_17.joints.index(f"{side}_{name}")] = (500.0, v)
        keypoints[0, COCO_17.joints.index("nose")] = (500.0, head_v)
        people = People(COCO_17, keypoints, np.where(np.isnan(keypoints[..., 1]), 0.0, 0.9))
        return _shots(people, np.array([1000.0]), height_px)[0]

    # shown from the top at 0 down to the picture's edge: shares of 0.41 and 0.43, about the chest's 0.42
    assert (shot(180.0, 410), shot(180.0, 430)) == ("medium close-up", "medium shot")
    # a head that is seen tells the top by itself, 65 px above it
    assert (shot(400.0, 410, 65.0), shot(400.0, 430, 65.0)) == ("medium close-up", "medium shot")
    # the shoulders at the upper edge: 0.18 of the body lies above it and is not shown
    assert (shot(0.0, 410), shot(0.0, 430)) == ("medium close-up", "medium shot")
