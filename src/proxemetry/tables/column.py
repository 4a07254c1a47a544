"""A column of a results table: its name, type, unit and meaning, and how its value is read off a scene."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from ..intervals import LEVEL

Value = str | int | float | bool | None


@dataclass(frozen=True)
class Column:
    """One column: its name, SQL type, unit ("" where it has none), meaning, and its value for a row of a scene.

    `value` takes (scene) for photos, (scene, person) for people and (scene, a, b) for pairs; the log has none.
    levels: the texts that a categorical column takes; ordered where they have an order. identifies: a number that names
    something and is not to be averaged.
    """

    name: str
    kind: str
    unit: str
    meaning: str
    value: Callable[..., Value] = lambda *_: None
    levels: tuple[str, ...] = ()
    ordered: bool = False
    identifies: bool = False


#: The level of every interval, as the columns' meanings name it.
LEVEL_TEXT = f"{LEVEL:.0%}".replace("%", " %")
