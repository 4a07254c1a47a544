"""Rows of parts that another version of the package wrote, with the columns of this one.

A column that such a part lacks is missing, one that this version does not have is left out, and one of another type is
converted where its values can be.
"""

from __future__ import annotations

import logging
from collections.abc import Mapping, Sequence
from functools import cache

from .duck import attached, connection, quoted
from .folder import Folder

#: Columns that every version has written as they are today.
AS_EVER = ("photo", "sha256", "scene")

Types = tuple[tuple[str, str], ...]


def rows_of(
    folder: Folder, names: Sequence[str], structure: str, *, only: Sequence[str] = (), with_names: bool = False
) -> str:
    """Return the rows of parts as SQL to select from, with the columns of `structure`.

    names: of the parts in the folder, at least one. structure: that of one row, as DuckDB's `from_json` takes it. only:
    those of `AS_EVER` that are wanted, which are read as they are. with_names: with their `filename`.
    """
    if only:  # the other columns are not looked at, whatever they are
        columns = [*only, "filename"] if with_names else only
        return f"(SELECT {', '.join(columns)} FROM {_read(folder, names, with_names)})"
    groups = _by_columns(folder, names)
    expected = _expected(structure)
    if list(groups) == [expected]:
        return _read(folder, names, with_names)
    queries: list[str] = []
    for types, alike in groups.items():
        source = _read(folder, alike, with_names)
        if types == expected:
            queries.append(f"SELECT * FROM {source}")
        else:
            _warn(folder.location, types, expected)
            row = f"unnest(from_json(to_json(part), {quoted(structure)}), max_depth := 1)"
            queries.append(f"SELECT {row}{', filename' if with_names else ''} FROM {source} AS part")
    return f"({' UNION ALL BY NAME '.join(queries)})"


def _read(folder: Folder, names: Sequence[str], with_names: bool) -> str:
    files = ", ".join(quoted(folder.path(name)) for name in names)
    return f"read_parquet([{files}]{', filename = true' if with_names else ''})"


@cache
def _expected(structure: str) -> Types:
    """Return the columns that a part of this version has, with DuckDB's types."""
    query = "DESCRIBE SELECT unnest(from_json('[]'::JSON, $structure), max_depth := 2)"
    rows = connection().cursor().execute(query, {"structure": f"[{structure}]"}).fetchall()
    return tuple((str(row[0]), str(row[1])) for row in rows)


#: The columns of parts that were looked at, by folder, name, and the file's size and date.
_known: dict[tuple[object, ...], Types] = {}


def _by_columns(folder: Folder, names: Sequence[str]) -> Mapping[Types, list[str]]:
    """Return the parts that have the same columns together."""
    states = folder.states(names[0].rpartition("/")[0])
    keys = {name: (folder.location, name, states.get(name.rpartition("/")[2])) for name in names}
    fresh = [name for name in names if keys[name] not in _known]
    if fresh:
        for name, types in _columns_of(folder, fresh).items():
            _known[keys[name]] = types
    groups: dict[Types, list[str]] = {}
    for name in names:
        groups.setdefault(_known[keys[name]], []).append(name)
    return groups


def _columns_of(folder: Folder, names: Sequence[str]) -> dict[str, Types]:
    """Return every part's columns with DuckDB's types: parts whose schema reads the same are described once."""
    # By the last part of their paths: a store may spell the rest of a URL otherwise.
    by_base = {name.rpartition("/")[2]: name for name in names}
    duck = attached(folder)
    rows = duck.execute(
        "SELECT file_name, hash(list(row(name, type, num_children, duckdb_type))) FROM parquet_schema($paths) "
        "GROUP BY file_name",
        {"paths": [folder.path(name) for name in names]},
    ).fetchall()
    described: dict[int, Types] = {}
    found: dict[str, Types] = {}
    for path, digest in rows:
        if digest not in described:
            columns = duck.execute("DESCRIBE SELECT * FROM read_parquet($path)", {"path": path}).fetchall()
            described[digest] = tuple((str(column[0]), str(column[1])) for column in columns)
        found[by_base[path.rpartition("/")[2]]] = described[digest]
    return found


@cache
def _warn(location: str, types: Types, expected: Types) -> None:
    """Warn once of a folder's parts with these columns, and name those that this version has in addition."""
    before = dict(types)
    missing = [name for name, _ in expected if name not in before]
    within = [name for name, kind in expected if name in before and before[name] != kind]
    what = ", ".join([*missing, *(f"some of {name}" for name in within)])
    logging.getLogger("proxemetry").warning(
        f"{location}: measured by another version of proxemetry; columns that it did not have are empty"
        f"{f' ({what})' if what else ''}: measure again with --restart to fill them"
    )
