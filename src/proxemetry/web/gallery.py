"""The gallery of a review: which photos it shows, in which order."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from ..archive.store.index import PhotoCard
from ..errors import SettingsError


@dataclass(frozen=True)
class Query:
    """What the gallery shows: one of `FILTERS`, one of `SORTS`, one group (None: all), and a part of the name."""

    show: str = "all"
    sort: str = "name"
    group: str | None = None
    text: str = ""

    def __post_init__(self) -> None:
        if self.show not in FILTERS or self.sort not in SORTS:
            raise SettingsError(f"gallery: show is one of {', '.join(FILTERS)}, sort one of {', '.join(SORTS)}")


#: Filter -> whether a photo with these marks (actions in force) belongs to it.
FILTERS: dict[str, Callable[[PhotoCard, frozenset[str]], bool]] = {
    "all": lambda s, m: True,
    "unchecked": lambda s, m: "checked" not in m,
    "pairs": lambda s, m: s.n_pairs > 0,
    "nobody": lambda s, m: s.status == "ok" and s.n_people == 0,
    "camera": lambda s, m: s.doubtful or s.status == "no_camera",
    "doubles": lambda s, m: s.duplicates > 0,
    "doubts": lambda s, m: s.doubts > 0,
    "failed": lambda s, m: s.status == "failed",
    "corrected": lambda s, m: bool(m - {"checked", "note"}),
    "excluded": lambda s, m: s.status == "excluded",
    "notes": lambda s, m: "note" in m,
}


def _missing_last(value: float, descending: bool = False) -> tuple[bool, float]:
    return (math.isnan(value), 0.0 if math.isnan(value) else (-value if descending else value))


#: Sort -> its key; ties stay in the order of the names.
SORTS: dict[str, Callable[[PhotoCard], Any]] = {
    "name": lambda s: 0,
    "uncertain": lambda s: _missing_last(s.spread, descending=True),
    "nearest": lambda s: _missing_last(s.nearest_m),
    "people": lambda s: -s.n_people,
    "doubts": lambda s: -s.doubts,
}


def ordered(query: Query, cards: Sequence[PhotoCard], marks: Callable[[PhotoCard], frozenset[str]]) -> list[int]:
    """Return the numbers of the photos that a query asks for, in its order; marks: a photo's actions in force."""
    belongs, key, text = FILTERS[query.show], SORTS[query.sort], query.text.casefold()
    rows = [
        number
        for number, card in enumerate(cards)
        if belongs(card, marks(card))
        and (query.group is None or card.group == query.group)
        and text in card.photo.casefold()
    ]
    return sorted(rows, key=lambda number: key(cards[number]))
