"""Files of a fixed camera that are damaged or absurd: boxes, regions, points, subtitles, results: one line each."""

import os
from pathlib import Path

import numpy as np
import pytest

from proxemetry.archive.review.corrections import Action, Log
from proxemetry.archive.store.folder import Folder
from proxemetry.calibration.drone import from_subtitles
from proxemetry.calibration.points import FloorPoints, from_points, open_camera
from proxemetry.camera import Mount
from proxemetry.clip.boxes import Boxes
from proxemetry.clip.frames import open_clip
from proxemetry.clip.run import read_region, read_run
from proxemetry.errors import CameraError, ClipError, KeypointsError, OutputError, SettingsError
from proxemetry.measure import Settings
from proxemetry.photo import Photo
from synthetic import clips

PHOTO = Photo("clip.mp4#t=0.000", clips.WIDTH, clips.HEIGHT, "")


@pytest.mark.parametrize("line", ["nan,1,1,1,9,9,1", "1,1,inf,1,9,9,1", "1e400,1,1,1,9,9,1", "1,1,1e300,1,9,9,1"])
def test_a_number_in_a_box_that_is_none_is_one_line(tmp_path: Path, line: str) -> None:
    (tmp_path / "a.txt").write_text(f"1,1,100,100,50,150,1\n{line}\n")
    with pytest.raises(KeypointsError, match="line 2"):
        Boxes.read(tmp_path / "a.txt")


@pytest.mark.parametrize(
    ("box", "reason"),
    [
        ((300, 100, 60, 10), "above the horizon"),  # the horizon is at 240 - 700 tan 20 deg = -15
        ((1e8, 100, 60, 150), "outside the picture"),
        ((300, 100, 60, -1e-3), None),
    ],
)
def test_a_box_that_tells_no_place_has_a_reason(
    tmp_path: Path, box: tuple[float, float, float, float], reason: str | None
) -> None:
    left, top, width, height = box
    top = -200 if reason == "above the horizon" else top
    (tmp_path / "a.txt").write_text(f"1,1,200,150,60,180,1\n1,2,{left},{top},{width},{height},1\n")
    scene = Boxes.read(tmp_path / "a.txt").scene(PHOTO, 0, Settings(mount=clips.mount()))
    assert scene.bodies.placed.tolist() == ([True] if reason is None else [True, False])
    if reason is not None:
        assert reason in (scene.bodies.reasons[1] or "")


def test_a_box_of_no_height_is_not_known_better_than_a_pixel(tmp_path: Path) -> None:
    (tmp_path / "a.txt").write_text("1,1,200,150,60,180,1\n1,2,230,329.999999,1e-6,1e-6,1\n")
    scene = Boxes.read(tmp_path / "a.txt").scene(PHOTO, 0, Settings(mount=clips.mount()))
    sd = np.sqrt(np.diagonal(scene.bodies.covariance_m2)).reshape(2, 3)
    assert (sd[1] > 2e-3).all()


def test_a_box_just_below_the_horizon_is_placed_nowhere(tmp_path: Path) -> None:
    horizon = clips.HEIGHT / 2 - clips.FOCAL_PX * np.tan(clips.PITCH_RAD)
    (tmp_path / "a.txt").write_text(f"1,1,200,{horizon - 100},40,101,1\n")
    scene = Boxes.read(tmp_path / "a.txt").scene(PHOTO, 0, Settings(mount=clips.mount()))
    assert scene.bodies.reasons == ("the box ends too near the horizon",)


@pytest.mark.parametrize(
    "text",
    [
        "3", "null", "[]", "[[1, 2], [3, 4]]", '{"geometry": null}', '{"coordinates": []}', '{"coordinates": 3}',
        "[" * 100_000, f"[[0, 0], [1{'0' * 400}, 0], [0, 1]]", "[[0, 0], [1e300, 0], [0, 1]]",
        "[[0, 0], [1, 0], [2, 0]]",
    ],
)  # fmt: skip
def test_what_is_no_region_is_one_line(tmp_path: Path, text: str) -> None:
    (tmp_path / "r.json").write_text(text)
    with pytest.raises(SettingsError) as caught:
        read_region(tmp_path / "r.json")
    assert "\n" not in str(caught.value)
    assert len(str(caught.value)) < 500


def test_points_far_from_any_picture_and_near_the_horizon_end_in_one_line() -> None:
    floor = np.array([(-2, 6), (2, 6), (-1.5, 3), (1.5, 3)], dtype=float)
    with pytest.raises(CameraError, match="point 2"):
        FloorPoints(np.array([(100, 300), (1e200, 300), (40, 440), (600, 440)]), floor)
    for far in (1e5, 1e6):
        seen = np.array([(100, 300), (540, 300 - far), (40, 440), (600, 440)])
        with pytest.raises(CameraError):
            from_points(FloorPoints(seen, floor), open_camera(640, 480), focal_known=False)


@pytest.mark.parametrize("height_m", [1e-308, 1e-3, 0.0, -2.0, 1e6])
def test_a_height_that_no_camera_has_is_one_line(height_m: float) -> None:
    with pytest.raises(CameraError, match="mount height"):
        Mount.stated(0.3, 0.0, height_m)
    assert Mount.stated(0.3, 0.0, 0.02).height_m == 0.02


def test_a_drones_subtitles_with_broken_numbers_are_read_or_refused(tmp_path: Path) -> None:
    (tmp_path / "a.srt").write_text("[rel_alt: 30.1.2 abs_alt: 9] [gb_pitch: -60..1 gb_roll: 0]")
    mount = from_subtitles(tmp_path / "a.srt")
    assert (round(mount.height_m, 1), round(np.degrees(mount.pitch_rad))) == (30.1, 60)


@pytest.mark.parametrize("content", [b"", b"{", b"[1]", b"\xff\xfe"])
def test_a_damaged_run_of_a_clip_is_one_line(tmp_path: Path, content: bytes) -> None:
    (tmp_path / "run.json").write_bytes(content)
    with pytest.raises(OutputError, match=r"run\.json: damaged"):
        read_run(Folder(tmp_path))


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="no pipes on this system")
def test_a_pipe_in_the_place_of_a_clip_is_refused_at_once(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "a.mp4")
    with pytest.raises(ClipError, match="a pipe"):
        open_clip(tmp_path / "a.mp4", 5.0)


def test_a_log_keeps_json_alone(tmp_path: Path) -> None:
    log = Log(tmp_path / "log.sqlite")
    for value in ({"x": float("inf")}, {"x": object()}):
        with pytest.raises(SettingsError, match="note: cannot be stored in the log"):
            log.keep(Action(0, "t", "ada", "a.jpg", "a1", "note", value))
    assert log.actions() == []
