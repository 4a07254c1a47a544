"""Beginning a run in a results folder, or joining the one that is there."""

from __future__ import annotations

import json
import platform
from collections.abc import Collection
from importlib.metadata import PackageNotFoundError, version
from typing import Any

from ..store import parts
from ..store.folder import RUN_FILE, Folder
from ..store.identity import Identity, require_same
from ..store.results import Results
from .work import Job

#: Packages of which another version may decode, detect or know lenses otherwise; `run.json` names them.
_THAT_CHANGE_NUMBERS = (
    "numpy", "pillow", "pi-heif", "rawpy", "lensfunpy", "duckdb", "ai-edge-litert", "onnxruntime",
    "opencv-python-headless",
)  # fmt: skip


def settings_of(job: Job) -> dict[str, Any]:
    """Return every setting that changes a number, as JSON values; what only changes the speed is not among them."""
    options = job.options
    return {
        **job.settings.to_dict(), "effort": options.effort, "device": options.device, "flip": options.flip,
        "with_names": job.with_names, "with_gps": job.with_gps,
    }  # fmt: skip


def join(folder: Folder, identity: Identity, there: Collection[int]) -> None:
    """Begin a run, or make sure that what is there was made the same way; raises OutputError where it was not.

    All parts of a folder are of the run that its `run.json` describes, so that checking the first and the last is
    enough; without it every part is asked.
    """
    in_order = sorted(there)
    fields = {
        "schema": "proxemetry.run/1",
        "version": identity.version,
        "pose": identity.pose,
        "models": dict(identity.models),
        "settings": dict(identity.settings),
        "metadata": identity.metadata(),
        "python": platform.python_version(),
        "platform": f"{platform.system()} {platform.machine()}",
        "packages": _packages(),
    }
    if folder.create(RUN_FILE, (json.dumps(fields, indent=2) + "\n").encode()):
        before = [identity.metadata()]
    else:
        before = [Results(folder).run.get("metadata", {})]
        in_order = sorted({*in_order[:1], *in_order[-1:]})
    for other in (*before, *parts.metadata_of(folder, in_order)):
        require_same(identity, other, folder.location)


def _packages() -> dict[str, str]:
    found: dict[str, str] = {}
    for package in _THAT_CHANGE_NUMBERS:
        try:
            found[package] = version(package)
        except PackageNotFoundError:
            continue
    return found
