"""docs/conventions.md, sentence by sentence; what other tests pin already is named there, not repeated."""

import math
from pathlib import Path

import numpy as np
import pytest

from proxemetry.bodies import Bodies
from proxemetry.camera import Camera
from proxemetry.camera.from_people.verticals import _axes
from proxemetry.distances import ZONE_LIMITS_M, Distances, ground_frame, measure_distances
from proxemetry.locate.scenefit import locate
from proxemetry.locate.scenefit.projection import body_axes, camera_axes
from proxemetry.measure import place
from proxemetry.people import People
from proxemetry.people.skeleton import COCO_17
from proxemetry.photo import Photo
from proxemetry.settings import Settings
from synthetic import modelled
from synthetic.drawn import people_at
from synthetic.modelled import photo

DOCUMENT = Path(__file__).parents[1] / "docs" / "conventions.md"
CAMERA = Camera.centred(1000, 1000, 800)


def test_pixel_zero_is_the_outer_corner():
    assert (CAMERA.cx, CAMERA.cy) == (500, 400)  # the middle of 1000 x 800 pixels, not of 0..999
    assert CAMERA.resized(500, 400).cx == 250
    assert CAMERA.cropped(100, 0, 900, 800).cx == 400


def test_sizes_are_width_and_height_and_arrays_height_and_width():
    photo = Photo.from_array(np.zeros((30, 50, 3), np.uint8))
    assert (photo.width, photo.height) == (50, 30)
    assert photo.pixels().shape == (30, 50, 3)


def test_missing_is_nan_with_score_zero():
    people = People(COCO_17, np.zeros((1, 17, 2)), np.eye(17)[:1])
    assert people.keypoints_px[0, 0].tolist() == [0, 0]
    assert np.isnan(people.keypoints_px[0, 1:]).all()
    assert (people.scores[0, 1:] == 0).all()


def test_the_camera_frame_is_right_down_forward():
    centre = CAMERA.project([0, 0, 5])
    right, down = CAMERA.project([1, 0, 5]), CAMERA.project([0, 1, 5])
    assert (right - centre).tolist() == [200, 0]
    assert (down - centre).tolist() == [0, 200]
    assert np.isnan(CAMERA.project([0, 0, -5])).all()


@pytest.mark.parametrize(("pitch", "roll"), [(0.0, 0.0), (0.3, 0.0), (-0.2, 0.1)])
def test_up_from_pitch_and_roll(pitch, roll):
    up = np.array([math.sin(roll) * math.cos(pitch), -math.cos(roll) * math.cos(pitch), -math.sin(pitch)])
    assert -camera_axes(np.array([[pitch, roll]]))[0, :, 1] == pytest.approx(up)  # the scene fit's
    assert _axes(np.array([pitch]), np.array([roll]))[0, :, 0, 0] == pytest.approx(up)  # the self-calibration's
    assert ground_frame(up) @ ground_frame(up).T == pytest.approx(np.eye(3))


def test_left_is_the_persons_own():
    people = people_at([(0, 0, 5)], CAMERA)  # faces the camera
    assert people.joint("left_shoulder")[0, 0] > people.joint("right_shoulder")[0, 0]


def test_a_position_is_the_middle_of_the_torso():
    people = people_at([(0.5, 0.1, 5)], CAMERA)
    scene = place("a", "", 1000, 800, people, estimate(), Settings(method="torso"))
    assert scene.positions_m[0] == pytest.approx([0.5, 0.1, 5])
    for method, joints in (("shoulder", "shoulder"), ("pupil", "eye")):
        published = place("a", "", 1000, 800, people, estimate(), Settings(method=method))
        pair = (people.joint(f"left_{joints}") + people.joint(f"right_{joints}")) / 2
        assert CAMERA.project(published.positions_m) == pytest.approx(pair)


def test_a_camera_that_looks_down_has_a_positive_pitch():
    people, _ = photo(0, noise_px=0.1, pitch=0.3)
    bodies = locate(people, modelled.CAMERA, modelled.ADULTS)
    assert bodies.floor.pitch_rad == pytest.approx(0.3, abs=0.05)
    assert bodies.up == pytest.approx([0, -math.cos(0.3), -math.sin(0.3)], abs=0.05)


def test_heading_zero_faces_the_camera_and_positive_turns_right():
    forward = body_axes(np.array([0.0, math.pi / 2]))[..., 0]
    assert forward == pytest.approx(np.array([[0, 0, -1], [1, 0, 0]]))
    # who stands on the left and turns right faces the one on the right who turns left
    places = np.array([[-0.6, 0, 4], [0.6, 0, 4]])
    turned = np.array([math.pi / 2, -math.pi / 2])
    for heading, grouped in ((turned, 1.0), (-turned, 0.0)):
        bodies = Bodies(
            places, 1e-6 * np.eye(6), "scene", ("feet", "feet"), (None, None), np.array([0.0, -1.0, 0.0]), heading,
            np.full(2, 0.01),
        )  # fmt: skip
        assert measure_distances(bodies).group_probability[0, 1] == grouped


def test_zones_are_halls():
    assert ZONE_LIMITS_M == (0.457, 1.219, 3.658)


def test_a_zone_is_stated_where_it_is_more_likely_than_not():
    for likely in (0.5, 0.49):
        zones = np.full((2, 2, 4), (1 - likely) / 3)
        zones[..., 1] = likely
        metres = np.full((2, 2), 1.0)
        distances = Distances(metres, metres * 0.3, metres * 1.5, metres, zones, metres * 0, True)
        assert distances.zone(0, 1) == ("personal" if likely == 0.5 else "uncertain")


def estimate():
    from proxemetry.camera import CameraEstimate

    return CameraEstimate(CAMERA)


def test_every_section_is_there():
    headings = [line for line in DOCUMENT.read_text(encoding="utf-8").splitlines() if line.startswith("## ")]
    assert headings == ["## Pixels", "## The camera frame", "## People", "## Distances"]
