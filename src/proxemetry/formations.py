"""Who forms a group: F-formations (Bertoni et al. 2021, T-ITS), as probabilities."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .arrays import ComplexArray, FloatArray
from .bodies import Bodies
from .draws import blocks, pair_covariance, pairs_within, spread_out, standard_normal

#: Bertoni et al. 2021 (T-ITS): people beyond this are not a group; radii of the transactional segments tried.
GROUP_REACH_M, GROUP_RADII_M = 2.0, (0.3, 0.5, 1.0)


def group_probability(bodies: Bodies, frame: FloatArray, reach_m: float | None = None) -> FloatArray:
    """Return how probable it is that each pair forms an F-formation (Bertoni et al. 2021, eqs. 6-8), by sampling.

    frame: shape (2, 3), the ground's axes in the camera frame. reach_m: in a crowd, how far apart pairs are looked at.
    The result has shape (P, P), NaN where a place or a heading is unknown.
    """
    count = len(bodies)
    result = np.full((count, count), np.nan)
    known = np.flatnonzero(bodies.placed & np.isfinite(bodies.heading_rad) & np.isfinite(bodies.heading_sd_rad))
    if len(known) < 2:
        return result
    ground = bodies.positions_m @ frame.T
    a, b = (known[k] for k in np.triu_indices(len(known), 1))
    if reach_m is not None:
        a, b = pairs_within(reach_m, bodies, frame, a, b)
    points = standard_normal(4)
    points = np.concatenate([points, points[:, [0, 1, 3, 2]]])  # neither of a pair comes first
    # a place on the ground as one complex number, right + i forward
    place = _complex(ground)
    placed = np.flatnonzero(bodies.placed)
    result[a, b] = result[b, a] = 0.0
    for some in blocks(len(a), len(points)):
        gap = np.abs(place[a[some]] - place[b[some]])
        spread = frame @ pair_covariance(bodies.covariance_m2, a[some], b[some]) @ frame.T
        # no draw is further out than this
        furthest = np.linalg.norm(points[:, :2], axis=1).max() * np.sqrt(np.trace(spread, axis1=1, axis2=2))
        close = np.flatnonzero(gap - furthest <= GROUP_REACH_M)
        shift = _complex(spread_out(points[:, :2], spread[close])) / 2  # (pairs, draws)
        for i, j, aside in zip(a[some][close], b[some][close], shift, strict=True):
            near = _squared(place[i] - place[j] + 2 * aside) <= GROUP_REACH_M**2
            if not near.any():
                continue
            turn = points[near, 2:] * bodies.heading_sd_rad[[i, j]] + bodies.heading_rad[[i, j]]
            facing = -1j * np.exp(1j * turn.T)  # sin h - i cos h
            others = placed[(placed != i) & (placed != j)]
            # their centre is within a radius of the middle between them, and a radius from there is as far as counts
            others = others[np.abs(place[others] - (place[i] + place[j]) / 2) < 2 * max(GROUP_RADII_M)]
            grouped = face_each_other(place[i] + aside[near], place[j] - aside[near], facing, place[others])
            result[i, j] = result[j, i] = grouped.sum() / len(points)
    return result


def _complex(points: FloatArray) -> ComplexArray:
    return points[..., 0] + 1j * points[..., 1]


def _squared(values: ComplexArray) -> FloatArray:
    return values.real**2 + values.imag**2


def face_each_other(a: ComplexArray, b: ComplexArray, facing: ComplexArray, others: ComplexArray) -> NDArray[np.bool_]:
    """Return in which draws two people at a and b (n,), facing (2, n), interact, for any of the radii."""
    grouped = np.zeros(len(a), dtype=bool)
    for radius in GROUP_RADII_M:
        mine, yours = a + radius * facing[0], b + radius * facing[1]
        centre = (mine + yours) / 2
        reach2 = np.minimum(_squared(a - centre), _squared(b - centre))
        inward = np.flatnonzero(~grouped & (_squared(mine - yours) <= reach2))
        if len(inward):
            apart2 = _squared(centre[inward, None] - others)
            grouped[inward] = apart2.min(axis=1, initial=np.inf) > radius**2
    return grouped
