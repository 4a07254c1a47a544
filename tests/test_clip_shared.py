"""What all places of a clip owe to one camera and one floor: closed forms, and that neighbours share it."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from proxemetry.camera import Camera, FloorFrame, Mount
from proxemetry.camera.floor_view import level_axes, to_floor, to_pixels
from proxemetry.clip.boxes import standing
from proxemetry.clip.exposure import pairs_over_time, weights_s
from proxemetry.clip.floor import FLOOR_REACH_M, SharedError, held, sightings_of, uneven_m
from proxemetry.clip.sightings import Chain, Sightings
from proxemetry.clip.smoothing import LASTING_SHARE, smooth
from proxemetry.clip.tracking import SWAY_SD_M
from proxemetry.distances import ground_frame
from proxemetry.locate import LocateSettings, method_named
from proxemetry.locate.scenefit.fit import FLOOR_SD_M, FLOOR_SLOPE_SD
from proxemetry.people import People
from proxemetry.people.skeleton import COCO_17
from synthetic import clips
from synthetic.bodies import draw_build, draw_posture, pose_joints

PLACES = np.array([[1.0, 8.0], [-2.0, 15.0]])
EXACT = clips.mount(1e-9, 1e-9)


def variance(mount, places):
    """Return each coordinate's variance by the camera alone, shape (n, 2)."""
    return (SharedError(mount, clips.camera())(places) ** 2).sum(axis=2) - uneven_m(places, mount.height_m) ** 2


def test_a_camera_s_error_moves_places_as_a_wrong_camera_does():
    spread = np.sqrt(variance(clips.mount(0.01, 0.1), PLACES))
    # by hand, straight ahead: depth d = h / tan(angle), so that dd = d/h dh and dd = (d^2 + h^2) / h dp
    d, h = 15.0, clips.HEIGHT_M
    assert spread[1, 1] == pytest.approx(np.hypot(d / h * 0.1, (d * d + h * h) / h * 0.01), rel=0.05)
    # nothing but scale: a camera twice as high puts all twice as far
    assert np.sqrt(variance(clips.mount(1e-9, 0.4), PLACES)) == pytest.approx(np.abs(PLACES) * 0.1, rel=1e-3)


def test_a_higher_floor_looks_nearer_by_similar_triangles():
    # from a mast the feet decide: an error e of the floor is e times distance over height
    (shift,) = uneven_m(np.array([[0.0, 10.0]]), 30.0)
    assert shift == pytest.approx([0, 10 / 30 * FLOOR_SD_M], rel=2e-3)
    (sloping,) = uneven_m(np.array([[0.0, 10.0]]), 30.0, FLOOR_SLOPE_SD)
    assert sloping == pytest.approx([0, 10 / 30 * np.hypot(FLOOR_SD_M, FLOOR_SLOPE_SD * np.hypot(10, 30))], rel=5e-3)
    # from near the ground the size decides, and the floor hardly matters
    (low,) = uneven_m(np.array([[0.0, 10.0]]), 0.3)
    assert low[1] < 0.6 * 10 / 0.3 * FLOOR_SD_M
    (aside,) = uneven_m(np.array([[3.0, 4.0]]), 2.0)
    assert aside / np.linalg.norm(aside) == pytest.approx([0.6, 0.8])


@settings(max_examples=40)
@given(st.floats(-30, 30), st.floats(3, 40), st.floats(0, 2 * np.pi), st.floats(0, 8))
def test_a_floor_is_alike_at_near_places_and_not_at_far_ones(x, y, angle, apart):
    both = np.array([[x, y], [x + apart * np.cos(angle), y + apart * np.sin(angle)]])
    shift, own = SharedError(EXACT, clips.camera())(both), uneven_m(both, clips.HEIGHT_M)
    assert (shift**2).sum(axis=2) == pytest.approx(own**2, abs=1e-9)
    if abs(own[0] @ own[1]) > 1e-3:
        alike = float((shift[0] * shift[1]).sum() / (own[0] @ own[1]))
        assert alike == pytest.approx(np.exp(-0.5 * (apart / FLOOR_REACH_M) ** 2), abs=0.2)


def test_errors_turn_with_the_user_s_coordinates():
    frame = FloorFrame(5.0, -2.0, 0.7, mirrored=True)
    mount = clips.mount(0.01, 0.1)
    plain = SharedError(mount, clips.camera())(PLACES)
    user = SharedError(replace(mount, floor_frame=frame), clips.camera())(frame.to_user(PLACES))
    back = frame.from_user(np.swapaxes(user, 1, 2) + (frame.x_m, frame.y_m))
    assert np.allclose(np.swapaxes(back, 1, 2), plain, atol=1e-7)


def side_by_side(gap_m):
    """Return the pair of two who stand at 15 m, so far apart along the line of sight, for four seconds."""
    times = np.arange(20) * 0.2
    shot = [Sightings.of_places(t, [[0.0, 15.0], [0.0, 15.0 + gap_m]], 0.05) for t in times]
    paths = [smooth(Chain(np.arange(20), np.full(20, k)), shot, times, number=k) for k in range(2)]
    (pair,) = pairs_over_time(paths, weights_s(times, 0.2), (1.0,), SharedError(EXACT, clips.camera()))
    return pair, paths


def test_two_side_by_side_stand_on_the_same_floor():
    near, paths = side_by_side(0.7)
    far, _ = side_by_side(9.0)
    alone = np.sqrt(2 * paths[0].place_covariance_m2[10, 1, 1])
    uneven = uneven_m(np.array([[0.0, 15.0]]), clips.HEIGHT_M)[0, 1]
    width = [(p.near.high_m - p.near.low_m)[10] / 2 / 1.645 for p in (near, far)]
    # of the floor's error only what differs over 0.7 m is left; at 9 m the two are each other's strangers
    assert width[0] == pytest.approx(np.hypot(alone, uneven * np.sqrt(2) * 0.7 / FLOOR_REACH_M / np.sqrt(2)), rel=0.15)
    assert width[1] > np.hypot(alone, 1.2 * uneven)
    assert near.seconds[0] > 3.6


def people_at(places):
    rng = np.random.default_rng(3)
    points = []
    for place in places:
        body = pose_joints(draw_build(rng), draw_posture(rng, seated=False))
        joints = np.array([body[j] for j in COCO_17.joints])
        floor = np.column_stack([place[0] + joints[:, 1], place[1] - joints[:, 0], joints[:, 2]])
        points.append(clips.camera().project(clips.on_floor(floor)))
    return People(COCO_17, np.array(points), np.full((len(points), 17), 0.9))


def test_what_the_floor_does_is_the_place_s_and_not_the_person_s():
    people = people_at(PLACES)
    bodies = method_named("scene")(people, clips.camera(), LocateSettings(), held(clips.mount()))
    seen = sightings_of(0.0, people, bodies, clips.mount())
    own = sightings_of(0.0, people, bodies, None)
    assert np.allclose(seen.covariance_m2 + seen.floor_m2, own.covariance_m2)
    assert np.allclose(seen.by_themselves().covariance_m2, own.covariance_m2)
    assert np.linalg.eigvalsh(seen.covariance_m2).min() > 0
    uneven = uneven_m(seen.positions_m, clips.HEIGHT_M, FLOOR_SLOPE_SD)
    assert seen.floor_m2[1, 1, 1] == pytest.approx(uneven[1, 1] ** 2, rel=0.1)
    path = smooth(Chain(np.array([0]), np.array([1])), [seen], np.array([0.0]))
    assert path.place_covariance_m2[0] == pytest.approx(
        (1 + LASTING_SHARE**2) * (seen.covariance_m2[1] + SWAY_SD_M**2 * np.eye(2))
    )


@pytest.mark.parametrize("mirrored", [False, True])
@pytest.mark.parametrize(
    "together", [(1, 0, 0, 0), (0, 1, 0, 0), (0, 0, 1, 0), (0, 0, 0, 1), (1, -1, 2, 2), (1, 2, -1, 1)]
)
def test_a_place_moves_with_the_camera_as_the_pixel_it_is_seen_in_does(together, mirrored):
    """A camera off in several things at once puts what it sees in a pixel elsewhere: `to_floor` says where."""
    frame, lens = FloorFrame(2.0, -1.0, 0.7, mirrored), Camera.centred(900.0, 1280, 960)
    off = 0.01 * np.array(together)

    def at(part):
        pitch, roll, height, focal = part * off
        camera = lens.with_focal(900.0 * np.exp(focal))
        return Mount.stated(0.4 + pitch, 0.05 + roll, 5.0 * np.exp(height), camera=camera, floor_frame=frame)

    mount, own = at(0.0), np.array([[0.5, 8.0], [-3.0, 12.0], [2.0, 6.0]])
    seen, step = to_pixels(mount, own), 1e-4
    expected = frame.to_user(to_floor(at(step), seen)) - frame.to_user(to_floor(at(-step), seen))
    sure = replace(mount, covariance=tuple(map(tuple, np.outer(off, off).tolist())))
    shift = SharedError(sure, lens)(frame.to_user(own))[:, :, 0]
    sign = np.sign((shift * expected).sum())  # a standard deviation has none
    assert shift * sign == pytest.approx(expected / (2 * step), rel=1e-3, abs=1e-6)


@pytest.mark.parametrize("roll", [0.0, 0.05, -0.3])
@pytest.mark.parametrize("mirrored", [False, True])
def test_people_stand_where_the_users_points_of_the_same_pixels_lie(roll, mirrored):
    """Of a camera both pitched and rolled its own x along the floor is not the floor frame's right."""
    frame, lens = FloorFrame(2.0, -1.0, 0.7, mirrored), Camera.centred(900.0, 1280, 960)
    mount = Mount.stated(0.4, roll, 5.0, camera=lens, floor_frame=frame)
    own, angle = np.array([[0.5, 8.0], [-3.0, 12.0], [2.0, 6.0]]), np.array([0.3, -2.0, 1.1])
    feet = to_pixels(mount, own)
    boxes = np.column_stack([feet - (20, 100), feet + (20, 0)])
    people = People(COCO_17, np.full((3, 17, 2), np.nan), np.zeros((3, 17)), boxes, np.ones(3))
    bodies = standing(people, mount)
    # who faces along an angle of the user's floor, as a direction in the camera frame and as the fit states headings
    along = frame.from_user(frame.to_user(own) + np.stack([np.cos(angle), np.sin(angle)], axis=-1)) - own
    vectors = along @ level_axes(0.4, roll)[:, [0, 2]].T
    right, forward, _ = ground_frame(bodies.up)
    bodies = replace(
        bodies, heading_rad=np.arctan2(vectors @ right, -vectors @ forward), heading_sd_rad=np.full(3, 0.1)
    )
    found = sightings_of(0.0, people, bodies, mount)
    assert found.positions_m == pytest.approx(frame.to_user(own), abs=1e-6)
    assert np.cos(found.heading_rad - angle) == pytest.approx(1.0)
