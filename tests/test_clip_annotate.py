"""The clip with people and distances drawn in: what is drawn, whose heads are shown, and that files play."""

import csv
import importlib.util

import cv2
import numpy as np
import pytest

from proxemetry.cli import main
from proxemetry.clip import annotate
from proxemetry.errors import SettingsError
from proxemetry.measure import Settings, measure
from proxemetry.photo import Photo
from proxemetry.pose import backend_named
from synthetic import clips

STEP, FRAMES = 0.2, 12


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    folder = tmp_path_factory.mktemp("annotated")
    clips.write_video(folder / "walk.avi", FRAMES, 1 / STEP)
    names = [f"walk.avi#t={k * STEP:.3f}" for k in range(FRAMES)]
    clips.recorded(folder / "walk.json", names, clips.walkers(FRAMES, STEP))
    clips.mount().write(folder / "camera.json")
    return folder


@pytest.fixture(scope="module")
def scene(made):
    rng = np.random.default_rng(0)
    pixels = rng.integers(0, 255, (clips.HEIGHT, clips.WIDTH, 3), dtype=np.uint8)
    photo = Photo.from_array(pixels, name="walk.avi#t=0.000")
    backend = backend_named(f"recorded:{made / 'walk.json'}")
    return pixels, measure(photo, pose=backend, settings=Settings(mount=clips.mount()))


def video(made, out, *more):
    return main([
        "video", str(made / "walk.avi"), "--out", str(out), "--mount", str(made / "camera.json"), "--jobs", "0",
        "--detections", f"recorded:{made / 'walk.json'}", *more,
    ])  # fmt: skip


def tracks_of(scene):
    return {row: (row + 1, float(x), float(z)) for row, (x, _, z) in enumerate(scene.bodies.positions_m)}


def test_the_file_has_every_frame_and_plays(made, tmp_path, capsys, monkeypatch):
    av = pytest.importorskip("av")
    write, written = annotate._write, set[str]()
    monkeypatch.setattr(annotate, "_write", lambda *what: (written.add(what[1]), write(*what)))
    assert video(made, tmp_path / "out", "--annotated") == 0
    assert "annotated.mp4" in capsys.readouterr().out
    with (tmp_path / "out" / "people.csv").open(newline="") as file:
        doubtful = {r["track"]: r["doubt"] != "none" for r in csv.DictReader(file)}
    assert len(doubtful) == 4 and set(doubtful.values()) == {False, True}  # of two companions one may be the other
    assert {f"{track}?" if doubt else track for track, doubt in doubtful.items()} == {
        w for w in written if "m" not in w
    }
    path = str(tmp_path / "out" / "annotated.mp4")
    with av.open(path) as file:
        stream = file.streams.video[0]
        assert stream.codec_context.name in ("libdav1d", "av1", "libaom-av1", "vp9", "libvpx-vp9")
        times = [float(f.pts * stream.time_base) for f in file.decode(stream)]
    assert times == pytest.approx(np.arange(FRAMES) * STEP, abs=0.01)
    capture = cv2.VideoCapture(path)
    assert (capture.get(cv2.CAP_PROP_FRAME_WIDTH), capture.get(cv2.CAP_PROP_FRAME_HEIGHT)) == (640, 480)


def test_everyone_has_a_box_of_their_track_s_colour(scene):
    pixels, found = scene
    tracks = tracks_of(found)
    drawn = annotate.draw(pixels, found, tracks, 2.0, "show")
    for row, (number, *_) in tracks.items():
        x0, y0, _, y1 = found.people.boxes_px[row].astype(int)
        edge = drawn[(y0 + y1) // 2, x0]
        assert (edge == annotate._COLOURS[number % len(annotate._COLOURS)]).all()
    assert pixels is not drawn and not (pixels == drawn).all()


def test_heads_are_pixelated_unless_shown(scene):
    pixels, found = scene
    blurred, shown = (annotate.draw(pixels, found, {}, 2.0, faces) for faces in ("blur", "show"))
    assert (shown == pixels).all()
    for row in range(len(found)):
        u, v = found.people.joint("nose")[row].astype(int)
        patch = np.s_[v - 2 : v + 3, u - 2 : u + 3]
        assert blurred[patch].std(axis=(0, 1)).mean() < 0.5 * pixels[patch].std(axis=(0, 1)).mean()
    hidden = annotate.draw(pixels, found, {}, 2.0, "blur", np.array([[20.0, 20, 10]]))
    assert hidden[15:25, 15:25].std() < 0.6 * pixels[15:25, 15:25].std()
    assert (blurred[15:25, 15:25] == pixels[15:25, 15:25]).all()
    feet = found.people.joint("left_ankle")[0].astype(int)
    assert (blurred[feet[1], feet[0]] == pixels[feet[1], feet[0]]).all()


def test_a_head_that_is_hidden_for_a_while_is_pixelated_where_it_must_be(tmp_path):
    pytest.importorskip("av")
    places = clips.walkers(FRAMES, STEP)[:, 2:]
    places[4:7, 0] = np.nan  # who walks is not found for three frames
    clips.write_video(tmp_path / "walk.avi", FRAMES, 1 / STEP)
    clips.recorded(tmp_path / "walk.json", [f"walk.avi#t={k * STEP:.3f}" for k in range(FRAMES)], places)
    clips.mount().write(tmp_path / "camera.json")
    found = {}

    def kept(analysis, folder):
        found.update(hidden(analysis, folder))
        return found

    hidden, annotate.hidden_heads = annotate.hidden_heads, kept
    try:
        assert video(tmp_path, tmp_path / "out", "--annotated") == 0
    finally:
        annotate.hidden_heads = hidden
    assert sorted(found) == [4, 5, 6] and all(heads.shape == (1, 3) for heads in found.values())
    truth = clips.walkers(FRAMES, STEP)[5, 2]
    high = clips.camera().project(clips.on_floor([[*truth, 1.6]]))[0]
    assert np.linalg.norm(found[5][0, :2] - high) < found[5][0, 2] + 8


def test_who_is_near_is_joined_by_a_line_and_who_is_not_is_not():
    near = {0: (1, 0.0, 8.0), 1: (2, 1.0, 8.0), 2: (3, 9.0, 8.0)}
    assert annotate._nearest(near, 2.0) == [(0, 1, pytest.approx(1.0))]
    assert annotate._nearest(near, 0.5) == []
    assert annotate._nearest({0: (1, 0.0, 8.0)}, 2.0) == []
    # of three in a row everyone's nearest alone, each pair once
    row = {k: (k + 1, 0.9 * k, 8.0) for k in range(3)}
    assert [(a, b) for a, b, _ in annotate._nearest(row, 2.0)] == [(0, 1), (1, 2)]


def test_without_the_extra_it_is_said_before_any_work(made, tmp_path, monkeypatch, capsys):
    find = importlib.util.find_spec
    monkeypatch.setattr(importlib.util, "find_spec", lambda name, *a: None if name == "av" else find(name, *a))
    with pytest.raises(SettingsError, match=r"proxemetry\[video\]"):
        annotate.require_encoder()
    assert video(made, tmp_path / "out", "--annotated") == 2
    assert "proxemetry[video]" in capsys.readouterr().err and not (tmp_path / "out").exists()


def test_nobody_is_shown_where_only_aggregates_are_wanted(made, tmp_path, capsys):
    assert video(made, tmp_path / "out", "--annotated", "--aggregate-only") == 2
    assert "leave one of them out" in capsys.readouterr().err


def test_doubtful_tracks_have_a_question_mark(scene, monkeypatch):
    pixels, found = scene
    written = []
    monkeypatch.setattr(annotate, "_write", lambda picture, text, *more: written.append(text))
    annotate.draw(pixels, found, tracks_of(found), 0.0, "show", doubtful={2, 9})
    assert written == ["1", "2?", "3", "4"]
