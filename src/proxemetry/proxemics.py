"""What proxemics and visual communication measure in a photo: nearest others, viewing angles, shot sizes, orientations.

Everything follows from where people stand, which way they face and what of them is in the picture.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .arrays import FloatArray, IntArray, freeze
from .bodies import Bodies
from .camera import Camera
from .distances import UNCERTAIN, Distances, ground_frame, shortest_intervals
from .draws import log_sd, standard_normal
from .people import People

#: Hall 1966, chapter 10: where the close phase of each zone ends, metres (6 inches; 2.5, 7 and 25 feet).
PHASE_LIMITS_M = {"intimate": 0.152, "personal": 0.762, "social": 2.134, "public": 7.62}

#: Shot sizes of film and of Kress and van Leeuwen (2006, ch. 4), from the nearest to the farthest.
SHOTS = (
    "extreme close-up", "close-up", "medium close-up", "medium shot", "medium long shot", "full shot", "long shot",
    "very long shot",
)  # fmt: skip
#: The share of a standing body, from the top of the head down, that the first five shots show at most: face, shoulders,
#: chest, hips, knees (heights of Drillis and Contini 1966, as shares of the stature, midway to the next landmark).
_SHOT_SHARES = (0.16, 0.24, 0.42, 0.62, 0.85)
#: The stature over the picture's height below which a whole body is a full, a long and a very long shot.
_LONG_BELOW, _VERY_LONG_BELOW = 2 / 3, 1 / 4
#: How far the head's and the shoulders' middle lie below the top of the head, and how long the torso is from neck to
#: mid-hip, as shares of the stature (Drillis and Contini 1966; the torso as keypoint detectors place its ends).
_HEAD_DEPTH, _SHOULDER_DEPTH, _TORSO_LENGTH = 0.065, 0.18, 0.29

#: How two people are turned to one another.
ORIENTATIONS = ("facing", "side by side", "back to back", "one behind the other")
#: Beyond this, how two people are turned means nothing (Hall's far social phase ends there).
ORIENTATION_REACH_M = 3.658
#: Facing and backs: within 60 degrees of the line between the two. Side by side: within 45 degrees of one another and
#: 45 to 135 degrees from that line. The sectors of Kendon 1990 in rough: face to face, side by side, and L between.
_TOWARDS_RAD, _PARALLEL_RAD = math.radians(60), math.radians(45)

#: Two people belong to one group where they do so likelier than not.
_GROUPED = 0.5
_PAIRS_AT_ONCE = 2000


@dataclass(frozen=True, eq=False)
class Proxemics:
    """P people; NaN (or None) where unknown.

    nearest: shape (P,), the row of the nearest other person, -1 for none. nearest_m, nearest_low_m, nearest_high_m:
    shape (P,), the distance to them with its 90 % interval. camera_distance_m with camera_low_m, camera_high_m: shape
    (P,), from the optical centre to the body's middle, with its 90 % interval. horizontal_deg: shape (P,), between
    where the body faces and the camera: 0 frontal, 90 in profile, 180 from behind. vertical_deg: shape (P,), how far
    the camera looks down on the head; negative looks up. horizontal_sd_deg: shape (P,). shots: one of `SHOTS` a person.
    group: shape (P,), the number of the group each person belongs to, -1 for people on their own; group_size: shape
    (P,), 1 for those. orientation_probability: shape (P, P, 4), as `ORIENTATIONS`; what is left of 1 is none of them.
    """

    nearest: IntArray
    nearest_m: FloatArray
    nearest_low_m: FloatArray
    nearest_high_m: FloatArray
    camera_distance_m: FloatArray
    camera_low_m: FloatArray
    camera_high_m: FloatArray
    horizontal_deg: FloatArray
    horizontal_sd_deg: FloatArray
    vertical_deg: FloatArray
    shots: tuple[str | None, ...]
    group: IntArray
    group_size: IntArray
    orientation_probability: FloatArray

    def __post_init__(self) -> None:
        freeze(self)

    def orientation(self, a: int, b: int) -> str | None:
        """Return the likeliest of `ORIENTATIONS`, "uncertain" where none is likelier than not, None where unknown."""
        shares = self.orientation_probability[a, b]
        if math.isnan(shares[0]):
            return None
        best = int(shares.argmax())
        return ORIENTATIONS[best] if shares[best] >= 0.5 else UNCERTAIN


def phase_of(zone: str | None, distance_m: float) -> str | None:
    """Return Hall's phase of a distance in a zone, "close" or "far"; None outside his zones."""
    if zone not in PHASE_LIMITS_M:
        return None
    return "close" if distance_m < PHASE_LIMITS_M[zone] else "far"


def measure_proxemics(
    people: People, bodies: Bodies, distances: Distances, camera: Camera | None, height_px: int
) -> Proxemics:
    """Return what follows from people placed before a camera; without one, all but the shot sizes are missing.

    height_px: of the upright photo.
    """
    count = len(bodies)
    nearest = _nearest(distances.distance_m)
    rows = np.arange(count)
    has = nearest >= 0
    near, low, high = (np.full(count, np.nan) for _ in range(3))
    matrices = (distances.distance_m, distances.low_m, distances.high_m)
    for values, matrix in zip((near, low, high), matrices, strict=True):
        values[has] = matrix[rows[has], nearest[has]]
    away, away_low, away_high = _camera_distance(bodies)
    group, size = _groups(distances.group_probability)
    shots = _shots(people, _stature_px(people, bodies, camera), height_px)
    return Proxemics(
        nearest, near, low, high, away, away_low, away_high, _horizontal(bodies), np.degrees(bodies.heading_sd_rad),
        _vertical(people, bodies, camera), shots, group, size, _orientations(bodies, distances),
    )  # fmt: skip


def _nearest(distance_m: FloatArray) -> IntArray:
    """Return the row of each person's nearest other, -1 for none."""
    if len(distance_m) == 0:
        return np.zeros(0, dtype=np.int64)
    known = np.where(np.isfinite(distance_m), distance_m, np.inf)
    return np.where(np.isfinite(known.min(axis=1)), known.argmin(axis=1), -1)


def _camera_distance(bodies: Bodies) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return each person's distance from the camera with the shortest 90 % interval over all explanations.

    Each explanation's distance is uncertain along the line of sight by a factor, so that it is never behind the camera;
    what is uncertain across the line of sight hardly changes it.
    """
    count = len(bodies)
    distance = np.linalg.norm(bodies.positions_m, axis=1)
    low, high = (np.full(count, np.nan) for _ in range(2))
    placed = np.flatnonzero(bodies.placed)
    if not len(placed):
        return distance, low, high
    points = standard_normal(1)[:, 0]
    modes = [(m.weight, m.positions_m, m.covariance_m2) for m in bodies.modes]
    drawn, shares = [], []
    for weight, positions, covariance in modes or [(1.0, bodies.positions_m, bodies.covariance_m2)]:
        away = np.linalg.norm(positions[placed], axis=1)
        sight = positions[placed] / away[:, None]
        own = np.einsum("ikil->ikl", covariance.reshape(count, 3, count, 3))[placed]
        sd = np.sqrt(np.maximum(np.einsum("ik,ikl,il->i", sight, own, sight), 0.0))
        drawn.append(away[:, None] * np.exp(log_sd(sd / away)[:, None] * points))
        shares.append(np.full(len(points), weight / len(points)))
    lengths, weights = np.concatenate(drawn, axis=1), np.concatenate(shares)
    order = lengths.argsort(axis=1)
    lower, upper = shortest_intervals(np.take_along_axis(lengths, order, axis=1), weights[order])
    low[placed], high[placed] = np.minimum(lower, distance[placed]), np.maximum(upper, distance[placed])
    return distance, low, high


def _horizontal(bodies: Bodies) -> FloatArray:
    """Return the angle on the ground between each body's front and the camera, degrees."""
    ground = bodies.positions_m @ ground_frame(bodies.up)[:2].T
    to_camera = np.arctan2(-ground[:, 0], ground[:, 1])  # the heading that would face the camera
    return np.degrees(np.abs(_wrapped(bodies.heading_rad - to_camera)))


def _wrapped(angle: FloatArray) -> FloatArray:
    """Return angles in radians within half a turn of 0."""
    return (angle + np.pi) % (2 * np.pi) - np.pi


def _vertical(people: People, bodies: Bodies, camera: Camera | None) -> FloatArray:
    """Return how far the camera looks down on each head, degrees; NaN where gravity or the head is unknown."""
    if camera is None or bodies.up is None:
        return np.full(len(bodies), np.nan)
    rays = camera.rays(people.part("Head"))
    sight = rays / np.linalg.norm(rays, axis=1, keepdims=True)
    down = np.degrees(np.arcsin(np.clip(-sight @ bodies.up, -1, 1)))
    return np.where(bodies.placed, down, np.nan)


def _shots(people: People, stature_px: FloatArray, height_px: int) -> tuple[str | None, ...]:
    """Return each person's shot size by the share of the body that the picture shows, and by its size in it.

    The body is taken as long as its stature appears at its distance (by the torso in pixels where it has none), from
    the top of the head down; what the picture's lower edge cuts off is not shown.
    """
    head, shoulder = people.part("Head")[:, 1], people.part("Shoulder")[:, 1]
    top = np.where(np.isfinite(head), head - _HEAD_DEPTH * stature_px, shoulder - _SHOULDER_DEPTH * stature_px)
    share = (height_px - np.maximum(top, 0.0)) / stature_px
    parts = np.searchsorted(_SHOT_SHARES, share)
    return tuple(
        None if math.isnan(s) else SHOTS[part] if part < len(_SHOT_SHARES) else _whole_shot(float(long) / height_px)
        for s, part, long in zip(share, parts, stature_px, strict=True)
    )


def _whole_shot(size: float) -> str:
    """Return the shot size of a body that is wholly in the picture; size: its stature over the picture's height."""
    return "full shot" if size >= _LONG_BELOW else "long shot" if size >= _VERY_LONG_BELOW else "very long shot"


def _stature_px(people: People, bodies: Bodies, camera: Camera | None) -> FloatArray:
    """Return how long each person's stature appears, pixels, shape (P,)."""
    torso = np.linalg.norm(people.joint("neck") - people.joint("mid_hip"), axis=1) / _TORSO_LENGTH
    if camera is None:
        return torso
    seen = camera.f_px * bodies.stature_m / bodies.positions_m[:, 2]
    return np.where(np.isfinite(seen), seen, torso)


def _groups(probability: FloatArray) -> tuple[IntArray, IntArray]:
    """Return each person's group and its size: people linked by pairs that are a group likelier than not."""
    count = len(probability)
    label = np.arange(count)
    for a, b in zip(*np.nonzero(np.triu(probability >= _GROUPED, 1)), strict=True):
        label[label == max(label[a], label[b])] = min(label[a], label[b])
    roots, member, sizes = np.unique(label, return_inverse=True, return_counts=True)
    several = sizes > 1
    number = np.where(several, np.cumsum(several) - 1, -1)
    return number[member].reshape(count), sizes[member].reshape(count) if len(roots) else np.zeros(0, dtype=np.int64)


def _orientations(bodies: Bodies, distances: Distances) -> FloatArray:
    """Return how probable each of `ORIENTATIONS` is for each pair, shape (P, P, 4), from both headings' spreads."""
    count = len(bodies)
    result = np.full((count, count, len(ORIENTATIONS)), np.nan)
    known = np.isfinite(bodies.heading_rad) & np.isfinite(bodies.heading_sd_rad)
    near = (distances.distance_m < ORIENTATION_REACH_M) & known[:, None] & known[None, :]
    a, b = np.nonzero(np.triu(near, 1))
    ground = bodies.positions_m @ ground_frame(bodies.up)[:2].T
    points = standard_normal(2)
    points = np.concatenate([points, points[:, ::-1]])  # neither of a pair comes first
    for start in range(0, len(a), _PAIRS_AT_ONCE):
        i, j = a[start : start + _PAIRS_AT_ONCE], b[start : start + _PAIRS_AT_ONCE]
        gap = ground[j] - ground[i]
        line = np.arctan2(gap[:, 0], -gap[:, 1])[:, None]  # the heading that would face the other
        one = bodies.heading_rad[i][:, None] + bodies.heading_sd_rad[i][:, None] * points[:, 0]
        other = bodies.heading_rad[j][:, None] + bodies.heading_sd_rad[j][:, None] * points[:, 1]
        shares = _turned(np.abs(_wrapped(one - line)), np.abs(_wrapped(other - line - np.pi)), _wrapped(one - other))
        result[i, j] = result[j, i] = np.stack([kind.mean(axis=1) for kind in shares], axis=-1)
    return result


def _turned(one: FloatArray, other: FloatArray, between: FloatArray) -> tuple[NDArray[np.bool_], ...]:
    """Return which draws are each of `ORIENTATIONS`; one, other: angles from the line to the other person, radians."""
    away = np.pi - _TOWARDS_RAD
    alike = np.abs(between) < _PARALLEL_RAD
    aside = [(angle > _PARALLEL_RAD) & (angle < np.pi - _PARALLEL_RAD) for angle in (one, other)]
    side_by_side = aside[0] & aside[1] & alike
    return (
        (one < _TOWARDS_RAD) & (other < _TOWARDS_RAD),
        side_by_side,
        (one > away) & (other > away),
        (((one < _TOWARDS_RAD) & (other > away)) | ((one > away) & (other < _TOWARDS_RAD))) & ~side_by_side,
    )
