"""The current tables of a results folder, rewritten where they are out of date; readers of tables ask here."""

from __future__ import annotations

import logging
from collections.abc import Generator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass

from ...errors import OutputError
from . import manifest
from .folder import Folder
from .results import Results
from .scratch import scratch_folder

#: Photos whose tables are not written in a moment.
MANY = 50_000


@dataclass(frozen=True)
class CurrentTables:
    """folder: that the tables lie in. damaged: the parts of the results whose photos have no numbers in them."""

    folder: Folder
    damaged: tuple[str, ...] = ()


@contextmanager
def current_tables(
    results: Results, *, elsewhere: bool = True, formats: Sequence[str] = ("parquet",)
) -> Generator[CurrentTables]:
    """Yield the tables with corrections and every column of this version in them.

    Those of a run that is not finished are as they are. elsewhere: where the results cannot be written to any more, the
    tables are in a folder that does not stay, in these `formats`.
    """
    safe_distance_m = results.run.get("safe_distance_m")
    if results.tables_are_current(safe_distance_m):
        yield CurrentTables(results.folder)
        return
    if not results.is_finished:
        yield CurrentTables(results.folder, results.damaged_in_tables())
        return
    listed = manifest.read(results.folder)
    if listed is not None and len(listed) > MANY:
        logging.getLogger("proxemetry").warning(
            f"{results.folder.location}: rewriting the tables, since the results, their corrections or the version "
            "have changed; a million photos take minutes"
        )
    try:
        damaged = results.write_tables(safe_distance_m)
    except OutputError:
        if not elsewhere:
            raise
        with scratch_folder("tables") as scratch:
            damaged = results.write_tables(safe_distance_m, Folder(scratch), formats)
            yield CurrentTables(Folder(scratch), damaged)
    else:
        yield CurrentTables(results.folder, damaged)
