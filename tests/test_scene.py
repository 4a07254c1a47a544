"""Scenes: the way from keypoints to tables, and there and back through JSON."""

import json
import math
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from proxemetry.bodies import Bodies, Floor, Mode
from proxemetry.camera import Camera, CameraEstimate, Candidate, Doubt, Flag, FocalSource, Source
from proxemetry.camera.focal import FocalRequest
from proxemetry.camera.table import CameraRow, CameraTable
from proxemetry.distances import measure_distances
from proxemetry.errors import OutputError, SettingsError
from proxemetry.locate import LocateSettings
from proxemetry.measure import measure, place, remeasure
from proxemetry.people import People
from proxemetry.people.skeleton import COCO_17
from proxemetry.photo.about import About
from proxemetry.scene import Provenance, Review, Scene
from proxemetry.settings import Settings
from proxemetry.tables import TABLES, pair_columns, rows
from proxemetry.tables.doubt_columns import column_of_doubt
from synthetic.drawn import people_at

CAMERA = Camera.centred(1000, 1000, 800, focal_rel_sd=0.02, source="drawn")
ESTIMATE = CameraEstimate(
    CAMERA, (Candidate(1000.0, 0.02, Source(FocalSource.CROP_FACTOR, "1.5 of X")),), (Flag(Doubt.LENS, "a flag"),)
)  # fmt: skip


def scene_of(places, estimate=ESTIMATE, method="torso"):
    return place("a.jpg", "0" * 64, 1000, 800, people_at(places, CAMERA), estimate, Settings(method=method))


def test_two_people_on_a_3_4_5_triangle_are_5_m_apart():
    scene = scene_of([(-1.5, 0, 5), (1.5, 0, 9)])
    assert scene.distances_m[0, 1] == pytest.approx(5.00)
    assert scene.distances.low_m[0, 1] < 5 < scene.distances.high_m[0, 1]


def test_without_a_camera_people_are_listed_without_distances():
    scene = scene_of([(0, 0, 5), (1, 0, 5)], CameraEstimate(None, reason="no focal length; state one"))
    assert scene.status == "no_camera"
    assert scene.reason == "no focal length; state one"
    assert len(scene) == 2
    assert np.isnan(scene.distances_m).all()
    # What to do is told once a photo; people and pairs say why there is nothing, pairs once for both.
    reasons = {row["reason"] for table in ("people", "pairs") for row in rows(table, scene)}
    assert reasons == {"the photo's focal length is unknown"}
    assert {row["on_ground"] for row in rows("pairs", scene)} == {None}
    assert {row["basis"] for row in rows("people", scene)} == {None}


@pytest.mark.parametrize("places", [[], [(0, 0, 5)], [(-1, 0, 4), (1, 0, 6), (0, 0.1, 9)]])
def test_json_there_and_back(places):
    scene = scene_of(places)
    text = scene.to_json()
    assert "NaN" not in text
    again = Scene.from_json(text)
    assert again.to_json() == text
    assert again.distances_m == pytest.approx(scene.distances_m, rel=1e-5, nan_ok=True)


def test_json_keeps_floor_modes_and_gravity():
    positions, covariance = np.array([[0, 0, 5.0], [1, 0, 6.0]]), np.eye(6) * 0.01
    modes = (Mode(0.6, positions, covariance), Mode(0.4, positions + 1, covariance * 2))
    floor = Floor(1.6, 0.1, 0.0)
    bodies = Bodies(
        positions,
        covariance,
        "drawn",
        ("feet", "torso"),
        (None, None),
        np.array([0, -1.0, 0]),
        floor=floor,
        modes=modes,
    )
    scene = Scene("a", "", 10, 10, "ok", None, ESTIMATE, people_at([(0, 0, 5), (1, 0, 6)], CAMERA), bodies)
    again = Scene.from_json(scene.to_json()).bodies
    assert again.modes[1].weight == 0.4
    assert again.modes[1].covariance_m2 == pytest.approx(modes[1].covariance_m2)
    assert again.floor is not None and again.floor.pitch_rad == 0.1 and math.isnan(again.floor.pitch_sd_rad)
    assert again.up is not None and again.up.tolist() == [0, -1, 0]


def test_an_old_scene_is_refused_in_one_line() -> None:
    with pytest.raises(OutputError, match=r"scene/1.*measure the photo again") as refused:
        Scene.from_json('{"schema": "proxemetry.scene/1", "photo": "a.jpg"}')
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize("text", ["", "[]", "{}", '{"schema": "proxemetry.scene/99"}'])
def test_other_text_is_refused(text):
    with pytest.raises(OutputError):
        Scene.from_json(text)


def test_rows_have_every_column_and_missing_is_none():
    scene = scene_of([(0, 0, 5), (1, 0, 5)])
    for table, columns in TABLES.items():
        for row in rows(table, scene):
            assert list(row) == [c.name for c in columns]
            json.dumps(row, allow_nan=False)
    assert rows("pairs", scene)[0]["on_ground"] is False


def test_columns_promised_to_scripts_come_first_in_their_order():
    promised = {
        "photos": "photo, sha256, status, reason, width_px, height_px, focal_px, focal_source, n_people, n_pairs,"
        " seconds",
        "people": "photo, person, x_m, y_m, z_m, x_sd_m, y_sd_m, z_sd_m, method, basis, score, box_x0, box_y0, box_x1,"
        " box_y1, eyes_u_px, eyes_v_px, head_u_px, head_v_px, shoulder_u_px, shoulder_v_px, torso_u_px, torso_v_px,"
        " reason",
        "pairs": "photo, person_a, person_b, distance_m, low_m, high_m, distance_3d_m, zone, reason",
    }
    for table, names in promised.items():
        expected = [n.strip() for n in names.split(",")]
        assert [c.name for c in TABLES[table]][: len(expected)] == expected


def test_remeasuring_with_another_focal_length_scales_depth():
    scene = scene_of([(0, 0, 5), (1, 0, 5)])
    doubled = CameraEstimate(CAMERA.with_focal(2000))
    assert remeasure(scene, Settings(method="torso"), camera=doubled).positions_m[:, 2] == pytest.approx([10, 10])


def test_a_failed_photo_is_a_scene_too():
    scene = Scene.failed("b.jpg", "not a photo")
    assert Scene.from_json(scene.to_json()).reason == "not a photo"
    (row,) = rows("photos", scene)
    assert row["status"] == "failed"
    # Nothing is known of it: a zero would count as an empty photo in someone's mean.
    assert {row[c] for c in ("sha256", "width_px", "height_px", "n_people", "n_pairs", "focal_px")} == {None}
    assert rows("people", scene) == [] == rows("pairs", scene)


def test_a_scene_says_itself_in_a_line():
    scene = scene_of([(0, 0, 5), (3, 0, 9)])
    assert "\n" not in repr(scene) and len(repr(scene)) < 120
    assert "ok: 2 people, 1 distances" in repr(scene)
    assert repr(scene.people).startswith("People(2 with ")


def test_a_bare_number_is_no_camera():
    with pytest.raises(SettingsError, match="FocalRequest, not 800"):
        measure(np.zeros((20, 30, 3), np.uint8), camera=800)


def test_the_settings_of_a_scene_are_json():
    json.dumps(Settings().to_dict(), allow_nan=False)


def test_json_keeps_settings_metadata_and_review():
    told = Settings("torso", LocateSettings("women", quirks={"zero-length"}, off_floor={0}), undistort=False)
    scene = replace(
        scene_of([(0, 0, 5), (3, 0, 9)]),
        settings=told,
        about=About("1990-05-01", city="Oulu", people=("Bo", "Cy"), latitude_deg=65.01),
        review=Review(2, ("exclude", "note"), ("ada",), "<b>"),
        made_by=Provenance("1", "drawn", {"a.onnx": "00"}, "cameras.csv sha256:00"),
    )
    again = Scene.from_json(scene.to_json())
    for name in ("settings", "about", "review", "made_by"):
        assert getattr(again, name) == getattr(scene, name)


def test_a_camera_table_is_named_but_does_not_travel():
    table = CameraTable((CameraRow(1, photo="*", focal_px=900.0),), "/somewhere/cameras.csv")
    told = Settings(focal=FocalRequest(camera_table=table))
    scene = measure(np.zeros((20, 30, 3), np.uint8), pose=lambda _: People.none(COCO_17), settings=told)
    assert scene.settings == Settings()
    assert scene.made_by.camera_table.startswith("cameras.csv sha256:")
    assert told.to_dict()["focal"]["camera_table"] == scene.made_by.camera_table


@pytest.mark.parametrize("method", ["scene", "torso"])
def test_a_quirk_misspelled_is_refused_whatever_the_method(method):
    with pytest.raises(SettingsError, match="quirk 'nonsense' is unknown"):
        measure(np.zeros((20, 30, 3), np.uint8), settings=Settings(method, LocateSettings(quirks={"nonsense"})))


def test_a_status_that_is_none_is_refused():
    with pytest.raises(OutputError, match="status 'fine'"):
        replace(scene_of([(0, 0, 5)]), status="fine")


def test_distorted_keypoints_are_straightened_before_they_are_measured():
    bent = Camera(1000, 1000, 500, 400, 1000, 800, (-0.2, 0.05, 0.0, 0.0, 0.0))
    places = [(-1.5, 0, 5), (1.5, 0, 9)]
    scene = place("a", "", 1000, 800, people_at(places, bent), CameraEstimate(bent), Settings(method="torso"))
    assert scene.distances_m[0, 1] == pytest.approx(5.00)
    off = Settings(method="torso", undistort=False)
    assert place("a", "", 1000, 800, people_at(places, bent), CameraEstimate(bent), off).distances_m[0, 1] != 5.00


def test_people_keep_their_rows_through_the_whole_way():
    people = people_at([(0, 0, 5), (1, 0, 5), (2, 0, 5)], CAMERA)
    scores = people.scores.copy()
    scores[1] = 0
    scene = place("a", "", 1000, 800, People(COCO_17, people.keypoints_px, scores), ESTIMATE, Settings(method="torso"))
    assert [row["person"] for row in rows("people", scene)] == [0, 1, 2]
    assert rows("people", scene)[1]["x_m"] is None
    assert rows("pairs", scene)[0]["distance_m"] is None
    assert rows("pairs", scene)[1]["distance_m"] == pytest.approx(2)


@pytest.mark.parametrize("source", ["", "blazepose"])
def test_json_keeps_who_saw_the_people(source):
    scene = scene_of([(0, 0, 5)])
    seen = replace(scene, people=replace(scene.people, source=source))
    assert Scene.from_json(seen.to_json()).people.source == source
    assert ('"source":"blazepose"' in seen.to_json()) == bool(source)


def test_bodies_hold_numbers_of_their_own_that_nobody_edits():
    places, covariance = np.zeros((2, 3)), np.eye(6)
    bodies = Bodies(places, covariance, "drawn", ("drawn",) * 2, (None,) * 2, up=np.array([0.0, -2.0, 0.0]))
    places[0] = covariance[0] = 9.0
    assert not bodies.positions_m.any() and bodies.covariance_m2 == pytest.approx(np.eye(6))
    assert bodies.up == pytest.approx([0, -1, 0]) and np.isnan(bodies.heading_rad).all()
    for array in (bodies.positions_m, bodies.covariance_m2, bodies.stature_m):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 1.0
    for wrong in (np.zeros((3, 3)), np.zeros((2, 2))):
        with pytest.raises(ValueError, match="reshape"):
            replace(bodies, positions_m=wrong)


def test_a_pairs_doubts_and_phase_are_its_own(monkeypatch):
    monkeypatch.setattr(pair_columns, "doubt_text", lambda _scene, person: f"of {person}")
    columns = {column.name: column.value for column in pair_columns.PAIRS}
    assert [columns[column_of_doubt(end)](None, 3, 5) for end in pair_columns.ENDS] == ["of 3", "of 5"]
    places = np.array([(0.0, 0, 5), (0.5, 0, 5), (1.5, 0, 5)])
    bodies = Bodies(places, np.eye(9) * 1e-6, "drawn", ("drawn",) * 3, (None,) * 3, up=np.array([0.0, -1, 0]))
    scene = SimpleNamespace(distances=measure_distances(bodies))
    # 0.5 m is close personal, 1 m far personal and 1.5 m close social distance (Hall 1966)
    assert [columns["phase"](scene, a, b) for a, b in ((0, 1), (1, 2), (0, 2))] == ["close", "far", "close"]
    assert columns["phase"](scene, 1, 0) == "close"
