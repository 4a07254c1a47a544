"""Corrections: each does what it says, nothing is lost, and they follow their file through a rerun."""

import json
import sqlite3
from collections.abc import Iterable, Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from proxemetry.archive.review.corrections import FILE, Action, FileKey, Log, apply, corrected_scenes, in_force
from proxemetry.archive.store.index import card_of
from proxemetry.camera import Camera, CameraEstimate, Doubt, Flag
from proxemetry.errors import OutputError, SettingsError
from proxemetry.measure import place
from proxemetry.scene import Review, Scene
from proxemetry.settings import Settings
from proxemetry.tables import rows
from synthetic.drawn import people_at

CAMERA = Camera.centred(1000, 1200, 800, source="test")
PLACES_M = [(-1.5, 0.0, 5.0), (0.0, 0.0, 5.0), (2.0, 0.0, 5.0)]


def drawn_scene(places_m=PLACES_M, camera: Camera | None = CAMERA, photo: str = "a.jpg", sha256: str = "a1") -> Scene:
    estimate = CameraEstimate(camera, reason=None if camera else "no focal length")
    return place(photo, sha256, 1200, 800, people_at(places_m, CAMERA), estimate, Settings(method="torso"))


def box_of(scene: Scene, person: int) -> list[float]:
    return scene.people.boxes_px[person].tolist()


def act(action: str, number: int = 1, who: str = "ada", **value) -> Action:
    return Action(number, "2025-01-01T00:00:00+00:00", who, "a.jpg", "a1", action, value)


def test_removing_a_person_leaves_the_others_distances() -> None:
    scene = drawn_scene()
    smaller = apply(scene, [act("remove_person", box=box_of(scene, 1))])
    assert len(scene) == 3 and len(smaller) == 2  # the measured scene is as it was
    assert smaller.distances_m[0, 1] == pytest.approx(3.5)  # from -1.5 m to 2 m, both 5 m away
    assert [r["person"] for r in rows("people", smaller)] == [0, 1]


def test_a_missed_person_is_added_by_a_few_joints() -> None:
    everybody, scene = drawn_scene(), drawn_scene(PLACES_M[:2])
    people = everybody.people
    joints = {j: people.joint(j)[2].tolist() for j in ("left_shoulder", "right_shoulder", "left_hip", "right_hip")}
    larger = apply(scene, [act("add_person", joints=joints)])
    assert larger.distances_m == pytest.approx(everybody.distances_m, rel=1e-6, nan_ok=True)
    assert np.isnan(larger.people.joint("nose")[2]).all()


def test_somebody_added_by_two_joints_can_be_removed_again() -> None:
    scene = drawn_scene()
    joints = {"left_shoulder": [50.0, 100.0], "left_hip": [50.0, 200.0]}  # a box without width
    larger = apply(scene, [act("add_person", joints=joints)])
    actions = [act("add_person", 1, joints=joints), act("remove_person", 2, box=box_of(larger, 3))]
    assert len(larger) == 4 and len(apply(scene, actions)) == 3


def test_moving_the_hips_moves_the_person() -> None:
    scene = drawn_scene()
    hips = {side: scene.people.joint(f"{side}_hip")[0] for side in ("left", "right")}
    shoulders = scene.people.joint("neck")[0]
    actions = [
        act("move_joint", k, box=box_of(scene, 0), joint=f"{side}_hip",
            to=(shoulders + 2 * (hips[side] - shoulders)).tolist())
        for k, side in enumerate(hips)
    ]  # fmt: skip
    nearer = apply(scene, actions)
    assert nearer.positions_m[0, 2] == pytest.approx(2.5, rel=0.03)  # a torso twice as long is half as far away
    assert nearer.positions_m[1:] == pytest.approx(scene.positions_m[1:])
    gone = apply(scene, [act("move_joint", box=box_of(scene, 0), joint="left_hip", to=None)])
    assert np.isnan(gone.people.joint("left_hip")[0]).all() and gone.people.scores[0].min() == 0


def test_a_focal_length_gives_a_photo_without_one_its_distances() -> None:
    unknown = drawn_scene(camera=None)
    assert unknown.status == "no_camera" and np.isnan(unknown.distances_m).all()
    known = apply(unknown, [act("set_camera", focal_px=1000)])
    assert known.status == "ok" and known.distances_m[0, 1] == pytest.approx(1.5)
    assert known.camera.camera is not None and known.camera.camera.source.reviewed
    # 30 mm on a sensor 36 mm wide, 1200 px: 1000 px again
    same = apply(unknown, [act("set_camera", focal_mm=30, sensor_mm=[36, 24])])
    assert same.distances_m[0, 1] == pytest.approx(1.5, rel=1e-3)


def test_the_lens_stays_when_the_focal_length_changes() -> None:
    bent = replace(CAMERA, cx=580, distortion=(-0.1, 0.0, 0.0, 0.0, 0.0))
    camera = apply(drawn_scene(camera=bent), [act("set_camera", focal_px=1100)]).camera.camera
    assert camera is not None and (camera.cx, camera.distortion) == (580, bent.distortion)
    assert camera.f_px == pytest.approx(1100)


def test_a_body_size_is_stated_for_one_person_and_taken_back() -> None:
    scene = drawn_scene()
    child = apply(scene, [act("body_size", box=box_of(scene, 1), body_size="children")])
    assert child.settings.locate.body_sizes == (None, "children", None)
    back = apply(scene, [act("body_size", 1, box=box_of(scene, 1), body_size="children"),
                         act("body_size", 2, box=box_of(scene, 1), body_size=None)])  # fmt: skip
    assert back.distances_m == pytest.approx(scene.distances_m, nan_ok=True)


def test_who_is_off_the_floor_stays_so_when_another_is_removed() -> None:
    scene = drawn_scene()
    actions = [
        act("off_floor", 1, box=box_of(scene, 2), off_floor=True), act("remove_person", 2, box=box_of(scene, 0))
    ]  # fmt: skip
    assert apply(scene, actions).settings.locate.off_floor == {1}


def test_an_excluded_photo_keeps_its_row_and_loses_its_numbers() -> None:
    scene = drawn_scene()
    excluded = apply(scene, [act("exclude", excluded=True, reason="a mirror")])
    (row,) = rows("photos", excluded)
    assert (row["status"], row["reason"], row["n_people"]) == ("excluded", "excluded in review: a mirror", None)
    assert rows("pairs", excluded) == []
    back = apply(scene, [act("exclude", 1, excluded=True), act("exclude", 2, excluded=False)])
    assert back.status == "ok" and len(back) == 3


def test_a_focal_length_stated_by_hand_settles_the_doubts_about_the_old_one() -> None:
    crop = Flag(Doubt.CROPPED, "its shape is no sensor's")
    doubts = (Flag(Doubt.ASSUMED, "a guess"), Flag(Doubt.CONTRADICTED, "others"), Flag(Doubt.METADATA, "0/0"), crop)
    scene = drawn_scene()
    doubtful = replace(scene, camera=replace(scene.camera, flags=doubts))
    measured = apply(doubtful, [act("set_camera", focal_px=900)])
    assert measured.camera.flags == (crop,)
    guessed = apply(doubtful, [act("set_camera", focal_35mm=35)])
    assert guessed.camera.flags == (Flag(Doubt.ASSUMED, "focal length ASSUMED: 35 mm equivalent 35 mm"), crop)
    assert guessed.camera.is_assumed and card_of(guessed).doubtful
    (row,) = rows("photos", guessed)
    assert row["focal_source"] == "review: ASSUMED: 35 mm equivalent 35 mm" and row["focal_assumed"] is True


def test_notes_and_marks_change_no_number() -> None:
    scene = drawn_scene()
    noted = apply(scene, [act("note", text="<b>left one leans</b>"), act("checked", 2)])
    assert noted.bodies is scene.bodies
    (row,) = rows("photos", noted)
    assert (row["note"], row["corrections"]) == ("<b>left one leans</b>", 0)
    assert rows("photos", scene)[0]["corrections"] == 0


def test_what_was_corrected_and_by_whom_travels_with_the_scene() -> None:
    scene = drawn_scene()
    actions = [act("remove_person", 1, "ada", box=box_of(scene, 0)), act("checked", 2, "ben")]
    again = Scene.from_json(apply(scene, actions).to_json())
    assert again.review == Review(1, ("checked", "remove_person"), ("ada", "ben"))


def test_a_person_found_elsewhere_in_the_list_is_still_the_same() -> None:
    scene = drawn_scene()
    action = act("remove_person", box=box_of(scene, 0))
    shuffled = replace(scene, people=scene.people[[2, 0, 1]])
    assert apply(shuffled, [action]).people.boxes_px == pytest.approx(scene.people.boxes_px[[2, 1]])


def test_a_correction_of_somebody_who_is_not_there_changes_nothing() -> None:
    scene = drawn_scene()
    same = apply(scene, [act("remove_person", box=[0, 0, 5, 5])])
    assert same is scene


@settings(deadline=None)
@given(st.lists(st.sampled_from(["remove", "note", "exclude", "undo"]), max_size=12))
def test_undoing_everything_gives_the_measured_scene(kinds: list[str]) -> None:
    scene, log = drawn_scene(), Log(":memory:")
    for kind in kinds:
        if kind == "undo":
            log.undo(scene, "ada")
        elif kind == "remove":
            log.append(scene, "remove_person", {"box": box_of(scene, 1)}, "ada")
        elif kind == "note":
            log.append(scene, "note", {"text": "x"}, "ada")
        else:
            log.append(scene, "exclude", {"excluded": True}, "ada")
    while log.undo(scene, "ada"):
        pass
    assert apply(scene, in_force(log.actions(FileKey.of(scene)))) is scene
    assert len(log.actions()) >= len([k for k in kinds if k != "undo"])


def test_nobody_takes_back_anothers_correction() -> None:
    scene, log = drawn_scene(), Log(":memory:")
    log.append(scene, "note", {"text": "x"}, "ada")
    assert log.undo(scene, "ben") is None
    assert [a.who for a in in_force(log.actions())] == ["ada"]


def test_the_log_refuses_to_forget(tmp_path: Path) -> None:
    log = Log(tmp_path / FILE)
    log.append(drawn_scene(), "note", {"text": "x"}, "ada")
    log.close()
    with sqlite3.connect(tmp_path / FILE) as database:
        for statement in ("DELETE FROM actions", "UPDATE actions SET who = 'eve'"):
            with pytest.raises(sqlite3.DatabaseError, match="append-only"):
                database.execute(statement)
        row = database.execute("SELECT who, sha256, action, value, time FROM actions").fetchone()
    assert (*row[:3], json.loads(row[3])) == ("ada", "a1", "note", {"text": "x"})
    assert row[4].endswith("+00:00")


def test_the_log_is_one_file_however_its_program_ends(tmp_path: Path) -> None:
    log = Log(tmp_path / FILE)
    log.append(drawn_scene(), "note", {"text": "x"}, "ada")
    (tmp_path / "copy").mkdir()
    (tmp_path / "copy" / FILE).write_bytes(
        (tmp_path / FILE).read_bytes()
    )  # the program is still running, or was killed
    assert [a.value for a in Log(tmp_path / "copy" / FILE).actions()] == [{"text": "x"}]
    assert [p.name for p in tmp_path.iterdir() if p.is_file()] == [FILE]
    log.close()


def test_corrections_follow_the_file_not_its_name(tmp_path: Path) -> None:
    scene, other = drawn_scene(), drawn_scene(photo="b.jpg", sha256="b2")
    log = Log(tmp_path / FILE)
    log.append(scene, "exclude", {"excluded": True}, "ada")
    log.append(other, "note", {"text": "x"}, "ben")
    log.close()

    def found(stored: list[Scene]) -> dict[str, str]:
        def scenes(names: Iterable[str], files: Iterable[str]) -> Iterator[Scene]:
            return (s for s in stored if s.photo in set(names) or s.sha256 in set(files))

        return {p: s.status for p, s in corrected_scenes(tmp_path, scenes).items()}

    assert found([scene, other]) == {"a.jpg": "excluded", "b.jpg": "ok"}
    assert set(found([scene.renamed("new/a.jpg"), other])) == {"new/a.jpg", "b.jpg"}
    assert set(found([replace(scene, sha256="c3"), other])) == {"b.jpg"}  # another picture under the same name
    assert corrected_scenes(tmp_path / "nowhere", lambda names, files: iter([scene])) == {}


@pytest.mark.parametrize(
    ("action", "value"),
    [
        ("paint", {}), ("remove_person", {}), ("remove_person", {"box": [1, 2, 3, "x"]}),
        ("remove_person", {"box": [1, 2, 3, float("nan")]}), ("add_person", {"joints": {"nose": [1, 2]}}),
        ("add_person", {"joints": {"nose": [1], "left_eye": [1, 2]}}),
        ("move_joint", {"box": [0, 0, 1, 1], "to": None}),
        ("move_joint", {"box": [0, 0, 1, 1], "joint": "nose"}), ("set_camera", {}), ("set_camera", {"focal_px": -3}),
        ("set_camera", {"focal_px": 900, "focal_35mm": 28}), ("set_camera", {"focal_mm": 50}),
        ("body_size", {"box": [0, 0, 1, 1], "body_size": "giants"}), ("off_floor", {"box": [0, 0, 1, 1]}),
        ("exclude", {"excluded": "yes"}), ("note", {"text": "x" * 10_001}), ("note", {"text": 3}), ("undo", {}),
    ],
)  # fmt: skip
def test_what_cannot_be_read_is_not_kept(action: str, value: dict) -> None:
    log = Log(":memory:")
    with pytest.raises(SettingsError):
        log.append(drawn_scene(), action, value, "ada")
    assert log.actions() == []


@pytest.mark.parametrize(
    ("action", "value"),
    [
        ("set_camera", {"focal_px": 1e300}), ("set_camera", {"focal_px": 1e-320}),
        ("set_camera", {"focal_35mm": 1e200}),
        ("set_camera", {"focal_px": 10**400}), ("set_camera", {"focal_px": "900"}), ("set_camera", {"focal_px": True}),
        ("set_camera", {"focal_mm": 50, "sensor_mm": [36, "x"]}), ("note", {"text": "\ud800"}),
        ("exclude", {"excluded": True, "reason": "half \udc00"}),
        ("add_person", {"joints": {"left_shoulder": [1e12, 5], "right_shoulder": [9, 5]}}),
        ("add_person", {"joints": {"left_shoulder": [10**400, 5], "right_shoulder": [9, 5]}}),
    ],
)  # fmt: skip
def test_what_cannot_be_applied_is_not_kept_and_in_the_log_costs_its_photo_alone(
    action: str, value: dict, tmp_path: Path
) -> None:
    scene, other, log = drawn_scene(), drawn_scene(photo="b.jpg", sha256="b2"), Log(tmp_path / FILE)
    with pytest.raises(SettingsError, match="correction"):
        log.append(scene, action, value, "ada")
    assert log.actions() == []
    log.append(other, "note", {"text": "x"}, "ada")
    log.keep(Action(0, "2026-01-01T00:00:00+00:00", "ben", "a.jpg", "a1", action, value))  # an earlier version did
    log.close()
    found = corrected_scenes(tmp_path, lambda names, files: iter([scene, other]))
    assert (found["a.jpg"].status, found["b.jpg"].status) == ("failed", "ok")
    assert "(2 in the log) cannot be applied: " in (found["a.jpg"].reason or "")
    assert "\n" not in (found["a.jpg"].reason or "")
    json.loads(found["a.jpg"].to_json().encode())  # a file can hold it


def test_a_log_that_others_wrote_into_is_read(tmp_path: Path) -> None:
    log = Log(tmp_path / FILE)
    log.close()
    with sqlite3.connect(tmp_path / FILE) as database:
        for value in ("no JSON", "[1]", '{"number": "one"}', "[" * 100_000, None):
            row = ("t", "ada", "a.jpg", "a1", "undo", "" if value is None else value)
            database.execute("INSERT INTO actions (time, who, photo, sha256, action, value) VALUES (?,?,?,?,?,?)", row)
        row = ("t", b"\xff\xfe", "a.jpg", "a1", "note", '{"text": "x"}')
        database.execute("INSERT INTO actions (time, who, photo, sha256, action, value) VALUES (?,?,?,?,?,?)", row)
    assert [a.action for a in in_force(Log(tmp_path / FILE).actions())] == ["note"]


def test_a_file_that_is_no_log_is_one_clear_error(tmp_path: Path) -> None:
    (tmp_path / FILE).write_text("not a database, but long enough to be read as the header of one" * 4)
    with pytest.raises(OutputError, match="log of corrections"):
        Log(tmp_path / FILE)
    with pytest.raises(OutputError, match="log of corrections"):
        Log(tmp_path / "no" / "folder" / FILE)
