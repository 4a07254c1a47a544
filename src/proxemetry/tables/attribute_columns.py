"""Columns of what else recordings state of people: as many as there are attributes, in `people` and in `pairs`."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from ..scene import Scene
from .column import Column, Value

#: Before an attribute's name: no column of ours begins so, and no spreadsheet takes it for a formula.
PREFIX = "attr_"
#: More attributes than these become no columns; the rarest stay in the scenes alone.
MOST_COLUMNS = 100
#: The two people of a pair.
ENDS = ("a", "b")


def column_name(key: str, end: str = "") -> str:
    """Return how the column of an attribute is called, of a pair's person "a" or "b" with that at its end."""
    return f"{PREFIX}{key}_{end}" if end else f"{PREFIX}{key}"


def attribute_columns(table: str, keys: Sequence[str]) -> tuple[Column, ...]:
    """Return the columns that a table has of attributes by these names: KEY is attr_KEY, of pairs attr_KEY_a and _b."""
    if table == "people":
        return tuple(
            Column(column_name(key), "VARCHAR", "", f"attribute {key!r} as it was recorded", _of_person(key))
            for key in keys
        )
    if table == "pairs":
        return tuple(
            Column(
                column_name(key, end), "VARCHAR", "", f"attribute {key!r} of person_{end} as it was recorded",
                _of_one(key, end),
            )
            for key in keys
            for end in ENDS
        )  # fmt: skip
    return ()


def _of_person(key: str) -> Callable[[Scene, int], Value]:
    def value(scene: Scene, person: int) -> Value:
        return scene.people.attributes[person].get(key)

    return value


def _of_one(key: str, end: str) -> Callable[[Scene, int, int], Value]:
    def value(scene: Scene, a: int, b: int) -> Value:
        return scene.people.attributes[a if end == "a" else b].get(key)

    return value
