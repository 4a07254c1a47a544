"""Known mistakes in the published KORTE labels, as data (`korte_errata.csv`).

Each row names an annotated point that stands under the wrong person's tag, and whose it is: re-projecting the
measured positions through each photo's camera shows both. Five people exist by such a row alone.
"""

from __future__ import annotations

import csv
import functools
from dataclasses import dataclass
from importlib.resources import files


@dataclass(frozen=True)
class Erratum:
    """The point (x, y) of `part` in photo `filename` is labelled `tag` but belongs to `belongs_to`."""

    filename: str
    tag: str
    part: str
    x: float
    y: float
    belongs_to: str

    def concerns(self, tag: str, part: str, x: float, y: float) -> bool:
        """Whether an annotated point of this photo is the wrong one."""
        return (tag, part, x, y) == (self.tag, self.part, self.x, self.y)


@functools.cache
def load_errata() -> tuple[Erratum, ...]:
    """Return the errata that ship with the package."""
    text = (files("proxemetry.benchmark") / "korte_errata.csv").read_text(encoding="utf-8")
    return tuple(
        Erratum(row["filename"], row["tag"], row["part"], float(row["x"]), float(row["y"]), row["belongs_to"])
        for row in csv.DictReader(text.splitlines())
    )
