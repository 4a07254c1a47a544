"""How sure it is that a sighting is a person: one logistic function of the networks' outputs."""

from __future__ import annotations

import math

from .search import Sighting

_FACE, _TORSO = [0, 2, 5, 7, 8], [11, 12, 23, 24]
_LIMBS = [13, 14, 15, 16, 25, 26, 27, 28]

# Feature: (mean, standard deviation, weight of the standardised feature). A logistic regression made with the
# measured prototype on its candidates from hand-labelled photos, taken over but for two features that counted its
# windows (their usual values are in the bias); the photos of the published count may have been among them. Heat map
# peaks at the torso and the face weigh most. A new one with the person detector's score and overlap as features, each
# photo judged by a fit to the others, separated people from the rest no better than this one with the rule for boxes.
_BIAS = 2.3047
_FEATURES = {
    "flag": (4.2956, 3.3254, 0.0862),
    "first_flag": (3.1954, 3.2691, -0.1961),
    "face_peaks": (0.6363, 0.2012, 0.5810),
    "torso_peaks": (0.4898, 0.1655, 1.1524),
    "limb_peaks": (0.4642, 0.1366, 0.2991),
    "detection": (0.1903, 0.2996, 0.2676),
    "face": (0.4240, 0.3741, 1.0256),
    "face_visibility": (0.9824, 0.0581, 0.1638),
    "visibility": (0.7744, 0.1224, -0.1682),
    "presence": (0.9746, 0.0751, 0.0798),
    "silhouette": (-2.0204, 0.4915, 0.6313),
    "drift": (0.0628, 0.0482, -0.1266),
    "growth": (0.0643, 0.0467, 0.4508),
}

# A first look below LIKELY is not worth a second. Over both looks the mean must exceed PERSON_MINIMUM: 0.5 let a play
# tower and a group of statues pass in cut-outs of photos without people, 0.6 nothing.
LIKELY, PERSON_MINIMUM = 0.35, 0.6

# Where there is a person detector a person must fill one of its boxes: overlap times score. A teddy bear has 0.04, a
# statue 0.09, nine in ten people more than 0.1; with that much even odds are enough.
SUPPORTED, WELL_SUPPORTED, PERSON_MINIMUM_IN_BOX = 0.05, 0.1, 0.5


def person_score(sighting: Sighting) -> float:
    """Return the probability that a sighting is a person."""
    seen = sighting.candidate
    assert seen.mask is not None  # a sighting's candidate is no quick look
    a, b = seen.region, seen.next_region
    values = {
        "flag": _logit(seen.flag),
        "first_flag": _logit(sighting.first_flag),
        "face_peaks": seen.peaks[_FACE].mean(),
        "torso_peaks": seen.peaks[_TORSO].mean(),
        "limb_peaks": seen.peaks[_LIMBS].mean(),
        "detection": sighting.detection,
        "face": sighting.face,
        "face_visibility": seen.visibility[_FACE].mean(),
        "visibility": seen.visibility.mean(),
        "presence": seen.presence.mean(),
        "silhouette": math.log((seen.mask > 0.5).mean() + 0.01),
        "drift": min(math.hypot(a.x - b.x, a.y - b.y) / a.size, 0.5),
        "growth": min(abs(math.log(b.size / a.size)), 0.7),
    }
    total = _BIAS
    for name, (mean, deviation, weight) in _FEATURES.items():
        total += weight * (float(values[name]) - mean) / deviation
    return 1 / (1 + math.exp(-total))


def _logit(probability: float) -> float:
    clipped = min(max(probability, 1e-4), 1 - 1e-4)
    return math.log(clipped / (1 - clipped))
