"""The benchmark of consistency: a look agrees with itself, and comes back into the photo's pixels."""

from dataclasses import replace

import numpy as np
import pytest

from benchmarks.networks.consistency import END, START, Agreement, Look, compared, markdown, same_people, written
from proxemetry.camera import Camera
from synthetic.scenes import Recipe, scenes

CAMERA = Camera.centred(1000, 1200, 900)


@pytest.fixture(scope="module")
def look():
    photo = next(p for p in scenes(20, 3, Recipe()) if len(p.people) >= 3)
    return Look("first", photo.people, photo.camera)


def test_a_look_agrees_with_itself(look):
    same = compared(look, look)
    assert len(same.there) >= 1
    assert same.there.all()
    assert same.back.all()
    assert same.headings.all()
    assert same.depth == pytest.approx(1)


@pytest.mark.parametrize(("scale", "corner"), [(0.5, (0, 0)), (1.0, (70, 30))])
def test_a_smaller_or_cut_photo_comes_back_to_the_same_places(look, scale, corner):
    camera = look.camera
    size = round(camera.width * scale), round(camera.height * scale)
    people = replace(look.people, keypoints_px=look.people.keypoints_px - np.array(corner)).scaled(scale, scale)
    cut = camera.cropped(*corner, camera.width, camera.height)
    shown = Look("shown", people, cut.resized(*size) if scale != 1 else cut, scale, corner)
    assert shown.in_photo().keypoints_px == pytest.approx(look.people.keypoints_px, nan_ok=True)
    again = compared(look, shown)
    assert again.depth == pytest.approx(1, abs=0.02)
    assert again.there.all()


def test_people_far_from_one_another_are_others(look):
    away = replace(look.people, keypoints_px=look.people.keypoints_px + 5000)
    assert same_people(look.people, away) == []
    assert len(same_people(look.people, look.people)) == len(look.people)


def test_the_table_is_written_between_its_marks():
    row = ["a", "b", *Agreement.of_all([]).cells()]
    text = markdown([row])
    page = f"before\n{START}\nold\n{END}\nafter\n"
    again = written(page, text)
    assert again.startswith("before\n")
    assert again.endswith("\nafter\n")
    assert text in again
    assert "old" not in again
    with pytest.raises(ValueError, match="marks"):
        written("no marks", text)
