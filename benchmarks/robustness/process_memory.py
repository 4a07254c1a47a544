"""The memory of a process, from its own status file: what it holds now and the most it ever held. Linux only.

`getrusage` would also count what the parent held when it started the process, so that a small process started by a
large one looks large.
"""

from __future__ import annotations

from pathlib import Path


def memory_bytes(process: int | str = "self") -> tuple[float, float]:
    """Return what a process holds now and the most it ever held (VmRSS, VmHWM), in bytes."""
    text = Path(f"/proc/{process}/status").read_text()
    lines = dict(line.split(":", 1) for line in text.splitlines())
    now, most = (int(lines[name].split()[0]) * 1024.0 for name in ("VmRSS", "VmHWM"))
    return now, most
