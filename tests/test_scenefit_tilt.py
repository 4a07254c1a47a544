"""Bodies that are seen as if from less far above than they are: shape, derivatives, and the cameras that follow."""

from dataclasses import replace

import numpy as np
import pytest

import proxemetry.locate.scenefit.evidence as evidence_module
import proxemetry.locate.scenefit.pooled_equations as equations_module
from proxemetry.locate import LocateSettings
from proxemetry.locate.scenefit.body_model import body_model
from proxemetry.locate.scenefit.fit import locate
from proxemetry.locate.scenefit.pooled import pooled
from proxemetry.locate.scenefit.projection import (
    DEPTH,
    HEADING,
    HEIGHT,
    LOG_LENGTHS,
    N_LOCAL,
    N_SHARED,
    PITCH,
    POSTURE,
    ROLL,
    BodyTables,
    angle_from_above,
    camera_axes,
    project,
    torso_position,
)
from proxemetry.locate.scenefit.tilt import TILT_SD_RAD, by_tilt, expected_tilt
from proxemetry.people.keypoint_noise import laws
from proxemetry.people.skeleton import COCO_17
from synthetic.modelled import ADULTS, CAMERA, LENGTHS_M, camera_above, on_floor, people_of

MODEL = body_model(COCO_17)
DEGREE = float(np.deg2rad(1))


def tables(count, tilt_rad=0.0, roll_rad=0.0):
    bodies = BodyTables.of(MODEL, np.zeros(count, dtype=np.intp))
    return replace(bodies, tilt=np.tile([tilt_rad, roll_rad], (count, 1)))


def standing(count, seed, pitch_rad, height_m, depths_m):
    """Return people on the floor before a camera, (P, N_LOCAL), and the camera."""
    rng = np.random.default_rng(seed)
    local = np.zeros((count, N_LOCAL))
    local[:, LOG_LENGTHS] = np.log(LENGTHS_M) + rng.normal(0, 0.03, (count, 1))
    local[:, HEADING] = rng.uniform(-3, 3, count)
    local[:, POSTURE] = rng.normal(0, 0.01, local[:, POSTURE].shape)
    local[:, DEPTH] = np.log(rng.uniform(*depths_m, count))
    local[:, 0] = np.linspace(-0.5, 0.5, count)
    shared = camera_above(height_m, pitch_rad)
    return on_floor(local, shared)[0], shared


def seen_too_level(by_rad, count=4, seed=0, pitch_rad=0.4, height_m=3.0, depths_m=(4, 7), source="yolox-tinypose"):
    """Return people of whom each is seen at a tilt."""
    local, shared = standing(count, seed, pitch_rad, height_m, depths_m)
    joints = project(local, shared, tables(count, -by_rad)).points.transpose(0, 2, 1)
    noise = np.random.default_rng([seed, 1]).normal(0, 1.0, joints.shape) / CAMERA.f_px
    return replace(people_of(joints + noise), source=source)


def test_a_tilted_body_looks_as_from_there_and_as_long_as_it_is():
    shared = np.zeros(N_SHARED)
    shared[PITCH], shared[HEIGHT] = 0.5, np.log(40.0)
    local = np.zeros((1, N_LOCAL))
    local[:, DEPTH], local[:, LOG_LENGTHS] = np.log(80.0), np.log(LENGTHS_M)  # far: no perspective within the body
    joints = [COCO_17.joints[k] for k in MODEL.columns]
    at = lambda pitch, tilt: dict(zip(joints, project(  # noqa: E731
        local, np.array([pitch, 0, shared[HEIGHT], 0, 0, 0]), tables(1, tilt)
    ).points[0].T * 80, strict=True))  # fmt: skip
    body, tilted, shallower = at(0.5, 0.0), at(0.5, -0.1), at(0.4, 0.0)
    length = lambda seen: seen["left_ankle"][1] - seen["left_shoulder"][1]  # noqa: E731
    assert length(tilted) == pytest.approx(length(body), rel=0.01)
    assert length(shallower) > 1.04 * length(body)
    # the face stands out towards the camera, and down in the picture by the sine of the angle: less of it is seen
    lower = lambda seen: (seen["nose"][1] - seen["left_ear"][1]) / length(seen)  # noqa: E731
    assert lower(tilted) == pytest.approx(lower(shallower), abs=2e-3)
    assert lower(tilted) < lower(body) - 5e-3


def test_the_floor_stays_where_it_is():
    local, shared = standing(3, 1, 0.4, 3.0, (4, 7))
    level, tilted = project(local, shared, tables(3)), project(local, shared, tables(3, -0.1, 0.05))
    assert tilted.floor == pytest.approx(level.floor, abs=1e-12)
    assert tilted.equations[:, -1, :-1] == pytest.approx(level.equations[:, -1, :-1], abs=1e-12)
    assert np.abs(tilted.points - level.points).max() > 1e-3


def test_derivatives_of_tilted_bodies_agree_with_differences():
    local, shared = standing(3, 2, 0.35, 3.0, (4, 7))
    bodies, step = tables(3, -0.06, 0.02), 1e-6
    here = project(local, shared, bodies)
    for k in range(N_LOCAL + N_SHARED):
        moved, moved_shared = local.copy(), shared.copy()
        if k < N_LOCAL:
            moved[:, k] += step
        else:
            moved_shared[k - N_LOCAL] += step
        there = project(moved, moved_shared, bodies)
        by_difference = np.column_stack([(there.points - here.points).reshape(3, -1), there.floor - here.floor]) / step
        # that a body which moves in the picture is looked down at from another angle is left out
        in_picture = k in (0, 1, N_LOCAL + ROLL) or k > N_LOCAL + HEIGHT
        left_out = 0.02 if in_picture else 0.005 if k == N_LOCAL + PITCH else 1e-5
        assert by_difference == pytest.approx(here.equations[..., k], abs=left_out), k


def test_derivatives_by_the_tilt_agree_with_differences():
    local, shared = standing(3, 3, 0.35, 3.0, (4, 7))
    here, step = project(local, shared, tables(3, -0.05, 0.02)), 1e-6
    found = by_tilt(here.equations, angle_from_above(local, shared))
    for k, more in enumerate(np.eye(2) * step):
        there = project(local, shared, tables(3, -0.05 + more[0], 0.02 + more[1]))
        assert (there.points - here.points).reshape(3, -1) / step == pytest.approx(found[:, :-1, k], abs=1e-5)
    assert not found[:, -1].any()


def test_how_steeply_somebody_is_looked_down_at():
    local, shared = standing(2, 4, 0.3, 3.0, (5, 9))
    sight = torso_position(local, shared)
    down = camera_axes(shared[None, PITCH : ROLL + 1])[0, :, 1]
    expected = np.arctan2(sight @ down, np.linalg.norm(sight - (sight @ down)[:, None] * down, axis=1))
    assert angle_from_above(local, shared) == pytest.approx(expected)
    assert (expected > 0.1).all()


def test_people_straight_below_are_not_shrunk_to_nothing():
    local, shared = np.zeros((1, N_LOCAL)), camera_above(8.0, np.deg2rad(89.0))
    local[:, DEPTH], local[:, LOG_LENGTHS] = np.log(6.5), np.log(LENGTHS_M)
    assert angle_from_above(local, shared) == pytest.approx([np.deg2rad(53.0)])
    level, tilted = (project(local, shared, tables(1, tilt)) for tilt in (0.0, -0.1))
    size = [np.ptp(seen.points, axis=2) for seen in (level, tilted)]
    assert size[1] == pytest.approx(size[0], rel=0.35)
    assert np.isfinite(tilted.equations[..., :-1]).all()


def test_no_tilt_is_expected_at_eye_level_and_all_of_it_from_ten_degrees_on():
    tilt = expected_tilt(2 * DEGREE, np.deg2rad([-30, 0, 5, 10, 50]))
    assert tilt[:, 0] == pytest.approx(np.deg2rad([0, 0, -1, -2, -2]))
    assert not tilt[:, 1].any()


def test_networks_see_people_too_level_and_who_placed_joints_by_hand_does_not():
    for name in ("yolox-tinypose", "nanodet-movenet", "blazepose"):
        assert laws()[name].too_level_deg == 2.0
    assert laws()["coco17"].too_level_deg == laws()["korte_parts"].too_level_deg == 0.0


def test_a_camera_that_looks_down_is_found_further_down_where_bodies_are_known_to_look_too_level(monkeypatch):
    law = laws()["yolox-tinypose"]
    off = {}
    for too_level in (0.0, 5.0):
        monkeypatch.setattr(evidence_module, "law_for", lambda _, deg=too_level: replace(law, too_level_deg=deg))
        found = [locate(seen_too_level(5 * DEGREE, seed=s), CAMERA, ADULTS).floor for s in range(6)]
        off[too_level] = np.mean([floor.pitch_rad for floor in found if floor]) - 0.4
    assert off[5.0] > off[0.0] + 2 * DEGREE
    assert abs(off[5.0]) < abs(off[0.0])


def test_many_people_on_a_floor_show_the_camera_whatever_their_bodies_tilt(monkeypatch):
    people = seen_too_level(5 * DEGREE, count=40, pitch_rad=0.3, height_m=6.0, depths_m=(10, 25))
    found = pooled(people, CAMERA, np.arange(40), LocateSettings())
    assert found is not None
    assert abs(found.shared[PITCH] - 0.3) < 2 * np.sqrt(found.covariance[PITCH, PITCH]) < 2 * DEGREE
    assert found.covariance.shape == found.by_bodies.shape == (N_SHARED, N_SHARED)
    monkeypatch.setattr(equations_module, "TILT_SD_RAD", TILT_SD_RAD / 1000)
    trusting = pooled(people, CAMERA, np.arange(40), LocateSettings())
    assert trusting is not None
    # with bodies trusted: nearer to level, however many people there are
    assert trusting.shared[PITCH] < found.shared[PITCH] - 0.3 * DEGREE
    assert trusting.covariance[PITCH, PITCH] < found.covariance[PITCH, PITCH]
    assert found.cost < trusting.cost - 1.0
