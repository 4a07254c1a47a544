"""Clips as they come: odd, broken, cut, bumped and in pictures; each is measured or is one clear line."""

import csv
import json
import re
import struct
import wave
from fractions import Fraction

import cv2
import numpy as np
import pytest
from PIL import Image

from proxemetry.cli import main
from proxemetry.clip.frames import open_clip
from proxemetry.errors import ClipError
from synthetic import clips

STEP = 0.2


def run(folder, clip, keypoints, out, *more):
    return main([
        "video", str(folder / clip), "--out", str(out), "--jobs", "0", "--detections",
        f"recorded:{folder / keypoints}", *more,
    ])  # fmt: skip


def table(folder, name):
    with (folder / f"{name}.csv").open(newline="") as file:
        return list(csv.DictReader(file))


def names(clip, times):
    return [f"{clip}#t={t:.3f}" for t in times]


def filmed(path, pictures, rate=5.0, codec="MJPG"):
    """Write pictures (H, W, 3) as a video."""
    height, width = pictures[0].shape[:2]
    writer = cv2.VideoWriter(str(path), cv2.VideoWriter.fourcc(*codec), rate, (width, height))
    for picture in pictures:
        writer.write(picture)
    writer.release()
    return path


def picture(seed=0):
    return clips.background((clips.WIDTH, clips.HEIGHT), seed)


def test_frames_that_come_unevenly_have_their_own_times(tmp_path):
    av = pytest.importorskip("av")
    times = [0.0, 0.25, 0.283, 0.316, 1.0, 2.5, 2.6]
    with av.open(str(tmp_path / "v.mp4"), "w") as output:
        stream = output.add_stream("mpeg4", rate=30)
        stream.width, stream.height, stream.pix_fmt = 640, 480, "yuv420p"
        stream.codec_context.time_base = Fraction(1, 1000)
        for t in times:
            frame = av.VideoFrame.from_ndarray(picture(), format="rgb24")
            frame.pts, frame.time_base = round(1000 * t), Fraction(1, 1000)
            output.mux(stream.encode(frame))
        output.mux(stream.encode(None))
    assert [f.t_s for f in open_clip(tmp_path / "v.mp4", 60.0).frames()] == pytest.approx(times, abs=1e-3)
    few = list(open_clip(tmp_path / "v.mp4", 4.0).frames())
    assert [f.source for f in few] == [0, 1, 4, 5]  # never more than four a second, none made up
    clips.mount().write(tmp_path / "camera.json")
    still = np.broadcast_to([[0.0, 8.0], [0.9, 8.0]], (7, 2, 2))
    clips.recorded(tmp_path / "v.json", names("v.mp4", times), still)
    out = tmp_path / "out"
    assert run(tmp_path, "v.mp4", "v.json", out, "--fps", "60", "--mount", str(tmp_path / "camera.json")) == 0
    (pair,) = table(out, "exposure")
    # both stood there all the time: from first to last, and half a usual step on either side
    assert float(pair["seconds_together"]) == pytest.approx(2.6 + np.median(np.diff(times)), abs=0.01)
    assert float(pair["seconds_within_2"]) == pytest.approx(float(pair["seconds_together"]), rel=0.02)


def test_a_clip_filmed_upright_is_upright(tmp_path):
    content = bytearray(filmed(tmp_path / "r.mp4", [picture()] * 3, codec="mp4v").read_bytes())
    where = content.index(b"tkhd") + 44  # the track header's matrix: a quarter turn
    quarter = (0, 1 << 16, 0, -(1 << 16), 0, 0, clips.HEIGHT << 16, 0, 1 << 30)
    content[where : where + 36] = struct.pack(">9i", *quarter)
    (tmp_path / "r.mp4").write_bytes(content)
    clip = open_clip(tmp_path / "r.mp4", 5.0)
    assert (clip.width, clip.height) == (clips.HEIGHT, clips.WIDTH)
    frame = next(clip.frames())
    assert (frame.photo.width, frame.photo.height) == (clips.HEIGHT, clips.WIDTH)
    turned = np.rot90(picture(), -1).astype(float)
    assert np.abs(frame.photo.pixels() - turned).mean() < 12


def sound(path):
    with wave.open(str(path), "wb") as file:
        file.setnchannels(1)
        file.setsampwidth(2)
        file.setframerate(8000)
        file.writeframes(bytes(16000))


@pytest.mark.parametrize(
    ("name", "make", "said"),
    [
        ("sound.wav", sound, "no video in it"),
        ("none.avi", lambda path: _no_frames(path), "without a single"),
        ("empty.mp4", lambda path: path.write_bytes(b""), "the file is empty"),
        ("cut.mp4", lambda path: _beginning(path, 0.5), "no video in it"),
        ("gone.mp4", lambda path: None, "no such file"),
    ],
)
def test_what_holds_no_video_is_one_line(tmp_path, capsys, name, make, said):
    make(tmp_path / name)
    assert main(["video", str(tmp_path / name), "--out", str(tmp_path / "out"), "--jobs", "0"]) == 2
    lines = capsys.readouterr().err.strip().splitlines()
    assert len(lines) == 1 and name in lines[0] and said in lines[0]
    assert not (tmp_path / "out" / "frames.csv").exists()


def _no_frames(path):
    cv2.VideoWriter(str(path), cv2.VideoWriter.fourcc(*"MJPG"), 5.0, (64, 48)).release()


def _beginning(path, share):
    """An MP4 whose index, which comes last, is missing."""
    content = filmed(path, [picture(k) for k in range(4)], codec="mp4v").read_bytes()
    path.write_bytes(content[: int(len(content) * share)])


def test_a_clip_that_was_cut_short_is_measured_as_far_as_it_goes(tmp_path):
    content = filmed(tmp_path / "a.avi", [picture()] * 60).read_bytes()
    (tmp_path / "a.avi").write_bytes(content[: len(content) // 2])
    clips.recorded(tmp_path / "a.json", names("a.avi", np.arange(60) * STEP), clips.walkers(60, STEP)[:, 3:])
    clips.mount().write(tmp_path / "camera.json")
    out = tmp_path / "out"
    assert run(tmp_path, "a.avi", "a.json", out, "--mount", str(tmp_path / "camera.json")) == 0
    frames, numbers = table(out, "frames"), json.loads((out / "summary.json").read_text())
    assert 20 < len(frames) < 40
    assert any("ends after" in note and "header" in note for note in numbers["notes"])


def test_a_cut_clip_is_two_shots_each_with_its_own_camera(tmp_path, capsys):
    filmed(tmp_path / "c.avi", [picture(1)] * 15 + [picture(2)] * 15)
    places = clips.walkers(30, STEP)
    clips.recorded(tmp_path / "c.json", names("c.avi", np.arange(30) * STEP), places)
    clips.mount().write(tmp_path / "camera.json")
    out = tmp_path / "out"
    assert run(tmp_path, "c.avi", "c.json", out, "--mount", str(tmp_path / "camera.json")) == 0
    frames = table(out, "frames")
    assert [f["shot"] for f in frames] == ["0"] * 15 + ["1"] * 15
    assert {f["camera"] for f in frames[15:]} == {"1"}
    numbers = json.loads((out / "summary.json").read_text())
    assert numbers["cameras"]["0"] == "the camera's place: stated"
    assert "people" in numbers["cameras"]["1"]  # the mount is the first camera's alone
    for person in table(out, "people"):
        assert float(person["from_s"]) >= 3 or float(person["to_s"]) < 3  # nobody is followed through a cut
    assert all(float(e["end_s"]) <= 3.0 or float(e["begin_s"]) >= 2.9 for e in table(out, "events"))


def test_a_bumped_camera_is_said(tmp_path, capsys):
    moved = np.roll(picture(1), 14, axis=1)
    filmed(tmp_path / "b.avi", [picture(1)] * 15 + [moved] * 15)
    clips.recorded(tmp_path / "b.json", names("b.avi", np.arange(30) * STEP), clips.walkers(30, STEP))
    clips.mount().write(tmp_path / "camera.json")
    assert run(tmp_path, "b.avi", "b.json", tmp_path / "out", "--mount", str(tmp_path / "camera.json")) == 0
    assert "the camera was moved once" in capsys.readouterr().out
    assert "camera moved by 2." in (tmp_path / "out" / "report.html").read_text()


def test_pictures_taken_minutes_apart_are_each_a_moment_of_its_own(tmp_path):
    folder = tmp_path / "lapse"
    folder.mkdir()
    taken = ["10:00:00", "10:02:00", "10:04:00", "10:06:00"]
    for k, clock in enumerate(taken):
        image = Image.fromarray(picture())
        exif = image.getexif()
        exif.get_ifd(0x8769)[0x9003] = f"2024:05:01 {clock}"
        image.save(folder / f"{9 - k}.jpg", exif=exif)  # their names run backwards: times decide
    order = [f"lapse/{9 - k}.jpg" for k in range(4)]
    clips.recorded(tmp_path / "l.json", order, clips.walkers(4, STEP)[:, 2:])
    clips.mount().write(tmp_path / "camera.json")
    out = tmp_path / "out"
    assert run(tmp_path, "lapse", "l.json", out, "--mount", str(tmp_path / "camera.json")) == 0
    frames, people = table(out, "frames"), table(out, "people")
    assert [float(f["t_s"]) for f in frames] == [0, 120, 240, 360]
    assert [f["n_people"] for f in frames] == ["2"] * 4
    assert len(people) == 8  # nobody can be followed over two minutes
    numbers = json.loads((out / "summary.json").read_text())
    assert (numbers["people_at_least"], numbers["people_at_most"]) == (2, 8)
    assert len(table(out, "exposure")) == 4
    assert (out / "report.html").exists()


def test_people_of_pictures_minutes_apart_count_as_no_more_than_one_picture_shows(tmp_path):
    folder = tmp_path / "lapse"
    folder.mkdir()
    for k in range(8):
        cv2.imwrite(str(folder / f"{k}.png"), picture())
    places = np.broadcast_to(clips.walkers(1, STEP), (8, 4, 2))
    clips.recorded(tmp_path / "l.json", [f"lapse/{k}.png" for k in range(8)], places)
    focal = ("--focal-px", str(clips.FOCAL_PX))
    spread = {}
    for fps in ("5", "0.05"):
        out = tmp_path / fps
        assert run(tmp_path, "lapse", "l.json", out, "--fps", fps, *focal) == 0
        said = json.loads((out / "summary.json").read_text())["cameras"]["0"]
        assert " from 4 " in said  # people, or the short tracks that are all that is known of them
        spread[fps] = json.loads((out / "mount.json").read_text())["pitch_sd_deg"]
    assert spread["0.05"] > 0.7 * spread["5"]  # not a quarter: eight times four are still four


def test_a_folder_without_pictures_is_one_line(tmp_path):
    with pytest.raises(ClipError, match="no pictures in this folder"):
        open_clip(tmp_path, 5.0)


def test_a_camera_that_moves_all_the_time_is_no_zero(tmp_path, capsys):
    filmed(tmp_path / "pan.avi", [np.ascontiguousarray(np.roll(picture(1), 12 * k, axis=1)) for k in range(10)])
    clips.recorded(tmp_path / "k.json", names("pan.avi", np.arange(10) * STEP), clips.walkers(10, STEP))
    clips.mount().write(tmp_path / "camera.json")
    out = tmp_path / "out"
    assert run(tmp_path, "pan.avi", "k.json", out, "--mount", str(tmp_path / "camera.json")) == 0
    said = capsys.readouterr().out
    assert "nobody was followed for 2.0 of 2.0 s" in said and "within 1 m" not in said
    numbers = json.loads((out / "summary.json").read_text())
    assert (numbers["people_at_least"], numbers["people_at_most"]) == (4, 40)
    assert numbers["seconds_not_followed"] == pytest.approx(numbers["seconds"])
    page = (out / "report.html").read_text()
    assert "unknown, not zero" in page
    _says_nothing_of_nearness(out)


def _says_nothing_of_nearness(out):
    """Whether missing is missing on the page, in the summary and in the frames' table, not zero."""
    table_of_page = re.search(r"<h2>Nearness</h2>.*?</table>", (out / "report.html").read_text(), re.DOTALL)[0]
    assert "0.0" not in table_of_page and table_of_page.count("<td>–</td>") == 3 * 5
    assert "<strong>–</strong><span>groups of two and more" in (out / "report.html").read_text()
    numbers = json.loads((out / "summary.json").read_text())
    assert numbers["n_groups"] is None
    for found in numbers["within_m"].values():
        assert found["events"] is found["events_apart"] is found["share_within_groups"] is None
        for name in ("pair_seconds", "pair_seconds_apart", "seconds_per_person_minute_apart"):
            assert set(found[name].values()) == {None}
    frames = table(out, "frames")
    assert {row[name] for row in frames for name in row if name.startswith("n_within")} == {""}
    assert {row["density"] for row in frames} == {""}


def test_people_who_cannot_be_placed_are_no_zero(tmp_path, capsys):
    filmed(tmp_path / "c.avi", [np.full_like(picture(), 128)] * 10)  # no lines, and few people, would tell the camera
    clips.recorded(tmp_path / "k.json", names("c.avi", np.arange(10) * STEP), clips.walkers(10, STEP)[:, :2])
    out = tmp_path / "out"
    assert run(tmp_path, "c.avi", "k.json", out, "--no-assume") == 1
    said = capsys.readouterr().out
    assert "the focal length is unknown" in said and "nobody was followed for 2.0 of 2.0 s" in said
    assert "within 1 m" not in said
    numbers = json.loads((out / "summary.json").read_text())
    assert (numbers["people_at_least"], numbers["people_at_most"], numbers["n_tracks"]) == (2, 20, 0)
    _says_nothing_of_nearness(out)


def test_nobody_ever_before_an_unknown_camera_is_zero(tmp_path):
    filmed(tmp_path / "c.avi", [picture(1)] * 10)
    clips.recorded(tmp_path / "k.json", names("c.avi", np.arange(10) * STEP), clips.walkers(10, STEP)[:, :1])
    out = tmp_path / "out"
    assert run(tmp_path, "c.avi", "k.json", out, "--no-assume") == 1
    numbers = json.loads((out / "summary.json").read_text())
    assert numbers["within_m"]["2"]["pair_seconds"]["seconds"] == numbers["seconds_not_followed"] == 0
    assert {row["n_within_2"] for row in table(out, "frames")} == {"0"}


def test_what_a_moving_camera_shows_is_missing_and_the_rest_counts(tmp_path):
    still = [picture(1)] * 20
    panned = [np.ascontiguousarray(np.roll(picture(1), 12 * k, axis=1)) for k in range(1, 16)]
    filmed(tmp_path / "c.avi", still + panned)
    clips.recorded(tmp_path / "k.json", names("c.avi", np.arange(35) * STEP), clips.walkers(35, STEP))
    clips.mount().write(tmp_path / "camera.json")
    out = tmp_path / "out"
    assert run(tmp_path, "c.avi", "k.json", out, "--mount", str(tmp_path / "camera.json")) == 0
    frames = table(out, "frames")
    assert all(row["n_within_2"] for row in frames[:20]) and not any(row["n_within_2"] for row in frames[25:])
    numbers = json.loads((out / "summary.json").read_text())
    assert 2 < numbers["seconds_not_followed"] < 4
    assert numbers["within_m"]["2"]["pair_seconds"]["seconds"] > 0
    known = [row for row in frames if row["n_within_2"]]
    rate = 60 * sum(float(r["n_within_2"]) for r in known) / sum(int(r["n_people"]) for r in known)
    within = numbers["within_m"]["2"]
    assert within["seconds_per_person_minute"]["value"] == pytest.approx(rate, rel=0.05)
    apart = within["pair_seconds_apart"]["seconds"] / within["pair_seconds"]["seconds"]
    assert within["seconds_per_person_minute_apart"]["value"] == pytest.approx(apart * rate, rel=0.1)
    assert "The numbers are of the rest." in (out / "report.html").read_text()
