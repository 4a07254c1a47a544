"""Known joints as a back end would see them (`benchmarks/accuracy/disturbed_joints.py`)."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from benchmarks.accuracy.disturbed_joints import HABITS, Disturbance, habit, heads_show, noise_px
from proxemetry.camera import Camera
from proxemetry.people.keypoint_noise import law_of, laws
from proxemetry.people.skeleton import COCO_17

K = COCO_17.joints.index
CAMERA = Camera.centred(1000.0, 2000, 2000)
DOWN = np.array([0.0, 1.0, 0.0])


def _person(facing_rad: float = 0.0) -> np.ndarray:
    """Joints (17, 3) of one who stands 4 m away, 0 facing the camera."""
    right_of, up, ahead = {"eye": 0.03, "ear": 0.08, "shoulder": 0.17, "hip": 0.1}, {}, {"nose": 0.1, "eye": 0.08}
    up |= {"nose": 1.55, "eye": 1.58, "ear": 1.56, "shoulder": 1.4, "elbow": 1.1, "wrist": 0.85, "hip": 0.9}
    up |= {"knee": 0.5, "ankle": 0.08}
    at = np.zeros((17, 3))
    for k, joint in enumerate(COCO_17.joints):
        kind = joint.split("_")[-1]
        side = right_of.get(kind, 0.1) * (joint != "nose") * (1 if joint.startswith("left") else -1)
        at[k] = side, 1.5 - up[kind], -ahead.get(kind, 0.0)
    c, s = np.cos(facing_rad), np.sin(facing_rad)
    return at @ np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]]) + (0, 0, 4)


def test_a_face_that_looks_away_and_a_far_ear_are_hidden() -> None:
    front, side, back = (heads_show(_person(a)[None])[0] for a in (0.0, np.pi / 2, np.pi))
    assert front.all()
    assert not back[[K("nose"), K("left_eye"), K("right_eye")]].any()
    assert back[[K("left_ear"), K("right_ear")]].all()
    assert side[[K("left_ear"), K("right_ear")]].sum() == 1
    assert side[K("nose")] and all(side[5:])


def test_the_ear_on_the_cameras_side_is_the_one_that_shows() -> None:
    for angle in (np.pi / 2, -np.pi / 2):
        person = _person(angle)
        shown = heads_show(person[None])[0]
        nearer = "left_ear" if person[K("left_ear"), 2] < person[K("right_ear"), 2] else "right_ear"
        assert shown[K(nearer)]


def test_nothing_is_disturbed_without_noise_and_habits() -> None:
    seen = Disturbance("yolox-tinypose", 0.0).seen(_person()[None], CAMERA, DOWN, np.random.default_rng(0))
    assert seen.keypoints_px[0] == pytest.approx(CAMERA.project(_person()))
    assert seen.source == "yolox-tinypose"


@pytest.mark.parametrize("name", sorted(HABITS))
@pytest.mark.parametrize("sine", [0.0, 0.6])
def test_noise_is_as_large_as_the_row_says(name: str, sine: float) -> None:
    law, rng = law_of(name), np.random.default_rng(1)
    exact = np.tile(CAMERA.project(_person()), (1, 1, 1))
    errors = np.array([noise_px(law, exact, np.array([400.0]), np.array([sine]), rng)[0] for _ in range(2000)])
    for joint in ("nose", "left_knee", "right_ankle"):  # no ends of lengths that are seen too long
        grown = law.score_noise([joint], [0.8])[0] * (1 + sine * law.grows_from_above([joint])[0]) * 400
        assert errors[:, K(joint)].std(axis=0) == pytest.approx(np.hypot(grown, law.floor_px), rel=0.06)


def test_people_of_a_photo_err_alike_and_torsos_are_seen_longer_as_a_whole() -> None:
    law, rng = law_of("yolox-tinypose"), np.random.default_rng(2)
    exact = np.tile(CAMERA.project(_person()), (2, 1, 1))
    errors = np.array([noise_px(law, exact, np.full(2, 400.0), np.zeros(2), rng) for _ in range(3000)])
    one, other = errors[:, 0, K("left_knee"), 0], errors[:, 1, K("left_knee"), 0]
    spread = law.score_noise(["left_knee"], [0.8])[0] * 400
    assert np.cov(one, other)[0, 1] == pytest.approx(0.5 * spread**2, rel=0.12)
    torso = exact[0, [K("left_hip"), K("right_hip")], 1].mean() - exact[0, [5, 6], 1].mean()
    longer = errors[:, 0, [K("left_hip"), K("right_hip")], 1].mean(axis=1) - errors[:, 0, [5, 6], 1].mean(axis=1)
    ends = sum((law.score_noise([j], [0.8])[0] * 400) ** 2 + law.floor_px**2 for j in ("left_hip", "left_shoulder")) / 2
    assert longer.std() == pytest.approx(np.hypot(law.common["torso"] * torso, np.sqrt(ends)), rel=0.08)


@given(st.sampled_from(sorted(HABITS)), st.floats(0.0, 1.0))
def test_habits_move_both_sides_towards_each_other_and_down(name: str, sine: float) -> None:
    exact = CAMERA.project(_person())[None]
    shift = habit(name, exact, np.array([sine]))[0]
    for joint in ("shoulder", "knee"):
        left, right = (shift[K(f"{side}_{joint}")] for side in ("left", "right"))
        assert left[0] == pytest.approx(-right[0])
        angle = np.rad2deg(np.arcsin(sine))
        down, inwards_by_view = HABITS[name][joint]
        assert left[1] == pytest.approx(right[1])
        assert left[1] == pytest.approx(np.interp(angle, (0, 10, 20, 30, 40, 53), down) / 100)
        apart = exact[0, K(f"left_{joint}"), 0] - exact[0, K(f"right_{joint}"), 0]
        inwards = -left[0] * np.sign(apart)
        assert inwards == pytest.approx(np.interp(angle, (0, 10, 20, 30, 40, 53), inwards_by_view) / 100)


def test_habits_are_of_back_ends_that_have_a_row() -> None:
    assert set(HABITS) <= set(laws())
