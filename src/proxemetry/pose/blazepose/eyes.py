"""Pupils: from a detected face by the face mesh to the iris network, to a tenth of the eye's width."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ...arrays import FloatArray
from .networks import Network
from .regions import Picture, Region

_MESH_POINTS, _IRIS_POINTS = 468, 5
# Corners of the right and the left eye in the mesh, outer and inner.
_RIGHT_EYE, _LEFT_EYE = (33, 133), (263, 362)
# MediaPipe's rules: the face's square is 1.5 times its extent, an eye's 2.3 times its width.
_FACE_FACTOR, _EYE_FACTOR = 1.5, 2.3
# Below this the mesh network's flag means that there is no face (MediaPipe's threshold).
_FACE_MINIMUM = 0.5


@dataclass(frozen=True, eq=False)
class Pupils:
    """Left and right pupil in pixels of the picture, shape (2,) each, and the mesh's score that this is a face."""

    left_px: FloatArray
    right_px: FloatArray
    score: float


class PupilFinder:
    """Both networks at work on a picture."""

    def __init__(self, mesh: Path, iris: Path) -> None:
        # One thread: these networks are so small that a second one only waits.
        self._mesh, self._iris = Network(mesh, 1), Network(iris, 1)

    def find(self, picture: Picture, box_px: FloatArray, points_px: FloatArray) -> Pupils | None:
        """Return the pupils of a detected face (its box and points: right eye, left eye first), None where unsure."""
        right, left = points_px[0], points_px[1]
        extent = float((box_px[2:] - box_px[:2]).max())
        centre = (box_px[:2] + box_px[2:]) / 2
        mesh, score = self._look(picture, _square(centre, extent * _FACE_FACTOR, left - right))
        if score < _FACE_MINIMUM:
            return None
        extent = float((mesh.max(axis=0) - mesh.min(axis=0)).max())
        across = mesh[list(_LEFT_EYE)].mean(axis=0) - mesh[list(_RIGHT_EYE)].mean(axis=0)
        centre = (mesh.max(axis=0) + mesh.min(axis=0)) / 2
        mesh, score = self._look(picture, _square(centre, extent * _FACE_FACTOR, across))
        if score < _FACE_MINIMUM:
            return None
        return Pupils(self._pupil(picture, mesh, _LEFT_EYE), self._pupil(picture, mesh, _RIGHT_EYE), score)

    def _look(self, picture: Picture, region: Region) -> tuple[FloatArray, float]:
        outputs = self._mesh(_scaled(picture.crop(region, self._mesh.side)))
        points = outputs[_MESH_POINTS * 3].reshape(_MESH_POINTS, 3)[:, :2].astype(float) / self._mesh.side
        return region.to_photo(points), 1 / (1 + math.exp(-float(outputs[1].ravel()[0])))

    def _pupil(self, picture: Picture, mesh: FloatArray, corners: tuple[int, int]) -> FloatArray:
        outer, inner = mesh[corners[0]], mesh[corners[1]]
        across = outer - inner if corners == _LEFT_EYE else inner - outer
        region = _square((outer + inner) / 2, float(np.linalg.norm(across)) * _EYE_FACTOR, across)
        crop = picture.crop(region, self._iris.side)
        mirrored = corners == _RIGHT_EYE  # the network knows left eyes only
        outputs = self._iris(_scaled(crop[:, ::-1] if mirrored else crop))
        pupil = outputs[_IRIS_POINTS * 3].reshape(_IRIS_POINTS, 3)[0, :2].astype(float) / self._iris.side
        return region.to_photo(np.array([1 - pupil[0], pupil[1]]) if mirrored else pupil)


def _square(centre: FloatArray, size: float, across: FloatArray) -> Region:
    """Return a square whose horizontal axis runs along `across`."""
    return Region(float(centre[0]), float(centre[1]), max(size, 1.0), math.atan2(float(across[1]), float(across[0])))


def _scaled(crop: NDArray[np.uint8]) -> NDArray[np.float32]:
    return crop.astype(np.float32) / np.float32(255)
