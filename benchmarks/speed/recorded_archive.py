"""Small photos and the keypoints recorded for them, for runs that need no network: a helper of other benchmarks."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
from PIL import Image

WIDTH, HEIGHT = 160, 120
_F_PX = 150.0
#: Joints of a standing adult in metres from the middle of the torso, x to the photo's right, y down (COCO's order).
_FIGURE_M = (
    (0.0, -0.42), (0.03, -0.45), (-0.03, -0.45), (0.07, -0.44), (-0.07, -0.44), (0.17, -0.25), (-0.17, -0.25),
    (0.24, 0.05), (-0.24, 0.05), (0.25, 0.28), (-0.25, 0.28), (0.09, 0.25), (-0.09, 0.25), (0.1, 0.65), (-0.1, 0.65),
    (0.1, 1.05), (-0.1, 1.05),
)  # fmt: skip


def name_of(number: int) -> str:
    """Return the name of a photo."""
    return f"{number // 500:04d}/photo_{number:07d}.jpg"


def write_photos(folder: Path, count: int) -> None:
    """Write small photos, each like no other."""
    for number in range(count):
        path = folder / name_of(number)
        path.parent.mkdir(parents=True, exist_ok=True)
        coarse = np.random.default_rng(number).integers(0, 255, (HEIGHT // 8, WIDTH // 8, 3), dtype=np.uint8)
        Image.fromarray(coarse).resize((WIDTH, HEIGHT)).save(path, quality=80)


def write_keypoints(path: Path, count: int) -> None:
    """Write keypoints of one to four people in each photo, with the camera that saw them."""
    camera = {"fx": _F_PX, "fy": _F_PX, "cx": WIDTH / 2, "cy": HEIGHT / 2}
    images = [
        {"filename": name_of(n), "width": WIDTH, "height": HEIGHT, "camera": camera, "people": _people(n)}
        for n in range(count)
    ]
    path.write_text(json.dumps({"skeleton": "coco17", "images": images}))


def _people(number: int) -> list[dict[str, object]]:
    random = np.random.default_rng([7, number])
    people: list[dict[str, object]] = []
    for _ in range(int(random.integers(1, 5))):
        depth = random.uniform(3, 9)
        x, y = random.uniform(-0.4, 0.4) * depth, random.uniform(-0.1, 0.3)
        points = (np.array(_FIGURE_M) + (x, y)) * _F_PX / depth + (WIDTH / 2, HEIGHT / 2)
        people.append({"keypoints": [[round(float(u), 2), round(float(v), 2), 0.9] for u, v in points], "score": 0.9})
    return people
