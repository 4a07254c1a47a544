"""A clip's tables in other forms than they lie in its folder: SPSS files, a workbook, CSV of a locale, copies."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from itertools import chain

from ..archive.figures.export import write_sav_files
from ..archive.figures.spreadsheet import Locale, Table, rows_of, write_csv_files, write_workbook
from ..archive.store.duck import attached, quoted
from ..archive.store.folder import Folder
from ..errors import OutputError
from ..tables import PREFIX, Column, rows_about
from .columns import TABLES, codebook
from .exports import COCO
from .writing import CODEBOOK


def write_again(folder: Folder, target: Folder, formats: Sequence[str], locale: Locale | None = None) -> list[str]:
    """Write every table that is there in these of csv, parquet, xlsx, spss and coco; return the names of the files.

    What lies in the folder already is copied where the target is another. Raises OutputError where there are no tables,
    SettingsError where an extra is missing or a table is longer than a sheet.
    """
    columns = _columns(folder)
    written: list[str] = []
    for form in formats:
        if form == "spss":
            queries = {table: (of_table, _query(folder, table)) for table, of_table in columns.items()}
            written += write_sav_files(attached(folder), queries, target)
        elif form == "xlsx":
            tables = chain(_rows(folder, columns), [("codebook", *rows_about(columns))])
            written.append(write_workbook(tables, target))
        elif form == "csv" and locale is not None:
            written += write_csv_files(_rows(folder, columns), target, locale)
        elif folder.location != target.location:
            names = [COCO] if form == "coco" else [f"{table}.{form}" for table in columns]
            written += _copied(folder, target, [*names, CODEBOOK] if form == "csv" else names)
    return written


def _columns(folder: Folder) -> dict[str, list[Column]]:
    """Return the columns of the tables that are there, with the limits that their names have."""
    found: dict[str, list[Column]] = {}
    for table in TABLES:
        if folder.exists(f"{table}.parquet"):
            rows = attached(folder).execute(f"DESCRIBE {_query(folder, table)}").fetchall()
            found[table] = _meanings(table, {str(row[0]): str(row[1]) for row in rows})
    if not found:
        raise OutputError(f"{folder.location}: no tables yet; repeat the same `proxemetry video` to continue")
    return found


def _meanings(table: str, names: Mapping[str, str]) -> list[Column]:
    """Return the columns by these names and of these types; what another version wrote stays, without a meaning."""
    limits = {n.split("_within_")[1].removesuffix("_apart") for n in names if "_within_" in n}
    attributes = [n.removeprefix(PREFIX) for n in names if n.startswith(PREFIX)]
    known = {c.name: c for c in codebook(sorted(limits, key=float), attributes)[table]}
    return [
        known[name] if name in known and known[name].kind == kind else _of_another_version(name, kind, known.get(name))
        for name, kind in names.items()
    ]


def _of_another_version(name: str, kind: str, now: Column | None) -> Column:
    if now is None:
        return Column(name, kind, "", "(a column of another version of proxemetry)")
    return Column(name, kind, now.unit, now.meaning)


def _query(folder: Folder, table: str) -> str:
    return f"SELECT * FROM read_parquet({quoted(folder.path(f'{table}.parquet'))})"


def _rows(folder: Folder, columns: dict[str, list[Column]]) -> Iterator[Table]:
    for table, of_table in columns.items():
        yield table, [c.name for c in of_table], rows_of(attached(folder).execute(_query(folder, table)))


def _copied(folder: Folder, target: Folder, names: Sequence[str]) -> list[str]:
    written: list[str] = []
    for name in names:
        content = folder.read(name)
        if content is not None:
            target.write(name, content)
            written.append(name)
    return written
