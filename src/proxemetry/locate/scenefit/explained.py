"""What the fit hands to `posterior`, which turns it into places."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...arrays import FloatArray
from .alternatives import Explanations
from .batch import HypothesisBatch
from .evidence import Evidence
from .mirror import Mirrored
from .solver import Fit


@dataclass(frozen=True, eq=False)
class Explained:
    """All usable people, explained.

    usable: shape (P,), their rows among the people. rows: all that was tried, with their explanations and log weight,
    shape (R,). first: shape (P,), the best row of each, whose joint fit is `fit`; mirrored: those on the other side of
    the line of sight. on_floor: shape (P,).
    """

    usable: NDArray[np.intp]
    evidence: Evidence
    rows: HypothesisBatch
    explanations: Explanations
    weight: FloatArray
    first: NDArray[np.intp]
    fit: Fit
    mirrored: Mirrored
    on_floor: NDArray[np.bool_]
    mount_misfit: float
