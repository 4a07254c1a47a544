"""One Parquet part a shard: a row a photo, with the photo's table row, its people, its pairs and the whole scene."""

from __future__ import annotations

import hashlib
import json
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence

from ...scene import Scene
from ...tables import TABLES
from .damage import BLANK, DIGEST, require_whole, seal
from .duck import attached, connection, quoted
from .earlier import AS_EVER, rows_of
from .file_state import FileState
from .folder import Folder
from .part_rows import PreviousRow, Record, structure
from .signals import interruptible

FOLDER = "scenes"
_NAMED = re.compile(r"part-(\d{6,})\.parquet")
_FORMAT = "FORMAT parquet, COMPRESSION zstd"
# Rows of photos of some names or with some hashes.
_OF_THESE = "(photo IN (SELECT unnest($names::VARCHAR[])) OR sha256 IN (SELECT unnest($files::VARCHAR[])))"


def name_of(shard: int) -> str:
    """Return the file name of a shard's part."""
    return f"{FOLDER}/part-{shard:06d}.parquet"


def finished(folder: Folder) -> set[int]:
    """Return the shards whose part is there."""
    found = (_NAMED.fullmatch(name) for name in folder.names(FOLDER, ".parquet"))
    return {int(name[1]) for name in found if name}


def names_of(folder: Folder) -> list[str]:
    """Return the names of all parts that are there, in the order of their shards."""
    return [name_of(shard) for shard in sorted(finished(folder))]


def strays(folder: Folder) -> list[str]:
    """Return the names of files among the parts that are not parts, as "part-000001 (1).parquet", a copy of one."""
    return [f"{FOLDER}/{name}" for name in folder.names(FOLDER, ".parquet") if not _NAMED.fullmatch(name)]


def state(folder: Folder) -> str:
    """Return what changes with every part that is written: a digest of their names, sizes and dates."""
    known = {name.rpartition("/")[2] for name in names_of(folder)}
    rows = [(name, *about) for name, about in folder.states(FOLDER).items() if name in known]
    return hashlib.sha256(repr(sorted(rows)).encode()).hexdigest()


def every_row(
    folder: Folder, names: Sequence[str] | None = None, *, with_names: bool = False, only: Sequence[str] = ()
) -> str:
    """Return the rows of parts as SQL to select from; there must be a part.

    names: of the parts, all of them where None. with_names: with their `filename`. only: those of `earlier.AS_EVER`
    that are wanted, where no others are.
    """
    names = names_of(folder) if names is None else names
    return rows_of(folder, names, structure()[1:-1], only=only, with_names=with_names)


def write(folder: Folder, shard: int, records: Iterable[Record], metadata: Mapping[str, str]) -> None:
    """Write a shard's part, whole or not at all; raises OutputError where it cannot be written.

    Where it takes the place of another, the tables that were made of that one go first: a process that is killed in
    between, or one that looks in the meantime, must not take them for those of this one.
    """
    if folder.exists(name_of(shard)):
        for table in TABLES:
            folder.remove(f"{table}.parquet")
    text = f"[{','.join(r.json for r in records)}]"
    pairs = ", ".join(f"{key}: {quoted(value)}" for key, value in sorted(metadata.items()))
    with folder.writing(name_of(shard)) as temporary, interruptible():
        connection().execute(
            f"COPY (SELECT unnest(from_json($rows::JSON, $structure), max_depth := 2)) TO {quoted(temporary)} "
            f"({_FORMAT}, KV_METADATA {{{pairs}, {DIGEST}: {quoted(BLANK)}}})",
            {"rows": text, "structure": structure()},
        )
        seal(temporary)


def metadata_of(folder: Folder, shards: Iterable[int]) -> list[dict[str, str]]:
    """Return the distinct metadata of parts."""
    paths = [folder.path(name_of(s)) for s in shards]
    if not paths:
        return []
    found = (
        attached(folder)
        .execute(
            "SELECT DISTINCT map(list(decode(key) ORDER BY key), list(decode(value) ORDER BY key)) "
            "FROM parquet_kv_metadata($paths) WHERE decode(key) LIKE 'proxemetry%' "
            f"AND decode(key) <> '{DIGEST}' GROUP BY file_name",
            {"paths": paths},
        )
        .fetchall()
    )
    return [dict(row[0]) for row in found]


def measured_files(folder: Folder, shards: Iterable[int]) -> list[tuple[str, str]]:
    """Return name and SHA-256 of one photo of each shard, none of a shard whose files could not be read."""
    names = list(map(name_of, shards))
    if not names:
        return []
    every = every_row(folder, names, only=("photo", "sha256"), with_names=True)
    rows = attached(folder).execute(
        f"SELECT arg_min(photo, photo), arg_min(sha256, photo) FROM {every} "
        "WHERE coalesce(sha256, '') <> '' GROUP BY filename ORDER BY 1"
    )
    return rows.fetchall()


def scenes(
    folder: Folder, names: Sequence[str], photos: Iterable[str] | None = None, *, files: Iterable[str] | None = None
) -> Iterator[Scene]:
    """Yield the scenes of parts of these names in the order of the photos' names, as measured.

    photos: the names of some; files: the SHA-256 of some, whatever they are called.
    """
    if not names:
        return
    every = every_row(folder, names, only=AS_EVER)
    cursor = attached(folder)
    if photos is None and files is None:
        cursor.execute(f"SELECT scene FROM {every} ORDER BY photo")
    else:
        cursor.execute(f"SELECT scene FROM {every} WHERE {_OF_THESE} ORDER BY photo", _these(photos, files))
    while batch := cursor.fetchmany(64):
        yield from (Scene.from_json(text) for (text,) in batch)


def photos_of(folder: Folder, names: Sequence[str], photos: Iterable[str], files: Iterable[str]) -> set[str]:
    """Return which photos of these names, or with these SHA-256, there are in parts of these names."""
    if not names:
        return set()
    every = every_row(folder, names, only=("photo", "sha256"))
    found = attached(folder).execute(f"SELECT photo FROM {every} WHERE {_OF_THESE}", _these(photos, files))
    return {photo for (photo,) in found.fetchall()}


def _these(photos: Iterable[str] | None, files: Iterable[str] | None) -> dict[str, list[str]]:
    return {"names": sorted(set(photos or ())), "files": sorted(set(files or ()))}


def previous_rows(folder: Folder, shard: int) -> dict[str, PreviousRow]:
    """Return the rows of a shard's part by photo, none where the part is not there."""
    if not folder.exists(name_of(shard)):
        return {}
    require_whole(folder, [name_of(shard)])
    rows = every_row(folder, [name_of(shard)])
    found = attached(folder).execute(f"SELECT photo, to_json(part) FROM {rows} AS part")
    return {photo: PreviousRow(json.loads(text)) for photo, text in found.fetchall()}


def copied(folder: Folder, shard: int, sha256: str, photo: str, file: FileState | None) -> Record | None:
    """Return a file's row in a shard's part, as the row of `photo`, a copy; None where the part does not have it."""
    if not folder.exists(name_of(shard)):
        return None
    require_whole(folder, [name_of(shard)])
    rows = every_row(folder, [name_of(shard)])
    found = attached(folder).execute(
        f"SELECT to_json(part) FROM {rows} AS part WHERE sha256 = $sha256 LIMIT 1", {"sha256": sha256}
    )
    row = found.fetchone()
    if row is None:
        return None
    return PreviousRow(json.loads(row[0])).copied(photo, file)
