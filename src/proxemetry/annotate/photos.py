"""The photos to annotate: found, named and hashed once, before the page opens."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from ..archive.store.folder import is_url
from ..archive.store.photos import search
from ..errors import PhotoError, SettingsError
from ..photo import Photo
from .lens import recorded_lens
from .state import Lens


@dataclass(frozen=True, eq=False)
class OwnPhoto:
    """One photo, its name relative to the folder named, and its path."""

    photo: Photo
    name: str
    path: str

    @property
    def sha256(self) -> str:
        """The hash of its file, which annotations go by."""
        return self.photo.sha256

    @property
    def width(self) -> int:
        """Pixels of the upright photo."""
        return self.photo.width

    @property
    def height(self) -> int:
        """Pixels of the upright photo."""
        return self.photo.height

    @cached_property
    def lens(self) -> Lens | None:
        """The lens as the file records it."""
        return recorded_lens(self.photo)

    @property
    def folder(self) -> str:
        """The folder that it lies in, relative to the one named; "" for that itself."""
        return self.name.rpartition("/")[0]

    @property
    def camera(self) -> str:
        """Make and model as the file has them, without repeating the make; "" where it has neither."""
        make, model = self.photo.metadata.make or "", self.photo.metadata.model or ""
        return model if model.lower().startswith(make.lower()) else f"{make} {model}".strip()


def find_own_photos(
    paths: Sequence[str], without: str, on_progress: Callable[[int, int], None] = lambda done, total: None
) -> tuple[list[OwnPhoto], list[str]]:
    """Return the photos of files, folders and globs in the order of their names, and why others are left out.

    without: a folder that is not searched, as what the tool itself writes. Raises SettingsError where there is none.
    """
    if any(map(is_url, paths)):
        raise SettingsError("annotate takes photos on this machine: copy them here first")
    listing = search(paths).listing()
    photos: list[OwnPhoto] = []
    left_out: list[str] = []
    seen: dict[str, str] = {}
    names = [
        n for n in listing.names if not Path(listing.location(n)).resolve().is_relative_to(Path(without).resolve())
    ]
    for k, name in enumerate(names):
        on_progress(k, len(names))
        path = listing.location(name)
        try:
            photo = Photo.open(path, name)
        except PhotoError as error:
            left_out.append(str(error))
            continue
        if len(f"{name} ".splitlines()) > 1 or name != name.strip():
            left_out.append(
                f"{name!r}: rename it, for label files hold one line a point and names without blanks around"
            )
        elif photo.sha256 in seen:
            left_out.append(f"{name}: the same file as {seen[photo.sha256]}")
        else:
            seen[photo.sha256] = name
            photos.append(OwnPhoto(photo, name, path))
    if not photos:
        raise SettingsError(
            f"{', '.join(paths)}: no photo that can be read" + (f" ({left_out[0]})" if left_out else "")
        )
    return photos, left_out
