"""How long who was near whom: against closed forms and laws."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from proxemetry.clip.critical import _block_interval, _line, _prediction_low, critical_density, rate
from proxemetry.clip.events import events_of
from proxemetry.clip.exposure import TotalExposure, pairs_over_time, same_group, weights_s
from proxemetry.clip.nearness import nearness
from proxemetry.clip.sightings import Chain, Sightings
from proxemetry.clip.smoothing import smooth

STEP = 0.2


def paths_of(places, step=STEP, sd=0.02):
    times = np.arange(len(places)) * step
    shot = [Sightings.of_places(t, p, sd) for t, p in zip(times, places, strict=True)]
    frames = np.arange(len(times))
    return [
        smooth(Chain(frames, np.full(len(frames), k)), shot, times, number=k + 1) for k in range(places.shape[1])
    ], weights_s(times, step)


def side_by_side(apart, frames=50, speed=1.2):
    t = np.arange(frames) * STEP
    one = np.stack([speed * t, np.zeros(frames)], axis=1)
    return np.stack([one, one + (0, apart)], axis=1)


def test_frames_stand_for_the_time_around_them():
    assert weights_s(np.array([0.0, 0.2, 0.4]), 0.2) == pytest.approx([0.2, 0.2, 0.2])
    assert weights_s(np.array([0.0, 1.0, 4.0]), 1.0) == pytest.approx([1.0, 2.0, 2.0])
    assert weights_s(np.array([7.0]), 0.2) == pytest.approx([0.2])


@given(st.floats(0.1, 1.0), st.floats(0.2, 3.0))
def test_two_at_one_place_are_apart_as_rayleigh_says(sd, limit):
    found = nearness(np.zeros((1, 2)), sd**2 * np.eye(2)[None], [limit])
    assert found.p_within[0, 0] == pytest.approx(
        1 - np.exp(-(limit**2) / (2 * sd**2)), abs=0.012
    )  # 128 radii: steps of 0.008


def test_far_and_near_formulas_meet():
    spread = np.array([[0.04, 0.01], [0.01, 0.09]])
    edge = 10 * np.sqrt(0.13)
    gaps = np.array([[edge - 1e-3, 0.0], [edge + 1e-3, 0.0]])
    found = nearness(gaps, np.stack([spread] * 2), [edge, edge - 0.2])
    assert found.distance_m[0] == pytest.approx(found.distance_m[1], abs=0.01)
    assert found.low_m[0] == pytest.approx(found.low_m[1], abs=0.02)
    assert found.high_m[0] == pytest.approx(found.high_m[1], abs=0.02)
    assert found.p_within[0] == pytest.approx(found.p_within[1], abs=0.02)


def test_seconds_within_are_those_of_the_truth_where_nothing_is_noisy():
    paths, weight = paths_of(side_by_side(1.2))
    (pair,) = pairs_over_time(paths, weight, [0.7, 1.7, 2.0])  # far enough from 1.2 m for how bodies sway
    assert pair.seconds == pytest.approx([0.0, 10.0, 10.0], abs=0.05)
    low, high = pair.interval_s()
    assert (low <= pair.seconds).all() and (pair.seconds <= high).all()
    assert pair.closest_m == pytest.approx(1.2, abs=0.03)
    assert pair.closest_low_m <= pair.closest_m <= pair.closest_high_m


def test_half_of_the_time_is_near_at_exactly_the_limit():
    paths, weight = paths_of(side_by_side(2.0), sd=0.1)
    (pair,) = pairs_over_time(paths, weight, [2.0])
    assert pair.seconds[0] == pytest.approx(5.0, abs=0.5)
    low, high = pair.interval_s()
    assert high[0] - low[0] > 5  # one error a person for the whole clip: nearly all of it or nearly nothing


def test_noise_does_not_hide_contact():
    rng = np.random.default_rng(2)
    places = side_by_side(1.6, frames=150) + rng.normal(0, 0.4, (150, 2, 2))
    paths, weight = paths_of(places, sd=0.4)
    (pair,) = pairs_over_time(paths, weight, [2.0])
    raw = (np.linalg.norm(places[:, 0] - places[:, 1], axis=1) < 2.0).mean() * 30
    assert raw < 25  # counted frame by frame
    assert 26 < pair.seconds[0] <= 30.01


@settings(max_examples=10, deadline=None)
@given(st.floats(0, 6.28), st.booleans())
def test_seconds_stay_when_the_floor_is_turned_or_mirrored(angle, mirrored):
    places = side_by_side(1.5) + np.random.default_rng(4).normal(0, 0.1, (50, 2, 2))
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    other = places @ turn.T * ((-1, 1) if mirrored else (1, 1))
    (pair,), (turned,) = (list(pairs_over_time(*paths_of(p, sd=0.1), [1.5])) for p in (places, other))
    assert turned.seconds[0] == pytest.approx(pair.seconds[0], abs=0.05)
    assert turned.near.distance_m == pytest.approx(pair.near.distance_m, abs=0.01)


def test_half_the_frames_give_the_same_seconds():
    t = np.arange(101) * 0.1
    one = np.stack([1.2 * t, 0 * t], axis=1)
    two = np.stack([12 - 1.2 * t, 0 * t + 0.5], axis=1)
    places = np.stack([one, two], axis=1)
    (fine,) = pairs_over_time(*paths_of(places, step=0.1), [2.0])
    (coarse,) = pairs_over_time(*paths_of(places[::2], step=0.2), [2.0])
    truth = 2 * np.sqrt(2.0**2 - 0.5**2) / 2.4
    assert fine.seconds[0] == pytest.approx(truth, abs=0.08)
    assert coarse.seconds[0] == pytest.approx(truth, abs=0.12)


def test_an_error_of_the_camera_is_shared_by_all():
    paths, weight = paths_of(side_by_side(1.5))
    shifted = list(pairs_over_time(paths, weight, [1.5], lambda p: np.broadcast_to(np.eye(2), (len(p), 2, 2))))
    (plain,) = pairs_over_time(paths, weight, [1.5])
    assert shifted[0].near.high_m == pytest.approx(plain.near.high_m)  # everyone moves alike: no distance changes
    (scaled,) = pairs_over_time(paths, weight, [1.5], lambda p: 0.1 * p[:, :, None])
    spread = (scaled.near.high_m - scaled.near.low_m) / 2
    own = (plain.near.high_m - plain.near.low_m) / 2
    # a tenth of scale is a tenth of every distance, besides what each has by itself
    assert spread[0] == pytest.approx(np.hypot(own[0], 1.645 * 0.15), rel=0.15)
    totals = TotalExposure(1)
    totals.add(scaled, 0.0)
    found = totals.totals()
    assert found.low_s[0] < 1 and found.high_s[0] > 9


def test_pairs_of_one_group_are_counted_apart():
    paths, weight = paths_of(np.concatenate([side_by_side(1.0), side_by_side(1.0) + (0, 3.0)], axis=1))
    totals = TotalExposure(1)
    for pair in pairs_over_time(paths, weight, [1.5]):
        totals.add(pair, 1.0 if (pair.a, pair.b) == (1, 2) else 0.0)
    found = totals.totals()
    assert found.seconds[0] == pytest.approx(20, abs=0.1)
    assert found.apart_seconds[0] == pytest.approx(10, abs=0.1)


@given(st.floats(0, 1))
def test_two_tracks_belong_together_whichever_is_named_first(probability):
    known = {(1, 2): probability}
    assert same_group(known, 1, 2) == same_group(known, 2, 1) == probability
    assert same_group(known, 1, 3) == 0.0


def test_an_event_has_a_beginning_an_end_and_a_minimum():
    t = np.arange(100) * STEP
    places = np.stack([np.zeros((100, 2)), np.stack([np.abs(t - 10) + 1.0, 0 * t], axis=1)], axis=1)
    (pair,) = pairs_over_time(*paths_of(places), [2.0, 3.0])
    near, wider = events_of(pair, [2.0, 3.0])
    assert near.begin_s == pytest.approx(9.0, abs=0.2)
    assert near.end_s == pytest.approx(11.3, abs=0.2)  # ends beyond 1.15 times the limit
    assert near.closest_m == pytest.approx(1.0, abs=0.3)
    assert near.closest_s == pytest.approx(10.0, abs=0.2)
    assert wider.seconds > near.seconds
    assert list(events_of(pair, [2.0], shortest_s=5.0)) == []


def test_an_events_ends_lie_half_way_to_the_frames_around_it():
    """Frames at 0.2, 0.6, 1, 2, 3 and 4 s, near in the third to the fifth; and one from the clip's beginning."""
    t_s = np.array([0.2, 0.6, 1.0, 2.0, 3.0, 4.0])
    weight_s = np.array([0.6, 0.4, 0.7, 1.0, 1.0, 1.0])
    distance = np.array([5.0, 4.0, 1.5, 1.2, 1.4, 5.0])
    p_within = np.array([[0, 0], [0, 0.1], [0.9, 1.0], [1.0, 1.0], [0.5, 1.0], [0, 0.0]])
    near = SimpleNamespace(distance_m=distance, p_within=p_within)
    (event, wider) = events_of(SimpleNamespace(a=3, b=7, t_s=t_s, weight_s=weight_s, near=near), [2.0, 3.0])
    assert (event.a, event.b, event.within_m) == (3, 7, 2.0) and wider.within_m == 3.0
    assert (event.begin_s, event.end_s, event.seconds) == pytest.approx((0.8, 3.5, 2.7))
    assert (event.closest_m, event.closest_s) == (1.2, 2.0)
    assert (event.p_within, wider.p_within) == pytest.approx((0.8, 1.0))
    near = SimpleNamespace(distance_m=np.full(6, 1.0), p_within=np.ones((6, 1)))
    (whole,) = events_of(SimpleNamespace(a=0, b=1, t_s=t_s, weight_s=weight_s, near=near), [2.0])
    assert (whole.begin_s, whole.end_s) == pytest.approx((0.0, 4.5))  # no earlier than the clip


def test_wavering_about_the_limit_is_one_event():
    wave = 2.0 + 0.1 * np.sin(np.arange(100))
    places = np.stack([np.zeros((100, 2)), np.stack([wave, np.zeros(100)], axis=1)], axis=1)
    (pair,) = pairs_over_time(*paths_of(places, sd=0.01), [2.0])
    assert len(list(events_of(pair, [2.0]))) == 1


def test_the_critical_density_is_the_intercept():
    rng = np.random.default_rng(0)
    t = np.arange(0, 300, 0.5)
    near = rng.poisson(3, len(t)).astype(float)
    density = 0.15 + 0.02 * near + rng.normal(0, 0.01, len(t))
    found = critical_density(density, near, t)
    assert found.reason is None
    assert found.intercept == pytest.approx(0.15, abs=0.005)
    assert found.low - 0.002 < 0.15 < found.high + 0.002
    assert found.prediction_low == pytest.approx(found.intercept - 1.96 * 0.01, abs=0.003)


@pytest.mark.parametrize(
    ("density", "near", "seconds", "said"),
    [
        (lambda n, e: 0.15 + 0.02 * n + 0.2 * e, lambda e: e % 4, 300, "prediction interval"),
        (lambda n, e: 0.15 + 0 * n, lambda e: 0 * e, 300, "no two people came within"),
        (lambda n, e: 0.15 + 0.02 * n, lambda e: e % 3, 30, "stretches of 10 s"),
        (lambda n, e: 0.35 - 0.02 * n, lambda e: e % 3, 300, "does not grow"),
    ],
)
def test_a_critical_density_without_meaning_is_refused(density, near, seconds, said):
    t = np.arange(0, seconds, 0.5)
    violations = near(np.arange(len(t))).astype(float)
    noise = np.random.default_rng(1).normal(0, 1, len(t))
    assert said in (critical_density(density(violations, noise), violations, t).reason or "")


def test_rates_vary_from_stretch_to_stretch_not_from_frame_to_frame():
    t = np.arange(0, 200, 0.1)
    bursts = ((t // 10) % 4 == 0).astype(float)
    found = rate(bursts, np.ones_like(bursts), t)
    assert found.value == pytest.approx(0.25)
    assert found.high - found.low > 0.2  # of twenty stretches; independent frames would say 0.03


@pytest.mark.parametrize("same", [0.0, 0.3, 1.0])
def test_pairs_of_one_group_are_left_out_as_often_as_they_are_one(same):
    """Of many pairs 1.2 m apart the share that are strangers counts; of none or all that are, exactly none or all."""
    (pair,) = pairs_over_time(*paths_of(side_by_side(1.2)), [2.0])
    totals = TotalExposure(1)
    for k in range(100):
        totals.add(replace(pair, a=k, b=k + 1), same)
    found = totals.totals()
    share = np.array([found.apart_seconds, found.apart_low_s, found.apart_high_s])[:, 0] / found.seconds[0]
    assert share[0] == pytest.approx(1 - same)
    assert share[1:] == pytest.approx([1 - same] * 2, abs=1e-9 if same in (0.0, 1.0) else 0.12)
    assert share[1] <= share[0] <= share[2]


def test_the_prediction_bound_is_the_textbooks():
    """Of y = 1, 2, 2, 3 on x = 0, 1, 2, 3: y = 1.1 + 0.6 x, residuals squared 0.2 on 2 degrees of freedom."""
    x, y = np.arange(4.0), np.array([1.0, 2, 2, 3])
    assert _line(x, y) == pytest.approx((1.1, 0.6))
    # leverage at 0: 1 + 1/4 + 1.5^2 / 5
    assert _prediction_low(y, x, 1.1, 0.6) == pytest.approx(1.1 - 1.959964 * np.sqrt(0.1 * 1.7))


def test_blocks_that_are_all_alike_leave_no_doubt_of_the_line():
    x, y = np.tile([0.0, 1, 2, 3], 8), np.tile([1.0, 2, 2, 3], 8)
    assert _block_interval(y, x, np.repeat(np.arange(8), 4), 8, 0) == pytest.approx((1.1, 1.1))
