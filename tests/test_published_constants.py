"""Constants that were published elsewhere are what was published: feet and inches, percentiles, tables of surveys."""

import itertools

import numpy as np
import pytest
from scipy import stats

from proxemetry import intervals, overlap, proxemics
from proxemetry.anthropometry import _CORRELATION, CHILD_AGES, CHILD_STATURES, LANDMARKS, LENGTHS
from proxemetry.benchmark.labels import KORTE_SENSOR_MM
from proxemetry.benchmark.metrics import CONSTANT_MM, F1_THRESHOLDS_M
from proxemetry.camera import published, sensors
from proxemetry.clip import joining, statures, tracking
from proxemetry.distances import ZONE_LIMITS_M, ZONES
from proxemetry.formations import GROUP_RADII_M, GROUP_REACH_M
from proxemetry.locate import pinhole
from proxemetry.people.skeleton import COCO_17
from proxemetry.photo import metadata

INCH, FOOT = 0.0254, 0.3048


def test_halls_zones_and_phases_are_his_feet_and_inches():
    """Hall 1966, chapter 10: 18 inches, 4 and 12 feet; close phases end at 6 inches, 2.5, 7 and 25 feet."""
    assert pytest.approx([18 * INCH, 4 * FOOT, 12 * FOOT], abs=6e-4) == list(ZONE_LIMITS_M)
    phases = dict(zip(ZONES, [6 * INCH, 2.5 * FOOT, 7 * FOOT, 25 * FOOT], strict=True))
    assert phases == pytest.approx(dict(proxemics.PHASE_LIMITS_M), abs=6e-4)
    assert ZONE_LIMITS_M[-1] == proxemics.ORIENTATION_REACH_M


def test_the_papers_lengths_and_ratios():
    """Seker et al. 2021, section 3 and its code: shoulders 389, pupils 63, torso 444 mm (444.5 in the code)."""
    assert {cue: round(1000 * pinhole._CUES[cue].length_m) for cue in pinhole._CUES} == {
        "torso": 444, "shoulder": 389, "pupil": 63,
    }  # fmt: skip
    assert (pinhole._CODE_TORSO_M, pinhole._SHOULDER_RATIO, pinhole._EYE_EAR_RATIO) == (0.4445, 1.25, 1.95)
    assert F1_THRESHOLDS_M == (1.0, 1.5, 2.0, 3.0)
    assert KORTE_SENSOR_MM == (36.0, 24.0)
    assert CONSTANT_MM == 1700


def test_two_people_interact_within_the_published_reach():
    """Bertoni et al. 2021 (T-ITS): within two metres, radii of 0.3, 0.5 and 1 m."""
    assert GROUP_REACH_M == 2.0 and GROUP_RADII_M == (0.3, 0.5, 1.0)


def test_cocos_constants_in_its_order():
    """cocodataset.org, keypoint evaluation: per-keypoint standard deviations, nose to ankles."""
    coco = [26, 25, 25, 35, 35, 79, 79, 72, 72, 62, 62, 107, 107, 87, 87, 89, 89]
    assert overlap.sigmas_of(COCO_17.joints) == pytest.approx(np.array(coco) / 1000)


def test_gates_and_levels_are_the_percentiles_that_they_are_named_for():
    assert stats.chi2(2).ppf(0.999) == pytest.approx(tracking.GATE, abs=0.05)
    assert stats.chi2(4).ppf(0.99) == pytest.approx(joining._GATE, abs=0.01)
    assert stats.norm.ppf(0.75) == pytest.approx(statures._MAD_SD, abs=1e-4)
    assert stats.norm.ppf(0.95) == pytest.approx(intervals.HALF_WIDTH_SD)


def test_full_frame_and_units_of_a_focal_plane():
    """36 x 24 mm; EXIF 2.32, FocalPlaneResolutionUnit: 1 none (inch is meant), 2 inch, 3 cm, 4 mm, 5 micrometre."""
    assert pytest.approx(43.267, abs=1e-3) == sensors.FULL_FRAME_DIAGONAL_MM
    assert dict(metadata._UNITS_PER_MM) == pytest.approx({1: 1 / 25.4, 2: 1 / 25.4, 3: 1 / 10, 4: 1.0, 5: 1000.0})


def test_published_photos_quantiles_are_those_of_their_density():
    """19, 27, 37, 54 and 101 mm, as is stated there, and as the density adds up to."""
    shares = [0.05, 0.25, 0.5, 0.75, 0.95]
    found = [published.quantile_mm(share) for share in shares]
    assert found == pytest.approx([19, 27, 37, 54, 101], abs=0.8)
    log_mm = np.linspace(np.log(2), np.log(2000), 20_001)
    added = np.cumsum(np.exp(published.log_density(log_mm)))
    assert np.interp(np.log(found), log_mm, added / added[-1]) == pytest.approx(shares, abs=1e-3)


def test_what_ansur_measured():
    """Gordon et al. 2014, men and women: means and standard deviations in millimetres."""
    ansur = {
        "stature": (1756, 69, 1629, 64), "biacromial": (416, 19, 365, 18), "interpupillary": (64.0, 3.4, 61.7, 3.6),
        "acromial_height": (1441, 63, 1335, 58), "acromion_trochanterion": (540, 33, 490, 29),
    }  # fmt: skip
    for sex, at in (("men", 0), ("women", 2)):
        assert {n: (1000 * v.mean_m, 1000 * v.sd_m) for n, v in LANDMARKS[sex].items()} == {
            name: pytest.approx(values[at : at + 2]) for name, values in ansur.items()
        }


def test_lengths_go_together_as_ansurs_do():
    """With stature: biacromial .53 and .57, acromial height .97, trunk .58 and .62, pupils .18 and .20."""
    assert pytest.approx(_CORRELATION.T) == _CORRELATION
    with_stature = dict(zip(LENGTHS, _CORRELATION[0], strict=True))
    for name, (women, men) in {
        "shoulders": (0.53, 0.57), "shoulder_height": (0.97, 0.97), "torso": (0.58, 0.62), "pupils": (0.18, 0.20),
    }.items():  # fmt: skip
        assert min(women, men) <= with_stature[name] <= max(women, men)
    at = LENGTHS.index
    assert _CORRELATION[at("shoulders"), at("torso")] == 0.28 and _CORRELATION[at("pupils"), at("shoulders")] == 0.25


def test_children_grow_as_the_growth_charts_say():
    """CDC 2000, medians and standard deviations of stature at 2, 4 ... 18 years, millimetres."""
    cdc = {
        "boys": [865, 35, 1025, 42, 1157, 51, 1281, 58, 1388, 66, 1493, 75, 1641, 80, 1736, 75, 1762, 72],
        "girls": [850, 35, 1010, 44, 1150, 52, 1278, 58, 1382, 66, 1515, 74, 1605, 66, 1626, 65, 1631, 65],
    }
    assert tuple(range(2, 19, 2)) == CHILD_AGES
    for sex, table in cdc.items():
        ours = itertools.chain.from_iterable((1000 * s.mean_m, 1000 * s.sd_m) for s in CHILD_STATURES[sex])
        assert list(ours) == pytest.approx(table)
