"""The back ends that a specification describes: detector and top-down network, or one network for all."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from ..errors import ModelError
from ..people import People
from ..photo import Photo, RGBArray
from ..skeleton import Skeleton
from . import PoseOptions
from .detections import DECODERS, Detections, joined, suppressed, uncut
from .duplicates import distinct
from .heads import HEADS
from .letterbox import Placement, Region, crop, letterbox, person_region, tiles
from .network import Floats, Network
from .one_stage import ONE_STAGE, Skeletons
from .specification import Input, Specification, read_specification

FloatArray = NDArray[np.float64]

#: A photo is first decoded with at least this long side, pixels; again larger where a person there is too small.
_FIRST_LOOK_PX = 2000


class OnnxBackend:
    """One specification, its networks loaded, ready to detect; thread-safe.

    Scores are the networks' own, cut to 0..1: of a joint the height of its peak, of a person the geometric mean of the
    detector's score and of the joints' mean, unseen ones counted as 0. `keypoint_noise` says what pixel error a
    joint's score stands for.
    Raises ModelError where a network is absent, damaged, or does not fit the specification.
    """

    def __init__(self, specification: Specification, options: PoseOptions | None = None) -> None:
        self.specification, self.options = specification, options or PoseOptions()
        self.networks = {
            file: Network(specification.path_of(file), device=self.options.device, threads=self.options.threads)
            for file in specification.files
        }

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
        return MappingProxyType({network.path.name: network.sha256 for network in self.networks.values()})

    def detect(self, photo: Photo) -> People:
        """Return the people of a photo in pixels of the full-size photo."""
        pixels = photo.pixels(_FIRST_LOOK_PX)
        if self.specification.pose is None:
            people = self._one_stage(pixels)
        else:
            found = self._boxes(pixels)
            pixels, found = self._closer_look(photo, pixels, found)
            people = self._top_down(pixels, found)
        height, width = pixels.shape[:2]
        return self._kept(people.scaled(photo.width / width, photo.height / height), photo)

    def _looks(self, pixels: RGBArray, size: tuple[int, int]) -> list[Region]:
        height, width = pixels.shape[:2]
        detector, effort = self.specification.detector, self.options.effort
        fractions = {"fast": detector.fast_tiles, "thorough": detector.thorough_tiles}.get(effort) or detector.tiles
        return [region for fraction in fractions for region in tiles(width, height, fraction, size[0] / size[1])]

    def _boxes(self, pixels: RGBArray) -> Detections:
        detector = self.specification.detector
        network = self.networks[detector.file]
        size = _size(detector, network)
        photo_size = pixels.shape[1], pixels.shape[0]

        def look(region: Region) -> Detections:
            canvas, placement = letterbox(pixels, region, size, fill=detector.fill, centred=detector.centred)
            outputs = network.run_one(_normalised(canvas[None], detector))
            found = DECODERS[detector.decode](outputs, size, detector.person, detector.score)
            return uncut(Detections(placement.boxes_to_photo(found.boxes_px), found.scores), region, photo_size)

        parts = network.each([lambda region=region: look(region) for region in self._looks(pixels, size)])
        found = joined(parts)
        inside = np.tile(photo_size, 2)
        return suppressed(Detections(found.boxes_px.clip(0, inside), found.scores), detector.overlap)

    def _closer_look(self, photo: Photo, pixels: RGBArray, found: Detections) -> tuple[RGBArray, Detections]:
        """Decode the photo again, larger, where its pixels are too few for the smallest person found."""
        pose = self.specification.pose
        decoded = pixels.shape[1]
        if pose is None or not len(found) or decoded >= photo.width:
            return pixels, found
        size = _size(pose, self.networks[pose.file])
        smallest = (found.boxes_px[:, 3] - found.boxes_px[:, 1]).min() * pose.padding
        if smallest >= size[1]:
            return pixels, found
        wanted = min(1.0, decoded / photo.width * size[1] / max(smallest, 1.0)) * max(photo.width, photo.height)
        pixels = photo.pixels(int(np.ceil(wanted)))
        return pixels, Detections(found.boxes_px * (pixels.shape[1] / decoded), found.scores)

    def _top_down(self, pixels: RGBArray, found: Detections) -> People:
        if not len(found):
            return People.none(self.skeleton)
        keypoints, scores = self._keypoints(pixels, found)
        if self.options.flip or self.options.effort == "thorough":
            keypoints, scores = self._flip_averaged(pixels, found, keypoints, scores)
        return People(self.skeleton, keypoints, scores, found.boxes_px, found.scores)

    def _keypoints(self, pixels: RGBArray, found: Detections, flip: bool = False) -> tuple[FloatArray, FloatArray]:
        """Return keypoints (N, K, 2) and scores (N, K) of the boxes, seen in a mirror with `flip`."""
        pose = self.specification.pose
        assert pose is not None
        network = self.networks[pose.file]
        size = _size(pose, network)

        def cut(box: FloatArray) -> tuple[RGBArray, Placement]:
            return crop(pixels, person_region(box, size, pose.padding), size)

        crops = network.each([lambda box=box: cut(box) for box in found.boxes_px])
        canvases = np.stack([canvas for canvas, _ in crops])
        outputs = network.run(_normalised(canvases[:, :, ::-1] if flip else canvases, pose))
        points, scores = HEADS[pose.decode](outputs, size)
        if points.shape[1] != len(self.skeleton):
            raise ModelError(
                f"{pose.file} answers {points.shape[1]} joints, and {self.skeleton.name} has {len(self.skeleton)}"
            )
        if flip:
            order = list(self.skeleton.mirror)
            points, scores = points[:, order] * (-1, 1) + (size[0], 0), scores[:, order]
        return np.stack([at.to_photo(p) for p, (_, at) in zip(points, crops, strict=True)]), scores

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

    def _one_stage(self, pixels: RGBArray) -> People:
        spec = self.specification.detector
        network = self.networks[spec.file]
        size = _size(spec, network)
        photo_size = pixels.shape[1], pixels.shape[0]

        def look(region: Region) -> People:
            canvas, at = letterbox(pixels, region, size, fill=spec.fill, centred=spec.centred)
            found, points, scores = ONE_STAGE[spec.decode](network.run_one(_normalised(canvas[None], spec)), spec.score)
            return self._people_in(region, photo_size, at, (found, points, scores))

        parts: list[People] = network.each([lambda region=region: look(region) for region in self._looks(pixels, size)])
        return People(
            self.skeleton,
            np.concatenate([p.keypoints_px for p in parts]),
            np.concatenate([p.scores for p in parts]),
            np.concatenate([p.boxes_px for p in parts]),
            np.concatenate([p.person_scores for p in parts]),
        )

    def _people_in(self, region: Region, photo_size: tuple[int, int], at: Placement, seen: Skeletons) -> People:
        found, points, scores = seen
        if len(found) and points.shape[1] != len(self.skeleton):
            raise ModelError(
                f"{self.specification.detector.file} answers {points.shape[1]} joints, and {self.skeleton.name} has "
                f"{len(self.skeleton)}"
            )
        boxes = at.boxes_to_photo(found.boxes_px)
        # an index as the score: `uncut` says by it which rows stay
        rows = uncut(Detections(boxes, np.arange(len(found), dtype=float)), region, photo_size).scores.astype(np.intp)
        if not len(rows):
            return People.none(self.skeleton)
        return People(self.skeleton, at.to_photo(points)[rows], scores[rows], boxes[rows], found.scores[rows])

    def _kept(self, people: People, photo: Photo) -> People:
        """Return who is left once joints outside the photo and unsure ones are missing, and doubles are dropped."""
        spec = self.specification
        points = people.keypoints_px
        inside = ((points >= 0) & (points <= (photo.width, photo.height))).all(axis=-1)
        scores = np.where(inside & (people.scores >= spec.keypoint_score), people.scores, 0.0)
        # a joint that should be there and is not speaks against the person, one beyond the photo's edge does not
        joint_mean = scores.sum(axis=1) / np.maximum(inside.sum(axis=1), 1)
        person_scores = np.sqrt(people.person_scores * joint_mean)
        people = People(self.skeleton, points, scores, people.boxes_px, person_scores)
        is_person = (person_scores >= spec.person_score) & (np.stack([people.joint_score(j) for j in _TRUNK]) > 0).any(
            axis=0
        )
        return distinct(people[is_person], spec.most_similar)


#: Limbs in a box without any of these are nobody who could be placed, and often part of somebody else.
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


def _size(part: Input, network: Network) -> tuple[int, int]:
    fixed = network.input_size
    if fixed is None and min(part.size) <= 0:
        raise ModelError(f"{part.file} takes any size: state `size` in the specification")
    if fixed is not None and min(part.size) > 0 and tuple(part.size) != fixed:
        raise ModelError(f"{part.file} takes {fixed[0]} x {fixed[1]}, and the specification says {list(part.size)}")
    return fixed or (int(part.size[0]), int(part.size[1]))


def _normalised(canvases: RGBArray, part: Input) -> Floats:
    """Return images (B, H, W, 3) as a network's input (B, 3, H, W)."""
    ordered = canvases[..., ::-1] if part.colours == "bgr" else canvases
    values = np.ascontiguousarray(ordered.transpose(0, 3, 1, 2), np.float32)
    if part.mean != (0.0, 0.0, 0.0):
        values -= np.array(part.mean, np.float32).reshape(3, 1, 1)
    if part.std != (1.0, 1.0, 1.0):
        values /= np.array(part.std, np.float32).reshape(3, 1, 1)
    return values
