"""Starting again in a results folder: what a run wrote is removed, and nothing else."""

from __future__ import annotations

import os
from pathlib import Path

from ...tables import TABLES
from . import manifest, parts
from .folder import CAMERAS_FILE, OVERLAYS, RUN_FILE, Folder, is_url
from .results import TABLE_FORMATS


def forget(folder: Folder) -> None:
    """Remove what an earlier run wrote, corrections and anything not ours left alone."""
    for name in parts.names_of(folder):
        folder.remove(name)
    for path in manifest.names(folder):
        folder.remove(path)
    for table in TABLES:
        for form in TABLE_FORMATS:
            folder.remove(f"{table}.{form}")
    folder.remove("codebook.csv")
    folder.remove(CAMERAS_FILE)
    folder.remove(RUN_FILE)
    if not is_url(folder.location):
        folder.sweep(parts.FOLDER, written_once=True)
        forget_overlays(folder)


def forget_overlays(folder: Folder) -> None:
    """Remove the drawings of a local results folder."""
    for where, _, files in os.walk(Path(folder.location) / OVERLAYS):
        for file in files:
            Path(where, file).unlink()
