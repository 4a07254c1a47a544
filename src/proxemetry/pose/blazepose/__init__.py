"""The embedded pose back end: several people a photo from MediaPipe's BlazePose and face networks, run with LiteRT.

MediaPipe's own pipeline finds one person. Here windows of several sizes are searched for bodies and faces
(`detectors`), each find is looked at by the landmark network (`search`, `landmarks`), sightings are scored
(`score`), the same person is kept once (`duplicates`), and pupils come from the face networks (`eyes`).
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from ... import weights
from ...errors import SettingsError
from ...people import People
from ...photo import Photo
from ...skeleton import BLAZEPOSE_33
from .. import PoseOptions
from .detectors import FACE_HEAD, POSE_HEAD, Boxes, Detector
from .duplicates import agree, without_duplicates
from .eyes import PupilFinder
from .landmarks import Candidate, Landmarks
from .regions import Picture
from .score import LIKELY, PERSON_MINIMUM, face_of, head_px, person_score
from .search import EFFORTS, Search, Sighting, neighbours, proposals, small_faces

FloatArray = NDArray[np.float64]

#: Photos are decoded at no more than this: a torso of a tenth of the photo is then 240 px long, more than a crop holds.
_LONG_SIDE_PX = 2400
#: Who is at least this sure has neighbours looked for, and says at which level heads are.
_SURE = 0.7
# 37 people of the labelled photos, their headings put down by eye: 21 degrees rms, none turned front to back.
_HEADING_SD_RAD = 0.37
# Looks more than 60 degrees apart say nothing.
_HEADING_AGREEMENT = math.cos(math.radians(30))


def open_backend(argument: str, options: PoseOptions) -> BlazePose:
    """Return the embedded back end; its networks are fetched at first use unless that is forbidden."""
    if argument:
        raise SettingsError(f"pose back end blazepose takes no argument, not {argument!r}")
    located = weights.require(weights.EMBEDDED, may_fetch=True, offline=options.offline)
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
        self._pose = Detector(paths["pose_detection.tflite"], POSE_HEAD, threads)
        self._face = Detector(paths["face_detection_full_range_sparse.tflite"], FACE_HEAD, threads)
        self._landmarks = Landmarks(paths["pose_landmark_full.tflite"], threads)
        self._pupils = PupilFinder(paths["face_landmark.tflite"], paths["iris_landmark.tflite"])

    def detect(self, photo: Photo) -> People:
        """Return the people in a photo, best first; joints outside the photo are not seen."""
        pixels = photo.pixels(_LONG_SIDE_PX)
        picture = Picture(pixels)
        found, faces = proposals(picture, self._pose, self._face, self.effort)
        search = Search(picture, self._landmarks, self.effort.looks)
        kept_back = self.effort.looks // 4 if self.effort.neighbours else 0
        search.visit(found, 2 * kept_back if self.effort.small_faces[1] else kept_back)
        if self.effort.small_faces[1]:
            heads = np.array([head_px(s.candidate) for s in _sure(search, faces)]).reshape(-1, 2)
            found, faces = small_faces(picture, self._face, self.effort, heads, faces)
            search.visit(found, kept_back)
        if self.effort.neighbours:
            search.visit(neighbours(_sure(search, faces)))
        people = self._people(picture, search, faces)
        return people.scaled(photo.width / picture.width, photo.height / picture.height)

    def _people(self, picture: Picture, search: Search, faces: Boxes) -> People:
        scores = np.array([_scored(s, faces) for s in search.sightings])
        likely = np.flatnonzero(scores > LIKELY)
        kept = likely[without_duplicates([search.sightings[i].candidate for i in likely], scores[likely])]
        rows: list[tuple[FloatArray, FloatArray, float, float, float]] = []
        for i in kept:
            sighting = search.sightings[i]
            mirrored = search.again(sighting)
            # Shown the mirror image, the network must see the same person: what it imagined it does not see twice. Its
            # own word that somebody is there is one of the score's features, and one of the least telling.
            if not agree(sighting.candidate, mirrored):
                continue
            score = (float(scores[i]) + person_score(replace(sighting, candidate=mirrored))) / 2
            if score > PERSON_MINIMUM:
                looks = [sighting.candidate, mirrored, *search.steadied(sighting, self.effort.steadying)]
                rows.append((*self._joints(picture, sighting, looks, faces), score, *_heading(looks)))
        if not rows:
            return People.none(BLAZEPOSE_33)
        keypoints, joint_scores, person_scores, headings, heading_sds = (np.array(c) for c in zip(*rows, strict=True))
        return People(
            BLAZEPOSE_33, keypoints, joint_scores, person_scores=person_scores, heading_rad=headings,
            heading_sd_rad=heading_sds,
        )  # fmt: skip

    def _joints(
        self, picture: Picture, sighting: Sighting, looks: list[Candidate], faces: Boxes
    ) -> tuple[FloatArray, FloatArray]:
        """Return keypoints (33, 2) and scores (33,) of one person, the looks' means; NaN outside the picture."""
        keypoints = np.mean([look.keypoints_px for look in looks], axis=0)
        scores = np.mean([look.visibility * look.presence for look in looks], axis=0)
        face = face_of(sighting, faces)
        pupils = None if face is None else self._pupils.find(picture, faces.boxes_px[face], faces.points_px[face])
        if pupils is not None:
            for joint, pupil in (("left_eye", pupils.left_px), ("right_eye", pupils.right_px)):
                keypoints[BLAZEPOSE_33.joints.index(joint)] = pupil
        outside = ((keypoints < 0) | (keypoints > (picture.width, picture.height))).any(axis=1)
        keypoints[outside], scores[outside] = np.nan, 0.0
        return keypoints, scores


def _sure(search: Search, faces: Boxes) -> list[Sighting]:
    return [sighting for sighting in search.sightings if _scored(sighting, faces) > _SURE]


def _scored(sighting: Sighting, faces: Boxes) -> float:
    face = face_of(sighting, faces)
    sighting.face = 0.0 if face is None else float(faces.scores[face])
    return person_score(sighting)


def _heading(looks: list[Candidate]) -> tuple[float, float]:
    """Return the looks' mean heading and its standard deviation; NaN where they contradict each other."""
    mean = complex(np.mean([look.facing for look in looks]))
    if abs(mean) < _HEADING_AGREEMENT:
        return math.nan, math.nan
    spread = math.sqrt(-2 * math.log(min(abs(mean), 1.0)))
    return math.atan2(mean.imag, mean.real), math.hypot(_HEADING_SD_RAD, spread)
