"""Where a page finds a photo and its overlay: addresses relative to the page, so that they hold when both move."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path
from urllib.parse import quote

from ..archive.store.folder import is_url, overlay_name
from ..archive.store.results import Results


@dataclass(frozen=True)
class Links:
    """Addresses of one photo, None where there is no such file: its figure in the page, its overlay, the photo."""

    figure: str | None = None
    overlay: str | None = None
    photo: str | None = None


def links_of(results: Results, photo: str, page: Path, figures: list[str]) -> Links:
    """Return a photo's addresses as seen from a page; figures: the photos whose figures are in it, in order."""
    location = results.location(photo)
    overlay = Path(results.folder.location, overlay_name(photo))
    return Links(
        f"#{figure_id(figures.index(photo))}" if photo in figures else None,
        _relative(overlay, page),
        None if location is None or is_url(location) else _relative(Path(location), page),
    )


def figure_id(number: int) -> str:
    """Return the name of a figure's place in the page."""
    return f"figure-{number + 1}"


def _relative(file: Path, page: Path) -> str | None:
    """Return a file's address seen from a page; None where it is not there, or on another drive."""
    if not file.is_file():
        return None
    try:
        return quote(Path(os.path.relpath(file, page.resolve().parent)).as_posix())
    except ValueError:
        return None
