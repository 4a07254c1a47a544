"""Pixelating heads, found from the keypoints: a person that the pose back end missed stays recognisable."""

from __future__ import annotations

import numpy as np

from ..arrays import FloatArray
from ..people import People
from ..photo import RGBArray

#: The values of `--faces`.
FACES = ("show", "blur")

_FACE = ("nose", "left_eye", "right_eye", "left_ear", "right_ear", "head_top")

#: Cells across a head: at 5 no eye, mouth or outline is left to compare.
_CELLS = 5


def heads_px(people: People) -> FloatArray:
    """Return a circle (x, y, radius) around each person's head, shape (P, 3), in the people's own pixels.

    The radius is the largest that the face, the shoulders, the neck or the torso suggest, so that one misplaced joint
    rather blurs too much; a person without a seen head gets the top of the box. NaN where there is no box either.
    """
    face = np.stack([people.joint(j) for j in _FACE])
    centre = people.part("Head")
    neck = people.joint("neck")
    torso = np.linalg.norm(neck - people.joint("mid_hip"), axis=-1)
    shoulders = np.linalg.norm(people.joint("left_shoulder") - people.joint("right_shoulder"), axis=-1)
    spread = np.linalg.norm(face - centre, axis=-1)
    box = people.boxes_px
    width, height = box[:, 2] - box[:, 0], box[:, 3] - box[:, 1]
    sizes = np.stack([
        1.35 * _largest(spread), 0.42 * shoulders, 0.30 * torso, 0.75 * np.linalg.norm(neck - centre, axis=-1),
    ])  # fmt: skip
    radius = _largest(sizes)
    top = np.stack([(box[:, 0] + box[:, 2]) / 2, box[:, 1] + 0.11 * height], axis=-1)
    seen = np.asarray(np.isfinite(centre).all(axis=-1))
    centre = np.where(seen[:, None], centre, top)
    fallback = np.minimum(0.14 * height, 0.6 * width)
    radius = np.where(np.isfinite(radius), np.where(seen, radius, np.fmax(radius, fallback)), fallback)
    radius = np.fmin(radius, np.fmax(width, height))  # a stray joint must not blot out the photo
    return np.concatenate([centre, radius[:, None]], axis=-1)


def _largest(values: FloatArray) -> FloatArray:
    """Return the largest along the first axis, leaving NaN out; NaN where there is nothing else."""
    highest = np.where(np.isfinite(values), values, -np.inf).max(axis=0)
    return np.where(np.isfinite(highest), highest, np.nan)


def pixelated(pixels: RGBArray, heads: FloatArray) -> RGBArray:
    """Return a copy of pixels (H, W, 3) in which the circles (x, y, radius), shape (P, 3), are coarse squares."""
    result = pixels.copy()
    for x, y, radius in heads[np.isfinite(heads).all(axis=1)]:
        _pixelate(result, float(x), float(y), max(float(radius), 2.0))
    return result


def _pixelate(pixels: RGBArray, x: float, y: float, radius: float) -> None:
    height, width = pixels.shape[:2]
    x0, x1 = max(0, int(x - radius)), min(width, int(x + radius) + 1)
    y0, y1 = max(0, int(y - radius)), min(height, int(y + radius) + 1)
    if x0 >= x1 or y0 >= y1:
        return
    cell = max(2, round(2 * radius / _CELLS))
    region = pixels[y0:y1, x0:x1]
    rows, columns = np.arange(y0, y1), np.arange(x0, x1)
    coarse = region.copy()
    for top in range(0, len(rows), cell):
        for left in range(0, len(columns), cell):
            block = region[top : top + cell, left : left + cell]
            coarse[top : top + cell, left : left + cell] = block.reshape(-1, 3).mean(axis=0)
    inside = (rows[:, None] + 0.5 - y) ** 2 + (columns[None] + 0.5 - x) ** 2 <= radius**2
    region[inside] = coarse[inside]
