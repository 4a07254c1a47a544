"""Laws of homographies and mounts: own points back, mirrored, scaled, resized; what tells no camera, a line each."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from proxemetry.calibration.homography import homography
from proxemetry.calibration.points import FloorPoints, from_homography, from_points
from proxemetry.camera import Camera, CameraEstimate, Doubt, FloorFrame, Mount
from proxemetry.camera.floor_view import to_floor, to_pixels
from proxemetry.cli import main
from proxemetry.errors import CameraError
from proxemetry.measure import place
from proxemetry.settings import Settings
from synthetic.modelled import photo

SIZE = (768, 576)
CAMERA = Camera.centred(1190.0, *SIZE)
FRAME = FloorFrame(-29.0, -19.5, -0.95)
#: Pixels all over the lower two thirds of the picture, none of which the estimation is told.
EVERYWHERE = np.stack(np.meshgrid(np.linspace(20, 750, 6), np.linspace(230, 560, 5)), axis=-1).reshape(-1, 2)


def _mount(pitch_deg=16.5, roll_deg=-3.0, height_m=7.0, frame=FRAME, camera=CAMERA):
    return Mount.stated(math.radians(pitch_deg), math.radians(roll_deg), height_m, camera=camera, floor_frame=frame)


def _user(mount, pixels):
    return mount.floor_frame.to_user(to_floor(mount, pixels))


def _homography(mount, pixels=EVERYWHERE):
    """From pixels to floor metres, as another program would have written it."""
    return homography(pixels, _user(mount, pixels))


def _mapped(matrix, pixels):
    seen = np.column_stack([pixels, np.ones(len(pixels))]) @ matrix.T
    return seen[:, :2] / seen[:, 2:]


tilts = st.tuples(st.floats(14.0, 70.0), st.floats(-8.0, 8.0))


@given(tilts, st.floats(1.5, 30.0), st.floats(-3, 3), st.booleans(), st.sampled_from([1.0, -1.0, 1e-3, -250.0]))
@settings(max_examples=30, deadline=None)
def test_a_camera_made_from_a_homography_gives_its_points_back(tilt, height, yaw, mirrored, scale):
    """To 1e-9 of the height in metres and to 1e-6 pixels, mirrored or not, whatever its scale."""
    true = _mount(*tilt, height, FloorFrame(4.0, -3.0, yaw, mirrored))
    matrix = _homography(true)
    fit = from_homography(scale * matrix, CAMERA)
    back = _user(fit.mount, EVERYWHERE)
    far = np.linalg.norm(to_floor(true, EVERYWHERE), axis=1)
    assert (
        np.linalg.norm(back - _mapped(matrix, EVERYWHERE), axis=1) < 1e-9 * height * np.maximum(1, far / height) ** 2
    ).all()
    seen = to_pixels(fit.mount, fit.mount.floor_frame.from_user(_mapped(matrix, EVERYWHERE)))
    assert np.abs(seen - EVERYWHERE).max() < 1e-6
    assert fit.mount.floor_frame.mirrored == mirrored and fit.mount.source == "homography"


def test_a_homography_of_a_mirrored_picture_is_of_the_mirrored_camera():
    true = _mount()
    flipped = _homography(true) @ np.array([[-1, 0, SIZE[0]], [0, 1, 0], [0, 0, 1]])
    mirrored, plain = from_homography(flipped, CAMERA).mount, from_homography(_homography(true), CAMERA).mount
    assert mirrored.roll_rad == pytest.approx(-plain.roll_rad) and mirrored.pitch_rad == pytest.approx(plain.pitch_rad)
    assert mirrored.floor_frame.mirrored != plain.floor_frame.mirrored
    np.testing.assert_allclose(_user(mirrored, EVERYWHERE * (-1, 1) + (SIZE[0], 0)), _user(true, EVERYWHERE), atol=1e-8)


def test_a_homography_of_a_larger_copy_is_of_the_same_place():
    true = _mount()
    doubled = _homography(true) @ np.diag([0.5, 0.5, 1.0])
    larger = from_homography(doubled, CAMERA.resized(2 * SIZE[0], 2 * SIZE[1])).mount
    assert (larger.pitch_rad, larger.height_m) == pytest.approx((true.pitch_rad, true.height_m), rel=1e-8)
    np.testing.assert_allclose(_user(larger, 2 * EVERYWHERE), _user(true, EVERYWHERE), atol=1e-8)
    # of the wrong copy it is another camera, which the misses of its own corners show
    assert from_homography(doubled, CAMERA).mount.height_m != pytest.approx(true.height_m, rel=0.02)


def test_a_floor_measured_in_feet_is_a_higher_camera():
    true = _mount()
    feet = from_homography(np.diag([1 / 0.3048, 1 / 0.3048, 1.0]) @ _homography(true), CAMERA).mount
    assert feet.height_m == pytest.approx(true.height_m / 0.3048) and feet.pitch_rad == pytest.approx(true.pitch_rad)


def _one_line(error):
    text = str(error.value)
    assert "\n" not in text and len(text) < 250
    return text


@pytest.mark.parametrize("horizon_v", [450.0, 560.0, 700.0])
def test_a_homography_whose_horizon_runs_through_the_people_is_refused(horizon_v):
    """A floor that ends low in the picture is none on which the people in it stand."""
    matrix = np.array([[1.0, 0.0, -384.0], [0.0, 0.0, 900.0], [0.0, 1.0, -horizon_v]])
    with pytest.raises(CameraError, match="horizon runs through") as error:
        from_homography(matrix, CAMERA)
    _one_line(error)


def test_points_behind_the_camera_are_refused_or_named():
    true = _mount()
    pixels = np.vstack([EVERYWHERE[::6], EVERYWHERE[3::7]])
    metres = _user(true, pixels)
    behind = metres.copy()
    # the same spot beyond the camera: on the line through it, at the other side
    camera = np.array([true.floor_frame.x_m, true.floor_frame.y_m])
    behind[2] = camera - (metres[2] - camera)
    fit = None
    try:
        fit = from_points(FloorPoints(pixels, behind), CAMERA)
    except CameraError as error:
        assert "\n" not in str(error)
    assert fit is None or (3 in fit.wrong and fit.spread > 5)
    with pytest.raises(CameraError) as error:  # all of them beyond the camera: no camera sees that
        from_points(FloorPoints(EVERYWHERE[:4] - (0, 900), metres[:4]), CAMERA)
    _one_line(error)


@pytest.mark.parametrize(
    ("pixels", "metres", "said"),
    [
        (EVERYWHERE[:2], [(0, 0), (1, 0)], "2 points: four"),
        (np.zeros((0, 2)), np.zeros((0, 2)), "0 points: four"),
        (EVERYWHERE[:4], [(0, 0), (1, 0), (0, 1)], "4 pixels with 3 places"),
        (EVERYWHERE[:6], [(k, 2 * k + 1) for k in range(6)], "line"),
        (EVERYWHERE[:6] * (1, 0) + (0, 400), [(0, 0), (1, 0), (0, 1), (3, 1), (2, 2), (5, 1)], "line"),
        (EVERYWHERE[:4], [(0, 0), (1, 0), (0, math.inf), (1, 1)], "point 3"),
    ],
)
def test_points_that_tell_no_camera_say_why(pixels, metres, said):
    with pytest.raises(CameraError, match=said) as error:
        from_points(FloorPoints(np.array(pixels, float), np.array(metres, float)), CAMERA)
    _one_line(error)


def test_the_command_refuses_in_one_line(tmp_path, capsys):
    """A picture of the wrong size for a homography is not knowable; a mount of the wrong size is, when it is used."""
    cases = {
        "three.csv": "u_px,v_px,x_m,y_m\n1,2,3,4\n2,3,4,5\n3,4,5,7\n",
        "line.csv": "u_px,v_px,x_m,y_m\n" + "".join(f"{10 * k},{20 * k},{k},0\n" for k in range(1, 6)),
        "nan.csv": "u_px,v_px,x_m,y_m\n1,2,nan,4\n2,3,4,5\n3,4,5,7\n9,4,5,7\n",
    }
    for name, text in cases.items():
        (tmp_path / name).write_text(text)
        arguments = ["--points", str(tmp_path / name), "--size", "768x576", "--out", str(tmp_path / "camera.json")]
        assert main(["calibrate", *arguments]) == 2
        (line,) = capsys.readouterr().err.strip().splitlines()
        assert name in line or "line" in line
        assert not (tmp_path / "camera.json").exists()
    with pytest.raises(CameraError, match="768 x 576") as error:
        _mount().check_size(1536, 1152)
    _one_line(error)


def test_a_horizon_through_the_people_is_said_of_the_photo():
    """A mount whose horizon runs through everyone's hips, of a camera that in truth looks down on them from a mast."""
    true = math.radians(16.0)
    camera = Camera.centred(1400.0, 1600, 1200)
    people, _ = photo(1, count=6, pitch=true, height_m=7.0, camera=camera, depths_m=(18, 26))
    middle = float(np.nanmean(people.joint("left_hip")[:, 1]))
    mount = Mount.stated(math.atan((camera.cy - middle) / camera.fy), 0.0, 7.0, camera=camera)
    scene = place("a.jpg", "", camera.width, camera.height, people, CameraEstimate(camera, mount=mount), Settings())
    (flag,) = [f for f in scene.camera.flags if f.doubt is Doubt.MOUNT]
    assert "contradict the camera's pitch" in str(flag) and "\n" not in str(flag)
    assert scene.bodies.placed.all() and np.isfinite(scene.distances_m[0, 1])
    right = replace(mount, pitch_rad=true)
    fine = place("a.jpg", "", camera.width, camera.height, people, CameraEstimate(camera, mount=right), Settings())
    assert not [f for f in fine.camera.flags if f.doubt is Doubt.MOUNT]
