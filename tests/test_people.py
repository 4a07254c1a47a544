"""People: what is missing stays missing, rows never move."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from proxemetry.camera import Camera
from proxemetry.errors import KeypointsError, SettingsError
from proxemetry.people import People
from proxemetry.people.skeleton import BODY_25, COCO_17, HALPE_26, SKELETONS, skeleton_named
from synthetic.drawn import people_at

CAMERA = Camera.centred(1000, 1200, 900)


@pytest.mark.parametrize("skeleton", SKELETONS.values(), ids=lambda s: s.name)
def test_every_skeleton_has_distinct_joints_and_mirrors_twice_to_itself(skeleton):
    assert len(set(skeleton.joints)) == len(skeleton)
    assert [skeleton.mirror[i] for i in skeleton.mirror] == list(range(len(skeleton)))


def test_halpes_joints_behind_cocos_are_in_mmposes_order():
    assert HALPE_26.joints[:17] == COCO_17.joints
    assert [HALPE_26.index(joint) for joint in ("head_top", "neck", "mid_hip")] == [17, 18, 19]
    feet = [f"{side}_{part}" for part in ("big_toe", "small_toe", "heel") for side in ("left", "right")]
    assert list(HALPE_26.joints[20:]) == feet


@pytest.mark.parametrize("spelling", ["COCO-17", "coco_17", "coco17"])
def test_skeletons_are_found_by_loose_spelling(spelling):
    assert skeleton_named(spelling) is COCO_17


def test_an_unknown_skeleton_is_refused():
    with pytest.raises(SettingsError, match="smpl"):
        skeleton_named("smpl")


def test_score_zero_means_missing_and_a_keypoint_at_the_origin_does_not():
    keypoints, scores = np.zeros((1, 17, 2)), np.zeros((1, 17))
    scores[0, 3] = 0.5
    people = People(COCO_17, keypoints, scores)
    assert np.isnan(people.joint("nose")).all()
    assert people.joint("left_ear").tolist() == [[0, 0]]


def test_nobody_is_a_value():
    nobody = People.none(BODY_25)
    assert len(nobody) == 0
    assert nobody.part("Head").shape == (0, 2)
    assert nobody.mirrored(100).boxes_px.shape == (0, 4)


def test_parts_of_a_drawn_figure():
    people = people_at([(0, 0, 5)], CAMERA)
    centre_u, centre_v, metre_px = 600, 450, 200
    assert people.part("Torso")[0] == pytest.approx([centre_u, centre_v])
    assert people.part("Shoulder")[0] == pytest.approx([centre_u, centre_v - 0.222 * metre_px])
    assert people.part("Eyes")[0] == pytest.approx([centre_u, centre_v - 0.45 * metre_px])
    assert people.part("Head")[0] == pytest.approx([centre_u, centre_v - 0.44 * metre_px])


def test_one_visible_eye_is_the_eyes_centre_and_none_is_nan():
    people = people_at([(0, 0, 5)], CAMERA)
    scores = people.scores.copy()
    scores[0, COCO_17.index("left_eye")] = 0
    one = People(COCO_17, people.keypoints_px, scores)
    assert one.part("Eyes")[0] == pytest.approx(one.joint("right_eye")[0])
    scores[0, COCO_17.index("right_eye")] = 0
    assert np.isnan(People(COCO_17, people.keypoints_px, scores).part("Eyes")).all()


def test_mirroring_twice_changes_nothing():
    people = people_at([(1, 0, 5), (-1, 0.2, 8)], CAMERA)
    again = people.mirrored(1200).mirrored(1200)
    assert again.keypoints_px == pytest.approx(people.keypoints_px)
    assert again.boxes_px == pytest.approx(people.boxes_px)


@given(st.permutations(range(4)))
def test_choosing_rows_chooses_rows(order):
    people = people_at([(k - 2.0, 0, 5 + k) for k in range(4)], CAMERA)
    assert people[list(order)].part("Torso") == pytest.approx(people.part("Torso")[list(order)])


def test_input_arrays_are_neither_changed_nor_shared():
    keypoints, scores = np.ones((1, 17, 2)), np.zeros((1, 17))
    people = People(COCO_17, keypoints, scores)
    assert (keypoints == 1).all()
    assert not np.shares_memory(people.keypoints_px, keypoints)
    with pytest.raises(ValueError, match="read-only"):
        people.keypoints_px[0] = 0


def test_wrong_shapes_are_refused():
    with pytest.raises(KeypointsError, match="shape"):
        People(COCO_17, np.zeros((2, 17, 2)), np.zeros((1, 17)))
    with pytest.raises(KeypointsError, match="boxes_px"):
        People(COCO_17, np.zeros((2, 17, 2)), np.zeros((2, 17)), boxes_px=np.zeros((1, 4)))


def test_one_visible_shoulder_stands_for_the_shoulders_centre():
    people = people_at([(0, 0, 5)], CAMERA)
    scores = people.scores.copy()
    scores[0, COCO_17.index("left_shoulder")] = 0
    one = People(COCO_17, people.keypoints_px, scores)
    assert one.part("Shoulder")[0] == pytest.approx(one.joint("right_shoulder")[0])
    assert np.isnan(one.part("Torso")).all()


def test_who_saw_people_stays_with_them():
    people = replace(people_at([(1, 0, 5), (-1, 0.2, 8)], CAMERA), source="blazepose")
    assert people[1].source == people.mirrored(1200).scaled(0.5, 0.5).source == "blazepose"
