"""A log of what a person did: append-only, in one file, on the disk before the answer is shown.

Nothing is ever changed or deleted, taking an action back is an entry too, and the database itself refuses anything
else.
"""

from __future__ import annotations

import json
import os
import sqlite3
import threading
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from ...errors import OutputError, SettingsError
from ...files import reason_of, require_file
from ...scene import Scene
from .actions import Action

_SCHEMA = """
CREATE TABLE IF NOT EXISTS actions (
    number INTEGER PRIMARY KEY AUTOINCREMENT,
    time TEXT NOT NULL,
    who TEXT NOT NULL,
    photo TEXT NOT NULL,
    sha256 TEXT NOT NULL,
    action TEXT NOT NULL,
    value TEXT NOT NULL
);
CREATE INDEX IF NOT EXISTS actions_of_a_file ON actions (sha256, photo);
CREATE TRIGGER IF NOT EXISTS nothing_changes BEFORE UPDATE ON actions
    BEGIN SELECT RAISE(ABORT, 'entries are append-only'); END;
CREATE TRIGGER IF NOT EXISTS nothing_goes BEFORE DELETE ON actions
    BEGIN SELECT RAISE(ABORT, 'entries are append-only'); END;
"""
_COLUMNS = "number, time, who, photo, sha256, action, value"


@dataclass(frozen=True)
class FileKey:
    """What a correction belongs to: the file's hash, or the photo's name where there was no file to hash."""

    sha256: str
    photo: str

    @classmethod
    def of(cls, item: Scene | Action) -> FileKey:
        """Return the key of a scene or of an action."""
        return cls(item.sha256, "" if item.sha256 else item.photo)


class ActionLog:
    """The log at `path` (":memory:" keeps none), created where it is absent; holds a database connection.

    read_only: nothing is created or kept, as on a disk that cannot be written.

    Raises OutputError where the file cannot be written or is no such log.
    """

    what = "actions"

    def __init__(self, path: str | Path, *, read_only: bool = False) -> None:
        self.path, self._read_only = str(path), read_only
        self._lock = threading.Lock()
        try:
            if self.path != ":memory:" and os.path.lexists(self.path):
                require_file(self.path)  # a pipe would be waited for
            self._database = self._opened()
            self._database.execute(f"SELECT {_COLUMNS} FROM actions LIMIT 1")
            # What another program wrote need not be UTF-8.
            self._database.text_factory = lambda content: content.decode(errors="replace")
        except (sqlite3.Error, OSError, ValueError) as error:  # a damaged schema need not be text, nor its error
            why = reason_of(error)
            raise OutputError(f"{self.path}: cannot be used as a log of {self.what} ({why})") from error

    def _opened(self) -> sqlite3.Connection:
        """Return the database, with its table; a log that may only be read and is not there is an empty one."""
        if self._read_only and os.path.lexists(self.path):
            address = f"{Path(self.path).absolute().as_uri()}?mode=ro"
            return sqlite3.connect(address, uri=True, check_same_thread=False, isolation_level=None)
        database = sqlite3.connect(
            ":memory:" if self._read_only else self.path, check_same_thread=False, isolation_level=None
        )
        # All in one file, whatever ends the program: people copy it, and keep it on shared drives.
        database.execute("PRAGMA journal_mode = DELETE")
        database.execute("PRAGMA synchronous = FULL")  # an entry is on the disk before its answer is shown
        database.executescript(_SCHEMA)
        return database

    def keep(self, draft: Action) -> Action:
        """Append a checked action and return it with its number; raises OutputError, or SettingsError for no JSON."""
        if self._read_only:
            raise OutputError(f"{self.path}: cannot be written; copy its folder elsewhere to write there")
        try:
            value = json.dumps(dict(draft.value), sort_keys=True, allow_nan=False)
        except (TypeError, ValueError, RecursionError) as error:
            raise SettingsError(f"{draft.action}: cannot be stored in the log ({error})") from error
        row = (draft.time, draft.who, draft.photo, draft.sha256, draft.action, value)
        try:
            with self._lock:
                cursor = self._database.execute(
                    "INSERT INTO actions (time, who, photo, sha256, action, value) VALUES (?, ?, ?, ?, ?, ?)", row
                )
        except sqlite3.Error as error:
            raise OutputError(f"{self.path}: the entry was not kept ({error})") from error
        return replace(draft, number=int(cursor.lastrowid or 0))

    def actions(self, key: FileKey | None = None, who: str | None = None) -> list[Action]:
        """Return the log in its order: of one file, of one person, or all of it."""
        query, values = f"SELECT {_COLUMNS} FROM actions WHERE 1", list[str]()
        if key is not None:
            query += " AND sha256 = ?" + ("" if key.sha256 else " AND photo = ?")
            values += [key.sha256] if key.sha256 else ["", key.photo]
        if who is not None:
            query += " AND who = ?"
            values.append(who)
        return [_action(row) for row in self._rows(f"{query} ORDER BY number", values)]

    def people(self) -> list[str]:
        """Return who wrote in the log."""
        return [str(row[0]) for row in self._rows("SELECT DISTINCT who FROM actions ORDER BY who", [])]

    def _rows(self, query: str, values: Sequence[str]) -> list[tuple[Any, ...]]:
        try:
            with self._lock:
                return self._database.execute(query, values).fetchall()
        except (sqlite3.Error, ValueError) as error:
            raise OutputError(f"{self.path}: damaged ({error}); put back a copy of it, or move it away") from error

    def close(self) -> None:
        """Close the database."""
        with self._lock:
            self._database.close()


def _action(row: tuple[Any, ...]) -> Action:
    """Return a row of the log as an action; a value that is no JSON object is empty, and cannot be applied."""
    number, *texts, value = row
    try:
        content = json.loads(value)
    except (TypeError, ValueError, RecursionError):
        content = None
    time, who, photo, sha256, action = (str(text) for text in texts)
    return Action(int(number), time, who, photo, sha256, action, content if isinstance(content, dict) else {})
