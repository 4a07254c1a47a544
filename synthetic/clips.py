"""Synthetic clips: people who walk on a level floor, as keypoints in a file, and an empty video."""

from __future__ import annotations

import json
from pathlib import Path

import cv2
import numpy as np

from proxemetry.camera import Camera, Mount

from .bodies import draw_build, draw_posture, pose_joints

WIDTH, HEIGHT, FOCAL_PX = 640, 480, 700.0
PITCH_RAD, HEIGHT_M = np.deg2rad(20.0), 4.0


def camera() -> Camera:
    return Camera.centred(FOCAL_PX, WIDTH, HEIGHT)


def mount(sd_rad: float = 1e-4, height_sd_m: float = 1e-3) -> Mount:
    """The camera's place, as nearly exactly known as wanted."""
    return Mount.stated(
        PITCH_RAD, 0.0, HEIGHT_M, pitch_sd_rad=sd_rad, roll_sd_rad=sd_rad, height_sd_m=height_sd_m, camera=camera()
    )


def on_floor(points_m: np.ndarray) -> np.ndarray:
    """Return points (..., 3), metres to the right, ahead and above the floor, in the camera frame."""
    up = np.array([0.0, -np.cos(PITCH_RAD), -np.sin(PITCH_RAD)])
    ahead = np.array([0.0, -np.sin(PITCH_RAD), np.cos(PITCH_RAD)])
    axes = np.stack([np.array([1.0, 0.0, 0.0]), ahead, up])
    return (np.asarray(points_m, dtype=float) - (0.0, 0.0, HEIGHT_M)) @ axes


def walkers(frames: int, step_s: float) -> np.ndarray:
    """Two who walk side by side, one who comes towards them, and one who stands: places (frames, 4, 2)."""
    t = np.arange(frames)[:, None] * step_s
    still = np.zeros_like(t)
    return np.stack([
        np.hstack([-3 + 1.2 * t, still + 9]), np.hstack([-3 + 1.2 * t, still + 9.8]),
        np.hstack([3 - 1.1 * t, still + 9.5]), np.hstack([still + 2, still + 13]),
    ], axis=1)  # fmt: skip


def write_video(path: Path, frames: int, rate: float, size: tuple[int, int] = (WIDTH, HEIGHT), seed: int = 0) -> Path:
    """Write a video of a still background with corners to hold on to."""
    writer = cv2.VideoWriter(str(path), cv2.VideoWriter.fourcc(*"MJPG"), rate, size)
    picture = background(size, seed)
    for _ in range(frames):
        writer.write(picture)
    writer.release()
    return path


def background(size: tuple[int, int], seed: int = 0) -> np.ndarray:
    """Return a picture of grey blocks, (H, W, 3)."""
    blocks = np.random.default_rng(seed).integers(40, 220, (size[1] // 20 + 1, size[0] // 20 + 1), dtype=np.uint8)
    gray = np.kron(blocks, np.ones((20, 20), np.uint8))[: size[1], : size[0]]
    return np.repeat(gray[..., None], 3, axis=2)


def recorded(
    path: Path, names: list[str], places: np.ndarray, noise: float = 0.003, seed: int = 0,
    hidden: np.ndarray | None = None,
) -> Path:  # fmt: skip
    """Write the keypoints of people at places (F, P, 2) to the right and ahead, NaN where unseen, a frame a name.

    noise: standard deviation of a joint, in heights of the person in the picture. hidden: shape (F, P), of whom the
    legs are behind something.
    """
    from proxemetry.people.skeleton import COCO_17

    rng = np.random.default_rng(seed)
    builds = [draw_build(rng) for _ in range(places.shape[1])]
    bodies = [pose_joints(b, draw_posture(rng, seated=False)) for b in builds]
    images = []
    covered = np.zeros(places.shape[:2], dtype=bool) if hidden is None else hidden
    for name, where, behind in zip(names, places, covered, strict=True):
        people = []
        for body, place, legless in zip(bodies, where, behind, strict=True):
            if np.isfinite(place).all():
                people.append(_person(body, place, COCO_17.joints, noise, rng, legless))
        images.append({"filename": name, "width": WIDTH, "height": HEIGHT, "people": people})
    path.write_text(json.dumps({"skeleton": "coco17", "images": images}))
    return path


def _person(body, place, joints, noise, rng, legless=False) -> dict:
    points = np.array([body[j] for j in joints])
    # everyone faces the camera: a body's left is to the right, its front nearer
    floor = np.column_stack([place[0] + points[:, 1], place[1] - points[:, 0], points[:, 2]])
    pixels = camera().project(on_floor(floor))
    tall = np.ptp(pixels[:, 1])
    pixels = pixels + rng.normal(0, noise * tall, pixels.shape)
    low, high = pixels.min(axis=0) - 0.05 * tall, pixels.max(axis=0) + 0.05 * tall
    scores = [0.0 if legless and j.endswith(("hip", "knee", "ankle")) else 0.9 for j in joints]
    return {
        "keypoints": [[float(x), float(y), s] for (x, y), s in zip(pixels, scores, strict=True)],
        "box": [*map(float, low), *map(float, high)],
        "score": 0.9,
    }
