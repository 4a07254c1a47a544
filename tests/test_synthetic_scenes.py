"""The synthetic scenes obey their own truth."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from proxemetry.people.skeleton import BOX, SKELETONS
from synthetic.bodies import draw_build, draw_posture, pose_joints
from synthetic.detections import EXACT, Detector
from synthetic.scenes import KINDS, Recipe, SyntheticPhoto, scenes


def photos(count: int = 12, seed: int = 3, **recipe: object) -> list[SyntheticPhoto]:
    return list(scenes(count, seed, replace(Recipe(), **recipe)))  # type: ignore[arg-type]


def test_population_has_the_measured_means_and_spreads() -> None:
    rng = np.random.default_rng(0)
    builds = [draw_build(rng) for _ in range(3000)]
    stature = np.array([build.stature for build in builds])
    torso = np.array([build.torso for build in builds])
    shoulders = np.array([build.shoulders for build in builds])
    assert stature.mean() == pytest.approx(1.692, abs=0.006)
    assert stature.std() == pytest.approx(0.092, abs=0.006)
    assert 0.47 < torso.mean() < 0.50  # neck to mid-hip of real keypoints
    assert 0.32 < shoulders.mean() < 0.36
    assert 0.6 < np.corrcoef(shoulders, stature)[0, 1] < 0.85  # .55 within a sex, more over both


@pytest.mark.parametrize("seated", [False, True])
def test_bodies_stand_on_the_floor_and_keep_their_lengths(seated: bool) -> None:
    rng = np.random.default_rng(1)
    for _ in range(100):
        build = draw_build(rng)
        joints = pose_joints(build, draw_posture(rng, seated))
        lowest = min(point[2] for point in joints.values())
        assert lowest == pytest.approx(build.sole + 0.02)
        eyes = np.linalg.norm(joints["left_eye"] - joints["right_eye"])
        assert eyes == pytest.approx(build.pupils)
        shoulders = np.linalg.norm(joints["left_shoulder"] - joints["right_shoulder"])
        assert shoulders == pytest.approx(build.shoulders)
        assert joints["nose"][2] < joints["head_top"][2]
        assert joints["left_shoulder"][1] > joints["right_shoulder"][1]


@pytest.mark.parametrize("skeleton", [s for s in SKELETONS.values() if s != BOX], ids=lambda s: s.name)
def test_exact_detections_are_the_projected_joints(skeleton: object) -> None:
    for photo in photos(skeleton=skeleton, detector=EXACT):
        for row, owner in enumerate(photo.owners):
            for k, joint in enumerate(photo.people.skeleton.joints):
                u, v = photo.camera.project(photo.joints_m[joint][owner])
                inside = 0 <= u < photo.camera.width and 0 <= v < photo.camera.height
                assert (photo.people.scores[row, k] > 0) == inside
                if inside:
                    np.testing.assert_allclose(photo.people.keypoints_px[row, k], (u, v))


def test_truth_is_consistent_between_frames() -> None:
    for photo in photos():
        up = (
            np.sin(photo.roll_rad) * np.cos(photo.pitch_rad),
            -np.cos(photo.roll_rad) * np.cos(photo.pitch_rad),
            -np.sin(photo.pitch_rad),
        )
        np.testing.assert_allclose(photo.up, up, atol=1e-12)
        flat = photo.positions_m - np.outer(photo.positions_m @ photo.up, photo.up)
        distances = np.linalg.norm(flat[:, None] - flat[None], axis=-1)
        np.testing.assert_allclose(distances, photo.distances_m, atol=1e-9)
        heights = photo.height_m + np.stack([p @ photo.up for p in photo.joints_m.values()])
        assert heights.min() > 0.0  # nobody below the floor
        assert (photo.joints_m["head_top"] @ photo.up + photo.height_m < photo.stature_m + 0.08).all()


def test_a_photo_depends_on_its_seed_and_number_alone() -> None:
    few, many = photos(2), photos(4)
    np.testing.assert_array_equal(few[1].people.keypoints_px, many[1].people.keypoints_px)
    assert not np.array_equal(few[1].positions_m, photos(2, seed=4)[1].positions_m)


@pytest.mark.parametrize("kind", KINDS)
def test_every_kind_of_camera_gives_photos(kind: str) -> None:
    for photo in photos(4, kind=kind, posture="standing"):
        assert kind in ("mixed", photo.kind)
        assert len(photo.heading_rad) >= 2
        assert len(photo.people) >= 1
        assert not photo.seated.any()


def test_noise_scales_with_the_person_and_duplicates_are_known() -> None:
    noisy = photos(20, detector=Detector(noise=0.4, duplicate_rate=0.5, miss_rate=0.0, occlusion=False, outliers=0))
    duplicated, relative = 0, []
    for photo in noisy:
        duplicated += len(photo.owners) - len(set(photo.owners.tolist()))
        for row, owner in enumerate(photo.owners):
            truth = photo.camera.project(photo.joints_m["left_shoulder"][owner])
            torso = np.linalg.norm(
                photo.camera.project(photo.joints_m["neck"][owner])
                - photo.camera.project(photo.joints_m["mid_hip"][owner])
            )
            relative.append(np.linalg.norm(photo.people.joint("left_shoulder")[row] - truth) / torso)
    assert duplicated > 5
    assert 0.02 < np.nanmedian(relative) < 0.12  # a few centimetres on half a metre


def test_children_are_small() -> None:
    for photo in photos(6, children=1.0):
        assert photo.child.all()
        assert photo.stature_m.max() < 1.95
