"""How doubts about people stand in the tables: in `people`, and of both people of a pair in `pairs`."""

from __future__ import annotations

from collections.abc import Sequence

from ..people.doubts import OF_PHOTOS, PersonDoubt
from ..scene import Scene

#: The column of people, and its value if nothing speaks against a person.
DOUBT, NO_DOUBT = "doubt", "none"
#: Between several reasons.
_AND = "+"

MEANING = (
    f"why this may not be a person, or may be one found twice: {', '.join(OF_PHOTOS)}, with {_AND} between them; "
    f"{NO_DOUBT}: no doubt; empty: measured by a version without this column"
)


def column_of_doubt(end: str = "") -> str:
    """Return how the column is called: of people, or of a pair's person "a" or "b"."""
    return f"{DOUBT}_{end}" if end else DOUBT


def doubt_text(scene: Scene, person: int) -> str:
    """Return why a person may not be one, as the tables have it."""
    return doubts_in_text(scene.doubts[person])


def doubts_in_text(reasons: Sequence[PersonDoubt]) -> str:
    """Return reasons as the tables have them."""
    return _AND.join(reasons) or NO_DOUBT


def reasons_in(text: str) -> list[str]:
    """Return the reasons in a text of the tables, "none" alone where there are none."""
    return text.split(_AND)
