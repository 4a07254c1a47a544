"""Which people and pairs of a results folder count: all, or those whose attributes are as `--pairs-where` has them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from ...people.attributes import PairsWhere, compared
from ...tables import ENDS, PREFIX, column_name
from ..store.duck import attached, named, quoted
from ..store.folder import Folder


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
    known = _known(attached(folder, threads=None), people, where)
    where.require_some(known)
    wanted = {key: [v for v in known[key] if compared(v) in values] for key, values in where.accepted.items()}
    some = f"(SELECT * FROM {people} WHERE {_holds(wanted)})"
    both = f"(SELECT * FROM {pairs} WHERE {' AND '.join(_holds(wanted, end) for end in ENDS)})"
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


def _known(duck: Any, people: str, where: PairsWhere) -> dict[str, dict[str, int]]:
    """Return the attributes that people have; of those asked for with their values and how many have each."""
    columns = [name for name, *_ in duck.execute(f"DESCRIBE SELECT * FROM {people}").fetchall()]
    known: dict[str, dict[str, int]] = {name.removeprefix(PREFIX): {} for name in columns if name.startswith(PREFIX)}
    for key in where.accepted:
        if key in known:
            column = named(column_name(key))
            known[key] = dict(
                duck.execute(f"SELECT {column}, count(*) FROM {people} WHERE {column} NOTNULL GROUP BY 1").fetchall()
            )
    return known


def _holds(wanted: dict[str, list[str]], end: str = "") -> str:
    """Return the SQL of a person, or of one of a pair, having one of the values of every attribute."""
    return " AND ".join(
        f"{named(column_name(key, end))} IN ({', '.join(map(quoted, values))})" for key, values in wanted.items()
    )


def nearest_of(pairs: str) -> str:
    """Return the SQL of each person's nearest other person among these pairs: photo, person, nearest_m."""
    ends = " UNION ALL ".join(f"SELECT photo, person_{end} AS person, distance_m FROM {pairs}" for end in ENDS)
    return f"(SELECT photo, person, min(distance_m) AS nearest_m FROM ({ends}) GROUP BY photo, person)"
