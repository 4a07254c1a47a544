"""Results for spreadsheets: one Excel workbook with its codebook, and CSV as a country's own Excel reads it."""

from __future__ import annotations

import csv
import importlib.util
import io
import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import chain
from typing import Any

from ...errors import SettingsError
from ...files import cell_of
from ...tables import all_columns, codebook_rows
from ..store.folder import Folder
from ..store.queries import attributes_in, table_query
from ..store.results import Results

XLSX_FILE = "results.xlsx"

#: What a sheet holds at most, its header included.
_SHEET_ROWS = 1_048_576
_ROWS_AT_ONCE = 10_000

#: Languages whose numbers have a decimal comma (Unicode CLDR 45), and countries where their speakers write a point.
_COMMA_LANGUAGES = frozenset(
    {
        *("af", "az", "be", "bg", "bs", "ca", "cs", "da", "de", "el", "es", "et", "eu", "fi", "fo", "fr", "gl", "hr"),
        *("hu", "hy", "id", "is", "it", "ka", "kk", "lt", "lv", "mk", "nb", "nl", "nn", "no", "pl", "pt", "ro", "ru"),
        *("sk", "sl", "sq", "sr", "sv", "tr", "uk", "uz", "vi"),
    }
)
_POINT_COUNTRIES = frozenset(
    {"de_CH", "de_LI", "it_CH", *(f"es_{c}" for c in ("MX", "US", "PR", "GT", "HN", "NI", "PA", "PE", "SV", "DO"))}
)


#: A table's name, its columns' names, and its rows.
Table = tuple[str, Sequence[str], Iterator[Sequence[Any]]]


@dataclass(frozen=True)
class Locale:
    """How a country's spreadsheet reads CSV: the sign before the decimals and the one between the columns."""

    name: str
    decimal: str
    separator: str

    @classmethod
    def named(cls, name: str) -> Locale:
        """Return the locale of a name such as fi, de_AT or pt-BR; raises SettingsError for anything else."""
        if not re.fullmatch(r"[A-Za-z]{2,3}([-_][A-Za-z]{2})?", name):
            raise SettingsError(f"--locale {name!r}: write a language, or a language and a country: fi, de_AT, en")
        language, _, country = name.replace("-", "_").partition("_")
        full = f"{language.lower()}_{country.upper()}"
        comma = language.lower() in _COMMA_LANGUAGES and full not in _POINT_COUNTRIES
        return cls(name, "," if comma else ".", ";" if comma else ",")


def write_local_csv(
    results: Results, target: Folder, locale: Locale, safe_distance_m: float | None = None
) -> list[str]:
    """Write photos, people and pairs as CSV of a locale, with a byte order mark; return their names.

    Numbers are those of the plain tables. Raises OutputError where a file cannot be written.
    """
    return write_csv_files(_tables(results, safe_distance_m), target, locale)


def write_csv_files(tables: Iterable[Table], target: Folder, locale: Locale) -> list[str]:
    """Write tables as `write_local_csv` does."""
    written: list[str] = []
    for table, names, rows in tables:
        name = f"{table}.csv"
        with target.writing(name) as temporary, open(temporary, "w", encoding="utf-8-sig", newline="") as file:
            writer = csv.writer(file, delimiter=locale.separator)
            writer.writerow(names)
            writer.writerows([_local(value, locale.decimal) for value in row] for row in rows)
        written.append(name)
    return written


def _local(value: Any, decimal: str) -> str:
    if value is None:
        return ""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return cell_of(value)
    return repr(value).replace(".", decimal) if isinstance(value, float) else str(value)


def write_xlsx(results: Results, target: Folder, safe_distance_m: float | None = None) -> str:
    """Write `results.xlsx`, a sheet a table and one with the codebook; return its name.

    Texts stay texts, whatever sign they begin with. Raises SettingsError where XlsxWriter is missing or a table is
    longer than a sheet, OutputError where the file cannot be written.
    """
    codebook = [("codebook", *codebook_rows(attributes_in(results.view())))]
    return write_workbook(chain(_tables(results, safe_distance_m), codebook), target)


def write_workbook(tables: Iterable[Table], target: Folder) -> str:
    """Write tables as `write_xlsx` does, a sheet each, one after the other as they come."""
    if importlib.util.find_spec("xlsxwriter") is None:
        raise SettingsError("Excel workbooks need an extra: pip install 'proxemetry[xlsx]'")
    import xlsxwriter

    # Rows go to temporary files: a million take little more memory than a thousand. Nothing is taken for a formula.
    options = {"constant_memory": True, "strings_to_formulas": False, "strings_to_urls": False}
    # Zipped in memory: on a full disk the zip file would complain again when it is thrown away.
    zipped = io.BytesIO()
    with target.writing(XLSX_FILE) as temporary:
        with xlsxwriter.Workbook(zipped, options) as book:
            bold = book.add_format({"bold": True})
            for table, names, rows in tables:
                _fill(book.add_worksheet(table), names, rows, bold)
        with open(temporary, "wb") as file:
            file.write(zipped.getbuffer())
    return XLSX_FILE


def _fill(sheet: Any, names: Sequence[str], rows: Iterator[Sequence[Any]], bold: Any) -> None:
    sheet.freeze_panes(1, 0)
    sheet.write_row(0, 0, names, bold)
    for number, row in enumerate(rows, start=1):
        if number >= _SHEET_ROWS:
            raise SettingsError(
                f"{sheet.get_name()}: more than {_SHEET_ROWS - 1:,} rows, which no sheet holds: use the CSV or Parquet"
            )
        for column, value in enumerate(row):
            if value is not None:
                sheet.write(number, column, value)


def _tables(results: Results, safe_distance_m: float | None) -> Iterator[Table]:
    """Yield each table, corrections applied."""
    duck = results.view()
    attributes = attributes_in(duck)
    for table, columns in all_columns(attributes).items():
        cursor = duck.execute(table_query(table, safe_distance_m, attributes))
        yield table, [c.name for c in columns], rows_of(cursor)


def rows_of(cursor: Any) -> Iterator[Sequence[Any]]:
    """Yield the rows of a query, so many at once."""
    while rows := cursor.fetchmany(_ROWS_AT_ONCE):
        yield from rows
