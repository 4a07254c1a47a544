"""The other side of the line of sight: a trunk turned to the left looks as wide as one turned to the right by as much.

Shoulders and hips alone fit both; the head decides, as far as necks turn, and so does perspective.
Gauss-Newton finds one of them and takes its curvature for the whole posterior: without the other side headings would
spread 1.5 times as far as stated.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...arrays import FloatArray
from .alternatives import at_fit, leave_one_out, refine
from .batch import HypothesisBatch
from .hypotheses import log_evidence
from .projection import HEADING, POINT, TURN
from .solver import Fit

_STEPS = 2


@dataclass(frozen=True, eq=False)
class Mirrored:
    """A fit's P rows with their trunks on the other side.

    local: shape (P, N_LOCAL). log_odds: shape (P,), how much likelier each is than the fit's own row.
    """

    local: FloatArray
    log_odds: FloatArray

    @property
    def share(self) -> FloatArray:
        """The probability of the other side, shape (P,)."""
        return np.exp(-np.logaddexp(0.0, -self.log_odds))


def mirrored(rows: HypothesisBatch, fit: Fit) -> Mirrored:
    """Return the other side of a fit's rows, each with the camera that all others determine."""
    cavity, same = leave_one_out(fit), np.zeros(len(rows))
    begin = on_the_other_side(fit.local)
    own = log_evidence(at_fit(fit, cavity), rows, same)
    turned = rows.with_heading_near(begin[:, HEADING])
    other = refine(turned, begin, np.tile(fit.shared, (len(rows), 1)), cavity, steps=_STEPS)
    return Mirrored(other.local, log_evidence(other, turned, same) - own)


def on_the_other_side(local: FloatArray) -> FloatArray:
    """Return rows (R, N_LOCAL) whose trunks are mirrored about the line of sight, and whose heads are as they were."""
    result = local.copy()
    # facing the lens is a heading of minus the azimuth
    off = local[:, HEADING] + np.arctan(local[:, POINT.start])
    turned = np.angle(np.exp(-2j * off))
    result[:, HEADING] += turned
    result[:, TURN] -= turned
    return result
