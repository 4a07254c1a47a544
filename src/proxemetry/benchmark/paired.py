"""Two methods on the same photos: how much better one is, and how sure that is."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from ..errors import SettingsError
from .bootstrap import Interval, ratio_intervals
from .image_score import finite
from .scores import Score


@dataclass(frozen=True)
class Difference:
    """A method's pair error less another's, over the photos that both score.

    pair_error_pct_mean_over_images: the mean of the photos' differences, negative where the first errs less; NaN where
    no photo is scored by both. ci95: its bootstrap interval over photos. Some photos are hard for every method, so that
    two methods may differ for sure although the intervals of their errors overlap.
    """

    n_images: int
    pair_error_pct_mean_over_images: float
    ci95: Interval

    def to_dict(self) -> dict[str, Any]:
        """Return the figures as JSON values: NaN as null."""
        return {
            "n_images": self.n_images,
            "pair_error_pct_mean_over_images": finite(self.pair_error_pct_mean_over_images),
            "ci95": [finite(bound) for bound in self.ci95],
        }


def difference(score: Score, other: Score) -> Difference:
    """Return how much more `score` errs than `other`, photo by photo.

    A photo without a scored pair counts under neither protocol here: the published one's 0 is no answer.

    Raises SettingsError where they were not scored under one protocol on the same photos.
    """
    if score.protocol != other.protocol or [i.label.filename for i in score.images] != [
        i.label.filename for i in other.images
    ]:
        raise SettingsError("two scores are compared under one protocol and on the same labels")
    both = np.array([a.n_pairs > 0 < b.n_pairs for a, b in zip(score.images, other.images, strict=True)], dtype=bool)
    apart = [a.pair_error_pct - b.pair_error_pct for a, b in zip(score.images, other.images, strict=True)]
    known = np.where(both, apart, 0.0)
    count = int(both.sum())
    if not count:
        return Difference(0, float("nan"), (float("nan"), float("nan")))
    interval = ratio_intervals({"difference": (known, both.astype(float))}, len(known))["difference"]
    return Difference(count, float(known.sum()) / count, interval)
