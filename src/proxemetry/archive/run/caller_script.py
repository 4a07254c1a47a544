"""Worker processes that leave the caller's script alone.

A spawned process first runs the script of the process that started it, so that a script of three lines that measures a
folder would start itself again in every worker. No worker of ours needs anything that is defined there, unless the
user's own detector is.
"""

from __future__ import annotations

import sys
from collections.abc import Generator
from contextlib import contextmanager
from types import ModuleType

_MAIN = "__main__"


def defines_backend(pose: str) -> bool:
    """Return whether a back end's name speaks of the script itself, as `python:__main__:FUNCTION` does."""
    return _MAIN in pose.replace("+", ":").split(":")


@contextmanager
def script_left_out(needed: bool = False) -> Generator[None]:
    """Have processes that are started meanwhile not run the caller's script, unless it is needed."""
    if needed:
        yield
        return
    script = sys.modules[_MAIN]
    sys.modules[_MAIN] = ModuleType(_MAIN)
    try:
        yield
    finally:
        sys.modules[_MAIN] = script
