"""The noise law: what it promises for every score, joint and size."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from benchmarks.networks.hand_labels import Pair
from benchmarks.networks.keypoint_noise import beside, fitted, lengths
from proxemetry.anthropometry import LENGTHS
from proxemetry.camera import Camera
from proxemetry.locate import LocateSettings
from proxemetry.locate.scenefit import evidence as evidence_module
from proxemetry.locate.scenefit import locate
from proxemetry.locate.scenefit.body_model import body_model
from proxemetry.locate.scenefit.evidence import evidence_of
from proxemetry.locate.scenefit.hypotheses import body_types, keypoint_precision
from proxemetry.locate.scenefit.projection import N_SHARED, PITCH
from proxemetry.people import People
from proxemetry.people.keypoint_noise import (
    UNMEASURED_ALIKE,
    UNMEASURED_TOO_LEVEL_DEG,
    NoiseLaw,
    apparent_stature_px,
    law_for,
    law_of,
    laws,
    people_sd_px,
)
from proxemetry.people.skeleton import BLAZEPOSE_33, COCO_17, SKELETONS
from proxemetry.pose import BACKENDS
from synthetic.modelled import ADULTS, CAMERA, photo

SCORES = st.floats(0.01, 1.0)
SIZES = st.floats(10, 5000)


@given(st.sampled_from(sorted(laws())), st.sampled_from(COCO_17.joints), SCORES, SCORES, SIZES)
def test_a_surer_joint_is_never_worse(source: str, joint: str, one: float, other: float, body_px: float) -> None:
    low, high = sorted((one, other))
    assert law_of(source).sd_px(joint, high, body_px) <= law_of(source).sd_px(joint, low, body_px)


@given(st.sampled_from(COCO_17.joints), SCORES, SIZES, st.floats(1, 10))
def test_noise_grows_with_the_body_but_never_faster(joint: str, score: float, body_px: float, factor: float) -> None:
    near, far = law_of("coco17").sd_px(joint, score, body_px * factor), law_of("coco17").sd_px(joint, score, body_px)
    assert far * (1 - 1e-12) <= near <= far * factor * (1 + 1e-12)


def test_the_law_in_numbers() -> None:
    law = NoiseLaw({"hip": 0.03, "other": 0.5}, {"hip": 0.01, "other": 0.5}, 1.0, 5.0, "made up")
    # score 0.25 makes the spread four times as large: 400 px * hypot(0.03, 0.04) = 20 px beside the floor's 5 px
    assert law.sd_px("left_hip", 0.25, 400) == pytest.approx(np.hypot(20, 5))
    assert law.sd_px("mid_hip", 1.0, 2) == pytest.approx(np.hypot(5, np.hypot(1, 1))), "not listed: as others"
    assert law.sd_px("right_hip", 0.05, 400) == law.sd_px("right_hip", 0.1, 400), "it was measured above a tenth"


def test_a_missing_joint_has_no_noise() -> None:
    assert np.isnan(law_of("coco17").sd_px("nose", 0.0, 300))


def test_unknown_sources_and_joints_get_the_default() -> None:
    assert law_of("no-such-back-end") is laws()["default"]
    assert law_of("no-such-back-end", "body25") is laws()["body25"]
    assert law_of("default").sd_px("left_thumb", 0.5, 100) == law_of("default").sd_px("other", 0.5, 100)


def test_every_skeleton_is_listed_and_every_row_says_where_it_is_from() -> None:
    assert set(SKELETONS) <= set(laws())
    assert all(law.origin for law in laws().values())


def _standing(stature_px: float, seen: list[str]) -> People:
    """A 1.70 m person facing the camera, drawn at `stature_px`."""
    heights_m = {
        "nose": 1.57, "left_eye": 1.60, "right_eye": 1.60, "left_ear": 1.58, "right_ear": 1.58, "left_shoulder": 1.40,
        "right_shoulder": 1.40, "left_elbow": 1.12, "right_elbow": 1.12, "left_wrist": 0.86, "right_wrist": 0.86,
        "left_hip": 0.88, "right_hip": 0.88, "left_knee": 0.48, "right_knee": 0.48, "left_ankle": 0.08,
        "right_ankle": 0.08,
    }  # fmt: skip
    side = {"shoulder": 0.175, "hip": 0.09, "eye": 0.032}
    points = np.full((1, 17, 2), np.nan)
    for k, joint in enumerate(COCO_17.joints):
        if joint in seen:
            x = side.get(joint.split("_")[-1], 0.1) * (1 if joint.startswith("left") else -1)
            points[0, k] = np.array([x, -heights_m[joint]]) * stature_px / 1.70
    return People(COCO_17, points, np.where(np.isfinite(points[..., 0]), 1.0, 0.0))


@pytest.mark.parametrize(
    "seen",
    [list(COCO_17.joints), ["left_shoulder", "right_shoulder", "left_hip", "right_hip"], ["left_knee", "left_ankle"]],
)
def test_apparent_stature_is_near_the_truth_from_any_part(seen: list[str]) -> None:
    assert apparent_stature_px(_standing(500, seen))[0] == pytest.approx(500, rel=0.05)


def test_of_who_shows_no_limb_the_boxs_longer_side_is_the_stature() -> None:
    face = _standing(500, ["nose"])
    boxes = np.array([[100.0, 50, 160, 350]]), np.array([[100.0, 50, 900, 350]])
    assert [apparent_stature_px(replace(face, boxes_px=box))[0] for box in boxes] == [300, 800]


def test_a_limb_that_looks_short_is_turned_and_the_longest_counts() -> None:
    people = _standing(500, ["left_shoulder", "right_shoulder", "left_hip", "right_hip", "left_knee"])
    turned = people.keypoints_px * (0.2, 1)  # seen from the side, where shoulders tell nothing
    implied = 500 / 1.70 * np.array([(1.40 - 0.88) * 1.70 / 0.52, (0.88 - 0.48) * 1.70 / 0.42])
    assert apparent_stature_px(replace(people, keypoints_px=turned))[0] == pytest.approx(implied.max(), rel=2e-3)


def test_the_sd_of_peoples_joints_is_the_laws_at_their_score_and_apparent_stature() -> None:
    people = _standing(500, list(COCO_17.joints))
    people = replace(people, scores=np.linspace(0.2, 0.9, 17)[None])
    law, body_px = law_for(people), apparent_stature_px(people)[0]
    expected = [law.sd_px(joint, people.scores[0, k], body_px) for k, joint in enumerate(COCO_17.joints)]
    assert people_sd_px(people)[0] == pytest.approx(np.ravel(expected))


def test_people_sd_has_a_number_for_every_seen_joint() -> None:
    sd = people_sd_px(_standing(500, ["nose", "left_shoulder", "right_shoulder", "left_hip", "right_hip"]))
    assert sd.shape == (1, 17)
    assert np.isfinite(sd).sum() == 5
    assert people_sd_px(People.none(COCO_17)).shape == (0, 17)


def _seen_by(name: str) -> People:
    """A person of the row's skeleton, every joint at another score, seen by its back end where it is one's."""
    skeleton = SKELETONS.get(name, BLAZEPOSE_33 if name == "blazepose" else COCO_17)
    points = np.random.default_rng(1).uniform(100, 900, (1, len(skeleton), 2))
    scores = np.linspace(0.2, 0.9, len(skeleton))[None]
    return People(skeleton, points, scores, source="" if name in SKELETONS else name)


@pytest.mark.parametrize("name", sorted(set(laws()) - {"default"}))
def test_every_row_reaches_the_scene_fit(name: str) -> None:
    assert name in SKELETONS or name in BACKENDS
    law, people = laws()[name], _seen_by(name)
    model = body_model(people.skeleton)
    evidence = evidence_of(people, Camera.centred(800, 1000, 1000), model)
    joints = [people.skeleton.joints[column] for column in model.columns]
    scores = people.scores[:, model.columns]
    assert evidence.score_noise == pytest.approx(law.score_noise(joints, scores))
    assert (evidence.seen == (scores >= law.lowest_score)).all()
    assert evidence.resolution == pytest.approx(max(law.floor_px, 4e-4 * np.hypot(1000, 1000)) / 800)
    assert dict(zip(LENGTHS, evidence.lengths, strict=True)) == {
        length: (law.scale.get(length, 1.0), law.common.get(length, 0.0)) for length in LENGTHS
    }
    assert {*law.scale, *law.common} <= set(LENGTHS)
    assert evidence.from_above == pytest.approx(law.grows_from_above(joints))
    assert evidence.alike == law.alike


@given(st.floats(-0.5, 1.2), st.floats(-0.3, 0.3), st.floats(0.1, 6))
def test_noise_grows_with_the_sine_of_the_angle_from_above(pitch: float, down: float, growth: float) -> None:
    """One person, seen `down` below the optical axis of a camera that looks down by `pitch`."""
    people, camera = _standing(5, list(COCO_17.joints)), Camera.centred(1000, 1000, 1000)
    seen = people.keypoints_px - np.nanmean(people.keypoints_px, axis=(0, 1)) + (500, 500 + 1000 * np.tan(down))
    evidence = evidence_of(replace(people, keypoints_px=seen), camera, body_model(COCO_17))
    evidence = replace(evidence, from_above=np.full(evidence.seen.shape[1], growth), resolution=0.0)
    exact = replace(body_model(COCO_17), spread=np.zeros(evidence.seen.shape[1]))
    shared = np.zeros(N_SHARED)
    shared[PITCH] = pitch
    level = keypoint_precision(evidence, exact, np.ones(1))
    factor = level[evidence.seen] / keypoint_precision(evidence, exact, np.ones(1), shared)[evidence.seen]
    assert factor == pytest.approx(1 + growth * max(np.sin(pitch + down), 0.0), rel=0.03)


def test_who_is_seen_from_above_by_a_back_end_is_less_sure_and_no_nearer_to_level() -> None:
    """Of the same joints on a camera that looks down by 29 degrees; at eye level nothing changes."""
    for pitch, widened in ((0.5, True), (0.0, False)):
        people, _ = photo(3, pitch=pitch, height_m=3.0 if widened else 1.6, depths_m=(4, 6))
        plain = laws()["coco17"]
        above = replace(plain, from_above={"other": 2.0})
        sd = []
        for law in (plain, above):
            with pytest.MonkeyPatch.context() as patch:
                patch.setattr(evidence_module, "law_for", lambda _people, law=law: law)
                bodies = locate(people, CAMERA, ADULTS)
            assert bodies.floor is not None
            sd.append((bodies.floor.pitch_sd_rad, bodies.position_sd_m[:, 2].mean()))
        assert (np.array(sd[1]) > 1.01 * np.array(sd[0])).all() == widened
        assert np.array(sd[1]) == pytest.approx(np.array(sd[0]), rel=1.5 if widened else 0.1)


def test_who_was_seen_by_a_detector_that_nobody_measured_is_less_sure() -> None:
    people, _ = photo(3)
    assert law_for(people).alike == 1.0
    assert law_for(replace(people, source="yolox-tinypose")).alike == laws()["yolox-tinypose"].alike > 1
    recorded = replace(people, source="recorded")
    assert law_for(recorded) == replace(
        laws()["coco17"], alike=UNMEASURED_ALIKE, too_level_deg=UNMEASURED_TOO_LEVEL_DEG
    )
    exact, seen = (locate(p, CAMERA, ADULTS) for p in (people, recorded))
    assert seen.positions_m == pytest.approx(exact.positions_m, abs=0.03)  # seen from 3 degrees above
    assert (seen.position_sd_m[:, 2] > exact.position_sd_m[:, 2]).all()
    assert exact.floor is not None and seen.floor is not None
    assert exact.floor.pitch_sd_rad < seen.floor.pitch_sd_rad < UNMEASURED_ALIKE**0.5 * exact.floor.pitch_sd_rad


def test_lengths_seen_otherwise_change_the_bodies_that_are_looked_for() -> None:
    plain, seen = (body_types("adults", 0.0, as_seen)[0] for as_seen in ((), ((1.0, 0.0),) * 2 + ((0.9, 0.1),) * 4))
    assert seen.mean - plain.mean == pytest.approx([0, 0, *[np.log(0.9)] * 4])
    wider = np.linalg.inv(seen.precision) - np.linalg.inv(plain.precision)
    assert wider == pytest.approx(np.diag([0, 0, *[0.01] * 4]), abs=1e-9)


def test_a_shrunken_torso_is_no_distant_person() -> None:
    """Who is known to be seen with short torsos and narrow shoulders is not put farther away for it."""
    people = _standing(500, [*(f"{s}_shoulder" for s in ("left", "right")), *(f"{s}_hip" for s in ("left", "right"))])
    points = people.keypoints_px + (500, 700)
    camera = Camera.centred(800, 1000, 1000)
    plain, known = (
        locate(People(COCO_17, points, people.scores, source=source), camera, LocateSettings("adults"))
        for source in ("", "blazepose")
    )
    assert known.positions_m[0, 2] < plain.positions_m[0, 2]
    assert known.position_sd_m[0, 2] > plain.position_sd_m[0, 2]


def test_the_benchmark_finds_the_law_again() -> None:
    rng = np.random.default_rng(3)
    law = NoiseLaw({"other": 0.0}, {"eye": 0.004, "shoulder": 0.008, "other": 0.012}, 1.6, 1.0, "made up")
    joints = ["left_eye", "right_shoulder", "left_knee"] * 700
    score, body_px = rng.uniform(0.3, 1, len(joints)), np.exp(rng.uniform(3.5, 7, len(joints)))
    sd = [float(law.sd_px(joint, s, b).item()) / b for joint, s, b in zip(joints, score, body_px, strict=True)]
    found = fitted(joints, score, body_px, rng.standard_t(5, (len(joints), 2)) * np.array(sd)[:, None])
    assert found.score_power == pytest.approx(1.6, abs=0.21)
    assert found.floor_px == pytest.approx(1.0, abs=0.31)
    for kind, expected in (("eye", 0.004), ("shoulder", 0.008), ("knee", 0.012)):
        assert found.spread[kind] == pytest.approx(expected, rel=0.15)


def test_lengths_tell_what_all_people_and_what_each_has_in_common() -> None:
    rng = np.random.default_rng(4)
    law = NoiseLaw({"other": 0.0}, {"other": 0.01}, 1.0, 0.0, "made up")
    truth = _standing(500, list(COCO_17.joints))
    found: list[Pair] = []
    for _ in range(300):
        width = 0.9 * (1 + rng.normal(0, 0.1))
        wider = np.array([width if "shoulder" in joint else 1.0 for joint in COCO_17.joints])
        points = truth.keypoints_px * np.stack([wider, np.ones(17)], axis=1) + rng.normal(0, 5, (1, 17, 2))
        found.append(Pair("", truth, 0, People(COCO_17, points, truth.scores), 0, 500.0))
    rows = {name: (ratio, common) for name, _, ratio, _, common in lengths(found, law)}
    assert rows["shoulders"] == pytest.approx((0.9, 0.09), abs=0.025)
    assert rows["torso"] == pytest.approx((1.0, 0.0), abs=0.02)


def test_two_back_ends_beside_each_other_show_how_much_of_the_errors_is_the_labels() -> None:
    rng = np.random.default_rng(5)
    exact = _standing(500, list(COCO_17.joints)).keypoints_px
    one: list[Pair] = []
    other: list[Pair] = []
    for k in range(200):
        label, seen, again = (
            People(COCO_17, exact + rng.normal(0, sd, exact.shape), np.ones(exact.shape[:2])) for sd in (8, 6, 3)
        )
        one.append(Pair(f"{k}", label, 0, seen, 0, 500.0))
        other.append(Pair(f"{k}", label, 0, again, 0, 500.0))
    for _, count, spreads, share, error in beside(one, other[50:]):
        assert count in (5 * 150, 2 * 150, 4 * 150)
        assert spreads == pytest.approx(np.hypot([8, 8, 6], [6, 3, 3]) / 500, rel=0.1)
        assert share == pytest.approx(0.64, abs=3 * error) and 0.005 < error < 0.1
