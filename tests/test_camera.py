"""The camera's laws and closed forms."""

import math
from dataclasses import replace

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from proxemetry.camera import Camera
from proxemetry.errors import CameraError

finite = st.floats(-3, 3)
cameras = st.builds(
    lambda f, w, h, dx, dy, k1, p1: Camera(f, f * 1.01, w / 2 + dx, h / 2 + dy, w, h, (k1, 0.02, p1, -p1, 0.0)),
    st.floats(300, 5000), st.integers(100, 8000), st.integers(100, 8000), st.floats(-50, 50), st.floats(-50, 50),
    st.floats(-0.1, 0.1), st.floats(-0.002, 0.002),
)  # fmt: skip
points = st.tuples(st.floats(-0.5, 0.5), st.floats(-0.5, 0.5), st.floats(0.5, 40)).map(
    lambda p: np.array([p[0] * p[2], p[1] * p[2], p[2]])
)


def test_a_person_of_1_70_m_at_5_m_with_a_focal_length_of_1000_px_is_340_px():
    camera = Camera.centred(1000, 1000, 1000)
    head, feet = camera.project([[0, -0.85, 5], [0, 0.85, 5]])
    assert feet[1] - head[1] == pytest.approx(340)


@given(cameras, points)
def test_project_then_ray_is_identity(camera, point):
    ray = camera.rays(camera.project(point))
    assert ray * point[2] == pytest.approx(point, rel=1e-7, abs=1e-7)


@given(cameras, points, st.floats(0.1, 4), st.floats(0.1, 4))
def test_resizing_multiplies_pixels(camera, point, sx, sy):
    resized = camera.resized(max(1, round(camera.width * sx)), max(1, round(camera.height * sy)))
    factors = np.array([resized.width / camera.width, resized.height / camera.height])
    assert resized.project(point) == pytest.approx(camera.project(point) * factors)


@given(cameras, points)
def test_cropping_subtracts(camera, point):
    assert camera.cropped(10, 20, 90, 80).project(point) == pytest.approx(camera.project(point) - (10, 20))


@given(cameras, points)
def test_mirroring_mirrors(camera, point):
    mirrored = camera.mirrored().project(point * (-1, 1, 1))
    u, v = camera.project(point)
    assert mirrored == pytest.approx([camera.width - u, v])


@given(cameras, points)
def test_undistorted_pixels_belong_to_the_ideal_camera(camera, point):
    ideal = camera.without_distortion().project(point)
    assert camera.undistorted(camera.project(point)) == pytest.approx(ideal, rel=1e-6, abs=1e-5)


@given(cameras, points, st.floats(-0.05, 0.05), st.floats(-0.01, 0.01), st.floats(-0.01, 0.01), st.floats(-0.02, 0.02))
def test_pixels_are_where_opencv_puts_them(camera, point, k2, p1, p2, k3):
    bent = replace(camera, distortion=(camera.distortion[0], k2, p1, p2, k3))
    matrix = np.array([[bent.fx, 0.0, bent.cx], [0.0, bent.fy, bent.cy], [0.0, 0.0, 1.0]])
    pixels, _ = cv2.projectPoints(point[None], np.zeros(3), np.zeros(3), matrix, np.array(bent.distortion))
    assert bent.project(point) == pytest.approx(pixels[0, 0], abs=1e-6)


def test_undoing_a_strong_distortion_is_exact_to_the_corners():
    camera = Camera(900, 950, 610, 350, 1200, 720, (-0.12, 0.03, 0.01, -0.02, 0.01))
    corners = np.array([[0, 0], [1200, 0], [0, 720], [1200, 720], [600, 0], [0, 360]], float)
    assert camera.project(camera.rays(corners)) == pytest.approx(corners, abs=1e-6)


def test_pixels_of_a_lens_without_distortion_stay_and_are_a_copy():
    pixels = np.array([[3.0, 4.0], [math.nan, 5.0]])
    straight = Camera.centred(900, 1200, 800).undistorted(pixels)
    assert straight == pytest.approx(pixels, nan_ok=True)
    assert straight is not pixels


def test_points_behind_the_camera_are_nan_and_keep_their_row():
    pixels = Camera.centred(100, 10, 10).project([[0, 0, -1], [0, 0, 1]])
    assert np.isnan(pixels[0]).all()
    assert pixels[1] == pytest.approx([5, 5])


def test_missing_pixels_stay_missing_beside_others():
    camera = Camera(500, 500, 50, 50, 100, 100, (0.1, 0, 0, 0, 0))
    rays = camera.rays([[math.nan, 3], [50, 50]])
    assert np.isnan(rays[0, 0])
    assert rays[1] == pytest.approx([0, 0, 1])


def test_with_focal_keeps_the_pixels_aspect():
    camera = Camera(1000, 1210, 5, 5, 10, 10).with_focal(550)
    assert camera.f_px == pytest.approx(550)
    assert camera.fy / camera.fx == pytest.approx(1.21)


@pytest.mark.parametrize(
    "wrong",
    [
        {"fx": 0},
        {"fy": math.nan},
        {"width": 0},
        {"fx": "900"},
        {"fy": [900.0, 900.0]},
        {"cx": math.inf},
        {"distortion": (0.1,) * 4},
        {"distortion": (0, 0, 1e9, 0, 0)},
    ],
)
def test_impossible_cameras_are_refused(wrong):
    fields = {"fx": 1.0, "fy": 1.0, "cx": 0.0, "cy": 0.0, "width": 1, "height": 1, **wrong}
    with pytest.raises(CameraError, match=next(iter(wrong))):
        Camera(**fields)


@pytest.mark.parametrize("factor", [0.5, 2.0])
def test_a_resized_photos_principal_point_is_as_unsure_in_its_own_pixels(factor):
    camera = Camera(900.0, 950.0, 600.0, 500.0, 1280, 960, focal_rel_sd=0.1, principal_sd_px=12.0)
    resized = camera.resized(round(1280 * factor), round(960 * factor))
    assert resized.principal_sd_px == pytest.approx(12.0 * factor)
    assert resized.focal_rel_sd == 0.1 and resized.cx == pytest.approx(600.0 * factor)
