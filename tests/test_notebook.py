"""The library as a notebook uses it: frames, figures, HTML, a folder measured and read back."""

import math
from pathlib import Path

import pytest

import proxemetry as px
from proxemetry.tables import TABLES
from synthetic.reviewing import make_results, scene_of
from synthetic.small_photos import write_photos

pandas = pytest.importorskip("pandas")


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    root = tmp_path_factory.mktemp("made")
    return root, make_results(root)


def crowd(made):
    return scene_of(made[0] / "photos" / "market" / "crowd.jpg", "market/crowd.jpg")


def test_frames_hold_the_columns_of_the_tables(made):
    scene = crowd(made)
    pairs, people = scene.pairs_frame(), scene.people_frame()
    assert list(pairs.columns) == [c.name for c in TABLES["pairs"]] and len(pairs) == 15
    assert list(people.columns) == [c.name for c in TABLES["people"]] and len(people) == 6
    assert pairs["distance_m"].iloc[0] == pytest.approx(scene.distances_m[0, 1], rel=1e-6)
    assert pairs["person_a"].dtype == "Int64" and pairs["on_ground"].dtype == "boolean"


def test_a_photo_without_people_has_empty_frames(made):
    scene = scene_of(made[0] / "photos" / "market" / "empty.jpg", "market/empty.jpg")
    assert len(scene.pairs_frame()) == 0 and list(scene.people_frame().columns) == [c.name for c in TABLES["people"]]


def test_html_shows_the_nearest_pairs_first_and_names_as_text(made):
    shown = crowd(made).renamed("<script>.jpg")._repr_html_()
    assert "<script>" not in shown and "&lt;script&gt;" in shown
    metres = [float(cell.split(" m [")[0]) for cell in shown.split("<td>") if " m [" in cell]
    assert metres == sorted(metres) and len(metres) == 12 and "and 3 more pairs" in shown
    unknown = scene_of(made[0] / "photos" / "park" / "unknown.jpg", "park/unknown.jpg")
    assert "unknown" in unknown._repr_html_() and "<table>" not in unknown._repr_html_()


def test_a_scene_is_drawn_with_its_own_photo_only(made):
    pytest.importorskip("matplotlib")
    scene, photos = crowd(made), made[0] / "photos" / "market"
    assert scene.plot(photos / "crowd.jpg").get_axes()
    assert scene.plot().get_axes()  # no file of that name: the people alone
    with pytest.raises(px.ProxemetryError, match="not the photo that was measured"):
        scene.plot(photos / "two.jpg")


def test_results_are_read_with_corrections(made):
    found = px.read_results(made[1].folder.location)
    assert len(found.photos) == 6 and set(found.pairs["photo"]) == {
        "market/crowd.jpg",
        "market/two.jpg",
        "park/assumed.jpg",
        "park/unknown.jpg",
    }
    assert sum(len(scene) for scene in found.scenes()) == len(found.people)
    with pytest.raises(px.ProxemetryError):
        px.read_results(made[0] / "nothing")


def test_a_folder_is_measured_and_gone_on_with(tmp_path):
    photos = write_photos(tmp_path / "photos", 3)
    measured = px.measure_folder(photos, tmp_path / "out", pose="python:synthetic.small_photos:two_people", jobs=0)
    assert len(measured.photos) == 3 and measured.people["nearest_m"].notna().sum() == 6
    again = px.measure_folder(str(photos), tmp_path / "out", pose="python:synthetic.small_photos:two_people", jobs=0)
    pandas.testing.assert_frame_equal(again.pairs, measured.pairs)


def test_a_focal_length_is_a_keyword(tmp_path):
    photo = Path("examples/plaza.jpg")
    pose = "recorded:examples/plaza.json"
    short, long = (px.measure(photo, pose=pose, focal_35mm=f) for f in (24, 48))
    assert long.camera.camera.f_px == pytest.approx(2 * short.camera.camera.f_px)
    stated = px.measure(photo, pose=pose, focal_px=1000.0)
    assert stated.camera.camera.f_px == 1000 and not math.isnan(stated.distances_m[0, 1])
    with pytest.raises(px.ProxemetryError, match="not both"):
        px.measure(photo, pose=pose, focal_px=1000.0, camera=px.FocalRequest(focal_35mm=35))
