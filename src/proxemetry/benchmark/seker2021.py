"""The evaluation as its authors published it, peculiarities included, to compare with published numbers.

After the public code of Seker, Männistö, Iosifidis and Raitoharju (*Automatic Social Distance Estimation From
Images*, 2021). What it does that one would not expect, all kept here:

- A detected person goes to the nearest annotated point over the parts given, however far; where several claim the
  same person the nearest stays (the first, where equally near) and the others are dropped.
- Dropping shortens the list of tags, not the list of locations: the person after a dropped one gets the location
  of a neighbour. Distances given instead of locations are shifted in the same way.
- A pixel coordinate of exactly 0 is missing. Where one person has no point at all, the photo's error is 0.
- A location of exactly (0, 0, 0) counts as detected but is left out of the error.
- A photo without a pair has error 0, and that 0 is averaged in.
- Rates come from counts alone: whether a detection is the right person does not matter.
- Given distances instead of locations, a photo with fewer than two people, with a pair missing, or with a person
  without a point scores 0 in everything.

People without a position were never handed to that code by any method, so they are left out here. Where it would stop
with an exception (none of a person's parts is annotated for any person in the photo), the person is left out of the
error and still takes a place in the list.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from ..arrays import FloatArray
from ..people.skeleton import PARTS
from .image_score import ImageScore, relative_errors, upper
from .labels import LabelImage
from .predictions import Prediction

_FARTHEST_PX = 1_000_000.0
#: The order in which the parts are compared: of equally near points the first wins.
_ORDER = ("Shoulder", "Eyes", "Torso", "Head")


def score_image(image: LabelImage, prediction: Prediction | None) -> ImageScore:
    """Score one photo; no answer is an answer without people."""
    prediction = prediction or Prediction.nobody(image.filename)
    if prediction.distances_mm is not None and not prediction.has_positions:
        return _score_distances(image, prediction, prediction.distances_mm)
    given = np.isfinite(prediction.positions_mm).all(axis=1)
    points = _scaled_points(prediction, image)[given]
    positions = prediction.positions_mm[given]
    pairs: list[tuple[str, str, float]] = []
    matched = 0
    if not _someone_has_no_point(points):
        tags = _tags_after_duplicates(points, image)
        matched = sum(tag is not None for tag in tags)
        # Here the lists part: `tags` may be shorter than `positions`, and the first of each belong together.
        placed = [(tag, place) for tag, place in zip(tags, positions, strict=False) if np.any(place != 0)]
        pairs = [
            (a, b, float(np.linalg.norm(p - q)))
            for k, (a, p) in enumerate(placed)
            for b, q in placed[k + 1 :]
            if a is not None and b is not None
        ]
    between = upper(np.linalg.norm(positions[:, None] - positions[None], axis=-1))
    return _answer(image, len(positions), matched, pairs, float(between.mean()) if len(between) else 0.0)


def _score_distances(image: LabelImage, prediction: Prediction, distances_mm: FloatArray) -> ImageScore:
    points = _scaled_points(prediction, image)
    given = upper(distances_mm)
    if len(points) < 2 or not np.isfinite(given).all() or _someone_has_no_point(points):
        return _answer(image, 0, 0, [], 0.0)
    tags = _tags_after_duplicates(points, image)
    # The distances are consumed in order, no matter which people were dropped before.
    running: Iterator[float] = iter(given.tolist())
    pairs = [(a, b, next(running)) for k, a in enumerate(tags) for b in tags[k + 1 :]]
    known = [(a, b, d) for a, b, d in pairs if a is not None and b is not None]
    return _answer(image, len(points), sum(tag is not None for tag in tags), known, float(given.mean()))


def _scaled_points(prediction: Prediction, image: LabelImage) -> FloatArray:
    """Shape (P, 4, 2), in pixels of the label's size; missing points are (0, 0)."""
    return np.nan_to_num(prediction.points_at(image.width, image.height), nan=0.0)


def _someone_has_no_point(points: FloatArray) -> bool:
    return bool((points == 0).all(axis=(1, 2)).any())


def _tags_after_duplicates(points: FloatArray, image: LabelImage) -> list[str | None]:
    """Return the person that each detection shows, without later claimants."""
    claims = [_nearest(person, image) for person in points]
    best: dict[str | None, int] = {}
    for k, (tag, distance) in enumerate(claims):
        if tag not in best or distance < claims[best[tag]][1]:
            best[tag] = k
    return [tag for k, (tag, _) in enumerate(claims) if best[tag] == k]


def _nearest(person: FloatArray, image: LabelImage) -> tuple[str | None, float]:
    """Return the tag of the nearest annotated point over the parts given, and how far it is in pixels."""
    tag, nearest = None, _FARTHEST_PX
    for part in _ORDER:
        x, y = person[PARTS.index(part)]
        if x == 0 or y == 0:
            continue
        for mark in image.marks:
            if mark.part == part:
                distance = math.sqrt((x - mark.x) ** 2 + (y - mark.y) ** 2)
                if distance < nearest:
                    tag, nearest = mark.tag, distance
    return tag, nearest


def _answer(
    image: LabelImage, n_detected: int, n_matched: int, pairs: list[tuple[str, str, float]], mean_distance_mm: float
) -> ImageScore:
    true = np.array([math.dist(image.places_mm[a], image.places_mm[b]) for a, b, _ in pairs], dtype=float)
    estimated = np.array([distance for _, _, distance in pairs], dtype=float)
    unknown = np.full(len(pairs), np.nan)
    annotated = len(image)
    return ImageScore(
        label=image,
        n_detected=n_detected,
        n_matched=n_matched,
        detection_rate=min(1.0, n_detected / annotated),
        false_discovery_rate=max(0, n_detected - annotated) / n_detected if n_detected else 0.0,
        pair_error_pct=float(relative_errors(estimated, true).mean()) if pairs else 0.0,
        mean_distance_mm=mean_distance_mm,
        true_mm=true,
        estimated_mm=estimated,
        low_mm=unknown,
        high_mm=unknown,
        annotated_mm=upper(image.distances_mm(ground=False)),
    )
