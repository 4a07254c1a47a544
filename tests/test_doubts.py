"""People who may be none: each reason by what was seen, how it travels, and where it shows."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from proxemetry.archive.figures.restriction import _by_reason, _meant, counted
from proxemetry.archive.figures.summary import summarise
from proxemetry.archive.figures.totals import totals
from proxemetry.archive.review.edits import _joined
from proxemetry.archive.store import index, parts
from proxemetry.archive.store.duck import connection, quoted
from proxemetry.archive.store.folder import Folder
from proxemetry.archive.store.queries import stored, with_columns
from proxemetry.archive.store.results import Results
from proxemetry.arrays import FloatArray
from proxemetry.cli import main
from proxemetry.errors import KeypointsError, SettingsError
from proxemetry.people import People
from proxemetry.people.attributes import PairsWhere
from proxemetry.people.doubts import LEAST_RIVALS, MOST_ABOVE_HIPS, MOST_UPPER, PersonDoubt, doubts_of, in_words
from proxemetry.people.duplicates import POSSIBLY_SAME, moved_aside, possible_duplicates, similarity
from proxemetry.people.rival import Rival
from proxemetry.people.skeleton import COCO_17
from proxemetry.photo import Photo
from proxemetry.pose import backend_named
from proxemetry.pose.detections import NOBODY, Detections, decode_yolox, joined
from proxemetry.pose.rivals import COCO_CLASSES, COMPANIONS, LEAST_RATIO, rivals_of
from proxemetry.scene import Scene
from proxemetry.scene_json import people_from_dict, people_to_dict
from proxemetry.tables import DOUBT, TABLES, Column
from synthetic.dotted_world import PEOPLE, PHOTO_SIZE, specification
from synthetic.network_files import dots

LEGS = slice(11, 17)
BIRD, CHAIR, KITE = (COCO_CLASSES.index(name) for name in ("bird", "chair", "kite"))


def _people(count: int = 1, top: float = 100.0, **stated: object) -> People:
    """Upright people side by side, 400 px tall and all joints seen."""
    rows = np.repeat([0.0, 0.02, 0.02, 0.05, 0.05, 0.2, 0.2, 0.35, 0.35, 0.5, 0.5, 0.5, 0.5, 0.75, 0.75, 1, 1], 1)
    one = np.stack([100 + 20.0 * (np.arange(17) % 2), top + 400 * rows], axis=1)
    points = np.stack([one + (300.0 * k, 0) for k in range(count)])
    boxes = np.array([[90 + 300.0 * k, top, 130 + 300.0 * k, top + 400] for k in range(count)])
    return People(COCO_17, points, np.full((count, 17), 0.8), boxes, **stated)  # type: ignore[arg-type]


def _legs_alone(top: float = 300.0, upper: float = 0.0) -> People:
    """Legs in a box of their own, which begins at `top`, little above the hips."""
    people = _people(top=top - 190)
    scores = np.where(np.arange(17) >= 11, 0.8, upper)[None]
    return People(COCO_17, people.keypoints_px, scores, people.boxes_px + (0, 190, 0, 0))


def test_nothing_speaks_against_a_person_who_is_seen_whole() -> None:
    assert doubts_of(_people(3)) == ((), (), ())
    assert doubts_of(People.none(COCO_17)) == ()


def test_legs_without_a_body_above_are_doubtful() -> None:
    assert doubts_of(_legs_alone()) == ((PersonDoubt.NO_UPPER_BODY,),)
    # of seven joints above as sure as MOST_UPPER of those below, the limit itself is still doubtful
    assert doubts_of(_legs_alone(upper=0.8 * MOST_UPPER - 0.001)) == ((PersonDoubt.NO_UPPER_BODY,),)
    assert doubts_of(_legs_alone(upper=0.8 * MOST_UPPER + 0.001)) == ((),)


@pytest.mark.parametrize(("from_top", "doubtful"), [(MOST_ABOVE_HIPS - 0.01, True), (MOST_ABOVE_HIPS + 0.01, False)])
def test_a_box_with_room_for_a_body_above_the_hips_is_no_legs_alone(from_top: float, doubtful: bool) -> None:
    legs = _legs_alone()
    hips, high = legs.joint("left_hip")[0, 1], legs.boxes_px[0, 3]
    box = legs.boxes_px.copy()
    box[0, 1] = (hips - from_top * high) / (1 - from_top)
    here = People(COCO_17, legs.keypoints_px, legs.scores, box)
    assert (doubts_of(here) == ((PersonDoubt.NO_UPPER_BODY,),)) is doubtful
    without_hips = legs.scores.copy()
    without_hips[0, 11:13] = 0.0
    only_knees = People(COCO_17, legs.keypoints_px, without_hips, box)
    assert doubts_of(only_knees) == ((PersonDoubt.NO_UPPER_BODY,),)  # no hip tells where the body would be


def test_whom_the_photos_upper_edge_cuts_is_not_doubtful() -> None:
    assert doubts_of(_legs_alone(top=0.0)) == ((),)
    assert doubts_of(_legs_alone(top=50.0)) == ((PersonDoubt.NO_UPPER_BODY,),)


def test_a_face_without_legs_and_joints_without_scores_are_not_doubtful() -> None:
    people = _people()
    scores = people.scores.copy()
    scores[:, LEGS] = 0.0
    assert doubts_of(People(COCO_17, people.keypoints_px, scores, people.boxes_px)) == ((),)
    nothing = People(COCO_17, np.full((1, 17, 2), np.nan), np.zeros((1, 17)), people.boxes_px)
    assert doubts_of(nothing) == ((),)


@pytest.mark.parametrize("source", ["yolox-tinypose", "my-own", ""])
def test_another_class_counts_from_the_back_ends_own_limit(source: str) -> None:
    limit = LEAST_RIVALS.get(source, 1.0)
    assert limit == {"yolox-tinypose": 0.2}.get(source, 1.0)
    rivals = [Rival("bird", limit - 0.01), None, Rival("kite", limit)]
    people = _people(3, source=source, rivals=rivals)
    assert doubts_of(people) == ((), (), (PersonDoubt.OTHER_CLASS,))
    assert in_words(people, 2, doubts_of(people)[2]) == "may be another kind of thing (kite)"


def test_a_person_found_twice_is_doubtful_and_both_reasons_stand() -> None:
    one = _people()
    points = np.concatenate([one.keypoints_px, one.keypoints_px + 3])
    people = People(
        COCO_17, points, np.full((2, 17), 0.8), np.concatenate([one.boxes_px, one.boxes_px + 3]), np.array([0.9, 0.5]),
        rivals=[None, Rival("bird", 2.0)],
    )  # fmt: skip
    assert doubts_of(people) == ((), (PersonDoubt.POSSIBLE_DUPLICATE, PersonDoubt.OTHER_CLASS))


@given(st.permutations(range(4)))
def test_doubts_go_with_their_people(order: list[int]) -> None:
    people = _people(4, rivals=[None, Rival("bird", 1.5), Rival("cat", 0.1), None])
    assert people[order].rivals == tuple(people.rivals[i] for i in order)
    assert doubts_of(people[order]) == tuple(doubts_of(people)[i] for i in order)


def test_people_need_a_rival_each_or_none() -> None:
    with pytest.raises(KeypointsError, match="2 entries for 3 people"):
        _people(3, rivals=[None, None])
    for ratio in (-0.1, np.nan, np.inf):
        with pytest.raises(KeypointsError, match="number from 0"):
            Rival("bird", ratio)


def test_scenes_keep_rivals_and_older_scenes_have_none() -> None:
    people = _people(2, rivals=[Rival("teddy bear", 0.123456789), None])
    fields = json.loads(json.dumps(people_to_dict(people)))
    assert people_from_dict(fields).rivals == (Rival("teddy bear", 0.1234568), None)
    del fields["rivals"]
    assert people_from_dict(fields).rivals == (None, None)
    assert "rivals" not in people_to_dict(_people(2))  # what was byte for byte the same stays so


# What a detector knows of its other classes


def _rivals(classes: dict[int, float], box: FloatArray, person: float = 0.5) -> Rival | None:
    """Of a person with a score and a cell whose box and class scores are given."""
    scores = np.zeros((2, 80))
    scores[0, 0] = person
    for name, score in classes.items():
        scores[1, name] = score
    boxes = np.array([[0.0, 0, 100, 200], box])
    (rival,) = rivals_of(boxes[:1], np.array([person]), scores, 0, lambda rows: boxes[rows])
    return rival


def _named(rival: Rival | None) -> tuple[str, float]:
    assert rival is not None
    return rival.name, rival.ratio


SAME, SMALLER = np.array([0.0, 0, 100, 190]), np.array([0.0, 0, 100, 120])


def test_the_strongest_other_class_in_the_same_place_is_the_rival() -> None:
    assert _named(_rivals({BIRD: 0.2, KITE: 0.3}, SAME)) == ("kite", pytest.approx(0.6))
    assert _rivals({BIRD: 0.3}, SMALLER) is None  # overlaps by 0.6: held or worn, not the person
    assert _rivals({BIRD: 0.5 * LEAST_RATIO - 1e-4}, SAME) is None
    assert _rivals({}, SAME) is None


def test_what_people_sit_on_is_no_rival_and_hides_none() -> None:
    assert _rivals({CHAIR: 0.9}, SAME) is None
    assert _named(_rivals({CHAIR: 0.9, BIRD: 0.25}, SAME)) == ("bird", pytest.approx(0.5))
    assert set(COCO_CLASSES) > COMPANIONS and len(COCO_CLASSES) == 80 and "person" not in COMPANIONS


def test_a_screen_that_holds_the_person_shows_one() -> None:
    around, beside = np.array([-20.0, -20, 160, 260]), np.array([20.0, -20, 160, 260])
    tv = COCO_CLASSES.index("tv")
    assert _rivals({tv: 0.1}, around) == Rival("tv", 0.2, shows=True)
    assert _rivals({tv: 0.1}, beside) is None  # a fifth of the person is beside it
    assert _rivals({BIRD: 0.1}, around) is None  # a bird shows nobody
    assert _rivals({tv: 0.5 * LEAST_RATIO - 1e-4}, around) is None


@pytest.mark.parametrize(("source", "limit"), [("yolox-tinypose", 0.1), ("my-own", 0.5)])
def test_a_person_on_a_screen_is_doubtful(source: str, limit: float) -> None:
    rivals = [Rival("tv", limit - 0.01, True), Rival("tv", limit, True), Rival("tv", limit)]
    people = _people(3, source=source, rivals=rivals)
    assert doubts_of(people) == ((), (PersonDoubt.IN_PICTURE,), ())
    assert in_words(people, 1, doubts_of(people)[1]) == "may be on a screen or in a picture (tv)"
    kept = people_from_dict(json.loads(json.dumps(people_to_dict(people)))).rivals
    assert [(r.name, r.shows) for r in kept if r] == [("tv", True), ("tv", True), ("tv", False)]


def test_classes_of_other_sets_have_numbers_and_one_class_has_no_rivals() -> None:
    box = np.array([[0.0, 0, 100, 200]])
    (found,) = rivals_of(box, np.array([0.5]), np.array([[0.1, 0.5, 0.4]]), 1, lambda rows: box)
    assert _named(found) == ("class 2", pytest.approx(0.8))
    assert rivals_of(box, np.array([0.5]), np.array([[0.5]]), 0, lambda rows: box) == (None,)
    assert rivals_of(box[:0], np.zeros(0), np.array([[0.5, 0.2]]), 0, lambda rows: box) == ()


def test_boxes_too_unsure_to_be_people_are_asked_nothing_and_change_no_other_answer() -> None:
    random = np.random.default_rng(5)
    boxes = np.repeat([[0.0, 0, 100, 200], [300, 0, 400, 200]], 10, axis=0) + random.uniform(0, 8, (20, 4))
    classes = random.uniform(0, 0.1, (20, 80))
    scores = random.uniform(0.1, 0.9, 20)
    every = rivals_of(boxes, scores, classes, 0, lambda rows: boxes[rows])
    some = rivals_of(boxes, scores, classes, 0, lambda rows: boxes[rows], 0.4)
    assert None not in every and 0 < some.count(None) < 20
    assert some == tuple(rival if score >= 0.4 else None for rival, score in zip(every, scores, strict=True))


def test_a_yolox_head_says_what_else_it_sees() -> None:
    """Cell (3, 2) of stride 16 in a 64 x 64 input, as in `test_pose_geometry`: a person 0.72, a bird 0.9 * 0.4."""
    raw = np.zeros((1, 64 + 16 + 4, 85), np.float32)
    raw[0, 64 + 2 * 4 + 3, :5] = [0.5, 0.25, np.log(2), np.log(1.5), 0.9]
    raw[0, 64 + 2 * 4 + 3, [5, 5 + BIRD]] = [0.8, 0.4]
    (rival,) = decode_yolox([raw], (64, 64), least=0.5).rivals
    assert _named(rival) == ("bird", pytest.approx(0.5))
    assert decode_yolox([raw * 0], (64, 64), least=0.5).rivals == ()


def test_detections_take_their_rivals_along() -> None:
    bird = Rival("bird", 0.4)
    found = Detections(np.array([[0.0, 0, 9, 9], [5, 5, 9, 9]]), np.array([0.9, 0.8]), rivals=(bird, None))
    assert found[np.array([1, 0])].rivals == (None, bird)
    assert joined([NOBODY, found[np.array([False, True])], found]).rivals == (None, bird, None)
    assert found.placed(found.boxes_px * 2).rivals == found.rivals


def test_a_back_end_hands_them_on(tmp_path: Path) -> None:
    pytest.importorskip("onnxruntime")
    people = backend_named(f"onnx:{specification(tmp_path, 'simcc')}").detect(
        Photo.from_array(dots(PHOTO_SIZE, PEOPLE))
    )
    assert len(people) > 0 and all(_named(rival) == ("bird", pytest.approx(0.2)) for rival in people.rivals)


def test_a_person_added_by_hand_has_no_rival_and_takes_none() -> None:
    bird = Rival("bird", 0.4)
    assert _joined(_people(2, rivals=[bird, None]), _people()).rivals == (bird, None, None)


def test_of_several_doubts_any_is_meant() -> None:
    both = "possible_duplicate+no_upper_body"
    assert _meant(both, frozenset({"no_upper_body"}), False) and not _meant(both, frozenset({"none"}), False)
    assert not _meant(both, frozenset({"no_upper_body"}), True)  # a recording's own attribute is one text
    assert _by_reason({both: 2, "no_upper_body": 3, "none": 4}) == {
        "possible_duplicate": 2, "no_upper_body": 5, "none": 4,
    }  # fmt: skip


# Results folders


def _recording(path: Path) -> None:
    whole, legs = _people(2), _legs_alone()
    persons = [
        np.concatenate([people.keypoints_px[k], people.scores[k][:, None]], axis=1)
        for people, k in ((whole, 0), (whole, 1), (legs, 0))
    ]
    persons[2][:, 0] += 600
    listed = [
        {
            "keypoints": np.where(p[:, 2:] > 0, p, 0.0).tolist(),
            "box": [*p[:, :2].min(axis=0) - 20, *p[:, :2].max(axis=0) + 20],
        }
        for p in persons
    ]
    camera = {"fx": 1000, "fy": 1000, "cx": 600, "cy": 400}
    images = [
        {"filename": f"{name}.jpg", "width": 1200, "height": 800, "camera": camera, "people": listed[:n]}
        for name, n in (("a", 3), ("b", 2))
    ]
    path.write_text(json.dumps({"skeleton": "coco17", "images": images}))


@pytest.fixture(scope="module")
def out(tmp_path_factory: pytest.TempPathFactory) -> Path:
    here = tmp_path_factory.mktemp("doubts")
    _recording(here / "people.json")
    assert (
        main(["measure", "--pose", f"recorded:{here / 'people.json'}", "--out", str(here / "out"), "--jobs", "0"]) == 0
    )
    return here / "out"


def _rows(folder: Path, name: str) -> list[dict[str, str]]:
    with (folder / name).open(newline="") as file:
        return list(csv.DictReader(file))


def test_tables_state_the_doubts_of_people_and_of_both_of_a_pair(out: Path) -> None:
    assert [row[DOUBT] for row in _rows(out, "people.csv")] == ["none", "none", "no_upper_body", "none", "none"]
    pairs = [(r["photo"], r["doubt_a"], r["doubt_b"]) for r in _rows(out, "pairs.csv")]
    assert pairs == [
        ("a.jpg", "none", "none"), ("a.jpg", "none", "no_upper_body"), ("a.jpg", "none", "no_upper_body"),
        ("b.jpg", "none", "none"),
    ]  # fmt: skip


def test_counts_cards_and_figures_tell(out: Path, capsys: pytest.CaptureFixture[str]) -> None:
    counts = totals(Folder(str(out)))
    assert (counts.people, counts.duplicates, counts.doubtful) == (5, 0, 1)
    cards = index.cards(Results.open(out))
    assert [card.doubts for card in cards] == [1, 0]
    scene = next(Results.open(out).scenes())
    assert index.card_of(scene).doubts == 1 and "1 of them doubtful" in scene._repr_html_()
    plots = pytest.importorskip("proxemetry.plots.pair_selection")
    assert [plots.number_text(scene, i) for i in range(3)] == ["0", "1", "2?"]
    assert "2: legs without a body above" in plots.footnote(scene, [])
    assert main(["measure", "--pose", f"recorded:{out.parent / 'people.json'}", "--out", str(out), "--jobs", "0"]) == 0
    assert "in doubt: 1 may not be a person (animals, posters, legs alone); see doubt in" in capsys.readouterr().out


def test_pairs_where_takes_doubts(out: Path) -> None:
    sure, every = (summarise(Results.open(out), where=w).groups[0] for w in (PairsWhere.parsed(["doubt=none"]), None))
    assert (every.n_people, every.n_pairs) == (5, 4) and (sure.n_people, sure.n_pairs) == (4, 2)
    (doubtful,) = summarise(Results.open(out), where=PairsWhere.parsed(["doubt=NO_upper_body"])).groups
    assert (doubtful.n_people, doubtful.n_pairs) == (1, 0)
    with pytest.raises(SettingsError, match=r"no person has it; 'doubt' is none \(4 people\), no_upper_body"):
        counted(Folder(str(out)), PairsWhere.parsed(["doubt=other_class"]))


def test_the_report_counts_them(out: Path) -> None:
    pytest.importorskip("matplotlib")
    assert main(["report", str(out), "--photos", "0"]) == 0
    page = (out / "report.html").read_text()
    assert "People in doubt: perhaps not people, or counted twice" in page and "legs without a body above" in page


def test_results_from_before_the_column_are_read_and_say_nothing(out: Path, tmp_path: Path) -> None:
    """Parts and tables without the column: what they lack is empty."""
    old = tmp_path / "old"
    (old / "scenes").mkdir(parents=True)
    duck = connection()
    part = parts.name_of(0)
    fields = ", ".join(f"{c.name} := p.{c.name}" for c in TABLES["people"] if c.name not in ("photo", DOUBT))
    duck.execute(
        f"COPY (SELECT * REPLACE (list_transform(people, lambda p: struct_pack({fields}, attributes := p.attributes)) "
        f"AS people) FROM read_parquet({quoted(str(out / part))})) TO {quoted(str(old / part))} (FORMAT parquet)"
    )
    duck.execute(
        f"COPY (SELECT * EXCLUDE ({DOUBT}) FROM read_parquet({quoted(str(out / 'people.parquet'))})) "
        f"TO {quoted(str(old / 'people.parquet'))} (FORMAT parquet)"
    )
    folder = Folder(str(old))
    every = duck.execute(f"SELECT unnest(people).doubt FROM {parts.every_row(folder)}").fetchall()
    assert every == [(None,)] * 3
    assert duck.execute(f"SELECT doubt, person FROM {stored(folder, 'people')}").fetchall() == [
        (None, p) for p in (0, 1, 2, 0, 1)
    ]
    with pytest.raises(SettingsError, match="no person has it"):
        counted(folder, PairsWhere.parsed(["doubt=none"]))


def test_columns_that_are_missing_are_empty_behind_the_others() -> None:
    duck = connection()
    rows = with_columns("(SELECT 1 AS b, 'x' AS a)", [Column("a", "VARCHAR", "", ""), Column("c", "DOUBLE", "", "")])
    answer = duck.execute(f"SELECT * FROM {rows}")
    assert [d[0] for d in answer.description] == ["b", "a", "c"] and answer.fetchall() == [(1, "x", None)]


def test_a_scene_keeps_doubtful_people_and_their_distances(out: Path) -> None:
    scene = next(Results.open(out).scenes())
    assert isinstance(scene, Scene) and scene.bodies.placed.all()
    assert scene.people.rivals == (None,) * 3  # a recording states no classes: none speaks against its people
    assert np.isfinite(scene.distances_m[0, 2]) and scene.doubts == ((), (), (PersonDoubt.NO_UPPER_BODY,))


# One person twice in one photo


def _twice(aside: float = 0.0, resized: float = 1.0, pose: float = 0.0) -> People:
    """A person and the same one aside by a part of the square root of the box's area, resized, in another pose."""
    one = _people()
    x0, y0, x1, y1 = one.boxes_px[0]
    size = np.sqrt((x1 - x0) * (y1 - y0))
    points, middle = one.keypoints_px[0], one.keypoints_px[0].mean(axis=0)
    other = middle + resized * (points - middle) + (aside * size, 0) + pose * size * np.sin(np.arange(17))[:, None]
    box = np.array([*(middle - resized * (middle - (x0, y0))), *(middle + resized * ((x1, y1) - middle))])
    boxes = np.stack([one.boxes_px[0], box + np.tile((aside * size, 0), 2)])
    return People(COCO_17, np.stack([points, other]), np.full((2, 17), 0.8), boxes, np.array([0.9, 0.7]))


@pytest.mark.parametrize(
    ("people", "is_one"),
    [
        (_twice(0.3), True),
        (_twice(0.33), True),
        (_twice(0.35), False),
        (_twice(0.3, 1.14), True),
        (_twice(0.29, 1 / 1.14), True),
        (_twice(0.28, 1.16), False),
        (_twice(0.28, 1 / 1.16), False),
        (_twice(0.3, pose=0.3), False),
    ],
)
def test_a_person_moved_aside_in_the_same_pose_may_be_one_twice(people: People, is_one: bool) -> None:
    assert similarity(people)[0, 1] < POSSIBLY_SAME  # what lies on the spot is told already
    assert possible_duplicates(people).tolist() == [False, is_one]
    assert (moved_aside(people) == [[False, is_one], [is_one, False]]).all()


@pytest.mark.parametrize(
    ("people", "is_one"),
    [
        (_twice(0.16, 1.14), True),
        (_twice(0.16, 1.16), False),
        (_twice(0.16, 1 / 1.16), False),
        (_twice(0.1, 1.16), True),
    ],
)
def test_a_smaller_person_close_behind_is_another_even_where_they_overlap(people: People, is_one: bool) -> None:
    assert similarity(people)[0, 1] > POSSIBLY_SAME
    assert possible_duplicates(people).tolist() == [False, is_one]


def test_few_joints_are_alike_in_many() -> None:
    people = _twice(0.3)
    points = people.keypoints_px.copy()
    points[:, 7:] = np.nan
    assert not moved_aside(People(COCO_17, points, people.scores, people.boxes_px)).any()


@given(st.floats(0.1, 10), st.tuples(st.floats(-1e3, 1e3), st.floats(-1e3, 1e3)), st.booleans())
def test_where_and_how_large_a_photo_is_makes_no_difference(factor: float, by: tuple[float, float], turn: bool) -> None:
    people = _twice(0.32, 1.1)
    points, boxes = people.keypoints_px * factor + by, people.boxes_px * factor + np.tile(by, 2)
    order = [1, 0] if turn else [0, 1]
    moved = People(COCO_17, points, people.scores, boxes, people.person_scores)[order]
    assert moved_aside(moved).tolist() == [[False, True], [True, False]]
    assert possible_duplicates(moved).tolist() == (np.array([False, True])[order]).tolist()
    assert moved_aside(People.none(COCO_17)).shape == (0, 0)
