"""Where a fixed camera is: from points, homographies, lengths, drones and people; closed forms first."""

import json
import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from proxemetry.bodies import Bodies
from proxemetry.calibration.drone import from_subtitles, from_xmp
from proxemetry.calibration.homography import homography, read_homography
from proxemetry.calibration.identity import linked
from proxemetry.calibration.lengths import Length, with_lengths
from proxemetry.calibration.lens import lens_of, with_open_principal
from proxemetry.calibration.people import LEAST_SEEN, Gathered, PeopleFit, from_people
from proxemetry.calibration.points import FloorPoints, from_homography, from_points, open_camera
from proxemetry.calibration.report import TAKE_POINTS, doubt_m, floor_drawn, grid_lines, lines_of
from proxemetry.camera import Camera, CameraEstimate, FloorFrame, FocalSource, Mount, Source
from proxemetry.camera.floor_view import horizon, reach, to_floor, to_pixels
from proxemetry.camera.focal import FocalRequest
from proxemetry.cli import calibrate_people, main
from proxemetry.clip import camera as clip_camera
from proxemetry.clip.camera import told_by_people
from proxemetry.errors import CameraError
from proxemetry.locate import LocateSettings
from proxemetry.people import People
from proxemetry.people.skeleton import COCO_17
from proxemetry.photo import Photo
from proxemetry.scene import Scene
from synthetic.modelled import photo

CAMERA = Camera.centred(1190.0, 768, 576)
FRAME = FloorFrame(-29.0, -19.5, -0.95)
MAST = Mount.stated(math.radians(16.5), math.radians(-3.0), 7.0, camera=CAMERA, floor_frame=FRAME)
#: Seen at the picture's corners: where the floor is to be known.
SEEN = np.array([(100.0, 500.0), (700.0, 480.0), (120.0, 130.0), (650.0, 120.0)])


def seen_points(mount=MAST, pixels=SEEN, **changes):
    return FloorPoints(pixels, mount.floor_frame.to_user(to_floor(mount, pixels)), **changes)


angles = st.tuples(st.floats(0.1, 1.4), st.floats(-0.3, 0.3))


@given(angles, st.floats(1.0, 40.0), st.floats(-3, 3), st.booleans())
@settings(max_examples=25, deadline=None)
def test_points_of_a_camera_give_it_back(tilt, height, yaw, mirrored):
    true = replace(MAST, pitch_rad=tilt[0], roll_rad=tilt[1], height_m=height,
                   floor_frame=FloorFrame(4.0, -3.0, yaw, mirrored))  # fmt: skip
    pixels = SEEN + (0, 250)  # below the horizon of all of them
    floor = to_floor(true, pixels)
    if not np.isfinite(floor).all() or np.abs(floor).max() > 300:
        return
    fit = from_points(seen_points(true, pixels), CAMERA)
    assert np.abs(fit.residual_m).max() < 1e-9 * max(1.0, height)
    assert np.abs(fit.residual_px).max() < 1e-7
    assert fit.mount.pitch_rad == pytest.approx(tilt[0], abs=1e-9)
    assert fit.mount.roll_rad == pytest.approx(tilt[1], abs=1e-9)
    assert fit.mount.height_m == pytest.approx(height, rel=1e-9)
    assert fit.mount.floor_frame.mirrored == mirrored
    assert math.cos(fit.mount.floor_frame.yaw_rad - yaw) == pytest.approx(1)


def test_points_find_the_focal_length_too():
    fit = from_points(seen_points(), open_camera(768, 576), focal_known=False)
    assert fit.mount.camera.f_px == pytest.approx(1190, rel=1e-4)
    assert fit.mount.height_m == pytest.approx(7.0, rel=1e-4)
    assert 0.01 < fit.mount.sd[3] < 0.2
    assert fit.mount.camera.focal_rel_sd == pytest.approx(fit.mount.sd[3])


def test_a_camera_straight_above_is_found():
    above = replace(MAST, pitch_rad=math.pi / 2 - 1e-6, roll_rad=0.0)
    fit = from_points(seen_points(above), CAMERA)
    assert fit.mount.pitch_rad == pytest.approx(math.pi / 2, abs=1e-4)
    assert np.abs(fit.residual_m).max() < 1e-6


def test_a_mirrored_picture_is_of_the_mirrored_camera():
    mirrored = from_points(FloorPoints(np.abs(SEEN * (-1, 1) + (768, 0)), seen_points().floor_m), CAMERA).mount
    want = MAST.mirrored()
    assert mirrored.roll_rad == pytest.approx(want.roll_rad, abs=1e-9)
    assert mirrored.floor_frame.mirrored != MAST.floor_frame.mirrored


def test_another_frame_size_scales():
    double = from_points(
        FloorPoints(2 * SEEN, seen_points().floor_m, click_sd_px=4.0), CAMERA.resized(1536, 1152)
    ).mount
    assert double.pitch_rad == pytest.approx(MAST.pitch_rad, abs=1e-9)
    assert double.sd[0] == pytest.approx(from_points(seen_points(), CAMERA).mount.sd[0], rel=1e-4)


def test_stated_uncertainty_is_that_of_the_errors_made():
    rng = np.random.default_rng(1)
    exact = seen_points(pixels=np.concatenate([SEEN, [(400.0, 300.0), (300.0, 420.0)]]))
    z = []
    for _ in range(60):
        points = FloorPoints(exact.points_px + rng.normal(0, 2, exact.points_px.shape),
                             exact.floor_m + rng.normal(0, 0.05, exact.floor_m.shape))  # fmt: skip
        fit = from_points(points, CAMERA)
        sd = fit.mount.sd / fit.spread
        z.append([(fit.mount.pitch_rad - MAST.pitch_rad) / sd[0], math.log(fit.mount.height_m / 7.0) / sd[2]])
    assert np.sqrt(np.mean(np.square(z), axis=0)).min() > 0.75
    assert np.sqrt(np.mean(np.square(z), axis=0)).max() < 1.3


def test_a_wrong_point_is_named_and_widens():
    pixels = np.concatenate([SEEN, [(400.0, 300.0), (300.0, 420.0), (200.0, 250.0), (600.0, 350.0)]])
    exact = seen_points(pixels=pixels)
    moved = exact.floor_m.copy()
    moved[4] += (2.0, 1.0)
    good, bad = from_points(exact, CAMERA), from_points(FloorPoints(pixels, moved), CAMERA)
    assert 5 in bad.wrong
    assert good.wrong == ()
    assert bad.mount.sd[0] > 2 * good.mount.sd[0]


@pytest.mark.parametrize(
    ("pixels", "metres", "said"),
    [
        (SEEN[:3], [(0, 0), (1, 0), (0, 1)], "four or more"),
        (SEEN, [(0, 0), (1, 0), (2, 0), (3, 0)], "line"),
        ([(0, 0), (10, 10), (20, 20), (30, 30)], [(0, 0), (1, 0), (0, 1), (1, 1)], "line"),
        (SEEN, [(0, 0), (1, 0), (0, 1), (math.nan, 1)], "point 4"),
        ([*SEEN[:3], (math.inf, 3)], [(0, 0), (1, 0), (0, 1), (1, 1)], "point 4"),
        (np.tile(SEEN[:1], (4, 1)), [(0, 0), (1, 0), (0, 1), (1, 1)], "same"),
    ],
)
def test_points_that_tell_no_camera_are_one_line(pixels, metres, said):
    with pytest.raises(CameraError, match=said) as error:
        from_points(FloorPoints(np.array(pixels, float), np.array(metres, float)), CAMERA)
    assert "\n" not in str(error.value)


def test_a_point_above_the_horizon_is_refused_or_named():
    high = SEEN.copy()
    high[3] = (650.0, -400.0)  # sky
    points = FloorPoints(high, seen_points().floor_m)
    try:
        fit = from_points(points, CAMERA)
    except CameraError as error:
        assert "\n" not in str(error)
    else:
        assert fit.spread > 5


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("u_px,v_px,x_m\n1,2,3\n", "no column y_m"),
        ("u_px,v_px,x_m,y_m\n1,2,3,x\n", "line 2"),
        ("u_px,v_px,x_m,y_m\n1,2,3\n", "line 2"),
        ("u_px,v_px,x_m,y_m\n1,2,3,4\n", "four or more"),
        ("u_px,v_px,x_m,y_m\n1,2,3,nan\n2,3,4,5\n3,4,5,6\n4,5,6,7\n", "point 1"),
    ],
)
def test_a_wrong_file_of_points_says_where(tmp_path, text, said):
    path = tmp_path / "points.csv"
    path.write_text(text)
    with pytest.raises(CameraError, match=said) as error:
        FloorPoints.read(path)
    assert str(path) in str(error.value)


def test_points_with_decimal_commas(tmp_path):
    path = tmp_path / "points.csv"
    path.write_text("u_px;v_px;x_m;y_m\n" + "1,5;2;3;4,25\n" * 4)
    assert FloorPoints.read(path).floor_m[0].tolist() == [3.0, 4.25]


def test_a_homography_gives_its_camera(tmp_path):
    exact = seen_points()
    matrix = homography(exact.points_px, exact.floor_m)
    path = tmp_path / "H.txt"
    path.write_text("\n".join(" ".join(f"{v!r}" for v in row) for row in matrix.tolist()))
    fit = from_homography(read_homography(path), CAMERA)
    assert fit.mount.pitch_rad == pytest.approx(MAST.pitch_rad, abs=1e-8)
    assert fit.mount.height_m == pytest.approx(7.0, rel=1e-8)
    scaled = from_homography(-3 * matrix, CAMERA)
    assert scaled.mount.height_m == pytest.approx(7.0, rel=1e-8)


@pytest.mark.parametrize(
    "text", ["1 2 3\n4 5 6\n", "1 2 3\n4 5 x\n7 8 9\n", "1 2 3\n2 4 6\n1 1 1\n", "nan 0 0\n0 1 0\n0 0 1\n"]
)
def test_what_is_no_homography_is_one_line(tmp_path, text):
    path = tmp_path / "H.txt"
    path.write_text(text)
    with pytest.raises(CameraError, match=str(path)):
        read_homography(path)


def test_floor_and_pixels_there_and_back():
    floor = np.array([(0.0, 20.0), (-3.0, 12.0), (5.0, 30.0)])
    assert to_floor(MAST, to_pixels(MAST, floor)) == pytest.approx(floor)
    assert np.isnan(to_pixels(MAST, (0.0, -50.0))).all()
    (_, left), (_, right) = horizon(MAST)
    assert np.isnan(to_floor(MAST, [(0.0, left - 1)])).all()
    assert np.linalg.norm(to_floor(MAST, [(768.0, right + 0.5)])) > 1000


def test_half_a_degree_at_25_m_from_a_mast():
    # h / tan(atan(7 / 25) - 0.5 degrees) - 25
    assert reach(MAST, 25.0, -math.radians(0.5)) == pytest.approx(
        7 / math.tan(math.atan(0.28) - math.radians(0.5)) - 25
    )
    assert 0.8 < reach(MAST, 25.0, -math.radians(0.5)) < 0.9


def test_a_length_tells_the_height_as_surely_as_it_was_taped_and_clicked():
    """Where the angles are known a length grows with the height: relative deviations are those of the metres."""
    angles = Mount.stated(MAST.pitch_rad, MAST.roll_rad, pitch_sd_rad=1e-7, roll_sd_rad=1e-7, camera=CAMERA)
    ends = np.array([[200.0, 500.0], [420.0, 470.0]])
    metres = float(np.linalg.norm(np.subtract(*to_floor(MAST, ends))))
    length = Length(*ends[0], *ends[1], metres)
    for tape_sd_m in (0.02, 0.04):
        taped, away = with_lengths(angles, [length], click_sd_px=1e-6, tape_sd_m=tape_sd_m)
        assert taped.height_m == pytest.approx(MAST.height_m, rel=1e-3)
        assert taped.sd[2] == pytest.approx(tape_sd_m / metres, rel=0.02)
        assert away == pytest.approx(0, abs=1e-3)
    # clicks: each end's two coordinates move the length by its derivative
    by = [np.linalg.norm(np.subtract(*to_floor(MAST, ends + step))) - metres
          for step in 1e-3 * np.eye(4).reshape(4, 2, 2)]  # fmt: skip
    clicked, _ = with_lengths(angles, [length], click_sd_px=2.0, tape_sd_m=1e-6)
    assert clicked.sd[2] == pytest.approx(2.0 * np.linalg.norm(by) / 1e-3 / metres, rel=0.02)


def test_a_length_that_says_nothing_leaves_what_was_known_with_all_that_goes_together():
    root = np.array([[0.03, 0, 0], [0.01, 0.02, 0], [-0.05, 0.02, 0.04]])
    covariance = np.full((4, 4), np.nan)
    covariance[:3, :3] = root @ root.T
    known = replace(MAST, covariance=tuple(map(tuple, covariance.tolist())), camera=CAMERA, floor_frame=None)
    found, _ = with_lengths(known, [Length(200.0, 500.0, 420.0, 470.0, 5.0)], tape_sd_m=1e5)
    assert np.array(found.covariance)[:3, :3] == pytest.approx(root @ root.T, rel=1e-3, abs=1e-8)
    assert (found.pitch_rad, found.height_m) == pytest.approx((MAST.pitch_rad, MAST.height_m), rel=1e-5)


def test_lengths_tell_pitch_and_height():
    ends = [((200.0, 480.0), (250.0, 150.0)), ((120.0, 400.0), (650.0, 420.0)), ((500.0, 500.0), (560.0, 130.0))]
    lengths = [Length(*a, *b, float(np.linalg.norm(np.subtract(*to_floor(MAST, [a, b]))))) for a, b in ends]
    found, away = with_lengths(Mount(camera=CAMERA), lengths)
    assert math.degrees(found.pitch_rad) == pytest.approx(16.5, abs=0.4)
    assert found.height_m == pytest.approx(7.0, rel=0.03)
    assert np.abs(away).max() < 0.15
    rough = Mount.stated(MAST.pitch_rad + 0.03, MAST.roll_rad, 7.5, height_sd_m=1.0, pitch_sd_rad=0.05, camera=CAMERA)
    better, _ = with_lengths(rough, lengths[:1])
    assert better.sd[0] < 0.5 * rough.sd[0]
    assert abs(better.pitch_rad - MAST.pitch_rad) < 2 * better.sd[0]


@pytest.mark.parametrize("text", ["1,2,3,4", "1,2,3,4,x", "1,2,1,2,5", "1,2,3,4,-5", "1,2,3,4,nan"])
def test_what_is_no_length_is_refused(text):
    with pytest.raises(CameraError, match="length"):
        Length.parsed(text)


def test_one_length_alone_and_a_length_in_the_sky():
    with pytest.raises(CameraError, match="two"):
        with_lengths(Mount(camera=CAMERA), [Length(1, 500, 400, 500, 5.0)])
    with pytest.raises(CameraError, match="horizon"):
        with_lengths(MAST, [Length(100, -2000, 400, -2000, 5.0)])


def test_drones_write_down_where_they_are(tmp_path):
    path = tmp_path / "drone.jpg"
    path.write_bytes(b'\xff\xd8<rdf drone-dji:RelativeAltitude="+30.10" drone-dji:GimbalPitchDegree="-90.00"/>')
    mount = from_xmp(path)
    assert (mount.height_m, math.degrees(mount.pitch_rad)) == (30.1, pytest.approx(90))
    path.write_bytes(b"\xff\xd8 nothing")
    assert from_xmp(path) is None
    srt = tmp_path / "clip.srt"
    srt.write_text("1\n[rel_alt: 20.0 abs_alt: 90] [gb_yaw: 1 gb_pitch: -45.0 gb_roll: 0.0]\n" * 3)
    assert math.degrees(from_subtitles(srt).pitch_rad) == pytest.approx(45)
    srt.write_text("[rel_alt: 20.0] [gb_pitch: -45.0]\n[rel_alt: 30.0] [gb_pitch: -45.0]\n")
    with pytest.raises(CameraError, match="moved"):
        from_subtitles(srt)


def test_boxes_that_go_on_are_one_person():
    def seen(*lefts):
        boxes = np.array([[x, 100.0, x + 40, 220] for x in lefts])
        keypoints = np.full((len(lefts), 17, 2), np.nan)
        return People(COCO_17, keypoints, np.zeros((len(lefts), 17)), boxes)

    frames = [seen(10, 300), seen(22, 290), seen(281, 34), seen(46)]
    who = [w.tolist() for w in linked(frames, [0.0, 0.2, 0.4, 0.6])]
    assert who == [[0, 1], [0, 1], [1, 0], [0]]
    assert [w.tolist() for w in linked(frames[:2], [0.0, 9.0])] == [[0, 1], [2, 3]]


def crowd(count=20, pitch=0.3, height=5.0):
    """Gather people of photos before one camera, everyone another one."""
    gathered = Gathered()
    for seed in range(count):
        people, _ = photo(seed, count=4, pitch=pitch, height_m=height, depths_m=(7, 18))
        gathered.add(people, range(4 * seed, 4 * seed + 4))
    return gathered


LENS = Camera.centred(1200, 1920, 1080)


def test_people_tell_pitch_and_height():
    fit = from_people(crowd(), LENS)
    mount = fit.mount
    assert (fit.n_people, fit.n_frames) == (80, 20)
    assert abs(mount.pitch_rad - 0.3) < 3 * mount.sd[0] and mount.sd[0] < math.radians(1)
    assert abs(math.log(mount.height_m / 5.0)) < 3 * mount.sd[2] and mount.sd[2] < 0.05
    assert math.isnan(mount.sd[3])


def test_people_tell_the_focal_length_too():
    mount = from_people(crowd(), open_camera(1920, 1080), focal_known=False).mount
    assert abs(math.log(mount.camera.f_px / 1200)) < 3 * mount.sd[3]
    assert mount.sd[3] < 0.12


def test_the_interval_counts_people_not_detections():
    once = from_people(crowd(10), LENS).mount
    often = Gathered()
    for again in range(4):
        for seed in range(10):
            people, _ = photo(seed, count=4, pitch=0.3, height_m=5.0, depths_m=(7, 18))
            often.add(people, range(4 * seed, 4 * seed + 4))
        assert again >= 0
    tied = from_people(often, LENS).mount
    assert tied.sd[2] > 0.6 * once.sd[2]  # as four times as many people it would be half
    unknown = from_people(crowd(10), LENS, recurring=True)
    assert unknown.n_people == 4 and unknown.mount.source.startswith("4 people, seen ")  # as many as it counts for
    assert unknown.mount.sd[0] > 1.5 * once.sd[0]


def test_nobody_upright_tells_nothing():
    gathered = Gathered()
    gathered.add(People.none(COCO_17), [])
    with pytest.raises(CameraError, match="no person"):
        from_people(gathered, LENS)


def test_what_it_means_is_said_in_metres():
    away = (15.0, 26.0, 35.0)
    said = "\n".join(lines_of(MAST, away))
    assert "at 25 m  half a degree of pitch moves a person by 0.8" in said
    assert TAKE_POINTS in said  # one degree is too much there
    fine = replace(MAST, covariance=tuple(tuple(v / 100 for v in row) for row in MAST.covariance))
    assert TAKE_POINTS not in "\n".join(lines_of(fine, away))


def test_the_floor_lies_on_the_picture():
    blank = np.zeros((576, 768, 3), np.uint8)
    drawn = floor_drawn(blank, MAST, SEEN)
    (_, left), _ = horizon(MAST)
    assert (left < 0) or drawn[: int(left)].sum() == 0  # nothing in the sky
    assert drawn[300:].any() and not blank.any()


def test_the_command_writes_a_mount_and_a_picture(tmp_path, capsys):
    table = tmp_path / "points.csv"
    points = seen_points()
    rows = np.column_stack([points.points_px, points.floor_m]).tolist()
    table.write_text("u_px,v_px,x_m,y_m\n" + "\n".join(",".join(map(str, row)) for row in rows))
    out = tmp_path / "camera.json"
    told = ["calibrate", "--points", str(table), "--size", "768x576", "--focal-px", "1190", "--out", str(out)]
    assert main(told) == 0
    assert math.degrees(Mount.read(out).pitch_rad) == pytest.approx(16.5, abs=1e-4)
    assert (tmp_path / "camera.png").is_file()
    assert "point 4: off by 0.0 px" in capsys.readouterr().out
    assert main([*told, "--height-m", "3"]) == 2
    assert main(["calibrate", "--out", str(out), "--points", str(table)]) == 2


def test_the_command_takes_recorded_people(tmp_path, capsys):
    images = []
    for seed in range(6):
        people, _ = photo(seed, count=4, pitch=0.3, height_m=5.0, depths_m=(7, 18))
        points = np.concatenate([people.keypoints_px, people.scores[..., None]], axis=-1)
        images.append({"filename": f"{seed}.jpg", "width": 1920, "height": 1080,
                       "people": [{"keypoints": np.nan_to_num(p).tolist()} for p in points]})  # fmt: skip
    path = tmp_path / "keypoints.json"
    path.write_text(json.dumps({"skeleton": "coco17", "images": images}))
    out = tmp_path / "camera.json"
    told = ["calibrate", "--pose", f"recorded:{path}", "--focal-px", "1200", "--different-people", "--out", str(out)]
    assert main(told) == 0
    assert Mount.read(out).height_m == pytest.approx(5.0, rel=0.1)
    assert "only 24 different people" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("request_", "focal_px", "sd"),
    [
        (FocalRequest(focal_px=900.0), 900.0, 0.0),
        (FocalRequest(focal_35mm=30.0), 30.0 * math.hypot(640, 480) / math.hypot(36, 24), 0.1),
        (FocalRequest(assume_fov_deg=60.0), 320.0 / math.tan(math.radians(30.0)), 0.2),
    ],
)
def test_what_the_user_states_of_the_lens_is_known_as_well_as_stated(request_, focal_px, sd):
    """A 35 mm equivalent for all photos is marked as a guess; nothing stated is another thing."""
    lens, known = lens_of(Photo("frame.jpg", 640, 480, ""), request_)
    assert known
    assert lens.f_px == pytest.approx(focal_px) and lens.focal_rel_sd == pytest.approx(sd)


def test_a_lens_that_nothing_tells_is_open():
    lens, known = lens_of(Photo("frame.jpg", 640, 480, ""), FocalRequest())
    assert not known and lens == with_open_principal(open_camera(640, 480))


def test_a_stated_equivalent_goes_into_the_mount(tmp_path):
    out = tmp_path / "camera.json"
    command = ["calibrate", "--size", "640x480", "--height-m", "3", "--pitch-deg", "20", "--out", str(out)]
    assert main([*command, "--focal-35mm", "30"]) == 0
    assert Mount.read(out).camera.f_px == pytest.approx(30.0 * 800 / math.hypot(36, 24))
    assert main(command) == 0
    assert Mount.read(out).camera is None


@pytest.mark.parametrize("kind", [FocalSource.ASSUMED_EQUIVALENT, FocalSource.ASSUMED_FOV, FocalSource.ASSUMED_PRIOR])
def test_a_clips_people_weigh_what_is_stated_of_the_lens(kind):
    lens = replace(LENS, focal_rel_sd=0.1, source=Source(kind, "26 mm"))
    scenes = []
    for seed in range(3):
        people, _ = photo(seed, pitch=0.3, height_m=5.0, depths_m=(7, 18), camera=LENS)
        unplaced = Bodies.unplaced(len(people), "scene", "not yet")
        scenes.append(Scene(f"{seed}", "", 1920, 1080, "ok", None, CameraEstimate(lens), people, unplaced))
    found = told_by_people([([scene], [0.0]) for scene in scenes], None, LocateSettings())
    stays = found.camera.source.kind is kind
    assert stays == (kind is not FocalSource.ASSUMED_PRIOR)


def test_distances_of_a_calibrated_floor_are_off_by_as_much_as_stated_wherever_the_lens_has_its_middle():
    """What clicks and tape do to distances, and nothing else: the angles make up for a principal point that is off."""
    from proxemetry.clip.floor import SharedError

    true = replace(MAST, camera=replace(CAMERA, cx=CAMERA.cx + 9, cy=CAMERA.cy - 6))
    floor = true.floor_frame.to_user(to_floor(true, SEEN))
    extra = np.array([(400.0, 300.0), (300.0, 420.0)])
    points = np.concatenate([floor, true.floor_frame.to_user(to_floor(true, extra))])
    z = []
    for seed in range(25):
        rng = np.random.default_rng(seed)
        pixels = to_pixels(true, true.floor_frame.from_user(points)) + rng.normal(0, 2.0, (6, 2))
        told = FloorPoints(pixels, points + rng.normal(0, 0.05, (6, 2)), 2.0, 0.05)
        mount = from_points(told, with_open_principal(CAMERA)).mount
        assert mount.camera.principal_sd_px == 0
        own = to_floor(mount, to_pixels(true, true.floor_frame.from_user(points)))
        shared = SharedError(mount, mount.camera)(mount.floor_frame.to_user(own))[..., :4]
        for a, b in ((0, 1), (0, 2), (1, 3), (2, 3)):
            gap = mount.floor_frame.to_user(own)[a] - mount.floor_frame.to_user(own)[b]
            sd = np.linalg.norm((gap / np.linalg.norm(gap)) @ (shared[a] - shared[b]))
            z.append((np.linalg.norm(gap) - np.linalg.norm(points[a] - points[b])) / sd)
    assert 0.7 < np.sqrt(np.mean(np.square(z))) < 1.3


def test_a_stated_height_leaves_the_doubt_of_the_pitch():
    """Of h / tan(b): h / sin(b)^2 for each radian of b, and nothing of a height that nobody doubts."""
    sure = Mount.stated(0.3, 0.0, 7.0, pitch_sd_rad=0.01, height_sd_m=0.0, camera=CAMERA)
    below = math.atan2(7.0, 25.0)
    assert doubt_m(sure, 25.0) == pytest.approx(0.01 * 7.0 / math.sin(below) ** 2)


def test_grid_lines_are_the_floors_metre_lines_near_the_picture():
    width, height, reach_m, tenths = 768, 576, 12.0, set()
    for line, tenth in grid_lines(MAST, (width, height), reach_m, samples=81):
        assert len(line) > 1 and (line > -width).all() and (line < (2 * width, width + height)).all()
        places = MAST.floor_frame.to_user(to_floor(MAST, line))
        off = np.abs(places - np.array([FRAME.x_m, FRAME.y_m])).max(axis=0)
        assert off.max() <= reach_m + 1e-6
        axis = int(np.ptp(places, axis=0).argmin())  # the one that does not change along the line
        k = round(float(places[:, axis].mean()))
        assert places[:, axis] == pytest.approx(k, abs=1e-5)
        assert tenth == (k % 10 == 0)
        assert np.allclose(np.diff(places[:, 1 - axis]), 2 * reach_m / 80, atol=1e-6)
        tenths.add((axis, k))
    for axis, middle in enumerate((FRAME.x_m, FRAME.y_m)):
        found = sorted(k for a, k in tenths if a == axis)
        assert found[0] >= math.ceil(middle - reach_m) and found[-1] <= math.floor(middle + reach_m)


def test_pitch_and_height_together_move_a_person_as_drawn_cameras_do():
    spread = np.zeros((4, 4))
    spread[np.ix_([0, 2], [0, 2])] = [[0.005**2, 0.8 * 0.005 * 0.02], [0.8 * 0.005 * 0.02, 0.02**2]]
    mount = replace(MAST, roll_rad=0.0, covariance=tuple(map(tuple, spread.tolist())))
    pitch, log_height = np.random.default_rng(0).multivariate_normal([0, 0], spread[np.ix_([0, 2], [0, 2])], 4000).T
    below = math.atan2(mount.height_m, 25.0) + pitch
    drawn = mount.height_m * np.exp(log_height) / np.tan(below)
    assert doubt_m(mount, 25.0) == pytest.approx(float(drawn.std()), rel=0.06)
    apart = replace(mount, covariance=tuple(map(tuple, np.diag(np.diag(spread)).tolist())))
    assert doubt_m(apart, 25.0) > 1.3 * doubt_m(mount, 25.0)


@pytest.mark.parametrize(("focal_known", "focal_sd", "again"), [(True, math.nan, 1), (False, 0.14, 1), (False, 0.3, 0)])
def test_people_are_followed_over_the_floor_unless_they_leave_the_focal_length_open(
    monkeypatch, focal_known, focal_sd, again
):
    told = Mount(0.3, 0.0, 6.0, tuple(map(tuple, np.diag([1e-4, 1e-4, 1e-4, focal_sd**2]))), CAMERA)
    asked = []

    def from_followed(gathered, *_, **options):
        asked.append(len(gathered))
        assert options["focal_known"] == focal_known and options["least_seen"] == LEAST_SEEN
        return PeopleFit(told, 3, 20, 5, (8.0, 10.0, 12.0), ())

    monkeypatch.setattr(clip_camera, "from_people", from_followed)
    monkeypatch.setattr(clip_camera, "followed", lambda frames, times, mount: [np.arange(len(f)) for f in frames])
    people = [photo(k, camera=LENS)[0] for k in range(3)]
    calibrate_people.of_frames([(k / 5, p) for k, p in enumerate(people)], CAMERA, focal_known)
    assert len(asked) == 1 + again


@pytest.mark.parametrize(("apart_s", "focal_sd", "again"), [(0.2, math.nan, 1), (0.2, 0.3, 0), (60.0, math.nan, 0)])
def test_a_clip_s_people_are_followed_over_the_floor_block_by_block(monkeypatch, apart_s, focal_sd, again):
    """Whoever is hidden for a while is one person: the camera of ten is less sure than that of forty pieces of them."""
    known = math.isnan(focal_sd)
    lens = replace(LENS, source=Source(FocalSource.USER if known else FocalSource.ASSUMED_PRIOR))
    mount = Mount(0.3, 0.0, 6.0, tuple(map(tuple, np.diag([1e-4, 1e-4, 1e-4, focal_sd**2]))), lens)
    asked = []

    def from_gathered(gathered, *_, least_seen, **options):
        asked.append((sorted(person for _, person in gathered._kept), least_seen, options["recurring"]))
        return PeopleFit(mount, 4, 20, 5, (8.0, 10.0, 12.0), ())

    monkeypatch.setattr(clip_camera, "from_people", from_gathered)
    monkeypatch.setattr(clip_camera, "linked", lambda frames, times: [np.arange(len(f)) + 10 for f in frames])
    monkeypatch.setattr(clip_camera, "followed", lambda frames, times, mount: [np.arange(len(f)) for f in frames])
    people, _ = photo(0, pitch=0.3, height_m=5.0, depths_m=(7, 18), camera=LENS)
    scene = Scene("", "", 1920, 1080, "ok", None, CameraEstimate(lens), people, Bodies.unplaced(len(people), "", ""))
    blocks = [([scene] * 3, [first + k * apart_s for k in range(3)]) for first in (0.0, 500.0)]
    found = told_by_people(blocks, None, LocateSettings())
    assert "from 4 people" in found.note and len(asked) == 1 + again
    assert asked[0][1:] == (1, apart_s > 1.5)
    if again:
        persons, least_seen, _ = asked[1]
        # the same in all frames of a block, others in the next one
        assert persons == sorted(3 * [*range(len(people)), *range(len(people), 2 * len(people))])
        assert least_seen == LEAST_SEEN
