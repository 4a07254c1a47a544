"""The paper's four estimators against closed forms, and their laws."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from proxemetry.camera import Camera
from proxemetry.errors import SettingsError
from proxemetry.locate import LocateSettings, method_named
from proxemetry.locate.pinhole import _CUES, _NOISE_FLOOR_PX, _NOISE_SHARE
from proxemetry.people import People
from proxemetry.people.skeleton import BODY_25, COCO_17, HALPE_26
from synthetic.drawn import people_at

CAMERA = Camera.centred(1200, 1600, 1200, focal_rel_sd=0.03)
PLAIN = LocateSettings()
METHODS = ("torso", "shoulder", "pupil", "combined")
PLACES = [(-1.5, 0.1, 5.0), (1.5, -0.2, 9.0), (0.3, 0.0, 3.0)]
#: Where each cue's pair lies above the middle of the torso, metres.
RISE_M = {"torso": 0.0, "shoulder": 0.222, "pupil": 0.45}


def locate(method, people, camera=CAMERA, quirks=()):
    return method_named(method)(people, camera, LocateSettings(quirks=frozenset(quirks)))


def without(people, *joints, row=0):
    scores = people.scores.copy()
    for joint in joints:
        scores[row, people.skeleton.index(joint)] = 0
    return People(people.skeleton, people.keypoints_px, scores)


@pytest.mark.parametrize("skeleton", [COCO_17, BODY_25, HALPE_26], ids=lambda s: s.name)
@pytest.mark.parametrize("cue", ["torso", "shoulder", "pupil"])
def test_a_figure_of_the_papers_size_is_placed_exactly(cue, skeleton):
    bodies = locate(cue, people_at(PLACES, CAMERA, skeleton))
    expected = np.array(PLACES) - (0, RISE_M[cue], 0)
    assert bodies.positions_m == pytest.approx(expected)
    assert bodies.basis == (cue,) * 3


def test_combined_takes_the_position_nearest_to_the_camera():
    people = people_at([(0, 0, 5)], CAMERA)
    keypoints = people.keypoints_px.copy()
    for joint, shift in (("left_shoulder", 5), ("right_shoulder", -5)):  # wider shoulders look nearer
        keypoints[0, COCO_17.index(joint), 0] += shift
    bodies = locate("combined", People(COCO_17, keypoints, people.scores))
    width_px = 0.389 * 1200 / 5 + 10
    assert bodies.basis == ("shoulder",)
    assert bodies.positions_m[0, 2] == pytest.approx(1200 * 0.389 / width_px)


def test_who_cannot_be_placed_stays_with_a_reason():
    people = without(people_at(PLACES, CAMERA), "left_hip", row=1)
    bodies = locate("torso", people)
    assert bodies.placed.tolist() == [True, False, True]
    assert bodies.reasons[1] is not None and "hips" in bodies.reasons[1]
    assert np.isnan(bodies.positions_m[1]).all()


def test_a_face_seen_from_behind_gives_no_pupils():
    people = people_at([(0, 0, 5)], CAMERA)
    swapped = people.keypoints_px.copy()
    swapped[0, [1, 2]] = swapped[0, [2, 1]]
    assert not locate("pupil", People(COCO_17, swapped, people.scores)).placed[0]


@pytest.mark.parametrize("unseen", ["left_ear", "right_ear"])
def test_with_one_ear_the_pupils_are_far_eye_to_ear_over_1_95(unseen):
    people = without(people_at([(0, 0, 5)], CAMERA), unseen)
    far = np.hypot(0.0315 + 0.07, 0.01) / 1.95
    assert locate("pupil", people).positions_m[0, 2] == pytest.approx(0.063 / (far / 5))


def test_shoulders_of_unequal_halves_are_refused_where_the_neck_is_real():
    people = people_at([(0, 0, 5)], CAMERA, BODY_25)
    keypoints = people.keypoints_px.copy()
    keypoints[0, BODY_25.index("neck"), 0] += 8
    assert not locate("shoulder", People(BODY_25, keypoints, people.scores)).placed[0]


def test_quirk_shoulder_counter_hands_a_neighbours_shoulders_on():
    people = people_at(PLACES, CAMERA, BODY_25)
    keypoints = people.keypoints_px.copy()
    keypoints[0, BODY_25.index("neck"), 0] += 8
    bodies = locate("shoulder", People(BODY_25, keypoints, people.scores), quirks=["shoulder-counter"])
    assert bodies.positions_m[:2, 2] == pytest.approx([9, 3])
    assert not bodies.placed[2]


def test_quirk_code_torso_length():
    depth = locate("torso", people_at([(0, 0, 5)], CAMERA), quirks=["code-torso-length"]).positions_m[0, 2]
    assert depth == pytest.approx(5 * 444.5 / 444)


def test_quirk_zero_length_puts_a_person_into_the_camera():
    people = people_at([(0, 0, 5)], CAMERA, BODY_25)
    keypoints = people.keypoints_px.copy()
    keypoints[0, BODY_25.index("mid_hip")] = keypoints[0, BODY_25.index("neck")]
    flat = People(BODY_25, keypoints, people.scores)
    assert not locate("torso", flat).placed[0]
    assert locate("torso", flat, quirks=["zero-length"]).positions_m[0].tolist() == [0, 0, 0]


def test_an_unknown_quirk_is_refused():
    with pytest.raises(SettingsError, match="wobble"):
        locate("torso", people_at(PLACES, CAMERA), quirks=["wobble"])


@pytest.mark.parametrize("method", METHODS)
def test_nobody_gives_nobody(method):
    assert len(locate(method, People.none(COCO_17))) == 0


@pytest.mark.parametrize("method", METHODS)
@given(factor=st.floats(0.2, 5))
def test_scaling_photo_and_focal_length_together_changes_no_position(method, factor):
    people = people_at(PLACES, CAMERA)
    scaled = Camera(1200 * factor, 1200 * factor, 800 * factor, 600 * factor, 1, 1)
    there = locate(method, people.scaled(factor, factor), scaled).positions_m
    assert there == pytest.approx(locate(method, people).positions_m)


@pytest.mark.parametrize("method", METHODS)
@given(order=st.permutations(range(3)))
def test_permuting_people_permutes_bodies(method, order):
    people, order = people_at(PLACES, CAMERA), list(order)
    bodies, permuted = locate(method, people), locate(method, people[order])
    assert permuted.positions_m == pytest.approx(bodies.positions_m[order])
    rows = np.concatenate([[3 * i, 3 * i + 1, 3 * i + 2] for i in order])
    assert permuted.covariance_m2 == pytest.approx(bodies.covariance_m2[np.ix_(rows, rows)])


@pytest.mark.parametrize("method", METHODS)
def test_mirroring_mirrors(method):
    people = people_at(PLACES, CAMERA)
    mirrored = locate(method, people.mirrored(1600), CAMERA.mirrored())
    assert mirrored.positions_m == pytest.approx(locate(method, people).positions_m * (-1, 1, 1))


@pytest.mark.parametrize("method", METHODS)
def test_the_covariance_is_symmetric_and_positive_and_shares_the_focal_length(method):
    bodies = locate(method, people_at(PLACES, CAMERA))
    covariance = bodies.covariance_m2
    assert covariance == pytest.approx(covariance.T)
    assert np.linalg.eigvalsh(covariance).min() > -1e-9
    assert covariance[2, 5] >= 0.03**2 * 5 * 9 * 0.99  # both depths scale with f


@pytest.mark.parametrize(("cue", "above_m"), [("torso", 0.0), ("shoulder", 0.255), ("pupil", 0.48)])
def test_a_place_above_the_torso_is_known_to_be_one_and_is_the_same_for_who_is_placed_alike(cue, above_m):
    covariance = locate(cue, people_at(PLACES, CAMERA)).covariance_m2
    heights = covariance[1::3, 1::3]
    assert heights.diagonal().min() >= above_m**2
    # what is shared cancels between two of a kind: what is left is the error of the depth and of the joints
    apart = heights[0, 0] + heights[1, 1] - 2 * heights[0, 1]
    assert apart <= heights[0, 0] + heights[1, 1] - 2 * above_m**2 + 0.05**2


def test_who_is_placed_by_the_eyes_may_be_as_high_as_who_is_placed_by_the_torso():
    people = without(people_at([(-1, 0, 5), (1, 0, 5)], CAMERA), "left_hip", row=0)
    people = without(people, "left_shoulder", row=0)
    bodies = locate("combined", people)
    assert bodies.basis == ("pupil", "torso")
    blocks = bodies.covariance_m2.reshape(2, 3, 2, 3)
    between = blocks[0, :, 0] + blocks[1, :, 1] - blocks[0, :, 1] - blocks[1, :, 0]
    assert between[1, 1] >= 0.48**2


@pytest.mark.parametrize(("cue", "turned_rad"), [("shoulder", np.pi), ("pupil", np.pi / 3)])
def test_who_faces_anywhere_is_as_near_as_the_interval_says(cue, turned_rad):
    """A turned body looks narrower, so farther away: the depth times 1 / cos h, and no other error."""
    headings = np.linspace(0, turned_rad, 201)[:-1] + turned_rad / 400
    shown = np.abs(np.cos(headings))
    joints = {"shoulder": ("left_shoulder", "right_shoulder"), "pupil": ("left_eye", "right_eye")}[cue]
    people = people_at([(0, 0, 5)] * len(headings), CAMERA)
    keypoints = people.keypoints_px.copy()
    rows = [people.skeleton.index(joint) for joint in joints]
    middle = keypoints[:, rows].mean(axis=1, keepdims=True)
    keypoints[:, rows] = middle + (keypoints[:, rows] - middle) * shown[:, None, None]
    bodies = locate(cue, People(people.skeleton, keypoints, people.scores))
    depth, sd = bodies.positions_m[:, 2], bodies.position_sd_m[:, 2]
    assert depth == pytest.approx(5 / shown)
    assert np.mean((depth - 5) ** 2 / depth**2) <= np.mean(sd**2 / depth**2)
    assert np.mean(np.abs(depth - 5) <= 1.645 * sd) >= 0.9


def test_a_constant_that_is_off_moves_two_people_together():
    sure = Camera.centred(1200, 1600, 1200)
    bodies = locate("torso", people_at([(0.5, 0, 4), (-1, 0, 8)], sure), sure)
    # no focal length to share: what is common is the torso's constant, 8 % of each place (METHOD: 444 mm)
    shared = 0.08**2 * np.outer(bodies.positions_m[0], bodies.positions_m[1])
    assert bodies.covariance_m2[:3, 3:] == pytest.approx(shared)


def _people_by_torso(places):
    """Necks and hips alone of upright people at places (n, 3), so that `torso` places them exactly there."""
    keypoints = np.full((len(places), 17, 2), np.nan)
    for row, (x, y, z) in enumerate(places):
        for name, above in (("shoulder", 0.222), ("hip", -0.222)):
            for side in ("left", "right"):
                pixel = CAMERA.project([x, y - above, z])
                keypoints[row, COCO_17.joints.index(f"{side}_{name}")] = pixel
    return People(COCO_17, keypoints, np.where(np.isnan(keypoints[..., 0]), 0.0, 0.9))


def _spread(places, **camera):
    sure = replace(CAMERA, focal_rel_sd=0.0, principal_sd_px=0.0)
    return locate("torso", _people_by_torso(places), replace(sure, **camera)).covariance_m2.reshape(
        -1, 3, len(places), 3
    )


def test_what_the_lens_adds_is_depth_for_the_focal_length_and_a_shift_for_the_principal_point():
    """X and Y do not depend on the focal length: the depth and 1/f scale together. All people are off alike."""
    places = np.array([(0.0, 0.0, 5.0), (1.5, 0.3, 8.0)])
    plain, z = _spread(places), places[:, 2]
    expected = np.zeros_like(plain)
    expected[:, 2, :, 2] = 0.1**2 * np.outer(z, z)
    assert _spread(places, focal_rel_sd=0.1) - plain == pytest.approx(expected, abs=1e-12)
    expected[:] = 0.0
    for axis in (0, 1):
        expected[:, axis, :, axis] = (20 / CAMERA.f_px) ** 2 * np.outer(z, z)
    assert _spread(places, principal_sd_px=20.0) - plain == pytest.approx(expected, abs=1e-12)


def test_a_persons_own_uncertainty_is_of_both_joints_and_the_bodys_length():
    """On the axis: across it the middle of two joints, of half a joint's variance; along it the body's length too."""
    z = 5.0
    own = _spread(np.array([(0.0, 0.0, z)]))[0, :, 0, :]
    noise = np.hypot(_NOISE_FLOOR_PX, _NOISE_SHARE * 0.5 * CAMERA.f_px / z)
    across = (z / CAMERA.f_px) ** 2 * noise**2 / 2
    torso = _CUES["torso"]
    ends = np.sqrt(2) * noise / (torso.length_m * CAMERA.f_px / z)
    along = z**2 * (torso.population**2 + torso.angle**2 + torso.constant**2 + ends**2)
    assert own == pytest.approx(np.diag([across, across, across + along]), rel=1e-6, abs=1e-12)
