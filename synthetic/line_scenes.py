"""Straight segments as a detector would find them, of synthetic scenes whose camera is known.

Segments are placed in the picture and turned towards the vanishing point of their direction in the world, as the edges
of things are; walls are a little out of true, lenses bend, principal points are not in the middle.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from proxemetry.arrays import FloatArray

Rng = np.random.Generator

SIZES = ((640, 480), (480, 640), (1024, 683), (1600, 1200), (3000, 4000), (6000, 4000), (1920, 1080), (800, 800))


@dataclass(frozen=True, eq=False)
class LineScene:
    """One picture's segments (N, 4) in pixels, and the camera: focal_px, principal point, pitch and roll in degrees."""

    kind: str
    segments_px: FloatArray
    width: int
    height: int
    focal_px: float
    cx_px: float
    cy_px: float
    pitch_deg: float
    roll_deg: float

    @property
    def down(self) -> FloatArray:
        """Gravity's direction in the camera frame."""
        pitch, roll = math.radians(self.pitch_deg), math.radians(self.roll_deg)
        return np.array([-math.sin(roll) * math.cos(pitch), math.cos(roll) * math.cos(pitch), math.sin(pitch)])


@dataclass(frozen=True)
class Family:
    """Segments along one direction of the world (x right, y down, z ahead): count, and how far each strays, degrees.

    region: where they lie, as parts of the picture's sides: x0, y0, x1, y1.
    """

    direction: tuple[float, float, float]
    count: int
    stray_deg: float = 0.3
    region: tuple[float, float, float, float] = (0.0, 0.0, 1.0, 1.0)


UP = (0.0, 1.0, 0.0)


def level(azimuth_deg: float) -> tuple[float, float, float]:
    """Return a horizontal direction, seen straight ahead at azimuth 0."""
    return (math.sin(math.radians(azimuth_deg)), 0.0, math.cos(math.radians(azimuth_deg)))


def _parts(rng: Rng) -> list[tuple[float, float, float, float]]:
    """Return the walls of a scene: rectangles of the picture that overlap."""
    walls: list[tuple[float, float, float, float]] = []
    for _ in range(int(rng.integers(2, 6))):
        x, y = np.sort(rng.random(2)), np.sort(rng.random(2))
        walls.append((float(x[0] * 0.8), float(y[0] * 0.6), float(min(1, x[1] + 0.2)), float(min(1, y[1] + 0.3))))
    return walls


def _city(rng: Rng, azimuths: list[float], shares: list[float], count: int) -> list[Family]:
    families: list[Family] = []
    walls = _parts(rng)
    for wall in walls:
        across = int(rng.choice(len(azimuths), p=np.array(shares) / sum(shares)))
        lean = rng.normal(0, 0.3, 2)
        upright = (math.radians(lean[0]), 1.0, math.radians(lean[1]))
        sloped = level(azimuths[across] + rng.normal(0, 0.4))
        sloped = (sloped[0], math.radians(rng.standard_t(3) * 0.6), sloped[2])
        n = max(2, int(count / len(walls) * rng.uniform(0.4, 1.6)))
        part = rng.uniform(0.3, 0.7)
        families += [
            Family(upright, max(1, int(n * part)), 0.35, wall),
            Family(sloped, max(1, int(n * (1 - part))), 0.35, wall),
        ]
    return families


def _count(rng: Rng) -> int:
    return int(np.exp(rng.uniform(math.log(25), math.log(400))))


def street(rng: Rng) -> list[Family]:
    """Walls at right angles."""
    turn = rng.uniform(0, 90)
    return _city(rng, [turn, turn + 90], [1.0, rng.uniform(0.2, 1)], _count(rng))


def odd_angles(rng: Rng) -> list[Family]:
    """Walls at any angles to one another: two to four of them."""
    turns = list(rng.uniform(0, 180, int(rng.integers(2, 5))))
    return _city(rng, turns, [1.0] * len(turns), _count(rng))


def one_wall(rng: Rng) -> list[Family]:
    """One horizontal direction alone."""
    return _city(rng, [rng.uniform(0, 180)], [1.0], _count(rng))


def fence(rng: Rng) -> list[Family]:
    """Many posts and a few rails."""
    turn = rng.uniform(0, 180)
    band = (0.0, float(rng.uniform(0.2, 0.5)), 1.0, 1.0)
    return [Family(UP, int(rng.integers(20, 120)), 1.0, band), Family(level(turn), int(rng.integers(2, 12)), 0.5, band)]


def trees(rng: Rng) -> list[Family]:
    """Trunks, roughly upright."""
    return [Family(UP, int(rng.integers(10, 80)), float(rng.uniform(3, 8)))]


def stairs(rng: Rng) -> list[Family]:
    """A flight of stairs with its slanted rails, and some wall."""
    turn, slope = rng.uniform(0, 180), math.radians(rng.uniform(25, 38))
    x, _, z = level(turn)
    slanted = (x * math.cos(slope), math.sin(slope), z * math.cos(slope))
    return [
        Family(slanted, int(rng.integers(8, 40)), 0.5, (0.2, 0.2, 0.8, 0.9)),
        Family(level(turn + 90), int(rng.integers(5, 40)), 0.4, (0.2, 0.2, 0.8, 0.9)),
        Family(UP, int(rng.integers(0, 30)), 0.5),
    ]


def few(rng: Rng) -> list[Family]:
    """A handful of segments along a building's directions."""
    turn = rng.uniform(0, 90)
    return [Family(d, int(rng.integers(1, 4)), 0.3) for d in (UP, level(turn), level(turn + 90))]


def clutter(rng: Rng) -> list[Family]:
    """Nothing straight that belongs together."""
    del rng
    return []


def round_things(rng: Rng) -> list[Family]:
    """Wheels, bowls, heads: every direction, in a few places."""
    families: list[Family] = []
    for _ in range(int(rng.integers(2, 8))):
        x, y = rng.uniform(0, 0.8, 2)
        region = (float(x), float(y), float(x + 0.2), float(y + 0.2))
        families += [Family(_anywhere(rng), 1, 0.5, region) for _ in range(int(rng.integers(8, 30)))]
    return families


def single_object(rng: Rng) -> list[Family]:
    """A box that lies anyhow: three directions at right angles that are not gravity's."""
    axes = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    x, y = rng.uniform(0.05, 0.4, 2)
    size = rng.uniform(0.25, 0.55)
    region = (float(x), float(y), float(x + size), float(y + size))
    return [Family(tuple(axis.tolist()), int(rng.integers(4, 25)), 0.4, region) for axis in axes]


def stripes(rng: Rng) -> list[Family]:
    """Many parallel lines in any direction, sometimes crossed."""
    families = [Family(_anywhere(rng), int(rng.integers(15, 80)), 0.4)]
    if rng.random() < 0.4:
        families.append(Family(_anywhere(rng), int(rng.integers(5, 40)), 0.4))
    return families


def _anywhere(rng: Rng) -> tuple[float, float, float]:
    x, y, z = rng.normal(size=3)
    return (float(x), float(y), float(z))


STRAIGHT: dict[str, Callable[[Rng], list[Family]]] = {
    "street": street, "odd angles": odd_angles, "one wall": one_wall, "fence": fence, "stairs": stairs, "few": few,
}  # fmt: skip
WITHOUT: dict[str, Callable[[Rng], list[Family]]] = {
    "clutter": clutter, "round things": round_things, "single object": single_object, "stripes": stripes,
    "trees": trees,
}  # fmt: skip
KINDS = STRAIGHT | WITHOUT


def line_scene(kind: str, rng: Rng) -> LineScene:
    """Return one picture of a kind, by any camera held about upright."""
    width, height = SIZES[int(rng.integers(len(SIZES)))]
    diagonal = math.hypot(width, height)
    focal = diagonal * float(np.clip(np.exp(rng.normal(math.log(35), 0.5)), 14, 300)) / math.hypot(36, 24)
    pitch = float(rng.normal(0, 5) if rng.random() < 0.6 else rng.uniform(-20, 40))
    roll = float(rng.normal(0, 1.2 if rng.random() < 0.8 else 5.0))
    return seen_by(kind, rng, width, height, focal, pitch, roll)


def seen_by(
    kind: str, rng: Rng, width: int, height: int, focal_px: float, pitch_deg: float, roll_deg: float
) -> LineScene:  # fmt: skip
    """Return one picture of a kind by a camera that is given, but for its principal point and how its lens bends."""
    centre = np.array([width, height]) / 2 + rng.normal(0, 0.006 * math.hypot(width, height), 2)
    families = KINDS[kind](rng)
    straight = sum(family.count for family in families)
    bent = float(rng.normal(0, 0.01)) if rng.random() < 0.5 else 0.0
    scene = LineScene(kind, np.zeros((0, 4)), width, height, focal_px, *centre.tolist(), pitch_deg, roll_deg)
    pieces = [_seen(family, scene, rng, bent) for family in families]
    pieces.append(_stray_segments(scene, rng, int(straight * rng.uniform(0.05, 1.2)) + int(rng.integers(5, 40))))
    segments = np.concatenate(pieces)
    swapped = rng.random(len(segments)) < 0.5
    segments[swapped] = segments[swapped][:, [2, 3, 0, 1]]
    return replace(scene, segments_px=segments)


def _lengths(rng: Rng, count: int) -> FloatArray:
    """Return lengths in diagonals as detectors find them: York's median is 0.03, one in ten is longer than 0.08."""
    return np.clip(np.exp(rng.normal(math.log(0.032), 0.75, count)), 0.01, 0.6)


def _seen(family: Family, scene: LineScene, rng: Rng, bent: float) -> FloatArray:
    x0, y0, x1, y1 = family.region
    size = np.array([scene.width, scene.height])
    diagonal = math.hypot(*size)
    middle = rng.uniform((x0, y0), (x1, y1), (family.count, 2)) * size
    to_camera = _axes(scene)
    d = np.array(family.direction) / np.linalg.norm(family.direction)
    d = (d + rng.normal(0, math.radians(family.stray_deg), (family.count, 3))) @ to_camera.T
    away = middle - (scene.cx_px, scene.cy_px)
    along = scene.focal_px * d[:, :2] - away * d[:, 2:]
    return _drawn(
        middle, np.arctan2(along[:, 1], along[:, 0]), _lengths(rng, family.count) * diagonal, scene, rng, bent
    )


def _axes(scene: LineScene) -> FloatArray:
    """Return the matrix from the world (y along gravity) to the camera."""
    pitch, roll = math.radians(scene.pitch_deg), math.radians(scene.roll_deg)
    down = scene.down
    right = np.array([math.cos(roll), math.sin(roll), 0.0])
    ahead = np.array([math.sin(roll) * math.sin(pitch), -math.cos(roll) * math.sin(pitch), math.cos(pitch)])
    return np.stack([right, down, ahead], axis=1)


def _stray_segments(scene: LineScene, rng: Rng, count: int) -> FloatArray:
    """Return clutter: any angle, or roughly upright or level."""
    middle = rng.random((count, 2)) * (scene.width, scene.height)
    rough = rng.integers(0, 2, count) * math.pi / 2 + rng.normal(0, math.radians(10), count)
    angle = np.where(rng.random(count) < rng.uniform(0.2, 0.9), rng.uniform(0, math.pi, count), rough)
    lengths = _lengths(rng, count) * 0.7 * math.hypot(scene.width, scene.height)
    return _drawn(middle, angle, lengths, scene, rng, 0.0)


def _drawn(
    middle: FloatArray, angle: FloatArray, length: FloatArray, scene: LineScene, rng: Rng, bent: float
) -> FloatArray:
    """Return segments (n, 4) with the detector's noise and the lens's distortion; `bent` is k1 for the diagonal."""
    diagonal = math.hypot(scene.width, scene.height)
    half = 0.5 * length[:, None] * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    ends = np.stack([middle - half, middle + half], axis=1)
    ends = ends + rng.standard_t(4, ends.shape) * 0.0006 * diagonal
    away = (ends - (scene.cx_px, scene.cy_px)) / (diagonal / 2)
    ends = ends + bent * (away**2).sum(axis=-1, keepdims=True) * away * diagonal / 2
    return ends.reshape(-1, 4)


def exact_scene(
    pitch_deg: float, roll_deg: float, focal_px: float, width: int, height: int, azimuths_deg: tuple[float, ...],
    each: int,
) -> LineScene:  # fmt: skip
    """Return walls without noise, lean or clutter: `each` upright segments, then as many along every azimuth."""
    rng = np.random.default_rng(0)
    scene = LineScene("exact", np.zeros((0, 4)), width, height, focal_px, width / 2, height / 2, pitch_deg, roll_deg)
    diagonal = math.hypot(width, height)
    segments: list[FloatArray] = []
    for direction in (UP, *(level(azimuth) for azimuth in azimuths_deg)):
        middle = rng.uniform(0.05, 0.95, (each, 2)) * (width, height)
        x, y, z = _axes(scene) @ direction
        along = focal_px * np.array([x, y]) - (middle - (width / 2, height / 2)) * z
        half = 0.05 * diagonal * along / np.linalg.norm(along, axis=1, keepdims=True)
        segments.append(np.concatenate([middle - half, middle + half], axis=1))
    return replace(scene, segments_px=np.concatenate(segments))
