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


def test_shoulder_joints_lie_below_the_acromion():
    """ANSUR II's acromial height less de Leva's 38 mm, with its own spread; 0.8 of the stature."""
    for sex, (acromial_m, sd_m) in {"men": (1.441, 0.063), "women": (1.335, 0.058)}.items():
        height = anthropometry.JOINT_LENGTHS[sex]["shoulder_height"]
        assert (height.mean_m, height.sd_m) == pytest.approx((acromial_m - 0.038, sd_m))
        assert height.mean_m / anthropometry.JOINT_LENGTHS[sex]["stature"].mean_m == pytest.approx(0.797, abs=0.004)


@pytest.mark.parametrize("share", [0.05, 0.4, 1.0])
def test_children_are_a_mixtures_share_of_it(share):
    mixed = populations("mixed", share)
    young = [g for g in mixed if g.name.startswith("children")]
    assert sum(g.weight for g in mixed) == pytest.approx(1) and sum(g.weight for g in young) == pytest.approx(share)
    assert len({g.weight for g in young}) == 1  # of every age as many
    grown = {g.name: g.weight for g in mixed if g not in young}
    assert grown == pytest.approx({"women": (1 - share) / 2, "men": (1 - share) / 2} if share < 1 else {})
    ages = [np.exp(g.log_mean[0]) for g in young]
    assert ages == sorted(ages) and 0.85 < ages[0] < 1.05 and 1.38 < ages[2] < 1.64  # of 2 to 5, and of 10 to 14


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
