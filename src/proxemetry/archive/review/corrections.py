"""What people corrected by hand: an append-only log beside the results, which no rerun touches.

Each entry records the file (by its SHA-256), what was corrected, who did it and when. Nothing is ever changed or
deleted, taking a correction back is an entry too, and the database itself refuses anything else. Photos are never
written to.
"""

from __future__ import annotations

import hashlib
import os
from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from ...errors import ProxemetryError, SettingsError
from ...scene import Scene
from .action_log import ActionLog, FileKey
from .actions import ACTIONS, Action, check
from .edits import applied, apply

__all__ = ["ACTIONS", "FILE", "Action", "FileKey", "Log", "apply", "corrected_scenes", "in_force"]

#: Name of the log in a results folder.
FILE = "corrections.sqlite"


class Log(ActionLog):
    """The log of corrections of scenes; see `ActionLog`."""

    what = "corrections"

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

    def undo(self, scene: Scene, who: str) -> Action | None:
        """Take back one's own latest action on a scene's file that is in force; return it, None where there is none."""
        mine = [a for a in in_force(self.actions(FileKey.of(scene))) if a.who == who]
        if not mine:
            return None
        self.append(scene, "undo", {"number": mine[-1].number}, who)
        return mine[-1]


def in_force(actions: Iterable[Action]) -> list[Action]:
    """Return the actions that were not taken back, without the entries that took others back."""
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
