"""The parts of the joint fit that weigh and spread: closed forms on equations written by hand, and laws."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from proxemetry.camera import Camera, Mount
from proxemetry.locate import LocateSettings
from proxemetry.locate.scenefit import contradiction, locate, shared_prior, solver
from proxemetry.locate.scenefit import fit as joint_fit
from proxemetry.locate.scenefit.alternatives import Cavity, Explanations, _better, _explanation, leave_one_out, refine
from proxemetry.locate.scenefit.body_model import body_model
from proxemetry.locate.scenefit.camera_prior import Place, Raised, SharedPrior
from proxemetry.locate.scenefit.contradiction import misfit
from proxemetry.locate.scenefit.evidence import evidence_of
from proxemetry.locate.scenefit.hypotheses import keypoint_precision, log_evidence
from proxemetry.locate.scenefit.posterior import (
    _TWIST_SD,
    _ambiguous,
    _covariance,
    _floor,
    _merged_spread,
    _modes,
    _normalised,
    _spread_square,
)
from proxemetry.locate.scenefit.projection import (
    DEPTH,
    FOCAL,
    HEADING,
    HEIGHT,
    N_LOCAL,
    N_SHARED,
    PITCH,
    ROLL,
    torso_position,
)
from proxemetry.locate.scenefit.solver import Fit, evaluate_rows, schur_complement
from proxemetry.locate.scenefit.start import initialise
from proxemetry.people import People
from proxemetry.people.keypoint_noise import law_for
from proxemetry.people.skeleton import COCO_17
from synthetic.modelled import ADULTS, CAMERA, photo

N = N_LOCAL + N_SHARED


def linear_fit(rows, seed=0):
    """Return a fit whose normal equations are made up, with what is known of the camera beforehand: unit Gaussians."""
    rng = np.random.default_rng(seed)
    roots = rng.normal(size=(rows, N, N))
    hessian = roots @ roots.transpose(0, 2, 1) + 0.1 * np.eye(N)
    normal = np.concatenate([hessian, rng.normal(size=(rows, N, 1))], axis=-1)
    prior_equations = np.column_stack([np.eye(N_SHARED), np.zeros(N_SHARED)])
    local = np.zeros((rows, N_LOCAL))
    return Fit(local, np.zeros(N_SHARED), normal, prior_equations, np.zeros(rows), 0.0, np.ones((rows, 1)))


def camera_of_all(fit, rows, prior):
    """Return mean and covariance of the camera from these rows and a prior precision (N_SHARED,), all solved whole."""
    size = len(rows) * N_LOCAL + N_SHARED
    whole, right = np.zeros((size, size)), np.zeros(size)
    whole[-N_SHARED:, -N_SHARED:] += np.diag(prior)
    for at, (h, g) in enumerate(zip(fit.hessian[rows], fit.gradient[rows], strict=True)):
        index = np.r_[at * N_LOCAL : (at + 1) * N_LOCAL, size - N_SHARED : size]
        whole[np.ix_(index, index)] += h
        right[index] += g
    covariance = np.linalg.inv(whole)
    return (covariance @ right)[-N_SHARED:], covariance[-N_SHARED:, -N_SHARED:]


def test_what_the_others_say_is_what_is_left_without_oneself():
    fit = linear_fit(4)
    cavity = leave_one_out(fit)
    for k in range(4):
        mean, covariance = camera_of_all(fit, np.delete(np.arange(4), k), np.ones(N_SHARED))
        assert cavity.mean[k] == pytest.approx(mean)
        assert np.linalg.inv(cavity.precision[k]) == pytest.approx(covariance)


def test_a_place_is_contradicted_in_units_of_what_people_and_place_leave_open_together():
    fit, sd = linear_fit(3), np.ones(N_SHARED)
    sd[PITCH] = np.inf
    place = Place(np.array([PITCH]), np.array([0.5]), np.array([[0.2**-2]]))
    # Student-t with 3 degrees of freedom at its middle, and Gaussians; of the pitch no more than a deviation of 1
    mean, covariance = camera_of_all(fit, np.arange(3), [4 / 3, 4 / 3, 4 / 3, 1, 1, 1])
    expected = abs(mean[PITCH] - 0.5) / np.sqrt(covariance[PITCH, PITCH] + 0.2**2)
    assert misfit(fit, SharedPrior(np.zeros(N_SHARED), sd, place)) == pytest.approx(expected)


def test_a_stated_depth_is_contradicted_in_units_of_what_it_and_all_else_leave_open(monkeypatch):
    """All else alone puts the person at one depth; the fit, which has the stated one in it, somewhere between."""
    fit, stated, sd, elsewhere = linear_fit(2), 2.0, 0.4, 0.09
    size = 2 * N_LOCAL + N_SHARED
    whole = np.zeros((size, size))
    whole[-N_SHARED:, -N_SHARED:] = fit.shared_normal[:, :-1]
    for k in range(2):
        index = np.r_[k * N_LOCAL : (k + 1) * N_LOCAL, 2 * N_LOCAL : size]
        whole[np.ix_(index, index)] += fit.hessian[k]
    variance, alone = np.linalg.inv(whole)[DEPTH, DEPTH], 0.5
    whole[DEPTH, DEPTH] += sd**-2
    between = alone + np.linalg.inv(whole)[DEPTH, DEPTH] * sd**-2 * (stated - alone)
    normal = fit.normal.copy()
    normal[0, DEPTH, DEPTH] += sd**-2
    local = fit.local.copy()
    local[0, DEPTH] = between
    rows = SimpleNamespace(depth_precision=np.array([1 / sd, 0.0]), log_depth=np.array([stated, np.nan]))
    monkeypatch.setattr(contradiction, "stated_depth_precision", lambda *_: np.array([sd**-2, 0.0]))
    monkeypatch.setattr(contradiction, "evaluate_rows", lambda *_: (normal, None, None))
    found = contradiction.depth_misfit(rows, replace(fit, local=local), np.array([elsewhere, elsewhere]))
    assert found[0] == pytest.approx((stated - alone) / np.sqrt(variance + sd**2 + elsewhere))
    assert np.isnan(found[1])


def test_a_mount_enters_the_fit_with_its_whole_covariance():
    rng = np.random.default_rng(0)
    root = 0.02 * rng.normal(size=(4, 4))
    rows = tuple(map(tuple, (root @ root.T + 1e-4 * np.eye(4)).tolist()))
    mount = Mount(0.2, -0.03, 3.0, covariance=rows, camera=CAMERA.with_focal(1.1 * CAMERA.f_px))
    place = shared_prior(CAMERA, mount).place
    assert place.which.tolist() == [PITCH, ROLL, HEIGHT, FOCAL]
    assert place.mean == pytest.approx([0.2, -0.03, np.log(3.0), np.log(1.1)])
    assert place.covariance == pytest.approx(np.array(rows), rel=1e-3, abs=1e-8)


def explanations(depths_m, precision=None, shared=None):
    rows = len(depths_m)
    local = np.zeros((rows, N_LOCAL))
    local[:, DEPTH] = np.log(depths_m)
    eye = np.tile(np.eye(N), (rows, 1, 1)) if precision is None else precision
    return Explanations(local, np.zeros((rows, N_SHARED)) if shared is None else shared, eye, eye, np.zeros(rows))


class Two:
    """Two rows of one person."""

    person = np.array([0, 0])
    prior_log_volume = np.zeros(2)


def test_an_explanation_that_is_no_mode_widens_the_covariance_by_its_weight():
    added = _merged_spread(Two, explanations([5.0, 5.4]), np.array([0.7, 0.3]), np.array([0]), {})
    assert added[0, 2, 2] == pytest.approx(0.3 * 0.4**2)
    assert _merged_spread(Two, explanations([5.0, 5.4]), np.array([0.7, 0.3]), np.array([0]), {0: [0, 1]})[0, 2, 2] == 0


def test_weights_are_each_persons_shares_of_the_evidence():
    weight = _normalised(np.array([0, 0, 1]), np.array([5 + np.log(3), 5.0, -700.0]), 2)
    assert weight == pytest.approx([0.75, 0.25, 1.0])


def test_the_evidence_of_a_sharp_explanation_is_less_by_its_volume():
    precision = np.stack([np.eye(N), 4 * np.eye(N)])  # twice as sharp in each of N unknowns
    plain, sharp = log_evidence(explanations([5.0, 5.0], precision), Two, np.zeros(2))
    assert plain - sharp == pytest.approx(N * np.log(2))


def test_an_explanation_costs_what_the_others_evidence_on_the_camera_costs_besides():
    """A Gaussian's half square, whose slope is the pull, and whose precision adds to the row's own."""
    fit = linear_fit(3, seed=4)
    cavity = leave_one_out(linear_fit(3, seed=5))
    shared = np.random.default_rng(6).normal(0, 0.3, (3, N_SHARED))
    cost = np.array([1.0, 2.0, 3.0])
    found, pull = _explanation(fit.local, shared, fit.normal, cost, cavity)
    for k in range(3):
        off = shared[k] - cavity.mean[k]
        assert found.cost[k] == pytest.approx(cost[k] + 0.5 * off @ cavity.precision[k] @ off)
        assert pull[k] == pytest.approx(-cavity.precision[k] @ off)  # downhill
        added = found.precision[k] - found.hessian[k]
        assert added[N_LOCAL:, N_LOCAL:] == pytest.approx(cavity.precision[k])
        assert not added[:N_LOCAL].any() and not added[:, :N_LOCAL].any()
    assert found.hessian == pytest.approx(fit.hessian)


def test_refined_explanations_lie_where_no_step_goes_down():
    """Both evidences together, the row's and the others', have no slope left there, though neither is at its best."""
    people, _ = photo(3, noise_px=1.5, pitch=0.15)
    seen = joint_fit.explained_people(people, CAMERA, shared_prior(CAMERA), ADULTS, body_model(COCO_17))
    assert seen is not None
    rows, shared = seen.rows.taken(seen.first), np.tile(seen.fit.shared, (len(seen.first), 1))
    aside = np.array([0.03, 0.01, -0.05, 0.0, 0.0, 0.0])
    known = np.diag([4e3, 4e3, 1e3, 1e6, 1e6, 1e6])
    cavity = Cavity(shared + aside, np.tile(known, (len(shared), 1, 1)))
    start = refine(rows, seen.fit.local, shared, cavity, steps=0)
    found = refine(rows, seen.fit.local, shared, cavity, steps=25)
    assert (found.cost <= start.cost).all()
    normal, _, _ = evaluate_rows(rows, found.local, found.shared)
    slope = normal[..., -1].copy()
    slope[:, N_LOCAL:] += (cavity.mean - found.shared) @ known
    step = np.linalg.solve(found.precision, slope[..., None])[..., 0]
    assert np.abs(step).max() < 2e-3
    assert np.abs(found.shared - shared).max() > 5e-3  # the others' evidence moved the camera


def test_of_two_explanations_each_row_keeps_its_better_one():
    a, b = explanations([3.0, 4.0, 5.0]), explanations([6.0, 7.0, 8.0], precision=np.tile(2 * np.eye(N), (3, 1, 1)))
    a, b = replace(a, cost=np.array([1.0, 5.0, 2.0])), replace(b, cost=np.array([2.0, 1.0, 2.5]))
    for better in (_better(a, b), _better(b, a)):
        assert np.exp(better.local[:, DEPTH]) == pytest.approx([3, 7, 5])
        assert better.cost.tolist() == [1, 1, 2]
        assert better.precision[:, 0, 0].tolist() == [1, 2, 1]
    assert _better(b, replace(a, cost=np.full(3, -1.0))).cost.tolist() == [-1, -1, -1]
    assert _better(replace(a, cost=np.full(3, 9.0)), b).cost.tolist() == b.cost.tolist()


@pytest.mark.parametrize(("apart_sd", "weight", "ambiguous"), [(1.4, 0.4, False), (1.6, 0.4, True), (1.6, 0.02, False)])
def test_explanations_that_put_a_person_elsewhere_stay_apart(apart_sd, weight, ambiguous):
    """Elsewhere is beyond one and a half deviations of depth of the vaguer of the two; the unlikely do not count."""
    sharp, vague = 100 * np.eye(N), 25 * np.eye(N)  # deviations of log depth of 0.1 and 0.2
    for precision in ((sharp, vague), (vague, sharp)):
        rows = explanations([5.0, 5.0 * np.exp(apart_sd * 0.2)], precision=np.stack(precision))
        found = _ambiguous(Two, rows, np.array([1 - weight, weight]), np.array([0]))
        assert found == ({0: [0, 1]} if ambiguous else {})


def test_each_persons_own_uncertainty_is_that_of_all_unknowns_solved_together():
    fit = linear_fit(2)
    size = 2 * N_LOCAL + N_SHARED
    whole = np.zeros((size, size))
    whole[-N_SHARED:, -N_SHARED:] = np.eye(N_SHARED)
    for k in range(2):
        index = np.r_[k * N_LOCAL : (k + 1) * N_LOCAL, 2 * N_LOCAL : size]
        whole[np.ix_(index, index)] += fit.hessian[k]
    inverse = np.linalg.inv(whole)
    local_sd, _, shared = _covariance(fit)
    assert local_sd**2 == pytest.approx(np.diag(inverse)[:-N_SHARED].reshape(2, N_LOCAL))
    assert shared == pytest.approx(inverse[-N_SHARED:, -N_SHARED:])


def test_the_floor_states_the_cameras_own_deviations():
    fit = replace(linear_fit(1), shared=np.array([0.2, -0.1, np.log(3.0), 0.0, 0.0, 0.0]))
    covariance = np.diag([0.02, 0.03, 0.04, 1.0, 1.0, 1.0]) ** 2
    floor = _floor(fit, covariance)
    assert floor is not None
    assert (floor.height_m, floor.pitch_rad, floor.roll_rad) == pytest.approx((3.0, 0.2, -0.1))
    assert (floor.height_sd_m, floor.pitch_sd_rad, floor.roll_sd_rad) == pytest.approx((0.12, 0.02, 0.03))
    assert _floor(fit, np.eye(N_SHARED)) is None  # nobody shows how far below the camera it is


def test_a_covariance_among_others_is_the_same_in_its_own_rows():
    values = np.arange(36.0).reshape(6, 6)
    found = _spread_square(values, 3, np.array([0, 2]))
    index = np.array([0, 1, 2, 6, 7, 8])
    assert found[np.ix_(index, index)].tolist() == values.tolist()
    assert np.isnan(found[3:6]).all() and np.isnan(found[:, 3:6]).all()


def test_who_cannot_be_placed_changes_nothing_for_the_others():
    people, _ = photo(5, pitch=0.1)
    nobody = People(COCO_17, np.full((1, 17, 2), np.nan), np.zeros((1, 17)))
    order = [0, 1, 4, 2, 3]
    keypoints = np.concatenate([people.keypoints_px, nobody.keypoints_px])[order]
    with_one = People(COCO_17, keypoints, np.concatenate([people.scores, nobody.scores])[order])
    plain, found = locate(people, CAMERA, ADULTS), locate(with_one, CAMERA, ADULTS)
    assert found.placed.tolist() == [True, True, False, True, True] and found.reasons[2]
    kept = np.array([0, 1, 3, 4])
    index = (3 * kept[:, None] + np.arange(3)).ravel()
    assert found.positions_m[kept] == pytest.approx(plain.positions_m)
    assert found.covariance_m2[np.ix_(index, index)] == pytest.approx(plain.covariance_m2)
    for name in ("heading_rad", "heading_sd_rad", "stature_m", "stature_sd_m"):
        assert getattr(found, name)[kept] == pytest.approx(getattr(plain, name)) and np.isnan(getattr(found, name)[2])
    assert np.isnan(found.covariance_m2[6:9]).all() and np.isnan(found.positions_m[2]).all()


def test_what_is_known_of_the_camera_alone_is_its_places_where_it_has_one():
    precision = np.array([[400.0, 30.0], [30.0, 25.0]])
    place = Place(np.array([PITCH, HEIGHT]), np.array([0.3, 1.0]), precision)
    prior = SharedPrior(np.arange(6.0), np.array([np.inf, 0.2, np.inf, 0.3, 0.4, 0.5]), place)
    assert prior.marginal_mean.tolist() == [0.3, 1.0, 1.0, 3.0, 4.0, 5.0]
    sd = np.sqrt(np.diag(np.linalg.inv(precision)))
    assert prior.marginal_sd == pytest.approx([sd[0], 0.2, sd[1], 0.3, 0.4, 0.5])
    assert place.widened(3.0).covariance == pytest.approx(9 * place.covariance)


def test_in_another_mode_the_others_follow_the_camera():
    fit = linear_fit(2)
    fit = replace(fit, local=fit.local + np.eye(N_LOCAL)[DEPTH] * np.log(6.0))
    shift = np.array([0.02, -0.01, 0.03, 0.0, 0.0, 0.0])
    rows = explanations([6.0, 4.0, 6.0], shared=np.stack([fit.shared, fit.shared + shift, fit.shared]))
    weights, first = np.array([0.6, 0.4, 1.0]), np.array([0, 2])
    best, other = _modes({0: [0, 1]}, rows, weights, first, fit)
    assert (best.weight, other.weight) == (pytest.approx(0.6), pytest.approx(0.4))
    assert best.positions_m == pytest.approx(torso_position(fit.local, fit.shared))
    # of the second person nothing but the camera changed: the normal equations say how it answers
    own, cross = fit.hessian[1, :N_LOCAL, :N_LOCAL], fit.hessian[1, :N_LOCAL, N_LOCAL:]
    follows = fit.local[1] - np.linalg.solve(own, cross @ shift)
    local = np.stack([rows.local[1], follows])
    assert other.positions_m == pytest.approx(torso_position(local, fit.shared + shift))


def test_what_people_who_err_alike_tell_of_the_camera_is_worth_less_beside_what_is_known_of_it():
    fit, alike = linear_fit(3), 3.0
    told = np.linalg.inv(schur_complement(fit.normal)[1][..., :-1].sum(axis=0))
    worse = np.where(np.arange(N_SHARED) < FOCAL, alike**0.5, 1.0)  # of the lens they tell what they did
    told *= np.outer(worse, worse)
    for known in (1.0, 1e9):  # beforehand: next to nothing, or all but the pitch itself
        beforehand = np.eye(N_SHARED) * 1e-6
        beforehand[PITCH, PITCH] = known
        equations = np.column_stack([beforehand, np.zeros(N_SHARED)])
        _, _, shared = _covariance(replace(fit, shared_normal=equations), alike)
        assert shared == pytest.approx(np.linalg.inv(np.linalg.inv(told) + beforehand), rel=1e-6, abs=1e-9)
    assert shared[PITCH, PITCH] == pytest.approx(1e-9, rel=1e-3)  # a stated pitch stays as stated
    assert _covariance(fit, 1.0)[1] == pytest.approx(_covariance(fit)[1])


@pytest.mark.parametrize("away_sd", [0.3, 1.0, 4.0])
def test_what_is_known_of_the_camera_pulls_as_its_cost_falls(away_sd):
    prior = replace(shared_prior(Camera.centred(1200, 1920, 1080, focal_rel_sd=0.05)), raised=None)
    shared = prior.mean + away_sd * prior.sd
    _, normal = prior.cost(shared)
    hessian, gradient = normal[:, :-1], normal[:, -1]
    step = 1e-6 * prior.sd
    for k in range(N_SHARED):
        nudge = step * np.eye(N_SHARED)[k]
        slope = (prior.cost(shared + nudge)[0] - prior.cost(shared - nudge)[0]) / (2 * step[k])
        assert gradient[k] == pytest.approx(-slope, rel=1e-4)
    # the hessian is that of the robust weight: the pull over how far it pulls, for tails and all
    assert np.diag(hessian) == pytest.approx(gradient / (prior.mean - shared))
    assert hessian == pytest.approx(np.diag(np.diag(hessian)))


def test_a_camera_far_from_usual_is_held_less_and_one_of_unsure_focal_length_as_much():
    prior = SharedPrior(np.zeros(N_SHARED), np.ones(N_SHARED))
    near, far = (np.diag(prior.cost(np.full(N_SHARED, z))[1][:, :-1]) for z in (0.0, 5.0))
    # Student-t with 3 degrees of freedom: (1 + 1 / 3) / (1 + z^2 / 3)
    assert near[[PITCH, HEIGHT]] == pytest.approx(4 / 3)
    assert far[[PITCH, HEIGHT]] == pytest.approx(4 / 3 / (1 + 25 / 3))
    assert far[FOCAL:] == pytest.approx(1.0)


def student(z: float) -> float:
    """Student's density with 3 degrees of freedom, up to its constant."""
    return (1 + z**2 / 3) ** -2


def test_some_cameras_are_raised_and_look_down():
    prior = SharedPrior(np.zeros(N_SHARED), np.ones(N_SHARED), raised=Raised(0.2, (4.0, 3.0), (2.0, 1.5)))
    shared = np.zeros((4, N_SHARED))
    shared[:, PITCH], shared[:, HEIGHT] = (0.0, 4.0, 4.0, 2.0), (0.0, 3.0, 0.0, 2.5)

    def density(pitch: float, height: float) -> float:
        level = 0.8 * student(pitch) * student(height)
        return level + 0.2 * student((pitch - 4) / 2) * student((height - 3) / 1.5) / (2 * 1.5)

    cost, normal = prior.cost(shared)
    expected = [-np.log(density(p, h) / 0.8) for p, h in shared[:, [PITCH, HEIGHT]]]
    assert cost == pytest.approx(expected)
    step = 1e-6 * np.eye(N_SHARED)
    slope = np.stack([(prior.cost(shared + s)[0] - prior.cost(shared - s)[0]) / 2e-6 for s in step], axis=-1)
    assert normal[..., -1] == pytest.approx(-slope, abs=1e-5)
    # in the middle of the raised ones hardly anything pulls down, and what does is eye level's share
    assert (np.linalg.eigvalsh(normal[..., :-1]) > 0).all()
    assert np.abs(normal[1, [PITCH, HEIGHT], -1]).max() < 0.1


def test_a_camera_that_looks_down_from_above_is_told_less_level_than_without_raised_ones(monkeypatch):
    people = photo(4, count=2, noise_px=0.0, pitch=0.4, height_m=2.8, depths_m=(4, 5))[0]
    raised = locate(people, CAMERA, ADULTS).floor
    beforehand = replace(shared_prior(CAMERA), raised=None)
    monkeypatch.setattr(joint_fit, "shared_prior", lambda *_: beforehand)
    level = locate(people, CAMERA, ADULTS).floor
    assert raised is not None and level is not None
    assert level.pitch_rad < raised.pitch_rad - 0.005
    assert abs(raised.pitch_rad - 0.4) < abs(level.pitch_rad - 0.4)


def test_a_stated_height_alone_tells_whether_a_camera_is_raised():
    sd = np.ones(N_SHARED)
    sd[HEIGHT] = np.inf
    place = Place(np.array([HEIGHT]), np.array([3.0]), np.array([[100.0]]))
    raised = Raised(0.2, (4.0, 3.0), (2.0, 0.5))
    shared = np.zeros(N_SHARED)
    shared[HEIGHT] = 3.0
    level, high = (SharedPrior(np.zeros(N_SHARED), sd, place, kind) for kind in (None, raised))
    shared[PITCH] = 4.0
    assert level.cost(shared)[1][PITCH, -1] < 2 * high.cost(shared)[1][PITCH, -1] < 0
    assert np.diag(high.cost(shared)[1])[HEIGHT] == pytest.approx(np.diag(level.cost(shared)[1])[HEIGHT])


def test_a_heading_that_swings_settles_by_halves(monkeypatch):
    seen = []

    def evaluated(rows, local, shared, prior):
        seen.append(local[0, HEADING])
        return Fit(local, shared, np.zeros((1, N, N + 1)), np.zeros((N_SHARED, N_SHARED + 1)), np.zeros(1), 0.0,
                   np.ones((1, 1)))  # fmt: skip

    def swinging(fit, *_):
        local = np.zeros((1, N_LOCAL))
        local[0, HEADING] = 0.2 if len(seen) % 2 else -0.2
        return local, np.full(N_SHARED, 0.05)

    monkeypatch.setattr(solver, "evaluate", evaluated)
    monkeypatch.setattr(solver, "_step", swinging)
    solver.solve(None, np.zeros((1, N_LOCAL)), np.zeros(N_SHARED), None, iterations=6)
    assert np.abs(np.diff(seen)) == pytest.approx(0.2 * 0.5 ** np.arange(6))


def test_a_floor_is_less_even_the_further_away(monkeypatch):
    solved = []

    def remembered(rows, local, *rest, **options):
        solved.append((rows.floor_precision, np.exp(local[:, DEPTH])))
        return solver.solve(rows, local, *rest, **options)

    monkeypatch.setattr(joint_fit, "solve", remembered)
    people, _ = photo(0, depths_m=(4, 40))
    locate(people, CAMERA, ADULTS)
    precision, depth_m = solved[0]
    # 4 cm, and 3 mm a metre of distance (METHOD: kerbs, slopes and cambered streets)
    assert precision == pytest.approx(1 / np.hypot(0.04, 0.003 * depth_m))
    assert np.ptp(depth_m) > 10


def test_no_heading_is_surer_than_trunks_twist():
    people, _ = photo(0, noise_px=0.1)
    stated = replace(people, heading_rad=np.zeros(4), heading_sd_rad=np.full(4, 0.01))
    assert (locate(stated, CAMERA, ADULTS).heading_sd_rad >= _TWIST_SD).all()


def test_a_crops_unknown_centre_moves_everyone_aside_by_its_share_of_the_depth():
    people, _ = photo(0, noise_px=0.1)
    known, unknown = (locate(people, replace(CAMERA, principal_sd_px=s), ADULTS) for s in (0.0, 120.0))
    aside = unknown.position_sd_m[:, 0] ** 2 - known.position_sd_m[:, 0] ** 2
    assert np.sqrt(aside) == pytest.approx(unknown.positions_m[:, 2] * 120 / CAMERA.f_px, rel=0.2)


def test_a_person_on_a_platform_that_nobody_stated_moves_the_others_little():
    people, _ = photo(5, count=8, noise_px=0.3)
    before, keypoints = locate(people, CAMERA, ADULTS), people.keypoints_px.copy()
    keypoints[0, :, 1] -= 1.0 * CAMERA.f_px / before.positions_m[0, 2]
    after = locate(People(COCO_17, keypoints, people.scores), CAMERA, ADULTS)
    assert after.positions_m[1:, 2] == pytest.approx(before.positions_m[1:, 2], rel=0.05)


@pytest.mark.parametrize("where", [(1, 500), (None, 500), (500, 1), (500, None)])
def test_every_edge_of_the_photo_is_one(where):
    """0.2 % of the diagonal from it is outside: 4 px of 1920 x 1080; half as much again from it is inside."""
    people, _ = photo(0)
    model, sides = body_model(COCO_17), (CAMERA.width, CAMERA.height)
    diagonal = np.hypot(*sides)
    for share, seen in ((0.0015, False), (0.003, True)):
        aside = share * diagonal
        at = [aside if w == 1 else side - aside if w is None else w for w, side in zip(where, sides, strict=True)]
        keypoints = people.keypoints_px.copy()
        keypoints[2, model.columns[0]] = at
        found = evidence_of(People(COCO_17, keypoints, np.full(people.scores.shape, 0.9)), CAMERA, model)
        assert found.seen[2, 0] == seen


def test_no_detector_resolves_less_than_a_share_of_the_photo():
    """Its own floor in pixels holds in small photos, 1 / 2500 of the diagonal in large ones."""
    people, _ = photo(0)
    model, floor = body_model(COCO_17), law_for(people).floor_px
    for factor in (0.2, 20.0):
        width, height = round(CAMERA.width * factor), round(CAMERA.height * factor)
        larger = evidence_of(people.scaled(factor, factor), CAMERA.resized(width, height), model)
        expected = max(4e-4 * np.hypot(width, height), floor)
        assert larger.resolution == pytest.approx(expected / CAMERA.f_px / factor, rel=1e-3)
        assert (expected > floor) == (factor > 1)


def test_keypoints_at_the_edge_or_scarcely_believed_are_no_evidence():
    people, _ = photo(0)
    model = body_model(COCO_17)
    keypoints, scores = people.keypoints_px.copy(), people.scores.copy()
    keypoints[0, model.columns[0]] = (0.5, 500)  # within 0.2 % of the diagonal from the edge
    scores[1, model.columns[1]] = 0.01
    evidence = evidence_of(People(COCO_17, keypoints, scores), CAMERA, model)
    expected = np.ones((4, len(model.columns)), dtype=bool)
    expected[0, 0] = expected[1, 1] = False
    assert np.array_equal(evidence.seen, expected & np.isfinite(people.keypoints_px[:, model.columns]).all(axis=-1))
    assert not evidence.points[0, 0].any()
    inside = evidence.seen[2]
    pixels = people.keypoints_px[2, model.columns][inside]
    assert evidence.points[2][inside] * CAMERA.f_px + (CAMERA.cx, CAMERA.cy) == pytest.approx(pixels)


def test_noise_grows_with_the_body_down_to_what_a_detector_resolves():
    people, _ = photo(0)
    model = body_model(COCO_17)
    evidence = evidence_of(people, CAMERA, model)
    tiny, large = (1 / keypoint_precision(evidence, model, np.full(4, scale)) for scale in (1e-9, 1e3))
    assert tiny[evidence.seen] == pytest.approx(evidence.resolution)
    share = np.hypot(model.spread, evidence.score_noise)
    assert large[evidence.seen] == pytest.approx(1e3 * share[evidence.seen])


def test_the_first_look_finds_depth_heading_and_pitch():
    people, truth = photo(3, noise_px=0.0, pitch=0.2)
    model = body_model(COCO_17)
    lengths = np.tile([1.70, 1.36, 0.51, 0.345, 0.063, 0.15], (4, 1))
    start = initialise(evidence_of(people, CAMERA, model), lengths, shared_prior(CAMERA), model, np.ones(4))
    posture, heading = np.divmod(start.cost.reshape(4, -1).argmin(axis=1), start.cost.shape[2])
    found = np.exp(start.log_depth[np.arange(4), posture, heading])
    assert found == pytest.approx(truth[:, 2], rel=0.12)
    assert start.shared[PITCH] == pytest.approx(0.2, abs=0.06)
    assert start.shared[HEIGHT] == pytest.approx(np.log(1.6), abs=0.25)


def test_off_the_floor_feet_say_nothing_of_the_others():
    people, _ = photo(0)
    alone = LocateSettings(body_size="adults", off_floor={0, 1, 2, 3})
    together, apart = locate(people, CAMERA, ADULTS), locate(people, CAMERA, alone)
    assert (apart.position_sd_m[:, 2] > together.position_sd_m[:, 2]).all()
