"""Likeness of boxes and of skeletons, against what can be reckoned by hand."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from proxemetry import intervals
from proxemetry.overlap import SIGMAS, iou, keypoint_similarity, pairwise_iou, sigmas_of
from proxemetry.people import People
from proxemetry.people.duplicates import similarity
from proxemetry.people.skeleton import COCO_17


def box(x0, y0, x1, y1):
    return np.array([x0, y0, x1, y1], dtype=float)


def test_half_of_each_is_a_third_of_both():
    others = np.array([box(0, 0, 2, 1), box(1, 0, 3, 1), box(2, 0, 4, 1), box(5, 5, 6, 6)])
    assert iou(box(0, 0, 2, 1), others) == pytest.approx([1, 1 / 3, 0, 0])


def test_a_box_without_area_is_itself_alone_and_one_of_nan_nothing():
    line, nan = box(1, 1, 1, 3), np.full(4, np.nan)
    assert iou(line, np.array([line, box(0, 0, 5, 5), nan])).tolist() == [1, 0, 0]


@given(st.lists(st.floats(-50, 50), min_size=8, max_size=8))
def test_overlap_is_mutual_and_a_share(numbers):
    a, b = (box(min(x, u), min(y, v), max(x, u), max(y, v)) for x, y, u, v in (numbers[:4], numbers[4:]))
    assert iou(a, b[None])[0] == pytest.approx(iou(b, a[None])[0])
    assert 0 <= iou(a, b[None])[0] <= 1 + 1e-12


def test_pairs_of_boxes_overlap_as_one_with_the_others_does():
    boxes = np.array([box(0, 0, 2, 1), box(1, 0, 3, 1), box(1, 1, 1, 3), box(5, 5, 6, 6), np.full(4, np.nan)])
    pairs = pairwise_iou(boxes, boxes)
    assert np.isnan(pairs[2, 2]) and np.isnan(pairs[4]).all() and np.isnan(pairs[:, 4]).all()
    for one, row in zip(boxes[[0, 1, 3]], pairs[[0, 1, 3]], strict=True):
        assert iou(one, boxes) == pytest.approx(np.nan_to_num(row))


def test_a_joint_off_by_two_sigmas_of_the_persons_size_is_worth_one_over_root_e():
    sigma, area = SIGMAS["hip"], 900.0
    off = (2 * sigma) ** 2 * area  # squared pixels
    got = keypoint_similarity(np.array([off, 0.0]), np.array(area), np.full(2, sigma), np.array([1.0, 0.0]))
    assert got == pytest.approx(math.exp(-0.5))


def test_no_joint_in_common_is_no_likeness():
    assert keypoint_similarity(np.zeros(2), np.array(1.0), np.ones(2), np.zeros(2)) == 0


def test_sides_do_not_matter_to_sigmas():
    assert sigmas_of(["left_knee", "right_knee", "nose"]).tolist() == [0.087, 0.087, 0.026]


def test_one_level_for_every_interval():
    assert intervals.LEVEL == 0.9
    assert pytest.approx(1.6448536) == intervals.HALF_WIDTH_SD
    assert (pytest.approx(0.05), pytest.approx(0.95)) == (intervals.LOW, intervals.HIGH)
    assert pytest.approx(4.60517) == intervals.CHI2_2D


def test_a_small_person_in_front_of_a_large_one_is_not_a_double():
    large = np.stack([np.linspace(0, 200, 17), np.linspace(0, 600, 17)], axis=1)
    small = large / 6 + (80, 250)
    two = People(COCO_17, np.stack([large, small]), np.ones((2, 17)))
    assert similarity(two)[0, 1] < 0.1
    assert similarity(two)[0, 0] == 1
