"""The focal length from people: exact where nothing is random, silent where geometry says nothing."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from proxemetry.camera import Camera
from proxemetry.camera.choice import choose_camera
from proxemetry.camera.focal import FocalRequest
from proxemetry.camera.from_people import focal_profile
from proxemetry.camera.from_people.focal_profile import Profile
from proxemetry.camera.from_people.self_calibration import WIDEST, calibrate, focal_posterior
from proxemetry.camera.from_people.verticals import (
    LEAN_SD,
    STATURE_CV,
    direct_solutions,
    residuals_of,
    segments_of,
    tops_of,
)
from proxemetry.people import People
from proxemetry.people.skeleton import COCO_17
from proxemetry.photo import Photo

WIDTH, HEIGHT = 1800, 1200
#: Joints over the ankles' middle, metres to the right and up, as long as the calibration takes an adult to be.
FIGURE = {
    "left_ear": (0.07, 0.895), "right_ear": (-0.07, 0.895), "left_shoulder": (0.17, 0.775),
    "right_shoulder": (-0.17, 0.775), "left_hip": (0.10, 0.49), "right_hip": (-0.10, 0.49), "left_knee": (0.10, 0.24),
    "right_knee": (-0.10, 0.24), "left_ankle": (0.10, 0.0), "right_ankle": (-0.10, 0.0),
}  # fmt: skip
PLACES = ((-2.0, 5.0), (1.8, 6.0), (0.2, 8.0), (-1.0, 10.0), (2.5, 11.0), (0.9, 4.5))


def crowd(
    f_px: float, pitch_deg: float, places: tuple[tuple[float, float], ...] = PLACES, *, height_m: float = 2.8,
    noise_px: float = 0.0, stature_cv: float = 0.0, seed: int = 0,
) -> People:  # fmt: skip
    """Return people who stand at (right, ahead) metres from under a camera, facing it."""
    rng, pitch = np.random.default_rng(seed), math.radians(pitch_deg)
    up = np.array([0.0, -math.cos(pitch), -math.sin(pitch)])
    ahead = np.array([0.0, -math.sin(pitch), math.cos(pitch)])
    camera = Camera.centred(f_px, WIDTH, HEIGHT)
    keypoints = np.full((len(places), len(COCO_17), 2), np.nan)
    for row, (x, z) in enumerate(places):
        foot = x * np.array([1.0, 0.0, 0.0]) + z * ahead - height_m * up
        stature = 1.7 * (1 + stature_cv * rng.normal())
        for joint, (right, above) in FIGURE.items():
            point = foot + stature * (right * np.array([1.0, 0.0, 0.0]) + above * up)
            keypoints[row, COCO_17.joints.index(joint)] = camera.project(point) + rng.normal(0, noise_px, 2)
    return People(COCO_17, keypoints, np.where(np.isfinite(keypoints[..., 0]), 0.9, 0.0))


@pytest.mark.parametrize("pitch_deg", [5, 12, 30, -8])
@pytest.mark.parametrize("f_px", [900.0, 2500.0])
def test_three_equal_people_give_the_focal_length_directly(f_px: float, pitch_deg: float) -> None:
    height_m = 0.3 if pitch_deg < 0 else 2.8
    segments = segments_of(crowd(f_px, pitch_deg, PLACES[:3], height_m=height_m), WIDTH, HEIGHT)
    (log_f,), ((pitch, roll, log_ratio, *_),) = direct_solutions(segments, np.arange(3)[None])
    assert math.exp(log_f) * WIDTH == pytest.approx(f_px, rel=1e-6)
    assert math.degrees(pitch) == pytest.approx(pitch_deg, abs=1e-4) and roll == pytest.approx(0, abs=1e-6)
    assert math.exp(log_ratio) == pytest.approx(1.7 / height_m, rel=1e-5)


def test_triples_are_solved_each_for_itself() -> None:
    segments = segments_of(crowd(1500, 12, noise_px=1), WIDTH, HEIGHT)
    triples = np.array([[0, 1, 2], [3, 4, 5], [1, 2, 4]])
    log_f, parameters = direct_solutions(segments, triples)
    alone = [direct_solutions(segments, triple[None]) for triple in triples]
    assert log_f == pytest.approx(np.concatenate([found[0] for found in alone]))
    assert parameters == pytest.approx(np.vstack([found[1] for found in alone]))


SMALL = st.floats(-0.3, 0.3)
LENGTH = 0.9


def top(log_f: float, values: np.ndarray) -> np.ndarray:
    """Where someone's top is by plain projection; values: the five parameters, foot, lean to the side and ahead."""
    pitch, roll, log_ratio, cx, cy, u, v, sideways, onwards = values
    f, sin, cos = math.exp(log_f), math.sin, math.cos
    up = np.array([sin(roll) * cos(pitch), -cos(roll) * cos(pitch), -sin(pitch)])
    side = np.array([cos(roll), sin(roll), 0.0])
    ray = np.array([(u - cx) / f, (v - cy) / f, 1.0])
    foot = -ray / (up @ ray)  # one camera height under the camera
    x, y, z = foot + LENGTH * math.exp(log_ratio) * (up + sideways * side + onwards * np.cross(up, side))
    return np.array([cx + f * x / z, cy + f * y / z])


@given(st.floats(-1.2, 2.3), st.floats(0.02, 0.5), SMALL, st.floats(-2.0, 0.2), st.tuples(SMALL, SMALL, SMALL, SMALL))
def test_tops_and_their_derivatives_are_those_of_plain_projection(
    log_f: float, pitch: float, roll: float, log_ratio: float, places: tuple[float, ...]
) -> None:
    values = np.array([pitch, roll, log_ratio, *places[:2], places[2], 0.3 + places[3], 0.0, 0.0])
    found = tops_of(values[None, 5:7], np.array([LENGTH]), np.array([log_f]), values[None, :5])
    derivatives = np.concatenate([found.by_parameter, found.by_foot, found.by_lean])[..., 0, 0]
    at = found.at[:, 0, 0]
    if at[0] == 10.0:  # no camera shows such a person, however little is moved
        assert not derivatives.any()
        return
    assert at == pytest.approx(top(log_f, values), rel=1e-6, abs=1e-9)
    step = 1e-6
    numeric = [(top(log_f, values + e) - top(log_f, values - e)) / (2 * step) for e in step * np.eye(9)]
    assert derivatives == pytest.approx(np.array(numeric), rel=1e-3, abs=1e-5 * (1 + np.abs(derivatives).max() ** 2))


def test_residuals_are_whitened_by_what_scatters_them() -> None:
    segments = segments_of(crowd(1500, 12, noise_px=3), WIDTH, HEIGHT)
    log_f, at = np.log([0.8, 0.9]), np.array([[0.2, 0.01, -0.5, 0.0, 0.001]] * 2)
    scatter = np.array([0.4, 1.6])
    white, log_det = residuals_of(segments, log_f, at, scatter)
    residual, jacobian = white[0], white[1:]
    tops = tops_of(segments.feet, segments.lengths, log_f, at)
    for g, factor in enumerate(scatter):
        for n in range(len(segments.rows)):
            foot, lean = tops.by_foot[:, :, g, n], tops.by_lean[:, :, g, n]
            stature = tops.by_parameter[2, :, g, n] * STATURE_CV
            covariance = factor**2 * (foot.T @ foot * segments.feet_sd[n] ** 2 + lean.T @ lean * LEAN_SD**2)
            covariance += factor**2 * np.eye(2) * segments.tops_sd[n] ** 2 + np.outer(stature, stature)
            off = tops.at[:, g, n] - segments.tops[n]
            assert (residual[:, g, n] ** 2).sum() == pytest.approx(off @ np.linalg.solve(covariance, off))
            assert log_det[g, n] == pytest.approx(np.linalg.slogdet(covariance)[1])
            slope = tops.by_parameter[:, :, g, n] @ np.linalg.solve(covariance, off)
            assert jacobian[:, :, g, n] @ residual[:, g, n] == pytest.approx(slope)


@pytest.mark.parametrize("sd", [0.03, 0.5])
def test_quantiles_of_a_normal_density_are_those_of_tables(sd: float) -> None:
    def profile(log_f: np.ndarray) -> Profile:
        costs = np.tile(((log_f - 0.31) / sd) ** 2 / 2, (4, 1)) + 700  # far down where densities underflow
        return Profile(log_f, costs, np.zeros((4, len(log_f), 5)))

    whole = profile(np.linspace(-2, 3, 26)).with_finer(profile(np.linspace(-0.1, 0.7, 33)))
    assert (np.diff(whole.log_f) > 0).all() and len(whole.log_f) == 26 - 4 + 33
    expected = 0.31 + sd * np.array([-1.6449, 0, 1.6449])
    assert whole.quantiles() == pytest.approx(tuple(expected), abs=0.03 * sd + 0.002)


def test_the_posterior_holds_the_truth() -> None:
    posterior = focal_posterior(crowd(1500, 20, noise_px=2, stature_cv=0.046), WIDTH, HEIGHT)
    assert not isinstance(posterior, str)
    assert posterior.low_px < 1500 < posterior.high_px
    assert math.degrees(posterior.pitch_rad) == pytest.approx(20, abs=4)
    assert posterior.upright.all()


def test_what_is_found_becomes_a_camera() -> None:
    estimate = calibrate(crowd(1500, 20), WIDTH, HEIGHT)
    camera = estimate.camera
    assert camera is not None and camera.f_px == pytest.approx(1500, rel=0.03)
    assert str(camera.source) == "estimated from people: 6 upright, camera pitched 20 degrees"
    assert 1.645 * camera.focal_rel_sd <= math.log1p(WIDEST)
    assert (camera.cx, camera.cy) == (WIDTH / 2, HEIGHT / 2)
    (candidate,) = estimate.candidates
    assert candidate.source == camera.source and any("px" in flag.text for flag in estimate.flags)


@pytest.mark.parametrize("seed", range(4))
def test_a_level_camera_says_nothing_of_its_focal_length(seed: int) -> None:
    estimate = calibrate(crowd(1500, 0, height_m=1.6, noise_px=3, stature_cv=0.046, seed=seed), WIDTH, HEIGHT)
    assert estimate.camera is None and "too wide" in (estimate.reason or "")
    assert len(estimate.candidates) == 1  # what was found is kept


def test_too_few_people_are_told() -> None:
    for people in (People.none(COCO_17), crowd(1500, 20, PLACES[:2])):
        estimate = calibrate(people, WIDTH, HEIGHT)
        assert estimate.camera is None and "3 people are needed" in (estimate.reason or "")


def test_people_cut_off_or_bent_do_not_count() -> None:
    people = crowd(1500, 20)
    keypoints = people.keypoints_px.copy()
    keypoints[0, COCO_17.joints.index("left_ankle")] = np.nan
    keypoints[1, [COCO_17.joints.index(f"{side}_knee") for side in ("left", "right")]] += (150, 0)
    posterior = focal_posterior(People(COCO_17, keypoints, people.scores), WIDTH, HEIGHT)
    assert not isinstance(posterior, str)
    assert posterior.upright.tolist() == [False, False, True, True, True, True]


def test_somebody_on_a_chair_is_outvoted() -> None:
    people = crowd(1500, 20, (*PLACES, (-0.5, 6.5)), noise_px=1)
    keypoints = people.keypoints_px.copy()
    ankles = [COCO_17.joints.index(f"{side}_ankle") for side in ("left", "right")]
    keypoints[0, ankles] += (40, -130)  # feet drawn up
    keypoints[0, [COCO_17.joints.index(f"{side}_knee") for side in ("left", "right")]] = np.nan
    posterior = focal_posterior(People(COCO_17, keypoints, people.scores), WIDTH, HEIGHT)
    assert not isinstance(posterior, str)
    assert posterior.upright.tolist() == [False] + [True] * 6
    assert posterior.low_px < 1500 < posterior.high_px


def test_laws() -> None:
    """Order and mirroring change nothing; a photo twice as large has twice the focal length."""
    people = crowd(1500, 20, noise_px=2, stature_cv=0.046)
    first = focal_posterior(people, WIDTH, HEIGHT)
    turned = focal_posterior(people[[3, 1, 5, 0, 4, 2]], WIDTH, HEIGHT)
    mirrored = focal_posterior(people.mirrored(WIDTH), WIDTH, HEIGHT)
    assert not isinstance(first, str) and not isinstance(turned, str) and not isinstance(mirrored, str)
    assert turned.f_px == pytest.approx(first.f_px, rel=0.01)
    assert mirrored.f_px == pytest.approx(first.f_px, rel=0.01)
    large = focal_posterior(people.scaled(2, 2), 2 * WIDTH, 2 * HEIGHT)
    assert not isinstance(large, str)
    assert large.f_px == pytest.approx(2 * first.f_px, rel=0.05)  # a pixel of noise weighs less in a larger photo


def test_a_crop_is_not_trusted_to_be_centred() -> None:
    people = crowd(1500, 20)
    assert calibrate(people, WIDTH, HEIGHT).camera is not None
    whole, strip = focal_posterior(people, WIDTH, HEIGHT), focal_posterior(people, WIDTH, HEIGHT - 300)
    assert not isinstance(whole, str) and not isinstance(strip, str)
    assert strip.log_sd > 1.5 * whole.log_sd


def test_people_stand_between_metadata_and_an_assumption() -> None:
    photo, people = Photo("scan.tif", WIDTH, HEIGHT, ""), crowd(1500, 20)

    def source(request: FocalRequest, seen: People) -> str | None:
        camera = choose_camera(photo, seen, request, None, None).camera
        return camera and str(camera.source).partition(":")[0]

    of_people = "estimated from people"

    assert source(FocalRequest(), people) == of_people
    assert source(FocalRequest(assume=False), people) == of_people
    assert source(FocalRequest(), people[:2]) == "ASSUMED"
    assert source(FocalRequest(assume_fov_deg=60), people) == of_people
    assert source(FocalRequest(focal_px=1400), people) == "user"
    assert source(FocalRequest(assume_fov_deg=60), people[:2]) == "ASSUMED"
    estimate = choose_camera(photo, people[:2], FocalRequest(assume=False), None, None)
    assert estimate.camera is None
    assert "no focal length in the photo" in (estimate.reason or "")
    assert "3 people are needed" in (estimate.reason or "")


def test_a_focal_length_counts_by_how_wide_its_other_parameters_are(monkeypatch: pytest.MonkeyPatch) -> None:
    """Laplace: half the log determinant of the hessian, so that a sharp optimum counts less than a wide one as low."""
    segments = segments_of(crowd(1500, 12), WIDTH, HEIGHT)
    hessian = np.array([np.eye(5), 4 * np.eye(5), np.diag([1.0, 1, 1, 1, 9])])

    def settled(_segments, log_f, parameters, _scatter):
        tries = len(log_f) // 3
        fit = focal_profile._Fit(np.full(len(log_f), 2.0), np.tile(hessian, (tries, 1, 1)), np.zeros((len(log_f), 5)))
        return parameters, fit

    monkeypatch.setattr(focal_profile, "_refined", settled)
    scatters = len(focal_profile._SCATTER)
    found = focal_profile._profile(segments, np.array([0.0, 0.1, 0.2]), np.zeros((1, scatters, 3, 5)))
    for row in found.costs:
        assert row - row[0] == pytest.approx([0, 2.5 * math.log(4), math.log(3)])


def test_without_people_a_camera_is_pulled_to_what_is_usual() -> None:
    nobody = segments_of(crowd(1500, 12)[:0], WIDTH, HEIGHT)
    parameters = np.array([[0.3, 0.05, -0.2, 0.01, 0.02]])
    fit = focal_profile._fit(nobody, np.zeros(1), parameters, np.ones(1))
    assert fit.hessian[0] == pytest.approx(np.diag(np.diag(fit.hessian[0])))
    assert fit.slope[0] == pytest.approx(fit.hessian[0] @ parameters[0])
    assert fit.cost[0] == pytest.approx(0.5 * parameters[0] @ fit.hessian[0] @ parameters[0])


def test_the_finer_profile_lies_about_the_likeliest() -> None:
    segments = segments_of(crowd(1500, 20, noise_px=1), WIDTH, HEIGHT)
    log_f = np.linspace(math.log(0.5), math.log(2), 12)
    start = focal_profile.Pose(math.log(1500 / WIDTH), np.array([math.radians(20), 0, -0.5, 0, 0]), 1.0)
    coarse = focal_profile._profile(
        segments, log_f, np.repeat(start.with_focal(log_f)[None, None], len(focal_profile._SCATTER), axis=1)
    )
    fine = focal_profile.profile_around(segments, coarse)
    assert (fine.log_f[0] + fine.log_f[-1]) / 2 == pytest.approx(coarse.best.log_f)
    assert fine.log_f[0] < coarse.best.log_f < fine.log_f[-1] and (np.diff(fine.log_f) > 0).all()
    assert fine.costs.min() <= coarse.costs.min() + 1e-6


def test_a_foot_above_the_horizon_explains_nothing() -> None:
    """Of a level camera: below the horizon a top moves with everything, above it nothing moves it."""
    feet = np.array([[0.1, 0.2], [0.1, -0.2]])
    tops = tops_of(feet, np.array([0.9, 0.9]), np.zeros(1), np.array([[0.0, 0.0, math.log(0.6), 0.0, 0.0]]))
    assert np.abs(tops.by_foot[..., 0]).max() > 0.1 and np.abs(tops.by_parameter[..., 0]).max() > 0.1
    assert not tops.by_parameter[:3, ..., 1].any() and not tops.by_lean[..., 1].any()
