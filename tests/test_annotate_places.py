"""Places from tapes and coordinates: closed forms, laws, honest uncertainty, and what cannot be told."""

import itertools
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from proxemetry.annotate.places import MOST_TAGS, Places, Spot, Tape, solve
from proxemetry.annotate.places.ambiguity import _reflected
from proxemetry.annotate.places.contradiction import chi2_bound
from proxemetry.annotate.places.layout import laid_out
from proxemetry.annotate.places.network import Network
from proxemetry.annotate.places.solution import _fits
from proxemetry.errors import SettingsError

SQUARE = {"P0": (0.0, 0.0), "P1": (2.0, 0.0), "P2": (2.0, 2.0), "P3": (0.0, 2.0)}
#: KORTE's outdoor shoot (Seker et al. 2021, figure 2), metres.
OUTDOOR = {
    "C0": (0, 0), "C1": (-0.6, 12), "P0": (-1.2, 1.2), "P1": (0, 2.4), "P2": (-1.2, 4.8), "P3": (-1.8, 6),
    "P4": (-2.4, 6), "P5": (-3, 4.8),
}  # fmt: skip


def apart(places, a, b):
    return math.dist(places[a], places[b])


def taped(places, pairs=None, noise_m=0.0, seed=0, sd_m=0.01):
    random = np.random.default_rng(seed)
    pairs = pairs or list(itertools.combinations(places, 2))
    return [Tape(a, b, apart(places, a, b) + random.normal(0, noise_m) if noise_m else apart(places, a, b), sd_m)
            for a, b in pairs]  # fmt: skip


def solved(places: Places, a: str, b: str) -> float:
    return float(places.distance_m[places.tags.index(a), places.tags.index(b)])


# Closed forms


def test_a_measurements_rows_are_those_of_its_residuals():
    """Two tapes and three coordinates: rows 0 and 1, then two for each coordinate."""
    tapes = (Tape("P0", "P1", 2.0, 0.01), Tape("P1", "P2", 2.0, 0.02))
    spots = tuple(Spot(tag, *SQUARE[tag]) for tag in ("P0", "P2", "P3"))
    network = Network(tuple(SQUARE), tapes, spots)
    assert [network.rows(m) for m in network.measurements] == [[0], [1], [2, 3], [4, 5], [6, 7]]
    off = np.array(list(SQUARE.values()), float)
    off[3] += (0.3, -0.2)  # the mark of the third coordinate alone
    residuals = network.residuals(off.ravel())
    assert residuals[[6, 7]] * network._spot_sd[2] == pytest.approx([-0.3, 0.2])
    assert np.delete(residuals, [6, 7]) == pytest.approx(0, abs=1e-9)
    # of a coordinate's two the larger stands for it, whichever way it errs
    for sign in (1, -1):
        off[3] = np.add(SQUARE["P3"], (0.3 * sign, -0.2 * sign))
        assert _fits(network, off, network.measurements)[4].residual_m == pytest.approx(-0.3 * sign)


@pytest.mark.parametrize(
    ("pairs", "ways"), [([(0, 1), (1, 2), (2, 3), (3, 0)], 4), ([*itertools.combinations(range(4), 2)], 3)]
)
def test_what_may_move_is_a_shift_a_turn_and_what_no_tape_holds(pairs, ways):
    """Four bars have a bend besides; with both diagonals they have none. Nothing changes at first order."""
    tags = tuple(SQUARE)
    network = Network(tags, tuple(taped(SQUARE, [(tags[a], tags[b]) for a, b in pairs])), ())
    at = np.array(list(SQUARE.values()), float)
    directions = network.null_directions(at)
    assert directions.shape == (ways, 4, 2)
    for direction in directions:
        assert network.residuals((at + 1e-6 * direction).ravel()) == pytest.approx(0, abs=1e-6)
    assert Network(tags, network.tapes, (Spot("P0", 0, 0), Spot("P1", 2, 0))).null_directions(at).shape[0] == ways - 3


@given(st.floats(0, 2 * math.pi), st.booleans())
@settings(max_examples=10)
def test_without_coordinates_places_look_from_the_first_camera_to_the_others(turn, mirror):
    """However measured: y runs from it to the middle of the others, the first mark beside that lies to the right."""
    cos, sin = math.cos(turn), math.sin(turn)
    moved = {tag: ((-x if mirror else x) * cos - y * sin, (-x if mirror else x) * sin + y * cos)
             for tag, (x, y) in OUTDOOR.items()}  # fmt: skip
    found, plain = solve([], taped(moved), []), solve([], taped(OUTDOOR), [])
    assert found.positions_m == pytest.approx(plain.positions_m, abs=1e-5)
    assert found.by_tag["C0"] == pytest.approx((0, 0), abs=1e-9)
    middle = found.positions_m.mean(axis=0)
    assert middle[0] == pytest.approx(0, abs=1e-6) and middle[1] > 0
    aside = [x for x in found.positions_m[:, 0] if abs(x) > 0.02]
    assert aside[0] > 0


def test_a_layout_begins_on_the_coordinates():
    spots = tuple(Spot(tag, x + 20, 7 - y) for tag, (x, y) in SQUARE.items() if tag != "P3")
    network = Network(tuple(SQUARE), tuple(taped(SQUARE)), spots)
    assert network.start() == pytest.approx(np.array([(x + 20, 7 - y) for x, y in SQUARE.values()]), abs=1e-6)


def test_a_right_triangle_closes():
    found = solve([], [Tape("P0", "P1", 3), Tape("P0", "P2", 5)], [Spot("P1", 0, 0), Spot("P2", 0, 4)])
    assert found.by_tag["P0"] == pytest.approx((3, 0), abs=1e-6) or found.by_tag["P0"] == pytest.approx(
        (-3, 0), abs=1e-6
    )
    assert found.mirrored and found.reasons == (None, None, None)


def test_two_tapes_average_into_a_third():
    """Three marks in a line: 1 + 1 against 2.03 leaves 1 cm of misfit for each tape, all alike."""
    found = solve([], [Tape("P0", "P1", 1), Tape("P1", "P2", 1), Tape("P0", "P2", 2.03)], [])
    assert solved(found, "P0", "P2") == pytest.approx(2.02, abs=1e-4)
    assert [fit.residual_m for fit in found.fits] == pytest.approx([-0.01, -0.01, 0.01], abs=1e-4)


def test_a_tape_alone_is_as_uncertain_as_it_is_stated():
    found = solve([], [Tape("P0", "P1", 3.2, 0.02)], [])
    assert solved(found, "P0", "P1") == pytest.approx(3.2) and found.distance_sd_m[0, 1] == pytest.approx(0.02)
    assert not found.fits[0].checked


def test_coordinates_alone_are_taken_as_they_are():
    found = solve([], [], [Spot("C0", 0, 0, 0.01), Spot("P0", 3, 4, 0.01)])
    assert found.by_tag["C0"] == pytest.approx((0, 0), abs=1e-9) and found.by_tag["P0"] == pytest.approx((3, 4))
    assert solved(found, "C0", "P0") == pytest.approx(5)
    assert found.distance_sd_m[0, 1] == pytest.approx(0.01 * math.sqrt(2))


def test_a_point_of_a_tape_halves_where_two_pull():
    """A mark typed at 0 and taped at 1.02 m from a mark typed at 1: the three errors of 1 cm share the 2 cm."""
    found = solve([], [Tape("P0", "P1", 1.03)], [Spot("P0", 0, 0), Spot("P1", 1, 0)])
    assert solved(found, "P0", "P1") == pytest.approx(1.02, abs=1e-6)


@pytest.mark.parametrize(("spots", "free"), [(0, 0), (1, 0), (2, 1), (3, 3)])
def test_how_many_measurements_are_beyond_the_needed(spots, free):
    """Three marks, three tapes: a triangle floats by 3, turns about one coordinate, and is checked by two and more."""
    triangle = {"P0": (0.0, 0.0), "P1": (3.0, 0.0), "P2": (0.0, 4.0)}
    assert solve([], taped(triangle), [Spot(t, *triangle[t]) for t in list(triangle)[:spots]]).free == free


def test_the_first_layout_is_exact_where_every_mark_is_taped_to_three():
    places = np.array(list(OUTDOOR.values()), dtype=float)
    links = [(a, b, float(np.linalg.norm(places[a] - places[b]))) for a, b in itertools.combinations(range(8), 2)]
    laid = laid_out(8, links)
    for a, b, metres in links:
        assert np.linalg.norm(laid[a] - laid[b]) == pytest.approx(metres, abs=1e-6)


# Laws

layouts = st.lists(st.tuples(st.integers(-30, 30), st.integers(-30, 30)), min_size=3, max_size=6, unique=True).map(
    lambda at: {f"P{k}": (x / 5, y / 5) for k, (x, y) in enumerate(at)}
)


@settings(max_examples=12)
@given(layouts)
def test_exact_tapes_give_back_every_distance(places):
    found = solve([], taped(places), [])
    for a, b in itertools.combinations(places, 2):
        assert solved(found, a, b) == pytest.approx(apart(places, a, b), abs=2e-3)
    assert found.contradiction is None and found.scale == pytest.approx(1)


@settings(max_examples=8)
@given(layouts, st.floats(-3, 3), st.booleans(), st.integers(0, 5))
def test_turning_shifting_mirroring_and_order_change_no_distance(places, turn, mirror, seed):
    random = np.random.default_rng(seed)
    sine, cosine = math.sin(turn), math.cos(turn)
    moved = {t: (cosine * x - sine * y + 7, (sine * x + cosine * y) * (-1 if mirror else 1) - 4)
             for t, (x, y) in places.items()}  # fmt: skip
    tapes = taped(places, noise_m=0.01, seed=seed)
    first, second = (solve([], tapes, [Spot(t, *where[t]) for t in list(places)[:3]]) for where in (places, moved))
    shuffled = solve([], [tapes[k] for k in random.permutation(len(tapes))],
                     [Spot(t, *places[t]) for t in list(places)[:3]])  # fmt: skip
    for a, b in itertools.combinations(places, 2):
        assert solved(second, a, b) == pytest.approx(solved(first, a, b), abs=2e-3)
        assert solved(shuffled, a, b) == pytest.approx(solved(first, a, b), abs=2e-3)


@settings(max_examples=20)
@given(layouts, st.integers(0, 99))
def test_derivatives_are_those_of_the_residuals(places, seed):
    tags = tuple(places)
    network = Network(tags, tuple(taped(places, sd_m=0.02)), (Spot(tags[0], 1, 2, 0.03),))
    at = np.array(list(places.values()), dtype=float).ravel() + np.random.default_rng(seed).normal(
        0, 0.1, 2 * len(tags)
    )
    if min(math.dist(a, b) for a, b in itertools.combinations(at.reshape(-1, 2), 2)) < 0.05:
        return  # two marks in one place have no direction to each other
    step = 1e-6
    numeric = np.stack(
        [(network.residuals(at + e) - network.residuals(at - e)) / (2 * step) for e in step * np.eye(len(at))], axis=1
    )
    assert network.derivatives(at) == pytest.approx(numeric, abs=1e-3)


def test_stated_uncertainty_is_what_errors_are():
    """Over 25 simulated tapings the errors of the solved distances match their stated sd, and average to 0."""
    z = []
    for seed in range(25):
        found = solve([], taped(OUTDOOR, noise_m=0.02, seed=seed, sd_m=0.02), [])
        assert found.scale < 2
        for a, b in itertools.combinations(OUTDOOR, 2):
            sd = found.distance_sd_m[found.tags.index(a), found.tags.index(b)] / found.scale
            z.append((solved(found, a, b) - apart(OUTDOOR, a, b)) / sd)
    assert np.std(z) == pytest.approx(1, abs=0.12) and abs(np.mean(z)) < 0.12


def test_a_tape_twice_as_loose_makes_distances_twice_as_uncertain():
    tight, loose = (solve([], taped(OUTDOOR, sd_m=sd), []) for sd in (0.01, 0.02))
    assert loose.distance_sd_m == pytest.approx(2 * tight.distance_sd_m, rel=1e-4)


def test_errors_larger_than_stated_widen_the_uncertainty():
    stated = solve([], taped(OUTDOOR, noise_m=0.05, seed=3, sd_m=0.05), [])
    wishful = solve([], taped(OUTDOOR, noise_m=0.05, seed=3, sd_m=0.01), [])
    assert wishful.scale == pytest.approx(5 * stated.scale, rel=0.35)
    assert np.nanmax(wishful.distance_sd_m) == pytest.approx(np.nanmax(stated.distance_sd_m), rel=0.35)


# What cannot be told is said


def test_a_mark_on_two_tapes_has_two_places():
    pairs = [("P0", "P1"), ("P1", "P2"), ("P2", "P3"), ("P3", "P0"), ("P0", "P2")]
    found = solve([], taped(SQUARE, pairs), [])
    ((tag, reason),) = [(t, r) for t, r in zip(found.tags, found.reasons, strict=True) if r]
    other = {"P1": "P3", "P3": "P1"}[tag]
    assert "mirror images" in reason and f"tape it to {other}" in reason
    assert math.isnan(solved(found, "P1", "P3")) and tag not in found.by_tag
    again = solve([], [*taped(SQUARE, pairs), Tape("P1", "P3", math.sqrt(8))], [])
    assert again.reasons == (None,) * 4


def test_a_mirror_image_that_changes_no_distance_is_no_ambiguity():
    assert solve([], taped(SQUARE), []).mirrored
    spots = [Spot("P0", 0, 0), Spot("P1", 2, 0), Spot("P2", 2, 2)]
    assert not solve([], taped(SQUARE), spots).mirrored


def test_four_bars_bend():
    found = solve([], taped(SQUARE, [("P0", "P1"), ("P1", "P2"), ("P2", "P3"), ("P3", "P0")]), [])
    assert sum(reason is None for reason in found.reasons) == 2
    assert any("several places fit" in (reason or "") for reason in found.reasons)


def test_a_mark_on_one_tape_or_none_says_so():
    found = solve(["P8"], [*taped(SQUARE), Tape("P0", "P9", 1.5)], [])
    reasons = dict(zip(found.tags, found.reasons, strict=True))
    assert "one tape alone, to P0" in reasons["P9"] and "nothing was measured" in reasons["P8"]
    assert sorted(found.by_tag) == sorted(SQUARE)


def test_groups_that_nothing_links_are_not_put_together():
    found = solve([], [*taped(SQUARE), Tape("P7", "P8", 1)], [])
    assert "no tape links it with P0" in dict(zip(found.tags, found.reasons, strict=True))["P7"]


def test_marks_in_a_row_are_determined():
    row = {"P0": (0.0, 0.0), "P1": (0.9, 0.0), "P2": (2.4, 0.0), "P3": (5.0, 0.0)}
    found = solve([], taped(row), [])
    assert found.reasons == (None,) * 4 and solved(found, "P0", "P3") == pytest.approx(5.0, abs=1e-3)


def test_nothing_measured_has_no_place():
    found = solve(["P0", "P1"], [], [])
    assert found.by_tag == {} and all(found.reasons)


# Gross errors


@pytest.mark.parametrize("by_m", [0.3, -0.5, 9.0])
def test_a_misread_tape_is_pointed_at_with_what_the_others_say(by_m):
    tapes = taped(OUTDOOR, noise_m=0.01, seed=5)
    wrong = next(k for k, t in enumerate(tapes) if t.ends == {"P1", "P4"})
    tapes[wrong] = Tape("P1", "P4", tapes[wrong].metres + by_m)
    found = solve([], tapes, [])
    assert found.contradiction is not None and found.contradiction.settled
    (suspect,) = found.contradiction.suspects
    assert suspect.measurement is tapes[wrong]
    assert suspect.expected_m == pytest.approx(apart(OUTDOOR, "P1", "P4"), abs=0.03)
    assert abs(suspect.expected_m - apart(OUTDOOR, "P1", "P4")) < 4 * suspect.expected_sd_m


def test_a_small_slip_in_a_well_taped_shoot_is_found_by_its_own_residual():
    """6 cm on one of 28 tapes: their sum of squares is as usual, that one residual is 4 of its own deviations."""
    tapes = taped(OUTDOOR)
    wrong = next(k for k, t in enumerate(tapes) if t.ends == {"P1", "P4"})
    tapes[wrong] = Tape("P1", "P4", tapes[wrong].metres + 0.06)
    found = solve([], tapes, [])
    assert sum((f.residual_m / 0.01) ** 2 for f in found.fits) < chi2_bound(found.free)
    assert found.contradiction is not None
    assert [s.measurement for s in found.contradiction.suspects] == [tapes[wrong]]
    assert max(found.fits, key=lambda f: abs(f.z)).measurement is tapes[wrong]


def test_a_mistyped_coordinate_is_pointed_at():
    spots = [Spot(t, *OUTDOOR[t]) for t in ("C0", "P0", "P1", "P2")]
    spots[2] = Spot("P1", 0, 4.2)  # for 2.4
    found = solve([], taped(OUTDOOR, noise_m=0.005, seed=6), spots)
    assert found.contradiction is not None
    assert [s.measurement for s in found.contradiction.suspects] == [spots[2]]


def test_where_nothing_tells_which_is_wrong_all_are_named():
    """Six tapes of four marks hold one check: any of them may be the wrong one."""
    tapes = taped(SQUARE, noise_m=0.003, seed=1)
    tapes[2] = Tape("P0", "P3", 3.0)
    found = solve([], tapes, [])
    assert found.contradiction is not None
    assert {s.measurement for s in found.contradiction.suspects} == set(tapes)
    told = next(s for s in found.contradiction.suspects if s.measurement is tapes[2])
    assert told.expected_m == pytest.approx(2.0, abs=0.06)


def test_two_misread_tapes_are_both_found():
    tapes = taped(OUTDOOR, noise_m=0.005, seed=8)
    wrong = [k for k, t in enumerate(tapes) if t.ends in ({"P0", "P3"}, {"C1", "P5"})]
    for k in wrong:
        tapes[k] = Tape(tapes[k].a, tapes[k].b, tapes[k].metres + 0.6)
    found = solve([], tapes, [])
    assert found.contradiction is not None and found.contradiction.settled
    assert {id(s.measurement) for s in found.contradiction.suspects} == {id(tapes[k]) for k in wrong}


def test_right_tapes_are_seldom_accused():
    """Each of 28 residuals exceeds 3.29 sd once in a thousand: 0.8 of 30 tapings are expected to be accused."""
    accused = sum(solve([], taped(OUTDOOR, noise_m=0.01, seed=s), []).contradiction is not None for s in range(30))
    assert accused <= 4


@pytest.mark.parametrize(("freedom", "bound"), [(1, 10.83), (2, 13.82), (10, 29.59), (30, 59.70)])
def test_the_bound_is_that_of_the_chi_squared_table(freedom, bound):
    assert chi2_bound(freedom) == pytest.approx(bound, rel=0.02)


# What is refused


@pytest.mark.parametrize("metres", [math.nan, math.inf, -1, 0, 5000, 1e308])
def test_what_no_tape_says_is_refused(metres):
    with pytest.raises(SettingsError, match="P0 to P1"):
        Tape("P0", "P1", metres)


@pytest.mark.parametrize("value", [math.nan, -math.inf, 1e9])
def test_what_is_no_coordinate_is_refused(value):
    with pytest.raises(SettingsError, match="P0"):
        Spot("P0", 0, value)


def test_a_mark_is_not_taped_to_itself_nor_twice_nor_without_end():
    with pytest.raises(SettingsError, match="between two marks"):
        Tape("P0", "P0", 1)
    with pytest.raises(SettingsError, match="two tapes"):
        solve([], [Tape("P0", "P1", 1), Tape("P1", "P0", 1)], [])
    with pytest.raises(SettingsError, match="two coordinates"):
        solve([], [], [Spot("P0", 1, 1), Spot("P0", 1, 1)])
    with pytest.raises(SettingsError, match="more than"):
        solve([f"P{k}" for k in range(MOST_TAGS + 1)], [], [])


@given(st.integers(0, 10**6))
def test_a_part_is_mirrored_over_the_line_through_two_marks(seed):
    """As far from both marks as before, on the other side; the rest stays, and twice is not at all."""
    at = np.random.default_rng(seed).normal(0, 5, (5, 2))
    mirrored = _reflected(at, (0, 3), [1, 4])
    assert mirrored[[0, 2, 3]].tolist() == at[[0, 2, 3]].tolist()
    for k in (1, 4):
        for mark in (0, 3):
            assert math.dist(mirrored[k], at[mark]) == pytest.approx(math.dist(at[k], at[mark]))
        side = [(at[3] - at[0])[0] * (p - at[0])[1] - (at[3] - at[0])[1] * (p - at[0])[0] for p in (at[k], mirrored[k])]
        assert side[1] == pytest.approx(-side[0], rel=1e-6, abs=1e-6)
    assert _reflected(mirrored, (0, 3), [1, 4]) == pytest.approx(at)
