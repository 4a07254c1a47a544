"""Attributes of recorded people: kept as text, in the tables, and in what counts as a pair."""

import csv
import json
import sys
import zipfile

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from proxemetry.archive.figures.frames import read_results
from proxemetry.archive.figures.summary import summarise
from proxemetry.archive.store.results import Results
from proxemetry.cli import main
from proxemetry.errors import KeypointsError, SettingsError
from proxemetry.people import People
from proxemetry.people.attributes import (
    LONGEST_KEY,
    LONGEST_VALUE,
    MOST_KEYS,
    PairsWhere,
    attributes_of,
    compared,
    most_frequent,
)
from proxemetry.people.skeleton import COCO_17
from proxemetry.pose.formats import read
from proxemetry.scene import Scene
from proxemetry.tables import PREFIX, TABLES, rows
from synthetic.scenes import Recipe, scenes

VALUES = ("no", "yes", False, None, "=cmd|'/c calc'!A0", {"a": [1, 2]}, 3.0)


@pytest.mark.parametrize(
    ("stated", "kept"),
    [
        (None, {}),
        ({}, {}),
        ({"Mask": " no "}, {"mask": "no"}),
        ({"mask": True, "hat": False}, {"mask": "true", "hat": "false"}),
        ({"age": 30, "x": 30.0, "y": 0.5, "z": 10**400}, {"age": "30", "x": "30", "y": "0.5", "z": "inf"}),
        ({"gone": None, "nan": float("nan"), "blank": "  "}, {}),
        ({"said": "one\r\ntwo\t\0three\u202e"}, {"said": "one two three"}),
        ({"nested": {"b": [1, {"c": None}], "a": "ü"}}, {"nested": '{"a":"ü","b":[1,{"c":null}]}'}),
        ({"photo": "x", "=1+1": "y", "Ключ": "да"}, {"photo": "x", "=1+1": "y", "ключ": "да"}),
    ],
)
def test_attributes_are_kept_as_text(stated, kept):
    assert attributes_of(stated) == kept


@pytest.mark.parametrize(
    ("stated", "said"),
    [
        (["mask"], "not list"),
        ({1: "x"}, "must be a text"),
        ({"": "x"}, "0 characters"),
        ({"\0 ": "x"}, "0 characters"),
        ({"k" * (LONGEST_KEY + 1): "x"}, f"1 to {LONGEST_KEY}"),
        ({"k": "x" * (LONGEST_VALUE + 1)}, f"{LONGEST_VALUE:,} at most"),
        ({"k": [list(range(2000))]}, "at most"),
        ({"Mask": "a", "mask": "b"}, "twice"),
        ({str(k): "x" for k in range(MOST_KEYS + 1)}, f"{MOST_KEYS} at most"),
        ({"k": "\ud800"}, "half of a character"),
        ({"\ud800": "x"}, "half of a character"),
        ({"k": object()}, "write a text or a number"),
    ],
)
def test_attributes_that_no_table_holds_are_one_line(stated, said):
    with pytest.raises(KeypointsError, match=said) as caught:
        attributes_of(stated)
    assert len(str(caught.value)) < 200 and "\n" not in str(caught.value)


def test_deep_nesting_is_one_line():
    deep = []
    for _ in range(sys.getrecursionlimit() * 50):
        deep = [deep]
    with pytest.raises(KeypointsError):
        attributes_of({"k": deep})


@given(
    st.dictionaries(
        st.text(max_size=8), st.one_of(st.text(max_size=30), st.booleans(), st.floats(), st.integers()), max_size=5
    )
)
def test_whatever_is_kept_is_kept_the_same_again(stated):
    try:
        kept = attributes_of(stated)
    except KeypointsError:
        return
    assert attributes_of(kept) == kept
    assert json.loads(json.dumps(kept)) == kept
    assert all(PairsWhere.parsed([f"{k}={v}"]).holds(kept) for k, v in kept.items() if "=" not in k)


def test_values_are_compared_by_what_they_mean():
    assert compared("No") == compared("false") == compared(" FALSE ") and compared("yes") == compared("True")
    assert compared("30") == compared("30.0") == compared("3e1") != compared("31")
    assert compared("nan") == "nan"


def test_conditions_on_two_attributes_both_hold_and_of_one_either_does():
    where = PairsWhere.parsed(["mask=no", "mask=unknown", "Hat=1"])
    assert where.holds({"mask": "No", "hat": "1.0"}) and where.holds({"mask": "unknown", "hat": "1"})
    assert not where.holds({"mask": "no"}) and not where.holds({"mask": "yes", "hat": "1"})
    assert str(where) == "mask=no or unknown, hat=1"
    assert PairsWhere.parsed([]) is None


@pytest.mark.parametrize("text", ["", "mask", "mask=", "=no", " = ", "\0=x", "k" * 99 + "=x"])
def test_a_condition_that_is_none_is_one_line(text):
    with pytest.raises(SettingsError, match="write ATTRIBUTE=VALUE, like mask=no"):
        PairsWhere.parsed([text])


def test_a_track_is_what_most_of_its_sightings_are():
    assert most_frequent([{"mask": "no"}, {"mask": "yes"}, {"mask": "no", "hat": "1"}, {}]) == {
        "mask": "no",
        "hat": "1",
    }
    assert most_frequent([{"mask": "yes"}, {"mask": "no"}]) == {"mask": "no"}


def test_people_carry_attributes_along():
    people = People(COCO_17, np.ones((3, 17, 2)), np.ones((3, 17)), attributes=[{"mask": "no"}, {}, {"mask": "yes"}])
    assert people[[2, 0]].attributes == ({"mask": "yes"}, {"mask": "no"})
    assert people[np.array([True, False, True])].attributes == ({"mask": "no"}, {"mask": "yes"})
    assert people.scaled(2, 2).mirrored(10).attributes == people.attributes
    assert People.none(COCO_17).attributes == ()
    with pytest.raises(KeypointsError, match="2 entries for 3 people"):
        People(COCO_17, np.ones((3, 17, 2)), np.ones((3, 17)), attributes=[{}, {}])


def _write_keypoints(path, extra=lambda n: {}):
    content, n = {"skeleton": "coco17", "images": []}, 0
    for photo in scenes(6, 5, Recipe(kind="eye_level", focal_mm=(35.0,))):
        c, people = photo.camera, []
        for points, scores in zip(photo.people.keypoints_px, photo.people.scores, strict=True):
            triples = [
                [float(x), float(y), float(s)] if s > 0 else [0, 0, 0] for (x, y), s in zip(points, scores, strict=True)
            ]
            said = {"mask": VALUES[n % len(VALUES)], "=1+1": "@x", "a\"b'c;--": n, **extra(n)}
            people.append({"keypoints": triples, "attributes": said})
            n += 1
        camera = {"fx": c.fx, "fy": c.fy, "cx": c.cx, "cy": c.cy}
        size = {"filename": photo.name, "width": c.width, "height": c.height}
        content["images"].append({**size, "camera": camera, "people": people})
    path.write_text(json.dumps(content))


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    here = tmp_path_factory.mktemp("attributes")
    _write_keypoints(here / "people.json")
    assert (
        main(["measure", "--pose", f"recorded:{here / 'people.json'}", "--out", str(here / "out"), "--jobs", "0"]) == 0
    )
    return here / "out"


def _rows(folder, name):
    with (folder / name).open(newline="") as file:
        return list(csv.DictReader(file))


def test_attributes_are_columns_of_people_and_pairs(folder):
    people, pairs = _rows(folder, "people.csv"), _rows(folder, "pairs.csv")
    wanted = ["", "no", "yes", "false", "", "'=cmd|'/c calc'!A0", '{"a":[1,2]}', "3"]
    assert [r["attr_mask"] for r in people[:7]] == wanted[1:]
    assert {r["attr_=1+1"] for r in people} == {"'@x"}
    of = {(r["photo"], r["person"]): r["attr_a\"b'c;--"] for r in people}
    assert len(pairs) > 20
    for row in pairs:
        for end in "ab":
            assert row[f"attr_a\"b'c;--_{end}"] == of[row["photo"], row[f"person_{end}"]]
    listed = _rows(folder, "codebook.csv")
    assert [r["column"] for r in listed if r["column"].startswith(PREFIX)].count("attr_mask_a") == 1
    assert not any(c.name.startswith(PREFIX) for columns in TABLES.values() for c in columns)


def test_frames_scenes_and_exports_have_them_too(folder, capsys):
    pytest.importorskip("pandas")
    found = read_results(folder)
    assert found.people["attr_mask"].tolist()[:3] == ["no", "yes", "false"]
    assert "=cmd" in found.people["attr_mask"][4]  # no apostrophe where nothing is run
    scene = next(Results.open(folder).scenes())
    assert isinstance(scene, Scene) and scene.people.attributes[0]["mask"] == "no"
    assert scene.people_frame()["attr_mask"][0] == "no"
    assert scene.pairs_frame()["attr_mask_b"][0] == "yes"
    assert rows("pairs", scene, ["mask"])[0]["attr_mask_a"] == "no"
    pyreadstat = pytest.importorskip("pyreadstat")
    assert main(["export", str(folder), "--format", "spss"]) == 0
    frame, meta = pyreadstat.read_sav(folder / "people.sav")
    assert frame["attr_mask"][0] == "no"
    odd = [name for name, label in meta.column_names_to_labels.items() if "=1+1" in label]
    assert odd[0].startswith("attribute_") and frame[odd[0]][0] == "@x"


def test_what_a_recording_said_goes_out_and_comes_back(tmp_path):
    _write_keypoints(tmp_path / "people.json")
    content = json.loads((tmp_path / "people.json").read_text())
    content["images"][0]["people"][0] |= {"depth_m": 4.5, "depth_sd_m": 0.2}
    (tmp_path / "people.json").write_text(json.dumps(content))
    out = tmp_path / "out"
    assert main(["measure", "--pose", f"recorded:{tmp_path / 'people.json'}", "--out", str(out), "--jobs", "0"]) == 0
    assert main(["export", str(out), "--format", "coco"]) == 0
    before, after = read(tmp_path / "people.json").photos, read(out / "coco_keypoints.json").photos
    for one, other in zip(before, after, strict=True):
        assert one.people.attributes == other.people.attributes
        np.testing.assert_array_equal(one.people.depth_m, other.people.depth_m)
    assert before[0].people.depth_m[0] == 4.5


def test_workbooks_have_them_and_run_nothing(folder):
    pytest.importorskip("xlsxwriter")
    assert main(["export", str(folder), "--format", "xlsx"]) == 0
    with zipfile.ZipFile(folder / "results.xlsx") as packed:
        people = packed.read("xl/worksheets/sheet2.xml").decode()
    assert "attr_mask" in people and "=cmd|" in people and "<f>" not in people


def test_pairs_where_counts_pairs_both_of_whose_people_match(folder):
    people, pairs = _rows(folder, "people.csv"), _rows(folder, "pairs.csv")
    (summary,) = summarise(Results.open(folder), where=PairsWhere.parsed(["mask=no"])).groups
    matching = [r for r in people if r["attr_mask"] in ("no", "false")]
    both = [r for r in pairs if r["attr_mask_a"] in ("no", "false") and r["attr_mask_b"] in ("no", "false")]
    assert summary.n_people == len(matching) and summary.n_pairs == len(both) > 0
    nearest = {}
    for r in both:
        for end in "ab":
            key = r["photo"], r[f"person_{end}"]
            nearest[key] = min(nearest.get(key, 99.0), float(r["distance_m"]))
    assert summary.nearest_m.value == pytest.approx(np.median(list(nearest.values())))
    (every,) = summarise(Results.open(folder)).groups
    assert every.n_people == len(people) and every.n_pairs == len(pairs) and every.n_photos == summary.n_photos


@pytest.mark.parametrize(
    ("texts", "said"),
    [
        (["hat=1"], "no person has an attribute 'hat'; there are =1"),
        (["mask=perhaps"], "no person has it; 'mask' is "),
        (["mask=no", "photo=x"], "no person has an attribute 'photo'"),
        (["mask"], "write ATTRIBUTE=VALUE"),
    ],
)
def test_what_nobody_has_is_one_line(folder, texts, said, capsys):
    options = [option for text in texts for option in ("--pairs-where", text)]
    for command in ("summary", "report"):
        assert main([command, str(folder), *options]) == 2
        (line,) = capsys.readouterr().err.strip().splitlines()
        assert said in line


def test_results_without_attributes_say_so(tmp_path, capsys):
    from synthetic.small_photos import write_photos

    photos = write_photos(tmp_path / "photos", 1)
    pose = "python:synthetic.small_photos:two_people"
    assert main(["measure", str(photos), "--pose", pose, "--out", str(tmp_path / "out"), "--jobs", "0"]) == 0
    capsys.readouterr()
    assert main(["summary", str(tmp_path / "out"), "--pairs-where", "mask=no"]) == 2
    assert "no person has attributes there" in capsys.readouterr().err
    assert PREFIX not in (tmp_path / "out" / "people.csv").read_text()


def test_the_report_says_whose_pairs_it_counts(folder, tmp_path):
    pytest.importorskip("matplotlib")
    page = tmp_path / "report.html"
    arguments = ["report", str(folder), "--out", str(page), "--photos", "0"]
    assert main([*arguments, "--pairs-where", "mask=<b>", "--pairs-where", "mask=no"]) == 0
    text = page.read_text()
    assert "Only people with mask=&lt;b&gt; or no count" in text and "mask=<b>" not in text
    assert "two people both with" in text
    assert main(arguments) == 0 and "Only people recorded" not in page.read_text()


def test_very_many_attributes_are_not_so_many_columns(tmp_path, capsys):
    _write_keypoints(tmp_path / "people.json", lambda n: {f"id {n} {k}": k for k in range(20)})
    out = tmp_path / "out"
    assert main(["measure", "--pose", f"recorded:{tmp_path / 'people.json'}", "--out", str(out), "--jobs", "0"]) == 0
    header = (out / "people.csv").read_text().splitlines()[0]
    assert header.count(PREFIX) == 100 and "attr_mask" in header
