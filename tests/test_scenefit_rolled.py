"""A camera that is turned about its axis: the answer is that of the upright photo, turned."""

from dataclasses import replace

import numpy as np
import pytest

from proxemetry.camera import Mount
from proxemetry.locate.scenefit import locate, shared_prior
from proxemetry.locate.scenefit.body_model import body_model
from proxemetry.locate.scenefit.evidence import evidence_of
from proxemetry.locate.scenefit.projection import ROLL
from proxemetry.locate.scenefit.start import _common_lean, initialise
from proxemetry.people import People
from proxemetry.people.skeleton import COCO_17
from synthetic.modelled import ADULTS, CAMERA, photo

#: Large enough that nobody leaves the photo when it is turned.
_LARGE = replace(CAMERA, width=4000, height=4000, cx=2000.0, cy=2000.0)


def turned(people: People, roll_deg: float) -> People:
    """Return the people of a camera that is turned by a roll, as in `bodies.Floor`."""
    c, s = np.cos(np.deg2rad(roll_deg)), np.sin(np.deg2rad(roll_deg))
    centre = np.array([_LARGE.cx, _LARGE.cy])
    return replace(people, keypoints_px=(people.keypoints_px - centre) @ np.array([[c, s], [-s, c]]) + centre)


@pytest.mark.parametrize("roll_deg", [-26.0, 13.0, 35.0])
def test_a_turned_photo_has_the_same_depths_and_floor(roll_deg: float):
    people, truth = photo(1, pitch=0.3, camera=_LARGE)
    upright, rolled = locate(people, _LARGE, ADULTS), locate(turned(people, roll_deg), _LARGE, ADULTS)
    assert rolled.positions_m[:, 2] == pytest.approx(truth[:, 2], rel=0.08)
    assert rolled.positions_m[:, 2] == pytest.approx(upright.positions_m[:, 2], rel=0.03)
    assert rolled.floor is not None and upright.floor is not None
    assert np.rad2deg(rolled.floor.roll_rad) == pytest.approx(roll_deg, abs=2)
    assert rolled.floor.pitch_rad == pytest.approx(upright.floor.pitch_rad, abs=0.05)


@pytest.mark.parametrize("roll_deg", [-40.0, 10.0, 20.0])
def test_trunks_lean_as_the_camera_is_turned(roll_deg: float):
    model = body_model(COCO_17)
    people, _ = photo(2, noise_px=0.0, pitch=0.0, camera=_LARGE)
    lean = _common_lean(evidence_of(turned(people, roll_deg), _LARGE, model), model)
    assert np.rad2deg(lean) == pytest.approx(roll_deg, abs=3)
    lengths = np.tile([1.70, 1.36, 0.51, 0.345, 0.063, 0.15], (4, 1))
    start = initialise(evidence_of(turned(people, roll_deg), _LARGE, model), lengths, shared_prior(_LARGE), model,
                       np.ones(4))  # fmt: skip
    assert start.shared[ROLL] == pytest.approx(lean)


def test_one_of_four_who_leans_turns_no_camera():
    people, _ = photo(1, pitch=0.1, camera=_LARGE)
    pixels = people.keypoints_px.copy()
    pixels[0] = turned(people, 30.0)[:1].keypoints_px[0]
    floor = locate(replace(people, keypoints_px=pixels), _LARGE, ADULTS).floor
    assert floor is not None and abs(np.rad2deg(floor.roll_rad)) < 3


def first_look(people: People):
    lengths = np.tile([1.70, 1.36, 0.51, 0.345, 0.063, 0.15], (len(people), 1))
    model = body_model(COCO_17)
    return initialise(evidence_of(people, _LARGE, model), lengths, shared_prior(_LARGE), model, np.ones(len(people)))


def test_trunks_that_lean_over_upright_legs_turn_no_camera():
    people, _ = photo(2, noise_px=0.0, pitch=0.0, camera=_LARGE)
    pixels = people.keypoints_px.copy()
    legs = [COCO_17.joints.index(f"{side}_{joint}") for side in ("left", "right") for joint in ("knee", "ankle")]
    face = [0, 1, 2, 3, 4]
    leaning = turned(people, 9.0).keypoints_px
    hips = [COCO_17.joints.index(f"{side}_hip") for side in ("left", "right")]
    shift = pixels[:, hips].mean(axis=1) - leaning[:, hips].mean(axis=1)
    trunks = leaning + shift[:, None]
    kept = replace(people, keypoints_px=np.where(np.isin(np.arange(17), legs + face)[None, :, None], pixels, trunks))
    assert np.rad2deg(_common_lean(evidence_of(kept, _LARGE, body_model(COCO_17)), body_model(COCO_17))) > 6
    assert first_look(kept).shared[ROLL] == 0


def test_one_person_who_leans_a_little_is_likelier_than_a_turned_camera():
    alone = photo(2, noise_px=0.0, pitch=0.0, camera=_LARGE)[0][:1]
    assert first_look(turned(alone, 7.0)).shared[ROLL] == 0
    assert np.rad2deg(first_look(turned(alone, 25.0)).shared[ROLL]) == pytest.approx(25, abs=4)


def test_a_stated_roll_is_where_the_search_begins():
    people, model = photo(1, pitch=0.1, camera=_LARGE)[0], body_model(COCO_17)
    lengths = np.tile([1.70, 1.36, 0.51, 0.345, 0.063, 0.15], (4, 1))
    evidence = evidence_of(turned(people, 20.0), _LARGE, model)
    stated = shared_prior(_LARGE, Mount.stated(roll_rad=0.05))
    assert initialise(evidence, lengths, stated, model, np.ones(4)).shared[ROLL] == pytest.approx(0.05)


def test_nobody_with_a_trunk_leans_nowhere():
    model = body_model(COCO_17)
    people, _ = photo(2, camera=_LARGE)
    hidden = replace(people, scores=np.where(np.isin(np.arange(17), (5, 6, 11, 12)), 0.0, people.scores))
    assert _common_lean(evidence_of(hidden, _LARGE, model), model) == 0.0
