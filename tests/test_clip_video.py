"""`proxemetry video` from file to folder, on synthetic clips: nobody looks at a network."""

import csv
import json
import os
import platform
import re
import shutil
import signal
import subprocess
import sys
import time
import zipfile
from pathlib import Path

import cv2
import numpy as np
import pytest

from proxemetry.cli import main
from proxemetry.clip.boxes import Boxes, standing
from proxemetry.clip.frames import PictureFolder, VideoFile, open_clip
from proxemetry.clip.shots import ShotFinder
from proxemetry.errors import CameraError, ClipError
from proxemetry.measure import Settings, measure
from proxemetry.people import People
from proxemetry.people.skeleton import COCO_17
from proxemetry.pose import backend_named
from synthetic import clips

STEP, FRAMES = 0.2, 30


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """A clip of four people, its keypoints and its camera."""
    folder = tmp_path_factory.mktemp("clip")
    clips.write_video(folder / "walk.avi", FRAMES, 1 / STEP)
    names = [f"walk.avi#t={k * STEP:.3f}" for k in range(FRAMES)]
    clips.recorded(folder / "walk.json", names, clips.walkers(FRAMES, STEP))
    clips.mount().write(folder / "camera.json")
    return folder


def video(folder, out, *more, clip="walk.avi", keypoints="walk.json"):
    return main([
        "video", str(folder / clip), "--out", str(out), "--mount", str(folder / "camera.json"), "--jobs", "0",
        "--detections", f"recorded:{folder / keypoints}", *more,
    ])  # fmt: skip


@pytest.fixture(scope="module")
def results(made):
    out = made / "results"
    assert video(made, out) == 0
    return out


def table(folder, name):
    with (folder / f"{name}.csv").open(newline="") as file:
        return list(csv.DictReader(file))


def test_everyone_is_followed_and_placed(results):
    people = table(results, "people")
    assert len(people) == 4
    assert all(int(p["n_seen"]) == FRAMES for p in people)
    truth = clips.walkers(FRAMES, STEP)
    tracks = table(results, "tracks")
    for person in people:
        path = np.array([[float(r["x_m"]), float(r["y_m"])] for r in tracks if r["track"] == person["track"]])
        apart = np.linalg.norm(path[:, None] - truth, axis=-1).mean(axis=0)
        assert apart.min() < 0.25


def test_seconds_near_are_those_of_the_truth(results):
    truth = clips.walkers(FRAMES, STEP)
    near = np.linalg.norm(truth[:, :, None] - truth[:, None], axis=-1) < 2
    seconds = near[:, *np.triu_indices(4, 1)].sum() * STEP
    found = json.loads((results / "summary.json").read_text())["within_m"]["2"]["pair_seconds"]
    assert found["seconds"] == pytest.approx(seconds, rel=0.12)
    assert found["low_s"] - 0.5 <= seconds <= found["high_s"] + 0.5
    rows = table(results, "exposure")
    assert sum(float(r["seconds_within_2"]) for r in rows) == pytest.approx(found["seconds"], abs=0.05)
    assert all(float(r["low_s_2"]) <= float(r["seconds_within_2"]) <= float(r["high_s_2"]) for r in rows)


def test_tables_hang_together(results):
    pairs, frames = table(results, "pairs_over_time"), table(results, "frames")
    assert len(frames) == FRAMES and [f["n_people"] for f in frames] == ["4"] * FRAMES
    assert len(pairs) == 6 * FRAMES
    assert all(float(p["low_m"]) <= float(p["distance_m"]) <= float(p["high_m"]) for p in pairs)
    first = sum(float(p["p_within_1.5"]) for p in pairs if p["frame"] == "0")
    assert float(frames[0]["n_within_1.5"]) == pytest.approx(first, abs=1e-5)
    meanings = {(r["table"], r["column"]) for r in table(results, "codebook")}
    for name in ("frames", "tracks", "people", "pairs_over_time", "exposure", "events"):
        assert {(name, c) for c in table(results, name)[0]} <= meanings
        assert (results / f"{name}.parquet").exists()


def test_the_files_of_other_programs_have_the_same_people(results):
    lines = (results / "trajectories.txt").read_text().splitlines()
    assert lines[0] == "# framerate: 5" and len(lines) == 2 + 4 * FRAMES
    mot = [line.split(",") for line in (results / "mot.txt").read_text().splitlines()]
    assert len(mot) == 4 * FRAMES and {len(m) for m in mot} == {10} and mot[0][0] == "1"
    coco = json.loads((results / "coco_keypoints.json").read_text())
    assert len(coco["images"]) == FRAMES and len(coco["annotations"]) == 4 * FRAMES


def test_spss_has_the_same_tables_with_labels(results, tmp_path):
    pyreadstat = pytest.importorskip("pyreadstat")
    assert main(["export", str(results), "--format", "spss", "--out", str(tmp_path)]) == 0
    frame, about = pyreadstat.read_sav(tmp_path / "exposure.sav")
    assert len(frame) == len(table(results, "exposure"))
    assert about.column_names_to_labels["seconds_within_1.5"] == "expected seconds within 1.5 m of each other [s]"
    assert about.variable_value_labels == {"same_group": {0.0: "no", 1.0: "yes"}}


def test_a_workbook_and_another_country_s_csv_have_the_same_rows(results, tmp_path):
    pytest.importorskip("xlsxwriter")
    formats = ("--format", "xlsx,csv,parquet,coco", "--locale", "fi")
    assert main(["export", str(results), *formats, "--out", str(tmp_path)]) == 0
    plain = table(results, "exposure")
    with zipfile.ZipFile(tmp_path / "results.xlsx") as book:
        names = re.findall(r'<sheet name="(\w+)"', book.read("xl/workbook.xml").decode())
        sheet = book.read(f"xl/worksheets/sheet{1 + names.index('exposure')}.xml").decode()
    assert names == ["frames", "tracks", "people", "pairs_over_time", "exposure", "events", "codebook"]
    assert sheet.count("<row ") == 1 + len(plain)
    head, first, *_ = (tmp_path / "exposure.csv").read_text(encoding="utf-8-sig").splitlines()
    assert head.split(";") == list(plain[0])
    value = first.split(";")[head.split(";").index("closest_m")]
    assert float(value.replace(",", ".")) == pytest.approx(float(plain[0]["closest_m"])) and "," in value
    assert (tmp_path / "exposure.parquet").read_bytes() == (results / "exposure.parquet").read_bytes()
    assert (tmp_path / "coco_keypoints.json").exists()


def test_what_lies_in_the_folder_is_not_written_again(results, tmp_path, capsys):
    assert main(["export", str(results)]) == 0
    assert "there already" in capsys.readouterr().out
    assert main(["export", str(results), "--out", str(tmp_path)]) == 0
    assert (tmp_path / "tracks.csv").read_bytes() == (results / "tracks.csv").read_bytes()
    assert main(["export", str(results), "--locale", "fi"]) == 2
    assert "--locale needs --out" in capsys.readouterr().err


def test_the_page_needs_nothing_else(results):
    page = (results / "report.html").read_text()
    assert "default-src 'none'" in page and "http" not in page.replace("http-equiv", "")
    assert "From above" in page and "walk.avi" in page


def test_a_frame_is_measured_as_the_photo_is(made, results):
    from proxemetry.archive.store.folder import Folder
    from proxemetry.clip.measuring import scenes
    from proxemetry.scene import Scene

    (_, texts), *_ = scenes(Folder(results))
    frame = next(VideoFile.open(made / "walk.avi", 5.0).frames())
    photo = measure(
        frame.photo, pose=backend_named(f"recorded:{made / 'walk.json'}"), settings=Settings(mount=clips.mount())
    )
    scene = Scene.from_json(texts[0])
    assert np.allclose(scene.distances_m, photo.distances_m, atol=1e-5, equal_nan=True)


def test_a_clip_of_one_frame_has_the_photo_s_people_and_distances(made, tmp_path):
    clips.write_video(tmp_path / "walk.avi", 1, 5.0)
    (tmp_path / "camera.json").write_text((made / "camera.json").read_text())
    (tmp_path / "walk.json").write_text((made / "walk.json").read_text())
    assert video(tmp_path, tmp_path / "out") == 0
    pairs = table(tmp_path / "out", "pairs_over_time")
    assert len(pairs) == 6
    frame = next(VideoFile.open(tmp_path / "walk.avi", 5.0).frames())
    photo = measure(
        frame.photo, pose=backend_named(f"recorded:{made / 'walk.json'}"), settings=Settings(mount=clips.mount())
    )
    expected = sorted(photo.distances_m[np.triu_indices(4, 1)])
    assert sorted(float(p["distance_m"]) for p in pairs) == pytest.approx(expected, abs=0.1)


def test_the_same_command_again_measures_nothing_again(made, results, monkeypatch):
    from proxemetry.clip import measuring

    def refuse(*_):
        raise AssertionError("measured again")

    monkeypatch.setattr(measuring.Worker, "record", refuse)
    assert video(made, results, "--within", "0.8") == 0
    assert "seconds_within_0.8" in table(results, "exposure")[0]
    monkeypatch.undo()
    assert video(made, results) == 0


@pytest.mark.parametrize("kind", ["flipped", "gone"])
def test_frames_whose_part_is_damaged_or_gone_are_measured_again(kind, made, results, tmp_path, capsys):
    there = Path(shutil.copytree(results, tmp_path / "out"))
    before = (there / "frames.csv").read_bytes()
    part = there / "scenes" / "part-000000.parquet"
    content = bytearray(part.read_bytes())
    part.unlink()
    if kind == "flipped":
        content[len(content) // 3] ^= 4
        part.write_bytes(content)
    assert video(made, there) == 0
    assert (there / "frames.csv").read_bytes() == before
    assert ("part-000000.parquet: damaged since" in capsys.readouterr().err) == (kind == "flipped")


@pytest.mark.parametrize("command", ["summary", "report", "review", "score"])
def test_what_is_for_photos_alone_says_so_of_a_clip(command, results, capsys):
    more = ["--labels", str(results)] if command == "score" else []
    assert main([command, str(results), *more]) == 2
    said = capsys.readouterr().err
    assert said.count("\n") == 1 and "results of a clip, not of photos: its page is report.html" in said


def test_other_settings_are_refused(made, results, capsys):
    assert video(made, results, "--fps", "2") == 2
    assert "--fps was 5.0, is 2" in capsys.readouterr().err


def test_aggregates_name_nobody(made, tmp_path):
    assert video(made, tmp_path / "out") == 0
    (tmp_path / "out" / "tracks_1.sav").write_bytes(b"an export's")
    assert video(made, tmp_path / "out", "--aggregate-only") == 0
    left = {p.name for p in (tmp_path / "out").rglob("*") if p.is_file()}
    assert left == {
        "frames.csv", "frames.parquet", "codebook.csv", "maps.npz", "summary.json", "report.html", "run.json",
        "mount.json",
    }  # fmt: skip
    data = (tmp_path / "out" / "report.html").read_text()
    assert '"tracks":[]' in data and '"pairs":[]' in data
    assert np.isnan(np.load(tmp_path / "out" / "maps.npz")["density_persons_m2"]).all()  # four people are too few


def test_only_pairs_count_whose_people_are_recorded_so(made, results, tmp_path, capsys):
    content = json.loads((made / "walk.json").read_text())
    for number, image in enumerate(content["images"]):
        for k, person in enumerate(image["people"]):
            sure = number % 3  # a third of the frames is mistaken
            person["attributes"] = {"mask": ("no" if k < 2 else "yes") if sure else "unknown", "=1": "=2"}
    (made / "masks.json").write_text(json.dumps(content))
    assert video(made, tmp_path / "out", "--pairs-where", "mask=no", keypoints="masks.json") == 0
    people = table(tmp_path / "out", "people")
    assert sorted(p["attr_mask"] for p in people) == ["no", "no", "yes", "yes"]
    assert {p["attr_=1"] for p in people} == {"'=2"}
    (pair,) = table(tmp_path / "out", "exposure")
    assert {pair["track_a"], pair["track_b"]} == {p["track"] for p in people if p["attr_mask"] == "no"}
    summary = json.loads((tmp_path / "out" / "summary.json").read_text())
    assert summary["pairs_where"] == "mask=no" and "mask=no" in summary["notes"][-1]
    assert summary["n_tracks"] == 4 and len(table(results, "exposure")) == 6
    import duckdb

    (values,) = zip(*duckdb.sql(f"""SELECT "attr_=1" FROM '{tmp_path}/out/people.parquet'""").fetchall(), strict=True)
    assert set(values) == {"=2"}
    pytest.importorskip("pyreadstat")
    assert main(["export", str(tmp_path / "out"), "--format", "spss"]) == 0
    assert video(made, tmp_path / "out", "--pairs-where", "hat=1", keypoints="masks.json") == 2
    assert "no person has an attribute 'hat'; there are =1, mask" in capsys.readouterr().err


def test_people_alone_tell_the_camera(made, tmp_path):
    code = main([
        "video", str(made / "walk.avi"), "--out", str(tmp_path / "out"), "--jobs", "0", "--focal-px",
        str(clips.FOCAL_PX), "--detections", f"recorded:{made / 'walk.json'}",
    ])  # fmt: skip
    assert code == 0
    mount = json.loads((tmp_path / "out" / "mount.json").read_text())
    assert mount["pitch_deg"] == pytest.approx(20, abs=5)
    assert mount["height_m"] == pytest.approx(4, rel=0.15)


def test_whose_legs_are_hidden_is_placed_by_the_stature_seen_before(made, tmp_path, monkeypatch):
    from proxemetry.clip import following

    truth = clips.walkers(FRAMES, STEP)
    hidden = np.zeros((FRAMES, 4), dtype=bool)
    hidden[8:, 3] = True  # who stands 13 m away, 1.49 m tall
    names = [f"walk.avi#t={k * STEP:.3f}" for k in range(FRAMES)]
    clips.recorded(tmp_path / "walk.json", names, truth, seed=8, hidden=hidden)
    for name in ("walk.avi", "camera.json"):
        (tmp_path / name).write_bytes((made / name).read_bytes())

    def error(out):
        assert video(tmp_path, out) == 0
        rows = table(out, "tracks")
        begun = {r["track"]: float(r["y_m"]) for r in reversed(rows) if r["frame"] == "0"}
        mine = [r for r in rows if r["track"] == max(begun, key=begun.get) and int(r["frame"]) >= 15]
        path = np.array([[float(r["x_m"]), float(r["y_m"])] for r in mine])
        off = np.linalg.norm(path - truth[0, 3], axis=1)
        return off.mean(), np.mean([float(r["y_sd_m"]) for r in mine])

    told, spread = error(tmp_path / "out")
    monkeypatch.setattr(following, "known_statures", lambda chains, statures, shot: [{} for _ in shot])
    alone, wide = error(tmp_path / "alone")
    assert told < 0.6 * alone and spread < wide
    people = table(tmp_path / "out", "people")
    assert len(people) == 4 and all(int(p["n_seen"]) == FRAMES for p in people)


def test_boxes_of_another_program_stand_on_the_floor(made, tmp_path):
    truth = clips.walkers(FRAMES, STEP)
    lines = []
    for k in range(FRAMES):
        for p, (x, y) in enumerate(truth[k]):
            feet, head = clips.camera().project(clips.on_floor([[x, y, 0.0], [x, y, 1.7]]))
            tall = feet[1] - head[1]
            lines.append(f"{k + 1},{p},{feet[0] - tall / 6:.2f},{head[1]:.2f},{tall / 3:.2f},{tall:.2f},0.9,-1,-1,-1")
    (tmp_path / "boxes.txt").write_text("\n".join(lines))
    assert main([
        "video", str(made / "walk.avi"), "--out", str(tmp_path / "out"), "--jobs", "0", "--mount",
        str(made / "camera.json"), "--detections", str(tmp_path / "boxes.txt"),
    ]) == 0  # fmt: skip
    tracks = table(tmp_path / "out", "tracks")
    assert len({r["track"] for r in tracks}) == 4
    assert {r["doubt"] for r in [*tracks, *table(tmp_path / "out", "people")]} == {""}  # boxes tell nothing of it
    places = np.array([[float(r["x_m"]), float(r["y_m"])] for r in tracks if r["frame"] == "10"])
    assert np.linalg.norm(places[:, None] - truth[10], axis=-1).min(axis=1) == pytest.approx(np.zeros(4), abs=0.1)


def test_boxes_above_the_horizon_are_nowhere():
    boxes = np.array([[300.0, 100, 340, 300], [300, 0, 340, 1]])
    people = People(COCO_17, np.full((2, 17, 2), np.nan), np.zeros((2, 17)), boxes, np.ones(2))
    level = clips.mount().resized(clips.WIDTH, clips.HEIGHT)
    bodies = standing(people, level)
    assert bodies.placed.tolist() == [True, False] or bodies.placed.tolist() == [True, True]
    assert Boxes("x", "", {}).frames == {}


def test_times_are_the_file_s_own(tmp_path):
    path = clips.write_video(tmp_path / "a.avi", 20, 10.0)
    frames = list(VideoFile.open(path, 5.0).frames())
    assert [f.t_s for f in frames] == pytest.approx(np.arange(10) * 0.2)
    assert [f.source for f in frames] == list(range(0, 20, 2))
    assert frames[3].photo.name == "a.avi#t=0.600"
    assert len(list(VideoFile.open(path, 30.0).frames())) == 20


def test_a_folder_of_pictures_goes_the_same_way(made, tmp_path):
    folder = tmp_path / "series"
    folder.mkdir()
    for k in range(12):
        cv2.imwrite(str(folder / f"{k}.png"), clips.background((clips.WIDTH, clips.HEIGHT)))
    (folder / "12.png").write_bytes(b"none")
    clip = open_clip(folder, 5.0)
    assert isinstance(clip, PictureFolder) and not clip.timed
    assert [f.photo.name for f in clip.frames()][9:] == ["series/9.png", "series/10.png", "series/11.png"]
    clips.recorded(tmp_path / "k.json", [f"series/{k}.png" for k in range(12)], clips.walkers(12, STEP))
    (tmp_path / "camera.json").write_text((made / "camera.json").read_text())
    assert video(tmp_path, tmp_path / "out", clip="series", keypoints="k.json") == 0
    assert len(table(tmp_path / "out", "people")) == 4


def test_pictures_of_several_sizes_are_refused_before_any_is_measured(tmp_path):
    for k in range(4):
        cv2.imwrite(str(tmp_path / f"{k}.png"), np.zeros((48, 64 if k != 2 else 60, 3), np.uint8))
    with pytest.raises(ClipError, match=r"2\.png has 60 x 48 pixels, most have 64 x 48"):
        open_clip(tmp_path, 5.0)


def test_a_picture_replaced_by_one_of_as_many_bytes_is_another_clip(tmp_path):
    """Uncompressed pictures of one camera all have one length."""
    for k in range(2):
        cv2.imwrite(str(tmp_path / f"{k}.bmp"), np.zeros((48, 64, 3), np.uint8))
    before = open_clip(tmp_path, 5.0).sha256
    assert open_clip(tmp_path, 5.0).sha256 == before
    cv2.imwrite(str(tmp_path / "1.bmp"), np.full((48, 64, 3), 9, np.uint8))
    assert open_clip(tmp_path, 5.0).sha256 != before


def test_a_clips_folder_names_system_and_processor_and_nothing_more_of_the_machine(results):
    assert json.loads((results / "run.json").read_text())["platform"] == f"{platform.system()} {platform.machine()}"


def finder_of(pictures):
    finder = ShotFinder()
    for k, picture in enumerate(pictures):
        finder.see(picture, k * STEP)
    return finder.shots()


def shifted(picture, x):
    return np.ascontiguousarray(np.roll(picture, x, axis=1))


def test_a_cut_a_bump_and_the_way_back_are_seen():
    one, other = (clips.background((640, 480), seed) for seed in (1, 2))
    shots = finder_of([one] * 5 + [other] * 5 + [one] * 5 + [shifted(one, 12)] * 5)
    assert [(s.first, s.last, s.camera, str(s.began)) for s in shots] == [
        (0, 4, 0, "start"), (5, 9, 1, "cut"), (10, 14, 0, "cut"), (15, 19, 2, "camera moved"),
    ]  # fmt: skip
    assert shots[3].shift_share == pytest.approx(12 / 640, rel=0.2)


def test_a_camera_that_stays_is_one_shot_and_one_that_pans_is_moving():
    one = clips.background((640, 480), 3)
    noisy = [np.clip(one + np.random.default_rng(k).normal(0, 4, one.shape), 0, 255).astype(np.uint8) for k in range(8)]
    assert len(finder_of(noisy)) == 1
    (pan,) = finder_of([shifted(one, 9 * k) for k in range(12)])
    assert pan.moving


def test_pictures_of_noise_are_not_as_many_cameras():
    """At night, or through a cable that is loose, no frame shows what the one before did."""
    wall = np.full((480, 640, 3), 90)
    noisy = [(wall + np.random.default_rng(k).integers(0, 9, wall.shape)).astype(np.uint8) for k in range(10)]
    (shot,) = finder_of(noisy)
    assert shot.moving  # nobody can say that it stays


@pytest.mark.parametrize("content", [b"", b"RIFF not a video", None])
def test_what_is_no_video_is_said_in_one_line(tmp_path, capsys, content, made):
    path = tmp_path / "bad.mp4"
    if content is not None:
        path.write_bytes(content)
    assert main(["video", str(path), "--out", str(tmp_path / "out"), "--jobs", "0", "--pose", "recorded:x"]) == 2
    said = capsys.readouterr().err.strip().splitlines()
    assert len(said) == 1 and "bad.mp4" in said[0]
    with pytest.raises(ClipError):
        open_clip(path, 5.0)


def test_of_several_clips_each_has_a_row(made, tmp_path, capsys):
    (tmp_path / "bad.avi").write_bytes(b"no")
    code = main([
        "video", str(made / "walk.avi"), str(tmp_path / "bad.avi"), "--out", str(tmp_path / "out"), "--mount",
        str(made / "camera.json"), "--jobs", "0", "--detections", f"recorded:{made / 'walk.json'}",
    ])  # fmt: skip
    assert code == 1
    rows = table(tmp_path / "out", "clips")
    assert [r["status"] for r in rows] == ["ok", "failed"] and rows[1]["reason"]
    assert (tmp_path / "out" / "walk" / "exposure.csv").exists()


def test_a_mount_of_another_size_is_refused_before_anything_is_done(made, tmp_path, capsys):
    clips.write_video(tmp_path / "walk.avi", 3, 5.0, (320, 240))
    (tmp_path / "camera.json").write_text((made / "camera.json").read_text())
    (tmp_path / "walk.json").write_text((made / "walk.json").read_text())
    assert video(tmp_path, tmp_path / "out") == 2
    assert "320 x 240" in capsys.readouterr().err
    with pytest.raises(CameraError):
        clips.mount().check_size(320, 240)


def test_nobody_ever_is_a_result(made, tmp_path):
    clips.recorded(
        tmp_path / "walk.json", [f"walk.avi#t={k * STEP:.3f}" for k in range(FRAMES)], np.full((FRAMES, 1, 2), np.nan)
    )
    for name in ("walk.avi", "camera.json"):
        (tmp_path / name).write_bytes((made / name).read_bytes())
    assert video(tmp_path, tmp_path / "out") == 0
    summary = json.loads((tmp_path / "out" / "summary.json").read_text())
    assert summary["n_tracks"] == 0 and summary["within_m"]["2"]["pair_seconds"]["seconds"] == 0
    assert table(tmp_path / "out", "exposure") == []


def test_killed_at_any_moment_every_frame_is_there_once(made, tmp_path):
    names = [f"long.avi#t={k * STEP:.3f}" for k in range(100)]
    clips.write_video(tmp_path / "long.avi", 100, 1 / STEP)
    clips.recorded(tmp_path / "long.json", names, clips.walkers(100, STEP)[:, 3:])
    command = [
        sys.executable, "-m", "proxemetry", "video", str(tmp_path / "long.avi"), "--out", str(tmp_path / "out"),
        "--mount", str(made / "camera.json"), "--jobs", "1", "--detections", f"recorded:{tmp_path / 'long.json'}",
    ]  # fmt: skip
    part = tmp_path / "out" / "scenes" / "part-000000.parquet"
    process = subprocess.Popen(command, stderr=subprocess.DEVNULL, stdout=subprocess.DEVNULL, env={**os.environ})
    while process.poll() is None and not part.exists():
        time.sleep(0.02)
    process.send_signal(signal.SIGKILL)
    process.wait()
    written = part.stat().st_mtime_ns
    assert subprocess.run(command, capture_output=True, check=False).returncode == 0
    assert part.stat().st_mtime_ns == written
    assert [int(r["frame"]) for r in table(tmp_path / "out", "frames")] == list(range(100))
    coco = json.loads((Path(tmp_path) / "out" / "coco_keypoints.json").read_text())
    assert [i["file_name"] for i in coco["images"]] == names
