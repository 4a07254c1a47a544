"""A clip's tables as SPSS files, with the codebook's meanings as labels."""

from __future__ import annotations

import importlib.util
from typing import Any

from ..archive.figures.export import spss_names
from ..archive.store.duck import attached, named, quoted
from ..archive.store.folder import RUN_FILE, Folder
from ..errors import OutputError, SettingsError
from ..tables import PREFIX, Column
from .columns import TABLES, codebook

#: Rows of one file, which is made in memory: as many of DuckDB's vectors as give a little under a million.
_ROWS_A_VECTOR, _VECTORS_A_FILE = 2048, 488


def is_clip(folder: Folder) -> bool:
    """Return whether a results folder is a clip's."""
    content = folder.read(RUN_FILE)
    return content is not None and b'"proxemetry.clip/1"' in content


def write_spss(folder: Folder, target: Folder) -> list[str]:
    """Write every table that is there as .sav and return the names; tables beyond a million rows come in several files.

    Raises SettingsError where pyreadstat is missing, OutputError where there are no tables.
    """
    if any(importlib.util.find_spec(package) is None for package in ("pandas", "pyreadstat")):
        raise SettingsError("SPSS files need an extra: pip install 'proxemetry[spss]'")
    written: list[str] = []
    for table in TABLES:
        if folder.exists(f"{table}.parquet"):
            written += _written(folder, target, table)
    if not written:
        raise OutputError(f"{folder.location}: no tables yet; the same `proxemetry video` goes on")
    return written


def _written(folder: Folder, target: Folder, table: str) -> list[str]:
    import pyreadstat

    duck = attached(folder)
    source = f"read_parquet({quoted(folder.path(f'{table}.parquet'))})"
    there = [row[0] for row in duck.execute(f"DESCRIBE SELECT * FROM {source}").fetchall()]
    known = _meanings(table, there)
    (rows,) = duck.execute(f"SELECT count(*) FROM {source}").fetchone()
    count = max(1, -(-rows // (_ROWS_A_VECTOR * _VECTORS_A_FILE)))
    names: list[str] = []
    columns = [known[name] for name in there]
    called = spss_names(columns)
    values = ", ".join(_value(column, name) for column, name in zip(columns, called, strict=True))
    duck.execute(f"SELECT {values} FROM {source}")
    for k in range(count):
        names.append(f"{table}.sav" if count == 1 else f"{table}_{k + 1}.sav")
        frame: Any = duck.fetch_df_chunk(_VECTORS_A_FILE)
        with target.writing(names[-1]) as temporary:
            pyreadstat.write_sav(frame, temporary, column_labels=[known[name].meaning for name in there])
    return names


def _value(column: Column, called: str) -> str:
    name, called = named(column.name), named(called)
    if column.kind == "VARCHAR":
        return f"coalesce({name}, '') AS {called}"
    return f"{name}::{'INTEGER::' if column.kind == 'BOOLEAN' else ''}DOUBLE AS {called}"


def _meanings(table: str, names: list[str]) -> dict[str, Column]:
    """Return the column of each name; limits are read off the names themselves."""
    limits = sorted({n.split("_within_")[1].removesuffix("_apart") for n in names if "_within_" in n}, key=float)
    of_table = codebook(tuple(limits), [n.removeprefix(PREFIX) for n in names if n.startswith(PREFIX)])[table]
    return {c.name: c for c in of_table}
