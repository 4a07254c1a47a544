"""Undo and redo over an append-only log: both are entries, and what is in force follows from all of them."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from ..archive.review.actions import Action

UNDO, REDO = "undo", "redo"
#: What the program does by itself: it stays, whatever is taken back around it.
PROPOSE = "propose"


@dataclass(frozen=True)
class History:
    """Entries in force, in their order; the action that an undo takes back and the one that a redo brings back."""

    in_force: tuple[Action, ...]
    undoable: Action | None
    redoable: Action | None


def history(entries: Iterable[Action]) -> History:
    """Return what is in force. An action after an undo forgets what could be brought back, as in any editor."""
    kept: list[Action] = []
    done: list[Action] = []
    undone: list[Action] = []
    for entry in entries:
        if entry.action == UNDO:
            if done:
                undone.append(done.pop())
                kept.remove(undone[-1])
        elif entry.action == REDO:
            if undone:
                done.append(undone.pop())
                kept.append(done[-1])
        else:
            kept.append(entry)
            if entry.action != PROPOSE:
                done.append(entry)
                undone.clear()
    return History(tuple(kept), done[-1] if done else None, undone[-1] if undone else None)
