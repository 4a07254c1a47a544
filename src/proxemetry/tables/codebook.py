"""The codebook: every column of every table with its type, unit and meaning, as rows, CSV and a page.

It is made from the columns themselves, so that a column and its meaning always agree.
"""

from __future__ import annotations

import csv
import io
from collections.abc import Iterator, Mapping, Sequence

from ..files import cell_of
from .attribute_columns import PREFIX
from .column import Column
from .rows import all_columns

#: `corrections.csv`, the log of a review as it is exported.
CORRECTIONS = (
    Column("number", "INTEGER", "", "number of the action, in the order they were done"),
    Column("time", "VARCHAR", "", "when, in universal time (ISO 8601)"),
    Column("who", "VARCHAR", "", "the reviewer's name (--who)"),
    Column("photo", "VARCHAR", "", "path of the photo"),
    Column("sha256", "VARCHAR", "", "SHA-256 of the file"),
    Column("action", "VARCHAR", "", "what was done: remove_person, set_camera, exclude ..., undo"),
    Column("value", "VARCHAR", "", "with what, as JSON"),
)


#: How the codebook calls the SQL types.
_KINDS = {"VARCHAR": "text", "INTEGER": "integer", "DOUBLE": "number", "BOOLEAN": "true or false"}


def _codebook(attributes: Sequence[str] = ()) -> dict[str, tuple[Column, ...]]:
    return {**all_columns(attributes), "corrections": CORRECTIONS}


def codebook_rows(attributes: Sequence[str] = ()) -> tuple[list[str], Iterator[tuple[str, ...]]]:
    """Return the codebook's header, and a row for every column: table, column, type, unit and meaning.

    attributes: those of people that the tables have columns of.
    """
    return rows_about(_codebook(attributes))


def rows_about(tables: Mapping[str, Sequence[Column]]) -> tuple[list[str], Iterator[tuple[str, ...]]]:
    """Return the same of any tables."""
    listed = ((table, column) for table, columns in tables.items() for column in columns)
    rows = ((table, c.name, _KINDS.get(c.kind, c.kind.lower()), c.unit, c.meaning) for table, c in listed)
    return ["table", "column", "type", "unit", "meaning"], rows


def codebook_csv(attributes: Sequence[str] = ()) -> str:
    """Return the codebook as CSV, with the columns of these attributes of people."""
    return csv_about(_codebook(attributes))


def csv_about(tables: Mapping[str, Sequence[Column]]) -> str:
    """Return the same of any tables."""
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    header, rows = rows_about(tables)
    writer.writerow(header)
    writer.writerows(tuple(map(cell_of, row)) for row in rows)
    return out.getvalue()


def codebook_markdown() -> str:
    """Return the same as a page."""
    lines = [
        "# Codebook",
        "",
        "The columns of the tables in a results folder; a value that is missing is empty. Attributes of recorded "
        f"people are further columns: KEY is `{PREFIX}KEY` in people, `{PREFIX}KEY_a` and `{PREFIX}KEY_b` in pairs.",
        "",
    ]
    for table, columns in _codebook().items():
        lines += [f"## {table}", "", *markdown_table(columns), ""]
    return "\n".join(lines)


def markdown_table(columns: Sequence[Column]) -> list[str]:
    """Return the lines of a table's columns on a page."""
    head = ["| column | type | unit | meaning |", "|---|---|---|---|"]
    return head + [f"| `{c.name}` | {_KINDS[c.kind]} | {c.unit} | {c.meaning} |" for c in columns]
