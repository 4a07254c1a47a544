"""People placed where the focal length is hardly known: several focal lengths held together."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from proxemetry.bodies import Bodies, Floor, Mode
from proxemetry.camera import Camera
from proxemetry.distances import measure_distances
from proxemetry.locate import LocateSettings, method_named, unsure_focal
from proxemetry.locate.scenefit import locate as fitted
from proxemetry.locate.unsure_focal import PITCHED_RAD, UNSURE_SD, locate
from synthetic.scenes import Recipe, SyntheticPhoto, scenes


@pytest.fixture(scope="module")
def level() -> SyntheticPhoto:
    """Return people before a level camera of 50 mm."""
    made = scenes(12, 3, Recipe(focal_mm=(50.0,)))
    return next(p for p in made if abs(p.pitch_rad) < PITCHED_RAD / 3 and len(p.people) >= 3 and p.kind != "elevated")


def test_a_focal_length_that_is_known_is_fitted_as_ever(level: SyntheticPhoto) -> None:
    bodies = method_named("scene")(level.people, level.camera, LocateSettings(), None)
    np.testing.assert_array_equal(bodies.positions_m, fitted(level.people, level.camera, LocateSettings()).positions_m)


@pytest.mark.parametrize("factor", [math.exp(-0.5), 1.0, math.exp(0.5)])
def test_depth_is_as_uncertain_as_the_focal_length(level: SyntheticPhoto, factor: float) -> None:
    """Whichever focal length is assumed, one standard deviation off: the true distances are inside."""
    camera = replace(level.camera.with_focal(level.camera.f_px * factor), focal_rel_sd=0.5)
    bodies = locate(level.people, camera, LocateSettings())
    assert sum(mode.weight for mode in bodies.modes) == pytest.approx(1)
    depth = bodies.position_sd_m[:, 2] / bodies.positions_m[:, 2]
    # depth goes with the focal length: sd of exp(0.5 z) at three nodes, about its middle
    spread = math.sqrt(sum((math.exp(0.5 * z) - 1) ** 2 / 6 for z in (-math.sqrt(3), math.sqrt(3))))
    assert np.median(depth) == pytest.approx(spread, rel=0.3)
    distances = measure_distances(bodies)
    held = [
        distances.low_m[i, j] <= level.distances_m[a, b] <= distances.high_m[i, j]
        for i, a in enumerate(level.owners) for j, b in enumerate(level.owners[:i])
    ]  # fmt: skip
    assert np.mean(held) >= 0.7


def test_the_focal_lengths_stand_for_a_normal_distribution() -> None:
    z, weight = np.array(unsure_focal._NODES).T
    assert [float((weight * z**k).sum()) for k in range(6)] == pytest.approx([1, 0, 1, 0, 3, 0])


def test_the_covariance_is_that_of_all_explanations_together(level: SyntheticPhoto) -> None:
    bodies = locate(level.people, replace(level.camera, focal_rel_sd=0.5), LocateSettings())
    about = np.array([(mode.positions_m - bodies.positions_m).ravel() for mode in bodies.modes])
    within = sum(mode.weight * mode.covariance_m2 for mode in bodies.modes)
    between = np.einsum("k,ki,kj->ij", [mode.weight for mode in bodies.modes], about, about)
    np.testing.assert_allclose(bodies.covariance_m2, within + between)
    assert np.trace(between) > np.trace(within)  # the focal length is most of what a level photo does not tell


def test_the_order_of_people_does_not_matter(level: SyntheticPhoto) -> None:
    camera = replace(level.camera, focal_rel_sd=2 * UNSURE_SD)
    there, back = (locate(people, camera, LocateSettings()) for people in (level.people, level.people[::-1]))
    np.testing.assert_allclose(back.positions_m[::-1], there.positions_m, rtol=0.02, atol=0.02)


def test_a_crowd_is_as_unsure_by_one_fit(level: SyntheticPhoto, monkeypatch: pytest.MonkeyPatch) -> None:
    camera = replace(level.camera, focal_rel_sd=0.5)
    several = locate(level.people, camera, LocateSettings())
    monkeypatch.setattr("proxemetry.locate.unsure_focal.CROWD", 1)
    once = locate(level.people, camera, LocateSettings())
    np.testing.assert_allclose(once.positions_m, several.positions_m)
    np.testing.assert_allclose(once.position_sd_m[:, 2], several.position_sd_m[:, 2], rtol=0.25)
    depth = once.covariance_m2[2::3, 2::3] / np.outer(once.positions_m[:, 2], once.positions_m[:, 2])
    assert (depth[0, 1:] > 0.2).all()  # they all move together


def _answer(people, pitch_rad: float) -> Bodies:
    count = len(people)
    places, spread = np.tile([0.0, 0.0, 5.0], (count, 1)), np.eye(3 * count) * 0.01
    modes = (Mode(0.3, places, spread), Mode(0.7, places + 0.1, spread))
    floor = Floor(1.6, pitch_rad, 0.0, 0.05, 0.01, 0.01)
    return Bodies(places, spread, "scene", ("feet",) * count, (None,) * count, floor=floor, modes=modes)


def test_explanations_of_each_focal_length_keep_their_weights(level, monkeypatch) -> None:
    monkeypatch.setattr(unsure_focal, "fitted", lambda people, *_: _answer(people, 0.0))
    camera = replace(level.camera, focal_rel_sd=2 * UNSURE_SD)
    modes = locate(level.people, camera, LocateSettings()).modes
    assert sum(mode.weight for mode in modes) == pytest.approx(1.0)
    assert [mode.weight for mode in modes] == pytest.approx([0.05, 7 / 60, 0.2, 7 / 15, 0.05, 7 / 60])


@pytest.mark.parametrize("pitch_rad", [PITCHED_RAD + 0.01, -PITCHED_RAD - 0.01])
def test_a_camera_that_looks_far_down_or_up_is_fitted_once(pitch_rad, level, monkeypatch) -> None:
    fits: list[float] = []

    def counted(people, camera, *_):
        fits.append(camera.f_px)
        return _answer(people, pitch_rad)

    monkeypatch.setattr(unsure_focal, "fitted", counted)
    locate(level.people, replace(level.camera, focal_rel_sd=2 * UNSURE_SD), LocateSettings())
    assert fits == [level.camera.f_px]


@pytest.mark.parametrize("rel_sd", [0.3, 0.8])
def test_a_crowds_depths_stretch_by_what_the_focal_lengths_differ(level, rel_sd) -> None:
    """By the mean of (exp(z sd) - 1)^2 over the nodes, all together; nothing is added across the picture."""
    plain = _answer(level.people, 0.0)
    found = unsure_focal._stretched(plain, rel_sd)
    factor = sum((math.exp(z * rel_sd) - 1) ** 2 / 6 for z in (-math.sqrt(3), math.sqrt(3)))
    for before, after in ((plain, found), *zip(plain.modes, found.modes, strict=True)):
        depth = np.zeros_like(before.positions_m)
        depth[:, 2] = before.positions_m[:, 2]
        added = after.covariance_m2 - before.covariance_m2
        assert added == pytest.approx(factor * np.outer(depth, depth))


def test_no_focal_length_is_tried_that_no_lens_has() -> None:
    camera = Camera.centred(900.0, 1200, 900, focal_rel_sd=1.5)
    tried = [unsure_focal._at(camera, z).f_px for z in (-2, -1, 0, 1, 3)]
    assert tried == pytest.approx([8 / 36 * 1200, 8 / 36 * 1200, 900, 900 * math.exp(1.5), 2000 / 36 * 1200])
    odd = replace(camera.with_focal(200.0), focal_rel_sd=1.5)  # a fisheye's, as stated
    assert [unsure_focal._at(odd, z).f_px for z in (-1, 0)] == pytest.approx([200, 200])


def test_where_one_focal_length_places_others_than_another_the_free_fit_answers(level, monkeypatch) -> None:
    answers = iter([0, 0, 1, 0])  # the free fit, and one at each node, the second of which leaves somebody out
    free = []

    def partly(people, *_):
        body = _answer(people, 0.0)
        if next(answers):
            body = replace(body, positions_m=np.where(np.arange(len(people))[:, None] == 0, np.nan, body.positions_m))
        free.append(body)
        return body

    monkeypatch.setattr(unsure_focal, "fitted", partly)
    assert locate(level.people, replace(level.camera, focal_rel_sd=0.5), LocateSettings()) is free[0]
    assert len(free) == 4


def test_the_floor_holds_those_of_the_other_focal_lengths(level) -> None:
    def with_floor(*fields):
        return replace(_answer(level.people, 0.0), floor=Floor(*fields) if fields else None)

    fits = [with_floor(1.3, 0.1, 0.02, 0.1, 0.01, 0.01), with_floor(1.6, 0.0, 0.0, 0.2, 0.02, 0.01),
            with_floor(2.2, -0.2, 0.0, 0.3, 0.03, 0.01)]  # fmt: skip
    found = unsure_focal._floor(fits)
    assert (found.height_m, found.pitch_rad) == (1.6, 0.0)
    apart = (0.1**2 + 0.3**2) / 6 + 0.2**2 * 2 / 3 + (0.3**2 + 0.6**2) / 6
    assert found.height_sd_m == pytest.approx(math.sqrt(apart))
    turned = (0.01**2 + 0.1**2) / 6 + 0.02**2 * 2 / 3 + (0.03**2 + 0.2**2) / 6
    assert found.pitch_sd_rad == pytest.approx(math.sqrt(turned))
    assert unsure_focal._floor([fits[0], with_floor(), fits[2]]) is None
    assert unsure_focal._floor([with_floor(), fits[1], fits[2]]) is fits[1].floor
