"""The library as someone meets it in a notebook: what is accepted, and what is refused in one line."""

import dataclasses
import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import proxemetry as px
from proxemetry.archive.run.caller_script import defines_backend, script_left_out
from proxemetry.errors import CameraError, KeypointsError, OutputError, PhotoError, SettingsError
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
        ({"statures": ((1.8, 0.02), None)}, "statures has 2 entries for 6 people"),
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


def test_body_sizes_may_be_any_sequence_and_a_share_is_a_number():
    sizes = np.array(["women", "men"], dtype=object)
    assert px.LocateSettings(body_sizes=sizes) == px.LocateSettings(body_sizes=("women", "men"))
    with pytest.raises(SettingsError, match="child weight is 'a': it must be a share"):
        px.LocateSettings(child_weight="a")


def test_a_known_stature_moves_that_person_and_is_kept(scene):
    def at(first):  # without the floor, on which a person keeps the place whatever their size
        stated = px.Settings(locate=px.LocateSettings(floor="none", statures=(first, *[None] * 5)))
        assert px.Settings.from_dict(stated.to_dict()) == stated
        return px.remeasure(scene, stated)

    tall, small = at((1.9, 0.005)), at((1.6, 0.005))
    assert tall.bodies.stature_m[0] == pytest.approx(1.9, abs=0.01)
    farther = tall.positions_m[:, 2] / small.positions_m[:, 2]
    assert farther[0] == pytest.approx(1.9 / 1.6, rel=0.03)
    assert np.allclose(farther[1:], 1, rtol=0.01)
    known, unknown = (s.bodies.position_sd_m[0, 2] for s in (tall, at(None)))
    assert known < 0.8 * unknown
    for wrong in ((190, 1), (1.8, 0), (1.8, -1)):
        with pytest.raises(SettingsError, match="stature"):
            px.LocateSettings(statures=(wrong,))


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
    fields = json.loads(scene.to_json())
    for name in fields:
        cut = {key: value for key, value in fields.items() if key != name}
        with pytest.raises(OutputError, match=r"not a scene|written by another version of proxemetry, or is damaged"):
            px.Scene.from_json(json.dumps(cut))
    for name in ("camera", "people", "bodies", "made_by"):
        with pytest.raises(OutputError, match=r"the scene of '.*plaza\.jpg' was written by another version"):
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


NUMPYS = (np.float32(1500.0), np.float64(1500.0), np.int64(1500), np.array(1500.0))


@pytest.mark.parametrize("f_px", NUMPYS, ids=lambda v: type(v).__name__)
def test_numbers_out_of_arrays_are_numbers(scene, f_px):
    """A calibration matrix is of float32 often, and sizes out of a table are int64: neither is JSON by itself."""
    width, height = np.array([1600, 1068])
    stated = px.Camera(f_px, f_px, np.float32(800), np.float32(534), width, height, np.zeros(5, dtype=np.float32))
    plain = px.Camera(1500, 1500, 800, 534, 1600, 1068)
    assert stated == plain
    settings_ = px.Settings(
        locate=px.LocateSettings(off_floor=frozenset(np.flatnonzero([0, 1])), child_weight=np.float32(0.25)),
        focal=px.FocalRequest(focal_px=f_px),
    )
    for camera in (stated, None):
        answer = px.measure(PLAZA, pose=RECORDED, camera=camera, settings=settings_)
        assert answer.camera.camera.f_px == 1500
        again = px.Scene.from_json(answer.to_json())
        assert again.settings.locate.off_floor == {1}


@pytest.mark.parametrize("wrong", ["1500", None, [1500, 1500], 1500j])
def test_what_is_no_number_is_no_focal_length(wrong):
    with pytest.raises(CameraError, match=r"fx is .* it must be a number"):
        px.Camera(wrong, 1500, 800, 534, 1600, 1068)
    if wrong is not None:
        with pytest.raises(SettingsError, match=r"--focal-px is .* a positive number"):
            px.FocalRequest(focal_px=wrong)
        with pytest.raises(SettingsError, match=r"--sensor-mm is .* two positive numbers"):
            px.FocalRequest(focal_mm=35, sensor_mm=[wrong, wrong])


def test_a_mask_is_not_taken_for_rows(scene):
    with pytest.raises(SettingsError, match="flatnonzero"):
        px.remeasure(scene, px.Settings(locate=px.LocateSettings(off_floor=np.array([True, False] * 3))))


COCO = px.SKELETONS["coco17"]


@pytest.mark.parametrize(
    ("keypoints", "scores", "said"),
    [
        (np.zeros((6, 17, 3)), np.ones((6, 17)), r"keypoints of shape \(P, 17, 2\), not \(6, 17, 3\)"),
        (np.zeros((17, 25, 2)), np.ones((17, 25)), r"not \(17, 25, 2\)"),  # as many numbers as 25 people of 17 joints
        (np.zeros((17, 2)), np.ones(17), r"not \(17, 2\)"),
        (np.zeros((6, 17, 2)), np.ones((17, 6)), r"scores of shape \(6, 17\), not \(17, 6\)"),
        (np.zeros((6, 17, 2)), None, r"scores of shape \(6, 17\), not \(\)"),
        ([["a"]], np.ones((1, 17)), "keypoints_px must be numbers"),
    ],
)
def test_arrays_of_another_shape_do_not_become_other_people(keypoints, scores, said):
    with pytest.raises(KeypointsError, match=said):
        px.People(COCO, keypoints, scores)


def test_a_skeletons_name_is_no_skeleton():
    with pytest.raises(KeypointsError, match=r"SKELETONS\['coco17'\]"):
        px.People("coco17", np.zeros((1, 17, 2)), np.ones((1, 17)))


def test_people_are_taken_one_by_one(scene):
    people = scene.people
    assert [len(person) for person in people] == [1] * 6
    assert np.array_equal(people[-1].keypoints_px, people.keypoints_px[5:], equal_nan=True)
    assert np.array_equal(people[np.int64(2)].boxes_px, people.boxes_px[2:3])
    with pytest.raises(IndexError):
        people[6]


def test_a_skeleton_of_ones_own_is_measured_written_and_read(scene):
    people = scene.people
    mine = px.Skeleton("mine", people.skeleton.joints[::-1])
    turned = px.People(mine, people.keypoints_px[:, ::-1], people.scores[:, ::-1], people.boxes_px)
    answer = px.remeasure(scene, px.Settings("torso"), people=turned)
    assert np.allclose(answer.distances_m, px.remeasure(scene, px.Settings("torso")).distances_m, equal_nan=True)
    assert px.Scene.from_json(answer.to_json()).people.skeleton == mine
    assert "joints" not in json.loads(scene.to_json())["people"]


@pytest.mark.parametrize(
    ("answer", "said"),
    [
        (lambda p: np.dstack([p.keypoints_px / (1600, 1068), p.scores]), "fractions, not pixels"),
        (lambda p: (p.keypoints_px, p.scores[:3]), r"scores must have shape \(6, 17\), not \(3, 17\)"),
        (lambda p: (p.keypoints_px, p.scores[..., None]), r"not \(6, 17, 1\)"),
    ],
)
def test_a_functions_answer_that_cannot_be_right_is_refused(scene, answer, said):
    with pytest.raises(KeypointsError, match=said):
        px.measure(PIXELS, pose=lambda pixels: answer(scene.people), camera=scene.camera)


def test_every_name_is_there_and_importing_alone_loads_nothing():
    for name in px.__all__:
        assert getattr(px, name) is not None
    assert {*px._HOME, "__version__"} == set(px.__all__) <= set(dir(px))
    with pytest.raises(AttributeError, match="no attribute 'measured'"):
        _ = px.measured
    program = "import sys, proxemetry, proxemetry.measure as function; print(function.__name__, proxemetry.measure)"
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert done.stdout.startswith("measure <function measure at")
    program = "import sys, proxemetry; print('numpy' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "False"


@pytest.mark.parametrize("part", ["bodies", "distances", "proxemics", "people"])
def test_no_array_of_a_scene_is_edited_in_place(scene, part):
    value = getattr(scene, part)
    arrays = {name: array for name, array in vars(value).items() if isinstance(array, np.ndarray) and array.size}
    assert arrays
    for name, array in arrays.items():
        with pytest.raises(ValueError, match="read-only"):
            array[...] = array
        assert not array.flags.writeable, name


def test_what_a_value_was_made_of_stays_open_to_its_owner(scene):
    mine = scene.distances.distance_m.copy()
    made = dataclasses.replace(scene.distances, distance_m=mine)
    assert mine.flags.writeable
    assert not made.distance_m.flags.writeable


@pytest.mark.parametrize(
    ("stated", "said"),
    [
        ({"undistort": "no"}, "True or False"),
        ({"lines": 1}, "True or False"),
        ({"focal": {"focal_px": 900}}, "focal must be a FocalRequest"),
        ({"focal": None}, "focal must be a FocalRequest"),
        ({"locate": "women"}, "locate must be a LocateSettings"),
        ({"mount": "camera.json"}, "Mount.read"),
    ],
)
def test_settings_of_another_kind_do_not_pass_for_the_default(stated, said):
    with pytest.raises(px.ProxemetryError, match=said):
        px.Settings(**stated)


def test_an_array_s_truth_is_a_setting():
    assert px.Settings(undistort=np.bool_(False)).undistort is False


@pytest.mark.parametrize("given_", [{"settings": {}}, {"mount": "camera.json"}, {"mount": Path("camera.json")}])
def test_an_empty_or_foreign_argument_is_not_the_default(scene, given_):
    with pytest.raises(px.ProxemetryError, match="must be a"):
        px.measure(np.zeros((30, 40, 3), dtype=np.uint8), pose=lambda pixels: scene.people, focal_px=40, **given_)


@pytest.mark.parametrize("points", [[3.0], 3.0, [1.0, 2.0, 3.0, 4.0], [[1.0], [2.0]]])
def test_points_of_another_shape_are_not_spread_over_the_axes(points):
    camera = px.Camera.centred(1000, 640, 480)
    bent = dataclasses.replace(camera, distortion=(0.1, 0.0, 0.0, 0.0, 0.0))
    for call in (camera.project, camera.rays, camera.undistorted, bent.undistorted):
        with pytest.raises(px.ProxemetryError, match="must have shape"):
            call(points)


def test_a_function_is_no_pose_for_many_processes(tmp_path):
    with pytest.raises(px.ProxemetryError, match="python:MODULE:FUNCTION"):
        px.measure_folder(tmp_path, tmp_path / "results", pose=lambda pixels: None)  # type: ignore[arg-type]


_SCRIPT = """
import sys
import proxemetry as px
print("the script runs")
tables = px.measure_folder(sys.argv[1], "results", pose="recorded:" + sys.argv[1].replace(".jpg", ".json"), jobs=2)
print(len(tables.pairs), "pairs")
"""


def test_a_script_that_measures_a_folder_runs_once(tmp_path):
    """Workers are spawned: a script without `if __name__ == "__main__":` would start itself again in each."""
    pytest.importorskip("pandas")
    (tmp_path / "script.py").write_text(_SCRIPT)
    done = subprocess.run(
        [sys.executable, "script.py", str(PLAZA)], cwd=tmp_path, capture_output=True, text=True, timeout=120,
        check=False, env={**os.environ, "PYTHONPATH": str(Path(px.__file__).parents[1])},
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert done.stdout == "the script runs\n15 pairs\n"
    assert not done.stderr


def test_a_back_end_defined_in_the_script_needs_the_script():
    assert defines_backend("python:__main__:find")
    assert defines_backend("cross-check:blazepose+python:__main__:find")
    assert not defines_backend("recorded:keypoints.json")
    script = sys.modules["__main__"]
    with script_left_out(needed=True):
        assert sys.modules["__main__"] is script
    with script_left_out():
        assert not hasattr(sys.modules["__main__"], "__file__")
    assert sys.modules["__main__"] is script
