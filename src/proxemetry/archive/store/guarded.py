"""A results folder's DuckDB, whose errors name the file that is damaged."""

from __future__ import annotations

from typing import Any

from .damage import explained
from .folder import Folder


class Guarded:
    """DuckDB's connection, or a cursor, on a results folder: what it raises names the file that is damaged."""

    def __init__(self, duck: Any, folder: Folder) -> None:
        self._duck, self._folder = duck, folder

    def execute(self, query: str, parameters: Any = None) -> Guarded:
        """Run a query; the answer is fetched from what comes back."""
        with explained(self._folder):
            self._duck.execute(query, parameters)
        return self

    def _fetched(self, method: str, *arguments: Any) -> Any:
        with explained(self._folder):
            return getattr(self._duck, method)(*arguments)

    def fetchone(self) -> Any:
        """Return the next row, None after the last."""
        return self._fetched("fetchone")

    def fetchall(self) -> list[Any]:
        """Return the rows that are left."""
        return self._fetched("fetchall")

    def fetchmany(self, size: int) -> list[Any]:
        """Return some more rows."""
        return self._fetched("fetchmany", size)

    def fetchdf(self) -> Any:
        """Return the rows as a pandas data frame."""
        return self._fetched("df")

    def fetchnumpy(self) -> dict[str, Any]:
        """Return the columns as arrays."""
        return self._fetched("fetchnumpy")

    def fetch_df_chunk(self, vectors: int) -> Any:
        """Return some more rows as a data frame."""
        return self._fetched("fetch_df_chunk", vectors)

    @property
    def description(self) -> Any:
        """The columns of the answer."""
        return self._duck.description

    def cursor(self) -> Guarded:
        """Return another connection to the same database: a thread needs one of its own."""
        return Guarded(self._duck.cursor(), self._folder)

    def register(self, name: str, columns: Any) -> None:
        """Make arrays a table of that name."""
        self._duck.register(name, columns)
