"""A whole clip, from sightings to totals: what must not depend on how it was filmed."""

import math

import numpy as np
import pytest

from proxemetry.archive.store.folder import Folder
from proxemetry.camera import Camera, Mount
from proxemetry.clip.analysis import Wanted, assembled
from proxemetry.clip.camera import ClipCamera, weighed
from proxemetry.clip.columns import TABLES
from proxemetry.clip.measuring import Measured
from proxemetry.clip.placing import Placed
from proxemetry.clip.shots import Change, Shot
from proxemetry.clip.sightings import Sightings
from proxemetry.clip.summary import Sums
from proxemetry.clip.writing import write_results

STEP, FRAMES, SD = 0.2, 60, 0.06


def filmed(seed=0):
    """Places (F, P, 2) of two companions, one who comes towards them and one who stands, seen with errors."""
    t = np.arange(FRAMES)[:, None] * STEP
    zero = np.zeros_like(t)
    truth = np.stack([
        np.hstack([1.2 * t - 6, zero]), np.hstack([1.2 * t - 6, zero + 0.8]), np.hstack([6 - 1.1 * t, zero + 1.8]),
        np.hstack([zero, zero + 5]),
    ], axis=1)  # fmt: skip
    return truth + np.random.default_rng(seed).normal(0, SD, truth.shape)


def totals(places, tmp_path, times=None, order=None):
    """Return seconds within 1 and 2 m, all and apart, and the sizes of groups."""
    times = np.arange(len(places)) * STEP if times is None else times
    seen = [Sightings.of_places(t, p if order is None else p[order[k]], SD) for k, (t, p) in
            enumerate(zip(times, places, strict=True))]  # fmt: skip
    placed = [Placed(s, "ok", None, len(s), {}, ({},) * len(s)) for s in seen]
    measured = Measured(tuple(times), (Shot(0, len(times) - 1, 0, Change.START),), 640, 480, ())
    found = assembled(measured, Wanted((1.0, 2.0)), {0: ClipCamera(None, None, "made up")}, placed)
    sums: Sums = write_results(found, Folder(str(tmp_path)))
    assert sums.totals is not None
    sizes = sorted(sum(q.group == p.group for q in found.people) for p in found.people)
    return np.concatenate([sums.totals.seconds, sums.totals.apart_seconds]), sizes


@pytest.fixture(scope="module")
def plain(tmp_path_factory):
    return totals(filmed(), tmp_path_factory.mktemp("plain"))


def test_two_walk_together_and_two_do_not(plain):
    seconds, sizes = plain
    assert sizes == [1, 1, 2, 2]
    assert seconds[0] == pytest.approx(FRAMES * STEP, rel=0.08)  # the companions, all the time
    assert seconds[2] < 0.1 * seconds[0]


def test_a_mirrored_clip_has_the_same_numbers(plain, tmp_path):
    seconds, sizes = totals(filmed() * (-1, 1), tmp_path)
    assert sizes == plain[1] and seconds == pytest.approx(plain[0], abs=0.02)


def test_a_clip_played_backwards_has_the_same_numbers(plain, tmp_path):
    seconds, sizes = totals(filmed()[::-1], tmp_path)
    assert sizes == plain[1] and seconds == pytest.approx(plain[0], abs=0.02)


def test_the_order_in_which_people_are_found_does_not_matter(plain, tmp_path):
    rng = np.random.default_rng(4)
    seconds, sizes = totals(filmed(), tmp_path, order=[rng.permutation(4) for _ in range(FRAMES)])
    assert sizes == plain[1] and seconds == pytest.approx(plain[0], abs=1e-6)


def test_half_the_frames_give_nearly_the_same_numbers(plain, tmp_path):
    seconds, sizes = totals(filmed()[::2], tmp_path, times=np.arange(FRAMES)[::2] * STEP)
    assert sizes == plain[1] and seconds == pytest.approx(plain[0], rel=0.06, abs=0.1)


def test_a_clip_that_begins_later_has_the_same_numbers(plain, tmp_path):
    seconds, sizes = totals(filmed(), tmp_path, times=100 + np.arange(FRAMES) * STEP)
    assert sizes == plain[1] and seconds == pytest.approx(plain[0], abs=1e-6)
    assert all((tmp_path / f"{name}.csv").exists() for name in TABLES)


def test_what_people_tell_and_what_is_stated_are_weighed_by_their_certainty():
    """By information: precisions add up, and what is correlated with a stated part moves along."""
    lens = Camera.centred(900.0, 1280, 960)
    root = np.array([[0.03, 0, 0, 0], [0.002, 0.01, 0, 0], [-0.04, 0.01, 0.05, 0], [0.02, 0, 0.03, 0.06]])
    own = root @ root.T
    told = Mount(0.30, 0.01, 5.0, tuple(map(tuple, own.tolist())), lens)
    stated = Mount.stated(0.36, height_m=5.6, pitch_sd_rad=0.02, height_sd_m=0.28)
    found = weighed(told, stated)
    said = np.diag([1 / 0.02**2, 0, 1 / 0.05**2, 0])
    precision = np.linalg.inv(own) + said
    before = np.array([0.30, 0.01, math.log(5.0), 0.0])
    mean = np.linalg.solve(precision, np.linalg.inv(own) @ before + said @ (0.36, 0, math.log(5.6), 0))
    after = (found.pitch_rad, found.roll_rad, math.log(found.height_m), math.log(found.camera.f_px / 900.0))
    assert after == pytest.approx(mean)
    assert np.array(found.covariance) == pytest.approx(np.linalg.inv(precision))
    assert found.camera.focal_rel_sd == pytest.approx(math.sqrt(np.linalg.inv(precision)[3, 3]))
