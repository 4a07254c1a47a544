"""Cross-checking: a person counts only where two models agree."""

from __future__ import annotations

from types import MappingProxyType

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from proxemetry.camera import Camera
from proxemetry.errors import PhotoError, SettingsError
from proxemetry.measure import measure
from proxemetry.people import People
from proxemetry.people.skeleton import BODY_25, COCO_17, KORTE_PARTS, Skeleton
from proxemetry.photo import Photo
from proxemetry.pose import backend_named, replays
from proxemetry.pose.confirmation import confirmed_by_boxes, confirmed_by_people
from proxemetry.pose.cross_check import CrossChecked, cross_checked
from proxemetry.pose.recording import Recording
from synthetic.field_maps import standing

PLACES = [(100, 20), (400, 40), (650, 30)]


def _people(places: list[tuple[float, float]], skeleton: Skeleton = BODY_25, height: float = 400) -> People:
    figures = np.array([standing(x, y, height) for x, y in places]).reshape(-1, 25, 2)
    rows = [BODY_25.joints.index(joint) for joint in skeleton.joints if joint in BODY_25.joints]
    assert len(rows) == len(skeleton)
    return People(skeleton, figures[:, rows], np.full((len(places), len(skeleton)), 0.8))


def test_only_those_whom_both_see_are_left_in_their_order() -> None:
    ours, theirs = _people(PLACES), _people([PLACES[2], PLACES[0]], COCO_17)
    kept = confirmed_by_people(ours, theirs)
    assert np.array_equal(kept.keypoints_px, ours[[0, 2]].keypoints_px)
    assert len(confirmed_by_people(ours, People.none(COCO_17))) == 0
    assert len(confirmed_by_people(People.none(COCO_17), ours)) == 0


def test_one_witness_confirms_one_person() -> None:
    twice = _people([PLACES[0], (104, 22)])
    assert len(confirmed_by_people(twice, _people(PLACES[:1]))) == 1


def test_a_neighbour_or_a_giant_is_no_witness() -> None:
    assert len(confirmed_by_people(_people([(100, 20)]), _people([(300, 20)]))) == 0
    assert len(confirmed_by_people(_people([(100, 300)], height=60), _people([(100, 20)], height=600))) == 0


def test_skeletons_without_a_joint_in_common_confirm_nothing() -> None:
    parts = People(KORTE_PARTS, np.array([[(100, 50), (100, 50), (np.nan,) * 2, (np.nan,) * 2]]), np.ones((1, 4)))
    assert len(confirmed_by_people(_people(PLACES), parts)) == 0


@given(st.permutations(range(3)), st.floats(0.2, 5))
def test_order_and_scale_do_not_matter(order: list[int], factor: float) -> None:
    ours, theirs = _people(PLACES), _people([PLACES[0], (405, 44)], COCO_17)
    expected = {0, 1}
    kept = confirmed_by_people(ours[list(order)].scaled(factor, factor), theirs.scaled(factor, factor))
    assert {order.index(row) for row in expected} == {
        int(np.flatnonzero((ours[list(order)].scaled(factor, factor).boxes_px == box).all(axis=1))[0])
        for box in kept.boxes_px
    }


def test_boxes_confirm_those_whom_they_hold_one_for_one() -> None:
    people = _people(PLACES)
    boxes = people.boxes_px[[2, 0]] + (3, 3, -3, -3)
    assert np.array_equal(confirmed_by_boxes(people, boxes).keypoints_px, people[[0, 2]].keypoints_px)
    assert len(confirmed_by_boxes(people, np.zeros((0, 4)))) == 0
    everything = np.array([[0, 0, 1000, 1000]])
    assert len(confirmed_by_boxes(people, everything)) == 1, "one box is one person"


@pytest.mark.parametrize("shift", [(0, 0), (-5000, 300), (40, 7000)])
def test_where_in_the_picture_people_stand_does_not_matter_to_who_confirms_them(shift: tuple[int, int]) -> None:
    people = _people([(x + shift[0], y + shift[1]) for x, y in PLACES])
    x0, y0, x1, y1 = people.boxes_px[1]
    width, height = x1 - x0, y1 - y0
    for box, confirmed in (
        ((x0, y0, x1, y1), True),
        ((x0 + 0.08 * width, y0 + 0.08 * height, x1 - 0.08 * width, y1 - 0.08 * height), True),  # hands and feet cut
        ((x0, y0 - height, x1, y0 - 0.2 * height), False),  # above, in the same columns
        ((x1 + 0.2 * width, y0, x1 + width, y1), False),  # beside, in the same rows
    ):
        assert len(confirmed_by_boxes(people, np.array([box]))) == confirmed


class _Fixed:
    def __init__(self, name: str, people: People) -> None:
        self.name, self.skeleton, self.people = name, people.skeleton, people
        self.models = MappingProxyType({f"{name}.onnx": "0" * 64})
        self.asked = 0

    def detect(self, photo: Photo) -> People:
        self.asked += 1
        return self.people


def test_a_pair_of_back_ends_is_a_back_end() -> None:
    photo = Photo.from_array(np.zeros((10, 10, 3), np.uint8))
    first, second = _Fixed("a", _people(PLACES)), _Fixed("b", _people(PLACES[1:], COCO_17))
    pair = CrossChecked(first, second)
    assert pair.name == "cross-check:a+b" and pair.skeleton is BODY_25
    assert set(pair.models) == {"a.onnx", "b.onnx"}
    assert len(pair.detect(photo)) == 2
    nobody = CrossChecked(_Fixed("a", People.none(BODY_25)), second)
    assert len(nobody.detect(photo)) == 0
    assert second.asked == 1, "where the first sees nobody the second is not asked"


class _Told(_Fixed):
    """A recording that states a camera."""

    photos = ("a.jpg",)

    def photo(self, name: str) -> Photo:
        return Photo(name, 1000, 800, "0" * 64)

    def camera_of(self, photo: Photo) -> Camera | None:
        return Camera.centred(999, photo.width, photo.height)

    def why_no_people(self, photo: Photo) -> str | None:
        return None if len(self.people) else "not listed"


def test_the_camera_that_a_keypoint_file_states_is_not_lost_where_another_confirms_its_people() -> None:
    pixels = np.zeros((800, 1000, 3), np.uint8)
    people = _people(PLACES)
    for pair in ((_Told("a", people), _Fixed("b", people)), (_Fixed("b", people), _Told("a", people))):
        scene = measure(pixels, pose=cross_checked(*pair))
        assert scene.camera.camera is not None and scene.camera.camera.f_px == 999
    assert not isinstance(cross_checked(_Fixed("a", people), _Fixed("b", people)), Recording)


def test_a_pair_knows_photos_without_files_where_its_first_does() -> None:
    told, seen = _Told("a", _people(PLACES)), _Fixed("b", _people(PLACES))
    first, second = cross_checked(told, seen), cross_checked(seen, told)
    assert isinstance(first, Recording) and isinstance(second, Recording)
    assert first.photos == ("a.jpg",) and first.photo("a.jpg").width == 1000
    assert second.photos == ()
    with pytest.raises(PhotoError, match="b looks at the photo"):
        second.photo("a.jpg")
    empty = cross_checked(_Told("a", People.none(BODY_25)), seen)
    assert isinstance(empty, Recording) and empty.why_no_people(first.photo("a.jpg")) == "not listed"
    assert replays("cross-check:recorded:a.json+blazepose") and not replays("cross-check:blazepose+recorded:a.json")


@pytest.mark.parametrize("names", ["", "blazepose", "a+b+c", "+blazepose"])
def test_two_names_are_needed(names: str) -> None:
    with pytest.raises(SettingsError, match=r"write cross-check:FIRST\+SECOND"):
        backend_named(f"cross-check:{names}")
