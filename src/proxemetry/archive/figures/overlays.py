"""A figure for every photo of a results folder: the photo with people and distances next to the view from above."""

from __future__ import annotations

import importlib.util
import os
from collections.abc import Callable, Iterator
from functools import partial
from itertools import islice
from pathlib import Path

from ...errors import PhotoError, SettingsError
from ...photo import Photo
from ...scene import Scene
from ..run.interrupts import WorkerProcesses
from ..store.folder import is_url, overlay_name
from ..store.removal import forget_overlays
from ..store.results import Results
from ..store.run_file import write_run

_BATCH = 16
#: In run.json: how the drawings show heads.
_FACES = "overlay_faces"


def require_plotting(results: str) -> None:
    """Raise SettingsError where figures cannot be drawn: matplotlib is missing or the results are behind a URL."""
    if importlib.util.find_spec("matplotlib") is None:
        raise SettingsError("--overlays needs matplotlib: pip install 'proxemetry[plot]'")
    if is_url(results):
        raise SettingsError(f"--overlays writes to a local folder only, not to {results}")


def draw(
    results: Results, *, faces: str = "show", jobs: int = 1, on_drawn: Callable[[int], None] = lambda _: None
) -> None:
    """Draw the overlays that are missing or whose scene was touched; on_drawn: called with how many more are done.

    If they show heads otherwise than `faces` asks for, all of them are redrawn: one face left visible is one too
    many.
    """
    root = Path(results.folder.location)
    if results.run.get(_FACES) != faces:
        forget_overlays(results.folder)
        write_run(results.folder, {**results.run, _FACES: faces})
    touched = results.touched()
    for photo, scene in results.corrected().items():
        if scene.status == "excluded":
            results.folder.remove(overlay_name(photo))
    wanted = (
        (scene.to_json(), results.location(scene.photo))
        for scene in results.scenes()
        if scene.status in ("ok", "no_camera")
        and (scene.photo in touched or not (root / overlay_name(scene.photo)).exists())
    )
    work = partial(_draw_batch, str(root), faces)
    if jobs <= 1:
        for batch in _batches(wanted):
            on_drawn(work(batch))
        return
    with WorkerProcesses(jobs) as pool:
        for drawn in pool.map(work, _batches(wanted)):
            on_drawn(drawn)


def _batches(rows: Iterator[tuple[str, str | None]]) -> Iterator[list[tuple[str, str | None]]]:
    while batch := list(islice(rows, _BATCH)):
        yield batch


def _draw_batch(root: str, faces: str, batch: list[tuple[str, str | None]]) -> int:
    for text, location in batch:
        _draw_one(root, faces, Scene.from_json(text), location)
    return len(batch)


def _draw_one(root: str, faces: str, scene: Scene, location: str | None) -> None:
    from ...plots import overlay, save

    path = Path(root, overlay_name(scene.photo))
    path.parent.mkdir(parents=True, exist_ok=True)
    photo = None
    try:
        if location is not None and os.path.exists(location):
            photo = Photo.open(location, scene.photo)
            if photo.sha256 != scene.sha256:  # its heads would not be where those of the measured one are pixelated
                photo = None
        figure = overlay(scene, photo, faces=faces)
    except PhotoError:  # it went bad since it was measured: its row stays
        figure = overlay(scene, None)
    save(figure, path)
