"""Figures of a scene: the photo with people and distances, and the view from above. Needs the extra `plot`.

matplotlib is loaded when a figure is asked for, and pyplot never: a figure is a value that the caller keeps or saves.
"""

from __future__ import annotations

import importlib.util
import os
from pathlib import Path
from typing import TYPE_CHECKING, Any, BinaryIO

from ..errors import OutputError, PhotoError, SettingsError
from ..photo import Photo
from ..scene import Scene
from .faces import FACES

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["FACES", "FORMATS", "birds_eye", "circles", "overlay", "photo_of", "plan", "render", "save"]

#: File name endings that `save` writes.
FORMATS = (".png", ".jpg", ".jpeg", ".svg", ".pdf")

#: At the default compression, 6, a photo in PNG takes about twice as long, for a file that is 1 to 6 % smaller.
_OPTIONS: dict[str, dict[str, Any]] = {".png": {"pil_kwargs": {"compress_level": 4}}}

#: Wider circles than these are around no person.
_WIDEST_M = 100.0


def overlay(scene: Scene, photo: Photo | None, *, faces: str = "show", all_pairs: bool = False) -> Figure:
    """Return the photo with skeletons, person numbers and labelled distances next to the view from above.

    photo: None draws the people alone (recorded keypoints without photos). faces: "blur" pixelates the heads of all
    people that were found (no others'), "show" leaves them. all_pairs: every pair instead of nearest neighbours.

    The figure's size depends on the photo's shape and not on its pixels, so text reads alike at 600 pixels and at 24
    megapixels. Raises PhotoError where the photo cannot be decoded, SettingsError for an unknown value of `faces`.
    """
    if faces not in FACES:
        raise SettingsError(f"faces {faces!r} is unknown: use one of {', '.join(FACES)}")
    _require_matplotlib()
    from .figure import overlay_figure

    return overlay_figure(scene, photo, faces, all_pairs)


def circles(scene: Scene, photo: Photo | None, *, within_m: float = 2.0, faces: str = "blur") -> Figure:
    """Return the photo with a circle on the floor around each person, coloured by whether two are nearer than a limit.

    Circles have the limit, metres, as their diameter: they touch where two people are nearer, and lines say how
    probable that is. photo, faces: as `overlay` takes them. Where no floor was found they lie at the height of the
    bodies. Raises PhotoError where the photo cannot be decoded, SettingsError for an unknown value of `faces` or an
    impossible limit.
    """
    _check(faces, within_m)
    _require_matplotlib()
    from .floor_figures import circles_figure

    return circles_figure(scene, photo, within_m, faces)


def birds_eye(scene: Scene, photo: Photo | None, *, within_m: float = 2.0, faces: str = "blur") -> Figure:
    """Return the floor as seen from straight above, laid flat out of the photo, with the people and circles on it.

    What stands up is smeared away from the camera; what lies on the floor has its true shape, to a metre grid.
    Without a photo, or where no floor was found, the grid alone. Parameters and errors are those of `circles`.
    """
    _check(faces, within_m)
    _require_matplotlib()
    from .floor_figures import birds_eye_figure

    return birds_eye_figure(scene, photo, within_m, faces)


def _require_matplotlib() -> None:
    if importlib.util.find_spec("matplotlib") is None:
        raise SettingsError("figures need matplotlib: pip install 'proxemetry[plot]'")


def _check(faces: str, within_m: float) -> None:
    if faces not in FACES:
        raise SettingsError(f"faces {faces!r} is unknown: use one of {', '.join(FACES)}")
    if not 0 < within_m <= _WIDEST_M:
        raise SettingsError(f"a limit of {within_m:g} m is none: it must be above 0 and at most {_WIDEST_M:g}")


def photo_of(scene: Scene, photo: Photo | str | Path | None) -> Photo | None:
    """Return the photo of a scene: the one given, else the file of the scene's name where it is still the same one.

    Raises PhotoError where the photo given cannot be read or is not the one that was measured.
    """
    if photo is None:
        if not scene.sha256 or not Path(scene.photo).is_file():
            return None
        found = Photo.open(scene.photo)
        return found if found.sha256 == scene.sha256 else None
    opened = photo if isinstance(photo, Photo) else Photo.open(photo)
    if scene.sha256 and opened.sha256 and opened.sha256 != scene.sha256:
        raise PhotoError(f"{opened.name}: not the photo that was measured as {scene.photo}")
    return opened


def plan(scene: Scene, *, all_pairs: bool = False) -> Figure:
    """Return the view from above alone: where people stand with 90 %, their headings, field of view, metre grid."""
    _require_matplotlib()
    from .figure import plan_figure

    return plan_figure(scene, all_pairs)


def save(figure: Figure, path: str | Path, *, dpi: int = 140) -> None:
    """Write a figure as PNG, JPEG, SVG or PDF by the file name's ending; nothing of the photo's metadata goes along.

    A pixel format has `dpi` pixels an inch. Raises SettingsError for another ending, OutputError where the file cannot
    be written.
    """
    path = Path(path)
    if path.suffix.lower() not in FORMATS:
        raise SettingsError(f"{path}: a figure is saved as one of {', '.join(FORMATS)}")
    temporary = path.with_name(f".{os.getpid()}.part{path.suffix}")  # short: the name itself may be as long as can be
    try:
        suffix = path.suffix.lower()
        render(figure, temporary, dpi=dpi, metadata=_metadata(suffix), **_OPTIONS.get(suffix, {}))
        temporary.replace(path)
    except OSError as error:
        temporary.unlink(missing_ok=True)
        raise OutputError(f"{path}: the figure cannot be written ({error.strerror or error})") from error


def render(figure: Figure, target: Path | BinaryIO, **options: Any) -> None:
    """Draw a figure into a file, with matplotlib's options; names may be in letters that its font lacks."""
    from .fonts import known_letters

    with known_letters(figure):
        figure.savefig(target, **options)


def _metadata(suffix: str) -> dict[str, str | None] | None:
    """Return what keeps dates out of the file, so that the same scene gives the same bytes."""
    return {".svg": {"Date": None}, ".pdf": {"CreationDate": None}}.get(suffix)  # pyright: ignore[reportReturnType]
