"""Laws of the joint fit: what must not change an answer, and what must change it how."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from proxemetry.locate.scenefit import locate
from proxemetry.people import People
from proxemetry.people.skeleton import COCO_17
from synthetic.modelled import ADULTS, CAMERA, photo

seeds = st.integers(0, 10_000)


def test_people_are_where_they_are():
    people, truth = photo(0)
    bodies = locate(people, CAMERA, ADULTS)
    assert np.linalg.norm(bodies.positions_m - truth, axis=1) == pytest.approx(0, abs=0.6)
    assert bodies.floor is not None
    assert bodies.floor.height_m == pytest.approx(1.6, rel=0.1)
    assert all("feet" in basis and "torso" in basis for basis in bodies.basis)


def _shown(people, width, height):
    return locate(people.scaled(width / 1920, height / 1080), CAMERA.resized(width, height), ADULTS)


@settings(deadline=None, max_examples=10)
@given(seeds, st.floats(1, 4))
def test_scaling_photo_and_focal_length_together_changes_nothing(seed, factor):
    people, _ = photo(seed)
    here = _shown(people, 3840, 2160)
    there = _shown(people, round(3840 * factor), round(2160 * factor))
    assert there.positions_m == pytest.approx(here.positions_m, rel=2e-2)


@settings(deadline=None, max_examples=10)
@given(seeds, st.floats(0.15, 1))
def test_of_fewer_pixels_people_are_where_they_were_and_no_surer(seed, factor):
    """What a detector resolves is a number of pixels: a small photo's answer moves within what it states itself."""
    people, _ = photo(seed)
    here, there = _shown(people, 3840, 2160), _shown(people, round(3840 * factor), round(2160 * factor))
    # robust weights move a little with the noise: by less than half a per cent
    assert np.median(there.position_sd_m[:, 2] / here.position_sd_m[:, 2]) > 0.995
    assert (np.abs(there.positions_m - here.positions_m) < 0.02 * here.positions_m[:, 2:] + there.position_sd_m).all()


@settings(deadline=None, max_examples=10)
@given(seeds)
def test_mirroring_mirrors(seed):
    people, _ = photo(seed)
    here = locate(people, CAMERA, ADULTS)
    there = locate(people.mirrored(CAMERA.width), CAMERA.mirrored(), ADULTS)
    assert there.positions_m * (-1, 1, 1) == pytest.approx(here.positions_m, rel=1e-3, abs=1e-3)
    assert np.cos(there.heading_rad + here.heading_rad) == pytest.approx(1, abs=1e-3)


@settings(deadline=None, max_examples=10)
@given(seeds, st.permutations(range(4)))
def test_permuting_people_permutes_rows(seed, order):
    people, _ = photo(seed)
    here, there = locate(people, CAMERA, ADULTS), locate(people[list(order)], CAMERA, ADULTS)
    assert there.positions_m == pytest.approx(here.positions_m[list(order)], abs=1e-4)
    assert there.basis == tuple(here.basis[k] for k in order)


@settings(deadline=None, max_examples=8)
@given(seeds)
def test_without_a_floor_nobody_depends_on_the_others(seed):
    people, _ = photo(seed)
    alone = replace(ADULTS, floor="none")
    everyone = locate(people, CAMERA, alone)
    some = locate(people[[0, 2]], CAMERA, alone)
    # gravity stays shared: it moves people by little where they stand upright
    assert some.positions_m == pytest.approx(everyone.positions_m[[0, 2]], rel=0.05, abs=0.02)


@settings(deadline=None, max_examples=8)
@given(seeds)
def test_more_evidence_hardly_widens_an_interval(seed):
    people, _ = photo(seed)
    hidden = people.keypoints_px.copy()
    hidden[:, 13:] = np.nan  # knees and ankles
    less = locate(People(COCO_17, hidden, people.scores), CAMERA, ADULTS)
    more = locate(people, CAMERA, ADULTS)
    assert (more.position_sd_m[:, 2] < 1.15 * less.position_sd_m[:, 2]).all()


@settings(deadline=None, max_examples=8)
@given(seeds, st.integers(-2, 2))
def test_headings_are_alike_by_whole_turns(seed, turns):
    people, _ = photo(seed)
    stated = np.full(len(people), 0.3)
    here, there = (
        locate(replace(people, heading_rad=h, heading_sd_rad=np.full(len(people), 0.2)), CAMERA, ADULTS)
        for h in (stated, stated + 2 * np.pi * turns)
    )
    assert there.positions_m == pytest.approx(here.positions_m, rel=1e-6)
    assert np.cos(there.heading_rad - here.heading_rad) == pytest.approx(1, abs=1e-9)


def test_the_same_answer_every_time():
    people, _ = photo(3)
    first, second = locate(people, CAMERA, ADULTS), locate(people, CAMERA, ADULTS)
    assert np.array_equal(first.positions_m, second.positions_m)
    assert np.array_equal(first.covariance_m2, second.covariance_m2)
