"""Circles on the floor and the floor from above, drawn for photos of a results folder, corrections applied."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Sequence
from fnmatch import fnmatchcase
from pathlib import Path

from ...errors import OutputError, PhotoError, SettingsError
from ...photo import Photo
from ...scene import Scene
from ..store.folder import is_url, overlay_name
from ..store.results import Results

KINDS = ("circles", "birds-eye")
FOLDER = "figures"


def draw(
    results: Results, out: str | Path | None = None, photos: Sequence[str] = (), *, kinds: Sequence[str] = KINDS,
    within_m: float = 2.0, faces: str = "blur", on_written: Callable[[Path], None] = lambda _: None,
) -> int:  # fmt: skip
    """Draw figures of these kinds for photos of these names or patterns, all without any; return how many.

    They are written to `out`, the folder `figures` of the results where None; `on_written` is called with each. Raises
    SettingsError for an impossible limit and results behind a URL, OutputError where one cannot be written.
    """
    from ... import plots

    if is_url(results.folder.location):
        raise SettingsError(f"{results.folder.location}: figures need a results folder on this machine; copy it here")
    target = Path(out) if out is not None else Path(results.folder.location) / FOLDER
    makers = {"circles": plots.circles, "birds-eye": plots.birds_eye}
    count = 0
    for scene in _chosen(results, photos):
        photo = _photo(scene, results.location(scene.photo))
        for kind in kinds:
            path = target / f"{overlay_name(scene.photo).partition('/')[2]}.{kind}.png"
            try:
                path.parent.mkdir(parents=True, exist_ok=True)
            except OSError as error:
                raise OutputError(f"{path.parent}: cannot be made ({error.strerror})") from error
            try:
                figure = makers[kind](scene, photo, within_m=within_m, faces=faces)
            except PhotoError:  # it went bad since it was measured: its row stays
                figure = makers[kind](scene, None, within_m=within_m, faces=faces)
            plots.save(figure, path)
            on_written(path)
            count += 1
    return count


def _chosen(results: Results, photos: Sequence[str]) -> Iterator[Scene]:
    for scene in results.scenes():
        wanted = not photos or any(scene.photo == name or fnmatchcase(scene.photo, name) for name in photos)
        if wanted and scene.status in ("ok", "no_camera"):
            yield scene


def _photo(scene: Scene, location: str | None) -> Photo | None:
    """Return the photo that was measured, None where it is gone or another one: its heads would lie elsewhere."""
    if location is None or not os.path.exists(location):
        return None
    try:
        photo = Photo.open(location, scene.photo)
    except PhotoError:
        return None
    return photo if photo.sha256 == scene.sha256 else None
