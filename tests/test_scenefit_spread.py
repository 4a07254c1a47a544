"""Answers spread as far as they say: one scene measured two hundred times, bodies, floor and noise drawn anew.

Everything that the fit takes for chance is drawn as it takes it: body lengths, postures, the turn of heads, how uneven
the floor is, the noise of keypoints, the twist of trunks. Places, headings and the camera stay.
"""

from dataclasses import replace

import numpy as np
import pytest

from proxemetry.locate.scenefit import locate
from proxemetry.locate.scenefit import projection as p
from proxemetry.locate.scenefit.body_model import body_model
from proxemetry.locate.scenefit.evidence import evidence_of
from proxemetry.locate.scenefit.hypotheses import _TURN_SD, body_types, keypoint_precision
from proxemetry.locate.scenefit.posterior import _TWIST_SD
from proxemetry.people.skeleton import COCO_17
from synthetic.modelled import ADULTS, CAMERA, camera_above, on_floor, people_of

ACROSS = np.array([-0.45, -0.1, 0.2, 0.5, 0.05])
DEPTHS_M = np.array([5.0, 7.0, 6.0, 9.0, 11.0])
HEADINGS = np.array([0.3, -0.5, 0.9, -1.2, 0.1])
#: How well the back end of the first test knows headings.
STATED_SD = 0.3
COUNT = len(DEPTHS_M)


def drawn(rng):
    """Return people, where they are, where their trunks face, and how tall they are."""
    model = body_model(COCO_17)
    (adults,) = body_types("adults", 0.05)
    local, shared = np.zeros((COUNT, p.N_LOCAL)), camera_above(1.7, 0.12)
    local[:, 0], local[:, p.DEPTH], local[:, p.HEADING] = ACROSS, np.log(DEPTHS_M), HEADINGS
    local[:, p.LOG_LENGTHS] = rng.multivariate_normal(adults.mean, np.linalg.inv(adults.precision), COUNT)
    local[:, p.TURN] = rng.normal(0, _TURN_SD, COUNT)
    local[:, p.POSTURE] = rng.normal(model.prior_mean[0], model.prior_sd[0], (COUNT, len(model.prior_mean[0])))
    local, joints = on_floor(local, shared, rng.normal(0, np.hypot(0.04, 0.003 * DEPTHS_M)))
    scale = np.exp(local[:, p.LOG_LENGTHS.start] - local[:, p.DEPTH])
    precision = keypoint_precision(evidence_of(people_of(joints), CAMERA, model), model, scale)
    sd = 1 / np.maximum(precision, 1e-9)[..., None]
    noise = np.where(precision[..., None] > 0, rng.standard_normal(joints.shape) * sd, 0.0)
    trunks = HEADINGS + rng.normal(0, _TWIST_SD, COUNT)
    stature_m = np.exp(local[:, p.LOG_LENGTHS.start])
    return people_of(joints + noise), p.torso_position(local, shared), trunks, stature_m


def measured(seed, times, stated_sd=None):
    """Return errors and stated standard deviations by quantity, each (times, ...)."""
    rng = np.random.default_rng(seed)
    rows = []
    a, b = np.triu_indices(COUNT, 1)
    for _ in range(times):
        people, truth, trunks, stature_m = drawn(rng)
        if stated_sd is not None:
            seen_from = np.arctan(ACROSS)  # headings are seen along the line of sight
            stated = HEADINGS + seen_from + rng.normal(0, stated_sd, COUNT)
            people = replace(people, heading_rad=stated, heading_sd_rad=np.full(COUNT, stated_sd))
        bodies = locate(people, CAMERA, ADULTS)
        gap, true_gap = (p[a] - p[b] for p in (bodies.positions_m, truth))
        flat, true_flat = (g - np.outer(g @ bodies.up, bodies.up) for g in (gap, true_gap))
        distance, true = np.linalg.norm(flat, axis=1), np.linalg.norm(true_flat, axis=1)
        along = flat / distance[:, None]
        blocks = bodies.covariance_m2.reshape(COUNT, 3, COUNT, 3).transpose(0, 2, 1, 3)
        covariance = blocks[a, a] + blocks[b, b] - blocks[a, b] - blocks[b, a]
        turned = np.angle(np.exp(1j * (bodies.heading_rad - trunks)))
        rows.append((
            (bodies.positions_m - truth)[:, 2], bodies.position_sd_m[:, 2], distance - true,
            np.sqrt(np.einsum("ni,nij,nj->n", along, covariance, along)), turned, bodies.heading_sd_rad,
            bodies.stature_m - stature_m, bodies.stature_sd_m,
        ))  # fmt: skip
    columns = [np.array(column) for column in zip(*rows, strict=True)]
    return {
        name: (columns[2 * k], columns[2 * k + 1]) for k, name in enumerate(("depth", "distance", "heading", "stature"))
    }


def spread_over_stated(errors, sd):
    """Return the standard deviation of errors over the one stated, a mean over people or pairs."""
    return float(np.sqrt((errors.var(axis=0) / (sd**2).mean(axis=0)).mean()))


def test_depths_distances_headings_and_statures_spread_as_stated():
    found = measured(0, 200, STATED_SD)
    ratios = {name: spread_over_stated(*of_it) for name, of_it in found.items()}
    assert ratios == pytest.approx(dict.fromkeys(ratios, 1.0), abs=0.2), ratios
    for errors, sd in found.values():  # and no answer is biased by half of that
        assert np.abs(errors.mean(axis=0) / sd.mean(axis=0)).mean() < 0.5


def test_headings_spread_as_stated_where_joints_alone_tell_them():
    assert spread_over_stated(*measured(1, 80)["heading"]) == pytest.approx(1, abs=0.2)
