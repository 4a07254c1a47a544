"""The one level of every interval that is stated, and what follows from it for a normal distribution."""

import math
from statistics import NormalDist

#: The share of cases that an interval encloses.
LEVEL = 0.9

#: The quantiles at which a central interval ends.
LOW, HIGH = (1 - LEVEL) / 2, (1 + LEVEL) / 2

#: Half the width of a normal distribution's central interval, in standard deviations: 1.6449.
HALF_WIDTH_SD = NormalDist().inv_cdf(HIGH)

#: The squared radius, in standard deviations, that encloses this share of a normal distribution in two dimensions: the
#: quantile of chi-squared with 2 degrees of freedom, 4.605.
CHI2_2D = -2 * math.log(1 - LEVEL)
