"""From detections to candidates: which squares of the photo the landmark network looks at, within a budget.

The network does not care much where exactly its square lies: it says where the person really is, and is asked once
more there. So a face, a pose detection and a neighbour's square all serve as a first look.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from .detectors import Boxes, Detector, joined, mean_of_groups, merged, windows_near, windows_of
from .duplicates import similarity
from .landmarks import Candidate, Landmarks
from .regions import Picture, Region

FloatArray = NDArray[np.float64]

# MediaPipe's own rule: the square's side is 1.25 times the diameter of the circle around the body.
_BODY_FACTOR = 1.25
# A face's box is about 1/4.3 of the way from hips to the circle's edge above the head (METHOD section 4: face height
# .12 of a stature of 1.7 m; hips .9 m below the crown); the same figure as in the measured prototype.
_HIPS_BELOW_FACE, _RADIUS_IN_FACES = 3.3, 4.3
# Below this a first look says that nobody is there (MediaPipe drops at 0.5), and there is no second one. Once it said
# that somebody is, the score of the second look decides: the flag wavers between two looks at one person from 0 to 1.
_FLAG_MINIMUM = 0.2
# A neighbour's square lies this far aside: people next to each other stand about a shoulder's breadth (a fifth of the
# square) to an arm's length apart.
_ASIDE = 0.4
# Keypoint similarity from which two first looks are the same person: COCO's strict threshold.
_SAME_PERSON = 0.75
_FACE_OVERLAP = 0.25
# Shifts within which the network's own answer moves from look to look (its torso repeats within 2.4 %).
_JITTER = ((0.03, 0.02, 1.05), (-0.03, -0.02, 1.05), (0.02, -0.03, 0.95), (-0.02, 0.03, 0.95))


@dataclass(frozen=True)
class Effort:
    """How long to look: windows as (fraction of the long side, overlap), thresholds, and the budget of looks.

    small_faces: fractions of the windows that are searched for faces of the size of those found so far or smaller,
    and how many of them there may be: those nearest to the level where heads were found. neighbours: whether squares
    beside people are tried. steadying: further looks at each person, to average over.
    """

    pose_windows: tuple[tuple[float, float], ...]
    face_windows: tuple[tuple[float, float], ...]
    pose_minimum: float
    face_minimum: float
    neighbours: bool
    looks: int
    small_faces: tuple[tuple[float, ...], int] = ((), 0)
    steadying: int = 0


EFFORTS = {
    "fast": Effort(((1.0, 0.5), (0.5, 0.5)), ((1.0, 0.25), (0.4, 0.25)), 0.2, 0.4, False, 24),
    "normal": Effort(
        ((1.0, 0.5), (0.5, 0.5)), ((1.0, 0.25), (0.5, 0.25), (0.3, 0.25)), 0.1, 0.3, True, 90,
        small_faces=((0.2, 0.13), 40),
    ),
    "thorough": Effort(
        ((1.0, 0.5), (0.6, 0.5), (0.4, 0.5), (0.25, 0.3)),
        ((1.0, 0.25), (0.5, 0.25), (0.3, 0.25), (0.2, 0.25), (0.13, 0.25)), 0.1, 0.3, True, 400,
        steadying=4,
    ),
}  # fmt: skip


@dataclass(eq=False)
class Sighting:
    """A candidate with what led to it.

    first_flag: what the first look said. detection: the best score of the detections that led here, 0 for none.
    votes: how many first looks ended here. face: the score of a detected face where the head is, 0 for none.
    looked_at: the squares of the first looks that ended here.
    """

    candidate: Candidate
    first_flag: float
    detection: float
    votes: int = 1
    face: float = 0.0
    sources: set[str] = field(default_factory=set[str])
    looked_at: list[Region] = field(default_factory=list[Region])


@dataclass(frozen=True)
class Proposal:
    """A square worth a first look, the detector's score, and who proposed it."""

    region: Region
    score: float
    source: str


def proposals(picture: Picture, pose: Detector, face: Detector, effort: Effort) -> tuple[list[Proposal], Boxes]:
    """Return squares worth a look, best first, and the faces."""
    bodies = pose.find(picture, _windows(picture, effort.pose_windows), effort.pose_minimum)
    faces = merged(face.find(picture, _windows(picture, effort.face_windows), effort.face_minimum))
    bodies = mean_of_groups(bodies, _same_bodies(bodies))
    found = [
        Proposal(Region.around(p[0], p[1], _BODY_FACTOR), float(s), "pose")
        for p, s in zip(bodies.points_px, bodies.scores, strict=True)
    ]
    return sorted([*found, *_below_faces(faces)], key=lambda p: -p.score), faces


def small_faces(
    picture: Picture, face: Detector, effort: Effort, heads_px: FloatArray, faces: Boxes
) -> tuple[list[Proposal], Boxes]:
    """Return squares under smaller faces than were seen before, best first, and all faces, those before among them.

    heads_px: where people were found, shape (N, 2). Who stands far away has the head near the horizon, and in photos
    taken by somebody who stands everybody has: so it is at the level of the heads that small faces are looked for
    first. Where nobody was found yet, it is at half the photo's height and in the largest of the windows alone: the
    smallest then find faces in stone and foliage before they find any of people.
    """
    fractions, most = effort.small_faces
    levels = (heads_px[:, 1].min(), heads_px[:, 1].max()) if len(heads_px) else (picture.height / 2,) * 2
    fractions = fractions if len(heads_px) else fractions[:1]
    windows = windows_near(picture.width, picture.height, fractions, _FACE_OVERLAP, levels, most)
    new = merged(face.find(picture, windows, effort.face_minimum))
    return sorted(_below_faces(new), key=lambda p: -p.score), merged(joined([faces, new]))


def _below_faces(faces: Boxes) -> list[Proposal]:
    return [
        Proposal(_below_face(box), float(score), "face")
        for box, score in zip(faces.boxes_px, faces.scores, strict=True)
    ]


class Search:
    """Looks at squares of one picture, keeps what the network takes for people, and spends no more than the budget."""

    def __init__(self, picture: Picture, landmarks: Landmarks, looks: int) -> None:
        self._picture, self._landmarks = picture, landmarks
        self.looks_left = looks
        self.sightings: list[Sighting] = []

    def visit(self, found: Iterable[Proposal], kept_back: int = 0) -> list[Sighting]:
        """Look at each square, then where the network would rather look; return the sightings that are new.

        `kept_back` looks of the budget are left for later.
        """
        new: list[Sighting] = []
        for proposal in found:
            if self.looks_left < max(2, kept_back):
                break
            known = next((s for s in self.sightings if _explains(s, proposal)), None)
            if known is not None:
                _vote(known, proposal)
                continue
            first = self._look(proposal.region, quick=True)
            if first.flag < _FLAG_MINIMUM:
                continue
            known = next((s for s in self.sightings if _shows(first, s)), None)
            if known is not None:
                _vote(known, proposal)
                known.looked_at.append(proposal.region)
                continue
            second = self._look(first.next_region)
            detection = proposal.score if proposal.source != "neighbour" else 0.0
            new.append(Sighting(second, first.flag, detection, sources={proposal.source}, looked_at=[proposal.region]))
            self.sightings.append(new[-1])
        return new

    def again(self, sighting: Sighting) -> Candidate:
        """Look once more where the network would look next, at the mirror image; not counted in the budget.

        The silhouette stays that of the look before.
        """
        seen = sighting.candidate
        mirrored = self._landmarks.look(self._picture, seen.next_region, mirrored=True, quick=True)
        return replace(mirrored, mask=seen.mask)

    def steadied(self, sighting: Sighting, looks: int) -> list[Candidate]:
        """Return further looks at somebody, each a little aside and every other one mirrored; not counted either."""
        region = sighting.candidate.next_region
        shifted = [region.moved(right, down, grown) for right, down, grown in _JITTER[:looks]]
        return [self._landmarks.look(self._picture, r, mirrored=k % 2 == 1, quick=True) for k, r in enumerate(shifted)]

    def _look(self, region: Region, *, quick: bool = False) -> Candidate:
        self.looks_left -= 1
        return self._landmarks.look(self._picture, region, quick=quick)


def neighbours(sightings: Iterable[Sighting]) -> list[Proposal]:
    """Return squares beside people who were found: who is hidden from the detectors often stands by others."""
    return [
        Proposal(Region(*_aside(s.candidate.next_region, side)), 0.0, "neighbour")
        for s in sightings
        for side in (-_ASIDE, _ASIDE)
    ]


def _aside(region: Region, side: float) -> tuple[float, float, float]:
    moved = region.moved(side, 0.0)
    return moved.x, moved.y, moved.size  # upright, whatever the neighbour's posture


def _windows(picture: Picture, sizes: tuple[tuple[float, float], ...]) -> list[tuple[int, int, int, int]]:
    return [w for fraction, overlap in sizes for w in windows_of(picture.width, picture.height, fraction, overlap)]


def _below_face(box: FloatArray) -> Region:
    """Return the body's square under a face: hips 3.3 face heights below it, upright."""
    centre, height = (box[:2] + box[2:]) / 2, float((box[2:] - box[:2]).max())
    hips = centre + (0.0, _HIPS_BELOW_FACE * height)
    return Region.around(hips, hips - (0.0, _RADIUS_IN_FACES * height), _BODY_FACTOR)


def _same_bodies(bodies: Boxes) -> list[NDArray[np.intp]]:
    """Return rows of detections that are one body seen in several windows: hips, head and size agree."""
    hips = bodies.points_px[:, 0]
    radius = np.linalg.norm(bodies.points_px[:, 1] - hips, axis=1) + 1e-6
    order = np.argsort(-bodies.scores, kind="stable")
    groups: list[NDArray[np.intp]] = []
    while len(order):
        best = order[0]
        same = (
            (np.linalg.norm(hips[order] - hips[best], axis=1) < 0.35 * radius[best])
            & (np.linalg.norm(bodies.centres_px[order] - bodies.centres_px[best], axis=1) < 0.25 * radius[best])
            & (np.abs(np.log(radius[order] / radius[best])) < 0.4)
        )
        same[0] = True
        groups.append(order[same])
        order = order[~same]
    return groups


def _explains(sighting: Sighting, proposal: Proposal) -> bool:
    """Return whether a proposal is so near where a sighting was found, or looked for, that it shows the same person."""
    return any(_near(region, proposal.region) for region in (sighting.candidate.region, *sighting.looked_at))


def _near(known: Region, new: Region) -> bool:
    near = math.hypot(known.x - new.x, known.y - new.y) < 0.1 * known.size
    return near and abs(math.log(known.size / new.size)) < 0.2


def _shows(first: Candidate, known: Sighting) -> bool:
    """Return whether a first look shows somebody who was found already: a second would end where that one did."""
    ends_there = first.next_region.resembles(known.candidate.region)
    return ends_there or similarity(first, known.candidate) > _SAME_PERSON


def _vote(sighting: Sighting, proposal: Proposal) -> None:
    sighting.votes += 1
    sighting.sources.add(proposal.source)
    if proposal.source != "neighbour":
        sighting.detection = max(sighting.detection, proposal.score)
