"""The fixed draws: as a Gaussian's in every direction, and which pairs of a crowd are looked at."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats

from proxemetry.bodies import Bodies, Mode
from proxemetry.draws import blocks, pairs_within, spread_out, standard_normal

DIMENSIONS = (1, 2, 3, 4)


@pytest.mark.parametrize("dimension", DIMENSIONS)
def test_points_have_unit_covariance_and_every_mirror_image(dimension):
    points = standard_normal(dimension)
    assert points.T @ points / len(points) == pytest.approx(np.eye(dimension), abs=1e-12)
    assert points.mean(axis=0) == pytest.approx(np.zeros(dimension), abs=1e-12)
    for axis in range(dimension):
        mirrored = points * np.where(np.arange(dimension) == axis, -1, 1)
        assert sorted(map(tuple, mirrored.round(9))) == sorted(map(tuple, points.round(9)))


@pytest.mark.parametrize(("dimension", "apart"), [(1, 0.01), (2, 0.02), (3, 0.05), (4, 0.08)])
def test_points_are_as_many_within_any_limit_as_a_gaussians(dimension, apart):
    """Kolmogorov's distance of 512 points from the normal distribution along any line, and from chi-squared's."""
    points = standard_normal(dimension)
    assert stats.kstest((points**2).sum(axis=1), stats.chi2(dimension).cdf).statistic < apart + 0.02
    for line in np.concatenate([np.eye(dimension), np.random.default_rng(0).normal(size=(20, dimension))]):
        assert stats.kstest(points @ line / np.linalg.norm(line), "norm").statistic < apart


@given(st.integers(0, 10**6), st.integers(1, 4))
def test_points_that_are_spread_out_have_exactly_that_covariance(seed, dimension):
    roots = np.random.default_rng(seed).normal(size=(3, dimension, dimension))
    covariance = roots @ roots.transpose(0, 2, 1)
    spread = spread_out(standard_normal(dimension), covariance)
    assert spread.transpose(0, 2, 1) @ spread / spread.shape[1] == pytest.approx(covariance, rel=1e-9, abs=1e-9)


@given(st.integers(0, 300), st.integers(10_000, 10**7))
def test_blocks_hold_every_row_once_and_no_more_draws_than_memory_allows(count, draws):
    parts = list(blocks(count, draws))
    rows = [min(part.stop, count) - part.start for part in parts]
    assert np.concatenate([np.arange(count)[part] for part in parts] or [np.zeros(0)]).tolist() == list(range(count))
    assert all(n == 1 or n * draws <= 2_000_000 for n in rows)
    assert all((n + 1) * draws > 2_000_000 for n in rows[:-1])


def test_pairs_are_near_where_any_explanation_has_them_so_on_the_ground():
    def explained(third_m):
        return np.array([[0, 0, 5], [3, 40, 9], [third_m, 0, 5]], float)

    far, near = explained(30.0), explained(5.0)
    own = np.eye(9) * 1e-4
    modes = (Mode(0.9, far, own), Mode(0.1, near, own))
    bodies = Bodies(far, own, "drawn", ("drawn",) * 3, (None,) * 3, np.array([0.0, -1.0, 0.0]), modes=modes)
    a, b = np.triu_indices(3, 1)
    ground = np.array([[1.0, 0, 0], [0, 0, 1]])

    def within(reach_m):
        return list(zip(*(k.tolist() for k in pairs_within(reach_m, bodies, ground, a, b)), strict=True))

    assert within(4.99) == [(1, 2)]  # math.hypot(5 - 3, 4) = 4.47 in the second explanation alone
    assert within(5.01) == [(0, 1), (0, 2), (1, 2)]  # 3-4-5 in both, whatever the height
    assert math.hypot(2, 4) > 4.4 and within(4.4) == []
