"""Lists of entries with ids out of several files, as one: no two entries share an id, and references follow."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

Fields = Mapping[str, Any]


@dataclass(frozen=True)
class United:
    """Entries of several files' lists, each once. changed: for each file, ids of it as text -> the id in `entries`."""

    entries: list[Any]
    changed: tuple[Mapping[str, Any], ...]

    def renamed(self, file: int, name: str, fields: Fields) -> Fields:
        """Return fields that refer by `name` to an entry of a file, by number, with its id in `entries`."""
        changed = self.changed[file]
        reference = str(fields.get(name))
        return {**fields, name: changed[reference]} if reference in changed else fields


def united(lists: Sequence[Sequence[Any]]) -> United:
    """Return the entries of a list of each file as one; one whose id another entry has already is given a new one."""
    found: list[Any] = []
    places: list[list[int]] = []
    for entries in lists:
        found += [entry for k, entry in enumerate(entries) if entry not in found and entry not in entries[:k]]
        places.append([found.index(entry) for entry in entries])
    given = [_id_of(entry) for entry in found]
    ids = ids_apart(given)
    changed: list[dict[str, Any]] = []
    for place in places:
        first = {str(given[k]): k for k in reversed(place) if given[k] is not None}
        changed.append({old: ids[k] for old, k in first.items() if ids[k] != given[k]})
    kept = [e if old is None else {**e, "id": new} for e, old, new in zip(found, given, ids, strict=True)]
    return United(kept, tuple(changed))


def ids_apart(wanted: Sequence[Any]) -> list[Any]:
    """Return an id for each entry: its own where it has one that no entry before has, else the next free number.

    Ids are apart as text: a file may refer to entry 3 by "3".
    """
    taken = {str(identity) for identity in wanted if _is_id(identity)}
    found: list[Any] = []
    used: set[str] = set()
    following = 1
    for identity in wanted:
        if not _is_id(identity) or str(identity) in used:
            while str(following) in taken or str(following) in used:
                following += 1
            identity = following
        used.add(str(identity))
        found.append(identity)
    return found


def _id_of(entry: Any) -> Any:
    found: Any = entry.get("id") if isinstance(entry, Mapping) else None  # pyright: ignore[reportUnknownVariableType, reportUnknownMemberType]
    return found if _is_id(found) else None


def _is_id(value: Any) -> bool:
    return isinstance(value, int | str)
