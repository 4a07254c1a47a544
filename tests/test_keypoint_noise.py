"""The noise law: what it promises for every score, joint and size."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from proxemetry.people import People
from proxemetry.people.keypoint_noise import NoiseLaw, apparent_stature_px, law_of, laws, people_sd_px, sd_px
from proxemetry.people.skeleton import COCO_17, SKELETONS

SCORES = st.floats(0.01, 1.0)
SIZES = st.floats(10, 5000)


@given(st.sampled_from(sorted(laws())), st.sampled_from(COCO_17.joints), SCORES, SCORES, SIZES)
def test_a_surer_joint_is_never_worse(source: str, joint: str, one: float, other: float, body_px: float) -> None:
    low, high = sorted((one, other))
    assert sd_px(source, joint, high, body_px) <= sd_px(source, joint, low, body_px)


@given(st.sampled_from(COCO_17.joints), SCORES, SIZES, st.floats(1, 10))
def test_noise_grows_with_the_body_but_never_faster(joint: str, score: float, body_px: float, factor: float) -> None:
    near, far = sd_px("coco17", joint, score, body_px * factor), sd_px("coco17", joint, score, body_px)
    assert far * (1 - 1e-12) <= near <= far * factor * (1 + 1e-12)


def test_the_law_in_numbers() -> None:
    law = NoiseLaw({"hip": 0.03, "other": 0.5}, {"hip": 0.01, "other": 0.5}, 1.0, 5.0, "made up")
    # score 0.25 makes the spread four times as large: 400 px * hypot(0.03, 0.04) = 20 px beside the floor's 5 px
    assert law.sd_px("left_hip", 0.25, 400) == pytest.approx(np.hypot(20, 5))
    assert law.sd_px("mid_hip", 1.0, 2) == pytest.approx(np.hypot(5, np.hypot(1, 1))), "not listed: as others"
    assert law.sd_px("right_hip", 0.05, 400) == law.sd_px("right_hip", 0.1, 400), "it was measured above a tenth"


def test_a_missing_joint_has_no_noise() -> None:
    assert np.isnan(sd_px("coco17", "nose", 0.0, 300))


def test_unknown_sources_and_joints_get_the_default() -> None:
    assert law_of("no-such-back-end") is laws()["default"]
    assert law_of("no-such-back-end", "body25") is laws()["body25"]
    assert sd_px("default", "left_thumb", 0.5, 100) == sd_px("default", "other", 0.5, 100)


def test_every_skeleton_is_listed_and_every_row_says_where_it_is_from() -> None:
    assert set(SKELETONS) <= set(laws())
    assert all(law.origin for law in laws().values())


def _standing(stature_px: float, seen: list[str]) -> People:
    """A 1.70 m person facing the camera, drawn at `stature_px`."""
    heights_m = {
        "nose": 1.57, "left_eye": 1.60, "right_eye": 1.60, "left_ear": 1.58, "right_ear": 1.58, "left_shoulder": 1.40,
        "right_shoulder": 1.40, "left_elbow": 1.12, "right_elbow": 1.12, "left_wrist": 0.86, "right_wrist": 0.86,
        "left_hip": 0.88, "right_hip": 0.88, "left_knee": 0.48, "right_knee": 0.48, "left_ankle": 0.08,
        "right_ankle": 0.08,
    }  # fmt: skip
    side = {"shoulder": 0.175, "hip": 0.09, "eye": 0.032}
    points = np.full((1, 17, 2), np.nan)
    for k, joint in enumerate(COCO_17.joints):
        if joint in seen:
            x = side.get(joint.split("_")[-1], 0.1) * (1 if joint.startswith("left") else -1)
            points[0, k] = np.array([x, -heights_m[joint]]) * stature_px / 1.70
    return People(COCO_17, points, np.where(np.isfinite(points[..., 0]), 1.0, 0.0))


@pytest.mark.parametrize(
    "seen",
    [list(COCO_17.joints), ["left_shoulder", "right_shoulder", "left_hip", "right_hip"], ["left_knee", "left_ankle"]],
)
def test_apparent_stature_is_near_the_truth_from_any_part(seen: list[str]) -> None:
    assert apparent_stature_px(_standing(500, seen))[0] == pytest.approx(500, rel=0.05)


def test_people_sd_has_a_number_for_every_seen_joint() -> None:
    sd = people_sd_px(_standing(500, ["nose", "left_shoulder", "right_shoulder", "left_hip", "right_hip"]))
    assert sd.shape == (1, 17)
    assert np.isfinite(sd).sum() == 5
    assert people_sd_px(People.none(COCO_17)).shape == (0, 17)
