"""The back ends that a specification describes: detector and top-down network, or one network for all."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from types import MappingProxyType

import numpy as np

from ...arrays import FloatArray
from ...errors import ModelError, SettingsError
from ...people import People
from ...people.duplicates import distinct
from ...people.skeleton import Skeleton
from ...photo import Photo, RGBArray
from .. import PoseOptions
from ..detections import Detections, seen_often, suppressed
from ..pupils import PupilNetworks
from .letterbox import crop, crop_placement, person_region
from .network import Floats, Network
from .pose_decoders import HEADS
from .specification import Specification, read_specification
from .tiled_detector import PhotoNetwork, input_size, normalised

#: A photo is first decoded with at least this long side, pixels; again larger where a person there is too small.
_FIRST_LOOK_PX = 2000


class OnnxBackend:
    """One specification, its networks loaded, ready to detect; thread-safe.

    Scores are the networks' own, cut to 0..1: of a joint the height of its peak, of a person the geometric mean of the
    detector's score and of the joints' mean, unseen ones counted as 0. `keypoint_noise` has the pixel error of a
    joint's score stands for.
    Raises ModelError where a network is absent, damaged, or does not fit the specification, SettingsError where an
    option does not.
    """

    def __init__(self, specification: Specification, options: PoseOptions | None = None) -> None:
        self.specification, self.options = specification, options or PoseOptions()
        if self.options.flip and specification.pose is None:
            raise SettingsError(f"{specification.name} is one network for all, shown no mirrored crops: leave flip out")
        self.networks = {
            file: Network(
                specification.path_of(file, self.options.device),
                device=self.options.device,
                threads=self.options.threads,
                eight_bits=file in specification.in_eight_bits,
            )
            for file in specification.files
        }
        detector = specification.detector
        wanted = self.options.pupils and set(_EYES) <= set(specification.skeleton.joints)
        self._pupils = PupilNetworks.to_be_had(offline=self.options.offline) if wanted else None
        self._photo_network = PhotoNetwork(detector, self.networks[detector.file], self.options.effort)

    @property
    def name(self) -> str:
        """The specification's name."""
        return self.specification.name

    @property
    def skeleton(self) -> Skeleton:
        """The specification's skeleton."""
        return self.specification.skeleton

    @property
    def models(self) -> Mapping[str, str]:
        """Each network's file name and sha256."""
        own = {network.path.name: network.sha256 for network in self.networks.values()}
        return MappingProxyType({**own, **(self._pupils.models if self._pupils else {})})

    def detect(self, photo: Photo) -> People:
        """Return the people of a photo in pixels of the full-size photo."""
        pixels = photo.pixels(_FIRST_LOOK_PX)
        found = self._photo_network.detect(pixels)
        if self.specification.pose is None:
            people = self._one_stage(found)
        else:
            inside = np.tile((pixels.shape[1], pixels.shape[0]), 2)
            found = found.placed(found.boxes_px.clip(0, inside))
            pixels, found = self._closer_look(photo, pixels, self._distinct(found))
            people = self._top_down(pixels, found)
        height, width = pixels.shape[:2]
        back = photo.width / width, photo.height / height
        people = self._kept(people.scaled(*back), photo)
        if self._pupils is None:
            return people
        return self._pupils.in_place_of_eyes(people.scaled(1 / back[0], 1 / back[1]), pixels).scaled(*back)

    def _distinct(self, found: Detections) -> Detections:
        """Return one box a person: the best of those that overlap, where enough of the detector's cells saw it.

        One look at the whole photo, as in effort fast, has too few cells to ask more than one.
        """
        detector = self.specification.detector
        least = 1 if self.options.effort == "fast" else detector.least_support
        return seen_often(suppressed(found, detector.overlap), found, detector.overlap, least)

    def _closer_look(self, photo: Photo, pixels: RGBArray, found: Detections) -> tuple[RGBArray, Detections]:
        """Decode the photo again, larger, where its pixels are too few for the smallest person found."""
        pose = self.specification.pose
        decoded = pixels.shape[1]
        if pose is None or not len(found) or decoded >= photo.width:
            return pixels, found
        size = input_size(pose, self.networks[pose.file])
        smallest = (found.boxes_px[:, 3] - found.boxes_px[:, 1]).min() * pose.padding
        if smallest >= size[1]:
            return pixels, found
        wanted = min(1.0, decoded / photo.width * size[1] / max(smallest, 1.0)) * max(photo.width, photo.height)
        pixels = photo.pixels(int(np.ceil(wanted)))
        return pixels, found.placed(found.boxes_px * (pixels.shape[1] / decoded))

    def _top_down(self, pixels: RGBArray, found: Detections) -> People:
        if not len(found):
            return People.none(self.skeleton)
        keypoints, scores = self._keypoints(pixels, found)
        if self.options.flip or self.options.effort == "thorough":
            keypoints, scores = self._flip_averaged(pixels, found, keypoints, scores)
        return People(self.skeleton, keypoints, scores, found.boxes_px, found.scores, rivals=found.rivals)

    def _keypoints(self, pixels: RGBArray, found: Detections, flip: bool = False) -> tuple[FloatArray, FloatArray]:
        """Return keypoints (N, K, 2) and scores (N, K) of the boxes, seen in a mirror with `flip`."""
        pose = self.specification.pose
        assert pose is not None
        network = self.networks[pose.file]
        size = input_size(pose, network)
        regions = [person_region(box, size, pose.padding) for box in found.boxes_px]

        def seen(region: tuple[float, float, float, float]) -> Floats:
            canvas, _ = crop(pixels, region, size)
            return normalised((canvas[:, ::-1] if flip else canvas)[None], pose, network)

        outputs = network.run_made([lambda region=region: seen(region) for region in regions])
        points, scores = HEADS[pose.decode](outputs, size)
        self._check_joints(pose.file, points.shape[1])
        if flip:
            order = list(self.skeleton.mirror)
            points, scores = points[:, order] * (-1, 1) + (size[0], 0), scores[:, order]
        placed = [crop_placement(r, size).to_photo(p) for p, r in zip(points, regions, strict=True)]
        return np.stack(placed), scores

    def _flip_averaged(
        self, pixels: RGBArray, found: Detections, keypoints: FloatArray, scores: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Average with what the network sees in a mirror, by score; where both disagree widely the surer one counts."""
        mirrored, mirrored_scores = self._keypoints(pixels, found, flip=True)
        total = np.maximum(scores + mirrored_scores, 1e-9)[..., None]
        mean = (keypoints * scores[..., None] + mirrored * mirrored_scores[..., None]) / total
        heights = (found.boxes_px[:, 3] - found.boxes_px[:, 1])[:, None]
        agree = np.linalg.norm(keypoints - mirrored, axis=-1) < _FLIP_AGREEMENT * heights
        surer = np.where((scores >= mirrored_scores)[..., None], keypoints, mirrored)
        return np.where(agree[..., None], mean, surer), (scores + mirrored_scores) / 2

    def _one_stage(self, found: Detections) -> People:
        if not len(found):
            return People.none(self.skeleton)
        self._check_joints(self.specification.detector.file, found.keypoints_px.shape[1])
        return People(
            self.skeleton, found.keypoints_px, found.keypoint_scores, found.boxes_px, found.scores, rivals=found.rivals
        )

    def _check_joints(self, file: str, count: int) -> None:
        if count != len(self.skeleton):
            raise ModelError(f"{file} returns {count} joints, and {self.skeleton.name} has {len(self.skeleton)}")

    def _kept(self, people: People, photo: Photo) -> People:
        """Return the people left without joints outside the photo, uncertain joints and duplicates."""
        spec = self.specification
        points = people.keypoints_px
        inside = ((points >= 0) & (points <= (photo.width, photo.height))).all(axis=-1)
        scores = np.where(inside & (people.scores >= spec.keypoint_score), people.scores, 0.0)
        # a joint that should be there and is not speaks against the person, one beyond the photo's edge does not
        joint_mean = scores.sum(axis=1) / np.maximum(inside.sum(axis=1), 1)
        person_scores = np.sqrt(people.person_scores * joint_mean)
        people = replace(people, scores=scores, person_scores=person_scores, source=self.name)
        shows_a_trunk = (np.stack([people.joint_score(j) for j in _TRUNK]) > 0).any(axis=0)
        is_person = (person_scores >= spec.person_score) & shows_a_trunk & (_share_inside(people) >= spec.least_inside)
        return distinct(people[is_person], spec.most_similar)


def _share_inside(people: People) -> FloatArray:
    """Return which share of each skeleton's nose, shoulders and hips lies in its own box, shape (P,).

    Where people overlap, a network sometimes finds in one's box the other, who is better seen: that is a duplicate.
    1 where none of these joints is seen.
    """
    points = np.stack([people.joint(joint) for joint in _FRAME], axis=1)
    seen = np.asarray(np.isfinite(points).all(axis=-1))
    margin = _BOX_MARGIN * (people.boxes_px[:, 2:] - people.boxes_px[:, :2])
    low, high = people.boxes_px[:, :2] - margin, people.boxes_px[:, 2:] + margin
    inside = ((points >= low[:, None]) & (points <= high[:, None])).all(axis=-1)
    return np.where(seen.any(axis=1), inside.sum(axis=1) / np.maximum(seen.sum(axis=1), 1), 1.0)


_EYES = ("left_eye", "right_eye")
_FRAME = ("nose", "left_shoulder", "right_shoulder", "left_hip", "right_hip")
#: How far a joint may lie beyond its box, in the box's sides: boxes end at the skin, more or less.
_BOX_MARGIN = 0.05


#: Limbs in a box without any of these are no person who could be placed, and often part of another.
_TRUNK = (
    "nose",
    "left_eye",
    "right_eye",
    "left_ear",
    "right_ear",
    "left_shoulder",
    "right_shoulder",
    "left_hip",
    "right_hip",
)
#: Positions further apart than this fraction of the box's height are two different opinions, not noise.
_FLIP_AGREEMENT = 0.05


def open_backend(argument: str, options: PoseOptions) -> OnnxBackend:
    """Return the back end of a ready specification's name or a TOML file's path."""
    return OnnxBackend(read_specification(argument), options)
