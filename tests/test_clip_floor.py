"""Groups, densities and maps: against closed forms and laws."""

import itertools
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from proxemetry.clip.density import (
    Maps,
    Region,
    classic_density,
    personal_space_m2,
    signed_area,
    voronoi_cells,
    voronoi_density,
)  # fmt: skip
from proxemetry.clip.groups import FITTED, adjusted, features, group_probabilities, groups_of, predicted, together
from proxemetry.clip.sightings import Chain, Sightings
from proxemetry.clip.smoothing import smooth

SQUARE = Region(np.array([[0.0, 0], [10, 0], [10, 10], [0, 10]]))


def paths_of(places, step=0.2):
    times = np.arange(len(places)) * step
    shot = [Sightings.of_places(t, p, 0.05) for t, p in zip(times, places, strict=True)]
    frames = np.arange(len(times))
    count = places.shape[1]
    return [smooth(Chain(frames, np.full(len(frames), k)), shot, times, number=k + 1) for k in range(count)]


def street(*people, frames=60, step=0.2):
    """People as (x, y, vx) who walk along a street."""
    t = np.arange(frames) * step
    return np.stack([np.stack([x + v * t, np.full(frames, float(y))], axis=1) for x, y, v in people], axis=1)


def test_who_walks_side_by_side_is_together_and_who_passes_is_not():
    found = group_probabilities(paths_of(street((0, 0, 1.3), (0, 0.7, 1.3), (14, 0.3, -1.3), (0, 5, 1.3))))
    assert found[1, 2] > 0.9
    assert found.get((1, 3), 0.0) < 0.1 and found.get((2, 3), 0.0) < 0.1
    assert found.get((1, 4), 0.0) < 0.1


def test_followers_are_less_likely_companions_than_those_abreast():
    found = group_probabilities(paths_of(street((0, 0, 1.3), (0, 1.2, 1.3), (30, 0, 1.3), (31.2, 0, 1.3))))
    assert found[1, 2] > found[3, 4]


@settings(max_examples=4, deadline=None)
@given(st.floats(0, 6.28), st.booleans())
def test_groups_stay_when_the_floor_is_turned_or_the_clip_reversed(angle, reversed_):
    places = street((0, 0, 1.3), (0.2, 1.0, 1.25), (14, 0.3, -1.3))
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    other = (places[::-1] if reversed_ else places) @ turn.T
    one, two = group_probabilities(paths_of(places)), group_probabilities(paths_of(other))
    assert one.keys() == two.keys()
    assert all(two[k] == pytest.approx(one[k], abs=0.02) for k in one)


def test_companions_are_rarer_among_many_strangers():
    p = np.array([0.5] + [0.001] * 400)
    assert adjusted(p, 0.05)[0] < 0.1
    assert adjusted(np.full(50, 0.9), 0.05)[0] > 0.95


def test_one_doubtful_link_does_not_chain_two_groups():
    sure = dict.fromkeys([(1, 2), (1, 3), (2, 3), (4, 5), (4, 6), (5, 6)], 0.95)
    assert groups_of(range(1, 8), {**sure, (3, 4): 0.8}) == [[1, 2, 3], [4, 5, 6], [7]]
    assert groups_of([3, 1, 2], {(2, 3): 0.9}) == [[1], [2, 3]]
    assert groups_of([], {}) == []


def test_classic_density_counts_by_area():
    places = np.array([[1.0, 1], [5, 5], [11, 5]])
    assert classic_density(places, SQUARE) == pytest.approx(0.02)
    assert Region(SQUARE.corners_m[::-1]).area_m2 == pytest.approx(100)


def test_a_region_may_have_a_notch():
    notched = Region(np.array([[0.0, 0], [4, 0], [4, 4], [2, 1], [0, 4]]))
    assert notched.holds(np.array([[1.0, 1], [2, 3], [3.5, 2], [2, 0.5]])).tolist() == [True, False, True, True]


def test_cells_of_a_grid_are_its_squares():
    places = np.array(list(itertools.product(np.arange(0.5, 10), np.arange(0.5, 10))))
    assert personal_space_m2(places, SQUARE) == pytest.approx(np.ones(100))


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 10_000), st.integers(1, 30))
def test_cells_share_out_the_floor_and_hold_who_is_nearest(seed, count):
    rng = np.random.default_rng(seed)
    places = rng.uniform(0, 10, (count, 2))
    cells = voronoi_cells(places, SQUARE)
    assert sum(signed_area(c) for c in cells) == pytest.approx(100)
    probes = rng.uniform(0, 10, (200, 2))
    nearest = np.linalg.norm(probes[:, None] - places, axis=-1).argmin(axis=1)
    inside = np.stack([Region(c).holds(probes) for c in cells], axis=1)
    assert (inside[np.arange(200), nearest]).mean() > 0.98


def test_two_at_one_place_share_their_floor():
    assert personal_space_m2(np.array([[5.0, 5], [5, 5]]), SQUARE).sum() == pytest.approx(100)
    assert np.isnan(personal_space_m2(np.array([[50.0, 5]]), SQUARE)).all()
    assert personal_space_m2(np.zeros((0, 2)), SQUARE).shape == (0,)


def test_voronoi_density_of_even_crowds_is_the_classic_one_and_steadier():
    places = np.array(list(itertools.product(np.arange(0.5, 10), np.arange(0.5, 10))))
    middle = Region(np.array([[2.0, 2], [8, 2], [8, 8], [2, 8]]))
    assert voronoi_density(places, middle, SQUARE) == pytest.approx(1.0)
    shifted = places + (0.4, 0.0)
    assert abs(voronoi_density(shifted, middle, SQUARE) - 1.0) < abs(classic_density(places + 0.6, middle) - 1.0) + 0.02
    assert voronoi_density(places, middle) == classic_density(places, middle)


def test_who_is_outside_a_map_on_any_side_is_not_on_it():
    maps = Maps.over(SQUARE, 10.0, (1.0,))
    outside = np.array([[-0.1, 5], [10.1, 5], [5, -0.1], [5, 10.1], [10.1, 10.1]])
    maps.add_presence(outside, np.full(5, 5.0), np.ones(5))
    maps.add_exposure(outside, np.ones((5, 1)))
    assert maps.presence_s.sum() == 0 and maps.exposure_s.sum() == 0
    maps.add_presence(np.array([[0.05, 9.95]]), np.array([5.0]), np.array([2.0]))
    assert maps.presence_s[0, -1, 0] == 2.0  # the last row is the farthest along y


def test_maps_add_up_to_the_time_that_was_spent():
    maps = Maps.over(SQUARE, 60.0, (1.0, 2.0))
    t = np.arange(0, 60, 0.2)
    maps.add_presence(np.full((300, 2), 3.3), t, np.full(300, 0.2))
    maps.add_exposure(np.full((300, 2), 3.3), np.full((300, 2), 0.1))
    assert (maps.density() * maps.cell_m**2).sum() * maps.stretch_s == pytest.approx(60)
    assert (maps.risk() * maps.cell_m**2).sum(axis=(1, 2)) == pytest.approx([30, 30])
    row, column = np.argwhere(maps.density()[0] > 0)[0]
    assert maps.origin_m + maps.cell_m * np.array([column, row]) == pytest.approx([3.0, 3.0])
    assert len(Maps.over(SQUARE, 7200.0, (1.0,)).presence_s) == 60


def test_a_region_is_drawn_around_where_people_were():
    around = Region.around(np.array([[0.0, 0.0]]))
    assert around.area_m2 == pytest.approx(1.0)
    assert around.holds(np.array([[0.0, 0.0], [0.6, 0.0]])).tolist() == [True, False]


def test_thousands_of_tracks_are_grouped_as_few_are():
    few = {(1, 2): 0.9, (2, 3): 0.8, (1, 3): 0.1, (4, 5): 0.6, (3, 4): 0.45}
    assert groups_of(range(1, 7), few) == [[1, 2], [3], [4, 5], [6]]
    many = {(a + 10 * k, b + 10 * k): p for (a, b), p in few.items() for k in range(400)}
    found = groups_of([n + 10 * k for k in range(400) for n in range(1, 7)], many)
    assert found == [[n + 10 * k for n in g] for k in range(400) for g in ([1, 2], [3], [4, 5], [6])]


@pytest.mark.parametrize(("apart", "in_file"), [((1.2, 0.0), 1.2), ((0.0, 1.2), 0.0), ((0.9, 1.2), 0.9)])
def test_what_two_walkers_are_described_by_is_as_by_hand(apart, in_file):
    """Both walk along x at 1.3 m/s for six seconds, so far apart along it and across it."""
    (one, other) = paths_of(street((0, 0, 1.3), (*apart, 1.3), frames=31))
    pair = together(one, other)
    steady = np.tile([1.3, 0.0], (31, 1))
    x = 1.3 * pair.t_s
    exact = replace(
        pair, a_m=np.stack([x, 0 * x], axis=1), b_m=np.stack([x, 0 * x], axis=1) + apart, a_m_s=steady, b_m_s=steady
    )
    expected = [np.log(np.hypot(*apart)), np.log(0.05), np.log(0.2 + in_file), np.log(6.0), 1.3]
    assert features(exact) == pytest.approx(expected, abs=1e-6)


def test_two_walkers_are_described_alike_whichever_comes_first():
    """Of different speeds and courses too: what lies ahead is where both go on average."""
    rng = np.random.default_rng(6)
    (one, other) = paths_of(street((0, 0, 1.3), (0.4, 1.1, 0.9), frames=31) + rng.normal(0, 0.02, (31, 2, 2)))
    there, back = together(one, other), together(other, one)
    turned = replace(there, a_m_s=there.a_m_s + (0.0, 0.8)), replace(back, b_m_s=back.b_m_s + (0.0, 0.8))
    assert features(there) == pytest.approx(features(back))
    assert features(turned[0]) == pytest.approx(features(turned[1]))
    assert features(turned[0])[2] != pytest.approx(features(there)[2], abs=0.01)


@pytest.mark.parametrize("k", range(5))
def test_the_model_is_a_logistic_regression_on_standardised_features(k):
    mean, sd, weights = (np.array(v) for v in (FITTED.mean, FITTED.sd, FITTED.weights))
    unit = np.eye(5)[k]
    for steps in (-1.0, 0.0, 2.0):
        (probability,) = predicted((mean + steps * unit * sd)[None], FITTED)
        assert np.log(probability / (1 - probability)) == pytest.approx(weights[0] + steps * weights[1 + k])


def test_a_pair_of_which_one_is_not_asked_for_makes_no_group():
    assert groups_of([1, 2], {(2, 3): 0.9, (0, 1): 0.9}) == [[1], [2]]
