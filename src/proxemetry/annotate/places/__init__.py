"""Where people and cameras were, from typed coordinates and taped distances: plane geometry, no photo."""

from .measurements import MOST_TAGS, SPOT_SD_M, TAPE_SD_M, Spot, Tape
from .solution import Places, solve
from .wording import remarks_on

__all__ = ["MOST_TAGS", "SPOT_SD_M", "TAPE_SD_M", "Places", "Spot", "Tape", "remarks_on", "solve"]
