"""Letters that matplotlib's own font lacks, as photos and folders may be called: drawn from another font, or spelled.

An empty box tells nothing. Where no installed font has a letter it is written as Python spells it, as in a terminal
that lacks it.
"""

from __future__ import annotations

import logging
import unicodedata
from collections.abc import Callable, Generator, Sequence
from contextlib import contextmanager, suppress
from functools import cache
from typing import Any

import numpy as np
from matplotlib import font_manager, ft2font
from matplotlib.figure import Figure
from matplotlib.font_manager import FontProperties, findfont, fontManager
from matplotlib.ft2font import FT2Font
from matplotlib.text import Text
from numpy.typing import NDArray

#: Has a box with a sign of the script for every letter, which is a box.
_BOXES = "Last Resort"
_LAST_LETTER = 0x110000
#: Since version 3.11 matplotlib joins Arabic letters and writes them from right to left.
_JOINS_LETTERS = hasattr(ft2font, "__libraqm_version__")
_RIGHT_TO_LEFT = ("R", "AL", "AN")
#: Categories of signs that move to another place or line, or do something else than to be seen.
_CONTROLS = ("Cc", "Zl", "Zp")


def drawable(text: str, families: Sequence[str] = ("DejaVu Sans",)) -> str:
    """Return a text, as one line, in which letters that no font has are spelled: 日 as \\u65e5, a line's end as \\n."""
    return text if text.isascii() and text.isprintable() else "".join(map(_speller(tuple(families)), text))


def without_formulas(text: str) -> str:
    """Return text in which matplotlib sees no formulas: the name of a file or folder may hold dollar signs."""
    return text.replace("$", r"\$")


@contextmanager
def known_letters(figure: Figure) -> Generator[None]:
    """Have a figure drawn in letters that there are, without a word where a font has no bold ones."""
    use_known_letters(figure)
    logger = logging.getLogger("matplotlib.font_manager")
    level = logger.level
    logger.setLevel(logging.ERROR)
    try:
        yield
    finally:
        logger.setLevel(level)


def use_known_letters(figure: Figure) -> None:
    """Give every text of a figure the fonts that have its letters, and spell those that none has.

    Labels along an axis are written anew by the axis: they are to be `drawable` from the start.
    """
    texts: list[Any] = figure.findobj(Text)
    for text in texts:
        if (words := text.get_text()).isascii():
            continue
        properties = text.get_fontproperties()
        families = tuple(properties.get_family())
        spelled = "\n".join(drawable(line, families) for line in words.split("\n"))
        text.set_text(spelled)
        more = dict.fromkeys(name for letter in spelled if (name := _family_of(letter, families)))
        if more:
            text.set_fontfamily([*families, *more])


@cache
def _speller(families: tuple[str, ...]) -> Callable[[str], str]:
    @cache
    def spelled(letter: str) -> str:
        if unicodedata.category(letter) in _CONTROLS:  # some fonts have a glyph for these as well
            return letter.encode("unicode_escape").decode()
        joined = _JOINS_LETTERS or unicodedata.bidirectional(letter) not in _RIGHT_TO_LEFT
        if joined and (_is_in(letter, families) or _family_of(letter, families)):
            return letter
        if unicodedata.category(letter) == "Cf" or "VARIATION SELECTOR" in unicodedata.name(letter, ""):
            return ""  # tells how its neighbours are to be drawn
        return letter.encode("unicode_escape").decode()

    return spelled


@cache
def _is_in(letter: str, families: tuple[str, ...]) -> bool:
    """Return whether the fonts of these families have a letter."""
    return any(ord(letter) in _letters(name) for name in families)


@cache
def _letters(family: str) -> frozenset[int]:
    found = findfont(FontProperties(family=[family]))
    return frozenset(FT2Font(found).get_charmap())


@cache
def _family_of(letter: str, families: tuple[str, ...]) -> str | None:
    """Return an installed family that has a letter, None where none has or these have it."""
    if _is_in(letter, families):
        return None
    place, names = _coverage()
    number = int(place[ord(letter)])
    return names[number - 1] if number else None


@cache
def _coverage() -> tuple[NDArray[np.uint16], list[str]]:
    """Return for every letter the number, from 1, of a family that has it, and the families. Takes a second."""
    _find_new_fonts()
    names: list[str] = []
    place = np.zeros(_LAST_LETTER, dtype=np.uint16)
    for entry in sorted(fontManager.ttflist, key=_unlike_plain_text):
        if entry.name in names or _BOXES in entry.name:
            continue
        with suppress(OSError, RuntimeError, ValueError):  # a file that went, or is no font
            font = FT2Font(entry.fname)
            if font.scalable:
                names.append(entry.name)
                letters = np.fromiter(font.get_charmap(), dtype=np.int64)
                place[letters[place[letters] == 0]] = len(names)
    return place, names


def _unlike_plain_text(entry: Any) -> tuple[bool, ...]:
    """Return what sorts upright letters without serifs first."""
    return (
        "Sans" not in entry.name,
        "Mono" in entry.name,
        entry.style != "normal",
        entry.weight not in (400, "normal"),
    )


def _find_new_fonts() -> None:
    """Add the fonts that were installed after matplotlib listed those that there are."""
    known = {entry.fname for entry in fontManager.ttflist}
    for path in font_manager.findSystemFonts():
        if path not in known:
            with suppress(OSError, RuntimeError, ValueError):
                fontManager.addfont(path)
