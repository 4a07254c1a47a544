"""One camera from the people of many photos: what counts once, what counts more often, and what never evens out."""

import math
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

import proxemetry.locate.scenefit.pooled as pooled_module
from proxemetry.calibration.people import _mount, joined_people
from proxemetry.camera import Camera, Mount
from proxemetry.clip.floor_identity import followed
from proxemetry.locate import LocateSettings
from proxemetry.locate.scenefit import shared_prior
from proxemetry.locate.scenefit.body_model import body_model
from proxemetry.locate.scenefit.departures import departures_of
from proxemetry.locate.scenefit.fit import explained_people
from proxemetry.locate.scenefit.pooled import _overdispersion, _without_repetition, pooled
from proxemetry.locate.scenefit.pooled_equations import Level, equations_of
from proxemetry.locate.scenefit.projection import DEPTH, LOG_LENGTHS, N_LOCAL, torso_position
from proxemetry.locate.scenefit.tilt import FALL_SD
from proxemetry.people import People
from proxemetry.people.skeleton import COCO_17
from synthetic.modelled import photo

LENS = Camera.centred(1200, 1920, 1080)
OPEN = Camera.centred(1700, 1920, 1080, focal_rel_sd=0.5)
PITCH, ROLL, HEIGHT, FOCAL = range(4)


def crowd(count=8, pitches=(0.3,), depths_m=(7, 18), first=0):
    """Return people of photos before a camera 5 m high, who each is, and which photo each is in."""
    parts = [photo(first + k, count=4, pitch=pitches[k % len(pitches)], height_m=5.0, depths_m=depths_m)[0]
             for k in range(count)]  # fmt: skip
    people = joined_people(parts)
    return people, np.arange(len(people)), np.repeat(np.arange(count), [len(p) for p in parts])


def told(people, persons, camera=LENS, views=None):
    return pooled(people, camera, persons, LocateSettings(), views)


def test_what_is_known_once_does_not_count_with_every_row():
    whole = np.arange(3.0)[:, None, None] + np.eye(N_LOCAL) * 5 + np.full((N_LOCAL, N_LOCAL), 0.1)
    free = _without_repetition(whole)
    # lengths are the person's, and how far away people are photographed is a guess about one photo
    assert not free[:, LOG_LENGTHS].any() and not free[:, :, LOG_LENGTHS].any()
    assert (free[:, DEPTH, DEPTH] <= 1e-3).all()
    kept = np.setdiff1d(np.arange(N_LOCAL), [DEPTH, *range(LOG_LENGTHS.start, LOG_LENGTHS.stop)])
    assert (free[:, kept[:, None], kept] == whole[:, kept[:, None], kept]).all()


def test_a_lens_that_was_carried_about_is_told_by_all_photos_together():
    people, persons, views = crowd(12, pitches=(0.2, 0.3, 0.42))
    found = told(people, persons, OPEN, views)
    f_px, sd = OPEN.f_px * math.exp(found.shared[FOCAL]), math.sqrt(found.covariance[FOCAL, FOCAL])
    assert abs(math.log(f_px / 1200)) < 2.5 * sd and sd < 0.12
    assert np.isnan(found.covariance[:3]).all() and not np.isnan(found.covariance[3:, 3:]).any()
    one = told(people[views == 0], persons[views == 0], OPEN, views[views == 0])
    assert one.covariance[FOCAL, FOCAL] > 2 * found.covariance[FOCAL, FOCAL]


def test_the_order_of_photos_does_not_matter():
    people, persons, views = crowd(5, pitches=(0.2, 0.35))
    order = np.random.default_rng(0).permutation(len(people))
    one, other = told(people, persons, OPEN, views), told(people[order], persons[order], OPEN, 7 - views[order])
    assert other.shared[FOCAL] == pytest.approx(one.shared[FOCAL], abs=2e-3)


def test_people_met_again_add_their_bodies_errors_and_no_more():
    found = told(*crowd()[:2])
    assert np.allclose(found.covariance_if_met(1.0), found.covariance)
    more = found.covariance_if_met(4.0) - found.covariance
    assert np.allclose(more, 3 * found.by_bodies)
    # a height hangs on statures above all; 32 people of 5 % each, and their share of the whole
    assert 0.005 < math.sqrt(found.by_bodies[HEIGHT, HEIGHT]) < 0.03
    assert np.linalg.eigvalsh(found.covariance - found.by_bodies).min() > -1e-12


def test_people_who_disagree_widen_it():
    stated, asked = np.array([4.0, 9.0, 1.0]), np.array([0, 1])
    agree = np.tile([[1.0, -1.0], [1.5, -1.5], [50.0, -50.0]], 4) / math.sqrt(2)  # the last is not asked
    assert _overdispersion(agree, stated, asked) == pytest.approx(8 / 7)
    assert _overdispersion(3 * agree, stated, asked) == pytest.approx(9 * 8 / 7)
    assert _overdispersion(agree / 3, stated, asked) == 1.0  # never surer than the noise allows
    assert _overdispersion(9 * agree[:, :4], stated, asked) == 1.0  # four people do not tell


def test_what_more_people_do_not_even_out_stays(monkeypatch):
    people, persons, views = crowd(8, pitches=(0.25, 0.4))
    whole = told(people, persons, OPEN, views)
    none = lambda *args: np.zeros((1, len(people), 2 * args[0].precision.shape[1] + 1))  # noqa: E731
    monkeypatch.setattr(pooled_module, "departures_of", none)
    bare = told(people, persons, OPEN, views)
    assert whole.shared[FOCAL] == pytest.approx(bare.shared[FOCAL])
    assert math.sqrt(whole.covariance[FOCAL, FOCAL] - bare.covariance[FOCAL, FOCAL]) > 0.02


def test_people_are_followed_over_the_floor_through_a_crossing():
    mount = Mount.stated(0.3, 0.0, 5.0, camera=LENS)
    from proxemetry.camera.floor_view import to_pixels

    frames, times = [], [k / 5 for k in range(20)]
    for t in times:
        feet = np.array([(-3 + 1.4 * t, 12.0), (3 - 1.4 * t, 13.2)])
        below, above = to_pixels(mount, feet), to_pixels(mount, feet, 1.7)
        keypoints = np.full((2, 17, 2), np.nan)
        keypoints[:, 15:] = below[:, None]
        size = (below[:, 1] - above[:, 1])[:, None] * (0.2, 0.0)
        frames.append(People(COCO_17, keypoints, np.where(np.isnan(keypoints[..., 0]), 0.0, 0.9),
                             boxes_px=np.concatenate([above - size, below + size], axis=1)))  # fmt: skip
    who = np.array(followed(frames, times, mount))
    assert (who == who[0]).all() and who[0, 0] != who[0, 1]
    alone = followed([People.none(COCO_17), frames[0]], [0.0, 30.0], mount)
    assert len(alone[0]) == 0 and len(set(alone[1].tolist())) == 2


@pytest.mark.parametrize("seed", range(3))
def test_a_level_that_is_eliminated_answers_as_in_the_whole(seed):
    """Five unknowns, two of them eliminated, and two right-hand sides: solved whole, the same steps come out."""
    rng = np.random.default_rng(seed)
    roots = rng.normal(size=(4, 5, 5))
    hessian, sides = roots @ roots.transpose(0, 2, 1) + 0.1 * np.eye(5), rng.normal(size=(4, 5, 2))
    own, above = np.array([1, 3]), np.array([0, 2, 4])
    level = Level.of(np.concatenate([hessian, sides], axis=2), own)
    for k in range(4):
        whole = np.linalg.solve(hessian[k], sides[k, :, 0])
        assert level.step(whole[None, above].repeat(4, axis=0))[k] == pytest.approx(whole[own])
        assert level.left[k][:, :3] == pytest.approx(np.linalg.inv(np.linalg.inv(hessian[k])[np.ix_(above, above)]))
        assert np.linalg.solve(level.left[k][:, :3], level.left[k][:, 3]) == pytest.approx(whole[above])
        # without a side of its own a level follows those above: by -response of each step
        response = np.linalg.solve(hessian[k][np.ix_(own, own)], hessian[k][np.ix_(own, above)])
        assert level.response[k] == pytest.approx(response)


@pytest.mark.parametrize("views", [1, 3])
def test_what_is_known_of_one_lens_counts_once_however_many_views_show_it(views):
    people, persons, of_view = crowd(views, pitches=(0.2, 0.35))
    prior, model = shared_prior(OPEN), body_model(COCO_17)
    begun = pooled_module._start(people, OPEN, persons, prior, LocateSettings(), model, of_view)
    assert begun is not None
    state = replace(begun[1], lens=prior.mean[3:] + np.array([0.3, 0.02, -0.01]))
    sd = prior.sd * np.where(np.arange(6) < 3, 1.0, 2.0)
    tight, loose = (equations_of(begun[0], state, replace(prior, sd=s)) for s in (prior.sd, sd))
    off = (state.lens - prior.mean[3:]) / prior.sd[3:]
    assert tight.cost - loose.cost == pytest.approx(0.5 * (1 - 1 / 4) * float(off @ off))
    added = tight.lens[:, :3] - loose.lens[:, :3]
    assert added == pytest.approx(np.diag(prior.sd[3:] ** -2 * (1 - 1 / 4)), rel=1e-6, abs=1e-6)


def test_what_was_found_of_a_camera_is_its_mount():
    """Places are in units of the fit's own focal length, in the pixels of the camera that was asked about."""
    asked = replace(LENS, fx=1000.0, fy=1010.0, focal_rel_sd=0.3)
    covariance = np.diag([0.01, 0.02, 0.03, 0.04, 0.05, 0.06]) ** 2
    found = SimpleNamespace(
        shared=np.array([0.3, -0.1, math.log(4.0), 0.05, 0.02, -0.03]), camera=asked.with_focal(1200.0), n_detections=99
    )
    mount = _mount(found, 12, covariance, asked, focal_known=False)
    assert (mount.pitch_rad, mount.roll_rad, mount.height_m) == pytest.approx((0.3, -0.1, 4.0))
    assert mount.sd == pytest.approx([0.01, 0.02, 0.03, 0.04])
    lens = mount.camera
    assert lens.f_px == pytest.approx(1200 * math.exp(0.05)) and lens.fy / lens.fx == pytest.approx(1.01)
    assert (lens.cx, lens.cy) == pytest.approx((asked.cx + 24, asked.cy - 36))
    assert lens.focal_rel_sd == pytest.approx(0.04)
    sure = _mount(found, 12, covariance, replace(asked, focal_rel_sd=0.0), focal_known=True)
    assert np.isnan(sure.sd[3]) and sure.camera.focal_rel_sd == 0


def test_departures_are_what_a_joint_off_by_so_much_moves_in_the_picture():
    """Before a level camera: a share of the stature over the depth, upwards; a pixel's worth where that is a step."""
    people, _ = photo(4, count=2, pitch=0.0, noise_px=0.0, depths_m=(5, 9))
    model = body_model(COCO_17)
    seen = explained_people(people, LENS, shared_prior(LENS), LocateSettings("adults"), model)
    assert seen is not None
    rows, local = seen.rows.taken(seen.first), seen.fit.local
    cameras = np.tile(np.zeros(6), (2, 1))
    found = departures_of(rows, local, cameras, model, 0.001, focal_sought=True)
    kinds, joints = list(model.kinds), rows.precision.shape[1]
    assert found.shape == (2 * len(kinds) + 2 + 2, 2, 2 * joints + 1)
    stature, depth = np.exp(local[:, LOG_LENGTHS.start]), np.exp(local[:, DEPTH])
    for k, name in enumerate(kinds):
        x, y = found[2 * k, :, :joints], found[2 * k, :, joints:-1]
        share = math.hypot(0.015, {"feet": 0.030, "legs": 0.025}.get(name, 0.0))
        moved = np.abs(y[:, model.kinds[name]]).mean(axis=1)
        assert moved == pytest.approx(share * stature / depth, rel=0.06)  # a joint is a little nearer or farther
        assert not y[:, ~model.kinds[name]].any() and np.abs(x).max() < 1e-9
        step = found[2 * k + 1, :, joints:-1]
        assert np.abs(step[:, model.kinds[name]]) == pytest.approx(0.001) and not step[:, ~model.kinds[name]].any()
    # a lean is seen away in part: aside by that share of the height above the middle, were bodies to lean
    assert not found[2 * len(kinds), :, joints:].any()
    # the floor falls to the right and ahead, by the distance from the middle of the people
    places = torso_position(local, cameras)
    for row, along in zip(found[-2:], (0, 2), strict=True):
        assert row[:, -1] == pytest.approx(FALL_SD * (places[:, along] - places[:, along].mean()))
        assert not row[:, :-1].any()


def test_each_photo_pulls_at_a_carried_lens_by_what_its_own_place_leaves(monkeypatch):
    """What its people say of the lens, less what their photo's pitch, roll and height take up of it."""
    people, persons, views = crowd(4, pitches=(0.2, 0.35))
    made, pulled = [], []
    equations_at = pooled_module.equations_of
    monkeypatch.setattr(pooled_module, "equations_of", lambda *a, **k: made.append(equations_at(*a, **k)) or made[-1])
    monkeypatch.setattr(pooled_module, "_overdispersion", lambda pulls, *_: pulled.append(pulls) or 1.0)
    told(people, persons, OPEN, views)
    last, pulls = made[-1], pulled[-1]
    count = last.lens.shape[0]
    inverse, side = np.linalg.inv(last.lens[:, :count]), 3 + count
    # the places are not where the people alone would have them: eye level is usual
    assert np.abs(last.by_view[:, :3, side]).max() > 1e-3
    for view, (seen, answer) in enumerate(zip(last.by_view, last.views.response, strict=True)):
        expected = inverse @ (seen[3:, side] - answer.T @ seen[:3, side])
        assert pulls[:, view] == pytest.approx(expected, rel=1e-6, abs=1e-9)
