"""The embedded pose back end: several people a photo from MediaPipe's BlazePose and face networks, run with LiteRT.

MediaPipe's own pipeline finds one person. Here a person detector looks at the photo and tiles of it (`finder`; where
it is not available the pose and face detectors do, `detectors`), the landmark network looks at each find (`proposals`,
`search`, `landmarks`), sightings are scored (`score`, with the help of `faces`), the same person is kept once
(`duplicates`), and pupils come from the face networks (`eyes`).
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from types import MappingProxyType

import numpy as np

from ... import weights
from ...arrays import FloatArray
from ...errors import SettingsError
from ...people import People
from ...people.skeleton import BLAZEPOSE_33
from ...photo import Photo
from .. import PoseOptions
from ..detections import Detections
from .detectors import FACE_HEAD, POSE_HEAD, Detector
from .duplicates import agree, is_among
from .eyes import PupilFinder
from .faces import Face, face_of
from .finder import PersonFinder
from .landmarks import Candidate, Landmarks
from .proposals import Proposal, in_boxes, without_boxes
from .regions import Picture
from .score import (
    LIKELY,
    PERSON_MINIMUM,
    PERSON_MINIMUM_IN_BOX,
    SUPPORTED,
    WELL_SUPPORTED,
    person_score,
)  # fmt: skip
from .search import BOX_IS_BODY, EFFORTS, Search, Sighting

_POSE_DETECTION = "pose_detection.tflite"
#: Photos are decoded at no more than this: a torso of a tenth of the photo is then 240 px long, more than a crop holds.
_LONG_SIDE_PX = 2400
#: Scores from which the person detector's boxes are looked at: in the whole photo, and in tiles, of which each is one
#: more chance to be wrong.
_SUSPICION, _IN_TILES = 0.1, 0.2
# 37 people of the labelled photos, their headings put down by eye: 21 degrees rms, none turned front to back.
_HEADING_SD_RAD = 0.37
# Passes whose answers are more than 60 degrees apart give no heading.
_HEADING_AGREEMENT = math.cos(math.radians(30))


def open_backend(argument: str, options: PoseOptions) -> BlazePose:
    """Return the embedded back end; its networks are fetched at first use unless that is forbidden."""
    if argument:
        raise SettingsError(f"pose back end blazepose takes no argument, not {argument!r}")
    is_first_use = not all(map(weights.is_here, weights.EMBEDDED))
    located = weights.require(weights.EMBEDDED, may_fetch=True, offline=options.offline)
    finder = weights.if_to_be_had(weights.EMBEDDED_FINDER, offline=options.offline, may_fetch=is_first_use)
    if finder is not None:
        # it takes the place of the pose detection: what is not used is not among a result's networks
        located = {name: one for name, one in located.items() if name != _POSE_DETECTION}
        located[finder.model.name] = finder
    return BlazePose(
        {name: one.path for name, one in located.items()},
        effort=options.effort,
        threads=options.threads,
        hashes={name: one.sha256 for name, one in located.items()},
    )


class BlazePose:
    """The embedded back end. One instance a worker: the networks' buffers are its own."""

    name = "blazepose"
    skeleton = BLAZEPOSE_33

    def __init__(
        self, paths: Mapping[str, Path], *, effort: str = "normal", threads: int = 2, hashes: Mapping[str, str]
    ) -> None:
        self.effort = EFFORTS[effort]
        self.models: Mapping[str, str] = MappingProxyType(dict(hashes))
        finder = paths.get(weights.EMBEDDED_FINDER)
        self._finder = None if finder is None else PersonFinder(finder, threads)
        self._pose = Detector(paths[_POSE_DETECTION], POSE_HEAD, threads) if finder is None else None
        self._face = Detector(paths["face_detection_full_range_sparse.tflite"], FACE_HEAD, threads)
        self._landmarks = Landmarks(paths["pose_landmark_full.tflite"], threads)
        self._pupils = PupilFinder(paths["face_landmark.tflite"], paths["iris_landmark.tflite"])

    def detect(self, photo: Photo) -> People:
        """Return the people in a photo, best first; joints outside the photo are not seen."""
        picture = Picture(photo.pixels(_LONG_SIDE_PX))
        search = Search(picture, self._landmarks, self.effort.looks)
        boxes = self._boxes(picture)
        search.visit(self._proposals(picture) if boxes is None else in_boxes(boxes, picture))
        people = self._people(picture, search, boxes)
        return people.scaled(photo.width / picture.width, photo.height / picture.height)

    def _boxes(self, picture: Picture) -> Detections | None:
        if self._finder is None:
            return None
        return self._finder.find(
            picture, self.effort.tiles, suspicion=_SUSPICION, threshold=_IN_TILES, guided=not self.effort.everywhere
        )

    def _proposals(self, picture: Picture) -> list[Proposal]:
        assert self._pose is not None  # it is loaded where there is no person detector
        e = self.effort
        return without_boxes(
            picture, self._pose, self._face, e.pose_windows, e.face_windows, e.pose_minimum, e.face_minimum
        )

    def _people(self, picture: Picture, search: Search, boxes: Detections | None) -> People:
        faces = [face_of(sighting.candidate, picture, self._face) for sighting in search.sightings]
        for sighting, face in zip(search.sightings, faces, strict=True):
            sighting.face = 0.0 if face is None else face.score
        scores = np.array([person_score(sighting) for sighting in search.sightings])
        kept: list[Candidate] = []
        means: list[Candidate] = []
        free = None if boxes is None else replace(boxes, scores=boxes.scores.copy())
        rows: list[tuple[FloatArray, FloatArray, float, float, float]] = []
        for i in np.argsort(-scores, kind="stable"):
            sighting = search.sightings[i]
            box, support = (0, SUPPORTED) if free is None else _support(search, sighting, free)
            if scores[i] <= LIKELY or support < SUPPORTED or is_among(sighting.candidate, kept):
                continue
            pair = _seen_twice(search, sighting.candidate)
            if pair is None or (pair[0] is not sighting.candidate and is_among(pair[0], kept)):
                continue
            seen, again = pair
            # two looks' mean is steadier than either, and so is the answer whether that person was found before
            mean = replace(seen, keypoints_px=(seen.keypoints_px + again.keypoints_px) / 2)
            if any(agree(mean, other) for other in means):
                continue
            score = (float(scores[i]) + person_score(replace(sighting, candidate=again))) / 2
            if score > (PERSON_MINIMUM if support < WELL_SUPPORTED else PERSON_MINIMUM_IN_BOX):
                kept.append(seen)
                means.append(mean)
                if free is not None:
                    free.scores[box] = 0.0
                looks = [seen, again, *search.steadied(seen, self.effort.steadying)]
                rows.append((*self._joints(picture, looks, faces[i]), score, *_heading(looks)))
        if not rows:
            return People.none(BLAZEPOSE_33)
        keypoints, joint_scores, person_scores, headings, heading_sds = (np.array(c) for c in zip(*rows, strict=True))
        return People(
            BLAZEPOSE_33, keypoints, joint_scores, person_scores=person_scores, heading_rad=headings,
            heading_sd_rad=heading_sds, source=self.name,
        )  # fmt: skip

    def _joints(self, picture: Picture, looks: list[Candidate], face: Face | None) -> tuple[FloatArray, FloatArray]:
        """Return keypoints (33, 2) and scores (33,) of one person, the looks' means; NaN outside the picture."""
        keypoints = np.mean([look.keypoints_px for look in looks], axis=0)
        scores = np.mean([look.visibility * look.presence for look in looks], axis=0)
        pupils = None if face is None else self._pupils.find(picture, face.box_px, face.points_px)
        if pupils is not None:
            for joint, pupil in (("left_eye", pupils.left_px), ("right_eye", pupils.right_px)):
                keypoints[BLAZEPOSE_33.joints.index(joint)] = pupil
        outside = ((keypoints < 0) | (keypoints > (picture.width, picture.height))).any(axis=1)
        keypoints[outside], scores[outside] = np.nan, 0.0
        return keypoints, scores


def _seen_twice(search: Search, seen: Candidate) -> tuple[Candidate, Candidate] | None:
    """Return two looks that agree, of which one was shown the mirror image; None where there are none.

    What the network imagined it does not see twice. Its own flag that a person is there is one of the score's
    features, and one of the least informative. A third look is for where the network would rather have looked.
    """
    mirrored = search.again(seen, mirrored=True)
    if agree(seen, mirrored):
        return seen, mirrored
    third = search.again(mirrored, mirrored=False)
    return (mirrored, third) if agree(mirrored, third) else None


def _support(search: Search, sighting: Sighting, free: Detections) -> tuple[int, float]:
    """Return the row of the box that speaks most for this body, and how much: what they share times the box's score.

    A box is good for one person: those taken have the score 0. Nothing (row 0) where the body fills no box.
    """
    if not len(free):
        return 0, 0.0
    shared = search.shared(sighting, free.boxes_px)
    support = np.where(shared >= BOX_IS_BODY, shared * free.scores, 0.0)
    return int(support.argmax()), float(support.max())


def _heading(looks: list[Candidate]) -> tuple[float, float]:
    """Return the looks' mean heading and its standard deviation; NaN where they contradict each other."""
    mean = complex(np.mean([look.facing for look in looks]))
    if abs(mean) < _HEADING_AGREEMENT:
        return math.nan, math.nan
    spread = math.sqrt(-2 * math.log(min(abs(mean), 1.0)))
    return math.atan2(mean.imag, mean.real), math.hypot(_HEADING_SD_RAD, spread)
