"""Whether an explanation of the segments is to be believed: a picture of a box has three directions too."""

from __future__ import annotations

import math

import numpy as np

from .mixture import N_CLUTTER, Fitted, Lines
from .model import PITCH, PRIOR, ROLL

#: Log evidence against clutter alone at which straight structure is as likely as not; it counts in worths of `mixture`.
#: York Urban's pictures have 7 and more, most of them over 30; furniture and graphics in other pictures -3 to 3.
_STRUCTURE = 0.0
#: What has less evidence after a first look is not looked at again: it gains 5 at most (synthetic scenes of all kinds).
HOPELESS = -8.0
#: Directions that are not gravity's: pictures that show such things alone (a box that lies anyhow, stripes), where a
#: second direction supports the first, and besides where none does; support counts in independent segments. Their
#: tilt is anywhere in what the tables of `search` hold.
_ANYHOW, _ALONE, _SUPPORT = 0.1, 0.89, 2.0
#: This part of the clutter falls in with a direction by chance.
_CHANCE = 0.1
_ANYHOW_DENSITY = 1 / (math.radians(144) * math.radians(84))


def trust_of(lines: Lines, fit: Fitted, log_evidence: float, best: int) -> float:
    """Return the probability that hypothesis `best` of `fit` shows gravity's frame, given its kind of explanation.

    log_evidence: of straight structure against clutter alone.
    """
    structure = 1 / (1 + math.exp(min(_STRUCTURE - log_evidence, 700.0)))
    shares = fit.shares[best]
    support = (float(np.sort(shares[N_CLUTTER:])[-2]) - _CHANCE * float(shares[:N_CLUTTER].sum())) * lines.count
    anyhow = _ANYHOW + _ALONE * math.exp(-max(support, 0.0) / _SUPPORT)
    upright = (1 - anyhow) * math.exp(-float(PRIOR.costs(fit.rows[best : best + 1])[0, [PITCH, ROLL]].sum()))
    return structure * upright / (upright + anyhow * _ANYHOW_DENSITY)
