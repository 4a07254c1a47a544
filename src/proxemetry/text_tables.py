"""Tables of text that fit a width: columns in groups that stay together, in as many blocks as the width needs."""

from __future__ import annotations

import shutil
from collections.abc import Sequence
from dataclasses import dataclass

#: Columns of a terminal of unknown width, and of files.
WIDTH = 100
_BETWEEN, _BETWEEN_GROUPS = "  ", "   "


@dataclass(frozen=True)
class Columns:
    """Columns that stay together: their title above them ("" for none), their headings, and a tuple of cells a row."""

    title: str
    heads: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]

    def lines(self, *, left: bool = False) -> list[str]:
        """Return the title, the headings and the rows, all of the same width; left: words, not numbers."""
        widths = [max(map(len, column)) for column in zip(self.heads, *self.rows, strict=True)]
        extra = len(self.title) - len(_BETWEEN.join(" " * w for w in widths))
        if extra > 0:
            widths[-1] += extra
        cells = [
            _BETWEEN.join(text.ljust(w) if left else text.rjust(w) for text, w in zip(row, widths, strict=True))
            for row in (self.heads, *self.rows)
        ]
        return [self.title.center(len(cells[0])), *cells]


def terminal_width() -> int:
    """Return how many columns the terminal has, `WIDTH` where output goes to a file."""
    return max(shutil.get_terminal_size((WIDTH, 24)).columns, 60)


def in_blocks(keys: Columns, groups: Sequence[Columns], width: int = WIDTH) -> list[str]:
    """Return the lines of a table: the key columns with as many groups as fit next to them, the rest in further blocks.

    A group that is wider than the width stands alone. No line has trailing spaces, none is there for missing titles.
    """
    first = keys.lines(left=True)
    blocks: list[list[str]] = []
    room = 0
    for group in groups:
        lines = group.lines()
        needed = len(_BETWEEN_GROUPS) + len(lines[0])
        if not blocks or needed > room:
            blocks.append(first)
            room = width - len(first[0])
        blocks[-1] = [before + _BETWEEN_GROUPS + line for before, line in zip(blocks[-1], lines, strict=True)]
        room -= needed
    result: list[str] = []
    for block in blocks or [first]:
        result += [""] if result else []
        result += [line.rstrip() for k, line in enumerate(block) if k or line.strip()]
    return result
