"""Which tables a results folder has, with their columns, and the rows of one scene in each."""

from __future__ import annotations

import math
from typing import Any

from ..scene import Scene
from .column import Column, Value
from .pair_columns import PAIRS
from .people_columns import PEOPLE
from .photo_columns import PHOTOS, safe_distance_columns

#: Table -> its columns, in order.
TABLES: dict[str, tuple[Column, ...]] = {"photos": PHOTOS, "people": PEOPLE, "pairs": PAIRS}


def rows(table: str, scene: Scene) -> list[dict[str, Value]]:
    """Return the rows of one scene in the table "photos", "people" or "pairs"."""
    if table == "photos":
        keys: list[tuple[int, ...]] = [()]
    elif table == "people":
        keys = [(i,) for i in range(len(scene))]
    else:
        keys = list(scene.distances.pairs())
    return [{c.name: _clean(c.value(scene, *key)) for c in TABLES[table]} for key in keys]


def _clean(value: Any) -> Value:
    if isinstance(value, float):
        value = float(value)
        return float(f"{value:.7g}") if math.isfinite(value) else None
    return value


def all_columns() -> dict[str, tuple[Column, ...]]:
    """Return every table's columns, those of the safe distance with the photos'."""
    return {**TABLES, "photos": (*TABLES["photos"], *safe_distance_columns(None))}
