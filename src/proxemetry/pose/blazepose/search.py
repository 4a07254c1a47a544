"""From squares worth a look to sightings of people, within a budget of looks."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, field, replace

import numpy as np

from ...arrays import FloatArray
from ...overlap import iou
from .duplicates import extent_px, similarity
from .landmarks import Candidate, Landmarks
from .proposals import Proposal, Windows
from .regions import Picture, Region

# Below this a first pass finds no person (MediaPipe drops at 0.5), and there is no second one. Above it the score of
# the second pass decides: between two passes over one person the flag varies from 0 to 1.
_FLAG_MINIMUM = 0.2
# MediaPipe's own threshold: below it another square is tried too.
_FLAG_SURE = 0.5
# Keypoint similarity from which two first looks are the same person: COCO's strict threshold.
_SAME_PERSON = 0.75
#: A box and a body are one person's where they share this much (intersection over union).
BOX_IS_BODY = 1 / 3
# A box that shares this much with a body that was found needs no look.
_EXPLAINED = 0.6
# Shifts within which the network's own answer moves from look to look (its torso repeats within 2.4 %).
_JITTER = ((0.03, 0.02, 1.05), (-0.03, -0.02, 1.05), (0.02, -0.03, 0.95), (-0.02, 0.03, 0.95))


@dataclass(frozen=True)
class Effort:
    """How long to look.

    tiles: fractions of the photo's longer side of the tiles that the person detector sees besides the whole photo;
    everywhere: whether they cover the photo, or lie only around people suspected in the whole photo. pose_windows,
    face_windows, pose_minimum, face_minimum: what takes the place of the person detector where it is not available:
    windows as (fraction of the longer side, overlap), and thresholds. looks: the budget. steadying: further looks at
    each person, to average over.
    """

    tiles: tuple[float, ...]
    pose_windows: Windows
    face_windows: Windows
    pose_minimum: float
    face_minimum: float
    looks: int
    everywhere: bool = False
    steadying: int = 0


EFFORTS = {
    "fast": Effort((), ((1.0, 0.5), (0.5, 0.5)), ((1.0, 0.25), (0.4, 0.25)), 0.2, 0.4, 24),
    "normal": Effort(
        (0.6,), ((1.0, 0.5), (0.5, 0.5)), ((1.0, 0.25), (0.5, 0.25), (0.3, 0.25)), 0.1, 0.3, 60,
    ),
    "thorough": Effort(
        (0.6,), ((1.0, 0.5), (0.6, 0.5), (0.4, 0.5), (0.25, 0.3)),
        ((1.0, 0.25), (0.5, 0.25), (0.3, 0.25), (0.2, 0.25), (0.13, 0.25)), 0.1, 0.3, 400, everywhere=True,
        steadying=4,
    ),
}  # fmt: skip


@dataclass(eq=False)
class Sighting:
    """A candidate with what led to it.

    first_flag: the flag of the first pass. detection: the best score of the detections that led here. face: the score
    of a face where the head is, 0 for none. looked_at: the squares of the first looks that ended here.
    """

    candidate: Candidate
    first_flag: float
    detection: float
    face: float = 0.0
    looked_at: list[Region] = field(default_factory=list[Region])


class Search:
    """Looks at squares of one picture, keeps what the network takes for people, and spends no more than the budget."""

    def __init__(self, picture: Picture, landmarks: Landmarks, looks: int) -> None:
        self._picture, self._landmarks = picture, landmarks
        self.looks_left = looks
        self.sightings: list[Sighting] = []

    def visit(self, found: Iterable[Proposal]) -> None:
        """Look at the squares of each proposal, then where the network would rather look, and keep what it sees.

        A proposal's later squares are for where the first shows no person, or one who does not fill its box.
        """
        for proposal in found:
            known = next((s for s in self.sightings if self._explains(s, proposal)), None)
            if known is not None:
                known.detection = max(known.detection, proposal.score)
                continue
            for square in proposal.squares:
                if self.looks_left < 2:
                    return
                seen = self._visit(square, proposal)
                if seen is not None and seen.first_flag >= _FLAG_SURE and self._fills(seen, proposal, BOX_IS_BODY):
                    break

    def _visit(self, square: Region, proposal: Proposal) -> Sighting | None:
        first = self._look(square, quick=True)
        if first.flag < _FLAG_MINIMUM:
            return None
        known = next((s for s in self.sightings if _shows(first, s)), None)
        if known is not None:
            known.detection = max(known.detection, proposal.score)
            known.looked_at.append(square)
            return known
        second = self._look(first.next_region)
        seen = Sighting(second, first.flag, proposal.score, looked_at=[square])
        self.sightings.append(seen)
        return seen

    def _explains(self, sighting: Sighting, proposal: Proposal) -> bool:
        """Return whether a proposal shows a person who was found, or a square that was searched."""
        if proposal.box_px is not None:
            return self._fills(sighting, proposal, _EXPLAINED)
        return any(_near(r, proposal.squares[0]) for r in (sighting.candidate.region, *sighting.looked_at))

    def _fills(self, sighting: Sighting, proposal: Proposal, least: float) -> bool:
        return proposal.box_px is None or float(self.shared(sighting, proposal.box_px[None])[0]) >= least

    def shared(self, sighting: Sighting, boxes_px: FloatArray) -> FloatArray:
        """Return how much a body shares with each box (N, 4), shape (N,), 0..1; only inside the picture."""
        limits = np.array([self._picture.width, self._picture.height] * 2, dtype=float)
        return iou(extent_px(sighting.candidate).clip(0, limits), boxes_px)

    def again(self, seen: Candidate, *, mirrored: bool) -> Candidate:
        """Look once more where the network would look next, at the mirror image or not; not counted in the budget.

        The silhouette stays that of the look before.
        """
        look = self._landmarks.look(self._picture, seen.next_region, mirrored=mirrored, quick=True)
        return replace(look, mask=seen.mask)

    def steadied(self, seen: Candidate, looks: int) -> list[Candidate]:
        """Return further passes over a person, each a little aside and every other one mirrored; not counted either."""
        region = seen.next_region
        shifted = [region.moved(right, down, grown) for right, down, grown in _JITTER[:looks]]
        return [self._landmarks.look(self._picture, r, mirrored=k % 2 == 1, quick=True) for k, r in enumerate(shifted)]

    def _look(self, region: Region, *, quick: bool = False) -> Candidate:
        self.looks_left -= 1
        return self._landmarks.look(self._picture, region, quick=quick)


def _near(known: Region, new: Region) -> bool:
    near = math.hypot(known.x - new.x, known.y - new.y) < 0.1 * known.size
    return near and abs(math.log(known.size / new.size)) < 0.2


def _shows(first: Candidate, known: Sighting) -> bool:
    """Return whether a first pass shows a person who was found already: a second would end where that one did."""
    ends_there = first.next_region.resembles(known.candidate.region)
    return ends_there or similarity(first, known.candidate) > _SAME_PERSON
