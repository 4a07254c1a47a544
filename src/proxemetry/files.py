"""Reading the files that a user names or that lie in a folder: regular files alone, and JSON that holds no surprise.

A pipe, a device or a socket may bear any name, be linked to, and be waited for without end.
"""

from __future__ import annotations

import codecs
import errno
import hashlib
import io
import json
import math
import os
import re
import stat
from collections.abc import Mapping
from io import BufferedReader
from pathlib import Path
from typing import Any, cast

#: What a file may be instead of a file; the kinds of `stat`.
_KINDS = {
    stat.S_IFIFO: "a pipe", stat.S_IFSOCK: "a socket", stat.S_IFCHR: "a device", stat.S_IFBLK: "a device",
    stat.S_IFDIR: "a folder",
}  # fmt: skip
#: What a spreadsheet takes for the beginning of a formula; also as SQL has it.
FORMULA = r"^'*[=+\-@\t\r]"
_FORMULA = re.compile(FORMULA)
_UTF_16_MARKS = (codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)
#: Longer whole numbers are beyond what a float holds.
_MOST_DIGITS = 300
_SPELLED = re.compile(r"\\(x(?:[89a-f][0-9a-f]|5c))")
_HALF_OF_A_PAIR = re.compile(r"\\u[dD][89abAB]|\\u[dD][c-fC-F]|[\ud800-\udfff]")


def open_file(path: str | Path) -> BufferedReader:
    """Open a regular file to read; raises OSError, whose `strerror` names what else it is."""
    require_file(path)
    # What was put in its place in the meantime is not waited for either.
    descriptor = os.open(path, os.O_RDONLY | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_BINARY", 0))
    try:
        _require_regular(os.fstat(descriptor), path)
        return os.fdopen(descriptor, "rb")
    except BaseException:
        os.close(descriptor)
        raise


def require_file(path: str | Path) -> None:
    """Raise OSError where there is no file, or something else than one; opening some devices alone does harm."""
    try:
        found = os.stat(path)  # noqa: PTH116 - a million times in a large archive
    except OSError as error:
        if os.path.islink(path):  # noqa: PTH114
            raise OSError(error.errno, "is a link that leads to no file", str(path)) from error
        raise
    _require_regular(found, path)


def _require_regular(found: os.stat_result, path: str | Path) -> None:
    if not stat.S_ISREG(found.st_mode):
        kind = _KINDS.get(stat.S_IFMT(found.st_mode), "something else")
        raise OSError(errno.EINVAL, f"is {kind}, not a file", str(path))


def is_file(path: str | Path) -> bool:
    """Return whether there is a regular file, whatever else there is instead."""
    try:
        require_file(path)
    except (OSError, ValueError):
        return False
    return True


def read_bytes(path: str | Path) -> bytes:
    """Return a regular file's content; raises OSError."""
    with open_file(path) as file:
        return file.read()


def read_text(path: str | Path) -> str:
    """Return a regular file's text: UTF-8 with or without a mark, or UTF-16 with one, as Windows writes it.

    Raises OSError, or ValueError for other bytes.
    """
    content = read_bytes(path)
    return content.decode("utf-16" if content.startswith(_UTF_16_MARKS) else "utf-8-sig")


def csv_lines(text: str) -> list[str]:
    """Return a CSV text's lines with their ends. What else `str.splitlines` takes for an end stays in its cell.

    Captions hold such signs: layout programs write a vertical tab or U+2028 for a line break.
    """
    return list(io.StringIO(text, newline=""))


def sha256_of(path: str | Path) -> str:
    """Return a regular file's SHA-256 in hexadecimal; raises OSError."""
    with open_file(path) as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def read_json(path: str | Path) -> Any:
    """Return what a JSON file holds; raises OSError where it cannot be read, ValueError where `parse_json` does."""
    return parse_json(read_text(path))


def parse_json(text: str, *, finite: bool = False) -> Any:
    """Return what a JSON text holds. Whole numbers beyond what a float holds are infinite; with `finite` none may be.

    Raises ValueError for what is no JSON, for nesting beyond any real file, and for halves of characters, which no file
    can be called by and no table can hold.
    """
    try:
        content = json.loads(text, parse_int=_whole, parse_constant=_refused if finite else None)
    except RecursionError:
        raise ValueError("nested too deep") from None
    if _HALF_OF_A_PAIR.search(text):
        require_whole_characters(content)
    return content


def _refused(name: str) -> float:
    raise ValueError(f"{name} is not a number")


def _whole(digits: str) -> int | float:
    return int(digits) if len(digits) <= _MOST_DIGITS else math.copysign(math.inf, float(digits))


def require_whole_characters(value: Any) -> None:
    r"""Raise ValueError where a text anywhere in a JSON value has half of a character, as "\ud800" is one."""
    waiting: list[Any] = [value]
    while waiting:
        item = waiting.pop()
        if isinstance(item, str) and not is_whole(item):
            shown = item.encode("ascii", "backslashreplace").decode()
            raise ValueError(f"the text {shown[:60]!r} has half of a character (a lone surrogate)")
        if isinstance(item, Mapping):
            waiting += [*cast("Mapping[Any, Any]", item).keys(), *cast("Mapping[Any, Any]", item).values()]
        elif isinstance(item, list | tuple):
            waiting += cast("list[Any]", item)


def readable_name(name: str) -> str:
    r"""Return a file's name as text: of bytes that are no UTF-8, as old archives have them, \xfc stands for 0xFC.

    A name that spells such a byte out itself has \x5c for its backslash, so that no two names are one.
    """
    if "\\x" in name:
        name = _SPELLED.sub(r"\\x5c\1", name)
    return name if is_whole(name) else os.fsencode(name).decode(errors="backslashreplace")


def is_whole(text: str) -> bool:
    """Return whether a text has no half of a character, so that any file can hold it."""
    try:
        text.encode()
    except UnicodeEncodeError:
        return False
    return True


def cell_of(text: str) -> str:
    """Return a text as a CSV file holds it: with an apostrophe before what a spreadsheet would take for a formula.

    Names, captions and notes come from others, and a cell like =HYPERLINK(...) is run where it is opened. A text that
    begins with apostrophes before such a sign gets one more, so that `text_of` gives back every text.
    """
    return f"'{text}" if _FORMULA.match(text) else text


def text_of(cell: str) -> str:
    """Return the text that `cell_of` wrote."""
    return cell[1:] if cell.startswith("'") and _FORMULA.match(cell) else cell


def reason_of(error: Exception) -> str:
    """Return why a file could not be read, for a message that names it already."""
    if not isinstance(error, OSError) or error.strerror is None:
        return str(error)
    absent = isinstance(error, FileNotFoundError) and error.strerror == os.strerror(errno.ENOENT)
    return "no such file" if absent else error.strerror
