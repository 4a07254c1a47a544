"""The three tidy tables of a results folder: their columns, units and meanings, and the rows of one scene."""

from .codebook import CORRECTIONS, codebook_csv, codebook_markdown, codebook_rows
from .column import Column, Value
from .photo_columns import safe_distance_columns
from .rows import TABLES, all_columns, rows

__all__ = [
    "CORRECTIONS",
    "TABLES",
    "Column",
    "Value",
    "all_columns",
    "codebook_csv",
    "codebook_markdown",
    "codebook_rows",
    "rows",
    "safe_distance_columns",
]
