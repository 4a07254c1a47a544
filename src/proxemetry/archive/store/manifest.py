"""The frozen list of a run's photos and the shards they are worked in.

A manifest is written once, before anything is measured, and only read afterwards: whoever joins or resumes a run works
on the same shards. Photos that came later are appended as a further manifest file with shards of its own
(`archive.run.manifest_update`).
Of ten million photos only the shards that are asked for are in memory.
"""

from __future__ import annotations

import json
import os
import re
from collections.abc import Collection, Iterator
from dataclasses import dataclass, field, replace
from typing import Any

from ...errors import OutputError
from .duck import attached
from .folder import Folder, is_url
from .photos import locate

FOLDER = "manifest"
SCHEMA = "proxemetry.manifest/4"
_NAMED = re.compile(r"manifest-\d{3,}\.parquet")

#: Shards are read so many at a time.
_SHARDS_AT_ONCE = 64


@dataclass(frozen=True)
class Item:
    """One photo of a shard. location: path or URL, None where only keypoints are recorded.

    duplicate_of: photos of one shard with the same number may be copies of one file (same size, same end); the column
    is called `twin` in the file. original_shard: an earlier shard that may have measured the same file.
    """

    photo: str
    location: str | None
    duplicate_of: int | None = None
    original_shard: int | None = None


@dataclass(frozen=True)
class Manifest:
    """What a results folder is about: `root` is None where photos are only names. shard_sizes: photos of each shard."""

    folder: Folder = field(compare=False)
    root: str | None
    shard_sizes: tuple[int, ...] = ()
    files: int = 0
    moved_to: str | None = field(default=None, compare=False)
    _read: dict[int, list[Item]] = field(default_factory=dict[int, list[Item]], compare=False, repr=False)

    def __len__(self) -> int:
        return sum(self.shard_sizes)

    @property
    def n_shards(self) -> int:
        """How many shards there are, numbered from 0."""
        return len(self.shard_sizes)

    def moved(self, root: str | None) -> Manifest:
        """Return the same photos, found below another folder now."""
        return replace(self, moved_to=root, _read={})

    def items(self, shard: int) -> tuple[Item, ...]:
        """Return the photos of a shard, in the order of their names."""
        if shard not in self._read:
            self._read.clear()
            self._read.update(self._items(shard, shard + _SHARDS_AT_ONCE))
        return tuple(self._read[shard])

    def _items(self, first: int, end: int) -> dict[int, list[Item]]:
        root = self.moved_to or self.root
        rows = attached(self.folder).execute(
            "SELECT shard, photo, twin, original_shard FROM read_parquet($paths) WHERE shard >= $first AND "
            "shard < $end ORDER BY shard, photo",
            {"paths": paths(self.folder), "first": first, "end": end},
        )
        found: dict[int, list[Item]] = {}
        for shard, photo, duplicate_of, original in rows.fetchall():
            location = None if root is None else locate(root, photo)
            found.setdefault(shard, []).append(Item(photo, location, duplicate_of, original))
        return found

    def names(self) -> Iterator[str]:
        """Yield all photos' names in their order."""
        if not self.files:
            return
        cursor = attached(self.folder).execute(
            "SELECT photo FROM read_parquet($paths) ORDER BY photo", {"paths": paths(self.folder)}
        )
        while batch := cursor.fetchmany(10_000):
            yield from (name for (name,) in batch)


def shards_of(folder: Folder, photos: Collection[str]) -> list[int] | None:
    """Return the shards that photos of these names are in; None where the folder has no list of photos."""
    files = paths(folder)
    if not files:
        return None
    rows = attached(folder).execute(
        "SELECT DISTINCT shard FROM read_parquet($paths) WHERE photo IN (SELECT unnest($names::VARCHAR[])) ORDER BY 1",
        {"paths": files, "names": sorted(photos)},
    )
    return [shard for (shard,) in rows.fetchall()]


def name_of(number: int) -> str:
    """Return the name of a manifest's file."""
    return f"{FOLDER}/manifest-{number:03d}.parquet"


def names(folder: Folder) -> list[str]:
    """Return the names of a results folder's manifest files; copies next to them are not among them."""
    return [f"{FOLDER}/{name}" for name in folder.names(FOLDER, ".parquet") if _NAMED.fullmatch(name)]


def paths(folder: Folder) -> list[str]:
    """Return the paths or URLs of a results folder's manifest files."""
    return [folder.path(name) for name in names(folder)]


def relative(folder: Folder, root: str | None) -> str | None:
    """Return where the photos are, relative to the results folder: without the path of the user's home folder."""
    if root is None or is_url(root) or is_url(folder.location):
        return root
    try:
        return os.path.relpath(root, folder.location).replace(os.sep, "/")
    except ValueError:  # another drive of Windows
        return root


def absolute(folder: Folder, root: str | None) -> str | None:
    """Return where the photos are that a results folder names."""
    if root is None or is_url(root) or is_url(folder.location):
        return root
    return os.path.normpath(os.path.join(folder.location, root))


def read(folder: Folder) -> Manifest | None:
    """Return the manifest of a results folder, None where there is none; raises OutputError for another kind."""
    files = paths(folder)
    if not files:
        return None
    duck = attached(folder)
    header = duck.execute(
        "SELECT decode(value) FROM parquet_kv_metadata($path) WHERE decode(key) = 'proxemetry'", {"path": files[0]}
    ).fetchone()
    try:
        fields: dict[str, Any] = json.loads(header[0])
        root, schema = fields["root"], fields["schema"]
    except (TypeError, ValueError, KeyError) as error:
        raise OutputError(f"{files[0]}: damaged; start again with --restart") from error
    if schema != SCHEMA:
        raise OutputError(
            f"{files[0]}: a list of photos of schema {schema!r}, made by another version of proxemetry; "
            "use that one, name another --out, or start again with --restart"
        )
    sizes = duck.execute(
        "SELECT count(*) FROM read_parquet($paths) GROUP BY shard ORDER BY shard", {"paths": files}
    ).fetchall()
    return Manifest(folder, absolute(folder, root), tuple(size for (size,) in sizes), len(files))
