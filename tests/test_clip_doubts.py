"""Doubts about whole tracks of a clip: what most frames say, in the tables, in the notes and in conditions on pairs."""

import csv
import json

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from proxemetry.cli import main
from proxemetry.clip.doubts import counts, of_most, of_sightings, require_some
from proxemetry.clip.placing import Placed
from proxemetry.clip.sightings import Sightings
from proxemetry.errors import SettingsError
from proxemetry.people.attributes import PairsWhere
from proxemetry.people.doubts import PersonDoubt
from synthetic import clips

DUPLICATE, OTHER, LEGS = PersonDoubt.POSSIBLE_DUPLICATE, PersonDoubt.OTHER_CLASS, PersonDoubt.NO_UPPER_BODY
STEP, FRAMES = 0.2, 12


def test_a_track_has_the_doubts_that_more_than_half_of_its_sightings_have():
    assert of_most([(LEGS,), (LEGS,), ()]) == (LEGS,)
    assert of_most([(LEGS,), ()]) == ()  # half is not most
    assert of_most([(LEGS, OTHER), (OTHER,), (DUPLICATE,)]) == (OTHER,)
    assert of_most([]) is None  # nothing was asked


@given(st.lists(st.sets(st.sampled_from(list(PersonDoubt))), min_size=1, max_size=9), st.randoms())
def test_neither_the_order_of_frames_nor_how_many_there_are_makes_a_difference(sets, random):
    sightings = [tuple(d for d in PersonDoubt if d in s) for s in sets]
    mixed = sightings * 3
    random.shuffle(mixed)
    assert of_most(mixed) == of_most(sightings)


def test_what_bridges_a_gap_has_no_doubts_of_its_own():
    seen = Sightings.of_places(0.0, np.zeros((2, 2)))
    placed = [Placed(seen, "ok", None, 2, {}, (), ((LEGS,), ())), Placed(seen, "ok", None, 2, {})]
    frames, rows = np.array([0, 0, 0, 1]), np.array([0, 1, -1, 0])
    assert of_sightings(frames, rows, placed) == [(LEGS,), (), None, None]


def where(*texts):
    found = PairsWhere.parsed(texts)
    assert found is not None
    return found


@pytest.mark.parametrize(
    ("reasons", "none", "legs"),
    [((), True, False), ((LEGS,), False, True), ((DUPLICATE, LEGS), False, True), ((OTHER,), False, False),
     (None, False, False)],
)  # fmt: skip
def test_tracks_are_chosen_by_any_of_their_doubts(reasons, none, legs):
    assert counts(where("doubt=none"), {}, reasons) is none
    assert counts(where("doubt=no_upper_body"), {}, reasons) is legs
    assert not counts(where("doubt=none", "mask=no"), {}, reasons)
    assert counts(where("doubt=none", "mask=no"), {"mask": "no"}, reasons) is none


def test_an_attribute_of_the_same_name_is_the_attribute():
    assert counts(where("doubt=much"), {"doubt": "much"}, ())
    assert not counts(where("doubt=none"), {"doubt": "much"}, ())
    require_some(where("doubt=much"), [({"doubt": "much"}, ())])


def test_what_no_track_has_is_one_line():
    tracks = [({}, ()), ({}, (LEGS, OTHER)), ({}, ())]
    require_some(where("doubt=other_class"), tracks)
    with pytest.raises(SettingsError, match=r"'doubt' is none \(2 people\), no_upper_body"):
        require_some(where("doubt=possible_duplicate"), tracks)
    with pytest.raises(SettingsError, match="no person has attributes there"):
        require_some(where("doubt=none"), [({}, None)])


def table(folder, name):
    with (folder / f"{name}.csv").open(newline="") as file:
        return list(csv.DictReader(file))


def test_legs_alone_in_most_frames_make_a_doubtful_track(tmp_path):
    clips.write_video(tmp_path / "walk.avi", FRAMES, 1 / STEP)
    apart = clips.walkers(FRAMES, STEP)[:, 1:]  # without one of two companions, who may be one person found twice
    clips.recorded(tmp_path / "k.json", [f"walk.avi#t={k * STEP:.3f}" for k in range(FRAMES)], apart)
    clips.mount().write(tmp_path / "camera.json")
    content = json.loads((tmp_path / "k.json").read_text())
    for k, image in enumerate(content["images"]):
        if k % 3:  # one frame in three shows the whole body, the others legs and hands
            image["people"][0].pop("box", None)
            for joint in image["people"][0]["keypoints"][:7]:
                joint[2] = 0.0
    (tmp_path / "k.json").write_text(json.dumps(content))
    out, arguments = tmp_path / "out", ["video", str(tmp_path / "walk.avi"), "--out", str(tmp_path / "out"), "--jobs"]
    arguments += ["0", "--mount", str(tmp_path / "camera.json"), "--detections", f"recorded:{tmp_path / 'k.json'}"]
    assert main(arguments) == 0
    people = table(out, "people")
    (legs,) = [p["track"] for p in people if p["doubt"] == "no_upper_body"]
    assert [p["doubt"] for p in people].count("none") == 2
    rows = {int(r["frame"]): r for r in table(out, "tracks") if r["track"] == legs}
    seen = {k: r["doubt"] for k, r in rows.items() if r["seen"] == "seen"}
    assert len(seen) > FRAMES / 2 and all(d == ("no_upper_body" if k % 3 else "none") for k, d in seen.items())
    assert all(not r["doubt"] for r in rows.values() if r["seen"] == "bridged")
    notes = json.loads((out / "summary.json").read_text())["notes"]
    assert any(n.startswith("1 of 3 tracks may not be people") for n in notes)
    assert main([*arguments, "--pairs-where", "doubt=none"]) == 0
    pairs = np.array([[p["track_a"], p["track_b"]] for p in table(out, "exposure")])
    assert len(pairs) == 1 and legs not in pairs
