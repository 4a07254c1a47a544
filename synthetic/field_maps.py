"""BODY_25's heatmaps and affinity fields of known people, drawn as its training targets are (Cao et al. 2019)."""

from __future__ import annotations

import numpy as np

from proxemetry.people.skeleton import BODY_25
from proxemetry.pose.paper.body25 import CHANNELS, JOINTS, LIMBS

#: Joints of a standing figure one unit tall, x to the photo's right and y down from the crown; it faces the camera.
_FIGURE = {
    "nose": (0, 0.08), "neck": (0, 0.18), "mid_hip": (0, 0.50), "shoulder": (0.11, 0.18), "elbow": (0.14, 0.33),
    "wrist": (0.15, 0.47), "hip": (0.06, 0.51), "knee": (0.065, 0.73), "ankle": (0.07, 0.94), "eye": (0.025, 0.06),
    "ear": (0.05, 0.07), "big_toe": (0.09, 1.0), "small_toe": (0.12, 0.985), "heel": (0.05, 0.975),
}  # fmt: skip
_SIGMA, _WIDTH = 7.0, 5.0


def standing(x: float, y: float, height: float, rng: np.random.Generator | None = None) -> np.ndarray:
    """A figure's joints, shape (25, 2), whose crown is at (x, y); with `rng` its limbs are moved about."""
    points = []
    for joint in BODY_25.joints:
        side, _, part = joint.partition("_")
        dx, dy = _FIGURE.get(joint) or _FIGURE[part]
        points.append((-dx if side == "right" else dx, dy))
    moved = np.array(points) + (rng.normal(0, 0.012, (JOINTS, 2)) if rng else 0)
    return moved * height + (x, y)


def maps_of(people: list[np.ndarray], size: tuple[int, int], stride: int = 1, sigma: float = _SIGMA) -> np.ndarray:
    """Return maps of shape (78, height / stride, width / stride); a joint that is NaN is not drawn.

    A cell's value is that of the target in its middle, in whole-numbered positions of the full size.
    """
    across = np.arange(size[0] // stride) * stride + (stride - 1) / 2
    down = np.arange(size[1] // stride) * stride + (stride - 1) / 2
    maps = np.zeros((CHANNELS, len(down), len(across)))
    touched = np.zeros_like(maps)

    def near(points: np.ndarray, reach: float) -> tuple[slice, slice]:
        """The rows and columns that lie within reach of the points' bounds: all else is not drawn."""
        low, high = points.min(axis=0) - reach, points.max(axis=0) + reach
        rows, columns = np.searchsorted(down, (low[1], high[1])), np.searchsorted(across, (low[0], high[0]))
        return slice(*rows), slice(*columns)

    for joints in people:
        for joint, at in enumerate(joints):
            if np.isfinite(at).all():
                rows, columns = near(at[None], 4 * sigma)
                x, y = np.meshgrid(across[columns], down[rows])
                bump = np.exp(-((x - at[0]) ** 2 + (y - at[1]) ** 2) / (2 * sigma**2))
                maps[joint, rows, columns] = np.maximum(maps[joint, rows, columns], bump)
        for a, b, channel in LIMBS:
            start, end = joints[a], joints[b]
            length = np.linalg.norm(end - start)
            if not np.isfinite(length) or length < 1e-6:
                continue
            unit = (end - start) / length
            rows, columns = near(np.array([start, end]), 2 * _WIDTH)
            x, y = np.meshgrid(across[columns], down[rows])
            along = (x - start[0]) * unit[0] + (y - start[1]) * unit[1]
            aside = np.abs((x - start[0]) * unit[1] - (y - start[1]) * unit[0])
            on_limb = (along >= -_WIDTH) & (along <= length + _WIDTH) & (aside <= _WIDTH)
            for axis in (0, 1):
                maps[JOINTS + 1 + channel + axis, rows, columns] += unit[axis] * on_limb
                touched[JOINTS + 1 + channel + axis, rows, columns] += on_limb
    return (maps / np.maximum(touched, 1)).astype(np.float32)
