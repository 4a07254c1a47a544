"""How long people are: body lengths with their spread and how they go together, for adults and children.

Adults: ANSUR II (Gordon et al., 2012 Anthropometric Survey of U.S. Army Personnel, 4082 men and 1986 women).
Children: CDC growth charts (Kuczmarski et al. 2002), medians and standard deviations of stature. Two kinds of length:
landmarks that an anthropometer touches, and joints as keypoint detectors place them. Triangulated from calibrated
views of 15 people those are .524 m from the middle of the shoulders to the middle of the hips and .347 m from shoulder
to shoulder; anatomy has the joints' centres .48-.50 m and .34 m apart. Neither sample is the population: the means lie
between, and the torso's spread has the doubt about where a detector's hips are added. Correlations are those of the
landmark length that is nearest.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache

import numpy as np

from .arrays import FloatArray
from .errors import SettingsError

#: Lengths of the joint distribution, in its order; metres. `torso`, `shoulders` and `head` are between joints as
#: detectors place them, `shoulder_height` is theirs above the sole; `pupils` is the interpupillary distance.
LENGTHS = ("stature", "shoulder_height", "torso", "shoulders", "pupils", "head")

#: The prior weight of children where a population has both: an assumption and a setting (docs/method.md, "Priors").
CHILD_WEIGHT = 0.05


@dataclass(frozen=True)
class Length:
    """A body length: mean and standard deviation in metres."""

    mean_m: float
    sd_m: float

    @property
    def rel_sd(self) -> float:
        """The coefficient of variation."""
        return self.sd_m / self.mean_m


@dataclass(frozen=True, eq=False)
class Population:
    """A group whose log lengths are jointly Gaussian.

    weight: its share of the body size it is part of. log_mean: shape (L,), logarithms of metres, in the order of
    `LENGTHS`. log_covariance: shape (L, L).
    """

    name: str
    weight: float
    log_mean: FloatArray
    log_covariance: FloatArray


#: What an anthropometer measures: landmark lengths in metres (ANSUR II 2012).
LANDMARKS: Mapping[str, Mapping[str, Length]] = {
    "men": {
        "stature": Length(1.756, 0.069),
        "biacromial": Length(0.416, 0.019),
        "interpupillary": Length(0.0640, 0.0034),
        "acromial_height": Length(1.441, 0.063),
        "acromion_trochanterion": Length(0.540, 0.033),
    },
    "women": {
        "stature": Length(1.629, 0.064),
        "biacromial": Length(0.365, 0.018),
        "interpupillary": Length(0.0617, 0.0036),
        "acromial_height": Length(1.335, 0.058),
        "acromion_trochanterion": Length(0.490, 0.029),
    },
}

# The glenohumeral joint centre lies about 38 mm below the acromion (de Leva 1996).
_ACROMION_TO_JOINT_M = 0.038
# Detected joint length over landmark length, equal weights of women and men.
_TORSO_RATIO, _SHOULDERS_RATIO = 0.510 / 0.515, 0.344 / 0.3905
# How unsure it is where a detector's hips are, of the torso: half of what lies between anatomy and triangulation.
_HIPS_DOUBT = 0.03

#: Means and standard deviations of `LENGTHS` by sex, metres: ANSUR II, scaled to joints triangulated from calibrated
#: views.
JOINT_LENGTHS: Mapping[str, Mapping[str, Length]] = {
    sex: {
        "stature": table["stature"],
        "shoulder_height": Length(
            table["acromial_height"].mean_m - _ACROMION_TO_JOINT_M, table["acromial_height"].sd_m
        ),
        "torso": Length(
            table["acromion_trochanterion"].mean_m * _TORSO_RATIO,
            table["acromion_trochanterion"].mean_m * _TORSO_RATIO
            * float(np.hypot(table["acromion_trochanterion"].rel_sd, _HIPS_DOUBT)),
        ),
        "shoulders": Length(
            table["biacromial"].mean_m * _SHOULDERS_RATIO, table["biacromial"].sd_m * _SHOULDERS_RATIO
        ),
        "pupils": table["interpupillary"],
        "head": Length({"men": 0.157, "women": 0.147}[sex], 0.0063),
    }
    for sex, table in LANDMARKS.items()
}  # fmt: skip

# Correlations within a sex, in the order of LENGTHS. Stature's row, biacromial-torso .28 and pupils-biacromial .25 are
# ANSUR II's; the head's are of bitragion breadth, rounded.
_CORRELATION = np.array([
    [1.00, 0.97, 0.60, 0.55, 0.19, 0.28],
    [0.97, 1.00, 0.61, 0.55, 0.18, 0.27],
    [0.60, 0.61, 1.00, 0.28, 0.12, 0.18],
    [0.55, 0.55, 0.28, 1.00, 0.25, 0.25],
    [0.19, 0.18, 0.12, 0.25, 1.00, 0.40],
    [0.28, 0.27, 0.18, 0.25, 0.40, 1.00],
])  # fmt: skip

#: Ages in years, and the median and standard deviation of stature in metres (CDC growth charts 2000).
CHILD_AGES = (2, 4, 6, 8, 10, 12, 14, 16, 18)
CHILD_STATURES: Mapping[str, tuple[Length, ...]] = {
    "boys": tuple(Length(m, s) for m, s in (
        (0.865, 0.035), (1.025, 0.042), (1.157, 0.051), (1.281, 0.058), (1.388, 0.066), (1.493, 0.075),
        (1.641, 0.080), (1.736, 0.075), (1.762, 0.072))),
    "girls": tuple(Length(m, s) for m, s in (
        (0.850, 0.035), (1.010, 0.044), (1.150, 0.052), (1.278, 0.058), (1.382, 0.066), (1.515, 0.074),
        (1.605, 0.066), (1.626, 0.065), (1.631, 0.065))),
}  # fmt: skip
# Children's bodies are adults' scaled by stature but for the head, which is nearly full-grown early, and the legs.
# By age: interpupillary distance, metres ("The development of norms of pediatric interpupillary
# distance", Pacific University 1993: 47.5 mm in the third year, 51 mm in the fifth and sixth; adults as above).
_CHILD_PUPILS = ((2, 5, 18), (0.0475, 0.051, 0.063))
# Head breadth relative to an adult's and the shoulders' height as a share of stature: assumed, ends at the adults'
# means. Snyder et al. 1977 (UM-HSRI-77-17) have measured ones.
_CHILD_HEAD = ((2, 6, 18), (0.88, 0.94, 1.0))
_CHILD_SHOULDER_HEIGHT = ((2, 6, 12, 18), (0.735, 0.765, 0.785, 0.797))
#: From then on statures are within the adults' spread (CDC: 1.61 and 1.64 m at 14).
_OLDEST_CHILD = 14


@cache
def populations(body_size: str, child_weight: float = CHILD_WEIGHT) -> tuple[Population, ...]:
    """Return the groups that a body size (`locate.BODY_SIZES`) is a mixture of; their weights sum to one.

    "adults" is half women, half men; "mixed" also has `child_weight` of children; "children" are 2 to 14 years old
    in three groups of ages. Raises SettingsError for another name.
    """
    adults = (_adults("women", 0.5), _adults("men", 0.5))
    if body_size in ("women", "men"):
        return (_adults(body_size, 1.0),)
    if body_size == "adults":
        return adults
    if body_size in ("mixed", "children"):
        share = child_weight if body_size == "mixed" else 1.0
        children = tuple(_children(*ages, share / 3) for ages in ((2, 5), (6, 9), (10, _OLDEST_CHILD)))
        grown = tuple(_adults(p.name, p.weight * (1 - share)) for p in adults) if share < 1 else ()
        return (*grown, *children)
    raise SettingsError(f"body size {body_size!r} is unknown: use adults, women, men, mixed or children")


def moments(groups: tuple[Population, ...]) -> tuple[FloatArray, FloatArray]:
    """Return mean (L,) and covariance (L, L) of the log lengths of a mixture, whatever its weights sum to."""
    weights = np.array([g.weight for g in groups]) / sum(g.weight for g in groups)
    mean = sum((w * g.log_mean for w, g in zip(weights, groups, strict=True)), np.zeros(len(LENGTHS)))
    covariance = np.zeros((len(LENGTHS), len(LENGTHS)))
    for weight, group in zip(weights, groups, strict=True):
        apart = group.log_mean - mean
        covariance += weight * (group.log_covariance + np.outer(apart, apart))
    return mean, covariance


def _adults(sex: str, weight: float) -> Population:
    lengths = [JOINT_LENGTHS[sex][name] for name in LENGTHS]
    rel_sd = np.array([entry.rel_sd for entry in lengths])
    # the mean of a log-normal is exp(mu + var / 2)
    log_mean = np.log([entry.mean_m for entry in lengths]) - rel_sd**2 / 2
    return Population(sex, weight, log_mean, _CORRELATION * np.outer(rel_sd, rel_sd))


def _children(youngest: int, oldest: int, weight: float) -> Population:
    """Return the children between two ages, both sexes alike, as one Gaussian over the ages."""
    adult_mean, _ = moments((_adults("women", 0.5), _adults("men", 0.5)))
    adult_rel_sd = np.array([np.mean([JOINT_LENGTHS[s][n].rel_sd for s in JOINT_LENGTHS]) for n in LENGTHS])
    groups: list[Population] = []
    for statures in CHILD_STATURES.values():
        for age in np.arange(youngest, oldest + 0.5):
            mean_m = float(np.interp(age, CHILD_AGES, [s.mean_m for s in statures]))
            rel_sd = float(np.interp(age, CHILD_AGES, [s.rel_sd for s in statures]))
            log_mean = adult_mean + np.log(mean_m) - adult_mean[0]
            log_mean[LENGTHS.index("shoulder_height")] = np.log(mean_m * np.interp(age, *_CHILD_SHOULDER_HEIGHT))
            log_mean[LENGTHS.index("pupils")] = np.log(np.interp(age, *_CHILD_PUPILS))
            log_mean[LENGTHS.index("head")] = adult_mean[LENGTHS.index("head")] + np.log(np.interp(age, *_CHILD_HEAD))
            spread = adult_rel_sd * (rel_sd / adult_rel_sd[0])
            spread[-2:] = adult_rel_sd[-2:]  # pupils and head vary among children as among adults
            groups.append(Population("child", 1.0, log_mean, _CORRELATION * np.outer(spread, spread)))
    mean, covariance = moments(tuple(groups))
    return Population(f"children {youngest}-{oldest}", weight, mean, covariance)
