"""The library as somebody meets it in a notebook: what is accepted, and what is refused in one line."""

import dataclasses
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import proxemetry as px
from proxemetry.errors import CameraError, OutputError, PhotoError, SettingsError
from proxemetry.locate import METHODS
from proxemetry.measure import place

PLAZA = Path(__file__).resolve().parent.parent / "examples" / "plaza.jpg"
RECORDED = f"recorded:{PLAZA.with_suffix('.json')}"
PIXELS = np.zeros((1068, 1600, 3), dtype=np.uint8)


@pytest.fixture(scope="module")
def scene():
    return px.measure(PLAZA, pose=RECORDED)


def test_a_photo_in_memory_with_people_found_before_is_the_same_scene(scene):
    answer = px.measure(PIXELS, pose=lambda pixels: scene.people, camera=scene.camera)
    assert np.array_equal(answer.distances_m, scene.distances_m, equal_nan=True)


def test_a_pil_image_is_refused_with_what_to_give(scene):
    image = pytest.importorskip("PIL.Image").open(PLAZA)
    with pytest.raises(PhotoError, match=r"not JpegImageFile: .*numpy.asarray"):
        px.measure(image, pose=RECORDED)
    answer = px.measure(np.asarray(image.convert("RGB")), pose=lambda pixels: scene.people, camera=scene.camera)
    assert len(answer) == len(scene)


@pytest.mark.parametrize("photo", [b"\xff\xd8", None, 3])
def test_what_is_no_photo_is_refused(photo):
    with pytest.raises(PhotoError, match=f"not {type(photo).__name__}"):
        px.measure(photo, pose=RECORDED)


def test_a_photo_without_pixels_is_refused():
    with pytest.raises(PhotoError, match="0 x 5"):
        px.Photo.from_array(np.zeros((5, 0, 3), dtype=np.uint8))


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("factor", [2, 0.5])
def test_the_camera_of_a_resized_copy_does_not_pass_for_the_photos_own(scene, method, factor):
    camera = scene.camera.camera
    other = camera.resized(int(1600 * factor), int(1068 * factor))
    with pytest.raises(CameraError, match=rf"camera is of {other.width} x .* give camera.resized\(1600, 1068\)"):
        px.measure(PLAZA, pose=RECORDED, camera=other, method=method)
    answer = px.measure(PLAZA, pose=RECORDED, camera=other.resized(1600, 1068), method=method)
    assert np.allclose(answer.positions_m, px.remeasure(scene, px.Settings(method=method)).positions_m, equal_nan=True)


def test_measuring_anew_takes_a_camera_as_measuring_does(scene):
    shorter = scene.camera.camera.with_focal(900)
    answer = px.remeasure(scene, px.Settings(), camera=shorter)
    assert answer.camera.camera == shorter
    assert answer.to_json() == px.remeasure(scene, px.Settings(), camera=px.CameraEstimate(shorter)).to_json()


@pytest.mark.parametrize(
    ("stated", "said"),
    [
        ({"body_sizes": ("women",)}, "1 entries for 6 people"),
        ({"body_sizes": (None,) * 7}, "7 entries for 6 people"),
        ({"off_floor": frozenset({6})}, "names person 6, but there are 6"),
        ({"off_floor": frozenset({-1})}, "names person -1"),
    ],
)
@pytest.mark.parametrize("method", ["scene", "torso"])
def test_what_is_stated_of_people_who_are_not_there_is_refused(scene, method, stated, said):
    with pytest.raises(SettingsError, match=said):
        px.remeasure(scene, px.Settings(method, px.LocateSettings(**stated)))


def test_a_body_size_a_person_moves_that_person(scene):
    def depths(first):  # without the floor, on which a person keeps the place whatever their size
        stated = px.LocateSettings(floor="none", body_sizes=(first, *[None] * 5))
        return px.remeasure(scene, px.Settings(locate=stated)).positions_m[:, 2]

    farther = depths("men") / depths("women")
    assert farther[0] == pytest.approx(1.756 / 1.629, rel=0.02)  # their statures
    assert np.allclose(farther[1:], 1, rtol=0.01)


def test_quirks_may_be_any_collection(scene):
    for some in (["code-torso-length"], ("code-torso-length",), {"code-torso-length"}):
        answer = px.remeasure(scene, px.Settings("torso", px.LocateSettings(quirks=some)))
        assert np.allclose(answer.positions_m * 444, px.remeasure(scene, px.Settings("torso")).positions_m * 444.5)


@pytest.mark.parametrize("given_", [px.LocateSettings(), {"method": "torso"}, "torso"])
def test_settings_of_another_kind_are_refused(scene, given_):
    with pytest.raises(SettingsError, match="settings must be a Settings"):
        px.measure(PLAZA, pose=RECORDED, settings=given_)
    with pytest.raises(SettingsError, match="settings must be a Settings"):
        px.remeasure(scene, given_)


def test_people_are_no_back_end_and_the_refusal_says_how(scene):
    with pytest.raises(SettingsError, match="lambda pixels: people"):
        px.measure(PIXELS, pose=scene.people)
    with pytest.raises(SettingsError, match="not NoneType"):
        px.measure(PIXELS, pose=None)


@pytest.mark.parametrize("field", ["focal_rel_sd", "principal_sd_px"])
def test_a_negative_standard_deviation_is_refused(scene, field):
    with pytest.raises(CameraError, match="0 or more"):
        dataclasses.replace(scene.camera.camera, **{field: -0.1})


def test_a_scene_cut_short_is_refused_in_one_line(scene):
    import json

    fields = json.loads(scene.to_json())
    for name in fields:
        cut = {key: value for key, value in fields.items() if key != name}
        with pytest.raises(OutputError, match="not a scene"):
            px.Scene.from_json(json.dumps(cut))
    for name in ("camera", "people", "bodies", "made_by"):
        with pytest.raises(OutputError, match="not a scene"):
            px.Scene.from_json(json.dumps({**fields, name: [1]}))


def test_values_say_themselves_in_a_line(scene):
    assert repr(scene.bodies) == "Bodies(6 of 6 people placed by scene)"
    assert repr(scene.distances) == "Distances(15 of 15 pairs, on the ground)"


@given(data=st.data())
@settings(max_examples=25, deadline=None)
def test_no_answer_lies_outside_its_own_interval(scene, data):
    """Doubles of a person, a principal point that nobody knows, a focal length open by half: all are noise."""
    rows = data.draw(st.lists(st.integers(0, 5), min_size=2, max_size=4))
    camera = dataclasses.replace(
        scene.camera.camera,
        focal_rel_sd=data.draw(st.sampled_from((0.0, 0.2, 0.5))),
        principal_sd_px=data.draw(st.sampled_from((0.0, 300.0, 10000.0))),
    )
    for method in ("torso", "shoulder", "scene"):
        answer = place("", "", 1600, 1068, scene.people[rows], px.CameraEstimate(camera), px.Settings(method)).distances
        for a, b in answer.pairs():
            if np.isfinite(answer.distance_m[a, b]):
                assert 0 <= answer.low_m[a, b] <= answer.distance_m[a, b] <= answer.high_m[a, b]
                assert answer.low_m[a, b] < answer.high_m[a, b]
