"""Which tables a results folder has, with their columns, and the rows of one scene in each."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from ..scene import Scene
from .attribute_columns import attribute_columns
from .column import Column, Value
from .pair_columns import PAIRS
from .people_columns import PEOPLE
from .photo_columns import PHOTOS, safe_distance_columns

#: Table -> its columns, in order.
TABLES: dict[str, tuple[Column, ...]] = {"photos": PHOTOS, "people": PEOPLE, "pairs": PAIRS}


def rows(table: str, scene: Scene, attributes: Sequence[str] = ()) -> list[dict[str, Value]]:
    """Return the rows of one scene in the table "photos", "people" or "pairs"; attributes: those that are columns."""
    if table == "photos":
        keys: list[tuple[int, ...]] = [()]
    elif table == "people":
        keys = [(i,) for i in range(len(scene))]
    else:
        keys = list(scene.distances.pairs())
    columns = (*TABLES[table], *attribute_columns(table, attributes))
    return [{c.name: _clean(c.value(scene, *key)) for c in columns} for key in keys]


def _clean(value: Any) -> Value:
    if isinstance(value, float):
        value = float(value)
        return float(f"{value:.7g}") if math.isfinite(value) else None
    return value


def all_columns(attributes: Sequence[str] = ()) -> dict[str, tuple[Column, ...]]:
    """Return every table's columns, with those of the safe distance and of these attributes of people."""
    found = {table: (*columns, *attribute_columns(table, attributes)) for table, columns in TABLES.items()}
    return {**found, "photos": (*TABLES["photos"], *safe_distance_columns(None))}
