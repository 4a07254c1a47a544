"""Tracks that never move: how far a body strays is arithmetic, people move and what is held still does not."""

import csv
import json

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from proxemetry.cli import main
from proxemetry.clip import stillness
from proxemetry.clip.doubts import of_track, stays_put
from proxemetry.clip.placing import Placed
from proxemetry.clip.sightings import Sightings
from proxemetry.clip.stillness import LEAST_S, MOST_STRAYED, WINDOW_S, is_motionless, strayed_share
from proxemetry.people.doubts import OF_PHOTOS, PersonDoubt
from synthetic import clips

JOINTS, TALL_PX, STEP_S = 17, 100.0, 1.25
TIMES_S = np.arange(0.0, LEAST_S, STEP_S)
PER_WINDOW = round(WINDOW_S / STEP_S)


def standing(times_s=TIMES_S):
    """A body 100 px tall whose joints stay where they are, (n, 17, 2)."""
    body = np.stack([np.linspace(0, 30, JOINTS), np.linspace(0, TALL_PX, JOINTS)], axis=-1)
    return np.repeat(body[None], len(times_s), axis=0)


def moved(share_of_time, joints=JOINTS, by_px=5.0):
    """The same with its first joints elsewhere during the last windows, as a share of the time."""
    body = standing()
    body[round((1 - share_of_time) * len(TIMES_S)) :, :joints, 0] += by_px
    return body


def test_what_stays_has_not_strayed():
    assert strayed_share(TIMES_S, standing()) == 0.0
    assert is_motionless(TIMES_S, standing())


def test_a_body_has_strayed_as_far_as_it_went_for_a_fifth_of_the_time_or_more():
    assert strayed_share(TIMES_S, moved(1 / 3)) == pytest.approx(5 / TALL_PX)
    assert strayed_share(TIMES_S, moved(1 / 6)) == 0.0  # someone walked past
    assert not is_motionless(TIMES_S, moved(1 / 3))


def test_a_quarter_of_the_joints_moves_the_body():
    assert strayed_share(TIMES_S, moved(1 / 3, joints=5)) == pytest.approx(5 / TALL_PX)  # a head: nose, eyes and ears
    assert strayed_share(TIMES_S, moved(1 / 3, joints=4)) == 0.0


def test_the_limit_is_a_share_of_the_body():
    assert is_motionless(TIMES_S, moved(1 / 3, by_px=TALL_PX * MOST_STRAYED * 0.99))
    assert not is_motionless(TIMES_S, moved(1 / 3, by_px=TALL_PX * MOST_STRAYED * 1.01))


def test_single_frames_do_not_move_a_body():
    jumps = standing()
    jumps[:: 2 * PER_WINDOW] += 20.0  # one frame in four of every other window
    assert strayed_share(TIMES_S, jumps) == 0.0


@settings(max_examples=25)
@given(
    st.floats(0.1, 50), st.floats(-500, 500), st.permutations(list(range(JOINTS))), st.integers(0, 2**32 - 1)
)  # fmt: skip
def test_neither_the_picture_s_size_nor_the_place_nor_the_order_of_joints_matters(scale, shift, order, seed):
    body = standing() + np.random.default_rng(seed).normal(0, 1, (len(TIMES_S), JOINTS, 2))
    expected = strayed_share(TIMES_S, body)
    assert expected > 0
    assert strayed_share(TIMES_S + 17.0, (scale * body + shift)[:, order]) == pytest.approx(expected, rel=1e-6)


def test_sightings_for_less_than_three_minutes_say_nothing():
    short = TIMES_S[:-PER_WINDOW]
    assert not is_motionless(short, standing(short))
    gap = np.concatenate([TIMES_S[:60], TIMES_S[:60] + 200])  # seen for 150 of 275 s
    assert not is_motionless(gap, standing(gap))
    assert not is_motionless(np.zeros(0), np.zeros((0, JOINTS, 2)))


def test_with_few_joints_nothing_is_known():
    few = standing()
    few[:, 4:] = np.nan
    assert np.isnan(strayed_share(TIMES_S, few)) and not is_motionless(TIMES_S, few)
    seldom = standing()
    seldom[: 2 * len(TIMES_S) // 3, 4:] = np.nan  # seen in a third of the windows
    assert np.isnan(strayed_share(TIMES_S, seldom))
    seldom[len(TIMES_S) // 3 :, 4:] = standing()[len(TIMES_S) // 3 :, 4:]
    assert strayed_share(TIMES_S, seldom) == 0.0
    one_place = np.ones((len(TIMES_S), JOINTS, 2))
    assert np.isnan(strayed_share(TIMES_S, one_place)) and not is_motionless(TIMES_S, one_place)
    assert np.isnan(strayed_share(TIMES_S, np.full((len(TIMES_S), JOINTS, 2), np.nan)))


def test_noise_hides_no_movement_and_a_swaying_body_is_a_person_s():
    noise = np.random.default_rng(0).normal(0, 0.005 * TALL_PX, (len(TIMES_S), JOINTS, 2))
    assert is_motionless(TIMES_S, standing() + noise)
    swaying = standing()
    swaying[..., 0] += 0.03 * TALL_PX * np.sin(2 * np.pi * TIMES_S / 40)[:, None]
    assert not is_motionless(TIMES_S, swaying) and not is_motionless(TIMES_S, swaying + noise)


def test_a_track_is_told_by_its_own_rows_where_it_was_seen():
    empty = Sightings.of_places(0.0, np.zeros((2, 2)))
    walking = standing() + 3.0 * np.arange(len(TIMES_S))[:, None, None]
    frames = np.arange(len(TIMES_S))
    placed = [
        Placed(empty, "ok", None, 2, {}, keypoints_px=np.stack([a, b]).astype(np.float32))
        for a, b in zip(standing(), walking, strict=True)
    ]
    first, second = np.zeros(len(frames), dtype=int), np.ones(len(frames), dtype=int)
    assert stays_put(frames, TIMES_S, first, placed) and not stays_put(frames, TIMES_S, second, placed)
    bridged = np.where(frames % 3 == 0, -1, 0)
    assert stays_put(frames, TIMES_S, bridged, placed)
    assert not stays_put(frames, TIMES_S, np.full(len(frames), -1), placed)
    boxes = [Placed(empty, "ok", None, 2, {}) for _ in frames]  # of boxes alone no joints are known
    assert not stays_put(frames, TIMES_S, first, boxes)


def test_it_is_the_last_reason_of_a_track_and_of_no_photo():
    legs = PersonDoubt.NO_UPPER_BODY
    assert of_track([(legs,), (legs,), ()], True) == (legs, PersonDoubt.MOTIONLESS)
    assert of_track([()], True) == (PersonDoubt.MOTIONLESS,) and of_track([()], False) == ()
    assert of_track([], True) is None
    assert PersonDoubt.MOTIONLESS not in OF_PHOTOS and len(OF_PHOTOS) == len(PersonDoubt) - 1


def test_a_statue_among_people_is_marked(tmp_path, monkeypatch):
    monkeypatch.setattr(stillness, "LEAST_S", 15.0)
    frames, step = 13, 1.25
    t = np.arange(frames)[:, None] * step
    statue, waiting = (
        np.hstack([0 * t + 2, 0 * t + 13]),
        np.hstack([-2 + 0.3 * np.sin(t / 3), 10 + 0.1 * np.cos(t / 4)]),
    )
    clips.write_video(tmp_path / "square.avi", frames, 1 / step)
    names = [f"square.avi#t={k * step:.3f}" for k in range(frames)]
    clips.recorded(tmp_path / "k.json", names, np.stack([statue, waiting], axis=1))
    clips.mount().write(tmp_path / "camera.json")
    out = tmp_path / "out"
    told = ["--mount", str(tmp_path / "camera.json"), "--detections", f"recorded:{tmp_path / 'k.json'}"]
    assert main(["video", str(tmp_path / "square.avi"), "--out", str(out), "--jobs", "0", "--fps", "0.8", *told]) == 0
    with (out / "people.csv").open(newline="") as file:
        people = list(csv.DictReader(file))
    assert sorted(p["doubt"] for p in people) == ["motionless", "none"]
    (marked,) = [p["track"] for p in people if p["doubt"] == "motionless"]
    with (out / "tracks.csv").open(newline="") as file:
        rows = [r for r in csv.DictReader(file) if r["track"] == marked]
    assert np.mean([float(r["y_m"]) for r in rows]) == pytest.approx(13, abs=0.5)
    assert {r["doubt"] for r in rows} == {"none"}  # no single frame shows it
    assert any(
        n.startswith("1 of 2 tracks may not be people") for n in json.loads((out / "summary.json").read_text())["notes"]
    )
