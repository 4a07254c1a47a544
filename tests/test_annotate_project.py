"""Annotations of one's own photos: actions, undo and redo, what is kept through kill -9, and the label files."""

import json
import math
import subprocess
import sys
import threading
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from proxemetry.annotate.actions import KINDS, apply, replayed
from proxemetry.annotate.history import history
from proxemetry.annotate.label_files import CAMERA_TABLE
from proxemetry.annotate.lens import recorded_lens
from proxemetry.annotate.project import LOG_FILE, Project
from proxemetry.annotate.proposals import proposed_people
from proxemetry.annotate.scoring import score_own_run
from proxemetry.annotate.state import Annotations, PhotoNotes
from proxemetry.archive.review.actions import Action
from proxemetry.benchmark import read_labels
from proxemetry.benchmark.validate_labels import check_labels
from proxemetry.camera.table import CameraTable
from proxemetry.errors import LabelsError, OutputError, SettingsError
from proxemetry.evaluate import camera_of_labels
from proxemetry.people import People
from proxemetry.people.skeleton import COCO_17, PARTS
from proxemetry.photo import Photo
from synthetic.drawn import people_at
from synthetic.reviewing import CAMERA, HEIGHT, WIDTH, draw_photo

#: Two people at 5 m, 1.5 m apart.
TWO = [(-0.75, 0.0, 5.0), (0.75, 0.0, 5.0)]


def drawn_two(pixels: np.ndarray) -> People:
    """Find the two people of the drawn photos."""
    return people_at(TWO, CAMERA)


POSE = "python:tests.test_annotate_project:drawn_two"


@pytest.fixture
def photos(tmp_path: Path) -> Path:
    for k, name in enumerate(("a.jpg", "b.jpg", "far/c.jpg")):
        draw_photo(tmp_path / "photos" / name, people_at([*TWO, (0.2 * k, 0.0, 8.0)], CAMERA))
    return tmp_path / "photos"


def opened(photos: Path, **options) -> Project:
    return Project([str(photos)], str(photos.parent / "labels"), pose=options.pop("pose", POSE), **options)


def annotated(photos: Path) -> Project:
    """Return a project with everything done: three photos, two people, places typed."""
    project = opened(photos)
    for k in range(3):
        project.propose(k)
        for person, tag in zip(project.notes(k).people, ("P0", "P1"), strict=True):
            project.act(k, "name_person", {"person": person.key, "tag": tag})
    for tag, at in (("C0", [0, 0]), ("P0", [-0.75, 5]), ("P1", [0.75, 5])):
        project.act(None, "set_spot", {"shoot": 0, "tag": tag, "at": at})
    return project


# Actions


def test_proposals_are_the_benchmarks_parts_from_left_to_right(photos: Path) -> None:
    project = opened(photos)
    project.propose(0)
    project.propose(0)  # once is enough
    people = project.notes(0).people
    expected = people_at(TWO, CAMERA)
    assert [p.tag for p in people] == [None, None] and [p.by for p in people] == [POSE, POSE]
    for k, person in enumerate(people):
        assert {part: person.points[part] for part in person.points} == {
            part: tuple(int(v) for v in expected.part(part)[k]) for part in PARTS if part in person.points
        }
        assert set(person.points) == set(PARTS)


def test_no_point_is_proposed_outside_the_picture_nor_eyes_of_which_one_is() -> None:
    keypoints = np.full((1, 17, 2), np.nan)
    for joint, at in (("left_eye", (98, 20)), ("right_eye", (104, 20)), ("left_shoulder", (60, 50)),
                      ("right_shoulder", (90, 50)), ("left_hip", (60, 120)), ("right_hip", (90, 120))):  # fmt: skip
        keypoints[0, COCO_17.joints.index(joint)] = at
    people = People(COCO_17, keypoints, np.isfinite(keypoints).all(axis=-1) * 0.9)
    (person,) = proposed_people(people, 100, 100, 7)
    assert person == {"person": 7, "points": {"Shoulder": [75, 50], "Torso": [75, 85]}}
    (left, right) = proposed_people(people_at([TWO[1], TWO[0]], CAMERA), WIDTH, HEIGHT, 0)
    assert left["points"]["Head"][0] < right["points"]["Head"][0] and (left["person"], right["person"]) == (0, 1)
    unsure = replace(people, scores=people.scores * 0.2)
    assert proposed_people(unsure, 200, 200, 0) == []


def test_points_are_set_moved_and_taken_away(photos: Path) -> None:
    project = opened(photos, pose="none")
    project.act(0, "add_person", {"points": {"Head": [10.9, 20.2]}})
    project.act(0, "set_point", {"person": 0, "part": "Eyes", "to": [11, 19]})
    project.act(0, "set_point", {"person": 0, "part": "Head", "to": [12, 22]})
    assert project.notes(0).people[0].points == {"Head": (12, 22), "Eyes": (11, 19)}
    project.act(0, "set_point", {"person": 0, "part": "Head", "to": None})
    assert project.notes(0).people[0].points == {"Eyes": (11, 19)}
    project.act(0, "remove_person", {"person": 0})
    assert project.notes(0).people == ()


def test_a_name_is_one_persons(photos: Path) -> None:
    project = annotated(photos)
    first, second = project.notes(0).people
    project.act(0, "name_person", {"person": second.key, "tag": "P0"})
    assert [p.tag for p in project.notes(0).people] == [None, "P0"]
    project.act(0, "name_people", {"names": [{"person": first.key, "tag": "P0"}, {"person": second.key, "tag": "P1"}]})
    assert [p.tag for p in project.notes(0).people] == ["P0", "P1"]


def test_undo_and_redo_walk_through_everything(photos: Path) -> None:
    project = opened(photos, pose="none")
    assert project.undo() is None and project.redo() is None
    states = [project.now]
    project.act(0, "add_person", {"points": {"Head": [10, 20]}})
    states.append(project.now)
    project.act(1, "finish", {"done": True})
    states.append(project.now)
    project.act(None, "set_tape", {"shoot": 0, "a": "P0", "b": "P1", "metres": 2})
    states.append(project.now)
    for state in states[-2::-1]:
        project.undo()
        assert project.now == state
    for state in states[1:]:
        project.redo()
        assert project.now == state
    project.undo()
    project.act(1, "finish", {"done": False})
    assert project.redo() is None  # as in any editor


steps = st.lists(st.sampled_from(["act", "undo", "redo", "propose"]), max_size=30)


@settings(max_examples=60)
@given(steps)
def test_the_log_of_undos_is_that_of_an_editor(walk: list[str]) -> None:
    """Replaying the log gives what a stack of states gives; what the program proposed is never taken back."""
    entries: list[Action] = []
    done: list[int] = []
    undone: list[int] = []
    proposed: list[int] = []
    for number, step in enumerate(walk):
        entries.append(Action(number, "", "ada", "", "", {"act": "finish"}.get(step, step), {}))
        if step == "act":
            done.append(number)
            undone.clear()
        elif step == "undo" and done:
            undone.append(done.pop())
        elif step == "redo" and undone:
            done.append(undone.pop())
        elif step == "propose":
            proposed.append(number)
    found = history(entries)
    assert sorted(a.number for a in found.in_force) == sorted([*done, *proposed])
    assert (found.undoable.number if found.undoable else None) == (done[-1] if done else None)
    assert (found.redoable.number if found.redoable else None) == (undone[-1] if undone else None)


def test_keys_are_never_used_again(photos: Path) -> None:
    project = opened(photos)
    project.act(0, "add_person", {"points": {"Head": [10, 20]}})
    project.undo()
    project.propose(0)
    assert [p.key for p in project.notes(0).people] == [1, 2]
    project.redo()
    assert sorted(p.key for p in project.notes(0).people) == [0, 1, 2]


def test_scopes_say_which_photos_are_meant(photos: Path) -> None:
    project = opened(photos, pose="none")
    camera_of = lambda: [project.notes(k).camera for k in range(3)]  # noqa: E731
    assert [p.name for p in project.photos] == ["a.jpg", "b.jpg", "far/c.jpg"]
    project.act(1, "place_photos", {"shoot": 0, "camera": "C1", "scope": "following"})
    assert camera_of() == ["C0", "C1", "C1"]
    project.act(2, "place_photos", {"shoot": 0, "camera": "C2", "scope": "folder"})
    assert camera_of() == ["C0", "C1", "C2"]
    project.act(0, "place_photos", {"shoot": 0, "camera": "C3", "scope": "camera"})  # by the model in the file
    assert camera_of() == ["C3", "C3", "C2"]
    project.act(0, "place_photos", {"shoot": 4, "camera": "C4", "scope": "all"})
    assert (camera_of() == ["C4"] * 3 and project.now.shoot_numbers(project.files) == [0, 4]) or [4]
    with pytest.raises(SettingsError, match="scope 'some' is unknown"):
        project.act(0, "place_photos", {"shoot": 0, "camera": "C0", "scope": "some"})


HOSTILE = [
    ("add_person", {"points": {}}),
    ("add_person", {"points": {"Knee": [1, 1]}}),
    ("add_person", {"points": {"Head": [math.nan, 1]}}),
    ("add_person", {"points": {"Head": [1e308, 1]}}),
    ("add_person", {"points": {"Head": [True, 1]}}),
    ("add_person", {"points": {"Head": [-1, 1]}}),
    ("add_person", {"points": {"Head": [WIDTH, 1]}}),
    ("add_person", {"points": [[1, 1]]}),
    ("set_point", {"person": 99, "part": "Head", "to": [1, 1]}),
    ("set_point", {"person": 0, "part": "Nose", "to": [1, 1]}),
    ("set_point", {"person": 0, "part": "Head"}),
    ("name_person", {"person": 0, "tag": "Q0"}),
    ("name_person", {"person": 0, "tag": "P-1"}),
    ("name_person", {"person": 0, "tag": "P1000"}),
    ("name_person", {"person": 0, "tag": "P01"}),
    ("name_person", {"person": 0, "tag": ["P0"]}),
    ("name_people", {"names": []}),
    ("name_people", {"names": ["P0"]}),
    ("name_tag", {"tag": "P0", "name": "\ud800"}),
    ("name_tag", {"tag": "P0", "name": "a\nb"}),
    ("name_tag", {"tag": "P0", "name": "x" * 101}),
    ("name_shoot", {"shoot": -1, "name": "x"}),
    ("name_shoot", {"shoot": 1.5, "name": "x"}),
    ("name_shoot", {"shoot": 0, "name": "a\u2028b"}),
    ("place_photos", {"shoot": 0, "camera": "../../etc", "scope": "photo"}),
    ("place_photos", {"shoot": 10**400, "camera": "C0", "scope": "photo"}),
    ("place_photos", {"shoot": 0, "camera": "C0", "photos": ["../x"]}),
    ("place_photos", {"shoot": 0, "camera": "C0"}),
    ("set_lens", {"scope": "photo", "lens": {"focal_35mm": -3}}),
    ("set_lens", {"scope": "photo", "lens": {"focal_35mm": math.inf}}),
    ("set_lens", {"scope": "photo", "lens": {"focal_35mm": 1e7}}),
    ("set_lens", {"scope": "photo", "lens": {"focal_mm": 50}}),
    ("set_lens", {"scope": "photo", "lens": {"focal_px": 500}}),
    ("set_lens", {"scope": "photo", "lens": {"focal_mm": 50, "sensor_mm": [36, 24], "focal_35mm": 50}}),
    ("set_lens", {"scope": "photo", "lens": [50]}),
    ("set_spot", {"shoot": 0, "tag": "P0", "at": [math.nan, 0]}),
    ("set_spot", {"shoot": 0, "tag": "P0", "at": [1e9, 0]}),
    ("set_spot", {"shoot": 0, "tag": "P0", "at": "0,0"}),
    ("set_spot", {"shoot": 0, "tag": "P0", "at": [0, 0], "sd_m": -1}),
    ("set_tape", {"shoot": 0, "a": "P0", "b": "P0", "metres": 1}),
    ("set_tape", {"shoot": 0, "a": "P0", "b": "P1", "metres": 0}),
    ("set_tape", {"shoot": 0, "a": "P0", "b": "P1", "metres": 1e12}),
    ("set_tape", {"shoot": 0, "a": "P0", "b": "P1", "metres": "2"}),
    ("finish", {"done": "yes"}),
    ("undo", {}),
    ("propose", {"pose": "x", "people": []}),
    ("drop_tables", {}),
]


@pytest.mark.parametrize(("action", "value"), HOSTILE)
def test_what_is_no_annotation_is_refused_in_one_line_and_not_kept(photos: Path, action: str, value: dict) -> None:
    project = opened(photos, pose="none")
    project.act(0, "add_person", {"points": {"Head": [10, 20]}})
    before = project.now
    with pytest.raises(SettingsError) as told:
        project.act(0, action, value)
    assert "\n" not in str(told.value) and project.now == before
    assert len(project.log.actions()) == 1


def test_every_kind_says_what_it_holds_and_a_log_of_nonsense_is_passed_over() -> None:
    assert all(kind.meaning for kind in KINDS.values())
    nonsense = [
        Action(k, "", "eve", "", "ab" * 32, kind, value)
        for k, (kind, value) in enumerate(
            (kind, value) for kind in KINDS for value in ({}, {"person": [], "points": 3, "people": [1], "names": {}})
        )
    ]
    now, lost = replayed(nonsense)
    assert now.photos == {} and len(lost) == len(nonsense)
    with pytest.raises(SettingsError):
        apply(Annotations(), Action(0, "", "", "", "", "finish", {"done": True}))  # of no photo


# Files


def test_the_label_files_are_what_the_projects_own_readers_expect(photos: Path) -> None:
    project = annotated(photos)
    assert project.check() == [] and check_labels(project.out) == []
    labels = read_labels(project.out)
    assert [image.filename for image in labels] == ["a.jpg", "b.jpg", "far/c.jpg"]
    image = labels.by_name["far/c.jpg"]
    assert (image.tags, image.shoot, image.camera, image.width, image.height) == (
        ("P0", "P1"),
        "0",
        "C0",
        WIDTH,
        HEIGHT,
    )
    assert image.distances_mm(ground=True)[0, 1] == 1500
    expected = [[tuple(p.points[part]) for part in PARTS] for p in project.notes(2).people]
    assert image.parts_px.tolist() == [[list(point) for point in person] for person in expected]
    for name in ("body_pixel_locations.csv", "ground_truth_locations.csv"):
        assert b"\r" not in (project.out / name).read_bytes()


@settings(max_examples=15)
@given(st.lists(st.tuples(st.integers(0, WIDTH - 1), st.integers(0, HEIGHT - 1)), min_size=4, max_size=4),
       st.integers(0, 999), st.integers(0, 999), st.text("abæ ,\"'=;", min_size=1, max_size=8))  # fmt: skip
def test_whatever_is_annotated_is_read_back(points, tag: int, shoot: int, name: str) -> None:
    from proxemetry.annotate.label_files import label_files
    from proxemetry.annotate.photos import OwnPhoto

    photo = OwnPhoto(Photo("x", WIDTH, HEIGHT, "ab" * 32), f"{name.strip()}.jpg", "/nowhere")
    entries = [
        ("add_person", {"person": 0, "points": dict(zip(PARTS, map(list, points), strict=True))}),
        ("name_person", {"person": 0, "tag": f"P{tag}"}),
        ("place_photos", {"photos": [photo.sha256], "shoot": shoot, "camera": "C7"}),
        ("name_shoot", {"shoot": shoot, "name": name}),
        ("set_spot", {"shoot": shoot, "tag": "C7", "at": [0, 0]}),
        ("set_spot", {"shoot": shoot, "tag": f"P{tag}", "at": [1.234, -5.678]}),
    ]
    now, lost = replayed([Action(k, "", "", photo.name, photo.sha256, a, v) for k, (a, v) in enumerate(entries)])
    assert not lost
    import tempfile

    with tempfile.TemporaryDirectory() as folder:
        for file, content in label_files(now, [photo], {shoot: now.places(shoot, [photo.sha256])}).items():
            if content is not None:
                (Path(folder) / file).write_bytes(content)
        assert check_labels(folder) == []
        (image,) = read_labels(folder)
    assert image.parts_px[0].tolist() == [list(p) for p in points]
    assert image.places_mm == {f"P{tag}": (1234, 0, -5678)}
    assert image.setting == (" ".join(name.split()) or f"shoot {shoot}")


def test_what_is_missing_is_a_fault_with_its_place(photos: Path) -> None:
    project = opened(photos)
    project.propose(0)
    assert all("empty" in str(fault) for fault in project.check())
    project.act(0, "name_person", {"person": 0, "tag": "P3"})
    told = [str(fault) for fault in project.check()]
    assert any("P3 is in a.jpg, but shoot 0 has no P3" in fault for fault in told)
    assert any("shoot 0 has no camera C0" in fault for fault in told)
    project.act(0, "skip", {"skipped": True})
    assert not any("P3" in str(fault) for fault in project.check())


def test_lenses_come_from_the_file_and_then_from_who_states_them(photos: Path) -> None:
    project = annotated(photos)
    assert not (project.out / "focal_lengths.csv").exists()  # the drawn photos record none
    project.act(0, "set_lens", {"scope": "all", "lens": {"focal_mm": 25, "sensor_mm": [18, 12]}})
    project.act(1, "set_lens", {"scope": "photo", "lens": {"focal_35mm": 50}})
    labels = read_labels(project.out)
    assert labels.by_name["a.jpg"].sensor_mm == (18, 12)
    a, b = (camera_of_labels(labels.by_name[name]).camera for name in ("a.jpg", "b.jpg"))
    assert a is not None and b is not None
    assert a.f_px == pytest.approx(25 / 18 * WIDTH) and b.f_px == pytest.approx(
        50 * math.hypot(WIDTH, HEIGHT) / 43.267, rel=1e-3
    )
    table = CameraTable.read(project.out / CAMERA_TABLE)
    assert table.row_for("b.jpg", None, None).focal_35mm == 50 and table.row_for("a.jpg", None, None).focal_mm == 25
    assert project.check() == []
    project.act(0, "set_lens", {"scope": "all", "lens": None})
    assert not (project.out / "focal_lengths.csv").exists() and not (project.out / CAMERA_TABLE).exists()


def test_an_upright_photos_sensor_is_turned_with_it(tmp_path: Path) -> None:
    """50 mm on a 30 x 20 mm sensor: 6000 pixels along the long side, whichever way the camera was held."""
    (tmp_path / "body_pixel_locations.csv").write_text("P0,Head,5,6,a.jpg,4000,6000\nP0,Head,5,6,b.jpg,6000,4000\n")
    (tmp_path / "ground_truth_locations.csv").write_text("0,C0,0,0,0\n0,P0,0,0,5000\n")
    (tmp_path / "camera_locations_photoshoot_identifiers.csv").write_text("0,C0,a.jpg\n0,C0,b.jpg\n")
    head = "filename,focal_length_mm,sensor_width_mm,sensor_height_mm\n"
    (tmp_path / "focal_lengths.csv").write_text(f"{head}a.jpg,50,30,20\nb.jpg,50,30,20\n")
    assert check_labels(tmp_path) == []
    for image in read_labels(tmp_path):
        camera = camera_of_labels(image).camera
        assert camera is not None and camera.f_px == pytest.approx(10_000)
    (tmp_path / "focal_lengths.csv").write_text(f"{head}a.jpg,50,0,20\n")
    assert "sensor_width_mm is '0'" in str(check_labels(tmp_path)[0])
    with pytest.raises(LabelsError, match="must be positive"):
        read_labels(tmp_path)


def test_a_files_own_lens_has_the_sensor_that_its_pixels_imply(tmp_path: Path) -> None:
    from PIL import Image

    exif = Image.Exif()
    exif[0x010F], exif[0x0110] = "Canon", "Canon EOS 6D Mark II"
    exif.get_ifd(0x8769)[0x920A], exif.get_ifd(0x8769)[0xA405] = 35.0, 35
    Image.new("RGB", (300, 450)).save(tmp_path / "x.jpg", exif=exif)  # upright
    lens = recorded_lens(Photo.open(tmp_path / "x.jpg"))
    assert lens is not None and lens.focal_mm == 35
    assert lens.sensor_mm == pytest.approx((36, 24), rel=0.03)


# What stays


def test_all_is_there_again(photos: Path) -> None:
    project = annotated(photos)
    project.undo()
    now = project.now
    project.close()
    again = opened(photos)
    assert again.now == now and again.redo() is not None


def test_a_renamed_photo_keeps_its_annotations(photos: Path) -> None:
    annotated(photos).close()
    (photos / "b.jpg").rename(photos / "z.jpg")
    again = opened(photos)
    assert [i.filename for i in read_labels(again.out)] == ["a.jpg", "far/c.jpg", "z.jpg"]


def test_nothing_is_lost_by_kill_9(photos: Path) -> None:
    out = photos.parent / "labels"
    program = f"""
import os, signal, sys
from proxemetry.annotate.project import Project
project = Project([{str(photos)!r}], {str(out)!r}, pose="none")
for k in range(50):
    project.act(0, "add_person", {{"points": {{"Head": [k, k]}}}})
    print(k, flush=True)
"""
    child = subprocess.Popen(
        [sys.executable, "-c", program], stdout=subprocess.PIPE, text=True, cwd=Path(__file__).parent.parent
    )
    assert child.stdout is not None
    answered = -1
    for line in child.stdout:
        answered = int(line)
        if answered == 7:
            child.kill()
            break
    child.wait()
    again = opened(photos, pose="none")
    assert len(again.notes(0).people) >= answered + 1
    assert not list(out.glob("*tmp*")) or again.check() is not None
    assert again.undo() is not None


def test_two_programs_on_one_folder_see_each_other(photos: Path) -> None:
    one, other = opened(photos, pose="none"), opened(photos, pose="none")
    one.act(0, "add_person", {"points": {"Head": [1, 1]}})
    other.act(0, "add_person", {"points": {"Head": [2, 2]}})
    assert [p.key for p in other.notes(0).people] == [0, 1]


def test_threads_do_not_lose_each_others_work(photos: Path) -> None:
    project = opened(photos, pose="none")
    work = [
        threading.Thread(target=lambda k=k: project.act(0, "add_person", {"points": {"Head": [k, k]}}))
        for k in range(8)
    ]
    for thread in work:
        thread.start()
    for thread in work:
        thread.join()
    assert len(project.notes(0).people) == 8 == len({p.key for p in project.notes(0).people})


def test_files_of_others_are_not_overwritten(photos: Path) -> None:
    out = photos.parent / "labels"
    out.mkdir()
    (out / "ground_truth_locations.csv").write_text("0,P0,0,0,0\n")
    with pytest.raises(OutputError, match="was not made by annotate"):
        opened(photos)
    assert (out / "ground_truth_locations.csv").read_text() == "0,P0,0,0,0\n"


def test_a_damaged_log_is_said_in_a_line(photos: Path) -> None:
    out = photos.parent / "labels"
    out.mkdir()
    (out / LOG_FILE).write_bytes(b"not a database" * 100)
    with pytest.raises(OutputError, match="log of annotations"):
        opened(photos)


def test_photos_that_cannot_be_used_are_left_out_with_the_reason(photos: Path) -> None:
    (photos / "broken.jpg").write_bytes(b"\xff\xd8\xff no more")
    (photos / "copy.jpg").write_bytes((photos / "a.jpg").read_bytes())
    odd = photos / "two\nlines.jpg"
    odd.write_bytes((photos / "b.jpg").read_bytes() + b" ")
    project = opened(photos, pose="none")
    assert [p.name for p in project.photos] == ["a.jpg", "b.jpg", "far/c.jpg"]
    assert len(project.left_out) == 3
    assert any("same file as a.jpg" in why for why in project.left_out)
    with pytest.raises(SettingsError, match="no photo that can be read"):
        Project([str(photos / "broken.jpg")], str(photos.parent / "other"), pose="none")


def test_what_annotate_wrote_is_not_taken_for_photos(photos: Path) -> None:
    inside = photos / "labels"
    Project([str(photos)], str(inside), pose="none").close()
    draw_photo(inside / "run" / "overlay.jpg", people_at(TWO, CAMERA))
    assert len(Project([str(photos)], str(inside), pose="none").photos) == 3


# The score


def test_the_tools_run_is_scored_under_both_protocols(photos: Path) -> None:
    project = annotated(photos)
    project.act(
        0, "set_lens", {"scope": "all", "lens": {"focal_35mm": CAMERA.f_px * 43.2666 / math.hypot(WIDTH, HEIGHT)}}
    )
    scores = score_own_run(project, ("torso", "scene"), jobs=0)
    assert list(scores) == ["v1", "seker2021"]
    overall = scores["v1"]["torso"].overall
    assert overall.n_images == 3 and overall.n_pairs == 3 and overall.detection_rate == 1
    assert overall.pair_error_pct_mean_over_images < 3  # the drawn people are as tall as the torso's constant has it
    assert {"torso", "scene", "scene-positions"} == set(scores["seker2021"])
    kept = json.loads((project.out / "run" / "score_scene_v1.json").read_text())
    assert kept["protocol"] == "v1" and len(kept["images"]) == 3
    before = (project.out / "run" / "photos.csv").read_bytes()
    project.act(
        0, "set_lens", {"scope": "all", "lens": {"focal_35mm": 2 * CAMERA.f_px * 43.2666 / math.hypot(WIDTH, HEIGHT)}}
    )
    again = score_own_run(project, ("torso",), jobs=0)  # another lens: measured anew
    assert (project.out / "run" / "photos.csv").read_bytes() != before
    assert again["v1"]["torso"].overall.signed_bias_pct == pytest.approx(overall.signed_bias_pct, abs=5)


def test_what_cannot_be_scored_yet_says_what_is_missing(photos: Path) -> None:
    project = opened(photos)
    with pytest.raises(LabelsError, match="nobody is annotated"):
        score_own_run(project, jobs=0)
    project.propose(0)
    project.act(0, "name_person", {"person": 0, "tag": "P3"})
    with pytest.raises(LabelsError, match="shoot 0 has no P3"):
        score_own_run(project, jobs=0)


def test_a_photo_without_notes_is_empty() -> None:
    assert Annotations().photo("x") == PhotoNotes() and not list(Annotations().counted(["x"]))


def test_a_shoots_places_are_the_same_values_after_everything_is_taken_back_and_done_again(photos: Path) -> None:
    """What is shown of a tape is found by its value: undo and redo make new ones."""
    from proxemetry.web.annotate_view import places_view

    project = annotated(photos)
    project.act(None, "set_tape", {"shoot": 0, "a": "P0", "b": "P1", "metres": 1.52})
    shown = places_view(project, 0)
    project.undo()
    project.redo()
    assert places_view(project, 0) == shown and shown["tapes"][0]["residual_m"] == pytest.approx(0.0067, abs=1e-3)
