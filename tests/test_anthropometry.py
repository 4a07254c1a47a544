import numpy as np
import pytest

from proxemetry import anthropometry
from proxemetry.anthropometry import LENGTHS, moments, populations
from proxemetry.errors import SettingsError
from proxemetry.locate import BODY_SIZES


def median(name, body_size):
    """Return the median of a length as one Gaussian of its logarithm has it."""
    mean, _ = moments(populations(body_size))
    return float(np.exp(mean[LENGTHS.index(name)]))


def rel_sd(name, body_size):
    _, covariance = moments(populations(body_size))
    return float(np.sqrt(covariance[LENGTHS.index(name), LENGTHS.index(name)]))


@pytest.mark.parametrize("body_size", BODY_SIZES)
def test_mixtures_are_distributions(body_size):
    groups = populations(body_size)
    assert sum(g.weight for g in groups) == pytest.approx(1)
    for group in groups:
        assert np.linalg.eigvalsh(group.log_covariance).min() > 0
    assert np.linalg.eigvalsh(moments(groups)[1]).min() > 0


def test_adults_are_half_women_half_men():
    # stature: sqrt(1.756 * 1.629) = 1.691; log variance (.0393^2 + .0393^2) / 2 + (log(1.756 / 1.629) / 2)^2 = .0544^2
    assert median("stature", "adults") == pytest.approx(1.691, abs=2e-3)
    assert rel_sd("stature", "adults") == pytest.approx(0.0544, abs=5e-4)
    assert rel_sd("shoulders", "adults") == pytest.approx(0.080, abs=2e-3)  # ANSUR II's biacromial breadth
    assert median("pupils", "adults") == pytest.approx(0.0628, abs=2e-4)


def test_joints_are_where_detectors_place_them():
    # between anatomy (.49, .34) and triangulated detections (.524, .347)
    assert median("torso", "adults") == pytest.approx(0.508, abs=2e-3)
    assert median("shoulders", "adults") == pytest.approx(0.343, abs=2e-3)
    # ANSUR II's 7.8 % of acromion to trochanterion, and 3 % for where the hips are
    assert rel_sd("torso", "adults") == pytest.approx(np.hypot(0.078, 0.03), abs=2e-3)


def test_one_sex_is_its_own_table():
    # the mean of a log-normal is exp(mu + var / 2)
    assert median("stature", "men") * np.exp(rel_sd("stature", "men") ** 2 / 2) == pytest.approx(1.756)
    assert rel_sd("torso", "women") == pytest.approx(np.hypot(0.029 / 0.490, 0.03))


def test_a_six_year_old_is_smaller_in_body_than_in_pupils():
    # METHOD: an adult constant overestimates a six-year-old's depth 1.47 times by the body, 1.2 times by the pupils
    child = anthropometry._children(6, 6, 1.0)
    adult, _ = moments(populations("adults"))
    ratio = np.exp(adult - child.log_mean)
    assert ratio[LENGTHS.index("torso")] == pytest.approx(1.47, abs=0.02)
    assert ratio[LENGTHS.index("pupils")] == pytest.approx(1.2, abs=0.02)


def test_children_widen_the_mixture():
    assert rel_sd("stature", "mixed") > rel_sd("stature", "adults")
    assert median("stature", "children") < 1.4
    assert sum(g.weight for g in populations("mixed", 0.3) if g.name.startswith("children")) == pytest.approx(0.3)


def test_unknown_names_are_refused():
    with pytest.raises(SettingsError, match="giants"):
        populations("giants")
