"""The frozen list of a run's photos and the shards they are worked in.

A manifest is written once, before anything is measured, and read ever after: who joins or resumes a run works on the
same shards. Photos that came later are appended as a further manifest file with shards of its own.
"""

from __future__ import annotations

import hashlib
import json
import os
from collections import defaultdict
from collections.abc import Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

from ..errors import OutputError
from .folder import Folder, is_url, open_filesystem
from .parts import attached, connection, quoted
from .photos import Listing, locate

FOLDER = "manifest"
SCHEMA = "proxemetry.manifest/1"

#: A shard is what a killed process loses: a few minutes at most. Small runs get shards of single photos.
MAX_SHARD, SHARDS_OF_A_SMALL_RUN = 256, 64
_TAIL_BYTES = 4096


@dataclass(frozen=True)
class Item:
    """One photo of a shard. location: path or URL, None where only keypoints are recorded.

    twin: photos of one shard with the same number may be copies of one file (same size, same end).
    """

    photo: str
    location: str | None
    twin: int | None = None


@dataclass(frozen=True)
class Manifest:
    """Photos, their shards and their twins, all in one order; `root` is None where photos are only names."""

    root: str | None
    photos: tuple[str, ...] = ()
    shards: tuple[int, ...] = ()
    twins: tuple[int | None, ...] = ()
    files: int = 0
    moved_to: str | None = field(default=None, compare=False)

    def __len__(self) -> int:
        return len(self.photos)

    @cached_property
    def _rows_of_shard(self) -> dict[int, list[int]]:
        found: defaultdict[int, list[int]] = defaultdict(list)
        for row, shard in enumerate(self.shards):
            found[shard].append(row)
        return dict(found)

    @property
    def n_shards(self) -> int:
        """How many shards there are, numbered from 0."""
        return len(self._rows_of_shard)

    def shard_size(self, shard: int) -> int:
        """Return how many photos a shard has."""
        return len(self._rows_of_shard[shard])

    def items(self, shard: int) -> tuple[Item, ...]:
        """Return the photos of a shard."""
        root = self.moved_to or self.root
        return tuple(
            Item(self.photos[r], None if root is None else locate(root, self.photos[r]), self.twins[r])
            for r in self._rows_of_shard[shard]
        )


def frozen(folder: Folder, listing: Listing | Sequence[str] | None) -> Manifest:
    """Return the manifest of a results folder, made now or extended by what is new in `listing`.

    listing: photos as found, names of recorded photos, or None for what the folder has already. Several machines may
    do this at once: one of them writes.
    """
    while True:
        manifest = read(folder)
        if listing is None:
            if manifest is None:
                raise OutputError(f"{folder.location}: no run to go on with there; name the photos to measure")
            return manifest
        manifest, new = _compared(manifest, listing)
        if not new:
            return manifest
        if _append(folder, manifest, new):
            moved = manifest.moved_to
            manifest = read(folder)
            assert manifest is not None
            return _moved(manifest, moved)


def _moved(manifest: Manifest, root: str | None) -> Manifest:
    return Manifest(manifest.root, manifest.photos, manifest.shards, manifest.twins, manifest.files, root)


def _compared(manifest: Manifest | None, listing: Listing | Sequence[str]) -> tuple[Manifest, list[str]]:
    """Return the manifest and which names of the listing it lacks, relative to its own root."""
    root = listing.root if isinstance(listing, Listing) else None
    names: Iterable[str] = listing.names if isinstance(listing, Listing) else sorted(set(listing))
    if manifest is None:
        return Manifest(root), list(names)
    known = set(manifest.photos)
    if root == manifest.root or root is None or manifest.root is None:
        return manifest, [n for n in names if n not in known]
    if known <= set(names):  # the archive is mounted elsewhere now
        manifest = _moved(manifest, root)
        return manifest, [n for n in names if n not in known]
    if is_url(root) or is_url(manifest.root):
        raise OutputError(
            f"the results so far are of photos in {manifest.root}, not {root}: name another --out, or --restart"
        )
    anew = (os.path.relpath(locate(root, n), manifest.root).replace(os.sep, "/") for n in names)
    return manifest, sorted(n for n in anew if n not in known)


def _append(folder: Folder, manifest: Manifest, new: list[str]) -> bool:
    """Write the new photos as one more manifest file; return whether nobody else was first."""
    root = manifest.moved_to or manifest.root
    twins = [None] * len(new) if root is None else _twins(root, new)
    shards = _shards(twins, manifest.n_shards)
    rows = sorted(zip(shards, new, twins, strict=True), key=lambda r: (r[0], r[1]))
    with folder.scratch() as path:
        header = quoted(json.dumps({"schema": SCHEMA, "root": manifest.root}))
        connection().execute(
            "COPY (SELECT unnest($shards::INTEGER[]) shard, unnest($photos::VARCHAR[]) photo, "
            f"unnest($twins::INTEGER[]) twin) TO {quoted(path)} "
            f"(FORMAT parquet, COMPRESSION zstd, KV_METADATA {{proxemetry: {header}}})",
            {"shards": [r[0] for r in rows], "photos": [r[1] for r in rows], "twins": [r[2] for r in rows]},
        )
        with open(path, "rb") as file:
            return folder.create(_name(manifest.files), file.read())


def _name(number: int) -> str:
    return f"{FOLDER}/manifest-{number:03d}.parquet"


def read(folder: Folder) -> Manifest | None:
    """Return the manifest of a results folder, None where there is none; raises OutputError for a newer kind."""
    files = [f"{FOLDER}/{n}" for n in folder.names(FOLDER, ".parquet")]
    if not files:
        return None
    duck = attached(folder)
    paths = [folder.path(f) for f in files]
    (header,) = duck.execute(
        "SELECT decode(value) FROM parquet_kv_metadata($path) WHERE decode(key) = 'proxemetry'", {"path": paths[0]}
    ).fetchone()
    fields: dict[str, Any] = json.loads(header)
    if fields["schema"] != SCHEMA:
        raise OutputError(f"{paths[0]}: manifest of schema {fields['schema']!r}; install a newer proxemetry")
    # As one text and two arrays: a million Python tuples would take as long as all the rest of a resumed run's start.
    (names,) = duck.execute(
        "SELECT string_agg(photo, chr(0) ORDER BY shard, photo) FROM read_parquet($paths)", {"paths": paths}
    ).fetchone()
    columns = duck.execute(
        "SELECT shard, twin FROM read_parquet($paths) ORDER BY shard, photo", {"paths": paths}
    ).fetchnumpy()
    photos = tuple(names.split("\0"))
    return Manifest(
        fields["root"], photos, tuple(columns["shard"].tolist()), tuple(columns["twin"].tolist()), len(files)
    )


def _shards(twins: Sequence[int | None], first: int) -> list[int]:
    """Return each photo's shard: even runs in the order of names, twins all in the shard of the first of them."""
    size = max(1, min(MAX_SHARD, -(-len(twins) // SHARDS_OF_A_SMALL_RUN)))
    shards: list[int] = []
    home: dict[int, int] = {}
    leading = 0
    for twin in twins:
        if twin is not None and twin in home:
            shards.append(home[twin])
            continue
        shard = first + leading // size
        leading += 1
        if twin is not None:
            home[twin] = shard
        shards.append(shard)
    return shards


def _twins(root: str, names: list[str]) -> list[int | None]:
    """Return a number for each photo that may be a copy of another: same size and same last bytes.

    Only photos of equal size are looked into, and only at their end, where compressed pixels differ between any two
    photos: one small read each. Whoever measures compares whole files.
    """
    sizes = _sizes(root, names)
    of_size: defaultdict[int, list[int]] = defaultdict(list)
    for row, size in enumerate(sizes):
        if size is not None:
            of_size[size].append(row)
    alike = [row for rows in of_size.values() if len(rows) > 1 for row in rows]
    with ThreadPoolExecutor(16) as pool:
        ends = list(pool.map(lambda row: _end_of(locate(root, names[row]), sizes[row] or 0), alike))
    groups: defaultdict[tuple[int | None, bytes], list[int]] = defaultdict(list)
    for row, end in zip(alike, ends, strict=True):
        groups[sizes[row], end].append(row)
    twins: list[int | None] = [None] * len(names)
    for rows in groups.values():
        if len(rows) > 1:
            for row in rows:
                twins[row] = rows[0]
    return twins


def _sizes(root: str, names: list[str]) -> list[int | None]:
    if is_url(root):
        found: dict[str, Any] = open_filesystem(root).find(root, detail=True)
        prefix = root.partition("://")[2].rstrip("/").lstrip("/") + "/"
        sizes = {path.lstrip("/").removeprefix(prefix): info.get("size") for path, info in found.items()}
        return [sizes.get(name) for name in names]
    return [_size(locate(root, name)) for name in names]


def _size(path: str) -> int | None:
    try:
        return os.stat(path).st_size
    except OSError:
        return None  # whoever measures says what is wrong


def _end_of(location: str, size: int) -> bytes:
    try:
        if is_url(location):
            end = open_filesystem(location).cat_file(location, start=max(0, size - _TAIL_BYTES))
        else:
            with open(location, "rb") as file:
                file.seek(max(0, size - _TAIL_BYTES))
                end = file.read()
    except OSError:
        end = location.encode()  # like nothing else
    return hashlib.blake2b(end, digest_size=16).digest()
