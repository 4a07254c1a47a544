"""Depths of people stated by other instruments: evidence of the fit, robust, its contradiction said."""

import json
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from proxemetry.bodies import MOST_DEPTH_MISFIT
from proxemetry.camera import Camera, CameraEstimate
from proxemetry.camera.sources import Doubt
from proxemetry.errors import KeypointsError
from proxemetry.locate import LocateSettings
from proxemetry.locate.scenefit import locate
from proxemetry.locate.scenefit.body_model import body_model
from proxemetry.locate.scenefit.evidence import evidence_of
from proxemetry.locate.scenefit.fit import explained_people, shared_prior
from proxemetry.locate.scenefit.projection import DEPTH, N_LOCAL
from proxemetry.locate.scenefit.solver import evaluate_rows
from proxemetry.measure import place, remeasure
from proxemetry.people import People
from proxemetry.people.skeleton import COCO_17
from proxemetry.pose.formats import read
from proxemetry.scene import Scene
from proxemetry.settings import Settings
from proxemetry.tables import rows
from synthetic.scenes import Recipe, scenes

PHOTO = next(
    p for p in scenes(40, 5, Recipe(kind="eye_level", posture="standing", focal_mm=(35.0,))) if len(p.people) == 5
)
TRUE_M = PHOTO.positions_m[PHOTO.owners, 2]


def _stating(depth_m, rel_sd=0.02):
    depth = np.asarray(depth_m, dtype=float)
    return replace(PHOTO.people, depth_m=depth, depth_sd_m=rel_sd * depth)


def _located(people):
    return locate(people, PHOTO.camera, LocateSettings())


def test_stated_depths_are_followed():
    plain, told = _located(PHOTO.people), _located(_stating(TRUE_M))
    off = np.abs(plain.positions_m[:, 2] / TRUE_M - 1)
    assert off.max() > 0.03
    assert np.abs(told.positions_m[:, 2] / TRUE_M - 1).max() < 0.01
    assert (told.position_sd_m[:, 2] < 0.03 * TRUE_M).all()
    assert all(basis.endswith("+depth") for basis in told.basis)
    assert not any("depth" in basis for basis in plain.basis)


@pytest.mark.parametrize("factor", [0.5, 1.5, 1000.0])
def test_a_wrong_depth_moves_nobody_else_and_is_noticed(factor):
    wrong = TRUE_M * np.array([1, factor, 1, 1, 1])
    told, off = _located(_stating(TRUE_M)), _located(_stating(wrong))
    others = [0, 2, 3, 4]
    assert np.abs(off.positions_m[others, 2] / told.positions_m[others, 2] - 1).max() < 0.02
    assert abs(off.positions_m[1, 2] / told.positions_m[1, 2] - 1) < 0.15
    assert np.sign(off.depth_misfit[1]) == np.sign(factor - 1) and abs(off.depth_misfit[1]) > MOST_DEPTH_MISFIT
    assert np.abs(off.depth_misfit[others]).max() < MOST_DEPTH_MISFIT
    assert "depth" not in off.basis[1]


def test_misfits_of_right_depths_are_standard_normal_or_smaller():
    found = []
    for number, photo in enumerate(scenes(25, 7)):
        true = photo.positions_m[photo.owners, 2]
        depth = true * (1 + 0.02 * np.random.default_rng(number).standard_normal(len(true)))
        people = replace(photo.people, depth_m=depth, depth_sd_m=0.02 * depth)
        found.append(locate(people, photo.camera, LocateSettings()).depth_misfit)
    misfit = np.concatenate(found)
    assert 0.6 < np.std(misfit) < 1.15 and np.mean(np.abs(misfit) > MOST_DEPTH_MISFIT) < 0.03


def test_the_contradiction_is_a_doubt_that_is_said_and_goes_when_it_is_settled():
    people = _stating(TRUE_M * np.array([1, 1, 2, 1, 1]))
    args = ("a.jpg", "", PHOTO.camera.width, PHOTO.camera.height)
    scene = place(*args, people, CameraEstimate(PHOTO.camera), Settings())
    (flag,) = [f for f in scene.camera.flags if f.doubt is Doubt.DEPTH]
    assert "contradicts 1 of the 5 stated depths (person 2" in str(flag)
    again = Scene.from_json(scene.to_json())
    assert again.camera.flags == scene.camera.flags
    np.testing.assert_allclose(again.bodies.depth_misfit, scene.bodies.depth_misfit, rtol=1e-6)
    np.testing.assert_allclose(again.people.depth_m, people.depth_m, rtol=1e-6)
    (photo,) = rows("photos", scene)
    assert "stated depths" in photo["camera_flags"]
    listed = rows("people", scene)
    assert listed[2]["stated_depth_m"] == pytest.approx(2 * TRUE_M[2], rel=1e-6) and listed[2]["depth_misfit"] > 3.3
    settled = remeasure(scene, Settings(), people=_stating(TRUE_M))
    assert not [f for f in settled.camera.flags if f.doubt is Doubt.DEPTH]


def test_scenes_without_depths_are_written_as_before():
    scene = place(
        "a.jpg", "", PHOTO.camera.width, PHOTO.camera.height, PHOTO.people, CameraEstimate(PHOTO.camera), Settings()
    )
    assert "depth_m" not in scene.to_json() and "depth_misfit" not in scene.to_json()
    assert rows("people", scene)[0]["stated_depth_m"] is None


@given(st.floats(-0.6, 0.6))
def test_the_evidence_row_is_student_t_with_the_right_derivative(shift):
    model = body_model(COCO_17)
    explained = explained_people(_stating(TRUE_M), PHOTO.camera, shared_prior(PHOTO.camera), LocateSettings(), model)
    batch, local, shared = explained.rows.taken(explained.first), explained.fit.local.copy(), explained.fit.shared
    local[:, DEPTH] += shift
    alone = replace(batch, depth_precision=np.zeros(len(batch)))
    told, cost, _ = evaluate_rows(batch, local, shared)
    plain, cost_without, _ = evaluate_rows(alone, local, shared)
    away = np.log(TRUE_M) - local[:, DEPTH]
    sd = np.hypot(0.02 * TRUE_M, 0.05) / TRUE_M
    np.testing.assert_allclose(cost - cost_without, 2 * np.log1p((away / sd) ** 2 / 3), rtol=1e-9)
    gradient = told[:, DEPTH, -1] - plain[:, DEPTH, -1]
    np.testing.assert_allclose(gradient, 4 * away / (3 * sd**2 + away**2), rtol=1e-6, atol=1e-9)
    apart = np.delete(told - plain, DEPTH, axis=1)
    assert np.abs(apart[:, : N_LOCAL - 1, :N_LOCAL]).max() == 0.0


def test_depth_counts_from_the_camera_along_its_axis():
    """Someone off to the side is nearer along the axis than in a straight line: the axis is what is meant."""
    bodies = _located(_stating(TRUE_M))
    far = np.argmax(np.abs(bodies.positions_m[:, 0]))
    straight = np.linalg.norm(bodies.positions_m[far])
    assert straight > 1.02 * TRUE_M[far] and bodies.positions_m[far, 2] == pytest.approx(TRUE_M[far], rel=0.01)


def test_people_check_their_depths():
    keypoints, scores = PHOTO.people.keypoints_px, PHOTO.people.scores
    for depth, sd, said in (
        ([1.0] * 5, [np.nan] * 5, "needs its standard deviation"),
        ([np.nan] * 5, [1.0] * 5, "needs its standard deviation"),
        ([-1.0] * 5, [1.0] * 5, "above 0"),
        ([1.0] * 5, [0.0] * 5, "above 0"),
        ([np.inf] * 5, [np.inf] * 5, "above 0"),
        ([1.0] * 4, [1.0] * 4, "shape"),
    ):
        with pytest.raises(KeypointsError, match=said):
            People(COCO_17, keypoints, scores, depth_m=np.array(depth), depth_sd_m=np.array(sd))
    people = _stating([1, 2, np.nan, 4, 5])
    np.testing.assert_array_equal(people[[4, 2]].depth_m, [5, np.nan])
    np.testing.assert_array_equal(people.mirrored(100).scaled(2, 2).depth_m, people.depth_m)


def _own(**person):
    points = [[float(x), float(y), 0.9] for x, y in np.nan_to_num(PHOTO.people.keypoints_px[0])]
    return {"skeleton": "coco17", "images": [{"filename": "a.jpg", "people": [{"keypoints": points, **person}]}]}


def _read(tmp_path, content):
    file = tmp_path / "people.json"
    file.write_text(json.dumps(content))
    return read(file).photos[0].people


def test_recorded_people_carry_depths_in_every_json_form(tmp_path):
    said = {"depth_m": 4.2, "depth_sd_m": 0.08}
    own = _own(**said)
    flat = [v for row in own["images"][0]["people"][0]["keypoints"] for v in row]
    annotations = {
        "images": [{"id": 1, "file_name": "a.jpg"}], "categories": [],
        "annotations": [{"image_id": 1, "keypoints": flat, **said}],
    }  # fmt: skip
    results = [{"image_id": 1, "keypoints": flat, "score": 0.9, **said}]
    for content in (own, annotations, results):
        people = _read(tmp_path, content)
        assert (people.depth_m[0], people.depth_sd_m[0]) == (4.2, 0.08)
    boxes = {"skeleton": "box", "images": [{"filename": "a", "people": [{"box": [1, 2, 3, 9], **said}]}]}
    assert _read(tmp_path, boxes).depth_m[0] == 4.2
    assert np.isnan(_read(tmp_path, _own()).depth_m[0])


@pytest.mark.parametrize(
    ("person", "said"),
    [
        ({"depth_m": 3}, "people.json, images\\[0\\]: depth_sd_m is missing"),
        ({"depth_sd_m": 3}, "depth_m is missing"),
        ({"depth_m": 0, "depth_sd_m": 1}, "depth_m is 0: it must be metres above 0"),
        ({"depth_m": "4", "depth_sd_m": 1}, "depth_m is 4: it must be"),
        ({"depth_m": True, "depth_sd_m": 1}, "depth_m is True"),
        ({"depth_m": 4, "depth_sd_m": -1}, "depth_sd_m is -1"),
        ({"depth_m": float("nan"), "depth_sd_m": 1}, "depth_m is nan"),
        ({"depth_m": 1e300, "depth_sd_m": 1}, "depth_m is 1e\\+300"),
        ({"depth_m": [4], "depth_sd_m": 1}, "depth_m is \\[4\\]"),
    ],
)
def test_depths_that_are_none_are_one_line(tmp_path, person, said):
    with pytest.raises(KeypointsError, match=said):
        _read(tmp_path, _own(**person))


def test_a_depth_alone_does_not_make_a_person_usable():
    unseen = People(COCO_17, np.full((1, 17, 2), np.nan), np.zeros((1, 17)), depth_m=[4.0], depth_sd_m=[0.1])
    bodies = locate(unseen, Camera.centred(1000.0, 1600, 1200), LocateSettings())
    assert not bodies.placed.any() and "two usable joints" in bodies.reasons[0]
    assert np.isnan(evidence_of(PHOTO.people, PHOTO.camera, body_model(COCO_17)).log_depth).all()
