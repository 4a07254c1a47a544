"""The distance of least expected relative error, for methods that state everyone's uncertainty."""

import numpy as np
import pytest

from proxemetry.bodies import Bodies
from proxemetry.distances import measure_distances


def two(gap_m, depth_sd_m, method="scene"):
    positions = np.array([[0.0, 0.0, 10.0], np.add((0.0, 0.0, 10.0), gap_m)])
    covariance = np.diag(np.tile([1e-6, 1e-6, depth_sd_m**2 / 2 + 1e-9], 2))
    return Bodies(positions, covariance, method, ("torso", "torso"), (None, None), up=np.array([0.0, -1.0, 0.0]))


def test_sure_positions_are_taken_at_their_word():
    # 3-4-5
    answer = measure_distances(two((3.0, 0.0, 4.0), 0.0))
    assert answer.distance_m[0, 1] == pytest.approx(5.0, abs=1e-3)
    assert answer.distance_3d_m[0, 1] == pytest.approx(5.0, abs=1e-3)


def test_depth_that_is_mostly_noise_counts_for_little():
    # a metre apart across, two metres in depth give or take three: |gap| is 2.24 m
    answer = measure_distances(two((1.0, 0.0, 2.0), 3.0)).distance_m[0, 1]
    assert 1.0 < answer < 2.0


def test_small_doubts_change_little():
    answer = measure_distances(two((1.0, 0.0, 2.0), 0.1)).distance_m[0, 1]
    assert answer == pytest.approx(np.sqrt(5), rel=0.01)


def test_it_has_less_error_than_the_distance_between_positions():
    rng = np.random.default_rng(0)
    true, sd = 1.5, 1.5
    seen = true + rng.normal(0, sd, 300)
    least = np.array([measure_distances(two((0.5, 0.0, z), sd)).distance_m[0, 1] for z in seen])
    plain = np.hypot(0.5, seen)
    truth = np.hypot(0.5, true)
    assert np.abs(least / truth - 1).mean() < 0.9 * np.abs(plain / truth - 1).mean()


def test_the_papers_estimators_measure_between_positions():
    answer = measure_distances(two((1.0, 0.0, 2.0), 3.0, method="torso"))
    assert answer.distance_m[0, 1] == pytest.approx(np.sqrt(5))


def test_in_space_is_never_shorter_than_along_the_ground():
    answer = measure_distances(two((1.0, 0.5, 2.0), 3.0))
    assert answer.distance_3d_m[0, 1] == pytest.approx(np.hypot(answer.distance_m[0, 1], 0.5))
