"""The body model and its projection: closed forms, and derivatives against differences."""

import numpy as np
import pytest

from proxemetry.anthropometry import moments, populations
from proxemetry.locate.scenefit.body_model import _TYPICAL, body_model
from proxemetry.locate.scenefit.body_tables import LATENTS, POSTURES, SHOE_M
from proxemetry.locate.scenefit.projection import (
    DEPTH,
    FOCAL,
    HEADING,
    HEIGHT,
    LOG_LENGTHS,
    N_LOCAL,
    N_SHARED,
    PITCH,
    POSTURE,
    TURN,
    BodyTables,
    camera_axes,
    project,
)
from proxemetry.people.skeleton import BLAZEPOSE_33, COCO_17, HALPE_26, SKELETONS

LENGTHS_M = [1.70, 1.36, 0.52, 0.35, 0.063, 0.15]


def tables(model, posture=(0,)):
    return BodyTables.of(model, np.array(posture))


def rows(count, rng=None):
    local = np.zeros((count, N_LOCAL))
    local[:, DEPTH] = np.log(5.0)
    local[:, LOG_LENGTHS] = np.log(LENGTHS_M)
    if rng is not None:
        local[:, :2] = rng.normal(0, 0.2, (count, 2))
        local[:, HEADING], local[:, TURN] = rng.normal(0, 2, count), rng.normal(0, 0.4, count)
        local[:, POSTURE] = rng.normal(0, 0.05, (count, len(LATENTS)))
    return local


def test_a_level_camera_sees_lengths_over_depth():
    model = body_model(COCO_17)
    seen = project(rows(1), np.zeros(N_SHARED), tables(model)).points[0].T
    at = {COCO_17.joints[c]: point for c, point in zip(model.columns, seen, strict=True)}
    # facing the camera the left shoulder is on the right, half of .35 m from the middle, half of .52 m above it
    assert at["left_shoulder"] == pytest.approx((0.175 / 5, -0.26 / 5))
    assert at["left_hip"][1] == pytest.approx(0.26 / 5)
    assert at["left_eye"][0] - at["right_eye"][0] == pytest.approx(0.063 / (5 - 0.56 * 0.15))
    assert at["nose"][0] == pytest.approx(0)


def test_heading_turns_towards_the_right_of_the_image():
    model = body_model(COCO_17)
    local = rows(1)
    local[:, HEADING] = np.pi / 2
    seen = project(local, np.zeros(N_SHARED), tables(model)).points[0].T
    at = {COCO_17.joints[c]: point for c, point in zip(model.columns, seen, strict=True)}
    assert at["nose"][0] > 0.01  # the face leads to the right
    assert at["left_shoulder"][0] == pytest.approx(0, abs=1e-9)


def test_a_sole_on_the_floor():
    shared = np.zeros(N_SHARED)
    local = rows(1)
    # a level camera at the height of the torso's middle: 1.36 - .26 m and the shoe
    shared[HEIGHT] = np.log(1.36 - 0.26 + SHOE_M)
    assert project(local, shared, tables(body_model(COCO_17))).floor == pytest.approx([0.0])


def test_looking_down_puts_up_towards_the_viewer():
    # Floor's definition: up is (sin r cos p, -cos r cos p, -sin p)
    (matrix,) = camera_axes(np.array([[0.3, 0.1]]))
    expected = (np.sin(0.1) * np.cos(0.3), -np.cos(0.1) * np.cos(0.3), -np.sin(0.3))
    assert -matrix[:, 1] == pytest.approx(expected)
    assert matrix @ matrix.T == pytest.approx(np.eye(3))
    assert np.linalg.det(matrix) == pytest.approx(1)


def test_derivatives_agree_with_differences():
    rng = np.random.default_rng(0)
    model, posture = body_model(HALPE_26), np.array([0, 1, 0])
    local, shared = rows(3, rng), np.array([0.2, 0.1, 0.5, 0.05, 0.01, -0.02])
    here, step = project(local, shared, tables(model, posture)), 1e-6
    for k in range(N_LOCAL + N_SHARED):
        moved, moved_shared = local.copy(), shared.copy()
        if k < N_LOCAL:
            moved[:, k] += step
        else:
            moved_shared[k - N_LOCAL] += step
        there = project(moved, moved_shared, tables(model, posture))
        by_difference = np.column_stack([(there.points - here.points).reshape(3, -1), there.floor - here.floor]) / step
        assert by_difference == pytest.approx(here.equations[..., k], abs=1e-5)


def test_focal_and_depth_trade_places():
    shared = np.zeros(N_SHARED)
    shared[FOCAL] = 0.1
    local = rows(1)
    point = project(local, shared, tables(body_model(COCO_17)))
    assert point.points[0].mean(axis=1)[0] == pytest.approx(0, abs=1e-9)
    assert abs(point.equations[0, :-1, N_LOCAL + PITCH]).max() < 1


@pytest.mark.parametrize("name", SKELETONS)
def test_left_mirrors_right(name):
    model = body_model(SKELETONS[name])
    joints = [SKELETONS[name].joints[c] for c in model.columns]
    for k, joint in enumerate(joints):
        if joint.startswith("left"):
            other = joints.index(joint.replace("left", "right"))
            for posture in range(len(POSTURES)):
                assert model.rest[posture, k] == pytest.approx(model.rest[posture, other] * (1, -1, 1))
                assert model.spread[k] == model.spread[other]


def test_blazeposes_ears_lie_nearer_together_and_to_the_face():
    def ears(skeleton):
        model = body_model(skeleton)
        at = [list(model.columns).index(skeleton.index(f"{side}_ear")) for side in ("left", "right")]
        return (model.head @ np.array(LENGTHS_M))[0, at]

    ours, coco = ears(BLAZEPOSE_33), ears(COCO_17)
    assert (ours[0] - ours[1]) / (coco[0] - coco[1])[1] == pytest.approx((0, 0.64, 0))
    assert ours[:, 0] == pytest.approx(0.20 * LENGTHS_M[-1])
    assert coco[:, 0] == pytest.approx(0)


@pytest.mark.parametrize(("joint", "higher"), [("knee", 0.006), ("ankle", 0.010), ("hip", 0.009), ("heel", 0.0)])
def test_blazeposes_joints_below_the_trunk_lie_higher(joint, higher):
    def height(skeleton):
        model = body_model(skeleton)
        return model.rest[0, list(model.columns).index(skeleton.index(f"left_{joint}")), 2]

    assert height(BLAZEPOSE_33) - height(HALPE_26) == pytest.approx(higher)


@pytest.mark.parametrize(
    ("latent", "joint", "moved"),
    [  # forward, left and up, in statures (or in heights above the torso's middle, for what leans) a unit
        ("head_forward", "nose", (1, 0, 0)), ("head_down", "nose", (0, 0, -1)), ("head_forward", "left_hip", (0, 0, 0)),
        ("slump", "left_shoulder", (0, 0, -0.5)), ("slump", "left_hip", (0, 0, 0.5)),
        ("crouch", "left_ankle", (0, 0, 1)), ("crouch", "left_knee", (1.2, 0, 0.5)),
        ("left_foot_forward", "left_ankle", (1, 0, 0)), ("left_foot_forward", "left_knee", (0.5, 0, 0)),
        ("left_foot_forward", "right_ankle", (0, 0, 0)), ("left_foot_out", "left_ankle", (0, 1, 0)),
        ("left_foot_out", "left_knee", (0, 0.5, 0)), ("right_foot_out", "right_ankle", (0, -1, 0)),
        ("right_foot_up", "right_ankle", (0, 0, 1)), ("right_foot_up", "right_knee", (0, 0, 0.5)),
    ],
)  # fmt: skip
def test_a_latent_moves_what_its_name_says(latent, joint, moved):
    model = body_model(COCO_17)
    k = list(model.columns).index(COCO_17.index(joint))
    assert model.latent[0, k, :, LATENTS.index(latent)] == pytest.approx(moved)


@pytest.mark.parametrize("joint", ["nose", "left_shoulder", "left_hip"])
def test_who_leans_leans_about_the_torsos_middle_and_nods_about_the_ears(joint):
    model, in_statures = body_model(COCO_17), np.array(LENGTHS_M) / LENGTHS_M[0]
    k = list(model.columns).index(COCO_17.index(joint))
    forward, _, up = (model.body[0, k] @ in_statures).tolist()
    moved = model.latent[0, k]
    assert forward == 0
    assert moved[:, LATENTS.index("lean_forward")] == pytest.approx((up, 0, 0), rel=0.05)
    assert moved[:, LATENTS.index("lean_left")] == pytest.approx((0, up, 0), rel=0.05)
    face = model.head[0, k, 0] @ in_statures  # how far before the ears
    assert moved[:, LATENTS.index("nod")] == pytest.approx((0, 0, -face), rel=0.1)
    assert (face > 0) == (joint == "nose")


@pytest.mark.parametrize("posture", [p for p in POSTURES if p != "lying"])
def test_feet_stay_on_the_floor_however_long_a_body_is_and_however_it_bends(posture):
    """An ankle is the torso's height above the sole below the torso's middle, but for its own height above the sole."""
    p, model = POSTURES.index(posture), body_model(COCO_17)
    for side in ("left", "right"):
        k = list(model.columns).index(COCO_17.index(f"{side}_ankle"))
        assert model.body[p, k, 2] == pytest.approx(-model.torso[p])
        above_floor = model.rest[p, k, 2] + model.torso_rest[p]
        assert 0.02 < above_floor < (0.25 if posture == "riding" else 0.12)  # feet of who rides are on pedals
        for name in ("crouch", "lean_forward"):
            d = LATENTS.index(name)
            assert model.latent[p, k, 2, d] == pytest.approx(-model.torso_latent[p, d])
        slump = LATENTS.index("slump")
        assert model.latent[p, k, 2, slump] == pytest.approx(-model.torso_latent[p, slump], abs=0.25)


def test_typical_lengths_are_the_populations():
    mean, _ = moments(populations("adults"))
    statures = np.exp(mean - mean[0])
    assert pytest.approx(statures, rel=0.05) == _TYPICAL
