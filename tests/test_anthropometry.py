import numpy as np
import pytest

from proxemetry import anthropometry
from proxemetry.anthropometry import LENGTHS, length, moments, populations
from proxemetry.errors import SettingsError
from proxemetry.locate import BODY_SIZES


@pytest.mark.parametrize("body_size", BODY_SIZES)
def test_mixtures_are_distributions(body_size):
    groups = populations(body_size)
    assert sum(g.weight for g in groups) == pytest.approx(1)
    for group in groups:
        assert np.linalg.eigvalsh(group.log_covariance).min() > 0
    assert np.linalg.eigvalsh(moments(groups)[1]).min() > 0


def test_adults_are_half_women_half_men():
    # stature: (1.756 + 1.629) / 2 = 1.6925; variance (.069^2 + .064^2) / 2 + (.127 / 2)^2 = .0921^2
    stature = length("stature", "adults")
    assert stature.mean_m == pytest.approx(1.6925, abs=5e-4)
    assert stature.sd_m == pytest.approx(0.0921, abs=1e-3)
    assert length("biacromial", "adults").rel_sd == pytest.approx(0.080, abs=1e-3)
    assert length("interpupillary", "adults").mean_m == pytest.approx(0.0629, abs=1e-4)


def test_joints_are_where_detectors_place_them():
    # between anatomy (.49, .34) and triangulated detections (.524, .347)
    assert length("torso", "adults").mean_m == pytest.approx(0.510, abs=1e-3)
    assert length("shoulders", "adults").mean_m == pytest.approx(0.344, abs=1e-3)
    # ANSUR II's 7.8 % of acromion to trochanterion, and 3 % for where the hips are
    assert length("torso", "adults").rel_sd == pytest.approx(np.hypot(0.078, 0.03), abs=2e-3)


def test_one_sex_is_its_own_table():
    assert length("stature", "men").mean_m == pytest.approx(1.756)
    assert length("acromion_trochanterion", "women").sd_m == pytest.approx(0.029)


def test_a_six_year_old_is_smaller_in_body_than_in_pupils():
    # METHOD: an adult constant overestimates a six-year-old's depth 1.47 times by the body, 1.2 times by the pupils
    child = anthropometry._children(6, 6, 1.0)
    adult, _ = moments(populations("adults"))
    ratio = np.exp(adult - child.log_mean)
    assert ratio[LENGTHS.index("torso")] == pytest.approx(1.47, abs=0.02)
    assert ratio[LENGTHS.index("pupils")] == pytest.approx(1.2, abs=0.02)


def test_children_widen_the_mixture():
    assert length("stature", "mixed").rel_sd > length("stature", "adults").rel_sd
    assert length("stature", "children").mean_m < 1.4
    assert sum(g.weight for g in populations("mixed", 0.3) if g.name.startswith("children")) == pytest.approx(0.3)


def test_unknown_names_are_refused():
    with pytest.raises(SettingsError, match="giants"):
        populations("giants")
    with pytest.raises(SettingsError, match="tail"):
        length("tail", "adults")
