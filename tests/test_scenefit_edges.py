"""Odd but valid photos: the joint fit answers with a position or with a reason, never with an error."""

from dataclasses import replace

import numpy as np
import pytest

from proxemetry.camera import Camera
from proxemetry.locate import LocateSettings, method_named
from proxemetry.locate.scenefit import locate
from proxemetry.locate.scenefit.hypotheses import body_types, with_stature
from proxemetry.people import People
from proxemetry.people.skeleton import COCO_17, SKELETONS
from synthetic.modelled import ADULTS, CAMERA, photo

FACE = [COCO_17.joints.index(j) for j in ("nose", "left_eye", "right_eye", "left_ear", "right_ear")]


def only(people, joints):
    keypoints = np.full_like(people.keypoints_px, np.nan)
    keypoints[:, joints] = people.keypoints_px[:, joints]
    return People(people.skeleton, keypoints, people.scores)


@pytest.mark.parametrize("name", SKELETONS)
def test_nobody(name):
    bodies = method_named("scene")(People.none(SKELETONS[name]), CAMERA, LocateSettings())
    assert len(bodies) == 0


def test_one_person_alone():
    people, truth = photo(1, count=1)
    bodies = locate(people, CAMERA, LocateSettings())
    assert bodies.positions_m[0, 2] == pytest.approx(truth[0, 2], rel=0.15)
    assert bodies.up is not None


def test_only_faces_are_placed_with_wide_intervals():
    people, truth = photo(2, noise_px=0.3)
    bodies = locate(only(people, FACE), CAMERA, ADULTS)
    assert bodies.placed.all()
    assert (np.abs(bodies.positions_m[:, 2] - truth[:, 2]) < 4 * bodies.position_sd_m[:, 2]).all()
    assert all("feet" not in basis for basis in bodies.basis)


def test_who_shows_nothing_stays_with_a_reason():
    people, _ = photo(4)
    keypoints = people.keypoints_px.copy()
    keypoints[1] = np.nan
    bodies = locate(People(COCO_17, keypoints, people.scores), CAMERA, ADULTS)
    assert not bodies.placed[1] and bodies.placed[[0, 2, 3]].all()
    assert bodies.reasons[1] is not None and "joints" in bodies.reasons[1]
    assert bodies.basis[1] == "" and np.isnan(bodies.stature_m[1])


def test_one_joint_is_not_enough():
    people, _ = photo(4, count=1)
    assert not locate(only(people, [0]), CAMERA, ADULTS).placed.any()


def test_all_joints_on_one_spot():
    keypoints = np.full((1, 17, 2), 500.0)
    assert not locate(People(COCO_17, keypoints, np.ones((1, 17))), CAMERA, ADULTS).placed.any()


@pytest.mark.parametrize("degrees", [-4, 20, 40, 60])
def test_steep_cameras(degrees):
    height = 1.1 + 6.5 * np.sin(np.radians(degrees))
    people, truth = photo(5, pitch=np.radians(degrees), height_m=height, depths_m=(6, 7.5))
    bodies = locate(people, CAMERA, ADULTS)
    assert bodies.positions_m[:, 2] == pytest.approx(truth[:, 2], rel=0.2)
    assert bodies.floor is not None
    assert bodies.floor.pitch_rad == pytest.approx(np.radians(degrees), abs=0.12)


def test_fifty_people():
    people, truth = photo(6, count=50)
    bodies = locate(people, CAMERA, ADULTS)
    assert np.median(np.abs(bodies.positions_m[:, 2] / truth[:, 2] - 1)) < 0.06


def test_a_wild_ankle_does_not_move_a_person():
    people, _ = photo(7)
    keypoints = people.keypoints_px.copy()
    keypoints[2, 15] += (150, -200)
    before = locate(people, CAMERA, ADULTS)
    after = locate(People(COCO_17, keypoints, people.scores), CAMERA, ADULTS)
    assert after.positions_m[:, 2] == pytest.approx(before.positions_m[:, 2], rel=0.06)


def test_off_the_floor():
    people, truth = photo(8, noise_px=0.5)
    keypoints = people.keypoints_px.copy()
    keypoints[0, :, 1] -= 1.0 * CAMERA.f_px / truth[0, 2]  # on a platform of one metre
    lifted = People(COCO_17, keypoints, people.scores)
    stated = locate(lifted, CAMERA, LocateSettings(body_size="adults", off_floor=frozenset({0})))
    assert stated.positions_m[:, 2] == pytest.approx(truth[:, 2], rel=0.12)
    assert "feet" not in stated.basis[0]


def test_an_uncertain_focal_length_widens_depth():
    people, _ = photo(9)
    exact = locate(people, CAMERA, ADULTS)
    unsure = locate(people, Camera.centred(1200, 1920, 1080, focal_rel_sd=0.2), ADULTS)
    assert (unsure.position_sd_m[:, 2] > 2 * exact.position_sd_m[:, 2]).all()


def test_body_sizes_of_single_people():
    people, _ = photo(10, count=2)
    stated = LocateSettings(body_size="adults", body_sizes=(None, "children"), floor="none")
    adults, child = (
        locate(people, CAMERA, LocateSettings(body_size="adults", floor="none")),
        locate(people, CAMERA, stated),
    )
    assert child.positions_m[1, 2] < adults.positions_m[1, 2]
    assert child.stature_m[1] < adults.stature_m[1]
    assert child.positions_m[0, 2] == pytest.approx(adults.positions_m[0, 2], rel=0.05)


def test_a_stature_is_one_more_observation_of_a_gaussian():
    grown, young = body_types("mixed", 0.05)
    told, _ = with_stature((grown, young), (1.8, 0.036))
    covariance = np.linalg.inv(grown.precision)
    row = np.eye(len(covariance))[:1]
    noise = (0.036 / 1.8) ** 2
    gain = covariance @ row.T / (row @ covariance @ row.T + noise)
    assert told.mean == pytest.approx(grown.mean + gain[:, 0] * (np.log(1.8) - grown.mean[0]))
    assert np.linalg.inv(told.precision) == pytest.approx(covariance - gain @ row @ covariance, abs=1e-9)
    assert told.log_volume == pytest.approx(np.linalg.slogdet(told.precision)[1])
    assert with_stature((grown, young), None) == (grown, young)


def test_who_is_small_is_likelier_a_child():
    types = body_types("mixed", 0.05)
    shares = [with_stature(types, (stature, 0.03)) for stature in (1.2, 1.75)]
    for kinds in shares:
        assert sum(k.weight for k in kinds) == pytest.approx(1)
        assert kinds[0].weight == max(k.weight for k in kinds)
    assert shares[0][0].mean[0] == pytest.approx(np.log(1.2), abs=0.03) and shares[0][0].weight > 0.99
    assert shares[1][0].weight > 0.99


@pytest.mark.parametrize("size", ["adults", "women", "men", "mixed", "children"])
def test_every_body_size(size):
    people, _ = photo(11, count=3)
    assert locate(people, CAMERA, LocateSettings(body_size=size)).placed.all()


def test_covariances_are_covariances():
    people, _ = photo(12)
    bodies = locate(people, CAMERA, LocateSettings())
    for covariance in (bodies.covariance_m2, *(m.covariance_m2 for m in bodies.modes)):
        assert covariance == pytest.approx(covariance.T)
        assert np.linalg.eigvalsh(covariance).min() > 0
    assert sum(m.weight for m in bodies.modes) == pytest.approx(1 if bodies.modes else 0)


def test_garbage_is_answered():
    rng = np.random.default_rng(0)
    for scale in (1.0, 50.0, 5000.0):
        keypoints = rng.normal(500, scale, (5, 17, 2))
        bodies = locate(People(COCO_17, keypoints, rng.random((5, 17))), CAMERA, LocateSettings())
        assert len(bodies) == 5


def test_two_joints_of_a_head_do_not_tell_the_distance():
    people, _ = photo(2, count=1)
    bodies = locate(only(people, FACE[:2]), CAMERA, ADULTS)  # nose and one eye
    assert not bodies.placed[0]
    assert bodies.reasons[0] is not None and "uncertain by" in bodies.reasons[0]


def test_a_heading_along_the_line_of_sight_is_turned_into_the_cameras():
    """Someone 30 degrees to the right who looks at the camera faces 30 degrees to the left of its axis."""
    people, _ = photo(13, count=2)
    keypoints = (
        people.keypoints_px
        + (CAMERA.f_px * np.tan(np.radians(30)) + CAMERA.cx, 0)
        - (np.nanmean(people.keypoints_px[..., 0], axis=1)[:, None, None] * (1, 0))
    )
    wide = Camera.centred(CAMERA.f_px, 4000, CAMERA.height)
    wide = replace(wide, cx=CAMERA.cx)
    looking = People(COCO_17, keypoints, people.scores, heading_rad=np.zeros(2), heading_sd_rad=np.full(2, 0.01))
    assert np.degrees(locate(looking, wide, ADULTS).heading_rad) == pytest.approx([-30, -30], abs=4)
