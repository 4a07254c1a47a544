"""What more people do not even out: how all of them, or the floor, may depart from the model alike.

Each departure is what the residuals of every row would be, at one standard deviation of it.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from ...arrays import FloatArray
from .batch import HypothesisBatch
from .body_model import BodyModel
from .projection import PITCH, ROLL, angle_from_above, camera_axes, project, torso_position
from .tilt import FALL_SD, FROM_ABOVE_SD_RAD, by_tilt

#: How far a detector's idea of a joint may be from the body model's, of all people alike, in statures: as far as two
#: networks' ideas of one are apart (`body_tables.DEFINITIONS`, and how ears, hips and shoulders were found to differ).
HABIT_SD = 0.015
#: People who walk carry their ankles higher and their knees lower than those who stand, in statures: by 0.030 and 0.025
#: on average over a step (mocap.cs.cmu.edu, subject 2, trials 1 and 2). How many of a crowd walk is not known.
GAIT = {"feet": 0.030, "legs": 0.025}
#: What a detector's grid does to a kind of joint in all pictures alike, of what it resolves: a step of it.
_OF_RESOLUTION = 1.0
#: How much of a lean a detector sees away, having learnt on upright people: 0.05 to 0.08 of photos turned by 4 and 8
#: degrees and looked at again (yolox-tinypose, people 70 pixels from shoulders to ankles).
LEAN_SD = 0.08
_UP = 2  # of the body's axes
_NUDGE = 1e-4


def departures_of(
    rows: HypothesisBatch, local: FloatArray, cameras: FloatArray, model: BodyModel, resolution: float,
    focal_sought: bool,
) -> FloatArray:  # fmt: skip
    """Return departures (D, R, 2 K + 1) in the order of `project`: x of all joints, y of all joints, the floor.

    Gait, bodies' tilt and a floor that falls count where the focal length is sought, which hangs on how people lean and
    how fast they grow smaller. Where it is known, the floor shows the tilt, which is an unknown then (`State.tilt`);
    pitch and height take a fall in, and are then what distances along that floor need.
    """
    count, joints = rows.precision.shape
    raised = rows.bodies.table.copy()
    raised[:, _UP, :, -1] += _NUDGE
    projected = project(local, cameras, rows.bodies)
    at = projected.points
    up = (project(local, cameras, replace(rows.bodies, table=raised)).points - at) / _NUDGE
    found: list[FloatArray] = []
    for name, kind in model.kinds.items():
        sd = math.hypot(HABIT_SD, GAIT.get(name, 0.0) if focal_sought else 0.0)
        found.append(_of_points(sd * up * kind))
        upright = np.zeros_like(at)
        upright[:, 1] = -_OF_RESOLUTION * resolution * kind
        found.append(_of_points(upright))
    seen = rows.precision > 0
    middle = (at * seen[:, None]).sum(axis=2, keepdims=True) / np.maximum(seen.sum(axis=1), 1)[:, None, None]
    leant = np.zeros_like(at)
    leant[:, 0] = -LEAN_SD * (up[:, 0] / up[:, 1]) * (at - middle)[:, 1]
    found.append(_of_points(leant))
    if focal_sought:
        tilted = by_tilt(projected.equations, angle_from_above(local, cameras))
        found.append(FROM_ABOVE_SD_RAD * tilted[..., 0])
        axes = camera_axes(cameras[:, PITCH : ROLL + 1])
        world = (torso_position(local, cameras)[:, None] @ axes)[:, 0]
        for along in (0, 2):  # to the right, and ahead
            departure = np.zeros((count, 2 * joints + 1))
            departure[:, -1] = FALL_SD * (world[:, along] - world[:, along].mean())
            found.append(departure)
    return np.array(found)


def _of_points(points: FloatArray) -> FloatArray:
    """Return a departure (R, 2 K + 1) of points (R, 2, K) alone."""
    return np.concatenate([points.reshape(len(points), -1), np.zeros((len(points), 1))], axis=1)
