"""`run.json`: how the results in a folder were made."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

from ...errors import OutputError
from .folder import RUN_FILE, Folder

#: Schema of the `run.json` of a clip.
CLIP_SCHEMA = "proxemetry.clip/1"


def is_of_clip(folder: Folder) -> bool:
    """Return whether a results folder is a clip's."""
    content = folder.read(RUN_FILE)
    return content is not None and f'"{CLIP_SCHEMA}"'.encode() in content


def require_run(content: Any, path: str) -> dict[str, Any]:
    """Return what `run.json` holds; raises OutputError where it is not what a run writes there."""
    kinds: dict[str, tuple[type, ...]] = {
        "version": (str,), "pose": (str,), "models": (dict,), "settings": (dict,), "metadata": (dict,),
        "photos_in": (str, type(None)), "safe_distance_m": (float, int, type(None)),
    }  # fmt: skip
    fits = isinstance(content, dict) and all(isinstance(content.get(k, None), kinds[k]) for k in kinds if k in content)
    if not fits or not all(isinstance(value, str) for value in content.get("metadata", {}).values()):
        raise OutputError(
            f"{path}: not written by a run; delete it, and repeating `proxemetry measure` writes it again"
        )
    return content


def run_of(folder: Folder) -> dict[str, Any] | None:
    """Return the content of `run.json`, None where there is none; raises OutputError where it is damaged."""
    content = folder.read(RUN_FILE)
    if content is None:
        return None
    try:
        fields = json.loads(content)
    except (ValueError, RecursionError):
        fields = None
    return require_run(fields, folder.path(RUN_FILE))


def write_run(folder: Folder, fields: Mapping[str, Any]) -> None:
    """Write `run.json`."""
    folder.write(RUN_FILE, (json.dumps(fields, indent=2, sort_keys=False) + "\n").encode())
