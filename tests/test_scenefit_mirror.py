"""The other side of the line of sight: closed forms of mirroring, and that the fit takes it into account."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from proxemetry.locate.scenefit import fit as joint_fit
from proxemetry.locate.scenefit import locate, shared_prior
from proxemetry.locate.scenefit.body_model import body_model
from proxemetry.locate.scenefit.mirror import Mirrored, on_the_other_side
from proxemetry.locate.scenefit.posterior import _headings
from proxemetry.locate.scenefit.projection import HEADING, N_LOCAL, TURN, BodyTables, body_axes, project
from proxemetry.locate.scenefit.start import HEADINGS
from proxemetry.people.skeleton import COCO_17
from synthetic.modelled import ADULTS, CAMERA, photo

angles = st.floats(-3.0, 3.0)


def row(across, heading, turn):
    local = np.zeros((1, N_LOCAL))
    local[0, 0], local[0, HEADING], local[0, TURN] = across, heading, turn
    return local


@given(st.floats(-1, 1), angles, angles)
def test_mirroring_twice_is_no_change_and_keeps_the_head(across, heading, turn):
    local = row(across, heading, turn)
    other = on_the_other_side(local)
    head, other_head = (part[0, HEADING] + part[0, TURN] for part in (local, other))
    assert np.exp(1j * head) == pytest.approx(np.exp(1j * other_head))
    assert np.exp(1j * on_the_other_side(other)[0, HEADING]) == pytest.approx(np.exp(1j * heading))


@given(st.floats(-1, 1), angles)
def test_a_trunk_and_its_mirror_image_face_the_lens_by_the_same_angle(across, heading):
    to_lens = -np.array([across, 0.0, 1.0]) / np.hypot(across, 1.0)
    local = row(across, heading, 0.0)
    forward, left = (body_axes(part[:, HEADING])[0, :, 0] for part in (local, on_the_other_side(local)))
    assert forward @ to_lens == pytest.approx(left @ to_lens)
    aside = np.cross(to_lens, [0.0, 1.0, 0.0])
    assert forward @ aside == pytest.approx(-(left @ aside))


def test_shoulders_look_as_wide_on_the_other_side():
    model, tables = body_model(COCO_17), BodyTables.of(body_model(COCO_17), np.zeros(1, dtype=np.intp))
    local = row(0.0, 0.6, 0.0)
    local[0, 2] = np.log(30.0)  # far away, where perspective tells nothing
    local[:, 5 : 5 + 6] = np.log([1.70, 1.36, 0.51, 0.345, 0.063, 0.15])
    shared = shared_prior(CAMERA).mean
    width = [
        np.ptp(project(part, shared, tables).points[0, 0, model.kinds["shoulders"]])
        for part in (local, on_the_other_side(local))
    ]
    assert width[0] == pytest.approx(width[1], rel=0.01)


def test_headings_are_the_likelier_sides_and_spread_over_both():
    class Rows:
        person = np.array([0, 0])

    class Same:
        local = np.zeros((2, N_LOCAL))

    class Fit:
        local = row(0.0, 0.4, 0.0)

    Same.local[:, HEADING] = 0.4
    local_sd = np.zeros((1, N_LOCAL))
    weights = np.array([0.7, 0.3])  # two explanations of the place, both with this heading
    for odds, expected in ((0.25, 0.4), (4.0, -0.4)):
        mirrored = Mirrored(row(0.0, -0.4, 0.8), np.log([odds]))
        heading, sd = _headings(Rows, Same, weights, local_sd, Fit, mirrored)
        assert heading == pytest.approx(expected)
        assert sd**2 == pytest.approx(np.deg2rad(9) ** 2 + 0.2 * 0.8**2)  # one in five is 0.8 rad away


def test_headings_do_not_depend_on_the_side_that_the_start_took(monkeypatch):
    people, _ = photo(0, noise_px=0.3)
    right = locate(people, CAMERA, ADULTS).heading_rad
    found = joint_fit.initialise

    def wrong_side(*arguments):
        start = found(*arguments)
        same_side = np.sin(HEADINGS)[None] * np.sign(right)[:, None] > 0.1
        return replace(start, cost=start.cost + np.where(same_side, 1e3, 0.0)[:, None])

    monkeypatch.setattr(joint_fit, "initialise", wrong_side)
    clear = np.abs(right) > 0.5
    assert clear.any()
    assert locate(people, CAMERA, ADULTS).heading_rad[clear] == pytest.approx(right[clear], abs=0.05)
