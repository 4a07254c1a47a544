"""What is said of scores: Wilson's interval, the logistic curve, and that a photo never judges itself."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from benchmarks.networks.backends import counts, verdicts
from benchmarks.networks.score_reliability import Candidates, left_out, logistic_curve, wilson
from proxemetry.people import People
from proxemetry.people.skeleton import COCO_17


@given(st.integers(1, 400), st.data())
def test_wilsons_interval_holds_the_share_and_mirrors(count: int, data: st.DataObject) -> None:
    hits = data.draw(st.integers(0, count))
    low, high = wilson(hits, count)
    assert 0 <= low <= hits / count + 1e-12 and hits / count - 1e-12 <= high <= 1
    assert wilson(count - hits, count) == pytest.approx((1 - high, 1 - low), abs=1e-12)


def test_wilsons_interval_in_numbers() -> None:
    # of none in n the upper end is z^2 / (n + z^2): 2.706 / 12.706
    assert wilson(0, 10) == pytest.approx((0.0, 0.213), abs=5e-4)
    assert wilson(0, 0) == (0.0, 1.0)


def test_the_curve_is_found_again() -> None:
    rng = np.random.default_rng(3)
    scores = rng.uniform(0, 1, 20000)
    are_real = rng.uniform(0, 1, 20000) < 1 / (1 + np.exp(3 - 8 * scores))
    assert logistic_curve(scores, are_real) == pytest.approx((-3, 8), abs=0.3)


def test_scores_that_part_real_from_false_have_a_finite_curve() -> None:
    bias, slope = logistic_curve(np.array([0.1, 0.2, 0.7, 0.9]), np.array([False, False, True, True]))
    assert np.isfinite([bias, slope]).all() and slope > 0


def test_a_photo_has_no_say_in_its_own_curve() -> None:
    rng = np.random.default_rng(5)
    scores, photos = rng.uniform(0, 1, 60), np.repeat(np.arange(6), 10)
    what = np.where(rng.uniform(0, 1, 60) < scores, "clear", "false")
    before = left_out(Candidates(scores, what, photos))
    turned = np.where(photos == 2, np.where(what == "clear", "false", "clear"), what)
    after = left_out(Candidates(scores, turned, photos))
    assert np.array_equal(before[photos == 2], after[photos == 2])
    assert not np.array_equal(before[photos != 2], after[photos != 2])


def _person(x: float, y: float, neck_px: float = 20.0) -> np.ndarray:
    """Joints of someone upright whose ears are at (x, y): only what the labels' parts need."""
    points = np.full((17, 2), np.nan)
    points[[3, 4]] = (x - 5, y), (x + 5, y)
    points[[5, 6]] = (x - 15, y + neck_px), (x + 15, y + neck_px)
    points[[11, 12]] = (x - 10, y + 3 * neck_px), (x + 10, y + 3 * neck_px)
    return points


def test_verdicts_are_what_is_counted() -> None:
    label = {"head": [50, 50], "mid_shoulder": [50, 70], "box": [20, 40, 80, 200], "difficulty": "hard"}
    other = {"head": [150, 50], "mid_shoulder": [150, 70], "box": [120, 40, 180, 200], "difficulty": "clear"}
    labels = {"people": [label, other], "ignore": [[300, 0, 400, 100, 1000]]}
    points = np.array([_person(51, 50), _person(50, 120), _person(250, 50), _person(350, 50)])
    people = People(COCO_17, points, np.where(np.isfinite(points).all(axis=-1), 0.9, 0.0))
    assert verdicts(people, labels) == ["hard", "double", "false", "unlabelled"]
    counted = counts(people, labels)
    assert [counted[k] for k in ("hard", "hard_found", "clear", "clear_found")] == [1, 1, 1, 0]
    assert [counted[k] for k in ("double", "false")] == [1, 1]
