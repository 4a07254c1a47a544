"""A person counts only where two models agree: the paper's idea (Seker et al. 2021), for any pair of models.

`cross-check:A+B` is the back end A with only those of its people whom B confirms.
"""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from ..arrays import FloatArray
from ..assignment import assign
from ..camera import Camera
from ..errors import PhotoError, SettingsError
from ..people import People, PoseBackend
from ..people.skeleton import MIDDLES, Skeleton
from ..photo import Photo
from . import PoseOptions, backend_named
from .recording import Recording

#: Skeletons agree where their shared joints are this close on average: a third of the smaller one's size.
_REACH = 1 / 3
#: A box confirms a skeleton where it holds at least this part of its joints.
_LEAST_INSIDE = 0.5
#: A box is grown by this part of its sides first: detectors cut hands and feet.
_BOX_MARGIN = 0.1


class CrossChecked:
    """The people of one back end whom another confirms, one for one."""

    def __init__(self, first: PoseBackend, second: PoseBackend) -> None:
        self.first, self.second = first, second

    @property
    def name(self) -> str:
        """Both names."""
        return f"cross-check:{self.first.name}+{self.second.name}"

    @property
    def skeleton(self) -> Skeleton:
        """The first back end's."""
        return self.first.skeleton

    @property
    def models(self) -> Mapping[str, str]:
        """Those of both back ends."""
        return MappingProxyType({**self.first.models, **self.second.models})

    def detect(self, photo: Photo) -> People:
        """Return the first back end's people whom the second sees too; the second is not asked about nobody."""
        people = self.first.detect(photo)
        return confirmed_by_people(people, self.second.detect(photo)) if len(people) else people


class CrossCheckedRecording(CrossChecked):
    """The same where one of the two replays a recording: what that knows of a photo beside its people is handed on."""

    @property
    def photos(self) -> tuple[str, ...]:
        """Those of the first back end; the second cannot do without files where the first looks at them."""
        return self.first.photos if isinstance(self.first, Recording) else ()

    def photo(self, name: str) -> Photo:
        """Return the first back end's photo; raises PhotoError where it needs the file or does not state its size."""
        if isinstance(self.first, Recording):
            return self.first.photo(name)
        raise PhotoError(f"{name}: no file, and {self.first.name} looks at the photo")

    def camera_of(self, photo: Photo) -> Camera | None:
        """Return the camera that the first recording to state one states."""
        recordings = (backend for backend in (self.first, self.second) if isinstance(backend, Recording))
        return next((camera for r in recordings if (camera := r.camera_of(photo)) is not None), None)

    def why_nobody(self, photo: Photo) -> str | None:
        """Return why neither recording has anybody there, None where it is not for want of a record."""
        recordings = (backend for backend in (self.first, self.second) if isinstance(backend, Recording))
        return next((why for r in recordings if (why := r.why_nobody(photo)) is not None), None)


def cross_checked(first: PoseBackend, second: PoseBackend) -> CrossChecked:
    """Return the back end of those of the first's people whom the second confirms."""
    replays = isinstance(first, Recording) or isinstance(second, Recording)
    return (CrossCheckedRecording if replays else CrossChecked)(first, second)


def open_backend(argument: str, options: PoseOptions) -> CrossChecked:
    """Return the back end of `cross-check:FIRST+SECOND`; raises SettingsError where there are not two names."""
    names = argument.split("+")
    if len(names) != 2 or not all(names):
        raise SettingsError(f"--pose cross-check:{argument}: write cross-check:FIRST+SECOND")
    return cross_checked(backend_named(names[0], options), backend_named(names[1], options))


def confirmed_by_people(people: People, others: People) -> People:
    """Return those of `people` whom somebody of `others` confirms, one for one, in their order.

    Two skeletons agree where the joints that both have lie near each other on average, relative to the smaller one's
    size; skeletons that share no joint do not.
    """
    return people[_paired(_closeness(people, others))]


def confirmed_by_boxes(people: People, boxes_px: FloatArray) -> People:
    """Return those of `people` whom a detector's box confirms, one for one, in their order.

    boxes_px: shape (N, 4). A box and a skeleton agree where the box, slightly grown, holds at least half of its joints.
    """
    boxes = np.asarray(boxes_px, dtype=float).reshape(-1, 4)
    margins = _BOX_MARGIN * (boxes[:, 2:] - boxes[:, :2])
    low, high = boxes[:, :2] - margins, boxes[:, 2:] + margins
    points = people.keypoints_px[:, None]
    seen = np.isfinite(points).all(axis=-1)
    inside = (points >= low[None, :, None]) & (points <= high[None, :, None])
    share = inside.all(axis=-1).sum(axis=-1) / np.maximum(seen.sum(axis=-1), 1)
    return people[_paired(np.where(share >= _LEAST_INSIDE, share, 0.0))]


def _closeness(people: People, others: People) -> FloatArray:
    """Return how near each skeleton is to each of the others, shape (P, Q): 1 on the same spot, 0 beyond reach."""
    names = list({**dict.fromkeys(people.skeleton.joints), **dict.fromkeys(MIDDLES)})
    ours = np.stack([people.joint(name) for name in names], axis=1)
    theirs = np.stack([others.joint(name) for name in names], axis=1)
    gaps = np.linalg.norm(ours[:, None] - theirs[None], axis=-1)
    shared = np.isfinite(gaps)
    mean = np.where(shared, gaps, 0.0).sum(axis=-1) / np.maximum(shared.sum(axis=-1), 1)
    reach = _REACH * np.minimum.outer(_extent(people), _extent(others))
    near = 1 - mean / np.maximum(reach, 1e-9)
    return np.where(shared.any(axis=-1), np.clip(near, 0.0, 1.0), 0.0)


def _extent(people: People) -> FloatArray:
    """Return the diagonal of each skeleton's bounds, shape (P,)."""
    points = np.where(np.isfinite(people.keypoints_px), people.keypoints_px, np.nan)
    if not len(points):
        return np.zeros(0)
    low = np.where(np.isfinite(points), points, np.inf).min(axis=1)
    high = np.where(np.isfinite(points), points, -np.inf).max(axis=1)
    return np.nan_to_num(np.linalg.norm(high - low, axis=1), posinf=0.0)


def _paired(agreement: FloatArray) -> NDArray[np.intp]:
    """Return the rows that get a partner of their own where as many and as good pairs as possible are made."""
    return np.array([row for row, column in assign(-agreement) if agreement[row, column] > 0], dtype=np.intp)
