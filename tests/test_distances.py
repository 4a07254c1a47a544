"""Distances, intervals, zones and groups: closed forms and laws."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from proxemetry.bodies import Bodies, Mode
from proxemetry.distances import UNCERTAIN, ZONES, ground_frame, measure_distances, zone_of
from proxemetry.draws import pair_covariance
from proxemetry.formations import face_each_other

LEVEL_UP = np.array([0.0, -1.0, 0.0])


def bodies_at(places, sd=0.0, up=LEVEL_UP, heading=None, modes=()):
    count = len(places)
    return Bodies(
        np.array(places, dtype=float).reshape(-1, 3), np.eye(3 * count) * sd**2, "drawn", ("drawn",) * count,
        (None,) * count, up=up, modes=modes,
        heading_rad=np.zeros(0) if heading is None else np.array(heading),
        heading_sd_rad=np.zeros(0) if heading is None else np.full(count, 0.05),
    )  # fmt: skip


def test_three_four_five():
    distances = measure_distances(bodies_at([(0, 0, 5), (3, 0, 9)]))
    assert distances.distance_m[0, 1] == pytest.approx(5)
    assert distances.low_m[0, 1] == pytest.approx(5) == distances.high_m[0, 1]


def test_on_the_ground_height_does_not_count_and_in_space_it_does():
    places = [(0, 0, 5), (3, 12, 9)]
    known, unknown = measure_distances(bodies_at(places)), measure_distances(bodies_at(places, up=None))
    assert known.on_ground and not unknown.on_ground
    assert known.distance_m[0, 1] == pytest.approx(5)
    assert known.distance_3d_m[0, 1] == unknown.distance_m[0, 1] == pytest.approx(13)


def test_a_pitched_camera_sees_the_same_ground():
    p = math.radians(30)
    up = np.array([0, -math.cos(p), -math.sin(p)])
    right, forward, _ = ground_frame(up)
    distances = measure_distances(bodies_at([5 * forward, 9 * forward + 3 * right - 2 * up], up=up))
    assert distances.distance_m[0, 1] == pytest.approx(5)


@given(st.floats(0.01, 0.3), st.floats(2, 8))
def test_far_apart_the_interval_is_the_gaussians(sd, gap):
    distances = measure_distances(bodies_at([(0, 0, 5), (gap, 0, 5)], sd))
    half = 1.6449 * math.sqrt(2) * sd
    assert distances.low_m[0, 1] == pytest.approx(gap - half, abs=0.1 * half + sd**2 / gap)
    assert distances.high_m[0, 1] == pytest.approx(gap + half, abs=0.1 * half + 2 * sd**2 / gap)


@pytest.mark.parametrize("arrangement", ["side by side", "anywhere", "one behind the other"])
def test_intervals_cover_the_truth_whatever_the_arrangement(arrangement):
    rng, covered, count = np.random.default_rng(5), 0, 400
    for _ in range(count):
        radius, turn = rng.uniform(0.6, 3), rng.uniform(0, 2 * math.pi)
        turn = {"side by side": 0.0, "anywhere": turn, "one behind the other": math.pi / 2}[arrangement]
        gap = radius * np.array([math.cos(turn), 0, math.sin(turn)])
        sd = np.array([0.02, 0.02, 0.06 * rng.uniform(3, 10)])
        seen = np.array([[0, 0, 5], [0, 0, 5] + gap]) + rng.standard_normal((2, 3)) * sd
        bodies = Bodies(seen, np.diag(np.tile(sd**2, 2)), "drawn", ("a", "b"), (None, None), up=LEVEL_UP)
        distances = measure_distances(bodies)
        covered += distances.low_m[0, 1] <= radius <= distances.high_m[0, 1]
    assert 0.86 <= covered / count <= 0.97


def test_people_who_share_an_error_are_surer_of_their_distance():
    apart = bodies_at([(0, 0, 5), (1, 0, 5)], 0.2)
    shared = np.tile(np.eye(3), (2, 2)) * 0.2**2
    together = Bodies(apart.positions_m, shared, "drawn", ("a", "b"), (None, None), up=LEVEL_UP)
    loose, tight = measure_distances(apart), measure_distances(together)
    assert tight.high_m[0, 1] - tight.low_m[0, 1] < 1e-6 < loose.high_m[0, 1] - loose.low_m[0, 1]


def test_two_modes_widen_the_interval_to_both():
    near, far = [(0, 0, 5), (1, 0, 5)], [(0, 0, 5), (3, 0, 5)]
    tiny = np.eye(6) * 1e-8
    modes = (Mode(0.7, np.array(near, float), tiny), Mode(0.3, np.array(far, float), tiny))
    distances = measure_distances(bodies_at(near, 1e-4, modes=modes))
    assert distances.low_m[0, 1] == pytest.approx(1, abs=0.01)
    assert distances.high_m[0, 1] == pytest.approx(3, abs=0.01)
    assert distances.zone_probability[0, 1].tolist() == pytest.approx([0, 0.7, 0.3, 0], abs=0.01)


places = st.lists(st.tuples(st.floats(-5, 5), st.floats(-1, 1), st.floats(2, 20)), min_size=2, max_size=5, unique=True)


@given(places, st.floats(0.01, 1), st.data())
def test_order_of_people_and_mirroring_change_nothing(people, sd, data):
    order = data.draw(st.permutations(range(len(people))))
    plain = measure_distances(bodies_at(people, sd))
    permuted = measure_distances(bodies_at([people[i] for i in order], sd))
    mirrored = measure_distances(bodies_at([(-x, y, z) for x, y, z in people], sd))
    for name in ("distance_m", "low_m", "high_m"):
        expected = getattr(plain, name)
        assert getattr(permuted, name) == pytest.approx(expected[np.ix_(order, order)], nan_ok=True)
        assert getattr(mirrored, name) == pytest.approx(expected, nan_ok=True)


def test_a_crowds_pairs_are_taken_some_at_a_time_and_nothing_changes(monkeypatch):
    rng = np.random.default_rng(3)
    places = rng.uniform((-3, 0, 4), (3, 0, 9), (14, 3))
    modes = (Mode(0.7, places, np.eye(42) * 0.01), Mode(0.3, places + 0.4, np.eye(42) * 0.02))
    bodies = bodies_at(places, 0.2, heading=rng.uniform(-3, 3, 14), modes=modes)
    together = measure_distances(bodies)
    monkeypatch.setattr("proxemetry.draws._MOST_DRAWS", 3000)
    apart = measure_distances(bodies)
    for name in ("distance_m", "low_m", "high_m", "distance_3d_m", "zone_probability", "group_probability"):
        np.testing.assert_array_equal(getattr(apart, name), getattr(together, name))


@given(places, st.floats(0.01, 1))
def test_the_interval_is_ordered_and_zones_are_probabilities(people, sd):
    distances = measure_distances(bodies_at(people, sd))
    a, b = np.triu_indices(len(people), 1)
    assert (distances.low_m[a, b] <= distances.high_m[a, b]).all()
    assert distances.zone_probability[a, b].sum(axis=-1) == pytest.approx(np.ones(len(a)))


def test_who_is_not_placed_has_no_distance_and_keeps_the_row():
    bodies = bodies_at([(0, 0, 5), (math.nan,) * 3, (3, 0, 9)])
    distances = measure_distances(bodies)
    assert np.isnan(distances.distance_m[1]).all()
    assert distances.distance_m[0, 2] == pytest.approx(5)
    assert distances.zone(0, 1) is None
    assert distances.below(10) == 1


def test_a_pair_with_two_explanations_has_no_zone_and_is_vague():
    def mode(weight, apart_m):
        one = bodies_at([(0, 0, 5), (apart_m, 0, 5)], sd=0.02)
        return Mode(weight, one.positions_m, one.covariance_m2)

    near, far = mode(0.4, 0.3), mode(0.6, 3.0)
    both = replace(bodies_at([(0, 0, 5), (0.3, 0, 5)], sd=0.02), method="scene", modes=(near, far))
    distances = measure_distances(both)
    assert distances.distance_m[0, 1] < 0.457  # an error of the short answer costs ten times as much
    assert distances.zone_probability[0, 1].tolist() == pytest.approx([0.4, 0, 0.6, 0], abs=0.01)
    assert distances.zone(0, 1) == UNCERTAIN
    assert distances.vague(0, 1)
    sure = measure_distances(replace(both, modes=()))
    assert sure.zone(0, 1) == "intimate"
    assert not sure.vague(0, 1)


@pytest.mark.parametrize(
    ("metres", "zone"),
    [(0, "intimate"), (0.456, "intimate"), (0.457, "personal"), (1.219, "social"), (3.7, "public"), (math.nan, None)],
)
def test_halls_zones(metres, zone):
    assert zone_of(metres) == zone
    assert zone is None or zone in ZONES


def test_nobody_and_one_person():
    for count in (0, 1):
        distances = measure_distances(bodies_at([(0, 0, 5)] * count))
        assert distances.distance_m.shape == (count, count)
        assert distances.pairs() == []


def facing(places, headings):
    return measure_distances(bodies_at(places, 0.02, heading=headings)).group_probability


def test_two_people_face_to_face_form_a_group_and_back_to_back_do_not():
    pair = [(-0.6, 0, 5), (0.6, 0, 5)]
    inwards, outwards = [math.pi / 2, -math.pi / 2], [-math.pi / 2, math.pi / 2]
    assert facing(pair, inwards)[0, 1] > 0.95
    assert facing(pair, outwards)[0, 1] < 0.05


def test_beyond_two_metres_nobody_forms_a_group():
    assert facing([(-1.5, 0, 5), (1.5, 0, 5)], [math.pi / 2, -math.pi / 2])[0, 1] == 0


def test_a_third_person_in_the_middle_ends_the_group():
    trio = [(-0.6, 0, 5), (0.6, 0, 5), (0, 0, 5)]
    assert facing(trio, [math.pi / 2, -math.pi / 2, 0.0])[0, 1] < 0.05


def test_without_headings_groups_are_unknown():
    assert np.isnan(measure_distances(bodies_at([(0, 0, 5), (1, 0, 5)])).group_probability).all()


@pytest.mark.parametrize(("aside_m", "forms"), [(0.6, False), (0.95, False), (1.05, True)])
def test_a_third_person_within_the_radius_about_the_centre_disturbs_a_group(aside_m, forms):
    # 2.2 m apart only the radius of 1 m brings two who face each other together (Bertoni et al. 2021, eqs. 6-8)
    a, b = np.array([0 + 0j]), np.array([2.2 + 0j])
    facing = np.array([[1 + 0j], [-1 + 0j]])
    assert face_each_other(a, b, facing, np.array([1.1 + 1j * aside_m]))[0] == forms


@pytest.mark.parametrize(("aside_m", "forms"), [(0.25, False), (0.35, True), (0.45, True)])
def test_the_third_persons_distance_is_compared_with_the_radius_itself(aside_m, forms):
    # 1 m apart the radii of 0.3 and 0.5 m bring the two together; beyond 0.3 m the smaller is undisturbed
    a, b, facing_ = np.array([0 + 0j]), np.array([1.0 + 0j]), np.array([[1 + 0j], [-1 + 0j]])
    assert face_each_other(a, b, facing_, np.array([0.5 + 1j * aside_m]))[0] == forms


def test_a_groups_probability_is_that_of_a_gap_within_reach():
    """Two who face each other along x are a group from 0.4 to 2 m: of a gap of 1.8 +- 0.2 m in Phi(1) = 84 %."""
    pair = bodies_at([(-0.9, 0, 5), (0.9, 0, 5)], heading=[math.pi / 2, -math.pi / 2])
    spread = np.zeros((6, 6))
    spread[0, 0] = spread[3, 3] = 0.2**2 / 2
    uncertain = replace(pair, covariance_m2=spread, heading_sd_rad=np.full(2, 1e-6))
    assert measure_distances(uncertain).group_probability[0, 1] == pytest.approx(0.841, abs=0.03)


@pytest.mark.parametrize("turned_deg", [0, 30, 90, 135, 250])
def test_where_on_the_ground_two_stand_does_not_matter_to_whether_they_are_a_group(turned_deg):
    """The 84 % from above with all turned about the first: nobody is only ever side by side before a camera."""
    turn = math.radians(turned_deg)
    along = np.array([math.cos(turn), 0.0, math.sin(turn)])
    facing_along = math.atan2(along[0], -along[2])  # a heading of 0 faces the camera, 90 degrees the photo's right
    pair = bodies_at([(0, 0, 9), 1.8 * along + (0, 0, 9)], heading=[facing_along, facing_along + math.pi])
    own = np.outer(along, along) * 0.2**2 / 2
    spread = np.block([[own, np.zeros((3, 3))], [np.zeros((3, 3)), own]])
    uncertain = replace(pair, covariance_m2=spread, heading_sd_rad=np.full(2, 1e-6))
    assert measure_distances(uncertain).group_probability[0, 1] == pytest.approx(0.841, abs=0.03)


def test_who_has_no_place_or_no_heading_is_in_no_group_and_in_nobodys_way():
    trio = bodies_at([(-0.6, 0, 5), (0.6, 0, 5), (0, 0, 5.9)], 0.02, heading=[math.pi / 2, -math.pi / 2, 0.0])
    whole = measure_distances(trio).group_probability
    unplaced = np.array([[-0.6, 0, 5], [0.6, 0, 5], [math.nan] * 3])
    for lacking in (
        replace(trio, heading_rad=np.array([math.pi / 2, -math.pi / 2, math.nan])),
        replace(trio, heading_sd_rad=np.array([0.05, 0.05, math.nan])),
        replace(trio, positions_m=unplaced),
    ):
        found = measure_distances(lacking).group_probability
        assert found[0, 1] == pytest.approx(whole[0, 1]) and whole[0, 1] > 0.95
        assert np.isnan(found[2]).all() and np.isnan(found[:, 2]).all()


def test_a_third_person_is_in_the_way_of_a_wide_group_from_as_far_as_its_radius_reaches():
    """0.9 m apart with both looking ahead, only the radius of 1 m brings them together, about a place 1 m ahead."""
    pair, ahead = [(-0.45, 0, 5), (0.45, 0, 5)], [0.0, 0.0]  # towards the camera
    assert facing(pair, ahead)[0, 1] > 0.95
    assert facing([*pair, (0, 0, 3.2)], [*ahead, 0.0])[0, 1] < 0.05  # 0.8 m beyond that place
    assert facing([*pair, (0, 0, 2.8)], [*ahead, 0.0])[0, 1] > 0.95  # 1.2 m


@given(st.integers(0, 10**6))
def test_the_covariance_of_a_gap_counts_both_cross_terms(seed):
    root = np.random.default_rng(seed).normal(size=(9, 9))
    joint, minus = root @ root.T, np.hstack([np.eye(3), np.zeros((3, 3)), -np.eye(3)])
    gap = pair_covariance(joint, np.array([0]), np.array([2]))[0]
    assert gap == pytest.approx(minus @ joint @ minus.T)
