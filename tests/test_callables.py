"""Anyone's detector as a back end: a function's answer, whatever library it comes from."""

from __future__ import annotations

import sys
from hashlib import sha256
from types import SimpleNamespace

import numpy as np
import pytest

from proxemetry.errors import KeypointsError, SettingsError
from proxemetry.people import People
from proxemetry.people.skeleton import BODY_25, COCO_17, HALPE_26
from proxemetry.photo import Photo
from proxemetry.pose import backend_named
from proxemetry.pose.callables import CallableBackend, people_from

XY = np.arange(2 * 17 * 2, dtype=float).reshape(2, 17, 2) + 1
SCORES = np.full((2, 17), 0.5)
BOXES = np.array([[0.0, 0, 50, 90], [10, 0, 60, 90]])


class Tensor:
    """What a tensor library's array offers: no array until it is moved and turned into one."""

    def __init__(self, values):
        self.values = np.asarray(values)

    def detach(self):
        return self

    def cpu(self):
        return self

    def numpy(self):
        return self.values


ANSWERS = {
    "People": People(COCO_17, XY, SCORES),
    "array with scores": np.concatenate([XY, SCORES[..., None]], axis=2),
    "pair": (XY, SCORES),
    "supervision": SimpleNamespace(xy=XY, confidence=SCORES, class_id=None),
    "newer supervision": SimpleNamespace(xy=XY, keypoint_confidence=SCORES, detection_confidence=np.array([0.7, 0.6])),
    "Ultralytics": SimpleNamespace(
        keypoints=SimpleNamespace(xy=Tensor(XY), conf=Tensor(SCORES)),
        boxes=SimpleNamespace(xyxy=Tensor(BOXES), conf=Tensor([0.7, 0.6])),
    ),
    "MMPose": SimpleNamespace(
        pred_instances=SimpleNamespace(
            keypoints=XY, keypoint_scores=SCORES, bboxes=BOXES, bbox_scores=np.array([0.7, 0.6])
        )
    ),
}


@pytest.mark.parametrize("kind", ANSWERS)
def test_every_librarys_answer_is_the_same_people(kind):
    people = people_from(ANSWERS[kind])
    assert people.skeleton is COCO_17
    np.testing.assert_array_equal(people.keypoints_px, XY)
    np.testing.assert_array_equal(people.scores, SCORES)
    if kind in ("Ultralytics", "MMPose"):
        np.testing.assert_array_equal(people.boxes_px, BOXES)
        np.testing.assert_array_equal(people.person_scores, [0.7, 0.6])


def test_what_supervision_calls_invisible_is_missing():
    visible = np.ones((2, 17), dtype=bool)
    visible[1, 3] = False
    for scores in (SCORES, None):
        people = people_from(SimpleNamespace(xy=XY, keypoint_confidence=scores, visible=visible))
        np.testing.assert_array_equal(np.isfinite(people.keypoints_px).all(axis=-1), visible)


def test_zero_zero_is_missing():
    points = XY.copy()
    points[0, 3] = 0
    people = people_from((points, SCORES))
    assert np.isnan(people.keypoints_px[0, 3]).all()
    assert people.scores[0, 3] == 0


@pytest.mark.parametrize("empty", [np.zeros((0, 26, 3)), np.zeros((0, 17, 2)), []])
def test_nobody_is_nobody(empty):
    assert len(people_from(empty)) == 0


@pytest.mark.parametrize(("count", "skeleton"), [(17, COCO_17), (25, BODY_25), (26, HALPE_26)])
def test_the_number_of_joints_says_which_skeleton(count, skeleton):
    assert people_from(np.ones((1, count, 3))).skeleton is skeleton


@pytest.mark.parametrize("answer", [np.ones((1, 14, 3)), np.ones((17, 3)), "people", object(), None, {"a": 1}])
def test_what_is_not_understood_is_an_error_that_names_the_detector(answer):
    with pytest.raises(KeypointsError, match="my detector"):
        people_from(answer, origin="my detector")


def test_a_function_is_a_back_end():
    def detector(pixels):
        assert pixels.shape == (48, 64, 3)
        return XY, SCORES

    backend = CallableBackend(detector)
    people = backend.detect(Photo.from_array(np.zeros((48, 64, 3), np.uint8)))
    assert backend.name == "python:detector"
    np.testing.assert_array_equal(people.keypoints_px, XY)


def test_a_function_by_name(tmp_path, monkeypatch):
    (tmp_path / "my_detector.py").write_text(
        "import numpy as np\ndef find(pixels):\n    return np.ones((1, 17, 3))\nnumber = 3\n"
    )
    monkeypatch.syspath_prepend(tmp_path)
    backend = backend_named("python:my_detector:find")
    assert len(backend.detect(Photo.from_array(np.zeros((8, 8, 3), np.uint8)))) == 1
    for wrong in ("python:my_detector:absent", "python:no_such_module:find", "python:my_detector:number", "python"):
        with pytest.raises(SettingsError):
            backend_named(wrong)


def test_a_function_in_the_current_folder_is_found(tmp_path, monkeypatch):
    monkeypatch.setattr(sys, "path", [p for p in sys.path if p])  # as an installed command has it
    monkeypatch.chdir(tmp_path)
    (tmp_path / "detector_right_here.py").write_text(
        "import numpy as np\ndef find(pixels): return np.ones((1, 17, 3))\n"
    )
    backend = backend_named("python:detector_right_here:find")
    assert len(backend.detect(Photo.from_array(np.zeros((8, 8, 3), np.uint8)))) == 1
    assert sys.path[-1] == str(tmp_path)  # last: no file there takes a package's place
    (digest,) = backend.models.values()  # so that a run does not go on with another function of that name
    assert digest == sha256((tmp_path / "detector_right_here.py").read_bytes()).hexdigest()
