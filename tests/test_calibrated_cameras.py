"""Cameras calibrated together: joints come back to where they are, and who is seen by several is one person."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from benchmarks.networks.calibrated_cameras import (
    Sighting,
    View,
    met,
    read_qualisys,
    straightened,
    together,
    triangulated,
    turned_to_meet,
)
from benchmarks.networks.calibrated_views import joints_of, known_view, known_views, lengths_lines, sightings_of
from benchmarks.networks.known_people import headings_rad, middles_m
from proxemetry.camera import Camera
from proxemetry.people import People
from proxemetry.people.skeleton import COCO_17

#: COCO's joints of someone upright at the origin who faces along +x, metres: x forward, y left, z up.
_UPRIGHT = np.array([
    (0.12, 0, 1.6), (0.1, 0.03, 1.64), (0.1, -0.03, 1.64), (0, 0.07, 1.62), (0, -0.07, 1.62), (0, 0.17, 1.4),
    (0, -0.17, 1.4), (0, 0.22, 1.1), (0, -0.22, 1.1), (0.1, 0.22, 0.9), (0.1, -0.22, 0.9), (0, 0.1, 0.9),
    (0, -0.1, 0.9), (0.02, 0.1, 0.5), (0.02, -0.1, 0.5), (0, 0.1, 0.08), (0, -0.1, 0.08),
])  # fmt: skip


def view_from(azimuth_deg: float, pitch_deg: float, roll_deg: float = 0.0, distance_m: float = 4.0) -> View:
    """A camera around the origin, 1.9 m above the floor or so, looking at it."""
    azimuth, pitch, roll = np.deg2rad([azimuth_deg, pitch_deg, roll_deg])
    ahead = np.array([-np.cos(azimuth), -np.sin(azimuth), 0.0])
    right, up = np.cross(ahead, (0, 0, 1)), np.array([0, 0, 1.0])
    down = -np.cos(pitch) * up - np.sin(pitch) * ahead
    forward = np.cos(pitch) * ahead - np.sin(pitch) * up
    c, s = np.cos(roll), np.sin(roll)
    rotation = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]]) @ np.array([right, down, forward])
    centre = np.array([0, 0, 1.0]) - distance_m * forward
    camera = Camera(1500, 1500, 530, 970, 1080, 1920, distortion=(-0.04, 0.1, 0.0, 0.0, 0.0))
    return View(f"{azimuth_deg:.0f}", camera, rotation, -rotation @ centre)


VIEWS = [view_from(10, 20, 13), view_from(100, 18), view_from(200, 25), view_from(280, 22, -26)]


def seen_by(view: View, *people: np.ndarray) -> People:
    pixels = np.array([view.camera.project(view.seen(joints)) for joints in people])
    return People(COCO_17, pixels, np.full(pixels.shape[:2], 0.8))


def test_pitch_and_roll_are_those_that_the_camera_was_given():
    view = view_from(37, 21, -12)
    assert np.rad2deg([view.pitch_rad, view.roll_rad]) == pytest.approx([21, -12])


@given(st.integers(0, 2**32 - 1))
def test_sight_lines_meet_where_the_point_is_and_one_of_another_point_does_not_matter(seed: int):
    rng = np.random.default_rng(seed)
    point, origins = (
        rng.normal(0, 0.5, 3),
        rng.normal(0, 1, (6, 3)) + 4 * np.eye(3)[rng.permutation([0, 0, 1, 1, 2, 2])],
    )
    lines = point - origins
    lines /= np.linalg.norm(lines, axis=1, keepdims=True)
    aside = np.cross(lines[0], np.eye(3)[np.abs(lines[0]).argmin()])
    origins[0] += 0.4 * aside / np.linalg.norm(aside)
    found, misses = met(origins, lines, np.ones(6))
    assert found == pytest.approx(point, abs=2e-3)
    assert misses[0] == pytest.approx(0.4, abs=2e-3)


def test_joints_come_back_where_three_views_agree():
    sightings = [Sighting(v, seen_by(view, _UPRIGHT).keypoints_px[0], np.full(17, 0.8)) for v, view in enumerate(VIEWS)]
    assert triangulated(VIEWS, sightings) == pytest.approx(_UPRIGHT, abs=1e-6)
    assert np.isnan(triangulated(VIEWS, sightings[:2])).all()
    assert triangulated(VIEWS, sightings[:2], 2) == pytest.approx(_UPRIGHT, abs=1e-6)


def test_people_are_told_apart_in_whatever_order_each_view_has_them():
    other = _UPRIGHT @ np.array([[-1, 0, 0], [0, -1, 0], [0, 0, 1.0]]) + (0.3, 1.0, 0)
    orders = [(0, 1), (1, 0), (1, 0), (0, 1)]
    seen = [seen_by(v, *[(_UPRIGHT, other)[k] for k in order]) for v, order in zip(VIEWS, orders, strict=True)]
    found = together(VIEWS, seen)
    assert {tuple(sorted(rows.items())) for rows in found} == {
        tuple((v, order.index(k)) for v, order in enumerate(orders)) for k in (0, 1)
    }
    joints = joints_of(VIEWS, sightings_of(VIEWS, {"a": seen, "b": seen}))
    assert sorted(j[0, 1] for j in joints) == pytest.approx([0, 1], abs=1e-6)


def test_knocked_cameras_are_turned_back():
    rng = np.random.default_rng(0)
    knocked: list[View] = []
    for view in VIEWS:
        w = np.deg2rad(rng.normal(0, 0.4, 3))
        turn = np.array([[1, -w[2], w[1]], [w[2], 1, -w[0]], [-w[1], w[0], 1]])
        rotation = np.linalg.qr(turn)[0] * np.sign(np.diag(np.linalg.qr(turn)[1])) @ view.rotation
        knocked.append(View(view.name, view.camera, rotation, -rotation @ view.centre_m))
    places = [(0, 0, 0), (0.8, 0.5, 0), (-0.6, 0.4, 0.1), (0.2, -0.7, 0)]
    people = [
        [Sighting(v, seen_by(view, _UPRIGHT + at).keypoints_px[0], np.full(17, 0.8)) for v, view in enumerate(VIEWS)]
        for at in places
    ]
    turned = turned_to_meet(knocked, people)

    def off(views: list[View]) -> float:
        return max(np.abs(triangulated(views, p) - _UPRIGHT - at).max() for p, at in zip(people, places, strict=True))

    assert off(knocked) > 0.01
    assert off(turned) < 0.25 * off(knocked)


def test_a_straightened_camera_sees_what_the_turned_picture_shows():
    level, matrix = straightened(VIEWS[3])
    assert level.roll_rad == pytest.approx(0, abs=1e-9)
    assert level.pitch_rad == pytest.approx(VIEWS[3].pitch_rad)
    assert level.centre_m == pytest.approx(VIEWS[3].centre_m)
    pixels = VIEWS[3].camera.project(VIEWS[3].seen(_UPRIGHT))
    assert level.camera.project(level.seen(_UPRIGHT)) == pytest.approx(pixels @ matrix[:, :2].T + matrix[:, 2])


def test_the_truth_of_a_picture_has_depths_pairs_and_headings():
    truth = known_view(np.zeros((1, 1, 3), np.uint8), VIEWS[1], [_UPRIGHT, _UPRIGHT + (0.3, 0.4, 0)])
    on_floor = (middles_m(truth) @ truth.to_camera)[:, [0, 2]]
    assert np.linalg.norm(on_floor[0] - on_floor[1]) == pytest.approx(0.5)
    # the camera stands at 100 degrees of the room, seen from someone who faces along 0: it is to their left, they
    # face the photo's
    assert np.rad2deg(headings_rad(truth)) == pytest.approx([-100, -100], abs=1e-6)
    assert next(lengths_lines([[_UPRIGHT], [_UPRIGHT]])).startswith(
        "torso 50.0 +- 0.0, shoulders 34.0 +- 0.0, hips 20.0"
    )


def test_pictures_of_turned_cameras_are_there_upright_too():
    pictures = [np.zeros((1920, 1080, 3), np.uint8)] * 4
    made = known_views(VIEWS, [pictures], [[_UPRIGHT]])
    assert [view.level for view in made] == [False, True, True, True, False, True]
    assert not made[0].leaning
    tilt = np.deg2rad(25.0)
    leaning = _UPRIGHT @ np.array([[np.cos(tilt), 0, -np.sin(tilt)], [0, 1, 0], [np.sin(tilt), 0, np.cos(tilt)]])
    assert known_views(VIEWS, [pictures], [[leaning]])[0].leaning
    assert [view.camera_name for view in made] == ["10", "10 upright", "100", "200", "280", "280 upright"]


def test_a_qualisys_calibration_is_read():
    text = b"""<calibration><cameras><camera serial="one">
    <fov_video left="0" right="1087" top="0" bottom="1919"/>
    <transform x="1000" y="-2000" z="1500" r11="0" r12="1" r13="0" r21="0" r22="0" r23="1" r31="1" r32="0" r33="0"/>
    <intrinsic focalLengthU="96000" focalLengthV="96000" centerPointU="34784" centerPointV="61408"
     radialDistortion1="0" radialDistortion2="0" tangentalDistortion1="0" tangentalDistortion2="0"/>
    </camera></cameras></calibration>"""
    (view,) = read_qualisys(text)
    assert view.centre_m == pytest.approx([1, -2, 1.5])
    assert (view.camera.fx, view.camera.cx, view.camera.cy) == (1500, 544, 960)
    assert (view.camera.width, view.camera.height) == (1088, 1920)
    assert np.rad2deg([view.pitch_rad, view.roll_rad]) == pytest.approx([0, 0])
    # its own x is the room's y, its own y the room's z, and it looks against its own z: along -x of the room
    ahead = view.camera.project(view.seen(np.array([[-1.0, -2.0, 1.5], [-1.0, -1.0, 2.0]])))
    assert ahead == pytest.approx(np.array([[544, 960], [544 + 750, 960 - 375]]))


def test_who_lacks_a_trunk_is_no_truth():
    seen = [seen_by(view, _UPRIGHT) for view in VIEWS]
    cut = [replace(p, scores=np.where(np.arange(17) == 5, 0.0, p.scores)) for p in seen]
    assert joints_of(VIEWS, sightings_of(VIEWS, {"a": cut})) == []
