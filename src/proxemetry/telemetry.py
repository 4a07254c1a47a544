"""Packages that report to their makers are kept from it, before any of them is imported.

Importing `proxemetry` does this once, in every process: the command line, worker processes, actors on a cluster, and a
user's own back end.
"""

from __future__ import annotations

import os

#: Variable -> its value, and the package that heeds it. docs/privacy.md describes how each package was checked.
OFF: dict[str, str] = {
    "ORT_DISABLE_TELEMETRY": "1",  # ONNX Runtime: device id, machine details and events to its maker
    "RAY_USAGE_STATS_ENABLED": "0",  # Ray: cluster size and libraries used
    "HF_HUB_DISABLE_TELEMETRY": "1",  # Hugging Face Hub, which a user's own back end may import
    "DO_NOT_TRACK": "1",  # the convention of several others
}


def turn_off() -> None:
    """Set every variable of `OFF`, also where the environment has another value: nothing leaves the machine."""
    os.environ.update(OFF)
