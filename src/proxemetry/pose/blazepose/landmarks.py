"""The landmark network: one square of the photo in, one person's 33 joints out, with the evidence for them."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ...arrays import FloatArray
from ...people.skeleton import BLAZEPOSE_33
from .networks import Network
from .regions import Picture, Region

_JOINTS = len(BLAZEPOSE_33)
_LEFT_SHOULDER, _RIGHT_SHOULDER, _LEFT_HIP, _RIGHT_HIP = 11, 12, 23, 24
_POINTS = 39  # 33 joints, 2 points that give the next square, 4 unused
_HEAT = 64
_MASK = 64
_MIRROR = np.array([*BLAZEPOSE_33.mirror, 33, 34, 35, 36, 37, 38])
#: MediaPipe refines a landmark from a 7 x 7 patch of its heat map where that reaches 0.5.
_PATCH, _PATCH_MINIMUM = 7, 0.5


@dataclass(frozen=True, eq=False)
class Candidate:
    """The network's answer for one square.

    keypoints_px: (33, 2). visibility, presence, peaks: (33,), 0..1; the last is the height of each heat map.
    flag: whether a person is there, 0..1. world_m: (33, 3), metres about the hips, x right and y down in the photo,
    z away from the camera. mask: (64, 64) over the square, 0..1; None where the look was a quick one. region: where it
    looked; next_region: where it would look again.
    """

    keypoints_px: FloatArray
    visibility: FloatArray
    presence: FloatArray
    peaks: FloatArray
    flag: float
    world_m: FloatArray
    mask: FloatArray | None
    region: Region
    next_region: Region

    @property
    def facing(self) -> complex:
        """Where the torso faces as exp(i h): h = 0 faces the viewer, positive turns towards the photo's right."""
        left, right = self.world_m[[_LEFT_SHOULDER, _LEFT_HIP]], self.world_m[[_RIGHT_SHOULDER, _RIGHT_HIP]]
        across = (left - right).sum(axis=0)
        return complex(across[0], across[2]) / max(math.hypot(across[0], across[2]), 1e-9)


class Landmarks:
    """The landmark network at work on a picture; counts its runs.

    It is loaded twice, whole and without what draws the silhouette: a quick look is a quarter cheaper.
    """

    def __init__(self, path: Path, threads: int) -> None:
        self._whole = Network(path, threads)
        self._quick = Network(path, threads, without=self._whole.side**2)
        self.runs = 0

    def look(self, picture: Picture, region: Region, *, mirrored: bool = False, quick: bool = False) -> Candidate:
        """Return what the network sees in a region; `mirrored` shows it the region flipped left to right."""
        self.runs += 1
        side = self._whole.side
        crop = picture.crop(region, side)
        if mirrored:
            crop = crop[:, ::-1]
        outputs = (self._quick if quick else self._whole)(crop.astype(np.float32) / np.float32(255))
        values = outputs[_POINTS * 5].reshape(_POINTS, 5).astype(float)
        heat = outputs[_HEAT * _HEAT * _POINTS].reshape(_HEAT, _HEAT, _POINTS)
        mask = None if quick else _thinned(outputs[side * side].reshape(side, side))
        world = outputs[_POINTS * 3].reshape(_POINTS, 3).astype(float)
        points = _refined(values[:, :2] / side, heat)
        peaks = _sigmoid(heat.reshape(-1, _POINTS).max(axis=0))
        if mirrored:
            points, values, peaks, world = _flipped(points, values, peaks, world)
            mask = None if mask is None else mask[:, ::-1]
        angle = region.angle_rad
        world[:, :2] = world[:, :2] @ np.array(
            [[math.cos(angle), math.sin(angle)], [-math.sin(angle), math.cos(angle)]]
        )
        photo = region.to_photo(points)
        return Candidate(
            photo[:_JOINTS], _sigmoid(values[:_JOINTS, 3]), _sigmoid(values[:_JOINTS, 4]), peaks[:_JOINTS],
            float(outputs[1].ravel()[0]), world[:_JOINTS], mask, region,
            Region.around(photo[_JOINTS], photo[_JOINTS + 1], 1.25),
        )  # fmt: skip


def _thinned(logits: NDArray[np.float32]) -> FloatArray:
    """Return a silhouette of 64 x 64 probabilities: the middle one of each block of cells."""
    step = len(logits) // _MASK
    return _sigmoid(logits[step // 2 :: step, step // 2 :: step])


def _refined(points: FloatArray, heat: NDArray[np.float32]) -> FloatArray:
    """Move each point to the centre of mass of its heat map nearby, where that is sure enough; fractions in and out."""
    column, row = (np.floor(points * _HEAT).astype(int)).T
    inside = (column >= 0) & (column < _HEAT) & (row >= 0) & (row < _HEAT)
    steps = np.arange(_PATCH) - _PATCH // 2
    rows = np.clip(row, 0, _HEAT - 1)[:, None] + steps
    columns = np.clip(column, 0, _HEAT - 1)[:, None] + steps
    valid = ((rows >= 0) & (rows < _HEAT))[:, :, None] & ((columns >= 0) & (columns < _HEAT))[:, None, :]
    joint = np.arange(len(points))[:, None, None]
    clipped = np.clip(rows, 0, _HEAT - 1)[:, :, None], np.clip(columns, 0, _HEAT - 1)[:, None, :]
    patch = np.where(valid, _sigmoid(heat[*clipped, joint]), 0.0)
    total = patch.sum(axis=(1, 2))
    mass = np.stack(
        [(patch * columns[:, None, :]).sum(axis=(1, 2)), (patch * rows[:, :, None]).sum(axis=(1, 2))], axis=1
    )
    sure = inside & (patch.max(axis=(1, 2)) >= _PATCH_MINIMUM)
    return np.where(sure[:, None], mass / np.maximum(total, 1e-9)[:, None] / _HEAT, points)


def _flipped(
    points: FloatArray, values: FloatArray, peaks: FloatArray, world: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Return what was seen in a mirrored square as in the square itself, left and right named anew."""
    return (points * (-1, 1) + (1, 0))[_MIRROR], values[_MIRROR], peaks[_MIRROR], (world * (-1, 1, 1))[_MIRROR]


def _sigmoid(values: NDArray[np.floating]) -> FloatArray:
    return 1 / (1 + np.exp(-np.clip(values.astype(float), -60, 60)))
