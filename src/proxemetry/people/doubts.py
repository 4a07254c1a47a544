"""Which reported people may not be people, or may be one found twice: the reasons, each from what was seen.

No one is dropped. What is marked is for the user to check; rules and thresholds are measured by
`benchmarks/networks/doubtful.py`.
"""

from __future__ import annotations

from collections.abc import Sequence
from enum import StrEnum

import numpy as np
from numpy.typing import NDArray

from ..arrays import FloatArray
from .duplicates import possible_duplicates
from .people import People


class PersonDoubt(StrEnum):
    """Why a detection may not be a person in the photo; `MOTIONLESS` needs a clip."""

    POSSIBLE_DUPLICATE = "possible_duplicate"
    OTHER_CLASS = "other_class"
    NO_UPPER_BODY = "no_upper_body"
    IN_PICTURE = "in_picture"
    MOTIONLESS = "motionless"

    @property
    def words(self) -> str:
        """The same to be read."""
        return _WORDS[self]


_WORDS = {
    PersonDoubt.POSSIBLE_DUPLICATE: "may be another person found twice",
    PersonDoubt.OTHER_CLASS: "may be another kind of thing",
    PersonDoubt.NO_UPPER_BODY: "legs without a body above",
    PersonDoubt.IN_PICTURE: "may be on a screen or in a picture",
    PersonDoubt.MOTIONLESS: "never moves",
}
#: The reasons that a single photo or frame can give.
OF_PHOTOS = tuple(doubt for doubt in PersonDoubt if doubt is not PersonDoubt.MOTIONLESS)


#: A thing that scores at least this part of the person's score in the same place makes a person doubtful, by back end;
#: of other back ends one that scores as much as the person does.
LEAST_RIVALS = {"yolox-tinypose": 0.2}
#: The same of things that show people and hold the person, by back end; of others half of the person's score.
LEAST_SCREENS = {"yolox-tinypose": 0.1}
#: Legs without a body above: the joints of head and shoulders score this part of those from the hips down, or less.
MOST_UPPER = 0.2
#: And the hips lie within this part of the box's height from its top: lower down, the detector saw a body above them
#: whose joints the other network missed. Legs behind a wall (`benchmarks/networks/doubtful.py`, yolox-tinypose and
#: nanodet-movenet) have them at -0.02 to 0.17, people seen whole of whom only legs were found at 0.38 and 0.45.
MOST_ABOVE_HIPS = 0.28
_UPPER = ("nose", "left_eye", "right_eye", "left_ear", "right_ear", "left_shoulder", "right_shoulder")
_LOWER = ("left_hip", "right_hip", "left_knee", "right_knee", "left_ankle", "right_ankle")
#: A box this near to the photo's upper edge, of its height, may be cut by it: what is above is not missing.
_AT_EDGE = 0.02


def doubts_of(people: People) -> tuple[tuple[PersonDoubt, ...], ...]:
    """Return the reasons of each person, in the order of `PersonDoubt`; none for most."""
    found = {
        PersonDoubt.POSSIBLE_DUPLICATE: possible_duplicates(people),
        PersonDoubt.OTHER_CLASS: _rivalled(people, False) >= LEAST_RIVALS.get(people.source, 1.0),
        PersonDoubt.NO_UPPER_BODY: _no_upper_body(people),
        PersonDoubt.IN_PICTURE: _in_picture(people),
    }
    return tuple(tuple(doubt for doubt, rows in found.items() if rows[i]) for i in range(len(people)))


def in_words(people: People, person: int, reasons: Sequence[PersonDoubt]) -> str:
    """Return a person's doubts to be read; what else the detector sees is named."""
    rival = people.rivals[person]
    told_by = None if rival is None else PersonDoubt.IN_PICTURE if rival.shows else PersonDoubt.OTHER_CLASS
    named = "" if rival is None else f" ({rival.name})"
    return ", ".join(doubt.words + (named if doubt is told_by else "") for doubt in reasons)


def _rivalled(people: People, shows: bool) -> FloatArray:
    """Return the ratios of the rivals of one sort, those that show people or those in their place, 0 without, (P,)."""
    return np.array([r.ratio if r is not None and r.shows is shows else 0.0 for r in people.rivals], dtype=float)


def _in_picture(people: People) -> NDArray[np.bool_]:
    """Return who is inside a thing that shows people, or framed by straight edges, shape (P,)."""
    return (_rivalled(people, True) >= LEAST_SCREENS.get(people.source, 0.5)) | np.array(people.framed, dtype=bool)


def _no_upper_body(people: People) -> NDArray[np.bool_]:
    """Return which people show only legs although the photo continues above them, shape (P,).

    Where a skeleton has no such joints, or none of its legs is seen, nothing is missing; neither is it where the box
    has room for a body above the hips.
    """
    upper, lower = (np.mean([people.joint_score(joint) for joint in joints], axis=0) for joints in (_UPPER, _LOWER))
    low, high = people.boxes_px[:, 1], people.boxes_px[:, 3]
    cut_above = ~(low > _AT_EDGE * (high - low))
    hips = np.fmin(people.joint("left_hip")[:, 1], people.joint("right_hip")[:, 1])
    room_above = hips - low > MOST_ABOVE_HIPS * (high - low)
    return (lower > 0) & (upper <= MOST_UPPER * lower) & ~cut_above & ~room_above
