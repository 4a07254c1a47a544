"""What a set of photos scores: pure functions from `ImageScore`s to numbers. Each name states how it averages."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..arrays import FloatArray
from ..distances import ZONE_LIMITS_M, ZONES
from .bootstrap import median_interval, ratio_intervals
from .image_score import ImageScore, finite, relative_errors

#: Seker et al. 2021, table 6: thresholds of the binary question, metres.
F1_THRESHOLDS_M = (1.0, 1.5, 2.0, 3.0)
#: The best single answer for KORTE's pairs.
CONSTANT_MM = 1700.0
#: Edges of the bins of the error over the true distance, millimetres.
DISTANCE_EDGES_MM = (0.0, 1000.0, 1500.0, 2000.0, 2500.0, 3000.0, 4000.0, math.inf)


@dataclass(frozen=True)
class Bin:
    """The pairs whose true distance lies in [low_mm, high_mm)."""

    low_mm: float
    high_mm: float
    n_pairs: int
    error_pct_mean: float
    error_pct_median: float
    bias_pct: float


@dataclass(frozen=True)
class Summary:
    """What a set of photos scores. Ratios are NaN where there is nothing to divide by.

    n_unscored: photos without a scored pair. pair_recall: scored pairs over annotated ones. coverage_90: share of
    scored pairs with a stated interval that holds the true distance. confusion: shape (4, 4), true zone by row. ci95:
    name -> bootstrap interval over photos.
    """

    n_images: int
    n_unscored: int
    n_annotated: int
    n_detected: int
    n_matched: int
    n_annotated_pairs: int
    n_pairs: int
    n_intervals: int
    pair_error_pct_mean_over_images: float
    pair_error_pct_mean_over_pairs: float
    pair_error_pct_median_over_pairs: float
    pair_error_3d_pct_mean_over_images: float
    signed_bias_pct: float
    log_ratio_abs_mean: float
    log_ratio_mean: float
    log_ratio_sd: float
    detection_rate: float
    false_discovery_rate: float
    pair_recall: float
    baseline_constant_pct: float
    coverage_90: float
    interval_width_mm_mean: float
    f1: dict[str, float]
    confusion: tuple[tuple[int, ...], ...]
    by_distance: tuple[Bin, ...]
    ci95: dict[str, tuple[float, float]] = field(default_factory=dict[str, tuple[float, float]])

    def to_dict(self) -> dict[str, Any]:
        """Return the figures as JSON values: NaN as null."""
        answer: dict[str, Any] = {}
        for name, value in self.__dict__.items():
            if isinstance(value, float):
                answer[name] = finite(value)
            elif isinstance(value, int):
                answer[name] = value
        answer["baseline_constant_mm"] = CONSTANT_MM
        answer["f1"] = {threshold: finite(value) for threshold, value in self.f1.items()}
        answer["zones"] = {"names": list(ZONES), "confusion": [list(row) for row in self.confusion]}
        answer["by_distance"] = [
            {key: finite(value) if isinstance(value, float) else value for key, value in b.__dict__.items()}
            for b in self.by_distance
        ]
        answer["ci95"] = {name: [finite(low), finite(high)] for name, (low, high) in self.ci95.items()}
        return answer


def summarise(images: Sequence[ImageScore], rates_over_images: bool, bootstrap: bool = True) -> Summary:
    """Sum up photos. Rates are means over photos where `rates_over_images`, else ratios of sums."""
    pooled = _Pooled.of(images)
    true, estimated = pooled.true_mm, pooled.estimated_mm
    errors, ratios = relative_errors(estimated, true), _log_ratios(estimated, true)
    stated = np.isfinite(pooled.low_mm) & np.isfinite(pooled.high_mm)
    held = (pooled.low_mm <= true) & (true <= pooled.high_mm)
    return Summary(
        n_images=len(images),
        n_unscored=sum(image.n_pairs == 0 for image in images),
        n_annotated=sum(image.n_annotated for image in images),
        n_detected=sum(image.n_detected for image in images),
        n_matched=sum(image.n_matched for image in images),
        n_annotated_pairs=sum(len(image.annotated_mm) for image in images),
        n_pairs=len(true),
        n_intervals=int(stated.sum()),
        pair_error_pct_mean_over_images=_mean([image.pair_error_pct for image in images]),
        pair_error_pct_mean_over_pairs=_mean(errors),
        pair_error_pct_median_over_pairs=float(np.median(errors)) if len(errors) else math.nan,
        pair_error_3d_pct_mean_over_images=_mean([image.spatial_error_pct for image in images]),
        signed_bias_pct=_mean((estimated - true) / true * 100),
        log_ratio_abs_mean=_mean(np.abs(ratios)),
        log_ratio_mean=_mean(ratios),
        log_ratio_sd=float(np.nanstd(ratios)) if np.isfinite(ratios).any() else math.nan,
        detection_rate=_detection(images, rates_over_images),
        false_discovery_rate=_false_discovery(images, rates_over_images),
        pair_recall=_ratio(len(true), sum(len(image.annotated_mm) for image in images)),
        baseline_constant_pct=_baseline(images, rates_over_images),
        coverage_90=_mean(held[stated].astype(float)),
        interval_width_mm_mean=_mean((pooled.high_mm - pooled.low_mm)[stated]),
        f1={f"{t:.1f}": f1(estimated < t * 1000, true < t * 1000) for t in F1_THRESHOLDS_M},
        confusion=zone_confusion(estimated, true),
        by_distance=error_by_distance(estimated, true),
        ci95=_bootstrap(images, pooled, rates_over_images) if bootstrap and images else {},
    )


@dataclass(frozen=True, eq=False)
class _Pooled:
    """The scored pairs of all photos in one row each; `image` is the photo's number."""

    image: NDArray[np.intp]
    true_mm: FloatArray
    estimated_mm: FloatArray
    low_mm: FloatArray
    high_mm: FloatArray

    @classmethod
    def of(cls, images: Sequence[ImageScore]) -> _Pooled:
        def joined(attribute: str) -> FloatArray:
            return np.concatenate([np.zeros(0), *(getattr(image, attribute) for image in images)])

        number = np.repeat(np.arange(len(images)), [image.n_pairs for image in images])
        return cls(number, *(joined(name) for name in ("true_mm", "estimated_mm", "low_mm", "high_mm")))


def f1(estimated: NDArray[np.bool_], true: NDArray[np.bool_]) -> float:
    """Return the F1 score of a yes-or-no answer, each of shape (n,); NaN where neither is ever yes."""
    hits = float((estimated & true).sum())
    return _ratio(2 * hits, float(estimated.sum() + true.sum()))


def zone_confusion(estimated_mm: FloatArray, true_mm: FloatArray) -> tuple[tuple[int, ...], ...]:
    """Return how many pairs of each true zone (row) were put into each zone (column), in the order of `ZONES`."""
    table = np.zeros((len(ZONES), len(ZONES)), dtype=int)
    np.add.at(table, (_zone_rows(true_mm), _zone_rows(estimated_mm)), 1)
    return tuple(tuple(int(n) for n in row) for row in table)


def _zone_rows(distances_mm: FloatArray) -> NDArray[np.intp]:
    return np.searchsorted(ZONE_LIMITS_M, distances_mm / 1000, side="right")


def error_by_distance(
    estimated_mm: FloatArray, true_mm: FloatArray, edges_mm: Sequence[float] = DISTANCE_EDGES_MM
) -> tuple[Bin, ...]:
    """Return the errors of the pairs between each two edges (figure 7 of the paper, in bins)."""
    bins: list[Bin] = []
    for low, high in itertools.pairwise(edges_mm):
        here = (true_mm >= low) & (true_mm < high)
        errors = relative_errors(estimated_mm[here], true_mm[here])
        bias = _mean((estimated_mm[here] - true_mm[here]) / true_mm[here] * 100)
        middle = float(np.median(errors)) if len(errors) else math.nan
        bins.append(Bin(low, high, len(errors), _mean(errors), middle, bias))
    return tuple(bins)


def _log_ratios(estimated: FloatArray, true: FloatArray) -> FloatArray:
    """ln(estimated / true); NaN where the estimate is 0 and has no logarithm."""
    return np.log(np.where(estimated > 0, estimated, np.nan) / true)


def _mean(values: Sequence[float] | FloatArray) -> float:
    """The mean of what is not NaN."""
    array = np.asarray(values, dtype=float)
    known = array[np.isfinite(array)]
    return float(known.mean()) if len(known) else math.nan


def _ratio(above: float, below: float) -> float:
    return above / below if below else math.nan


def _detection(images: Sequence[ImageScore], over_images: bool) -> float:
    if over_images:
        return _mean([image.detection_rate for image in images])
    return _ratio(sum(image.n_matched for image in images), sum(image.n_annotated for image in images))


def _false_discovery(images: Sequence[ImageScore], over_images: bool) -> float:
    if over_images:
        return _mean([image.false_discovery_rate for image in images])
    detected = sum(image.n_detected for image in images)
    return _ratio(detected - sum(image.n_matched for image in images), detected) if detected else 0.0


def _baseline(images: Sequence[ImageScore], empty_is_zero: bool) -> float:
    """Return the mean over photos of the error of answering `CONSTANT_MM` for every annotated pair."""
    nothing = 0.0 if empty_is_zero else math.nan
    apart = [image.annotated_mm[image.annotated_mm > 0] for image in images]
    return _mean([float(np.abs(CONSTANT_MM / true - 1).mean() * 100) if len(true) else nothing for true in apart])


def _bootstrap(images: Sequence[ImageScore], pooled: _Pooled, over_images: bool) -> dict[str, tuple[float, float]]:
    """Return 95 % intervals from photos drawn again with replacement, the same draws for every figure."""
    count = len(images)
    errors = relative_errors(pooled.estimated_mm, pooled.true_mm)
    bias = (pooled.estimated_mm - pooled.true_mm) / pooled.true_mm * 100
    stated = np.isfinite(pooled.low_mm) & np.isfinite(pooled.high_mm)
    held = stated & (pooled.low_mm <= pooled.true_mm) & (pooled.true_mm <= pooled.high_mm)

    def summed(values: FloatArray) -> FloatArray:
        return np.bincount(pooled.image, values, minlength=count).astype(float)

    image_errors = np.array([image.pair_error_pct for image in images])
    known = np.isfinite(image_errors).astype(float)
    pairs = summed(np.ones(len(errors)))
    ratios: dict[str, tuple[FloatArray, FloatArray]] = {
        "pair_error_pct_mean_over_images": (np.nan_to_num(image_errors), known),
        "pair_error_pct_mean_over_pairs": (summed(errors), pairs),
        "signed_bias_pct": (summed(bias), pairs),
        "coverage_90": (summed(held.astype(float)), summed(stated.astype(float))),
        "pair_recall": (pairs, np.array([len(image.annotated_mm) for image in images], dtype=float)),
        "detection_rate": _parts(
            images, over_images, lambda i: i.detection_rate, lambda i: (i.n_matched, i.n_annotated)
        ),
        "false_discovery_rate": _parts(
            images, over_images, lambda i: i.false_discovery_rate, lambda i: (i.n_detected - i.n_matched, i.n_detected)
        ),
    }  # fmt: skip
    return ratio_intervals(ratios, count) | {
        "pair_error_pct_median_over_pairs": median_interval(errors, pooled.image, count)
    }


def _parts(
    images: Sequence[ImageScore], over_images: bool, rate: Callable[[ImageScore], float],
    counts: Callable[[ImageScore], tuple[int, int]],
) -> tuple[FloatArray, FloatArray]:  # fmt: skip
    if over_images:
        return np.array([rate(image) for image in images]), np.ones(len(images))
    above, below = np.array([counts(image) for image in images], dtype=float).T
    return above, below
