"""Keypoint files as tools and computers write them: unturned, without visibility, without files for nobody, by Macs."""

from __future__ import annotations

import json
import unicodedata
from pathlib import Path

import numpy as np
import pytest

from proxemetry.cli import main
from proxemetry.errors import KeypointsError
from proxemetry.people import People
from proxemetry.people.skeleton import COCO_17
from proxemetry.photo import Photo
from proxemetry.photo.metadata import Metadata
from proxemetry.pose.recorded import Recorded
from synthetic.camera_files import write

WIDTH, HEIGHT = 600, 800


def standing(x: float) -> np.ndarray:
    """Return the joints of someone who stands upright at x in a photo of 600 x 800, shape (17, 2)."""
    heights = [200, 190, 190, 195, 195, 250, 250, 320, 320, 380, 380, 400, 400, 500, 500, 600, 600]
    sides = [0, 8, -8, 16, -16, 40, -40, 50, -50, 55, -55, 25, -25, 25, -25, 25, -25]
    return np.stack([x + np.array(sides, dtype=float), np.array(heights, dtype=float)], axis=-1)


UPRIGHT = np.stack([standing(150), standing(300), standing(450)])


def unturned(points: np.ndarray, orientation: int) -> np.ndarray:
    """Return pixels of the upright photo in those of the stored one (EXIF 2.32, tag 0x0112)."""
    x, y = points[..., 0], points[..., 1]
    if orientation in (2, 3, 6, 7):
        x = WIDTH - x
    if orientation in (3, 4, 7, 8):
        y = HEIGHT - y
    return np.stack([y, x] if orientation >= 5 else [x, y], axis=-1)


def recorded(path: Path, points: np.ndarray, size: tuple[int, int] | None) -> Recorded:
    people = [{"keypoints": [[x, y, 0.9] for x, y in person]} for person in points.tolist()]
    image = {"filename": "a.jpg", "people": people}
    if size is not None:
        image |= {"width": size[0], "height": size[1]}
    path.write_text(json.dumps({"skeleton": "coco17", "images": [image]}))
    return Recorded(path)


def photo_of(orientation: int) -> Photo:
    return Photo("a.jpg", WIDTH, HEIGHT, "", Metadata(orientation=orientation))


@pytest.mark.parametrize("orientation", [5, 6, 7, 8])
def test_people_of_the_unturned_photo_are_turned_where_its_size_is_stated(orientation: int, tmp_path: Path) -> None:
    points = unturned(UPRIGHT, orientation)
    if orientation in (5, 7):  # a mirror makes the tool call left right
        points = points[:, list(COCO_17.mirror)]
    people = recorded(tmp_path / "kp.json", points / 2, (HEIGHT // 2, WIDTH // 2)).detect(photo_of(orientation))
    np.testing.assert_allclose(people.keypoints_px, UPRIGHT)
    assert (people.boxes_px[:, 0] < people.boxes_px[:, 2]).all() and people.boxes_px[0, 1] == 190


@pytest.mark.parametrize("orientation", [6, 8])
def test_without_a_size_lying_people_are_refused(orientation: int, tmp_path: Path) -> None:
    points = unturned(UPRIGHT, orientation)
    points[..., 0] *= WIDTH / HEIGHT  # nothing lies beyond the upright photo
    for some in (points, points[:1]):
        with pytest.raises(KeypointsError, match=r"a\.jpg: .*heads the same way, and an orientation tag"):
            recorded(tmp_path / "kp.json", some, None).detect(photo_of(orientation))


@pytest.mark.parametrize("orientation", [6, 8])
def test_pixels_beyond_the_upright_photo_tell_as_much_as_a_size(orientation: int, tmp_path: Path) -> None:
    points = unturned(UPRIGHT + (0, 100 if orientation == 6 else -150), orientation)
    people = recorded(tmp_path / "kp.json", points, None).detect(photo_of(orientation))
    assert (people.part("Eyes")[:, 1] < people.part("Shoulder")[:, 1]).all()


def test_all_people_on_their_heads_are_turned(tmp_path: Path) -> None:
    people = recorded(tmp_path / "kp.json", unturned(UPRIGHT, 3), None).detect(photo_of(3))
    np.testing.assert_allclose(people.keypoints_px, UPRIGHT)


def test_what_fits_the_upright_photo_stays(tmp_path: Path) -> None:
    lying = UPRIGHT.copy()
    lying[0] = unturned(UPRIGHT[:1], 6)[0] * (WIDTH / HEIGHT, 1)
    for points, orientation in ((UPRIGHT, 6), (UPRIGHT, 3), (lying, 6), (lying[:1], 1)):
        people = recorded(tmp_path / "kp.json", points, None).detect(photo_of(orientation))
        np.testing.assert_allclose(people.keypoints_px, points)
    sized = recorded(tmp_path / "kp.json", UPRIGHT, (WIDTH, HEIGHT)).detect(photo_of(6))
    np.testing.assert_allclose(sized.keypoints_px, UPRIGHT)


@pytest.mark.parametrize("visible", [False, True])
@pytest.mark.parametrize("confidence", [False, True])
def test_ultralytics_text_with_and_without_visibility(visible: bool, confidence: bool, tmp_path: Path) -> None:
    points = UPRIGHT[0] / (WIDTH, HEIGHT)
    rows = np.column_stack([points, np.full(17, 0.8)]) if visible else points
    numbers = [0, 0.25, 0.5, 0.2, 0.5, *rows.ravel(), *([0.7] if confidence else [])]
    (tmp_path / "a.txt").write_text(" ".join(f"{n:.6f}" for n in numbers))
    people = Recorded(tmp_path).detect(photo_of(1))
    np.testing.assert_allclose(people.keypoints_px[0], UPRIGHT[0], atol=0.01)
    assert people.person_scores[0] == pytest.approx(0.7 if confidence else 0.8 if visible else 1.0)


def test_a_folder_of_texts_has_none_for_a_photo_without_anybody(tmp_path: Path) -> None:
    rows = " ".join(f"{n:.4f}" for n in (UPRIGHT[0] / (WIDTH, HEIGHT)).ravel())
    (tmp_path / "a.txt").write_text(f"0 .2 .5 .2 .5 {rows}")
    backend, empty = Recorded(tmp_path), Photo("empty.jpg", WIDTH, HEIGHT, "")
    assert len(backend.detect(empty)) == 0
    assert "has no file for it" in (backend.why_no_people(empty) or "")


@pytest.mark.parametrize("forms", [("NFD", "NFC"), ("NFC", "NFD")])
def test_names_from_a_mac(forms: tuple[str, str], tmp_path: Path) -> None:
    path = tmp_path / "kp.json"
    name, other = (unicodedata.normalize(form, "Müller_1.jpg") for form in forms)
    people = [{"keypoints": [[x, y, 1] for x, y in UPRIGHT[0].tolist()]}]
    path.write_text(json.dumps({"skeleton": "coco17", "images": [{"filename": name, "people": people}]}))
    assert len(Recorded(path).detect(Photo(other, WIDTH, HEIGHT, ""))) == 1


def coco(tmp_path: Path, categories: list[dict[str, object]], annotations: list[dict[str, object]]) -> People:
    path = tmp_path / "coco.json"
    images = [{"id": 1, "file_name": "a.jpg", "width": WIDTH, "height": HEIGHT}]
    path.write_text(json.dumps({"images": images, "categories": categories, "annotations": annotations}))
    return Recorded(path).detect(photo_of(1))


PERSON = {"id": 1, "name": "person", "keypoints": list(COCO_17.joints)}
DOG = {"id": 7, "name": "dog", "keypoints": ["nose", "tail"]}
SEATED = {"id": 2, "name": "seated", "keypoints": list(COCO_17.joints)}


def annotation(category: int, joints: int = 17) -> dict[str, object]:
    flat = [n for x, y in UPRIGHT[0][:joints].tolist() for n in (x, y, 2)]
    return {"image_id": 1, "category_id": category, "keypoints": flat}


@pytest.mark.parametrize("categories", [[DOG, PERSON], [PERSON, DOG], [DOG, SEATED, PERSON]])
def test_other_categories_are_left_out(categories: list[dict[str, object]], tmp_path: Path) -> None:
    annotations = [annotation(7, 2), annotation(1), annotation(7, 2)]
    assert len(coco(tmp_path, categories, annotations)) == 1
    if SEATED in categories:  # people of two kinds, with the same joints
        assert len(coco(tmp_path, categories, [*annotations, annotation(2)])) == 2
    # many tools count categories otherwise than they list them
    assert len(coco(tmp_path, [PERSON], [annotation(0)])) == 1


def test_results_of_other_photos_are_refused_in_one_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    photos = tmp_path / "photos"
    photos.mkdir()
    for name in ("a.jpg", "b.jpg"):
        write(photos / name, WIDTH, HEIGHT)
    flat = [n for x, y in UPRIGHT[0].tolist() for n in (x, y, 0.9)]
    results = tmp_path / "kp.json"
    results.write_text(json.dumps([{"image_id": 17, "keypoints": flat, "score": 0.9}]))
    command = ["measure", str(photos), "--pose", f"recorded:{results}", "--focal-px", "900", "--jobs", "0"]
    assert main([*command, "--out", str(tmp_path / "out")]) == 2
    (line,) = [line for line in capsys.readouterr().err.splitlines() if line.startswith("proxemetry:")]
    assert "not one of the 2 photos is named in it" in line
    results.write_text(json.dumps([{"image_id": "a.jpg", "keypoints": flat, "score": 0.9}]))
    assert main([*command, "--out", str(tmp_path / "out2")]) == 0  # nobody in b.jpg is an answer
