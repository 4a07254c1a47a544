"""Size and date of a photo's file: they show, without reading it, that it may not be the file that was measured."""

from __future__ import annotations

import os
from dataclasses import dataclass
from typing import Any

from .folder import is_url, open_filesystem


@dataclass(frozen=True)
class FileState:
    """A file's size in bytes and its date in nanoseconds since 1970; None for an unknown date, as of URLs."""

    size: int
    modified_ns: int | None

    @classmethod
    def of(cls, location: str | None) -> FileState | None:
        """Return the state of the file at a path or URL, None where there is none that can be looked at."""
        if location is None:
            return None
        try:
            if is_url(location):
                about: dict[str, Any] = open_filesystem(location).info(location)
                return None if about.get("size") is None else cls(int(about["size"]), None)
            found = os.stat(location)
        except OSError:
            return None
        return cls(found.st_size, found.st_mtime_ns)
