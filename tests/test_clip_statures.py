"""One stature a track: pooled from all sightings, told to each by the others, and carried on as one error."""

from statistics import NormalDist

import numpy as np
import pytest

from proxemetry.anthropometry import moments, populations
from proxemetry.clip.sightings import Chain, Sightings
from proxemetry.clip.smoothing import LASTING_SHARE, smooth
from proxemetry.clip.statures import _alike, _robust, known_statures, of_chain, pooled, told_again
from proxemetry.clip.tracking import SWAY_SD_M
from proxemetry.locate import LocateSettings

ADULTS = LocateSettings("adults")
MEAN, VARIANCE = (float(v) for v in (lambda m, c: (m[0], c[0, 0]))(*moments(populations("adults"))))
TALL = np.log(1.9)


def fitted(log_seen, noise):
    """What a frame's fit answers, given what it saw of log stature with a standard deviation."""
    precision = 1 / noise**2 + 1 / VARIANCE
    mean = (log_seen / noise**2 + MEAN / VARIANCE) / precision
    sd = np.full_like(mean, precision**-0.5)
    return np.exp(mean), np.exp(mean) * sd


def test_the_population_counts_once_however_many_frames_there_are():
    one = pooled(*fitted(np.array([TALL]), 0.05), ADULTS)
    assert one.mean == pytest.approx(np.log(fitted(np.array([TALL]), 0.05)[0][0]), abs=1e-9)
    many = pooled(*fitted(np.full(1000, TALL), 0.05), ADULTS)
    lasting = (LASTING_SHARE * 0.05) ** 2
    told = lasting + (0.05**2 - lasting) / 1000
    assert many.mean == pytest.approx((TALL / told + MEAN / VARIANCE) / (1 / told + 1 / VARIANCE), rel=1e-4)
    assert many.sd == pytest.approx((1 / told + 1 / VARIANCE) ** -0.5, rel=1e-3)


def test_frames_that_scatter_more_than_they_state_say_less():
    rng = np.random.default_rng(0)
    calm = pooled(*fitted(TALL + rng.normal(0, 0.03, 200), 0.03), ADULTS)
    wild = pooled(*fitted(TALL + rng.normal(0, 0.09, 200), 0.03), ADULTS)
    assert wild.sd > 1.8 * calm.sd


def test_nobody_is_told_what_they_said_themselves():
    seen = np.array([TALL, TALL, TALL - 0.3])
    found = pooled(*fitted(seen, 0.05), ADULTS)
    assert found.others[2] == pytest.approx(TALL, abs=1e-6)
    assert found.others[0] < TALL
    alone = pooled(*fitted(seen[:1], 0.05), ADULTS)
    assert np.isnan(alone.others).all()


def test_a_few_false_matches_move_nothing_much():
    rng = np.random.default_rng(1)
    seen = TALL + rng.normal(0, 0.03, 60)
    mixed = np.concatenate([seen, np.full(8, np.log(1.3))])
    clean, dirty = pooled(*fitted(seen, 0.05), ADULTS), pooled(*fitted(mixed, 0.05), ADULTS)
    assert dirty.mean == pytest.approx(clean.mean, abs=0.01)


def test_who_is_hardly_seen_says_nothing():
    stature, sd = np.full(5, np.exp(MEAN)), np.full(5, np.exp(MEAN) * VARIANCE**0.5)
    assert np.isnan(pooled(stature, sd, ADULTS).others).all()
    assert pooled(np.full(3, np.nan), np.full(3, np.nan), ADULTS) is None


def test_children_are_weighed_against_children():
    child = np.log(1.2)
    found = pooled(np.full(50, 1.2), np.full(50, 0.03), LocateSettings("mixed"))
    assert found.mean == pytest.approx(child, abs=0.02)


def seen_once_more(t_s, covariance, stature=1.75, sd=0.1):
    sighting = Sightings.of_places(t_s, [[0.0, 10.0]])
    return Sightings(
        t_s, sighting.positions_m, np.array([covariance]), sighting.scores, sighting.boxes_px, sighting.rows,
        sighting.heading_rad, sighting.heading_sd_rad, np.array([stature]), np.array([sd]), sighting.lasting_m2,
        sighting.floor_m2,
    )  # fmt: skip


def test_what_hangs_on_the_stature_is_one_error_for_the_whole_path():
    # depth d = d0 s / s0: with c = cov(depth, log stature) = depth times the stature's variance
    own, told, depth, rest = 0.06**2, 0.02**2, 10.0, 0.05**2
    before = rest + depth**2 * own
    after = rest + depth**2 * own * told / (own + told)
    wide, narrow = (np.diag([0.01, v]) for v in (before, after))
    first, again = (seen_once_more(0.0, c, sd=1.75 * own**0.5) for c in (wide, narrow))
    found = told_again(first, again, {0: (1.75, 1.75 * told**0.5)})
    # by hand: the place moves by depth * own / (own + told) with what was told
    assert found.lasting_m2[0, 1, 1] == pytest.approx((depth * own / (own + told)) ** 2 * told, rel=1e-9)
    assert np.allclose(found.lasting_m2[0, 0], 0)
    many = [told_again(seen_once_more(0.2 * k, wide, sd=1.75 * own**0.5), seen_once_more(0.2 * k, narrow),
                       {0: (1.75, 1.75 * told**0.5)}) for k in range(100)]  # fmt: skip
    path = smooth(Chain(np.arange(100), np.zeros(100, dtype=int)), many, np.arange(100) * 0.2)
    own_noise = after - found.lasting_m2[0, 1, 1] + SWAY_SD_M**2
    lasting = found.lasting_m2[0, 1, 1] + LASTING_SHARE**2 * own_noise
    assert path.lasting_m2[50, 1, 1] == pytest.approx(lasting)
    assert path.place_covariance_m2[50, 1, 1] > lasting


def test_a_part_is_never_more_than_the_whole():
    wide, narrow = np.diag([0.5, 9.0]), np.diag([0.2, 0.01])
    found = told_again(seen_once_more(0.0, wide), seen_once_more(0.0, narrow), {0: (1.75, 1.0)})
    assert np.linalg.eigvalsh(narrow - found.lasting_m2[0]).min() > -1e-12


def test_what_is_told_goes_to_the_rows_of_the_scene():
    shot = [seen_once_more(0.2 * k, np.eye(2) * 0.01, stature=1.75 + 0.01 * k, sd=0.05) for k in range(3)]
    chain = Chain(np.arange(3), np.zeros(3, dtype=int))
    found = pooled(np.array([1.75, 1.76, 1.77]), np.full(3, 0.05), ADULTS)
    told = known_statures([chain], [found], shot)
    assert [list(k) for k in told] == [[0]] * 3
    assert told[0][0][0] > told[2][0][0]  # the first is told by the others, who are taller
    assert known_statures([chain], [None], shot) == [{}, {}, {}]
    for k in range(3):  # in metres, with the deviation of a logarithm as that of metres
        assert told[k][0] == pytest.approx((np.exp(found.others[k]), np.exp(found.others[k]) * found.others_sd[k]))


def test_a_chains_stature_is_that_of_its_sightings():
    shot = [seen_once_more(0.2 * k, np.eye(2) * 0.01, stature=1.75 + 0.01 * k, sd=0.04 + 0.01 * k) for k in range(5)]
    found = of_chain(Chain(np.array([0, 1, 3, 4]), np.zeros(4, dtype=int)), shot, ADULTS)
    expected = pooled(np.array([1.75, 1.76, 1.78, 1.79]), np.array([0.04, 0.05, 0.07, 0.08]), ADULTS)
    assert (found.mean, found.sd) == (expected.mean, expected.sd)
    assert found.others == pytest.approx(expected.others) and found.others_sd == pytest.approx(expected.others_sd)


@pytest.mark.parametrize(("metres", "young"), [(1.05, True), (1.3, True), (1.62, False), (1.75, False), (1.95, False)])
def test_who_is_as_tall_as_an_adult_is_weighed_against_adults(metres, young):
    mixed = LocateSettings("mixed")
    groups = [g for g in populations("mixed") if g.name.startswith("children") == young]
    mean, covariance = moments(tuple(groups))
    assert _alike(np.log(metres), mixed) == pytest.approx((mean[0], covariance[0, 0]))


def test_how_much_frames_scatter_is_read_off_as_a_normal_distributions_deviation():
    """A thousand frames at the quantiles of a normal distribution, each of which claims to be sure."""
    quantiles = np.array([NormalDist(TALL, 0.1).inv_cdf((k + 0.5) / 999) for k in range(999)])
    weight, lasting = _robust(quantiles, np.full(999, 1e-8))
    assert lasting == pytest.approx(LASTING_SHARE**2 * 0.1**2, rel=0.01)
    assert weight[499] == pytest.approx(1 / 0.1**2, rel=0.01)
    assert weight[0] < 0.6 * weight[499]  # three deviations out
