"""How people move, who is who, and where they were: against closed forms and laws."""

from dataclasses import replace
from decimal import Decimal, localcontext

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.stats import multivariate_normal

from proxemetry.clip.joining import _HIDDEN_S, _NEVER, _area_m2, _evidence, _pairs, joined
from proxemetry.clip.motion import SPEED_SD_M_S, VELOCITY, _place_term, first_state, transition
from proxemetry.clip.sightings import Chain, Sightings
from proxemetry.clip.smoothing import LASTING_SHARE, noise_scale_of, smooth, surprises
from proxemetry.clip.tracking import SWAY_SD_M, at_picture_edge, sure_score, track
from proxemetry.overlap import pairwise_iou

STEP = 0.2


def shot_of(places, step=STEP, sd=0.1, times=None):
    """Sightings of places (F, P, 2), NaN where a person is not seen."""
    times = np.arange(len(places)) * step if times is None else times
    return [Sightings.of_places(t, p[np.isfinite(p).all(axis=1)], sd) for t, p in zip(times, places, strict=True)]


def walkers(frames=40, step=STEP):
    """Two people who walk towards each other and pass at a metre, and one who stands."""
    t = np.arange(frames) * step
    zero = np.zeros_like(t)
    return np.stack(
        [np.stack([1.3 * t - 5, zero], 1), np.stack([5 - 1.2 * t, zero + 1], 1), np.stack([zero, zero + 6], 1)], 1
    )


def chain_of(frames):
    return Chain(np.array(frames), np.zeros(len(frames), dtype=int))


@given(st.floats(1e-4, 3.0), st.floats(1e-4, 3.0))
def test_two_steps_are_one_long_step(a, b):
    (fa, qa), (fb, qb), (f, q) = transition(a), transition(b), transition(a + b)
    assert np.allclose(fb @ fa, f, atol=1e-9)
    assert np.allclose(fb @ qa @ fb.T + qb, q, atol=1e-7)


@given(st.floats(1e-3, 20.0))
def test_speeds_stay_as_they_are_on_average(seconds):
    f, q = transition(seconds)
    still = np.zeros((4, 4))
    still[VELOCITY, VELOCITY] = SPEED_SD_M_S**2 * np.eye(2)
    assert np.allclose((f @ still @ f.T + q)[VELOCITY, VELOCITY], still[VELOCITY, VELOCITY])


def test_of_who_is_seen_first_the_place_is_known_and_no_speed():
    noise = np.array([[0.04, 0.01], [0.01, 0.09]])
    state, covariance = first_state(np.array([[1.0, 2.0], [3.0, 4.0]]), np.stack([noise, 2 * noise]))
    assert state.tolist() == [[1, 2, 0, 0], [3, 4, 0, 0]]
    for k in range(2):
        zero = np.zeros((2, 2))
        expected = np.block([[(k + 1) * noise, zero], [zero, SPEED_SD_M_S**2 * np.eye(2)]])
        assert covariance[k] == pytest.approx(expected)


def test_one_sighting_is_its_own_path():
    shot = shot_of(np.array([[[3.0, 4.0]]]))
    path = smooth(chain_of([0]), shot, np.array([0.0]))
    own = 0.1**2 + SWAY_SD_M**2
    assert np.allclose(path.positions_m, [[3.0, 4.0]])
    assert np.allclose(path.place_covariance_m2[0], (1 + LASTING_SHARE**2) * own * np.eye(2))


def joint_prior(times):
    """The covariance of all states with a start that could be anywhere, by composing transitions."""
    count = len(times)
    first = np.diag([1e5, 1e5, SPEED_SD_M_S**2, SPEED_SD_M_S**2])
    joint = np.zeros((4 * count, 4 * count))
    marginal = [first]
    for k in range(1, count):
        f, q = transition(times[k] - times[k - 1])
        marginal.append(f @ marginal[-1] @ f.T + q)
    for i in range(count):
        block = marginal[i]
        for j in range(i, count):
            if j > i:
                block = transition(times[j] - times[j - 1])[0] @ block
            joint[4 * j : 4 * j + 4, 4 * i : 4 * i + 4] = block
            joint[4 * i : 4 * i + 4, 4 * j : 4 * j + 4] = block.T
    return joint


def test_the_smoother_is_the_joint_posterior_of_all_frames():
    rng = np.random.default_rng(1)
    times = np.cumsum(rng.uniform(0.1, 0.4, 9))
    places = np.cumsum(rng.normal(0, 0.3, (9, 1, 2)), axis=0)
    seen = np.array([0, 1, 2, 4, 5, 8])
    places[np.setdiff1d(np.arange(9), seen)] = np.nan
    path = smooth(chain_of(seen), shot_of(places, times=times), times)
    prior = joint_prior(times)
    rows = np.concatenate([4 * seen, 4 * seen + 1])
    measured = np.concatenate([places[seen, 0, 0], places[seen, 0, 1]])
    noise = (0.1**2 + SWAY_SD_M**2) * np.eye(len(rows))
    gain = np.linalg.solve(prior[np.ix_(rows, rows)] + noise, prior[rows]).T
    expected = (gain @ measured).reshape(-1, 4)
    covariance = prior - gain @ prior[rows]
    assert np.allclose(path.states, expected, atol=1e-3)
    for k in range(9):
        assert np.allclose(path.covariance[k], covariance[4 * k : 4 * k + 4, 4 * k : 4 * k + 4], atol=1e-3)
    # what is drawn has these covariances within a frame and from each frame to the next
    for k in range(8):
        assert np.allclose(path.gains[k] @ path.covariance[k + 1] @ path.gains[k].T + path.kicks[k], path.covariance[k])
        between = covariance[4 * k : 4 * k + 4, 4 * k + 4 : 4 * k + 8]
        assert np.allclose(path.gains[k] @ path.covariance[k + 1], between, atol=1e-3)


def test_drawn_paths_spread_as_stated():
    places = np.cumsum(np.full((12, 1, 2), 0.2), axis=0)
    path = smooth(chain_of(np.r_[0:5, 9:12]), shot_of(places), np.arange(12) * STEP)
    drawn = path.drawn(np.random.default_rng(0), 4000)
    assert np.allclose(drawn.mean(axis=1), path.positions_m, atol=0.02)
    for k in (0, 6, 11):
        assert np.allclose(np.cov(drawn[k].T), path.place_covariance_m2[k], atol=0.002)


@settings(max_examples=20, deadline=None)
@given(st.integers(0, 1000))
def test_a_path_played_backwards_is_the_path_reversed(seed):
    rng = np.random.default_rng(seed)
    places = np.cumsum(rng.normal(0, 0.3, (10, 1, 2)), axis=0)
    times = np.cumsum(rng.uniform(0.05, 0.5, 10))
    forwards = smooth(chain_of(range(10)), shot_of(places, times=times), times)
    back_times = times[-1] - times[::-1]
    backwards = smooth(chain_of(range(10)), shot_of(places[::-1], times=back_times), back_times)
    assert np.allclose(backwards.positions_m[::-1], forwards.positions_m, atol=1e-6)
    assert np.allclose(backwards.states[::-1, VELOCITY], -forwards.states[:, VELOCITY], atol=1e-6)
    assert np.allclose(backwards.place_covariance_m2[::-1], forwards.place_covariance_m2, atol=1e-8)


def test_who_is_not_seen_is_bridged_and_marked():
    places = walkers()[:, :1]
    places[15:20] = np.nan
    (chain,) = track(shot_of(places))
    path = smooth(chain, shot_of(places), np.arange(40) * STEP)
    assert (~path.seen).nonzero()[0].tolist() == [15, 16, 17, 18, 19]
    assert np.allclose(path.positions_m[15:20], walkers()[15:20, 0], atol=0.15)
    assert path.place_covariance_m2[17, 0, 0] > path.place_covariance_m2[10, 0, 0]


def test_people_who_pass_each_other_keep_their_names():
    rng = np.random.default_rng(3)
    places = walkers() + rng.normal(0, 0.1, (40, 3, 2))
    chains = track(shot_of(places))
    assert [len(c) for c in chains] == [40, 40, 40]
    assert all((c.people == c.people[0]).all() for c in chains)


@settings(max_examples=10, deadline=None)
@given(st.permutations(range(3)), st.booleans(), st.booleans())
def test_tracks_depend_on_neither_order_nor_mirror_nor_direction_of_time(order, mirrored, reversed_):
    places = walkers() + np.random.default_rng(5).normal(0, 0.1, (40, 3, 2))
    changed = places[:, list(order)] * ((-1, 1) if mirrored else (1, 1))
    changed = changed[::-1] if reversed_ else changed
    chains = track(shot_of(changed))
    assert sorted(order[c.people[0]] for c in chains if (c.people == c.people[0]).all()) == [0, 1, 2]


def test_half_the_frames_give_the_same_people():
    places = walkers(60) + np.random.default_rng(7).normal(0, 0.05, (60, 3, 2))
    whole, half = track(shot_of(places)), track(shot_of(places[::2], step=2 * STEP))
    assert len(whole) == len(half) == 3
    for a, b in zip(whole, half, strict=True):
        fine = smooth(a, shot_of(places), np.arange(60) * STEP)
        coarse = smooth(b, shot_of(places[::2], step=2 * STEP), np.arange(30) * 2 * STEP)
        assert np.abs(fine.positions_m[::2] - coarse.positions_m).max() < 0.12


def test_what_appears_once_in_the_middle_is_nobody_and_at_the_edge_somebody():
    places = np.full((12, 1, 2), np.nan)
    places[6] = 0.0
    assert track(shot_of(places)) == []
    assert len(track(shot_of(places[6:7]))) == 1
    assert len(track(shot_of(places[6:]))) == 1
    assert len(track(shot_of(places[:7]))) == 1


def test_who_stays_away_too_long_comes_back_as_another():
    places = np.zeros((40, 1, 2))
    places[10:25] = np.nan
    assert [len(c) for c in track(shot_of(places))] == [10, 15]


def test_the_left_and_the_right_edge_of_the_picture_are_alike():
    boxes = np.array([[0, 0, 80, 90], [4, 0, 80, 90], [40, 0, 80, 90], [900, 0, 996, 90], [900, 0, 960, 90.0]])
    assert at_picture_edge(boxes, 1000.0).tolist() == [True, True, False, True, False]
    mirrored = 1000.0 - boxes[:, [2, 1, 0, 3]]
    assert at_picture_edge(mirrored, 1000.0).tolist() == [True, True, False, True, False]
    assert not at_picture_edge(boxes, np.inf).any()  # without a picture there is no edge to leave by


def test_covariances_that_are_too_small_are_found_out():
    rng = np.random.default_rng(0)
    truth = np.stack([np.arange(400) * STEP * 1.2, np.zeros(400)], axis=1)[:, None]
    noisy = truth + rng.normal(0, 0.3, (400, 1, 2))
    shot = shot_of(noisy, sd=0.15)
    scale = noise_scale_of(surprises(chain_of(range(400)), shot, np.arange(400) * STEP))
    assert scale > 2
    honest = shot_of(noisy, sd=0.3)
    assert noise_scale_of(surprises(chain_of(range(400)), honest, np.arange(400) * STEP)) < 1.3


def test_only_where_somebody_is_seen_there_is_a_surprise_and_an_even_walk_has_none():
    seen = [0, 1, 2, 3, 9, 10, 11, 17]
    places = np.full((18, 1, 2), np.nan)
    places[seen, 0] = np.outer(seen, [1.2 * STEP, 0.0])
    found = surprises(chain_of(seen), shot_of(places), np.arange(18) * STEP)
    assert len(found) == len(seen) - 2
    assert (found >= 0).all() and found.max() < 0.6  # of chi-squared with two degrees, whose median is 1.4
    aside = places.copy()
    aside[9, 0, 1] = 3.0  # three metres to the side of where the walk goes on after the gap
    found = surprises(chain_of(seen), shot_of(aside), np.arange(18) * STEP)
    assert found[: seen.index(9) - 2].max() < 0.6 and found[seen.index(9) - 2] > 10


def test_overlap_of_boxes():
    boxes = np.array([[0.0, 0, 2, 2], [1, 0, 3, 2], [5, 5, 6, 6], [np.nan] * 4])
    found = pairwise_iou(boxes[:1], boxes)[0]
    assert found[:3] == pytest.approx([1.0, 2 / 6, 0.0])
    assert np.isnan(found[3])


def test_who_was_hidden_for_long_is_joined_from_both_sides_and_strangers_are_not():
    walker = walkers(60)[:, :1].copy()
    walker[20:38] = np.nan  # 3.6 s
    times = np.arange(60) * STEP
    chains = track(shot_of(walker))
    assert len(chains) == 2
    (whole,) = joined(chains, shot_of(walker), times)
    assert len(whole) == 42
    stranger = walker.copy()
    stranger[38:] = stranger[38:] * (1, 0) + (0, 4)
    assert len(joined(track(shot_of(stranger)), shot_of(stranger), times)) == 2
    back = walker.copy()
    back[38:] = back[38:][::-1]
    assert len(joined(track(shot_of(back)), shot_of(back), times)) == 2


def test_where_people_keep_appearing_a_stranger_is_likelier_than_one_who_was_hidden():
    """The same gap is bridged in an alley and left open before a door, out of which someone comes every second."""
    walker = walkers(60)[:, :1].copy()
    walker[20:38] = np.nan  # 3.6 s
    times = np.arange(60) * STEP
    door = np.full((60, 24, 2), np.nan)
    for k in range(24):
        begins = 2 + 2 * k
        for step in range(6):
            door[begins + step, k] = (-8.0 - 1.5 * (k % 3), 1.2 * STEP * step)
    alone = joined(track(shot_of(walker)), shot_of(walker), times)
    assert len(alone) == 1
    crowd = np.concatenate([walker, door], axis=1)
    found = joined(track(shot_of(crowd)), shot_of(crowd), times)
    of_walker = [c for c in found if c.frames[-1] >= 58 or (c.frames[0] == 0 and len(c) > 10)]
    assert len(of_walker) == 2


def test_a_box_that_goes_on_as_before_keeps_its_person_where_places_tell_nothing():
    """Two cross in the picture while the fit puts both at one place: where their boxes were going says who is who."""
    u = 300 + 12.0 * np.arange(21)
    left, right = (np.stack([x - 12, 0 * x + 100, x + 12, 0 * x + 180], axis=1) for x in (u, u[::-1]))
    shot = []
    for k in range(21):
        places = np.array([[0.005 * u[k], 20.0], [0.005 * u[::-1][k], 20.3]])
        if 6 <= k <= 14:
            places = np.tile(places.mean(axis=0), (2, 1))
        order = [0, 1] if k % 2 else [1, 0]
        seen = Sightings.of_places(k * STEP, places[order], 0.3)
        shot.append(replace(seen, boxes_px=np.stack([left[k], right[k]])[order]))
    chains = track(shot)
    assert len(chains) == 2
    for chain in chains:
        who = (chain.people + chain.frames) % 2
        assert len(chain) == 21
        assert len(set(np.delete(who, 10).tolist())) == 1  # in the middle their boxes are one


@pytest.mark.parametrize("s", [1e-6, 1e-3, 9.99e-3, 1.001e-2, 0.3, 20.0])
def test_the_spread_of_a_place_is_the_closed_form_where_its_terms_cancel_too(s):
    """2 s - 3 + 4 exp(-s) - exp(-2 s), with forty digits instead of sixteen."""
    with localcontext() as exactly:
        exactly.prec = 40
        x = Decimal(s)
        exact = float(2 * x - 3 + 4 * (-x).exp() - (-2 * x).exp())
    assert _place_term(s) == pytest.approx(exact, rel=1e-6)


def test_people_of_a_single_frame_are_as_many_tracks():
    shot = shot_of(walkers(1))
    assert len(joined(track(shot), shot, np.zeros(1))) == 3


def seen_at(places, boxes_px, scores=None, frames=30):
    """People at places (P, 2) who stand still, in boxes (P, 4), frame after frame."""
    shot = []
    for k in range(frames):
        now = Sightings.of_places(k * STEP, np.array(places, float), 0.1)
        now = replace(now, boxes_px=np.array(boxes_px, float))
        shot.append(now if scores is None else replace(now, scores=np.array(scores, float)))
    return shot


def test_one_person_in_two_boxes_is_one_track_and_two_who_hide_each_other_are_two():
    """Two detections of one person share most of their boxes and stand at one place; a couple shares one of the two."""
    box, nearly, aside = [100, 50, 200, 350], [105, 55, 205, 355], [170, 50, 270, 350]
    sure = [0.9, 0.9, 0.4]  # the third is matched last, when the others have been
    there, beside = (0.0, 8.0), (3.0, 8.0)
    assert len(track(seen_at([there, beside, (0.2, 8.1)], [box, aside, nearly], sure))) == 2
    # far apart on the floor, or in other boxes, it is someone else, but for the score that makes nobody sure of them
    for place, other in (((0.9, 8.1), nearly), ((0.2, 8.1), aside)):
        shot = seen_at([there, beside, place], [box, [300, 50, 400, 350], other], [0.9, 0.9, 0.6])
        assert len(track(shot)) == 3


def test_a_person_found_twice_all_at_once_begins_no_second_track():
    """The second box appears amid the clip, beside others: sharing a box with one of them is enough."""
    shot = seen_at([(0.0, 8.0), (3.0, 8.0)], [[100, 50, 200, 350], [400, 50, 500, 350]])
    for k in range(10, 20):
        twice = Sightings.of_places(k * STEP, np.array([(0.0, 8.0), (3.0, 8.0), (0.15, 8.1)]), 0.1)
        boxes = np.array([[100, 50, 200, 350], [400, 50, 500, 350], [104, 52, 204, 352]], float)
        shot[k] = replace(twice, boxes_px=boxes)
    assert [len(c) for c in track(shot)] == [30, 30]


@pytest.mark.parametrize(("u", "away", "people"), [(500, 5, 1), (5, 5, 2), (995, 5, 2), (5, 1, 1)])
def test_who_was_last_seen_at_the_pictures_edge_has_left_it_sooner(u, away, people):
    """Away for a second: amid the picture it is one person; at its edge another has come in, unless it is quick."""
    shot = seen_at([(0.0, 8.0)], [[u - 30, 50, u + 30, 350]])
    nobody = Sightings.of_places(0.0, np.zeros((0, 2)), 0.1)
    for k in range(10, 10 + away):
        shot[k] = replace(nobody, t_s=k * STEP)
    assert len(track(shot, width_px=1000.0)) == people
    assert len(track(shot)) == 1  # without a picture there is no edge


def test_a_back_end_that_is_never_sure_is_measured_by_its_own_scores():
    places = np.zeros((2, 2))
    assert sure_score([]) == 0.5
    assert sure_score(seen_at(places, np.zeros((2, 4)), [0.9, 0.8])) == 0.5
    assert sure_score(seen_at(places, np.zeros((2, 4)), [0.4, 0.4])) == pytest.approx(0.3)


@given(st.integers(0, 10**6), st.floats(0.2, 5.0))
def test_two_ends_are_weighed_by_the_densities_of_one_person_and_of_a_new_one(seed, gap_s):
    rng = np.random.default_rng(seed)
    roots = rng.normal(0, 0.3, (2, 4, 4))
    spreads = roots @ roots.transpose(0, 2, 1) + 0.01 * np.eye(4)
    before = np.concatenate([rng.normal(0, 5, 2), rng.normal(0, 1, 2)])
    forward, kick = transition(gap_s)
    expected = forward @ spreads[0] @ forward.T + kick + spreads[1]
    after = forward @ before + np.linalg.cholesky(expected) @ rng.normal(0, 0.5, 4)
    one = multivariate_normal(forward @ before, expected).logpdf(after) - gap_s / _HIDDEN_S
    two = multivariate_normal(np.zeros(2), spreads[1][VELOCITY, VELOCITY] + SPEED_SD_M_S**2 * np.eye(2))
    found = _evidence(before, spreads[0], after, spreads[1], gap_s)
    assert found == pytest.approx(-2 * (one - two.logpdf(after[VELOCITY])))
    beyond = forward @ before + np.linalg.cholesky(expected) @ [4.0, 0, 0, 0]  # the gate is 13.28 = 3.64 squared
    assert _evidence(before, spreads[0], beyond, spreads[1], gap_s) == _NEVER


def test_people_who_are_spread_over_a_rectangle_walk_on_its_area():
    """Of 40 x 30 m, and a metre's standard deviation of room to all sides."""
    x, y = (v.ravel() for v in np.meshgrid(np.linspace(-20, 20, 201), np.linspace(5, 35, 201)))
    places = np.stack([x, y], axis=1)[:, None]
    path = smooth(chain_of([0]), shot_of(places[:1]), np.zeros(1))
    spread = [replace(path, states=np.concatenate([p, np.zeros((1, 2))], axis=1)) for p in places]
    assert _area_m2(spread) == pytest.approx(np.sqrt((40**2 + 12) * (30**2 + 12)), rel=0.02)


@pytest.mark.parametrize(("appeared", "evidence", "joins"), [(1, 9.1, True), (1, 9.3, False), (4, 6.3, True)])
def test_chains_join_where_one_person_is_likelier_than_that_somebody_appeared(appeared, evidence, joins):
    """At one appearance in 100 square metres and seconds the limit is 2 ln 100 = 9.21; at four, 2 ln 25 = 6.44."""
    apart = np.full((2, 2), _NEVER)
    apart[0, 1] = evidence
    assert _pairs(apart, appeared, 100.0) == ({0: 1} if joins else {})


def test_when_a_clips_clock_begins_does_not_matter():
    walker = walkers(60)[:, :1].copy()
    walker[20:38] = np.nan
    times = 1000.0 + np.arange(60) * STEP
    shot = shot_of(walker, times=times)
    (whole,) = joined(track(shot), shot, times)
    assert len(whole) == 42
    door = np.full((60, 24, 2), np.nan)
    for k in range(24):
        door[2 + 2 * k : 8 + 2 * k, k] = [(-8.0 - 1.5 * (k % 3), 1.2 * STEP * step) for step in range(6)]
    crowd = np.concatenate([walker, door], axis=1)
    lengths = []
    for begins in (0.0, 1e5):
        now = begins + np.arange(60) * STEP
        lengths.append([len(c) for c in joined(track(shot_of(crowd, times=now)), shot_of(crowd, times=now), now)])
    assert lengths[0] == lengths[1]
