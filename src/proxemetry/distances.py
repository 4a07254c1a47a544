"""From bodies to the distances between them, with intervals, Hall's zones and who forms a group.

Distances are between body centres (the middle of the torso); the gap between surfaces is about one chest depth,
0.25 m, less.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .arrays import FloatArray, freeze
from .bodies import Bodies
from .draws import blocks, pair_covariance, pairs_within, spread_out, standard_normal
from .formations import group_probability
from .intervals import LEVEL

#: Hall 1966: upper limits of the zones in metres; beyond the last is public.
ZONES = ("intimate", "personal", "social", "public")
ZONE_LIMITS_M = (0.457, 1.219, 3.658)
#: What stands in place of a zone that a pair is less likely in than not.
UNCERTAIN = "uncertain"
#: An interval from one end to more than this many times that is to be read instead of any one number.
_VAGUE = 4.0

#: In a photo of more people than this, pairs are looked at up to this far apart (metres, as placed): beyond lies the
#: far phase of Hall's public distance, from 7.6 m, where two people of a crowd are like any other two.
CROWD, CROWD_REACH_M = 300, 10.0

#: Methods that state the joint uncertainty of all people, and whose pairs get the answer of least expected error. The
#: paper's estimators define a distance as the one between their positions.
LEAST_ERROR_METHODS = frozenset({"scene"})
#: No two bodies' middles are nearer.
_SHORTEST_M = 0.1


@dataclass(frozen=True, eq=False)
class Distances:
    """All pairs of P people; every array is symmetric with NaN on the diagonal and for people who could not be placed.

    distance_m: shape (P, P), on the ground plane where gravity is known, else in space (see `on_ground`);
    between the positions, or of least expected error (`LEAST_ERROR_METHODS`).
    low_m, high_m: shape (P, P), the 90 % interval of `distance_m`, which lies in it. distance_3d_m: shape (P, P), in
    space.
    zone_probability: shape (P, P, 4), in the order of `ZONES`. group_probability: shape (P, P), that two people face
    each other as an F-formation; NaN where a heading is unknown. reach_m: None, or, in a crowd, the largest distance
    between people for which pairs are computed; pairs further apart are NaN in all arrays.
    """

    distance_m: FloatArray
    low_m: FloatArray
    high_m: FloatArray
    distance_3d_m: FloatArray
    zone_probability: FloatArray
    group_probability: FloatArray
    on_ground: bool
    reach_m: float | None = None

    def __post_init__(self) -> None:
        freeze(self)

    def __len__(self) -> int:
        return len(self.distance_m)

    def __repr__(self) -> str:
        where = "on the ground" if self.on_ground else "in space"
        return f"Distances({self.below(math.inf)} of {len(self) * (len(self) - 1) // 2} pairs, {where})"

    def pairs(self) -> list[tuple[int, int]]:
        """Return every pair (a, b) with a < b, placed or not; in a crowd those within `reach_m`."""
        if self.reach_m is not None:
            known = np.argwhere(np.triu(np.isfinite(self.distance_m), 1))
            return [(int(a), int(b)) for a, b in known]
        return [(a, b) for a in range(len(self)) for b in range(a + 1, len(self))]

    def zone(self, a: int, b: int) -> str | None:
        """Return Hall's zone of a pair's distance, None where that is unknown.

        `UNCERTAIN` where the pair is less likely in that zone than not: the distance is the answer of least expected
        error, and of a pair with several explanations it may lie where hardly one of them does.
        """
        zone = zone_of(float(self.distance_m[a, b]))
        if zone is None:
            return None
        return zone if self.zone_probability[a, b, ZONES.index(zone)] >= 0.5 else UNCERTAIN

    def vague(self, a: int, b: int) -> bool:
        """Return whether a pair's interval is too wide for its distance to be quoted alone (by its ends' ratio)."""
        return is_vague(float(self.low_m[a, b]), float(self.high_m[a, b]))

    def below(self, limit_m: float) -> int:
        """Return how many pairs are nearer than `limit_m`."""
        return int(np.sum(np.triu(self.distance_m < limit_m, 1)))


def zone_of(distance_m: float) -> str | None:
    """Return Hall's zone of a distance in metres, None for NaN."""
    if math.isnan(distance_m):
        return None
    return ZONES[int(np.searchsorted(ZONE_LIMITS_M, distance_m, side="right"))]


def is_vague(low_m: float, high_m: float) -> bool:
    """Return whether an interval should be read instead of the distance in it; False where there is none."""
    return high_m > _VAGUE * low_m


def ground_frame(up: FloatArray | None) -> FloatArray:
    """Return the rows right, forward, up of shape (3, 3) that turn camera coordinates into ground coordinates.

    "Right" is the camera's x along the ground, "forward" where the camera looks along it. Without gravity the camera
    is taken to be level.
    """
    up = np.array([0.0, -1.0, 0.0]) if up is None else np.asarray(up, dtype=float)
    right = np.array([1.0, 0.0, 0.0]) - up[0] * up
    if np.linalg.norm(right) < 1e-6:  # the camera lies on its side
        right = np.array([0.0, 1.0, 0.0]) - up[1] * up
    right = right / np.linalg.norm(right)
    return np.array([right, np.cross(up, right), up], dtype=float)


def measure_distances(bodies: Bodies) -> Distances:
    """Return all pairs' distances with intervals from the joint covariance and every mode of `bodies`.

    Each interval is the shortest that holds 90 % of the distance between two Gaussians (of each mode, by its weight),
    taken from a fixed symmetric set of points: it depends on the pair alone, and is the same on every run. Far apart
    that is the central 90 %. Side by side it is not: any error in depth only ever adds distance there, and a central
    interval would leave out the shortest distances, which are the likeliest.
    """
    count = len(bodies)
    plane = ground_frame(bodies.up)[:2] if bodies.up is not None else np.eye(3)
    shape = (count, count)
    distance, low, high, spatial = (np.full(shape, np.nan) for _ in range(4))
    zones = np.full((*shape, len(ZONES)), np.nan)
    placed = np.flatnonzero(bodies.placed)
    a, b = (placed[k] for k in np.triu_indices(len(placed), 1))
    reach = CROWD_REACH_M if count > CROWD else None
    a, b = (a, b) if reach is None else pairs_within(reach, bodies, plane, a, b)
    for some in blocks(len(a), len(standard_normal(len(plane))) * max(1, len(bodies.modes))):
        i, j = a[some], b[some]
        gap = bodies.positions_m[i] - bodies.positions_m[j]
        drawn, weights = _draw_lengths(bodies, i, j, plane)
        order = drawn.argsort(axis=1)
        lengths, shares = np.take_along_axis(drawn, order, axis=1), weights[order]
        flat, straight = np.linalg.norm(gap @ plane.T, axis=-1), np.linalg.norm(gap, axis=-1)
        distance[i, j] = least_error(lengths, shares) if bodies.method in LEAST_ERROR_METHODS else flat
        spatial[i, j] = np.sqrt(distance[i, j] ** 2 + np.maximum(straight**2 - flat**2, 0.0))
        shortest, longest = shortest_intervals(lengths, shares)
        # Where a distance is all noise, that between the positions is shorter than nine in ten: no answer lies outside.
        low[i, j], high[i, j] = np.minimum(shortest, distance[i, j]), np.maximum(longest, distance[i, j])
        edges = np.searchsorted(ZONE_LIMITS_M, lengths, side="right")
        for k in range(len(ZONES)):
            zones[i, j, k] = ((edges == k) * shares).sum(axis=1)
    for array in (distance, low, high, spatial, zones):
        array[b, a] = array[a, b]
    groups = group_probability(bodies, ground_frame(bodies.up)[:2], reach)
    return Distances(distance, low, high, spatial, zones, groups, bodies.up is not None, reach)


def probability_within(bodies: Bodies, limit_m: float) -> FloatArray:
    """Return how probable it is that each two people are nearer than a limit, shape (P, P), of all explanations.

    NaN on the diagonal and for people who could not be placed; 0 in a crowd for pairs beyond the reach.
    """
    plane = ground_frame(bodies.up)[:2] if bodies.up is not None else np.eye(3)
    result = np.full((len(bodies), len(bodies)), np.nan)
    placed = np.flatnonzero(bodies.placed)
    a, b = (placed[k] for k in np.triu_indices(len(placed), 1))
    result[a, b] = result[b, a] = 0.0
    if len(bodies) > CROWD:
        a, b = pairs_within(CROWD_REACH_M, bodies, plane, a, b)
    for some in blocks(len(a), len(standard_normal(len(plane))) * max(1, len(bodies.modes))):
        lengths, weights = _draw_lengths(bodies, a[some], b[some], plane)
        result[a[some], b[some]] = result[b[some], a[some]] = (lengths < limit_m) @ weights
    return result


def planar_lengths(gap_m: FloatArray, covariance_m2: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the drawn lengths of uncertain gaps on the ground, each row in order, and the draws' weights.

    gap_m: shape (n, 2). covariance_m2: shape (n, 2, 2). Both results: shape (n, draws). The points are the fixed ones
    that every photo's distances come from.
    """
    points = standard_normal(2)
    lengths = np.sort(np.linalg.norm(gap_m[:, None, :] + spread_out(points, covariance_m2), axis=-1), axis=1)
    return lengths, np.full(lengths.shape, 1 / len(points))


def least_error_and_interval(lengths: FloatArray, shares: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return the answer of least expected relative error and the shortest 90 % interval of rows of `planar_lengths`."""
    answer = least_error(lengths, shares)
    low, high = shortest_intervals(lengths, shares)
    return answer, low, high


def _draw_lengths(
    bodies: Bodies, a: NDArray[np.intp], b: NDArray[np.intp], plane: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return drawn distances of shape (n, draws) and the draws' weights of shape (draws,)."""
    modes = bodies.modes or ()
    explanations = [(m.weight, m.positions_m, m.covariance_m2) for m in modes] or [
        (1.0, bodies.positions_m, bodies.covariance_m2)
    ]
    points = standard_normal(len(plane))
    lengths, weights = [], []
    for weight, positions, covariance in explanations:
        gap = (positions[a] - positions[b]) @ plane.T
        spread = plane @ pair_covariance(covariance, a, b) @ plane.T
        lengths.append(np.linalg.norm(gap[:, None, :] + spread_out(points, spread), axis=-1))
        weights.append(np.full(len(points), weight / len(points)))
    return np.concatenate(lengths, axis=1), np.concatenate(weights)


def least_error(lengths: FloatArray, shares: FloatArray) -> FloatArray:
    """Return the answer of least expected relative error for each row of `lengths` (n, draws), in order, with weights.

    It is the median by the draws' weights over their lengths: |x / d - 1| costs a long answer to a short
    distance most. Where depth is sure it is the distance between the positions; where it is not, that distance is
    mostly noise.
    """
    share = shares / np.maximum(lengths, _SHORTEST_M)
    middle = np.cumsum(share, axis=1) - share / 2
    half = share.sum(axis=1) / 2
    answers = [np.interp(h, m, v) for h, m, v in zip(half, middle, lengths, strict=True)]
    return np.array(answers, dtype=float)


def shortest_intervals(lengths: FloatArray, shares: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the shortest interval that holds `LEVEL` of each row of `lengths` (n, draws), in order, with weights."""
    below = np.cumsum(shares, axis=1) - shares  # of the weight before each draw
    upper = np.array(
        [np.interp(b + LEVEL, b + s / 2, v) for b, s, v in zip(below, shares, lengths, strict=True)]
    ).reshape(lengths.shape)
    width = np.where(below + LEVEL <= 1 + 1e-12, upper - lengths, np.inf)
    best = width.argmin(axis=1)[:, None]
    low, high = (np.take_along_axis(edge, best, axis=1)[:, 0] for edge in (lengths, upper))
    return low, high
