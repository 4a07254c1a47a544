"""Cameras calibrated together, and people's joints triangulated from all of them: the truth for each single picture."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import combinations
from xml.etree import ElementTree as ET

import numpy as np

from benchmarks.networks.known_people import owners
from proxemetry.arrays import FloatArray
from proxemetry.camera import Camera
from proxemetry.people import People
from proxemetry.people.skeleton import COCO_17

#: How far sight lines pass a joint by, metres: what lies further by a multiple counts for little (Cauchy's weight).
_MISS_M = 0.02
#: A sight line that passes further from the joint is of another joint, metres.
_OUTLIER_M = 0.08
_STEPS = 12
_STATURE_M = 1.7
#: Who is seen with so many joints is looked for in other views.
_LEAST_JOINTS = 10
#: Turning the cameras until sight lines meet has converged by then.
_TURNS = 6
#: By how much cameras are knocked, radians, and how far sight lines pass by a joint, metres: assumed.
_KNOCKED_RAD, _TYPICAL_MISS_M = np.deg2rad(0.5), 0.01


@dataclass(frozen=True, eq=False)
class View:
    """A calibrated camera: rotation (3, 3) and shift (3,) in metres from the room's frame, z up, to the camera's."""

    name: str
    camera: Camera
    rotation: FloatArray
    shift_m: FloatArray

    @property
    def centre_m(self) -> FloatArray:
        """The optical centre in the room's frame."""
        return -self.rotation.T @ self.shift_m

    @property
    def up(self) -> FloatArray:
        """Up in the camera frame."""
        return self.rotation[:, 2]

    @property
    def pitch_rad(self) -> float:
        """How far the camera looks down."""
        return float(-np.arcsin(self.up[2]))

    @property
    def roll_rad(self) -> float:
        """As in `bodies.Floor`."""
        return float(np.arctan2(self.up[0], -self.up[1]))

    def seen(self, points_m: FloatArray) -> FloatArray:
        """Return points (..., 3) of the room in the camera frame."""
        return points_m @ self.rotation.T + self.shift_m

    def sight_lines(self, pixels: FloatArray) -> FloatArray:
        """Return unit vectors (..., 3) of the room's frame through pixels (..., 2)."""
        rays = self.camera.rays(pixels) @ self.rotation
        return rays / np.linalg.norm(rays, axis=-1, keepdims=True)


def read_qualisys(text: bytes) -> list[View]:
    """Read the cameras of a Qualisys calibration (`.qca.txt`).

    Its lengths are mm and 64ths of a pixel whose middle is a whole number; its cameras look along -z with y up.
    """
    views: list[View] = []
    for part in ET.fromstring(text).iter("camera"):
        place, lens, field = (_numbers(part, name) for name in ("transform", "intrinsic", "fov_video"))
        own_axes = np.array([[place[f"r{i}{j}"] for j in (1, 2, 3)] for i in (1, 2, 3)])
        rotation = np.diag([1.0, -1.0, -1.0]) @ own_axes
        centre = np.array([place[axis] for axis in "xyz"]) / 1000
        bent = ("radialDistortion1", "radialDistortion2", "tangentalDistortion1", "tangentalDistortion2")
        k1, k2, p1, p2 = (lens[name] for name in bent)
        camera = Camera(
            lens["focalLengthU"] / 64, lens["focalLengthV"] / 64, lens["centerPointU"] / 64 - field["left"] + 0.5,
            lens["centerPointV"] / 64 - field["top"] + 0.5, int(field["right"] - field["left"] + 1),
            int(field["bottom"] - field["top"] + 1), distortion=(k1, k2, p1, p2, 0.0),
        )  # fmt: skip
        views.append(View(part.attrib["serial"], camera, rotation, -rotation @ centre))
    return views


def _numbers(part: ET.Element, name: str) -> dict[str, float]:
    found = part.find(name)
    return {} if found is None else {key: float(value) for key, value in found.attrib.items()}


def met(origins: FloatArray, lines: FloatArray, weights: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the point (3,) that sight lines pass nearest to, and how far each passes it by (N,), metres.

    origins, lines: shape (N, 3), the latter of unit length; weights: shape (N,). What passes far off counts little:
    every pair of lines is tried as a start, and Cauchy's weights follow from the best.
    """
    across = np.eye(3) - lines[:, :, None] * lines[:, None, :]
    starts = np.array([np.isin(np.arange(len(lines)), pair) for pair in combinations(range(len(lines)), 2)], float)
    points = _nearest(origins, across, starts)
    for _ in range(_STEPS):
        points = _nearest(origins, across, weights / (1 + (_misses(points, origins, across) / _MISS_M) ** 2))
    misses = _misses(points, origins, across)
    best = int((np.log1p((misses / _MISS_M) ** 2) @ weights).argmin())
    return points[best], misses[best]


def _nearest(origins: FloatArray, across: FloatArray, weights: FloatArray) -> FloatArray:
    """Return the points (S, 3) nearest to the lines by weights (S, N)."""
    normal = np.einsum("sn,nij->sij", weights, across) + 1e-9 * np.eye(3)  # lines may be all but parallel
    return np.linalg.solve(normal, np.einsum("sn,nij,nj->si", weights, across, origins)[..., None])[..., 0]


def _misses(points: FloatArray, origins: FloatArray, across: FloatArray) -> FloatArray:
    """Return how far lines pass points (S, 3) by, (S, N)."""
    return np.linalg.norm(np.einsum("nij,snj->sni", across, points[:, None] - origins), axis=-1)


@dataclass(frozen=True, eq=False)
class Sighting:
    """One person as one back end saw them in one view."""

    view: int
    pixels: FloatArray  # (17, 2)
    scores: FloatArray  # (17,)


def triangulated(views: Sequence[View], sightings: Sequence[Sighting], least_views: int = 3) -> FloatArray:
    """Return the joints (17, 3) in the room's frame, NaN where fewer views agree within 8 cm."""
    joints = np.full((len(COCO_17), 3), np.nan)
    for k in range(len(COCO_17)):
        rows = [s for s in sightings if s.scores[k] > 0 and np.isfinite(s.pixels[k]).all()]
        if len({s.view for s in rows}) < least_views:
            continue
        origins = np.array([views[s.view].centre_m for s in rows])
        lines = np.array([views[s.view].sight_lines(s.pixels[k]) for s in rows])
        point, miss = met(origins, lines, np.array([s.scores[k] for s in rows]))
        if len({s.view for s, off in zip(rows, miss, strict=True) if off < _OUTLIER_M}) >= least_views:
            joints[k] = point
    return joints


def together(views: Sequence[View], seen: Sequence[People]) -> list[dict[int, int]]:
    """Return the people of one moment: for each, the row in each view where they were found.

    seen: what one back end found in each view. Every two people of two views are taken for one, their joints put where
    the sight lines meet, and whoever is seen there in the other views joins them; who meets best is kept.
    """
    tried: list[tuple[int, float, dict[int, int]]] = []
    for a, b in combinations(range(len(views)), 2):
        for i in range(len(seen[a])):
            for j in range(len(seen[b])):
                sightings = [Sighting(v, seen[v].keypoints_px[r], seen[v].scores[r]) for v, r in ((a, i), (b, j))]
                rows, off = _joining(views, seen, _two_views(views, sightings))
                if {a, b} <= rows.keys() and rows[a] == i and rows[b] == j:
                    tried.append((-len(rows), off, rows))
    kept: list[dict[int, int]] = []
    for _, _, rows in sorted(tried, key=lambda t: t[:2]):
        if not any(other.get(v) == r for other in kept for v, r in rows.items()):
            kept.append(rows)
    return kept


def _two_views(views: Sequence[View], sightings: Sequence[Sighting]) -> FloatArray:
    joints = np.full((len(COCO_17), 3), np.nan)
    origins = np.array([views[s.view].centre_m for s in sightings])
    for k in range(len(COCO_17)):
        pixels = np.array([s.pixels[k] for s in sightings])
        if np.isfinite(pixels).all():
            lines = np.array([views[s.view].sight_lines(s.pixels[k]) for s in sightings])
            joints[k], _ = met(origins, lines, np.ones(2))
    return joints


def _joining(views: Sequence[View], seen: Sequence[People], joints_m: FloatArray) -> tuple[dict[int, int], float]:
    """Return who in each view has their joints there, and the mean of how far off, statures."""
    rows: dict[int, int] = {}
    offs: list[float] = []
    for v, view in enumerate(views):
        inside = view.seen(joints_m)
        pixels, depth = view.camera.project(inside), float(np.nanmedian(np.append(inside[:, 2], np.nan)))
        if np.isfinite(pixels).all(axis=1).sum() < _LEAST_JOINTS or not depth > 0:
            continue
        stature_px = view.camera.f_px * _STATURE_M / depth
        whom = owners(seen[v], pixels[None], np.array([stature_px]))
        if (whom == 0).any():
            rows[v] = int(np.flatnonzero(whom == 0)[0])
            gaps = np.linalg.norm(seen[v].keypoints_px[rows[v]] - pixels, axis=1)
            offs.append(float(np.nanmedian(gaps)) / stature_px)
    return rows, float(np.mean(offs)) if offs else np.inf


def turned_to_meet(views: Sequence[View], people: Sequence[Sequence[Sighting]]) -> list[View]:
    """Return the cameras turned, each about its own place, until the sight lines of everyone's joints meet best.

    Cameras that were calibrated once are knocked since, by some tenths of a degree; where they stand changes less.
    Gauss-Newton's steps with Cauchy's weights, the joints eliminated; sight lines miss joints by about a centimetre.
    """
    turned, so_far = list(views), np.zeros(3 * len(views))
    held = (_TYPICAL_MISS_M / _KNOCKED_RAD) ** 2
    for _ in range(_TURNS):
        normal, right = held * np.eye(len(so_far)), -held * so_far
        for sightings in people:
            joints = triangulated(turned, sightings)
            for k in np.flatnonzero(np.isfinite(joints).all(axis=1)):
                rows = [s for s in sightings if s.scores[k] > 0 and np.isfinite(s.pixels[k]).all()]
                one_normal, one_right = _turning(turned, rows, joints[k], int(k))
                normal += one_normal
                right += one_right
        turns = np.asarray(np.linalg.solve(normal, right), dtype=float)
        so_far = so_far + turns  # so small that they add up
        turned = [_turned(view, turn) for view, turn in zip(turned, turns.reshape(-1, 3), strict=True)]
    return turned


def _turning(
    views: Sequence[View], rows: Sequence[Sighting], joint_m: FloatArray, k: int
) -> tuple[FloatArray, FloatArray]:  # fmt: skip
    """Return the normal equations of all cameras' small turns from one joint, wherever it is."""
    by_turn = np.zeros((3 * len(rows), 3 * len(views)))
    by_place, off = np.zeros((3 * len(rows), 3)), np.zeros(3 * len(rows))
    for n, s in enumerate(rows):
        line, apart = views[s.view].sight_lines(s.pixels[k]), joint_m - views[s.view].centre_m
        across = np.eye(3) - np.outer(line, line)
        miss = across @ apart
        weight = np.sqrt(s.scores[k] / (1 + (np.linalg.norm(miss) / _MISS_M) ** 2))
        at = slice(3 * n, 3 * n + 3)
        # a line that turns by w moves by w x line, so that the joint's miss changes by line x w times how far it is
        by_turn[at, 3 * s.view : 3 * s.view + 3] = weight * (line @ apart) * np.cross(np.eye(3), line)
        by_place[at], off[at] = weight * across, weight * miss
    freed = np.eye(3 * len(rows)) - by_place @ np.linalg.pinv(by_place)
    return by_turn.T @ freed @ by_turn, -by_turn.T @ freed @ off


def _turned(view: View, turn: FloatArray) -> View:
    """Return a camera turned by a rotation vector of the room's frame."""
    angle = float(np.linalg.norm(turn))
    x, y, z = turn / angle if angle else turn
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    matrix = np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross
    rotation = view.rotation @ matrix.T
    return View(view.name, view.camera, rotation, -rotation @ view.centre_m)


def straightened(view: View) -> tuple[View, FloatArray]:
    """Return the camera turned about its axis until it is level, and the matrix (2, 3) that turns its picture."""
    roll = view.roll_rad
    c, s = np.cos(roll), np.sin(roll)
    turn = np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])
    k1, k2, _, _, k3 = view.camera.distortion  # the same all around; the rest is a fraction of a pixel
    camera = replace(view.camera, distortion=(k1, k2, 0.0, 0.0, k3))
    centre = np.array([camera.cx, camera.cy])
    matrix = np.column_stack([turn[:2, :2], centre - turn[:2, :2] @ centre])
    return View(f"{view.name} upright", camera, turn @ view.rotation, turn @ view.shift_m), matrix
