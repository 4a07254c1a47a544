"""Focal lengths of published photos: what is expected of a photo without any evidence."""

from __future__ import annotations

import math
from statistics import NormalDist

import numpy as np

from ..arrays import FloatArray

#: The most frequent 35 mm equivalent, and the standard deviations of its logarithm below and above: quantiles (5, 25,
#: 50, 75, 95 %) 19, 27, 37, 54 and 101 mm. A judgement between three kinds of counts. Phones' main cameras have 24 to
#: 28 mm. Of 6,300 holiday photos taken with a 28-300 mm zoom (fengraphy.blogspot.com, April 2012), 20 % were at 28 mm,
#: 60 % from 28 to 70, 30 % from 70 to 200, 9 % at 300. Newspapers work with zooms of 24-70 and 70-200 mm.
MODE_MM, BELOW_SD, ABOVE_SD = 28.5, 0.30, 0.70


def log_density(log_equivalent_mm: FloatArray) -> FloatArray:
    """Return the log density of log 35 mm equivalents, up to a constant: two halves of normal distributions."""
    away = log_equivalent_mm - math.log(MODE_MM)
    return -0.5 * (away / np.where(away < 0, BELOW_SD, ABOVE_SD)) ** 2


def quantile_mm(share: float) -> float:
    """Return the 35 mm equivalent below which this share of published photos is expected."""
    below = BELOW_SD / (BELOW_SD + ABOVE_SD)
    if share < below:
        return MODE_MM * math.exp(BELOW_SD * NormalDist().inv_cdf(share / (2 * below)))
    return MODE_MM * math.exp(-ABOVE_SD * NormalDist().inv_cdf((1 - share) / (2 * (1 - below))))
