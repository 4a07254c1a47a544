"""Other cameras that may explain a photo better: the descent ends in the optimum that is nearest to its start.

Of people far away one degree of pitch moves the floor under them by a third of a metre, and bodies that are a little
larger under a camera that is a little higher look the same. So there are several optima, and where the coarse search
began in the wrong one, the fit came out up to 16 log units less likely than another (people 17 to 35 m before a mast).
"""

from __future__ import annotations

import numpy as np

from ...arrays import FloatArray
from .batch import HypothesisBatch
from .camera_prior import SharedPrior
from .projection import DEPTH, HEIGHT, PITCH, ROLL, camera_axes, torso_position
from .solver import Fit, solve

#: How much further down, and less far, other cameras look: from 5 to 10 degrees all find the same optima.
_TILTS: FloatArray = np.deg2rad([7.0, -7.0])
#: People so far away, metres. Of nearer ones another camera was likelier in one photo of several people in seventy, and
#: in one of seven of one or two before rolled cameras; depths were no better with it, and the fit took half as long
#: again.
_FAR_M = 10.0
#: A camera is no lower over the people's floor, metres.
_LOWEST_M = 0.3
#: An optimum is another one where it is likelier by this log factor; less is what the descent left undone.
_LIKELIER = 0.05


def likeliest_camera(rows: HypothesisBatch, fit: Fit, prior: SharedPrior, iterations: int) -> Fit:
    """Return the fit, or a likelier one that is reached from a camera which looks further down or less far.

    rows: the fit's own. Nothing else is tried where the pitch is stated or half of the people are near.
    """
    best = fit
    if PITCH not in prior.place.which and np.median(fit.local[:, DEPTH]) > np.log(_FAR_M):
        for tilt in _TILTS:
            shared = _tilted(fit, rows, float(tilt))
            other = solve(rows, fit.local, shared, prior, iterations=iterations)
            best = other if other.cost < best.cost - _LIKELIER else best
    return best


def _tilted(fit: Fit, rows: HypothesisBatch, tilt: float) -> FloatArray:
    """Return the shared unknowns (N_SHARED,) of a camera that looks down by `tilt` more, radians, its floor still under
    the people: in the median of those who stand on it."""
    shared = fit.shared.copy()
    shared[PITCH] += tilt
    down, before = (camera_axes(camera[None, PITCH : ROLL + 1])[0, :, 1] for camera in (shared, fit.shared))
    standing = rows.floor_precision > 0
    if standing.any():
        deeper = np.median(torso_position(fit.local, fit.shared)[standing] @ (down - before))
        shared[HEIGHT] = np.log(max(float(np.exp(fit.shared[HEIGHT]) + deeper), _LOWEST_M))
    return shared
