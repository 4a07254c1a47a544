"""What people corrected by hand: an append-only log beside the results, which no rerun touches.

Each entry says of which file (by its SHA-256), what, by whom and when. Nothing is ever changed or deleted, taking a
correction back is an entry too, and the database itself refuses anything else. Photos are never written to.
"""

from __future__ import annotations

import hashlib
import json
import os
import sqlite3
import threading
from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from ...errors import OutputError, ProxemetryError, SettingsError
from ...files import reason_of, require_file
from ...scene import Scene
from .actions import ACTIONS, Action, check
from .edits import applied, apply

__all__ = ["ACTIONS", "FILE", "Action", "Log", "apply", "corrected_scenes", "in_force"]

#: Name of the log in a results folder.
FILE = "corrections.sqlite"

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
    BEGIN SELECT RAISE(ABORT, 'corrections are append-only'); END;
CREATE TRIGGER IF NOT EXISTS nothing_goes BEFORE DELETE ON actions
    BEGIN SELECT RAISE(ABORT, 'corrections are append-only'); END;
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


class Log:
    """The log at `path` (":memory:" keeps none), created where it is absent; holds a database connection.

    read_only: nothing is created or kept, as on a disk that cannot be written.

    Raises OutputError where the file cannot be written or is no log of corrections.
    """

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
            raise OutputError(f"{self.path}: cannot be used as a log of corrections ({why})") from error

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

    def append(self, scene: Scene, action: str, value: Mapping[str, Any], who: str) -> Action:
        """Append one action on a scene's file and return it; raises SettingsError for one that cannot be applied."""
        return self.keep(self.tried(scene, action, value, who)[0])

    def tried(
        self, scene: Scene, action: str, value: Mapping[str, Any], who: str, before: Sequence[Action] | None = None
    ) -> tuple[Action, Scene]:
        """Return an action that `keep` would append, and the scene that follows: what is kept is kept for good.

        before: the actions in force, those of the log where None. Raises SettingsError where it cannot be applied.
        """
        check(action, value)
        before = in_force(self.actions(FileKey.of(scene))) if before is None else before
        time, number = datetime.now(UTC).isoformat(timespec="seconds"), max((a.number for a in before), default=0) + 1
        draft = Action(number, time, who, scene.photo, scene.sha256, action, dict(value))
        try:
            after = scene if action == "undo" else apply(scene, [*before, draft])
            after.to_json()
        except (ProxemetryError, ValueError, ArithmeticError) as error:
            raise SettingsError(f"correction: {str(error).removeprefix('correction: ')}") from error
        return draft, after

    def keep(self, draft: Action) -> Action:
        """Append an action that was tried and return it with its number; raises OutputError."""
        if self._read_only:
            raise OutputError(f"{self.path}: cannot be written; copy the results folder elsewhere to correct them")
        value = json.dumps(dict(draft.value), sort_keys=True, allow_nan=False)
        row = (draft.time, draft.who, draft.photo, draft.sha256, draft.action, value)
        try:
            with self._lock:
                cursor = self._database.execute(
                    "INSERT INTO actions (time, who, photo, sha256, action, value) VALUES (?, ?, ?, ?, ?, ?)", row
                )
        except sqlite3.Error as error:
            raise OutputError(f"{self.path}: the correction was not kept ({error})") from error
        return replace(draft, number=int(cursor.lastrowid or 0))

    def undo(self, scene: Scene, who: str) -> Action | None:
        """Take back one's own latest action on a scene's file that is in force; return it, None where there is none."""
        mine = [a for a in in_force(self.actions(FileKey.of(scene))) if a.who == who]
        if not mine:
            return None
        self.append(scene, "undo", {"number": mine[-1].number}, who)
        return mine[-1]

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


def in_force(actions: Iterable[Action]) -> list[Action]:
    """Return the actions that nobody took back, without the entries that took others back."""
    listed = list(actions)
    undone = {number for a in listed if a.action == "undo" and isinstance(number := a.value.get("number"), int)}
    return [a for a in listed if a.action != "undo" and a.number not in undone]


def by_file(actions: Iterable[Action]) -> dict[FileKey, list[Action]]:
    """Return the actions of each file, in their order."""
    found: defaultdict[FileKey, list[Action]] = defaultdict(list)
    for action in actions:
        found[FileKey.of(action)].append(action)
    return dict(found)


def digest(location: str | Path) -> str | None:
    """Return the SHA-256 of all entries of a results folder's log, None where nothing was ever corrected."""
    if not os.path.lexists(Path(location) / FILE):
        return None
    log = entries_at(location)
    entries = [repr((a.number, a.time, a.who, a.photo, a.sha256, a.action, a.value)) for a in log]
    return hashlib.sha256("\n".join(entries).encode()).hexdigest()


def entries_at(location: str | Path) -> list[Action]:
    """Return the whole log of a results folder, nothing where there is none."""
    path = Path(location) / FILE
    if not os.path.lexists(path):
        return []
    log = Log(path, read_only=True)
    try:
        return log.actions()
    finally:
        log.close()


def corrected_scenes(
    location: str | Path, scenes: Callable[[Iterable[str], Iterable[str]], Iterator[Scene]]
) -> dict[str, Scene]:
    """Return the scenes of a results folder that a person corrected, by photo, with the corrections applied.

    scenes: yields the measured scenes of photos of these names, and of files with these hashes. A correction follows
    its file: after a rerun that calls the photo otherwise it applies to every photo with that hash.
    """
    wanted = by_file(in_force(entries_at(location)))
    if not wanted:
        return {}
    names, files = ({getattr(key, n) for key in wanted} - {""} for n in ("photo", "sha256"))
    found = (scene for scene in scenes(names, files) if FileKey.of(scene) in wanted)
    return {scene.photo: applied(scene, wanted[FileKey.of(scene)]) for scene in found}
