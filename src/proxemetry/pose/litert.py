"""Loading a network with LiteRT: one interpreter for each thread that runs it."""

from __future__ import annotations

import os
import sys
import threading
from collections.abc import Generator
from contextlib import contextmanager
from typing import Any

from ..errors import ModelError

_LOADING = threading.Lock()


def interpreter(content: bytes, threads: int, name: str) -> Any:
    """Return an interpreter of a TensorFlow Lite file, ready to run; not for several threads at once.

    name: the file's, for the message. Raises ModelError where LiteRT cannot load it.
    """
    from ai_edge_litert.interpreter import Interpreter  # type: ignore[import-untyped]

    try:
        with _LOADING, _without_banner():
            loaded = Interpreter(model_content=content, num_threads=threads)
            loaded.allocate_tensors()
    except (ValueError, RuntimeError) as error:
        raise ModelError(f"{name}: LiteRT cannot load it ({str(error).splitlines()[0]})") from error
    return loaded


@contextmanager
def _without_banner() -> Generator[None, None, None]:
    """Keep the line that the runtime's C++ writes on loading out of the user's terminal."""
    try:
        sys.stderr.flush()
        kept = os.dup(2)
    except (OSError, ValueError, AttributeError):  # no standard error to protect
        yield
        return
    silent = os.open(os.devnull, os.O_WRONLY)
    try:
        os.dup2(silent, 2)
        yield
    finally:
        os.dup2(kept, 2)
        os.close(kept)
        os.close(silent)
