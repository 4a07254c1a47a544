"""The parts of a results folder that can be read, and a row with the reason for each photo of one that cannot."""

from __future__ import annotations

import logging
from collections.abc import Collection
from dataclasses import dataclass
from functools import cache

from ...scene import Scene
from . import manifest, parts
from .damage import damaged_parts, require_whole
from .folder import Folder

_AGAIN = "the same `proxemetry measure` with --repair measures"
#: Why a photo has no results that had some.
REASON = f"its results were damaged after they were written: {_AGAIN} it again"


@dataclass(frozen=True)
class Usable:
    """names: of the parts that can be read. damaged: of the others; left_out: the photos of these, sorted."""

    names: tuple[str, ...]
    damaged: tuple[str, ...] = ()
    left_out: tuple[str, ...] = ()

    def scenes(self) -> list[Scene]:
        """Return the scenes of the photos that are left out: failed, with the reason."""
        return [Scene.failed(photo, REASON) for photo in self.left_out]


def usable_parts(folder: Folder, photos: Collection[str] | None = None) -> Usable:
    """Return which parts can be read, and warn once of those that cannot; of some photos only the parts they are in.

    Raises OutputError where none can be, or the list of photos is gone, which says what was in them.
    """
    names = parts.names_of(folder)
    if photos is not None and (shards := manifest.shards_of(folder, photos)) is not None:
        wanted = set(map(parts.name_of, shards))
        names = [name for name in names if name in wanted]
    damaged = damaged_parts(folder, names)
    if not damaged:
        return Usable(tuple(names))
    listed = manifest.read(folder)
    if listed is None or (photos is None and len(damaged) == len(names)):
        require_whole(folder, damaged)
    assert listed is not None
    lost = [s for s in range(listed.n_shards) if parts.name_of(s) in damaged]
    left_out = sorted(item.photo for shard in lost for item in listed.items(shard))
    _warn(folder.path(damaged[0]), len(damaged) - 1, len(left_out))
    return Usable(tuple(name for name in names if name not in damaged), tuple(damaged), tuple(left_out))


@cache
def _warn(path: str, more: int, photos: int) -> None:
    others = f" and {more} more" if more else ""
    whose, them = ("its 1 photo is", "it") if photos == 1 else (f"{photos} photos are", "them")
    logging.getLogger("proxemetry").warning(
        f"{path}{others}: damaged after it was written: {whose} without results; {_AGAIN} {them} again"
    )
