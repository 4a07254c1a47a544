"""Photos that a manifest lacks: found while others are measured, put into shards, appended as a manifest file."""

from __future__ import annotations

import json
import os
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ...errors import OutputError
from ..store.duck import attached, connection, quoted
from ..store.file_state import FileState
from ..store.folder import Folder, is_url
from ..store.manifest import SCHEMA, Manifest, name_of, paths, read, relative
from ..store.parts import finished, measured_files
from ..store.photos import Listing, Search, locate
from .background import BackgroundTask
from .duplicates import Duplicates, Ends, Sizes, ends_of, find_duplicates, repeated, sha256_of, sizes_of

#: A shard is what a killed process loses: a few minutes at most. Small runs get shards of single photos.
MAX_SHARD, SHARDS_OF_A_SMALL_RUN = 256, 64
#: Copies join the first of them in its shard, up to so many times its size.
COPIES_A_SHARD = 3
#: How many photos are compared to recognise an archive as the one that was measured.
_FILES_COMPARED = 8


class ManifestUpdate(BackgroundTask[Manifest]):
    """A thread that lists the photos named and, once allowed, appends those that are new to the manifest.

    An archive of a million photos takes a while to walk, over a network minutes: meanwhile what is known already can
    be measured. `close` ends the thread, wherever it is. passed_over: what was not taken for photos, once it is known.
    """

    passed_over: str = ""

    def __init__(self, folder: Folder, named: Search | Sequence[str], known: Manifest | None) -> None:
        connection()  # loaded in the main thread, where Ctrl-C can wait for it
        super().__init__(lambda: self._completed(folder, named, known))

    def _completed(self, folder: Folder, named: Search | Sequence[str], known: Manifest | None) -> Manifest:
        listing = named.listing(self.stopped.is_set) if isinstance(named, Search) else named
        self.passed_over = listing.passed_over if isinstance(listing, Listing) else ""
        manifest, new = compared(folder, known, listing)
        self.gate.wait()
        while new and not self.stopped.is_set():
            before = manifest.files
            written = append(folder, manifest, new)
            # Another machine may have been first: then what it left is to be appended.
            known = read(folder)
            if known is not None and manifest.moved_to:
                known = known.moved(manifest.moved_to)
            manifest, new = compared(folder, known, listing)
            if not written and manifest.files <= before:
                raise OutputError(f"{folder.path(name_of(before))}: in the way of the list of photos")
        return manifest

    def allow(self) -> None:
        """Let what is new be written: the run was found to be of the kind that is in the folder."""
        self.gate.set()


def compared(folder: Folder, known: Manifest | None, listing: Listing | Sequence[str]) -> tuple[Manifest, list[str]]:
    """Return the manifest and which names of the listing it lacks, relative to its own root."""
    root = listing.root if isinstance(listing, Listing) else None
    names = listing.names if isinstance(listing, Listing) else sorted(set(listing))
    if known is None:
        return Manifest(folder, root), list(names)
    new = _lacking(known.names(), names)
    home = known.moved_to or known.root
    if home in (root, None) or root is None:
        return known, new
    # Mounted elsewhere now? A photo or two may have been renamed or deleted in the meantime.
    if 2 * (len(names) - len(new)) > len(known) and _same_files(folder, known, root):
        return known.moved(root), new
    if is_url(root) or is_url(home):
        raise OutputError(f"the results so far are of photos in {home}, not {root}: name another --out, or --restart")
    anew = sorted(os.path.relpath(locate(root, n), home).replace(os.sep, "/") for n in names)
    return known, _lacking(known.names(), anew)


def mixed_folders_note(listed: Manifest, root: str) -> str | None:
    """Return what to say where photos of another folder are added to the results; None where there is nothing to say.

    Two archives in one results folder are one set of tables, which is seldom meant: `--out` has a default. A folder
    inside the other is the same archive.
    """
    home = listed.moved_to or listed.root
    if home is None or is_url(home) or is_url(root):
        return None
    if Path(root).is_relative_to(home) or Path(home).is_relative_to(root):
        return None
    return (
        f"these results are of photos in {home}; those of {root} are added to the same tables, under names that start "
        "with ../ (to keep them apart, name another --out)"
    )


def _same_files(folder: Folder, known: Manifest, root: str) -> bool:
    """Return whether photos of the same names below another folder are the ones that were measured, and not others.

    Cameras count from IMG_0001.JPG on in every folder. Of some that were measured the bytes are compared; most of them
    have to agree, since a photo or two may have been edited when the archive was moved.
    """
    there = sorted(s for s in finished(folder) if s < known.n_shards)
    asked = there[:: max(1, len(there) // _FILES_COMPARED)][:_FILES_COMPARED]
    compared = [(sha256_of(locate(root, photo)), digest) for photo, digest in measured_files(folder, asked)]
    agreed = [now == before for now, before in compared if now]
    return 2 * sum(agreed) >= len(agreed)


def _lacking(known: Iterator[str], names: Sequence[str]) -> list[str]:
    """Return the names that are not known; both come in their order, so that only the new ones are kept."""
    new: list[str] = []
    current = next(known, None)
    for name in names:
        while current is not None and current < name:
            current = next(known, None)
        if current != name:
            new.append(name)
    return new


def append(folder: Folder, manifest: Manifest, new: Sequence[str]) -> bool:
    """Write the new photos as one more manifest file; return False where another machine was first."""
    root = manifest.moved_to or manifest.root
    none = np.full(len(new), -1, dtype=np.int64)
    sizes, alike, older_shards = none, Duplicates(none, none), none
    if root is not None:
        sizes, alike, older_shards = _alike(folder, manifest, root, new)
    shards, earlier = shards_of(alike.duplicate_of, manifest.n_shards)
    older_shards = np.where(older_shards >= 0, older_shards, earlier)
    duck = attached(folder)
    duck.register("new_photos", {
        "shard": shards, "photo": np.array(new, dtype=object), "bytes": sizes, "twin": alike.duplicate_of,
        "original_shard": older_shards,
    })  # fmt: skip
    header = quoted(json.dumps({"schema": SCHEMA, "root": relative(folder, manifest.root)}))
    with folder.scratch() as path:
        duck.execute(
            "COPY (SELECT shard::INTEGER AS shard, photo::VARCHAR AS photo, nullif(bytes, -1) AS bytes, "
            "nullif(twin, -1) AS twin, nullif(original_shard, -1)::INTEGER AS original_shard FROM new_photos "
            f"ORDER BY shard, photo) TO {quoted(path)} "
            f"(FORMAT parquet, COMPRESSION zstd, ROW_GROUP_SIZE 20480, KV_METADATA {{proxemetry: {header}}})"
        )
        with open(path, "rb") as file:
            return folder.create(name_of(manifest.files), file.read())


def _alike(
    folder: Folder, manifest: Manifest, root: str, new: Sequence[str]
) -> tuple[Sizes, Duplicates, NDArray[np.int64]]:
    """Return the new photos' sizes, which of them may be copies, and the shards of the older ones they may be of."""
    sizes = sizes_of(root, new)
    old_names, old_sizes, old_shards = _older(folder, manifest, sizes)
    chosen = np.flatnonzero(repeated(sizes, old_sizes))
    ends = ends_of(root, [new[i] for i in chosen.tolist()], sizes[chosen])
    old_ends: Ends = ends_of(root, old_names, old_sizes)
    found = find_duplicates(sizes[chosen], ends, old_sizes, old_ends)
    none = np.full(len(new), -1, dtype=np.int64)
    duplicate_of, shard = none.copy(), none.copy()
    duplicate_of[chosen] = np.where(found.duplicate_of >= 0, chosen[found.duplicate_of], -1)
    shard[chosen] = np.append(old_shards, -1)[found.original]
    # A file that is gone has no end to compare: a new one of its size may be it, renamed.
    gone = {
        size: at
        for name, size, at in zip(old_names, old_sizes.tolist(), old_shards.tolist(), strict=True)
        if FileState.of(locate(root, name)) is None
    }
    renamed = [gone.get(size, -1) for size in sizes.tolist()] if gone else none
    shard = np.where(shard < 0, renamed, shard)
    return sizes, Duplicates(duplicate_of, shard), shard


def _older(folder: Folder, manifest: Manifest, sizes: Sizes) -> tuple[list[str], Sizes, NDArray[np.int64]]:
    """Return names, sizes and shards of the photos in the manifest that are as large as a new one."""
    if not manifest.files:
        nothing = np.zeros(0, dtype=np.int64)
        return [], nothing, nothing
    duck = attached(folder)
    duck.register("looked_for", {"bytes": np.unique(sizes[sizes >= 0])})
    rows = duck.execute(
        "SELECT photo, bytes, shard FROM read_parquet($paths) SEMI JOIN looked_for USING (bytes) ORDER BY shard, photo",
        {"paths": paths(folder)},
    ).fetchall()
    size, shard = (np.array([row[k] for row in rows], dtype=np.int64) for k in (1, 2))
    return [row[0] for row in rows], size, shard


def shards_of(duplicate_of: NDArray[np.int64], first: int) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Return each photo's shard, and the shard that may have measured the same file before, -1 for most.

    Shards are even runs in the order of names. Duplicates join the first of them in its shard, as long as that does
    not grow out of proportion: a thousand like files go into shards of their own, which wait for the first.
    """
    n = len(duplicate_of)
    size = max(1, min(MAX_SHARD, -(-n // SHARDS_OF_A_SMALL_RUN)))
    leads = (duplicate_of < 0) | (duplicate_of == np.arange(n))
    home = np.where(leads, (np.cumsum(leads) - 1) // size, -1)
    home = np.where(leads, home, home[duplicate_of])
    followers = np.flatnonzero(~leads)
    followers = followers[np.argsort(home[followers], kind="stable")]
    _, begins = np.unique(home[followers], return_index=True)
    rank = np.arange(len(followers)) - np.repeat(begins, np.diff(np.append(begins, len(followers))))
    leads[followers[rank >= COPIES_A_SHARD * size]] = True
    shards = first + (np.cumsum(leads) - 1) // size
    of_first = np.where(duplicate_of < 0, shards, shards[duplicate_of])
    joined = np.where(leads, shards, of_first)
    return joined, np.where(of_first < joined, of_first, -1)
