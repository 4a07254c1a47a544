"""The paper's pair: YOLOv4 finds boxes, overlapping ones share a crop, OpenPose finds joints there (Seker et al. 2021).

The networks are the user's: yolov4.cfg and yolov4.weights, body_25's pose_deploy.prototxt and
pose_iter_584000.caffemodel, in the model cache or in the folder of `yolov4-openpose:FOLDER`.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from types import MappingProxyType

import numpy as np

from ... import weights
from ...errors import ModelError
from ...files import sha256_of
from ...people import People
from ...people.duplicates import distinct
from ...people.skeleton import BODY_25, Skeleton
from ...photo import Photo, RGBArray
from .. import PoseOptions
from ..confirmation import confirmed_by_boxes
from ..detections import Detections
from .box_groups import BoxGroup, grouped, grouped_as_published
from .opencv_network import DarknetDetector
from .openpose_body25 import Body25

FILES = ("yolov4.cfg", "yolov4.weights", "body_25_pose_deploy.prototxt", "pose_iter_584000.caffemodel")
#: What the same files are called where their makers publish them.
_OTHER_NAMES = {"body_25_pose_deploy.prototxt": "pose_deploy.prototxt"}

#: The paper's pipeline resizes its photos to half their size first.
_RESIZE = 0.5


@dataclass(frozen=True)
class PublishedBehaviour:
    """What the authors' public code does beyond the paper; all off by default.

    grouping: overlap is not transitive (`box_groups.grouped_as_published`). surplus: skeletons beyond the number of
    boxes are dropped, smallest first, and only where more facing pairs of eyes than boxes were seen; without it a
    skeleton counts only where a box holds it, and no person counts twice.
    Not reproduced: a crop there shows the skeletons that earlier crops drew into the photo.
    """

    grouping: bool = False
    surplus: bool = False


class YoloOpenPose:
    """A Darknet detector and BODY_25, one after the other; see the module's own words."""

    skeleton: Skeleton = BODY_25

    def __init__(
        self,
        detector: DarknetDetector,
        pose: Body25,
        *,
        published: PublishedBehaviour | None = None,
        resize: float = _RESIZE,
        name: str = "yolov4-openpose",
    ) -> None:
        self.detector, self.pose, self.resize, self.name = detector, pose, resize, name
        self.published = published or PublishedBehaviour()

    @cached_property
    def models(self) -> Mapping[str, str]:
        """Each file's name and sha256."""
        files = (*self.detector.network.files, *self.pose.network.files)
        return MappingProxyType({file.name: sha256_of(file) for file in files})

    def detect(self, photo: Photo) -> People:
        """Return the people of a photo in pixels of the full-size photo."""
        pixels = self._resized(photo)
        found = self.detector.detect(pixels)
        make_groups = grouped_as_published if self.published.grouping else grouped
        parts = [self._in_group(pixels, found, group) for group in make_groups(found.boxes_px)]
        people = _all_of(parts)
        if not (self.published.surplus or self.published.grouping):
            people = distinct(people)
        height, width = pixels.shape[:2]
        return people.scaled(photo.width / width, photo.height / height)

    def _resized(self, photo: Photo) -> RGBArray:
        import cv2

        size = max(1, int(photo.width * self.resize)), max(1, int(photo.height * self.resize))
        pixels = photo.pixels(max(size))
        if (pixels.shape[1], pixels.shape[0]) == size:
            return pixels
        return np.asarray(cv2.resize(pixels, size, interpolation=cv2.INTER_AREA), np.uint8)

    def _in_group(self, pixels: RGBArray, found: Detections, group: BoxGroup) -> People:
        height, width = pixels.shape[:2]
        x0, y0, x1, y1 = group.region_px
        left, top = max(0, int(x0)), max(0, int(y0))
        part = pixels[top : min(height, int(np.ceil(y1))), left : min(width, int(np.ceil(x1)))]
        if not part.size:
            return People.none(BODY_25)
        points, scores = self.pose.detect(part)
        # OpenPose draws a crop with a margin of black where its sides do not fit; a joint there is outside
        outside = (points < 0) | (points > (part.shape[1], part.shape[0]))
        scores = np.where(outside.any(axis=-1), 0.0, scores)
        people = People(BODY_25, points + (left, top), scores)
        people = people[np.flatnonzero((people.scores > 0).any(axis=1))]
        if self.published.surplus:
            return _without_surplus(people, group.count, (left, top))
        return confirmed_by_boxes(people, found.boxes_px[list(group.rows)])


def _without_surplus(people: People, count: int, corner: tuple[float, float]) -> People:
    """Return what the published code leaves of a group: see `PublishedBehaviour.surplus`.

    It measures areas with missing joints at the crop's corner, where its zeros lie.
    """
    right, left = people.joint("right_eye"), people.joint("left_eye")
    if (left[:, 0] > right[:, 0]).sum() <= count:
        return people
    points = np.where(np.isfinite(people.keypoints_px), people.keypoints_px, np.array(corner, dtype=float))
    areas = (points.max(axis=1) - points.min(axis=1)).prod(axis=1)
    return people[np.argsort(-areas, kind="stable")[:count]]


def _all_of(parts: list[People]) -> People:
    if not parts:
        return People.none(BODY_25)
    return People(
        BODY_25,
        np.concatenate([p.keypoints_px for p in parts]),
        np.concatenate([p.scores for p in parts]),
        np.concatenate([p.boxes_px for p in parts]),
        np.concatenate([p.person_scores for p in parts]),
    )


def open_backend(argument: str, options: PoseOptions) -> YoloOpenPose:
    """Return the paper's pair from the model cache, or from the folder named; raises ModelError."""
    return _opened(argument, PublishedBehaviour(), "yolov4-openpose")


def open_published(argument: str, options: PoseOptions) -> YoloOpenPose:
    """Return the paper's pair with all that the published code does."""
    return _opened(argument, PublishedBehaviour(grouping=True, surplus=True), "yolov4-openpose-published")


def _opened(folder: str, published: PublishedBehaviour, name: str) -> YoloOpenPose:
    cfg, darknet, prototxt, caffe = (_path(file, folder) for file in FILES)
    return YoloOpenPose(DarknetDetector(cfg, darknet), Body25(prototxt, caffe), published=published, name=name)


def _path(file: str, folder: str) -> Path:
    if not folder:
        return weights.verify(file).path
    names = [file, *([_OTHER_NAMES[file]] if file in _OTHER_NAMES else [])]
    present = [Path(folder, name) for name in names if Path(folder, name).is_file()]
    if not present:
        raise ModelError(f"{folder}: no {' nor '.join(names)} in it")
    return present[0]
