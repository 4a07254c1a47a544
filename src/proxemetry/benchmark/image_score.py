"""What one photo scores, whichever the protocol."""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..arrays import FloatArray
from .labels import LabelImage


@dataclass(frozen=True, eq=False)
class ImageScore:
    """One photo: counts, rates, and its scored pairs, n of them.

    true_mm, estimated_mm: shape (n,), in the protocol's distance. low_mm, high_mm: shape (n,), the stated central
    90 %, NaN where none is stated. spatial_error_pct: mean error of the 3D norm, next to that on the ground, NaN where
    the protocol has none. annotated_mm: shape (N,), the true distances of all annotated pairs, scored or not.
    pair_error_pct is NaN where no pair was scored and the protocol does not count 0.
    """

    label: LabelImage
    n_detected: int
    n_matched: int
    detection_rate: float
    false_discovery_rate: float
    pair_error_pct: float
    mean_distance_mm: float
    true_mm: FloatArray
    estimated_mm: FloatArray
    low_mm: FloatArray
    high_mm: FloatArray
    annotated_mm: FloatArray
    spatial_error_pct: float = math.nan

    @property
    def n_annotated(self) -> int:
        """People annotated in the photo."""
        return len(self.label)

    @property
    def n_pairs(self) -> int:
        """Pairs scored."""
        return len(self.true_mm)

    def to_dict(self) -> dict[str, Any]:
        """Return the photo's row of the score file, NaN as None."""
        row: dict[str, Any] = {
            "filename": self.label.filename, "n_annotated": self.n_annotated, "n_detected": self.n_detected,
            "n_matched": self.n_matched, "n_pairs": self.n_pairs, "pair_error_pct": finite(self.pair_error_pct),
            "detection_rate": self.detection_rate, "false_discovery_rate": self.false_discovery_rate,
            "mean_distance_mm": finite(self.mean_distance_mm),
        }  # fmt: skip
        return row


def finite(value: float) -> float | None:
    """Return a number as JSON has it: None for NaN."""
    return float(value) if math.isfinite(value) else None


def relative_errors(estimated: FloatArray, true: FloatArray) -> FloatArray:
    """Return |estimated - true| / true in per cent, shape (n,) (Seker et al. 2021, section 3.3, with the modulus)."""
    return np.abs(estimated - true) / true * 100.0


def upper(matrix: FloatArray) -> FloatArray:
    """Return what stands above the diagonal of a square matrix, row by row."""
    return matrix[_above_diagonal(len(matrix))]


@functools.cache
def _above_diagonal(size: int) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    rows, columns = np.triu_indices(size, 1)
    return rows, columns
