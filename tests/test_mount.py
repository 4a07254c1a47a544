"""Where a camera is: the value, its file, the camera table's columns, and what it does to the scene fit."""

import json
import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import proxemetry as px
from proxemetry.bodies import MOST_MISFIT
from proxemetry.camera import Camera, CameraEstimate, Doubt, FloorFrame, Mount
from proxemetry.camera.floor_view import horizon, reach, to_floor, to_pixels
from proxemetry.camera.focal import FocalRequest, estimate_camera
from proxemetry.camera.table import CameraTable
from proxemetry.errors import CameraError, SettingsError
from proxemetry.measure import place, remeasure
from proxemetry.people import People
from proxemetry.photo import Photo
from proxemetry.scene import Scene
from proxemetry.settings import Settings
from synthetic.drawn import people_at
from synthetic.modelled import CAMERA as LENS
from synthetic.modelled import photo

CAMERA = Camera.centred(1200, 1600, 1200, focal_rel_sd=0.02)
angles = st.floats(-1.2, 1.2)


def a_mount(pitch=0.3, roll=-0.05, height=7.0, camera=CAMERA):
    """Return a mount found together with its focal length, everything correlated."""
    root = np.array([[0.01, 0, 0, 0], [0.002, 0.008, 0, 0], [0.01, 0.004, 0.02, 0], [-0.006, 0, 0.007, 0.03]])
    rows = tuple(tuple(row) for row in (root @ root.T).tolist())
    return Mount(pitch, roll, height, rows, camera, source="found", floor_frame=FloorFrame(3.0, -2.0, 0.4))


@given(angles, angles, st.floats(0.3, 60))
@settings(max_examples=30)
def test_a_mount_survives_its_file_form(pitch, roll, height):
    mount = a_mount(pitch, roll, height)
    again = Mount.from_dict(json.loads(json.dumps(mount.to_dict())))
    assert again.pitch_rad == pytest.approx(pitch, rel=1e-11, abs=1e-15)
    assert again.height_m == pytest.approx(height, rel=1e-11)
    assert np.array(again.covariance) == pytest.approx(np.array(mount.covariance), rel=1e-9)
    assert (again.camera, again.floor_frame.mirrored, again.size_px) == (CAMERA, False, (1600, 1200))
    assert again.to_dict() == mount.to_dict()


def test_what_is_not_known_stays_unknown(tmp_path):
    mount = Mount.stated(pitch_rad=0.2, pitch_sd_rad=0.01)
    mount.write(tmp_path / "mount.json")
    again = Mount.read(tmp_path / "mount.json")
    assert again.to_dict() == mount.to_dict()
    assert again.known.tolist() == [0]
    assert math.isnan(again.height_m)
    assert again.size_px is None


def test_another_program_writes_a_few_fields(tmp_path):
    path = tmp_path / "phone.json"
    path.write_text('{"schema": "proxemetry.mount/1", "pitch_deg": 12, "height_m": 1.5}')
    mount = Mount.read(path)
    assert math.degrees(mount.pitch_rad) == pytest.approx(12)
    assert mount.sd[0] == pytest.approx(math.radians(1))
    assert mount.height_sd_m == pytest.approx(0.045)
    assert math.isnan(mount.roll_rad)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("{", "no JSON"),
        ("[1]", "one JSON object"),
        ('{"pitch_deg": 3}', "schema None"),
        ('{"schema": "proxemetry.mount/2"}', "'proxemetry.mount/2'"),
        ('{"schema": "proxemetry.mount/1", "pitch": 3}', "'pitch' is unknown"),
        ('{"schema": "proxemetry.mount/1", "pitch_deg": NaN}', "pitch_deg is nan"),
        ('{"schema": "proxemetry.mount/1", "pitch_deg": "3"}', "must be a finite number"),
        ('{"schema": "proxemetry.mount/1", "pitch_deg": 120}', "-90 to 90"),
        ('{"schema": "proxemetry.mount/1", "height_m": -2}', "above the floor"),
        ('{"schema": "proxemetry.mount/1", "height_m": 2, "height_sd_m": -1}', "standard deviation"),
        ('{"schema": "proxemetry.mount/1", "width_px": 640}', "whole numbers"),
        ('{"schema": "proxemetry.mount/1", "camera": {"fx": 3}}', "camera"),
        ('{"schema": "proxemetry.mount/1", "pitch_deg": 3, "correlation": [[1]]}', "4 x 4"),
    ],
)  # fmt: skip
def test_what_is_no_mount_is_one_line(tmp_path, text, said):
    path = tmp_path / "camera.json"
    path.write_text(text)
    with pytest.raises(CameraError) as error:
        Mount.read(path)
    assert said in str(error.value)
    assert str(error.value).startswith(str(path))
    assert "\n" not in str(error.value)


def test_a_correlation_that_cannot_be_is_refused():
    rows = [[1e-4, 2e-4, math.nan, math.nan], [2e-4, 1e-4, math.nan, math.nan]] + [[math.nan] * 4] * 2
    with pytest.raises(CameraError, match="symmetric and positive"):
        Mount(0.1, 0.0, covariance=tuple(map(tuple, rows)))


def test_mirroring_twice_changes_nothing():
    mount = a_mount()
    again = mount.mirrored().mirrored()
    assert again.roll_rad == mount.roll_rad
    assert again.covariance == mount.covariance
    assert again.floor_frame.yaw_rad == pytest.approx(mount.floor_frame.yaw_rad)
    assert mount.mirrored().roll_rad == -mount.roll_rad


def test_the_floor_frame_of_a_mirrored_photo_gives_the_same_places():
    frame = FloorFrame(3.0, -2.0, 0.4)
    mirrored = replace(a_mount(), floor_frame=frame).mirrored().floor_frame
    seen = np.array([[1.0, 5.0], [-2.0, 8.0]])
    assert mirrored.to_user(seen * (-1, 1)) == pytest.approx(frame.to_user(seen))
    assert frame.from_user(frame.to_user(seen)) == pytest.approx(seen)
    # a camera at (3, -2) whose right is the x axis sees a point 5 m ahead and 1 m to its right at (4, 3)
    assert FloorFrame(3.0, -2.0).to_user(np.array([1.0, 5.0])) == pytest.approx([4.0, 3.0])


def test_a_mount_of_another_size_is_refused():
    people = people_at([(0, 0, 5)], CAMERA)
    with pytest.raises(CameraError, match="640 x 480"):
        place("a", "", 640, 480, people, CameraEstimate(None), Settings(), a_mount())
    assert a_mount().resized(800, 600).camera.f_px == pytest.approx(600)


def test_a_stated_focal_length_beside_a_mount_with_its_own_is_refused():
    with pytest.raises(SettingsError, match="leave out"):
        Settings(focal=FocalRequest(focal_px=900), mount=a_mount())


def test_the_camera_table_states_places(tmp_path):
    path = tmp_path / "cameras.csv"
    path.write_text("photo,pitch_deg,pitch_sd_deg,height_m\nmast*,16.5,0.25,7.07\nphone*,3,,\n")
    request = FocalRequest(focal_px=900, camera_table=CameraTable.read(path))
    mast = estimate_camera(Photo("mast_1.jpg", 1600, 1200, ""), request).mount
    assert math.degrees(mast.pitch_rad) == pytest.approx(16.5)
    assert math.degrees(mast.sd[0]) == pytest.approx(0.25)
    assert mast.height_m == 7.07
    assert math.isnan(mast.roll_rad)
    phone = estimate_camera(Photo("phone.jpg", 1600, 1200, ""), FocalRequest(camera_table=request.camera_table)).mount
    assert math.degrees(phone.sd[0]) == pytest.approx(1.0)  # known even where the focal length is not


@pytest.mark.parametrize(
    ("row", "said"),
    [
        ("mast*,,0.25,", "is given without"),
        ("mast*,16,-1,", "0 or more"),
        ("mast*,100,,", "90"),
        ("mast*,,,-3", "above"),
    ],
)
def test_a_wrong_place_in_the_camera_table_names_its_line(tmp_path, row, said):
    path = tmp_path / "cameras.csv"
    path.write_text(f"photo,pitch_deg,pitch_sd_deg,height_m\n{row}\n")
    with pytest.raises(CameraError, match=said) as error:
        CameraTable.read(path)
    assert "line 2" in str(error.value)


PITCH, HEIGHT = 0.29, 7.0


def mast(seed=3, **changes):
    """Return the scene's arguments of people 15 to 30 m from a mast, and their distances: shape (P, P)."""
    people, middles = photo(seed, count=6, pitch=PITCH, height_m=HEIGHT, depths_m=(15, 30), **changes)
    down = np.array([0.0, math.cos(PITCH), math.sin(PITCH)])
    floor = middles - (middles @ down)[:, None] * down
    return people, np.linalg.norm(floor[:, None] - floor[None], axis=-1)


def measured(people, mount=None, method="scene"):
    return place("a", "", LENS.width, LENS.height, people, CameraEstimate(LENS), Settings(method), mount)


def stated(pitch_off_deg=0.0, sd_deg=0.1, **others):
    sd = math.radians(sd_deg)
    return Mount.stated(PITCH + math.radians(pitch_off_deg), 0.0, HEIGHT, pitch_sd_rad=sd, roll_sd_rad=sd,
                         height_sd_m=0.05, **others)  # fmt: skip


def pair_error(people, truth, mount=None):
    a, b = np.triu_indices(len(people), 1)
    return float(np.mean(np.abs(measured(people, mount).distances_m[a, b] / truth[a, b] - 1)))


def test_a_known_place_brings_pairs_from_a_mast_nearer_to_the_truth():
    scenes = [mast(seed) for seed in range(8)]
    without = np.mean([pair_error(*scene) for scene in scenes])
    known = np.mean([pair_error(*scene, stated()) for scene in scenes])
    assert known < 0.025
    assert known < 0.5 * without


def test_the_fit_stays_where_a_good_mount_says():
    people, _ = mast()
    floor = measured(people, stated()).bodies.floor
    assert floor.pitch_rad == pytest.approx(PITCH, abs=math.radians(0.2))
    assert floor.pitch_sd_rad < math.radians(0.11)
    assert floor.height_m == pytest.approx(HEIGHT, abs=0.1)


def test_a_stated_pitch_alone_tells_the_height_better():
    people, _ = mast()
    pitch = Mount.stated(pitch_rad=PITCH, pitch_sd_rad=math.radians(0.1))
    free, known = measured(people).bodies.floor, measured(people, pitch).bodies.floor
    assert known.height_sd_m < 0.7 * free.height_sd_m
    assert known.pitch_sd_rad < 0.3 * free.pitch_sd_rad


def test_a_camera_straight_above_is_one_too():
    camera = Camera.centred(1000, 1000, 1000)
    down = Mount.stated(math.pi / 2, 0.0, 6.0, pitch_sd_rad=0.01, roll_sd_rad=0.01, height_sd_m=0.05)
    above = people_at([(-1.5, 0.0, 5.0), (1.5, 0.0, 5.0)], camera)  # the middles of torsos a metre above the floor
    shoulders = above.skeleton.joints.index("left_shoulder"), above.skeleton.joints.index("right_shoulder")
    keypoints = np.full_like(above.keypoints_px, np.nan)
    for row, x in enumerate((-1.5, 1.5)):
        keypoints[row, shoulders[0]] = camera.project([x, -0.18, 4.6])
        keypoints[row, shoulders[1]] = camera.project([x, 0.18, 4.6])
    people = People(above.skeleton, keypoints, np.isfinite(keypoints).all(axis=-1) * 0.9)
    scene = place("a", "", 1000, 1000, people, CameraEstimate(camera), Settings(), down)
    assert scene.distances_m[0, 1] == pytest.approx(3.0, rel=0.03)
    assert scene.bodies.floor.height_m == pytest.approx(6.0, abs=0.1)


def test_agreement_raises_no_doubt_and_contradiction_does():
    doubted = [bool(measured(mast(seed)[0], stated()).camera.flags) for seed in range(10)]
    assert sum(doubted) <= 1
    people, _ = mast()
    wrong = measured(people, stated(pitch_off_deg=12.0))
    assert wrong.bodies.mount_misfit > MOST_MISFIT
    assert [flag.doubt for flag in wrong.camera.flags] == [Doubt.MOUNT]
    # what is doubted is believed less
    assert wrong.bodies.floor.pitch_sd_rad > 3 * measured(people, stated()).bodies.floor.pitch_sd_rad


def test_without_a_mount_nothing_is_said_of_one():
    scene = measured(mast()[0])
    assert math.isnan(scene.bodies.mount_misfit)
    assert scene.camera.mount is None


def test_a_scene_keeps_its_mount():
    people, _ = mast()
    scene = measured(people, replace(stated(), camera=LENS, size_px=None))
    again = Scene.from_json(scene.to_json())
    assert again.to_json() == scene.to_json()
    assert again.camera.mount.camera == LENS
    after = remeasure(again, Settings())
    assert after.distances_m == pytest.approx(scene.distances_m, rel=1e-4, nan_ok=True)


def test_settings_with_a_mount_there_and_back():
    told = Settings(mount=stated())
    assert Settings.from_dict(json.loads(json.dumps(told.to_dict()))).to_dict() == told.to_dict()


def test_the_mounts_own_camera_measures_a_photo_without_metadata():
    people, truth = mast()
    mount = replace(stated(), camera=LENS)
    answer = px.measure(np.zeros((LENS.height, LENS.width, 3), np.uint8), pose=lambda pixels: people, mount=mount)
    assert answer.camera.camera.f_px == LENS.f_px
    assert answer.distances_m[0, 1] == pytest.approx(truth[0, 1], rel=0.1)


def test_the_papers_estimators_leave_the_mount_aside():
    people, _ = mast()
    for method in ("torso", "combined"):
        assert measured(people, stated(), method).distances_m == pytest.approx(
            measured(people, None, method).distances_m, nan_ok=True
        )


@pytest.mark.parametrize("off", [-0.02, 0.001, 0.03])
@pytest.mark.parametrize("metres", [3.0, 12.0, 30.0])
def test_a_wrong_pitch_puts_a_point_where_its_pixel_lies_then(metres, off):
    mount = Mount.stated(0.3, 0.0, 4.0, camera=Camera.centred(900.0, 1280, 960))
    wrong = Mount.stated(0.3 + off, 0.0, 4.0, camera=mount.camera)
    put = to_floor(wrong, to_pixels(mount, [0.0, metres]))[1]
    assert reach(mount, metres, off) == pytest.approx(put - metres)


def test_the_horizon_is_where_the_floor_far_away_is_seen():
    lens = Camera(900.0, 950.0, 600.0, 500.0, 1280, 960)
    mount = Mount.stated(0.15, 0.12, 4.0, camera=lens)
    (u0, v0), (u1, v1) = horizon(mount)
    far = to_pixels(mount, np.array([[-3e7, 1e8], [0.0, 1e8], [3e7, 1e8]]))
    assert far[:, 1] == pytest.approx(v0 + (far[:, 0] - u0) * (v1 - v0) / (u1 - u0), abs=1e-3)


def test_a_mirrored_mount_sees_the_mirrored_floor_in_the_users_coordinates():
    """The same point of the user's floor, in the photo flipped left to right."""
    frame, lens = FloorFrame(2.0, -1.0, 0.7), Camera(900.0, 950.0, 600.0, 500.0, 1280, 960)
    mount = Mount.stated(0.3, 0.1, 4.0, camera=lens, floor_frame=frame)
    points = np.array([[3.0, 6.0], [5.0, 4.0]])
    seen = to_pixels(mount, frame.from_user(points))
    flipped = mount.mirrored()
    assert flipped.floor_frame.to_user(to_floor(flipped, seen * (-1, 1) + (1280, 0))) == pytest.approx(points)


def test_widening_multiplies_standard_deviations():
    mount = Mount.stated(0.3, 0.1, 4.0, pitch_sd_rad=0.02, height_sd_m=0.4)
    assert mount.widened(3.0).sd[:3] == pytest.approx(3 * mount.sd[:3])
    assert mount.widened(3.0).height_sd_m == pytest.approx(1.2)


def test_a_mount_takes_no_lens_from_another():
    """Pitch, roll and height are the photo's own; a lens is given separately, with its own doubt."""
    other = Mount.stated(0.2, 0.1, 3.0, pitch_sd_rad=0.1, camera=replace(LENS, focal_rel_sd=0.05))
    completed = Mount.stated(0.3, pitch_sd_rad=0.1).completed_by(other)
    assert (completed.pitch_rad, completed.roll_rad, completed.height_m) == (0.3, 0.1, 3.0)
    assert completed.camera is None and np.isnan(completed.sd[3])
    nothing = Mount.stated(0.3, 0.0, 2.0)
    assert nothing.completed_by(other) is nothing


def test_what_a_mount_takes_from_another_is_independent_of_what_it_knew():
    spread = np.array([[0.04, np.nan, 0.01], [np.nan, np.nan, np.nan], [0.01, np.nan, 0.09]])
    covariance = np.full((4, 4), np.nan)
    covariance[:3, :3] = spread
    other = Mount(0.2, math.nan, 3.0, tuple(map(tuple, covariance.tolist())))
    found = np.array(Mount.stated(0.3, pitch_sd_rad=0.1).completed_by(other).covariance)
    assert found[0, 0] == pytest.approx(0.01) and found[2, 2] == pytest.approx(0.09) and found[0, 2] == 0.0
