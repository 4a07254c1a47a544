"""The protocol `v1`: the people found, and the errors of the distances between them, with nothing hidden.

- Detections and annotated people are matched one to one, at least total cost; the cost of a pair is the distance
  between its nearest common parts in units of the person's size, and beyond one unit there is no match. The order of
  neither list matters.
- Rows never move: a distance belongs to the two people it was measured between.
- Distances are along the ground; the error of those in space stands next to it.
- A photo without a scored pair is counted as unscored; it is neither 0 nor forgotten.
"""

from __future__ import annotations

import math
from statistics import median

import numpy as np
from numpy.typing import NDArray

from ..arrays import FloatArray
from ..assignment import assign
from ..people.skeleton import PARTS
from .image_score import ImageScore, relative_errors, upper
from .labels import LabelImage
from .predictions import Prediction

#: Distances between annotated points in units of that from the middle of the shoulders to the middle of the torso,
#: some 0.3 m: medians over the labels of the benchmark, where people show both.
_UNITS = {("Shoulder", "Torso"): 1.0, ("Head", "Shoulder"): 0.48, ("Eyes", "Shoulder"): 0.56,
          ("Head", "Torso"): 1.47, ("Eyes", "Torso"): 1.53}  # fmt: skip
#: A photo in which no person shows two parts far apart is a close-up: the unit is this share of its height.
_CLOSE_UP_SHARE = 1 / 8
#: Weight of the mean over all common parts, in addition to the nearest: decides where two people share an annotated
#: point.
_TIE_BREAK = 1e-3


def score_image(image: LabelImage, prediction: Prediction | None) -> ImageScore:
    """Score one photo; no answer is an answer without people."""
    prediction = prediction or Prediction.nobody(image.filename)
    detected, annotated = match(image, prediction)
    true = upper(image.distances_mm(ground=True)[np.ix_(annotated, annotated)])
    chosen = np.ix_(detected, detected)
    estimates = prediction.ground_distances_mm()
    estimated = upper(estimates[chosen])
    low, high = upper(prediction.low_mm[chosen]), upper(prediction.high_mm[chosen])
    scored = np.isfinite(estimated) & (true > 0)
    spatial_true = upper(image.distances_mm(ground=False)[np.ix_(annotated, annotated)])
    spatial = relative_errors(upper(prediction.spatial_distances_mm()[chosen])[scored], spatial_true[scored])
    everyone = upper(estimates)
    everyone = everyone[np.isfinite(everyone)]
    return ImageScore(
        label=image,
        n_detected=len(prediction),
        n_matched=len(detected),
        detection_rate=len(detected) / len(image),
        false_discovery_rate=(len(prediction) - len(detected)) / len(prediction) if len(prediction) else 0.0,
        pair_error_pct=_mean(relative_errors(estimated[scored], true[scored])),
        mean_distance_mm=_mean(everyone),
        true_mm=true[scored],
        estimated_mm=estimated[scored],
        low_mm=low[scored],
        high_mm=high[scored],
        annotated_mm=upper(image.distances_mm(ground=True)),
        spatial_error_pct=_mean(spatial),
    )


def _mean(values: FloatArray) -> float:
    return float(values.mean()) if len(values) else float("nan")


def match(image: LabelImage, prediction: Prediction) -> tuple[list[int], list[int]]:
    """Return the rows of the detections that show a person, and the rows of the annotated people they show."""
    points = prediction.points_at(image.width, image.height)
    order = _canonical_order(points, prediction)
    apart = np.linalg.norm(points[order][:, None] - image.parts_px[None], axis=-1)  # (D, P, part)
    apart = apart / person_sizes_px(image)[None, :, None]
    common = np.isfinite(apart)
    nearest = np.where(common, apart, np.inf).min(axis=-1, initial=np.inf)
    mean = np.where(common, apart, 0.0).sum(axis=-1) / np.maximum(common.sum(axis=-1), 1)
    possible = nearest < 1
    costs = np.where(possible, np.minimum(nearest + _TIE_BREAK * np.minimum(mean, 1.0), 1.0), 1.0)
    costs = costs.round(9)  # equal is equal, whatever the last digit is: the canonical order decides
    pairs = sorted((int(order[row]), column) for row, column in assign(costs) if possible[row, column])
    return [row for row, _ in pairs], [column for _, column in pairs]


def person_sizes_px(image: LabelImage) -> FloatArray:
    """Return each annotated person's unit, shape (P,): from the middle of the shoulders to that of the torso, pixels.

    The median over pairs of parts; a person who shows too little counts as large as the others in the photo.
    """
    estimates = np.stack([
        np.linalg.norm(image.parts_px[:, PARTS.index(a)] - image.parts_px[:, PARTS.index(b)], axis=-1) / unit
        for (a, b), unit in _UNITS.items()
    ])  # fmt: skip
    stated = [[value for value in column if math.isfinite(value)] for column in estimates.T.tolist()]
    known = [median(values) for values in stated if values]
    usual = median(known) if known else image.height * _CLOSE_UP_SHARE
    sizes = np.array([median(values) if values else usual for values in stated])
    return np.maximum(sizes, 1.0)


def _canonical_order(points: FloatArray, prediction: Prediction) -> NDArray[np.intp]:
    """Sort detections by their content, so that of two equally good ones the same is taken in any order."""
    distances = np.sort(prediction.ground_distances_mm(), axis=1)
    content = np.concatenate([points.reshape(len(points), 2 * len(PARTS)), prediction.positions_mm, distances], axis=1)
    return np.lexsort(np.nan_to_num(content, nan=-1.0).T[::-1])
