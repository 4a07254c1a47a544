"""Other things that a detector sees in a person's box."""

from __future__ import annotations

import math
from dataclasses import dataclass

from ..errors import KeypointsError


@dataclass(frozen=True)
class Rival:
    """Another class of things that a detector sees in the same place as a person: an animal, a kite, a picture.

    name: of the class. ratio: its score over the person's; above 1 the detector takes it for that rather than for a
    person. shows: the person lies inside of it, as on a screen or in a frame, which detectors take for a screen.
    Raises KeypointsError where the ratio is no number from 0.
    """

    name: str
    ratio: float
    shows: bool = False

    def __post_init__(self) -> None:
        if not (math.isfinite(self.ratio) and self.ratio >= 0):
            raise KeypointsError(f"the ratio of a rival's score to a person's is a number from 0, not {self.ratio!r}")
