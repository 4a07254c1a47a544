"""Pupils in the place of eyes: whose head is looked at, where the face is thought to be, and what is believed."""

from __future__ import annotations

import logging
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from proxemetry import weights
from proxemetry.archive.run.work import Job
from proxemetry.locate import MEASURE_PUPILS, METHODS
from proxemetry.people import People
from proxemetry.people.skeleton import COCO_17
from proxemetry.photo import Photo
from proxemetry.pose import PoseOptions, backend_named
from proxemetry.pose.blazepose.eyes import Pupils
from proxemetry.pose.pupils import LEAST_APART_PX, PupilNetworks, face_box
from proxemetry.settings import Settings
from synthetic.dotted_world import specification
from tests.test_blazepose import PHOTOS

RIGHT, LEFT = COCO_17.joints.index("right_eye"), COCO_17.joints.index("left_eye")
PIXELS = np.zeros((400, 400, 3), np.uint8)
UNSEEN = np.full(2, np.nan)
#: Three women of a photo: x and y of the right and of the left eye, put down by eye.
EYES = ((346, 158, 359, 158), (222, 107, 234, 107), (131, 107, 145, 107))


def _heads(*eyes: tuple[tuple[float, float], tuple[float, float]]) -> People:
    """People of whom a nose and both eyes are seen, right one first."""
    points, scores = np.full((len(eyes), 17, 2), np.nan), np.zeros((len(eyes), 17))
    for row, (right, left) in enumerate(eyes):
        points[row, [0, RIGHT, LEFT]] = (np.add(right, left) / 2 + (0, 9), right, left)
        scores[row, [0, RIGHT, LEFT]] = 0.8, 0.7, 0.6
    return People(COCO_17, points, scores, source="somebody")


class _Finder:
    """Sees both pupils so far aside of where the eyes were said to be."""

    def __init__(self, aside: float | np.ndarray) -> None:
        self.aside, self.asked = aside, 0

    def find(self, picture: object, box_px: object, points_px: np.ndarray) -> Pupils:
        self.asked += 1
        return Pupils(points_px[1] + self.aside, points_px[0] + self.aside, 0.9)


def _with(finder: _Finder, monkeypatch: pytest.MonkeyPatch) -> PupilNetworks:
    networks = PupilNetworks(None, None)  # type: ignore[arg-type]
    monkeypatch.setattr(networks, "_loaded", lambda: finder)
    return networks


def test_large_heads_that_face_the_camera_get_pupils(monkeypatch: pytest.MonkeyPatch) -> None:
    near = LEAST_APART_PX + 1, LEAST_APART_PX - 1
    people = _heads(((100, 50), (100 + near[0], 50)), ((200, 50), (200 + near[1], 50)), ((330, 50), (300, 50)))
    finder = _Finder(1.5)
    seen = _with(finder, monkeypatch).in_place_of_eyes(people, PIXELS)
    moved = seen.keypoints_px - people.keypoints_px
    assert finder.asked == 1
    assert moved[0, [RIGHT, LEFT]] == pytest.approx(1.5)
    assert np.nan_to_num(np.delete(moved[0], [RIGHT, LEFT], axis=0)) == pytest.approx(0)
    assert np.nan_to_num(moved[1:]) == pytest.approx(0)
    assert (seen.scores == people.scores).all() and seen.source == people.source


@pytest.mark.parametrize(("aside", "believed"), [(9.0, True), (11.0, False)])
def test_the_eye_that_moved_most_is_compared_with_half_the_eyes_distance(monkeypatch, aside, believed) -> None:
    people = _heads(((100, 50), (120, 50)))
    across = _with(_Finder(np.array([aside, 0.0])), monkeypatch).in_place_of_eyes(people, PIXELS)
    assert (across.keypoints_px[0, LEFT, 0] != 120) == believed


@pytest.mark.parametrize(("aside", "believed"), [(4.0, True), (9.0, False)])
def test_pupils_of_another_face_are_not_believed(monkeypatch, aside, believed) -> None:
    people = _heads(((100, 50), (120, 50)))
    seen = _with(_Finder(aside), monkeypatch).in_place_of_eyes(people, PIXELS)
    assert (seen.keypoints_px[0, LEFT, 0] != 120) == believed


@given(st.floats(-3.1, 3.1), st.floats(5, 500), st.floats(-1000, 1000))
def test_a_face_is_where_the_chin_is(angle: float, apart: float, shift: float) -> None:
    across = apart * np.array([np.cos(angle), np.sin(angle)])
    eyes = np.stack([[shift, shift], shift + across])
    box = face_box(eyes, UNSEEN, UNSEEN)
    assert box[2:] - box[:2] == pytest.approx(3 * apart)
    middle = (box[:2] + box[2:]) / 2 - eyes.mean(axis=0)
    assert middle @ across == pytest.approx(0, abs=1e-6 * apart**2)
    down = np.array([-across[1], across[0]])  # of a head upright, whose left eye is to the right: (0, 1)
    assert middle @ down == pytest.approx(0.45 * apart**2)


def test_a_head_turned_aside_is_as_large_as_its_ears_say() -> None:
    eyes = np.array([[100.0, 50.0], [110.0, 50.0]])
    box = face_box(eyes, np.array([60.0, 52.0]), np.array([160.0, 52.0]))
    assert box[2] - box[0] == pytest.approx(127)


@pytest.mark.parametrize("method", sorted(METHODS))
def test_pupils_are_looked_for_where_their_distance_is_measured(method: str) -> None:
    assert Job("out", settings=Settings(method=method)).pose_options.pupils == (method in MEASURE_PUPILS)


def test_without_the_networks_eyes_stay_and_one_line_says_so(tmp_path: Path, monkeypatch, caplog) -> None:
    pytest.importorskip("onnxruntime")
    monkeypatch.setenv("PROXEMETRY_CACHE", str(tmp_path / "empty"))
    with caplog.at_level(logging.WARNING, "proxemetry"):
        backend = backend_named(f"onnx:{specification(tmp_path)}", PoseOptions(pupils=True, offline=True))
    assert not set(weights.PUPILS) & set(backend.models)
    (said,) = caplog.messages
    assert said.startswith(
        "pupils are not found; the joint network's eyes are used: face_landmark.tflite, iris_landmark.tflite"
    )


@pytest.mark.skipif(
    not PHOTOS.is_dir() or not all(map(weights.is_here, weights.PUPILS)), reason="photos or networks are not here"
)
def test_pupils_are_found_again_from_eyes_that_lie_a_little_aside() -> None:
    pixels = Photo.open(PHOTOS / "COCO_val2014_000000000536.jpg").pixels()
    networks = PupilNetworks.to_be_had(offline=True)
    assert networks is not None and set(networks.models) == set(weights.PUPILS)
    answers = []
    for shift in (-1.5, 0.0, 1.5):
        shown = _heads(*(((x0 + shift, y0 - shift), (x1 + shift, y1)) for x0, y0, x1, y1 in EYES))
        answers.append(networks.in_place_of_eyes(shown, pixels).keypoints_px[:, [RIGHT, LEFT]])
    apart = np.linalg.norm(answers[1][:, 0] - answers[1][:, 1], axis=1)
    for other in (answers[0], answers[2]):
        assert (np.linalg.norm(other - answers[1], axis=2).max(axis=1) < 0.07 * apart).all()
