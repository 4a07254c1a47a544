"""The three tidy tables of a results folder: their columns, units and meanings, and the rows of one scene."""

from .attribute_columns import ENDS, MOST_COLUMNS, PREFIX, attribute_columns, column_name
from .codebook import (
    CORRECTIONS,
    codebook_csv,
    codebook_markdown,
    codebook_rows,
    csv_about,
    markdown_table,
    rows_about,
)
from .column import Column, Value
from .doubt_columns import DOUBT, NO_DOUBT, column_of_doubt, doubts_in_text, reasons_in
from .photo_columns import safe_distance_columns
from .rows import TABLES, all_columns, rows

__all__ = [
    "CORRECTIONS",
    "DOUBT",
    "ENDS",
    "MOST_COLUMNS",
    "NO_DOUBT",
    "PREFIX",
    "TABLES",
    "Column",
    "Value",
    "all_columns",
    "attribute_columns",
    "codebook_csv",
    "codebook_markdown",
    "codebook_rows",
    "column_name",
    "column_of_doubt",
    "csv_about",
    "doubts_in_text",
    "markdown_table",
    "reasons_in",
    "rows",
    "rows_about",
    "safe_distance_columns",
]
