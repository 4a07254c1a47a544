"""From bodies to the distances between them, with intervals, Hall's zones and who forms a group.

Distances are between body centres (the middle of the torso); the gap between surfaces is about one chest depth,
0.25 m, less.
"""

from __future__ import annotations

import functools
import itertools
import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .arrays import ComplexArray, FloatArray
from .bodies import Bodies
from .intervals import LEVEL

#: Hall 1966: upper limits of the zones in metres; beyond the last is public.
ZONES = ("intimate", "personal", "social", "public")
ZONE_LIMITS_M = (0.457, 1.219, 3.658)
#: What is said instead of a zone that a pair is less likely in than not.
UNCERTAIN = "uncertain"
#: An interval from one end to more than this many times that is to be read instead of any one number.
_VAGUE = 4.0

#: Bertoni et al. 2021 (T-ITS): people beyond this are not a group; radii of the transactional segments tried.
GROUP_REACH_M, GROUP_RADII_M = 2.0, (0.3, 0.5, 1.0)

#: In a photo of more people than this, pairs are looked at up to this far apart (metres, as placed): beyond lies the
#: far phase of Hall's public distance, from 7.6 m, where nothing tells two people of a crowd from any other two.
CROWD, CROWD_REACH_M = 300, 10.0

_DRAWS = 512
#: So many draws are held at a time, 16 MB an array.
_MOST_DRAWS = 2_000_000

#: Methods that state everybody's joint uncertainty, and whose pairs get the answer of least expected error. The paper's
#: estimators define a distance as the one between their positions.
LEAST_ERROR_METHODS = frozenset({"scene"})
#: No two bodies' middles are nearer.
_SHORTEST_M = 0.1
_GOLDEN, _SILVER = (math.sqrt(5) - 1) / 2, math.sqrt(2) - 1


@dataclass(frozen=True, eq=False)
class Distances:
    """All pairs of P people; every array is symmetric with NaN on the diagonal and for who could not be placed.

    distance_m: shape (P, P), on the ground plane where gravity is known, else in space (`on_ground` says which);
    between the positions, or of least expected error (`LEAST_ERROR_METHODS`).
    low_m, high_m: shape (P, P), the 90 % interval of `distance_m`, which lies in it. distance_3d_m: shape (P, P), in
    space.
    zone_probability: shape (P, P, 4), in the order of `ZONES`. group_probability: shape (P, P), that two people face
    each other as an F-formation; NaN where a heading is unknown. reach_m: None, or, in a crowd, how far apart people
    may be placed for their pair to be looked at; pairs further apart are NaN everywhere.
    """

    distance_m: FloatArray
    low_m: FloatArray
    high_m: FloatArray
    distance_3d_m: FloatArray
    zone_probability: FloatArray
    group_probability: FloatArray
    on_ground: bool
    reach_m: float | None = None

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
        """Return whether a pair's interval says more than its distance: its ends are far apart, as a ratio."""
        return is_vague(float(self.low_m[a, b]), float(self.high_m[a, b]))

    def below(self, limit_m: float) -> int:
        """Return how many pairs stand nearer than `limit_m`."""
        return int(np.sum(np.triu(self.distance_m < limit_m, 1)))


def zone_of(distance_m: float) -> str | None:
    """Return Hall's zone of a distance in metres, None for NaN."""
    if math.isnan(distance_m):
        return None
    return ZONES[int(np.searchsorted(ZONE_LIMITS_M, distance_m, side="right"))]


def is_vague(low_m: float, high_m: float) -> bool:
    """Return whether an interval says more than the distance in it; not where there is none."""
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
    a, b = (a, b) if reach is None else _within(reach, bodies, plane, a, b)
    for some in _blocks(len(a), _DRAWS * max(1, len(bodies.modes))):
        i, j = a[some], b[some]
        gap = bodies.positions_m[i] - bodies.positions_m[j]
        drawn, weights = _draw_lengths(bodies, i, j, plane)
        order = drawn.argsort(axis=1)
        lengths, shares = np.take_along_axis(drawn, order, axis=1), weights[order]
        flat, straight = np.linalg.norm(gap @ plane.T, axis=-1), np.linalg.norm(gap, axis=-1)
        distance[i, j] = _least_error(lengths, shares) if bodies.method in LEAST_ERROR_METHODS else flat
        spatial[i, j] = np.sqrt(distance[i, j] ** 2 + np.maximum(straight**2 - flat**2, 0.0))
        shortest, longest = shortest_intervals(lengths, shares)
        # Where a distance is all noise, that between the positions is shorter than nine in ten: no answer lies outside.
        low[i, j], high[i, j] = np.minimum(shortest, distance[i, j]), np.maximum(longest, distance[i, j])
        edges = np.searchsorted(ZONE_LIMITS_M, lengths, side="right")
        for k in range(len(ZONES)):
            zones[i, j, k] = ((edges == k) * shares).sum(axis=1)
    for array in (distance, low, high, spatial, zones):
        array[b, a] = array[a, b]
    groups = _group_probability(bodies, reach)
    return Distances(distance, low, high, spatial, zones, groups, bodies.up is not None, reach)


def _within(
    reach_m: float, bodies: Bodies, plane: FloatArray, a: NDArray[np.intp], b: NDArray[np.intp]
) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Return which of the pairs (a, b) any explanation places within reach of each other."""
    nearest = np.full(len(a), np.inf)
    for positions in (bodies.positions_m, *(mode.positions_m for mode in bodies.modes)):
        flat = positions @ plane.T
        for some in _blocks(len(a), 16):
            gap = np.linalg.norm(flat[a[some]] - flat[b[some]], axis=-1)
            nearest[some] = np.minimum(nearest[some], gap)
    close = nearest <= reach_m
    return a[close], b[close]


def planar_lengths(gap_m: FloatArray, covariance_m2: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the drawn lengths of uncertain gaps on the ground, each row in order, and the draws' weights.

    gap_m: shape (n, 2). covariance_m2: shape (n, 2, 2). Both results: shape (n, draws). The points are the fixed ones
    that every photo's distances come from.
    """
    points = standard_normal(2)
    lengths = np.sort(np.linalg.norm(gap_m[:, None, :] + _drawn(points, covariance_m2), axis=-1), axis=1)
    return lengths, np.full(lengths.shape, 1 / len(points))


def least_error_and_interval(lengths: FloatArray, shares: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return the answer of least expected relative error and the shortest 90 % interval of rows of `planar_lengths`."""
    answer = _least_error(lengths, shares)
    low, high = shortest_intervals(lengths, shares)
    return answer, low, high


@functools.cache
def standard_normal(dimension: int) -> FloatArray:
    """Return fixed standard normal points of shape (_DRAWS, dimension), spread evenly, with exactly unit covariance.

    They are symmetric in every axis, so that neither the order of two people nor a mirrored photo changes a quantile.
    """
    signs = np.array(list(itertools.product((1.0, -1.0), repeat=dimension)))
    count, pairs = _DRAWS // len(signs), (dimension + 1) // 2
    index = np.arange(count)
    # Radii are the quantiles of the Rayleigh distribution, every pair of axes in an order of its own; angles follow
    # the golden ratio within a quarter turn.
    columns: list[FloatArray] = []
    for k in range(pairs):
        order = np.argsort((index * _SILVER) % 1.0) if k else index
        radius = np.sqrt(-2 * np.log((order + 0.5) / count))
        angle = ((index * _GOLDEN * (k + 1)) % 1.0) * np.pi / 2
        columns += [radius * np.cos(angle), radius * np.sin(angle)]
    points = (np.abs(np.stack(columns[:dimension], axis=1))[:, None] * signs).reshape(-1, dimension)
    return points / np.sqrt((points**2).mean(axis=0))


def _pair_covariance(covariance: FloatArray, a: NDArray[np.intp], b: NDArray[np.intp]) -> FloatArray:
    """Return the covariance of position a minus position b, shape (n, 3, 3), from the joint one."""
    blocks = covariance.reshape(len(covariance) // 3, 3, -1, 3).transpose(0, 2, 1, 3)
    return blocks[a, a] + blocks[b, b] - blocks[a, b] - blocks[b, a]


def _blocks(count: int, draws: int) -> Iterator[slice]:
    """Yield slices of `count` rows of so many draws each: crowds have more pairs than fit into memory at once."""
    rows = max(1, _MOST_DRAWS // draws)
    yield from (slice(k, k + rows) for k in range(0, count, rows))


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
        spread = plane @ _pair_covariance(covariance, a, b) @ plane.T
        lengths.append(np.linalg.norm(gap[:, None, :] + _drawn(points, spread), axis=-1))
        weights.append(np.full(len(points), weight / len(points)))
    return np.concatenate(lengths, axis=1), np.concatenate(weights)


def _drawn(points: FloatArray, covariance: FloatArray) -> FloatArray:
    """Return standard normal points (draws, d) spread out by covariances (n, d, d): shape (n, draws, d)."""
    values, vectors = np.linalg.eigh(covariance)
    root = vectors * np.sqrt(np.maximum(values, 0.0))[:, None, :]
    return points @ root.transpose(0, 2, 1)


def _least_error(lengths: FloatArray, shares: FloatArray) -> FloatArray:
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


def _group_probability(bodies: Bodies, reach_m: float | None = None) -> FloatArray:
    """Return how probable it is that each pair forms an F-formation (Bertoni et al. 2021, eqs. 6-8), by sampling."""
    count = len(bodies)
    result = np.full((count, count), np.nan)
    known = np.flatnonzero(bodies.placed & np.isfinite(bodies.heading_rad) & np.isfinite(bodies.heading_sd_rad))
    if len(known) < 2:
        return result
    frame = ground_frame(bodies.up)[:2]
    ground = bodies.positions_m @ frame.T
    a, b = (known[k] for k in np.triu_indices(len(known), 1))
    if reach_m is not None:
        a, b = _within(reach_m, bodies, frame, a, b)
    points = standard_normal(4)
    points = np.concatenate([points, points[:, [0, 1, 3, 2]]])  # neither of a pair comes first
    # a place on the ground as one complex number, right + i forward
    place = _complex(ground)
    placed = np.flatnonzero(bodies.placed)
    result[a, b] = result[b, a] = 0.0
    for some in _blocks(len(a), len(points)):
        gap = np.abs(place[a[some]] - place[b[some]])
        spread = frame @ _pair_covariance(bodies.covariance_m2, a[some], b[some]) @ frame.T
        # no draw is further out than this
        furthest = np.linalg.norm(points[:, :2], axis=1).max() * np.sqrt(np.trace(spread, axis1=1, axis2=2))
        close = np.flatnonzero(gap - furthest <= GROUP_REACH_M)
        shift = _complex(_drawn(points[:, :2], spread[close])) / 2  # (pairs, draws)
        for i, j, aside in zip(a[some][close], b[some][close], shift, strict=True):
            near = _squared(place[i] - place[j] + 2 * aside) <= GROUP_REACH_M**2
            if not near.any():
                continue
            turn = points[near, 2:] * bodies.heading_sd_rad[[i, j]] + bodies.heading_rad[[i, j]]
            facing = -1j * np.exp(1j * turn.T)  # sin h - i cos h
            others = placed[(placed != i) & (placed != j)]
            # their centre is within a radius of the middle between them, and a radius from there is as far as counts
            others = others[np.abs(place[others] - (place[i] + place[j]) / 2) < 2 * max(GROUP_RADII_M)]
            grouped = _face_each_other(place[i] + aside[near], place[j] - aside[near], facing, place[others])
            result[i, j] = result[j, i] = grouped.sum() / len(points)
    return result


def _complex(points: FloatArray) -> ComplexArray:
    return points[..., 0] + 1j * points[..., 1]


def _squared(values: ComplexArray) -> FloatArray:
    return values.real**2 + values.imag**2


def _face_each_other(a: ComplexArray, b: ComplexArray, facing: ComplexArray, others: ComplexArray) -> NDArray[np.bool_]:
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
