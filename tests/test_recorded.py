"""Keypoint files of every kind: the same person from each; what is missing is missing; errors name the place."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from proxemetry.camera.focal import FocalRequest
from proxemetry.errors import KeypointsError, PhotoError, SettingsError
from proxemetry.measure import measure
from proxemetry.people.skeleton import BODY_25, COCO_17, HALPE_26
from proxemetry.photo import Photo
from proxemetry.pose import backend_named
from proxemetry.pose.callables import people_from
from proxemetry.pose.recorded import Recorded

#: One person of 17 joints in a photo of 640 x 480: joint k at (100 + 10 k, 50 + 20 k), the left ankle unseen.
XY = [(100.0 + 10 * k, 50.0 + 20 * k) for k in range(17)]
SCORES = [0.9] * 17
UNSEEN = COCO_17.joints.index("left_ankle")
FLAT = [v for k, (x, y) in enumerate(XY) for v in ((0, 0, 0) if k == UNSEEN else (x, y, 0.9))]
ROWS = [FLAT[3 * k : 3 * k + 3] for k in range(17)]
BOX = [90.0, 40.0, 300.0, 400.0]
PHOTO = Photo("shoot/one.jpg", 640, 480, "")


def _own(**changes):
    image = {
        "filename": "one.jpg", "width": 640, "height": 480, "people": [{"keypoints": ROWS, "score": 0.8, "box": BOX}],
    }  # fmt: skip
    return {"skeleton": "coco17", "images": [{**image, **changes}]}


def _coco_annotations():
    keypoints = [2 if k % 3 == 2 and v else v for k, v in enumerate(FLAT)]
    return {
        "images": [
            {"id": 7, "file_name": "one.jpg", "width": 640, "height": 480},
            {"id": 8, "file_name": "empty.jpg", "width": 640, "height": 480},
        ],
        "annotations": [
            {"image_id": 7, "keypoints": keypoints, "bbox": [90, 40, 210, 360], "num_keypoints": 16, "iscrowd": 0},
            {"image_id": 7, "keypoints": keypoints, "bbox": [0, 0, 9, 9], "num_keypoints": 16, "iscrowd": 1},
        ],
        "categories": [{"id": 1, "name": "person", "keypoints": list(COCO_17.joints)}],
    }


def _easy_vitpose():
    rows = [[y, x, score] for x, y, score in ROWS]
    return {"keypoints": [{"0": rows}], "skeleton": {str(k): name for k, name in enumerate(COCO_17.joints)}}


def _mmpose():
    points = [row[:2] for row in ROWS]
    scores = [row[2] for row in ROWS]
    return [{"keypoints": points, "keypoint_scores": scores, "bbox": [BOX], "bbox_score": 0.8}]


def _mmpose_demo():
    names = {str(k): name for k, name in enumerate(COCO_17.joints)}
    return {"meta_info": {"keypoint_id2name": names}, "instance_info": _mmpose()}


def _transformers():
    return [{"keypoints": [row[:2] for row in ROWS], "scores": [row[2] for row in ROWS], "labels": list(range(17))}]


def _ultralytics():
    points = {"x": [r[0] for r in ROWS], "y": [r[1] for r in ROWS], "visible": [r[2] for r in ROWS]}
    corners = dict(zip(("x1", "y1", "x2", "y2"), BOX, strict=True))
    return [{"name": "person", "class": 0, "confidence": 0.8, "box": corners, "keypoints": points}]


def _preds():
    return {"preds": [ROWS], "boxes": [[0] * 6], "image_paths": ["data/one.jpg"], "bbox_ids": [0]}


FILES = {
    "own": ("keypoints.json", _own()),
    "COCO annotations": ("person_keypoints.json", _coco_annotations()),
    "COCO results": ("results.json", [{"image_id": "one.jpg", "category_id": 1, "keypoints": FLAT, "score": 0.8}]),
    "MMPose": ("one.json", _mmpose()),
    "MMPose demo": ("results_one.json", _mmpose_demo()),
    "ViTPose of Transformers": ("one.json", _transformers()),
    "easy_ViTPose": ("one_result.json", _easy_vitpose()),
    "original ViTPose": ("dump.json", _preds()),
    "Ultralytics": ("one.json", _ultralytics()),
}


def _written(folder: Path, name: str, content: object) -> Path:
    path = folder / name
    path.write_text(content if isinstance(content, str) else json.dumps(content))
    return path


@pytest.mark.parametrize("kind", FILES)
def test_every_kind_of_file_gives_the_same_person(tmp_path, kind):
    path = _written(tmp_path, *FILES[kind])
    people = backend_named(f"recorded:{path}").detect(PHOTO)
    assert people.skeleton is COCO_17
    assert len(people) == 1
    expected = np.array(XY)
    expected[UNSEEN] = np.nan
    np.testing.assert_allclose(people.keypoints_px[0], expected)
    assert people.scores[0, UNSEEN] == 0
    assert people.scores[0, 0] in (0.9, 1.0)


def test_a_missing_joint_is_missing_and_not_the_corner_of_the_photo(tmp_path):
    people = Recorded(_written(tmp_path, "k.json", _own())).detect(PHOTO)
    assert np.isnan(people.joint("left_ankle")).all()
    assert people.boxes_px[0].tolist() == BOX
    assert people.person_scores[0] == 0.8


def test_an_annotators_hidden_joint_counts_half(tmp_path):
    content = _coco_annotations()
    content["annotations"][0]["keypoints"][2] = 1
    people = Recorded(_written(tmp_path, "k.json", content)).detect(PHOTO)
    assert people.scores[0, 0] == 0.5
    assert len(people) == 1  # the crowd is not a person


def test_a_photo_listed_without_people_is_empty_and_one_not_listed_is_an_error(tmp_path):
    recorded = Recorded(_written(tmp_path, "k.json", _coco_annotations()))
    assert recorded.photos == ("one.jpg", "empty.jpg")
    assert len(recorded.detect(Photo("empty.jpg", 640, 480, ""))) == 0
    with pytest.raises(KeypointsError, match=r"other\.jpg: not among the 2 photos of .*k\.json"):
        recorded.detect(Photo("other.jpg", 640, 480, ""))


def test_a_results_file_names_only_photos_with_somebody(tmp_path):
    recorded = Recorded(_written(tmp_path, *FILES["COCO results"]))
    assert len(recorded.detect(Photo("other.jpg", 640, 480, ""))) == 0


def test_a_photo_that_a_results_file_does_not_name_says_so(tmp_path):
    recorded = Recorded(_written(tmp_path, *FILES["COCO results"]))
    scene = measure(Photo("other.jpg", 640, 480, ""), pose=recorded, camera=FocalRequest(focal_px=500))
    assert scene.status == "ok"
    assert scene.reason is not None
    assert scene.reason.startswith("no people recorded: results.json names only photos with people (")
    listed = Recorded(_written(tmp_path, "k.json", _own(people=[])))
    assert measure(PHOTO, pose=listed, camera=FocalRequest(focal_px=500)).reason == "no people found"


@pytest.mark.parametrize("image_id", [192, "192", "000000000192"])
def test_an_image_id_is_the_number_that_a_photo_is_called_by(tmp_path, image_id):
    path = _written(tmp_path, "r.json", [{"image_id": image_id, "keypoints": FLAT, "score": 3.5}])
    for name in ("192.jpg", "a/000000000192.png", "COCO_val2014_000000000192.jpg"):
        people = Recorded(path).detect(Photo(name, 640, 480, ""))
        assert len(people) == 1
        assert people.person_scores[0] == pytest.approx(0.9)  # 3.5 is no probability
    # a camera's counter, a frame of a film and another photo are not called by an id
    for name in ("IMG_0192.jpg", "2021_03_192.jpg", "film-192.jpg", "COCO_val2014_000000000193.jpg"):
        assert len(Recorded(path).detect(Photo(name, 640, 480, ""))) == 0


def test_ids_of_annotations_may_be_numbers_or_text(tmp_path):
    content = _coco_annotations()
    content["images"][0]["id"] = "7"
    assert len(Recorded(_written(tmp_path, "k.json", content)).detect(PHOTO)) == 1


def test_annotations_of_no_image_or_of_two_are_refused(tmp_path):
    content = _coco_annotations()
    content["images"][0]["id"] = 99
    with pytest.raises(KeypointsError, match="no annotation's image_id is among"):
        Recorded(_written(tmp_path, "k.json", content))
    content["images"][0]["id"] = 8
    with pytest.raises(KeypointsError, match=r"images\[1\]: id 8 is another image's already"):
        Recorded(_written(tmp_path, "k.json", content))


def test_an_annotation_without_keypoints_is_nobody(tmp_path):
    content = _coco_annotations()
    content["annotations"].append({"image_id": 7, "keypoints": [], "bbox": [0, 0, 9, 9]})
    assert len(Recorded(_written(tmp_path, "k.json", content)).detect(PHOTO)) == 1


@pytest.mark.parametrize(("count", "skeleton"), [(133, COCO_17), (136, HALPE_26)])
def test_of_a_whole_body_the_body_is_taken(tmp_path, count, skeleton):
    rest = [[300.0, 300.0, 0.5]] * (count - 17)
    path = _written(tmp_path, "k.json", [{"image_id": "one", "keypoints": [*ROWS, *rest], "score": 0.8}])
    people = Recorded(path).detect(PHOTO)
    assert people.skeleton == skeleton
    expected = Recorded(_written(tmp_path, *FILES["COCO results"])).detect(PHOTO)
    np.testing.assert_allclose(people.keypoints_px[:, :17], expected.keypoints_px)
    answer = people_from(np.array([[*ROWS, *rest]]))
    assert answer.skeleton == skeleton
    np.testing.assert_allclose(answer.scores, people.scores)


@pytest.mark.parametrize("kind", ["own", "COCO results", "MMPose", "Ultralytics"])
def test_fractions_are_refused_whoever_wrote_them(tmp_path, kind):
    rows = [[x / 640, y / 480, s] for x, y, s in ROWS]
    points = {"x": [r[0] for r in rows], "y": [r[1] for r in rows], "visible": [r[2] for r in rows]}
    corners = {"x1": 0.1, "y1": 0.1, "x2": 0.5, "y2": 0.8}
    content = {
        "own": _own(people=[{"keypoints": rows}]),
        "COCO results": [{"image_id": "one", "keypoints": rows}],
        "MMPose": [{"keypoints": [r[:2] for r in rows], "keypoint_scores": [r[2] for r in rows]}],
        "Ultralytics": [{"box": corners, "keypoints": points}],
    }[kind]
    with pytest.raises(KeypointsError, match=r"one.*: coordinates are fractions, not pixels"):
        Recorded(_written(tmp_path, "one.json", content))
    stated = Recorded(_written(tmp_path, "k.json", _own(width=1, height=1, people=[{"keypoints": rows}])))
    np.testing.assert_allclose(stated.detect(PHOTO).keypoints_px[0, 0], XY[0])


def test_keypoints_of_a_larger_copy_are_refused_where_no_size_is_stated(tmp_path):
    far = [[x + 900, y, s] if s else [0, 0, 0] for x, y, s in ROWS]
    recorded = Recorded(_written(tmp_path, "r.json", [{"image_id": "one", "keypoints": k} for k in (FLAT, far)]))
    with pytest.raises(KeypointsError, match=r"person 1 in .* is entirely outside its 640 x 480 pixels"):
        recorded.detect(PHOTO)
    cut = [[x - 500, y, s] if s else [0, 0, 0] for x, y, s in far]  # by the edge, as a detector may guess
    assert len(Recorded(_written(tmp_path, "r.json", [{"image_id": "one", "keypoints": cut}])).detect(PHOTO)) == 1


def test_a_box_that_is_none_is_the_keypoints_bounds(tmp_path):
    person = {"keypoints": ROWS, "box": [float("nan")] * 4}
    people = Recorded(_written(tmp_path, "k.json", _own(people=[person]))).detect(PHOTO)
    assert np.isfinite(people.boxes_px).all()


def test_what_a_mac_leaves_beside_the_files_is_passed_over(tmp_path):
    folder = tmp_path / "poses"
    folder.mkdir()
    (folder / "one_keypoints.json").write_text(json.dumps({"people": []}))
    (folder / "._one_keypoints.json").write_bytes(b"\x00\x05\x16\x07\xff")
    assert Recorded(folder).photos == ("one",)


@given(factor=st.floats(0.1, 4))
def test_the_photo_may_have_another_scale_than_the_file(tmp_path_factory, factor):
    path = _written(tmp_path_factory.mktemp("scale"), "k.json", _own())
    size = round(640 * factor), round(480 * factor)
    people = Recorded(path).detect(Photo("one.jpg", *size, ""))
    np.testing.assert_allclose(people.keypoints_px[0, 0], (100 * size[0] / 640, 50 * size[1] / 480))


def test_a_turned_photo_is_an_error(tmp_path):
    with pytest.raises(KeypointsError, match=r"480 x 640.*of 640 x 480"):
        Recorded(_written(tmp_path, "k.json", _own())).detect(Photo("one.jpg", 480, 640, ""))


def test_the_photo_and_its_camera_come_from_the_file_alone(tmp_path):
    content = _own(camera={"fx": 800, "fy": 810, "cx": 300, "cy": 250})
    recorded = Recorded(_written(tmp_path, "k.json", content))
    photo = recorded.photo("one.jpg")
    assert (photo.name, photo.width, photo.height) == ("one.jpg", 640, 480)
    camera = recorded.camera_of(photo)
    assert camera is not None
    assert (camera.fx, camera.fy, camera.cx, camera.cy) == (800, 810, 300, 250)
    doubled = recorded.camera_of(Photo("one.jpg", 1280, 960, ""))
    assert doubled is not None and doubled.fx == 1600
    assert Recorded(_written(tmp_path, "k.json", _own())).camera_of(photo) is None


def test_measuring_takes_the_files_camera_unless_one_is_stated(tmp_path):
    content = _own(camera={"fx": 800})
    recorded = Recorded(_written(tmp_path, "k.json", content))
    photo = recorded.photo("one.jpg")
    assert measure(photo, pose=recorded).camera.camera.fx == 800
    assert measure(photo, pose=recorded, camera=FocalRequest(focal_px=500)).camera.camera.fx == 500


def test_without_a_size_the_photo_itself_is_needed(tmp_path):
    recorded = Recorded(_written(tmp_path, *FILES["MMPose"]))
    with pytest.raises(PhotoError, match="give the photos too"):
        recorded.photo("one.jpg")


@pytest.mark.parametrize("key", ["pose_keypoints_2d", "pose_keypoints"])
def test_openpose_folders_in_both_spellings(tmp_path, key):
    numbers = [v for k in range(25) for v in (10.0 + k, 20.0 + k, 0.5)]
    numbers[:3] = 0, 0, 0
    _written(tmp_path, "IMG_1_keypoints.json", {"version": 1.3, "people": [{key: numbers}]})
    _written(tmp_path, "IMG_2_keypoints.json", {"version": 1.3, "people": []})
    recorded = Recorded(tmp_path)
    assert recorded.skeleton is BODY_25
    people = recorded.detect(Photo("somewhere/IMG_1.JPG", 400, 300, ""))
    assert np.isnan(people.joint("nose")).all()
    assert people.joint("neck")[0].tolist() == [11, 21]
    assert len(recorded.detect(Photo("IMG_2.jpg", 400, 300, ""))) == 0


def test_openposes_eighteen_joints_become_seventeen(tmp_path):
    numbers = [v for k in range(18) for v in (10.0 + k, 20.0 + k, 0.5)]
    _written(tmp_path, "a_keypoints.json", {"people": [{"pose_keypoints": numbers}]})
    people = Recorded(tmp_path).detect(Photo("a.jpg", 400, 300, ""))
    assert people.skeleton is COCO_17
    assert people.joint("right_shoulder")[0].tolist() == [12, 22]
    assert people.joint("left_ear")[0].tolist() == [27, 37]


def test_openpose_fractions_are_refused(tmp_path):
    numbers = [v for k in range(25) for v in (0.01 * (k + 1), 0.5, 0.5)]
    _written(tmp_path, "a_keypoints.json", {"people": [{"pose_keypoints_2d": numbers}]})
    with pytest.raises(KeypointsError, match="--keypoint_scale 0"):
        Recorded(tmp_path)


def test_named_joints_find_their_place_with_neck_and_hip(tmp_path):
    names = [*COCO_17.joints[::-1], "neck", "hip"]
    rows = [[y, x, 0.9] for x, y in XY[::-1]] + [[5.0, 6.0, 0.8], [7.0, 8.0, 0.7]]
    content = {"keypoints": [{"3": rows}], "skeleton": {str(k): name for k, name in enumerate(names)}}
    people = Recorded(_written(tmp_path, "one_result.json", content)).detect(PHOTO)
    assert people.skeleton is HALPE_26
    assert people.joint("neck")[0].tolist() == [6, 5]
    assert people.joint("mid_hip")[0].tolist() == [8, 7]
    np.testing.assert_allclose(people.joint("left_ankle")[0], XY[UNSEEN])
    assert np.isnan(people.joint("left_heel")).all()


@pytest.mark.parametrize("confidence", [True, False])
def test_ultralytics_text_files_are_fractions(tmp_path, confidence):
    points = " ".join(f"{x / 640:.6f} {y / 480:.6f} {s}" for x, y, s in ROWS)
    _written(tmp_path, "one.txt", f"0 0.3 0.4 0.2 0.6 {points}{' 0.8' if confidence else ''}\n\n")
    people = Recorded(tmp_path).detect(PHOTO)
    np.testing.assert_allclose(people.keypoints_px[0, 3], XY[3], atol=1e-3)
    assert np.isnan(people.keypoints_px[0, UNSEEN]).all()
    np.testing.assert_allclose(people.boxes_px[0], [0.2 * 640, 0.1 * 480, 0.4 * 640, 0.7 * 480])
    assert people.person_scores[0] == pytest.approx(0.8 if confidence else 0.9)


def test_the_same_file_name_in_two_folders_is_two_photos(tmp_path):
    content = _own()
    first, second = content["images"][0], dict(content["images"][0], people=[])
    first["filename"], second["filename"] = "a/1.jpg", "b/1.jpg"
    content["images"] = [first, second]
    recorded = Recorded(_written(tmp_path, "k.json", content))
    assert len(recorded.detect(Photo("a/1.jpg", 640, 480, ""))) == 1
    assert len(recorded.detect(Photo("b/1.jpg", 640, 480, ""))) == 0
    with pytest.raises(KeypointsError, match="not among"):
        recorded.detect(Photo("1.jpg", 640, 480, ""))


@pytest.mark.parametrize(
    ("name", "content", "expected"),
    [
        ("k.json", "{not json", "not JSON"),
        ("k.json", "3", "no keypoints in it"),
        ("k.json", {"images": 3}, "'images' must be a list"),
        ("k.json", {"skeleton": "coco17", "images": [{"people": []}]}, r"images\[0\]: 'filename' is missing"),
        ("k.json", _own(filename=None), r"images\[0\]: 'filename' is None"),
        ("k.json", {"images": []}, "'skeleton' is missing"),
        ("k.json", {"skeleton": "octopus", "images": []}, "octopus"),
        ("k.json", _own(people=[{"keypoints": ROWS[:16]}]), r"images\[0\].*16 keypoints.*coco17 has 17"),
        ("k.json", _own(people=[{"keypoints": FLAT[:-1]}]), r"images\[0\].*multiple of three"),
        ("k.json", _own(people=[{"keypoints": [["a", 1, 2]]}]), r"images\[0\]: malformed"),
        ("k.json", _own(width=-5), r"images\[0\].*not the size of a photo"),
        ("k.json", _own(camera={"fy": 3}), r"images\[0\]: 'fx' is missing"),
        ("k.json", _own(camera={"fx": -3}), r"images\[0\].*fx"),
        ("k.json", _own(people=[{"keypoints": ROWS, "box": [1, 2]}]), r"images\[0\].*four numbers"),
        ("k.json", [3], "entry 0: not an object"),
        ("k.json", [{"image_id": 1}], "entry 0: 'keypoints' is missing"),
        ("k.json", [{"image_id": 1, "keypoints": FLAT[:42]}], "image_id 1.*14 keypoints fit no known skeleton"),
        ("k.json", [{"score": 1}], "entry 0: 'keypoints' is missing"),
        ("k.json", {"people": [{"face": []}]}, r"people\[0\].*pose_keypoints_2d"),
        ("k.json", {"keypoints": [{}, {}], "skeleton": {}}, "2 frames are a video"),
        ("k.txt", "0 0.1 0.2 0.3 0.4", "line 1.*no keypoints"),
        ("k.txt", "0 0.1 zero", "line 1: malformed"),
    ],
)
def test_a_malformed_file_is_one_line_that_names_file_and_entry(tmp_path, name, content, expected):
    path = _written(tmp_path, name, content)
    with pytest.raises(KeypointsError, match=expected) as caught:
        Recorded(path)
    message = str(caught.value)
    assert message.startswith(str(path))
    assert "\n" not in message


def test_what_is_not_there_says_so(tmp_path):
    with pytest.raises(KeypointsError, match="no such file"):
        Recorded(tmp_path / "absent.json")
    with pytest.raises(KeypointsError, match="no keypoint files"):
        Recorded(tmp_path)
    with pytest.raises(SettingsError, match="recorded:FILE"):
        backend_named("recorded")


def test_a_photo_twice_in_a_file_is_an_error(tmp_path):
    content = _own()
    content["images"] *= 2
    with pytest.raises(KeypointsError, match="twice"):
        Recorded(_written(tmp_path, "k.json", content))
