"""The tilt at which bodies are seen: detectors see people from above as if from less far above.

With the camera's place known, joints of the networks fit bodies best that are seen as by a camera which is pitched by 1
to 4 degrees less than the one that looks at the floor under them: rendered people, people before four calibrated
cameras, and people before a mast (benchmarks/networks/seen_tilt.py). Bodies look as long as they are; what shows the
pitch, how long trunks and legs are beside each other and where faces and knees are, is as from less far above.
"""

from __future__ import annotations

import math

import numpy as np

from ...arrays import FloatArray
from .projection import LOG_LENGTHS, N_LOCAL, PITCH, ROLL

#: From so steeply above on, bodies are seen too level by all of `NoiseLaw.too_level_deg`, from less steeply by less.
_FROM_ABOVE_RAD = math.radians(10.0)
#: How far that differs from one set of pictures to another, radians: 0.7 to 4 degrees where 2 are expected, in four
#: sets with two networks each.
FROM_ABOVE_SD_RAD = math.radians(1.5)
#: How much a floor may fall, metres a metre: pavements are laid with 1 to 2.5 % for the rain, floors indoors level.
FALL_SD = 0.01
#: How far the tilt of all bodies is from the expected one, in pitch and roll, one standard deviation, radians. Beside a
#: floor that falls, bodies that stand upright are tilted.
TILT_SD_RAD: FloatArray = np.array([math.hypot(FROM_ABOVE_SD_RAD, FALL_SD), FALL_SD])


def expected_tilt(too_level_rad: float, above_rad: FloatArray) -> FloatArray:
    """Return the tilt (R, 2) in pitch and roll at which bodies are seen that are looked down at so steeply (R,).

    too_level_rad: see `NoiseLaw.too_level_deg`.
    """
    share = np.clip(above_rad / _FROM_ABOVE_RAD, 0.0, 1.0)
    return np.stack([-too_level_rad * share, np.zeros_like(share)], axis=-1)


def by_tilt(equations: FloatArray, above_rad: FloatArray) -> FloatArray:
    """Return the derivatives of `Projected` by the tilt, shape (R, 2 K + 1, 2); the floor stays where it is.

    equations: those by all unknowns, (R, 2 K + 1, ...). above_rad: shape (R,), see `projection.angle_from_above`.
    """
    result = equations[..., N_LOCAL + PITCH : N_LOCAL + ROLL + 1].copy()
    # of a body that is turned about its middle alone; and it is seen as long as it is
    result[..., 0] += np.tan(above_rad)[:, None] * equations[..., LOG_LENGTHS].sum(axis=-1)
    result[:, -1] = 0.0
    return result
