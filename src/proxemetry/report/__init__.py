"""One self-contained page on a results folder: to read, to print, to send."""

from __future__ import annotations

import base64
import io
from dataclasses import dataclass
from pathlib import Path

from .. import plots
from ..archive.figures.methods import methods_paragraph
from ..archive.store.current_tables import current_tables
from ..archive.store.folder import Folder, is_url
from ..archive.store.results import Results
from ..errors import ProxemetryError, SettingsError
from ..people.attributes import PairsWhere
from ..photo import Photo
from ..plots.faces import FACES
from ..scene import Scene
from .links import links_of
from .numbers import count
from .page import page

__all__ = ["FILE", "Report", "write_report"]

#: Name of the report in a results folder.
FILE = "report.html"

_DPI = 110


@dataclass(frozen=True)
class Report:
    """path: of the page. damaged: the parts of the results whose photos have no numbers or figures in it."""

    path: Path
    damaged: tuple[str, ...] = ()


def write_report(
    location: str | Path,
    out: str | Path | None = None,
    *,
    faces: str = "blur",
    group_by: str = "folder",
    photos: int = 6,
    listed: int = 15,
    where: PairsWhere | None = None,
) -> Report:
    """Write the report of a results folder, as `report.html` in the folder where `out` is None.

    The folder's tables are rewritten first, so that corrections are in. faces: "blur" pixelates the heads of people who
    were found. group_by: year, month, folder or a column of the photos table. photos: how many figures; listed: how
    many of the nearest and least certain pairs. where: only people with these attributes count, and pairs of two such
    people. Raises OutputError where there are no results or the page cannot be written, SettingsError for options.
    """
    if faces not in FACES:
        raise SettingsError(f"--faces {faces!r} is unknown: use one of {', '.join(FACES)}")
    if is_url(str(location)):
        raise SettingsError(f"{location}: a report needs a results folder on this machine; copy it here first")
    results = Results.open(location)
    results.require_finished()
    run = results.run
    with current_tables(results, elsewhere=out is not None) as tables:
        numbers = count(tables.folder, group_by, photos, listed, where)
        methods = methods_paragraph(run, tables.folder, where)
    figures = [
        (scene.photo, _data_url(scene, results.location(scene.photo), faces))
        for scene in results.scenes(numbers.sample)
        if scene.status == "ok"
    ]
    title = f"Distances in {Path(results.folder.location).name}"
    path = Path(out) if out is not None else Path(results.folder.location) / FILE
    named = {pair.photo for pair in (*numbers.nearest_pairs, *numbers.uncertain_pairs)}
    links = {photo: links_of(results, photo, path, [name for name, _ in figures]) for photo in named}
    text = page(run, numbers, figures, links, methods, title=title, faces=faces, group_by=group_by, where=where)
    Folder(path.parent).write(path.name, text.encode())
    return Report(path, tuple(sorted({*tables.damaged, *results.usable(numbers.sample).damaged})))


def _data_url(scene: Scene, location: str | None, faces: str) -> str:
    """Return a photo's figure as a JPEG inside a URL; where the photo is gone, what was found in it."""
    photo = None
    if location is not None and not is_url(location):
        try:
            photo = Photo.open(location, scene.photo)
            photo = photo if photo.sha256 == scene.sha256 else None
        except ProxemetryError:
            photo = None
    buffer = io.BytesIO()
    figure = plots.overlay(scene, photo, faces=faces)
    plots.render(figure, buffer, format="jpeg", dpi=_DPI, pil_kwargs={"quality": 84})
    return f"data:image/jpeg;base64,{base64.b64encode(buffer.getvalue()).decode()}"
