"""What was measured on the floor: coordinates of marks, and distances between them."""

from __future__ import annotations

import math
from dataclasses import dataclass

from ...errors import SettingsError

#: Standard deviation of a taped distance unless stated, metres. Tapes of class II err by 2 mm at 10 m (Directive
#: 2014/32/EU, annex X); finding the middle of two marks and keeping the tape straight is what costs a centimetre.
TAPE_SD_M = 0.01
#: Standard deviation of a typed coordinate unless stated, metres: a mark on a grid of tiles, read to a centimetre.
SPOT_SD_M = 0.01
#: What a tape can be used for, and a coordinate be: beyond it units were mixed up.
SHORTEST_M, LONGEST_M, FARTHEST_M = 0.01, 1000.0, 10_000.0
#: Marks of one shoot: more than anyone tapes, and few enough to solve while the user waits.
MOST_TAGS = 40


def _need(condition: bool, text: str) -> None:
    if not condition:
        raise SettingsError(text)


@dataclass(frozen=True)
class Tape:
    """A distance taped between two marks, with its standard deviation, metres; SettingsError for what is none."""

    a: str
    b: str
    metres: float
    sd_m: float = TAPE_SD_M

    def __post_init__(self) -> None:
        name = f"{self.a} to {self.b}"
        _need(self.a != self.b, f"{name}: a distance is taped between two marks")
        _need(
            math.isfinite(self.metres) and SHORTEST_M <= self.metres <= LONGEST_M,
            f"{name}: {self.metres:g} m; a taped distance is {SHORTEST_M:g} to {LONGEST_M:g} metres",
        )
        _need(math.isfinite(self.sd_m) and 0.0005 <= self.sd_m <= 1, f"{name}: its uncertainty is 0.0005 to 1 m")

    @property
    def ends(self) -> frozenset[str]:
        """The two marks, in no order."""
        return frozenset((self.a, self.b))

    def __str__(self) -> str:
        return f"{self.a}–{self.b}"


@dataclass(frozen=True)
class Spot:
    """A mark whose coordinates are known, with their standard deviation, metres; SettingsError for what is none."""

    tag: str
    x_m: float
    y_m: float
    sd_m: float = SPOT_SD_M

    def __post_init__(self) -> None:
        for axis, value in (("x", self.x_m), ("y", self.y_m)):
            _need(
                math.isfinite(value) and abs(value) <= FARTHEST_M,
                f"{self.tag}: {axis} is {value:g} m; a coordinate is within {FARTHEST_M:g} metres",
            )
        _need(math.isfinite(self.sd_m) and 0.0005 <= self.sd_m <= 1, f"{self.tag}: its uncertainty is 0.0005 to 1 m")

    def __str__(self) -> str:
        return f"the coordinates of {self.tag}"


Measurement = Tape | Spot
