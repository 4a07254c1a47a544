"""The SQL of the tables of a results folder, over the view `measured` of all its rows (`Results.view`)."""

from __future__ import annotations

import logging
from collections.abc import Sequence
from typing import Any

from ...files import FORMULA
from ...tables import ENDS, MOST_COLUMNS, TABLES, Column, attribute_columns, column_name, safe_distance_columns
from .duck import named, quoted
from .folder import Folder


def attributes_in(duck: Any) -> tuple[str, ...]:
    """Return the attributes of people that tables over the view of `Results.view` have columns of, sorted.

    Of more than `tables.MOST_COLUMNS` the most frequent.
    """
    found = duck.execute(
        "SELECT key, count(*) AS n FROM (SELECT unnest(attributes) AS key FROM measured) GROUP BY key "
        "ORDER BY n DESC, key"
    ).fetchall()
    if len(found) > MOST_COLUMNS:
        logging.getLogger("proxemetry").warning(
            f"people have {len(found):,} different attributes: the {MOST_COLUMNS} most frequent become columns"
        )
    return tuple(sorted(key for key, _ in found[:MOST_COLUMNS]))


def table_query(table: str, safe_distance_m: float | None, attributes: Sequence[str] = ()) -> str:
    """Return the SQL of one table over the view of `Results.view`, with columns of these attributes of people."""
    columns = ", ".join(c.name for c in TABLES[table])
    if table == "photos":
        limit = "NULL::DOUBLE" if safe_distance_m is None else f"{float(safe_distance_m)!r}::DOUBLE"
        names = [c.name for c in safe_distance_columns(safe_distance_m)]
        values = (
            limit,
            f"CASE WHEN {limit} IS NOT NULL AND n_pairs IS NOT NULL "
            f"THEN len(list_filter(pairs, lambda p: p.distance_m < {limit})) END",
        )
        extra = ", ".join(f"{value} AS {name}" for name, value in zip(names, values, strict=True))
        return f"SELECT {columns}, {extra} FROM measured ORDER BY photo"
    if table == "people":
        said = "".join(_attribute(key, "attributes", column_name(key)) for key in attributes)
        return f"SELECT {columns}{said} FROM {_nested('people')} ORDER BY photo, person"
    said = "".join(_attribute(key, f"said_{end}", column_name(key, end)) for key in attributes for end in ENDS)
    people = "".join(
        f" LEFT JOIN (SELECT photo, person AS person_{end}, attributes AS said_{end} FROM {_nested('people')}) "
        f"USING (photo, person_{end})"
        for end in (ENDS if attributes else ())
    )
    return f"SELECT {columns}{said} FROM {_nested('pairs')}{people} ORDER BY photo, person_a, person_b"


def stored(folder: Folder, table: str) -> str:
    """Return a table of a results folder as SQL to select from, with the columns that it was written before, empty."""
    return with_columns(f"read_parquet({quoted(folder.path(f'{table}.parquet'))})", TABLES[table])


def with_columns(rows: str, columns: Sequence[Column]) -> str:
    """Return rows as SQL to select from, with those of the columns that they lack, empty, behind their own."""
    nothing = ", ".join(f"NULL::{column.kind} AS {named(column.name)}" for column in columns)
    return f"(FROM {rows} UNION ALL BY NAME SELECT * FROM (SELECT {nothing}) WHERE false)"


def _nested(table: str) -> str:
    return f"(SELECT photo, unnest({table}, max_depth := 2) FROM (SELECT photo, {table} FROM measured))"


def _attribute(key: str, source: str, column: str) -> str:
    """Return the SQL of an attribute's column, after a comma."""
    return f", map_extract({source}, {quoted(key)})[1] AS {named(column)}"


def as_cells(table: str, query: str, attributes: Sequence[str] = ()) -> str:
    """Return the SQL of a table as CSV holds it, see `files.cell_of`."""
    columns = (*TABLES[table], *attribute_columns(table, attributes))
    texts = [named(c.name) for c in columns if c.kind == "VARCHAR"]
    cells = ", ".join(
        f"CASE WHEN regexp_matches({name}, {quoted(FORMULA)}) THEN chr(39) || {name} ELSE {name} END AS {name}"
        for name in texts
    )
    return f"SELECT * REPLACE ({cells}) FROM ({query})" if texts else query
