"""Worker processes that end when the one that started them is gone.

A module of its own: the watching thread lives until the interpreter is torn down, and all that its module names with
it; a database among that would be reported as leaked.
"""

from __future__ import annotations

import multiprocessing
import os
import threading


def end_with_parent() -> None:
    """End this process when the one that started it is gone, killed for instance: nothing else would."""
    parent = multiprocessing.parent_process()
    if parent is not None:

        def watch() -> None:
            parent.join()
            os._exit(1)

        threading.Thread(target=watch, daemon=True).start()
