"""Which people and pairs of a results folder count: all, or those whose attributes are as `--pairs-where` has them."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from ...people.attributes import PairsWhere, compared
from ...tables import DOUBT, ENDS, PREFIX, column_name, column_of_doubt, reasons_in
from ..store.duck import attached, named, quoted
from ..store.folder import Folder
from ..store.queries import stored


@dataclass(frozen=True)
class Counted:
    """The three tables as SQL to select from, only with the rows that count.

    restricted: whether some do not: then `n_people` and `n_pairs` of photos are of those who do, while a person's
    `nearest_m` is still the distance to any person.
    """

    photos: str
    people: str
    pairs: str
    restricted: bool = False


def counted(folder: Folder, where: PairsWhere | None) -> Counted:
    """Return the tables of a folder; raises SettingsError where no person can be as `where` asks for."""
    photos, people, pairs = (f"read_parquet({quoted(folder.path(f'{t}.parquet'))})" for t in _TABLES)
    if where is None:
        return Counted(photos, people, pairs)
    people, pairs = stored(folder, "people"), stored(folder, "pairs")
    duck = attached(folder, threads=None)
    recorded = _recorded(duck, people)
    known = _known(duck, people, where, recorded)
    where.require_some({key: values if key in recorded else _by_reason(values) for key, values in known.items()})
    conditions = [
        _Condition(key, key in recorded, [v for v in known[key] if _meant(v, values, key in recorded)])
        for key, values in where.accepted.items()
    ]
    some = f"(SELECT * FROM {people} WHERE {_holds(conditions)})"
    both = f"(SELECT * FROM {pairs} WHERE {' AND '.join(_holds(conditions, end) for end in ENDS)})"
    # The row numbers of the file stay those of the photos: summaries go by them.
    listed = photos.removesuffix(")") + ", file_row_number = true)"
    numbered = (
        f"(SELECT * REPLACE (CASE WHEN n_people IS NOT NULL THEN coalesce(n_some, 0) END AS n_people, "
        f"CASE WHEN n_pairs IS NOT NULL THEN coalesce(n_both, 0) END AS n_pairs) FROM {listed} "
        f"LEFT JOIN (SELECT photo, count(*) AS n_some FROM {some} GROUP BY photo) USING (photo) "
        f"LEFT JOIN (SELECT photo, count(distance_m) AS n_both FROM {both} GROUP BY photo) USING (photo))"
    )
    return Counted(numbered, some, both, restricted=True)


_TABLES = ("photos", "people", "pairs")


@dataclass(frozen=True)
class _Condition:
    """What has to hold of a person: the value of an attribute that a recording stated, or of the column of doubts."""

    key: str
    is_recorded: bool
    values: list[str]

    def holds(self, end: str) -> str:
        """Return it as SQL, of a person or of one of a pair."""
        return f"{_column(self.key, self.is_recorded, end)} IN ({', '.join(map(quoted, self.values))})"


def _column(key: str, is_recorded: bool, end: str = "") -> str:
    return named(column_name(key, end) if is_recorded else column_of_doubt(end))


def _recorded(duck: Any, people: str) -> set[str]:
    """Return the attributes that recordings stated of people."""
    columns = [name for name, *_ in duck.execute(f"DESCRIBE SELECT * FROM {people}").fetchall()]
    return {name.removeprefix(PREFIX) for name in columns if name.startswith(PREFIX)}


def _known(duck: Any, people: str, where: PairsWhere, recorded: set[str]) -> dict[str, dict[str, int]]:
    """Return what can be asked for, attributes and doubts; of what is asked for with its values and how many have each.

    If a recording has an attribute named like the column of doubts, the attribute is meant.
    """
    known: dict[str, dict[str, int]] = {key: {} for key in sorted(recorded | ({DOUBT} & where.accepted.keys()))}
    for key in where.accepted:
        if key in known:
            column = _column(key, key in recorded)
            found = duck.execute(
                f"SELECT {column}, count(*) FROM {people} WHERE {column} NOTNULL GROUP BY 1 ORDER BY 1"
            )
            known[key] = dict(found.fetchall())
    return known


def _by_reason(texts: dict[str, int]) -> dict[str, int]:
    """Return how many people have each doubt, out of how many have each text of the tables."""
    count: Counter[str] = Counter()
    for text, people in texts.items():
        count.update(dict.fromkeys(reasons_in(text), people))
    return dict(count)


def _meant(value: str, accepted: frozenset[str], is_recorded: bool) -> bool:
    """Whether a value in the tables is one that is asked for; of several doubts about a person any will do."""
    return any(compared(part) in accepted for part in ([value] if is_recorded else reasons_in(value)))


def _holds(conditions: Sequence[_Condition], end: str = "") -> str:
    """Return the SQL of a person, or of one of a pair, having one of the values of every attribute."""
    return " AND ".join(condition.holds(end) for condition in conditions)


def nearest_of(pairs: str) -> str:
    """Return the SQL of each person's nearest other person among these pairs: photo, person, nearest_m."""
    ends = " UNION ALL ".join(f"SELECT photo, person_{end} AS person, distance_m FROM {pairs}" for end in ENDS)
    return f"(SELECT photo, person, min(distance_m) AS nearest_m FROM ({ends}) GROUP BY photo, person)"
