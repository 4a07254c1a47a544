"""This process's DuckDB, and a results folder in it."""

from __future__ import annotations

import tempfile
from functools import cache
from typing import Any

from .folder import Folder
from .guarded import Guarded
from .scratch import scratch_name
from .signals import answered_afterwards


@cache
def connection(threads: int | None = 1) -> Any:
    """Return this process's DuckDB: with one thread, since whatever runs in parallel runs as processes, or with all."""
    with answered_afterwards():
        import duckdb

    # It loads and fetches nothing by itself, and what does not fit into memory does not go into the working folder.
    config: dict[str, Any] = {
        "autoinstall_known_extensions": False,
        "autoload_known_extensions": False,
        "temp_directory": f"{tempfile.gettempdir()}/{scratch_name('tables')}",
    }
    return duckdb.connect(config=config if threads is None else {**config, "threads": threads})


def attached(folder: Folder, threads: int | None = 1) -> Guarded:
    """Return a cursor of this process's DuckDB, able to read the folder; what it raises names what is damaged there.

    It is the caller's own, since DuckDB refuses two threads on one: the review page answers several requests at a time.
    """
    connected = connection(threads)
    if folder.filesystem is not None and not connected.filesystem_is_registered(folder.location.partition("://")[0]):
        connected.register_filesystem(folder.filesystem)
    return Guarded(connected.cursor(), folder)


def named(name: str) -> str:
    """Return a column's name as an SQL identifier, whatever signs it has."""
    return '"' + name.replace('"', '""') + '"'


def quoted(text: str) -> str:
    """Return a text as an SQL literal."""
    return "'" + text.replace("'", "''") + "'"
