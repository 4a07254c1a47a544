"""Temporary folders that hold photos or tables: they go with the program, or, where it was killed, with the next one.

Their names contain the machine and the process that they belong to: a folder for temporary files may be shared.
"""

from __future__ import annotations

import os
import re
import shutil
import socket
import tempfile
from pathlib import Path

_NAMED = re.compile(r"proxemetry-[a-z]+@(?P<host>.+)\+(?P<pid>\d+)-\w*")


def scratch_folder(purpose: str) -> tempfile.TemporaryDirectory[str]:
    """Return a fresh temporary folder of this process, to be used as a context or cleaned up at the end."""
    return tempfile.TemporaryDirectory(prefix=scratch_name(purpose))


def scratch_name(purpose: str) -> str:
    """Return what the name of a temporary folder or file of this process begins with."""
    return f"proxemetry-{purpose}@{socket.gethostname()}+{os.getpid()}-"


def sweep_scratch() -> None:
    """Remove the temporary folders of this machine's processes that are gone, killed before they could."""
    for path in Path(tempfile.gettempdir()).glob("proxemetry-*"):
        found = _NAMED.fullmatch(path.name)
        if found and found["host"] == socket.gethostname() and not is_alive(int(found["pid"])):
            shutil.rmtree(path, ignore_errors=True)  # another account's stays


def is_alive(pid: int) -> bool:
    """Return whether a process of this machine runs; True where the system gives no answer."""
    if os.name != "posix":
        return True
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return False
    except (PermissionError, OverflowError):
        return True
    return True
