"""Other cameras that may explain far people better (`locate/scenefit/other_cameras.py`)."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import proxemetry.locate.scenefit.fit as fit_module
import proxemetry.locate.scenefit.other_cameras as module
from proxemetry.camera import Mount
from proxemetry.locate.scenefit import locate, shared_prior
from proxemetry.locate.scenefit.body_model import body_model
from proxemetry.locate.scenefit.fit import explained_people
from proxemetry.locate.scenefit.other_cameras import likeliest_camera
from proxemetry.locate.scenefit.projection import HEIGHT, PITCH, project
from proxemetry.people.skeleton import COCO_17
from synthetic.modelled import ADULTS, CAMERA, photo

MAST = {"pitch": 0.29, "height_m": 7.0, "depths_m": (17, 35)}


def _explained(seed: int, **kind: object):
    people, _ = photo(seed, **kind)
    prior = shared_prior(CAMERA)
    found = explained_people(people, CAMERA, prior, ADULTS, body_model(COCO_17))
    assert found is not None
    return found.rows.taken(found.first), found.fit, prior


def test_far_people_are_explained_by_the_likelier_camera(monkeypatch: pytest.MonkeyPatch) -> None:
    """In this photo the descent from the coarse search ends 2 log units above another optimum."""
    people, truth = photo(6, noise_px=2.0, **MAST)
    apart = np.linalg.norm(truth[:, None, [0, 2]] - truth[:, [0, 2]], axis=-1)[np.triu_indices(4, 1)]
    errors: list[float] = []
    floors: list[float] = []
    for alone in (False, True):
        if alone:
            monkeypatch.setattr(fit_module, "likeliest_camera", lambda rows, fit, prior, iterations: fit)
        bodies = locate(people, CAMERA, ADULTS)
        at = bodies.positions_m
        found = np.linalg.norm(at[:, None, [0, 2]] - at[:, [0, 2]], axis=-1)[np.triu_indices(4, 1)]
        errors.append(float(np.abs(found / apart - 1).mean()))
        floors.append(bodies.floor.pitch_rad if bodies.floor else 0.0)
    assert floors[0] > floors[1] + np.deg2rad(3.0)
    assert floors[0] < MAST["pitch"]
    assert errors[0] < errors[1]


@settings(max_examples=8, deadline=None)
@given(st.integers(0, 50))
def test_no_camera_is_taken_that_is_less_likely(seed: int) -> None:
    rows, fit, prior = _explained(seed, noise_px=2.0, **MAST)
    begun = module.solve(rows, fit.local, fit.shared - np.eye(len(fit.shared))[PITCH] * 0.1, prior, iterations=1)
    assert likeliest_camera(rows, begun, prior, 8).cost <= begun.cost


def test_nothing_is_tried_of_near_people_or_where_the_pitch_is_stated(monkeypatch: pytest.MonkeyPatch) -> None:
    near, near_fit, prior = _explained(1)
    far, far_fit, _ = _explained(1, **MAST)
    tried: list[float] = []
    solve = module.solve
    monkeypatch.setattr(module, "solve", lambda *args, **more: tried.append(1.0) or solve(*args, **more))
    assert likeliest_camera(near, near_fit, prior, 4) is near_fit
    assert likeliest_camera(far, far_fit, shared_prior(CAMERA, Mount.stated(pitch_rad=0.29)), 4) is far_fit
    assert not tried
    likeliest_camera(far, far_fit, prior, 4)
    assert len(tried) == 2


@pytest.mark.parametrize("tilt_deg", [-7.0, 7.0])
def test_the_floor_stays_under_the_people_of_another_camera(tilt_deg: float) -> None:
    rows, fit, _ = _explained(3, noise_px=0.0, pitch=0.29, height_m=7.0, depths_m=(24, 26))
    shared = module._tilted(fit, rows, np.deg2rad(tilt_deg))
    assert shared[PITCH] - fit.shared[PITCH] == pytest.approx(np.deg2rad(tilt_deg))
    assert np.exp(shared[HEIGHT]) != pytest.approx(np.exp(fit.shared[HEIGHT]), rel=0.2)
    before, after = (project(fit.local, camera, rows.bodies).floor for camera in (fit.shared, shared))
    assert np.median(after) == pytest.approx(np.median(before), abs=0.02)
