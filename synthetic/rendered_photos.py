"""Photos of rendered people before cameras from eye level to steeply above, with everything about them known."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np

from proxemetry.arrays import FloatArray, RGBArray
from proxemetry.camera import Camera
from synthetic.rendered_people import Bodies, Figure

#: Pitches in degrees, and how high a camera hangs that looks down so far, metres.
VIEWS = {0: (1.2, 1.8), 10: (1.5, 2.2), 20: (1.8, 2.6), 30: (2.2, 3.0), 40: (2.6, 3.4), 53: (3.0, 3.6)}
_WIDTH, _HEIGHT = 1280, 720
_LARGER = 2  # drawn at twice the size
_TORSO_M = 1.1
_NEAREST_M, _SMALLEST_GAP_M = 1.0, 0.55


@dataclass(frozen=True, eq=False)
class RenderedPhoto:
    """A picture and its truth.

    view: the key of `VIEWS`. pitch_rad, roll_rad, height_m: the camera's. joints_m: shape (P, 17, 3), camera frame.
    to_camera: shape (3, 3), from the floor's frame (x right, y down, z forward). shown: shape (P,), pixels of each.
    """

    view: int
    pixels: RGBArray
    camera: Camera
    pitch_rad: float
    height_m: float
    to_camera: FloatArray
    joints_m: FloatArray
    shown: np.ndarray


def rendered_photos(wheel: Path, count: int, seed: int) -> Iterator[RenderedPhoto]:
    """Yield photos of two to four people 1.5 to 5 m away, the views in turn."""
    bodies = Bodies(wheel)
    for number in range(count):
        rng = np.random.default_rng([seed, number])
        view = list(VIEWS)[number % len(VIEWS)]
        pitch = np.deg2rad(view + (rng.normal(0, 2) if view else 0))
        height, focal = float(rng.uniform(*VIEWS[view])), float(_WIDTH * rng.uniform(0.65, 1.1))
        camera = Camera.centred(focal, _WIDTH, _HEIGHT)
        figures = [bodies.figure(rng) for _ in range(int(rng.integers(2, 5)))]
        places = _places(len(figures), view, pitch, height, focal, rng)
        headings = rng.uniform(-np.pi, np.pi, len(figures))
        yield _drawn(view, camera, float(pitch), height, figures, places, headings, rng)


def _places(count: int, view: int, pitch: float, height: float, focal: float, rng: np.random.Generator) -> FloatArray:
    """Return x and z on the floor (count, 2) of people whose torsos are in the picture, apart from one another."""
    places = np.zeros((count, 2))
    for _ in range(500):
        down = pitch + np.arctan(rng.uniform(-0.18, 0.18, count) * _HEIGHT / focal)
        far = (height - _TORSO_M) / np.tan(down) if view >= 20 else rng.uniform(2.0, 4.8, count)
        across = rng.uniform(-0.38, 0.38, count) * _WIDTH / focal * np.hypot(far, height - _TORSO_M)
        places = np.column_stack([across, far])
        apart = np.linalg.norm(places[:, None] - places, axis=-1) + 9 * np.eye(count)
        if apart.min() > _SMALLEST_GAP_M and far.min() > _NEAREST_M and far.max() < 5:
            break
    return places


def _drawn(
    view: int, camera: Camera, pitch: float, height: float, figures: list[Figure], places: FloatArray,
    headings: FloatArray, rng: np.random.Generator,
) -> RenderedPhoto:  # fmt: skip
    roll = rng.normal(0, 0.01)
    (c, s), (cr, sr) = (np.cos(pitch), np.sin(pitch)), (np.cos(roll), np.sin(roll))
    to_camera = np.array([[cr, -sr, 0], [sr, cr, 0], [0, 0, 1]]) @ np.array([[1, 0, 0], [0, c, -s], [0, s, c]])
    canvas = _room(camera, height, to_camera, rng)
    canvas = canvas * _shadows(camera, height, to_camera, places)[..., None]
    canvas = np.ascontiguousarray(np.clip(canvas, 0, 255).astype(np.uint8))
    light = to_camera @ _unit(np.array([rng.normal(), -abs(rng.normal()) - 1.2, rng.normal()]))
    joints, corners, colours, depths, owners = [], [], [], [], []
    for owner, (figure, (x, z), heading) in enumerate(zip(figures, places, headings, strict=True)):
        sine, cosine = np.sin(heading), np.cos(heading)
        axes = np.array([[sine, 0, -cosine], [cosine, 0, sine], [0, -1, 0]])  # forward, left, up
        place = np.array([x, height, z])
        joints.append((figure.joints_m @ axes + place) @ to_camera.T)
        vertices = (figure.vertices_m @ axes + place) @ to_camera.T
        triangles = vertices[figure.triangles]
        normals = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
        normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-12)
        middle = triangles.mean(axis=1)
        facing = ((normals * middle).sum(axis=1) < 0) & (triangles[..., 2].min(axis=1) > 0.15)
        bright = 0.55 + 0.5 * np.clip(normals @ light, 0, 1) * (1 + 0.03 * rng.normal(size=len(normals)))
        corners.append(camera.project(triangles[facing].reshape(-1, 3)).reshape(-1, 3, 2))
        colours.append((figure.colours * bright[:, None])[facing])
        depths.append(middle[facing, 2])
        owners.append(np.full(int(facing.sum()), owner))
    shown = _paint(canvas, *map(np.concatenate, (corners, colours, depths, owners)))
    small = cv2.resize(canvas.astype(np.float32), (camera.width, camera.height), interpolation=cv2.INTER_AREA)
    noisy = cv2.GaussianBlur(small, (0, 0), 0.6) + rng.normal(0, 3, small.shape)
    pixels = np.clip(noisy, 0, 255).astype(np.uint8)
    counts = np.array([(shown == owner).sum() for owner in range(len(figures))]) // _LARGER**2
    return RenderedPhoto(view, pixels, camera, pitch, height, to_camera, np.array(joints), counts)


def _paint(
    canvas: RGBArray, corners: FloatArray, colours: FloatArray, depths: FloatArray, owners: np.ndarray
) -> np.ndarray:  # fmt: skip
    """Paint triangles onto the canvas, the farthest first; return whose each of its pixels is, -1 for nobody's."""
    shown = np.full(canvas.shape[:2], -1, np.int16)
    fixed = np.rint(corners * _LARGER * 16).astype(np.int32)
    for k in np.argsort(-depths):
        cv2.fillConvexPoly(canvas, fixed[k], np.clip(colours[k], 0, 255).tolist(), cv2.LINE_AA, 4)
        cv2.fillConvexPoly(shown, fixed[k], int(owners[k]), cv2.LINE_8, 4)
    return shown


def _room(camera: Camera, height: float, to_camera: FloatArray, rng: np.random.Generator) -> FloatArray:
    """Return a tiled floor and a wall, twice as large as the camera's picture."""
    u, v = np.meshgrid(np.arange(camera.width) + 0.5, np.arange(camera.height) + 0.5)
    rays = np.dstack([(u - camera.cx) / camera.fx, (v - camera.cy) / camera.fy, np.ones_like(u)]) @ to_camera
    wall_m, tile_m = rng.uniform(5.5, 9), rng.uniform(0.3, 1.0)
    with np.errstate(divide="ignore", invalid="ignore"):
        to_floor = np.where(rays[..., 1] > 1e-6, height / rays[..., 1], np.inf)
        to_wall = np.where(rays[..., 2] > 1e-6, wall_m / rays[..., 2], np.inf)
    on_floor = (to_floor < to_wall)[..., None]
    at = rays * np.minimum(to_floor, to_wall)[..., None]
    grain = cv2.GaussianBlur(rng.random((256, 256)).astype(np.float32), (0, 0), 1.5)
    grain = (grain - grain.min()) / np.ptp(grain)
    across, along = at[..., 0] * 90, np.where(on_floor[..., 0], at[..., 2] * 90, at[..., 1] * 60)
    speckle = grain[along.astype(int) % 256, across.astype(int) % 256][..., None]
    floor = rng.uniform(90, 190) * np.array([1, 0.97, 0.92]) * (0.8 + 0.4 * speckle)
    wall = rng.uniform(120, 220) * (0.85 + 0.3 * speckle) * np.ones(3)
    picture = np.where(on_floor, floor, wall)
    seams = ((np.mod(at[..., 0], tile_m) < 0.012) | (np.mod(at[..., 2], tile_m) < 0.012)) & on_floor[..., 0]
    picture[seams] *= 0.75
    return np.asarray(cv2.resize(picture, (_LARGER * camera.width, _LARGER * camera.height)), float)


def _shadows(camera: Camera, height: float, to_camera: FloatArray, places: FloatArray) -> FloatArray:
    shade = np.ones((camera.height, camera.width), np.float32)
    angles = np.linspace(0, 2 * np.pi, 40)
    for x, z in places:
        ring = np.column_stack([x + 0.28 * np.cos(angles), np.full(40, height), z + 0.28 * np.sin(angles)])
        seen = ring @ to_camera.T
        if seen[:, 2].min() > 0.2:
            cv2.fillPoly(shade, [camera.project(seen).astype(np.int32)], 0.55)
    size = (_LARGER * camera.width, _LARGER * camera.height)
    return np.asarray(cv2.resize(cv2.GaussianBlur(shade, (0, 0), 6), size), float)


def _unit(vector: FloatArray) -> FloatArray:
    return vector / np.linalg.norm(vector)
