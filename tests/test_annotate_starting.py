"""Annotating from labels of other tools: what is read, what stays, and what is written back."""

import json
import math
from pathlib import Path

import numpy as np
import pytest

from proxemetry.annotate.keypoint_file import COCO_FILE
from proxemetry.annotate.project import Project
from proxemetry.benchmark import read_labels
from proxemetry.cli import main
from proxemetry.errors import KeypointsError, ProxemetryError, SettingsError
from proxemetry.people import People
from proxemetry.people.skeleton import BODY_25, COCO_17, PARTS
from proxemetry.pose.formats import EXTRA_JOINTS, Beside
from proxemetry.pose.recorded import Recorded
from synthetic.drawn import people_at
from synthetic.reviewing import CAMERA, HEIGHT, WIDTH, draw_photo

TWO = [(-0.75, 0.0, 5.0), (0.75, 0.0, 5.0)]
PEOPLE = people_at(TWO, CAMERA)


@pytest.fixture
def photos(tmp_path: Path) -> Path:
    for k, name in enumerate(("a.jpg", "b.jpg")):
        draw_photo(tmp_path / "photos" / name, people_at([*TWO, (0.2 * k, 0.0, 8.0)], CAMERA))
    return tmp_path / "photos"


def opened(photos: Path, out: str = "labels") -> Project:
    return Project([str(photos)], str(photos.parent / out), pose="none")


def _joints(people: People, k: int) -> dict[str, list[float]]:
    return {
        joint: [float(v) for v in point]
        for joint, point in zip(people.skeleton.joints, people.keypoints_px[k], strict=True)
        if np.isfinite(point).all()
    }


def _coco(name: str = "a.jpg", **more: object) -> dict:
    """Return COCO keypoints as CVAT exports them, of the photo's two people, the second with a hidden wrist."""
    annotations = []
    for k in range(2):
        points = _joints(PEOPLE, k)
        hidden = {"right_wrist"} if k else set()
        flat = [v for j in COCO_17.joints for v in (*points[j], 1 if j in hidden else 2)]
        annotations.append({
            "id": 7 + k, "image_id": 3, "category_id": 2, "iscrowd": 0, "keypoints": flat, "num_keypoints": 17,
            "bbox": [10.0, 20.0, 300.0, 400.0], "area": 120000.0,
            "attributes": {"occluded": bool(k), "mask": "no", **({"name": f"P{k}"} if k else {})}, **more,
        })  # fmt: skip
    return {
        "licenses": [], "info": {}, "categories": [
            {"id": 1, "name": "car"}, {"id": 2, "name": "person", "keypoints": list(COCO_17.joints), "skeleton": []},
        ],
        "images": [{"id": 3, "width": WIDTH, "height": HEIGHT, "file_name": name}], "annotations": annotations,
    }  # fmt: skip


def _write(path: Path, content: object) -> str:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(json.dumps(content))
    return str(path)


def _label_studio() -> list[dict]:
    """Return two people as Label Studio's own JSON has them: percent, a rectangle around each."""
    size = {"original_width": WIDTH, "original_height": HEIGHT, "image_rotation": 0}
    regions: list[dict] = []
    for k in range(2):
        box = {"x": 10, "y": 5, "width": 30, "height": 80, "rotation": 0, "rectanglelabels": ["person"]}
        regions.append({"id": f"box{k}", "type": "rectanglelabels", "value": box, **size})
        for joint, (x, y) in _joints(PEOPLE, k).items():
            value = {"x": 100 * x / WIDTH, "y": 100 * y / HEIGHT, "width": 0.5, "keypointlabels": [joint]}
            regions.append(
                {"id": f"{k}{joint}", "parentID": f"box{k}", "type": "keypointlabels", "value": value, **size}
            )
    old = {"was_cancelled": True, "result": []}
    return [{"id": 1, "data": {"img": "/data/upload/1/0badcafe-a.jpg"}, "annotations": [{"result": regions}, old]}]


def _openpose(photos: Path) -> str:
    rows = []
    for k in range(2):
        points = _joints(PEOPLE, k)
        triples = [[*points.get(j, (0, 0)), 0.9 if j in points else 0] for j in BODY_25.joints]
        rows.append({"person_id": [-1], "pose_keypoints_2d": [v for t in triples for v in t]})
    return str(Path(_write(photos.parent / "openpose/a_keypoints.json", {"version": 1.3, "people": rows})).parent)


def _own(photos: Path) -> str:
    rows = [[[*_joints(PEOPLE, k).get(j, (0, 0)), 0.9] for j in COCO_17.joints] for k in range(2)]
    people = [{"keypoints": row, "attributes": {"person": f"P{k + 4}"}} for k, row in enumerate(rows)]
    image = {"filename": "a.jpg", "width": WIDTH, "height": HEIGHT, "people": people}
    return _write(photos.parent / "own.json", {"skeleton": "coco17", "images": [image]})


KINDS = {
    "cvat": lambda photos: _write(photos.parent / "cvat.json", _coco("images/a.jpg")),
    "label studio's coco": lambda photos: _write(photos.parent / "ls.json", _coco("images/3/0badcafe-a.jpg")),
    "label studio": lambda photos: _write(photos.parent / "tasks.json", _label_studio()),
    "openpose": _openpose,
    "own": _own,
}


@pytest.mark.parametrize("kind", KINDS)
def test_every_tools_people_have_the_benchmarks_parts(kind: str, photos: Path) -> None:
    project = opened(photos)
    assert project.start_from(KINDS[kind](photos)) == (1, 2)
    for k, person in enumerate(project.notes(0).people):
        for part in PARTS:
            x, y = PEOPLE.part(part)[k]
            if kind == "openpose" and part == "Torso":
                continue  # OpenPose has a neck and a mid-hip of its own
            assert np.hypot(person.points[part][0] - x, person.points[part][1] - y) < 2, (kind, part)
    assert not project.notes(1).people
    assert project.notes(1).proposed is None  # still to be proposed by a back end


def test_names_come_from_attributes_where_they_are_tags(photos: Path) -> None:
    project = opened(photos)
    project.start_from(KINDS["cvat"](photos))
    assert [p.tag for p in project.notes(0).people] == [None, "P1"]
    other = opened(photos, "other")
    other.start_from(_own(photos))
    assert [p.tag for p in other.notes(0).people] == ["P4", "P5"]


def test_what_was_read_is_written_back_with_the_points_as_they_are_now(photos: Path) -> None:
    project = opened(photos)
    project.start_from(KINDS["cvat"](photos))
    first, second = project.notes(0).people
    project.act(0, "set_point", {"person": first.key, "part": "Eyes", "to": [11, 12]})
    project.act(0, "set_point", {"person": first.key, "part": "Head", "to": None})
    project.act(0, "name_person", {"person": first.key, "tag": "P8"})
    project.act(1, "add_person", {"points": {"Torso": [300, 200]}})
    path = project.out / COCO_FILE
    content = json.loads(path.read_text())
    sent, back = _coco()["annotations"], content["annotations"]
    assert [image["file_name"] for image in content["images"]] == ["a.jpg", "b.jpg"]
    assert [c["name"] for c in content["categories"]] == ["car", "person"]
    assert content["categories"][1]["keypoints"][:17] == list(COCO_17.joints)
    for was, now in zip(sent, back[:2], strict=True):
        assert now["keypoints"][:51] == pytest.approx(was["keypoints"], abs=0.01)
        assert now["bbox"] == was["bbox"]
        assert now["attributes"]["mask"] == "no"
    assert back[1]["attributes"]["occluded"] == "true"
    assert back[0]["attributes"]["person"] == "P8"
    assert back[0]["attributes"]["eyes_px"] == [11, 12]
    assert "head_px" not in back[0]["attributes"]
    assert back[2]["attributes"] == {"torso_px": [300, 200]}
    # and what is written is read again, by this command and by every other
    again = opened(photos, "again")
    assert again.start_from(str(path)) == (2, 3)
    for k in range(2):
        assert [(p.tag, p.points) for p in again.notes(k).people] == [
            (p.tag, p.points) for p in project.notes(k).people
        ]
    assert json.loads((again.out / COCO_FILE).read_text()) == content
    read = Recorded(path).detect(project.photos[0].photo)
    assert read.keypoints_px[0] == pytest.approx(PEOPLE.keypoints_px[0, :17], abs=0.01)
    assert second.read is not None and second.read["score"] == pytest.approx(0.97, abs=0.04)


def test_what_is_not_understood_is_written_back(photos: Path) -> None:
    content = _coco(segmentation=[[1.5, 2.0, 30.0, 2.0, 30.0, 40.0]], track_id=12)
    content["info"] = {"contributor": "ada"}
    content["licenses"] = [{"id": 4, "name": "CC BY 4.0", "url": "https://creativecommons.org/licenses/by/4.0/"}]
    content["images"][0] |= {"license": 4, "coco_url": "there", "date_captured": "2024-05-01"}
    names = ["left_hand_1", *reversed(COCO_17.joints)]
    content["categories"][1] |= {"keypoints": names, "skeleton": [[1, 2], [17, 18]], "supercategory": "animate"}
    for entry in content["annotations"]:
        rows = np.reshape(entry["keypoints"], (-1, 3))[::-1]
        entry["keypoints"] = [33.0, 44.0, 2, *rows.ravel().tolist()]
    content["annotations"].append(
        {"id": 99, "image_id": 3, "category_id": 1, "bbox": [1.0, 2.0, 3.0, 4.0], "iscrowd": 0}
    )
    content["images"].append({"id": 5, "file_name": "b.jpg", "width": WIDTH, "height": HEIGHT, "license": 4})
    project = opened(photos)
    assert project.start_from(_write(photos.parent / "cvat.json", content)) == (2, 2)
    project.act(1, "add_person", {"points": {"Torso": [300, 200]}})
    back = json.loads((project.out / COCO_FILE).read_text())
    assert (back["info"], back["licenses"]) == (content["info"], content["licenses"])
    assert back["images"] == content["images"]
    first, _, car, new = back["annotations"]
    assert [a["id"] for a in back["annotations"]] == [7, 8, 99, 1]
    assert car == content["annotations"][2]
    assert (first["segmentation"], first["track_id"]) == (content["annotations"][0]["segmentation"], 12)
    assert (first["area"], first["category_id"], first["image_id"]) == (120000.0, 2, 3)
    assert (new["category_id"], new["image_id"]) == (2, 5)
    category = back["categories"][1]
    at = category["keypoints"].index
    assert first["keypoints"][3 * at("left_hand_1") :][:3] == [33.0, 44.0, 2]
    assert category["skeleton"] == [
        [at("left_hand_1") + 1, at("right_ankle") + 1], [at("left_eye") + 1, at("nose") + 1],
    ]  # fmt: skip
    assert category["supercategory"] == "animate"
    again = opened(photos, "again")
    assert again.start_from(str(project.out / COCO_FILE)) == (2, 3)
    assert json.loads((again.out / COCO_FILE).read_text()) == back


def test_hands_and_face_are_written_back_in_pixels_of_the_photo(photos: Path) -> None:
    folder = Path(_openpose(photos))
    path = folder / "a_keypoints.json"
    content = json.loads(path.read_text())
    hand = [100.0, 50.0, 0.9] * 21
    for person in content["people"]:
        person |= {
            "hand_left_keypoints_2d": hand,
            "face_keypoints_2d": [7.0, 8.0, 0.5] * 70,
            "hand_right_keypoints_3d": [],
        }
    path.write_text(json.dumps(content))
    project = opened(photos)
    project.start_from(str(folder))
    for entry in json.loads((project.out / COCO_FILE).read_text())["annotations"]:
        assert (entry["hand_left_keypoints_2d"], entry["person_id"]) == (hand, [-1])
        assert len(entry["face_keypoints_2d"]) == 210
    # of a copy half as wide and half as high
    half = _coco(face_kpts=[10.0, 20.0, 1.0], lefthand_box=[1.0, 2.0, 3.0, 4.0], note="as it is")
    half["images"][0] |= {"width": WIDTH / 2, "height": HEIGHT / 2}
    for entry in half["annotations"]:
        entry["keypoints"] = [v if k % 3 == 2 else v / 2 for k, v in enumerate(entry["keypoints"])]
        entry["segmentation"] = {"counts": "abc", "size": [3, 4]}
    other = opened(photos, "half")
    other.start_from(_write(photos.parent / "half.json", half))
    for entry in json.loads((other.out / COCO_FILE).read_text())["annotations"]:
        assert entry["face_kpts"] == [20.0, 40.0, 1.0]
        assert entry["lefthand_box"] == [2.0, 4.0, 6.0, 8.0]
        assert (entry["area"], entry["note"]) == (480000.0, "as it is")
        assert "segmentation" not in entry


def test_pixels_beside_are_scaled_along_their_own_axis() -> None:
    entry = {
        "face_kpts": [1.0, 10.0, 0.5], "bbox": [1.0, 2.0, 3.0, 4.0], "area": 12.0, "id": 4, "foot_kpts": "none",
        "segmentation": [[1.0, 2.0, 3.0, 4.0]], EXTRA_JOINTS: {"left_hand_1": [5.0, 6.0, 0.7]},
    }  # fmt: skip
    (found,) = Beside((entry,)).scaled((2.0, 3.0)).people
    assert found == {
        "face_kpts": [2.0, 30.0, 0.5], "bbox": [2.0, 6.0, 6.0, 12.0], "area": 72.0, "id": 4,
        "segmentation": [[2.0, 6.0, 6.0, 12.0]], EXTRA_JOINTS: {"left_hand_1": [10.0, 18.0, 0.7]},
    }  # fmt: skip
    assert Beside((entry,)).scaled(None).people == ({"id": 4},)


def test_ids_of_two_files_stay_apart(photos: Path) -> None:
    project = opened(photos)
    for name in ("a.jpg", "b.jpg"):
        project.start_from(_write(photos.parent / f"{name}.json", _coco(name)))
    back = json.loads((project.out / COCO_FILE).read_text())
    assert [image["id"] for image in back["images"]] == [3, 1]
    assert [(entry["id"], entry["image_id"]) for entry in back["annotations"]] == [(7, 3), (8, 3), (1, 1), (2, 1)]
    assert len(back["categories"]) == 2


def _of(back: dict, name: str) -> tuple[list[dict], list[dict]]:
    """Return the people and the other entries that are written of a photo."""
    identity = next(image["id"] for image in back["images"] if image["file_name"] == name)
    entries = [entry for entry in back["annotations"] if entry["image_id"] == identity]
    return [e for e in entries if "num_keypoints" in e], [e for e in entries if "num_keypoints" not in e]


def test_categories_and_licences_of_two_files_stay_what_they_are(photos: Path) -> None:
    first, second = _coco("a.jpg"), _coco("b.jpg")
    first["categories"].append({"id": 3, "name": "dog"})
    # In the second file 1 is people, 2 is trams, 3 the same dog, and licence 4 is another one.
    second["categories"] = [
        {"id": 1, "name": "person", "keypoints": list(COCO_17.joints), "skeleton": [[6, 7]]},
        {"id": 2, "name": "tram"},
        {"id": 3, "name": "dog"},
    ]
    for entry in second["annotations"]:
        entry["category_id"] = "1"  # as text, which is read as the number
    for number, content in enumerate((first, second)):
        box = {"image_id": 3, "bbox": [1.0, 2.0, 3.0, 4.0], "iscrowd": 0}
        content["annotations"] += [{**box, "id": 90 + k, "category_id": k} for k in (2 if number else 1, 3)]
        content["licenses"] = [{"id": 4, "name": ("CC BY 4.0", "CC0")[number]}]
        content["images"][0]["license"] = 4
    project = opened(photos)
    for content in (first, second):
        project.start_from(_write(photos.parent / f"{content['images'][0]['file_name']}.json", content))
    back = json.loads((project.out / COCO_FILE).read_text())
    names = {category["id"]: category["name"] for category in back["categories"]}
    assert len(names) == len(back["categories"]) == 5
    assert [names[k] for k in (1, 2, 3)] == ["car", "person", "dog"]  # the first file's ids stay
    for photo, others in (("a.jpg", ["car", "dog"]), ("b.jpg", ["tram", "dog"])):
        people, rest = _of(back, photo)
        assert [names[e["category_id"]] for e in people] == ["person", "person"]
        assert [names[e["category_id"]] for e in rest] == others
    licences = {licence["id"]: licence["name"] for licence in back["licenses"]}
    assert [licences[image["license"]] for image in back["images"]] == ["CC BY 4.0", "CC0"]
    assert [len(Recorded(project.out / COCO_FILE).detect(p.photo)) for p in project.photos] == [2, 2]


def test_people_of_two_files_that_differ_in_lines_alone_are_one_category(photos: Path) -> None:
    names = [list(COCO_17.joints), list(reversed(COCO_17.joints))]
    project = opened(photos)
    for photo, joints in zip(("a.jpg", "b.jpg"), names, strict=True):
        content = _coco(photo)
        content["categories"][1] |= {"keypoints": joints, "skeleton": [[1, 2], "no line", [0, 99], [1, 2, 3]]}
        project.start_from(_write(photos.parent / f"{photo}.json", content))
    back = json.loads((project.out / COCO_FILE).read_text())
    (person,) = [c for c in back["categories"] if c["name"] == "person"]
    assert person["skeleton"] == [[1, 2], [17, 16]]
    assert {e["category_id"] for e in back["annotations"]} == {person["id"]}


def test_an_id_that_is_a_text_is_apart_from_the_number(photos: Path) -> None:
    project = opened(photos)
    for name, identity in (("a.jpg", 3), ("b.jpg", "3")):
        content = _coco(name)
        content["images"][0]["id"] = identity
        for entry in content["annotations"]:
            entry["image_id"] = identity
        project.start_from(_write(photos.parent / f"{name}.json", content))
    assert [len(Recorded(project.out / COCO_FILE).detect(p.photo)) for p in project.photos] == [2, 2]


def test_joints_of_entries_that_are_of_no_one_stay_at_their_place(photos: Path) -> None:
    content = _coco()
    content["categories"][1]["keypoints"] = list(reversed(COCO_17.joints))
    content["categories"].append({"id": 3, "name": "face", "keypoints": ["nose", "left_eye"], "skeleton": [[1, 2]]})
    crowd = [v for k in range(17) for v in (float(k), 1.0, 2)]
    content["annotations"] += [
        {"id": 98, "image_id": 3, "category_id": 2, "iscrowd": 1, "keypoints": crowd},
        {"id": 99, "image_id": 3, "category_id": 3, "iscrowd": 0, "keypoints": [5.0, 6.0, 2, 7.0, 8.0, 2]},
    ]
    project = opened(photos)
    project.start_from(_write(photos.parent / "mixed.json", content))
    back = json.loads((project.out / COCO_FILE).read_text())
    _, (of_crowd, face) = _of(back, "a.jpg")
    assert of_crowd["keypoints"][:3] == [16.0, 1.0, 2]  # the nose, last in the file
    assert (face["keypoints"], back["categories"][2]) == ([5.0, 6.0, 2, 7.0, 8.0, 2], content["categories"][2])


def test_a_whole_body_without_names_keeps_its_other_joints(photos: Path) -> None:
    content = _coco()
    del content["categories"]
    for entry in content["annotations"]:
        entry["keypoints"] += [5.0, 6.0, 2] * (133 - 17)
    project = opened(photos)
    project.start_from(_write(photos.parent / "wb.json", content))
    back = json.loads((project.out / COCO_FILE).read_text())
    (category,) = back["categories"]
    assert category["keypoints"][17:] == [f"joint_{k}" for k in range(18, 134)]
    assert back["annotations"][0]["keypoints"][3 * 132 :] == [5.0, 6.0, 2]


def test_measuring_keeps_nothing_that_it_does_not_use(photos: Path) -> None:
    path = _write(photos.parent / "a.json", _coco(segmentation=[[1.0, 2.0, 3.0, 4.0, 5.0, 6.0]]))
    photo = opened(photos).photos[0].photo
    assert Recorded(path).beside(photo) == Beside()
    assert Recorded(path, keep_beside=True).beside(photo).people[0]["id"] == 7


def test_people_who_are_removed_or_have_no_part_are_handled(photos: Path) -> None:
    content = _coco()
    legs = content["annotations"][1]["keypoints"]
    for k, joint in enumerate(COCO_17.joints):
        if joint not in ("left_knee", "left_ankle"):
            legs[3 * k : 3 * k + 3] = [0, 0, 0]
    project = opened(photos)
    assert project.start_from(_write(photos.parent / "legs.json", content)) == (1, 2)
    first, second = project.notes(0).people
    assert second.points == {}
    project.act(0, "remove_person", {"person": first.key})
    (left,) = json.loads((project.out / COCO_FILE).read_text())["annotations"]
    assert left["num_keypoints"] == 2


def test_the_same_command_goes_on_and_begins_nothing_anew(photos: Path) -> None:
    path = KINDS["cvat"](photos)
    project = opened(photos)
    project.start_from(path)
    key = project.notes(0).people[0].key
    project.act(0, "remove_person", {"person": key})
    project.close()
    again = opened(photos)
    assert again.start_from(path) == (0, 0)
    assert len(again.notes(0).people) == 1
    assert not (opened(photos, "without").out / COCO_FILE).exists()


def test_kortes_own_files_are_read_and_written_as_they_were(photos: Path) -> None:
    project = opened(photos)
    for k in range(2):
        project.act(k, "add_person", {"points": {"Eyes": [100 + k, 50], "Torso": [100, 150]}})
        project.act(k, "add_person", {"points": {"Head": [300, 60 + k]}})
        for person, tag in zip(project.notes(k).people, ("P0", "P3"), strict=True):
            project.act(k, "name_person", {"person": person.key, "tag": tag})
    project.act(1, "place_photos", {"scope": "photo", "shoot": 4, "camera": "C2"})
    project.act(0, "set_lens", {"scope": "photo", "lens": {"focal_mm": 21.5, "sensor_mm": [23.5, 15.6]}})
    project.act(None, "name_shoot", {"shoot": 4, "name": "yard"})
    for shoot, camera in ((0, "C0"), (4, "C2")):
        for tag, at in ((camera, [0, 0]), ("P0", [-0.75, 5]), ("P3", [0.75, 5.5])):
            project.act(None, "set_spot", {"shoot": shoot, "tag": tag, "at": at})
    project.write()
    again = opened(photos, "again")
    assert again.start_from(str(project.out)) == (2, 4)
    names = ("body_pixel_locations", "ground_truth_locations", "camera_locations_photoshoot_identifiers", "settings")
    for name in (*names, "focal_lengths"):
        assert (again.out / f"{name}.csv").read_text() == (project.out / f"{name}.csv").read_text(), name
    assert again.check() == project.check()
    assert len(read_labels(again.out)) == 2


def test_labels_of_a_smaller_copy_are_scaled(photos: Path) -> None:
    content = _coco()
    content["images"][0] |= {"width": WIDTH // 2, "height": HEIGHT // 2}
    for annotation in content["annotations"]:
        annotation["keypoints"] = [v if k % 3 == 2 else v / 2 for k, v in enumerate(annotation["keypoints"])]
    project = opened(photos)
    project.start_from(_write(photos.parent / "half.json", content))
    x, y = PEOPLE.part("Torso")[0]
    found = project.notes(0).people[0].points["Torso"]
    assert math.hypot(found[0] - x, found[1] - y) < 2


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (lambda: _coco("other.jpg"), "names none of the 2 photos, but other.jpg"),
        (lambda: [{**_label_studio()[0], "data": {"text": 5}}], "names no image"),
        (lambda: [{"data": {"image": "a.jpg"}, "annotations": [{"result": [
            {"id": "1", "type": "keypointlabels", "original_width": 10, "original_height": 10,
             "value": {"x": 1, "y": 1, "keypointlabels": ["wheel"]}}]}]}], "no joint of a person"),
        (lambda: [{"data": {"image": "a.jpg"}, "annotations": [{"result": [
            {"id": n, "type": "keypointlabels", "original_width": 10, "original_height": 10,
             "value": {"x": 1, "y": 1, "keypointlabels": ["nose"]}} for n in "ab"]}]}], "rectangle around each person"),
        (lambda: {"no": "keypoints"}, "no keypoints in it"),
    ],
)  # fmt: skip
def test_what_cannot_be_used_is_one_line(content, message: str, photos: Path) -> None:
    project = opened(photos)
    with pytest.raises(ProxemetryError, match=message):
        project.start_from(_write(photos.parent / "bad.json", content()))
    assert not project.notes(0).people


def test_the_command_takes_them(photos: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = KINDS["cvat"](photos)
    out = str(photos.parent / "out")
    code = main(["annotate", str(photos), "--out", out, "--pose", "none", "--labels", path, "--check"])
    said = capsys.readouterr()
    assert code == 1  # nobody has a place yet
    assert "2 people read, on 1 photos" in said.err
    assert main(["annotate", str(photos), "--out", out, "--labels", str(photos / "none.json"), "--check"]) == 2
    assert issubclass(KeypointsError, ProxemetryError) and issubclass(SettingsError, ProxemetryError)
