"""What `--same-camera` found out about each shoot of a run, in words, as the run wrote it down."""

from __future__ import annotations

from typing import Any, cast

from ...files import parse_json
from ..store.folder import CAMERAS_FILE, Folder


def shoots_in_words(folder: Folder) -> list[str]:
    """Return a sentence for each size of photos that was asked about; none where nothing was, or it cannot be read."""
    content = folder.read(CAMERAS_FILE)
    if content is None:
        return []
    try:
        fields = cast("dict[str, Any]", parse_json(content.decode()))
        return [str(shoot["said"]) for shoot in fields["shoots"]]
    except (ValueError, KeyError, TypeError):
        return []
