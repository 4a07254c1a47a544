"""One Parquet part a shard: a row a photo, with the photo's table row, its people, its pairs and the whole scene."""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import cache
from typing import Any

from ..scene import Scene
from ..tables import TABLES, rows
from .folder import Folder

FOLDER = "scenes"
_FORMAT = "FORMAT parquet, COMPRESSION zstd"


@dataclass(frozen=True)
class Counts:
    """How many photos went which way; sums over shards are sums of these."""

    photos: int = 0
    failed: int = 0
    no_camera: int = 0
    people: int = 0
    pairs: int = 0

    def __add__(self, other: Counts) -> Counts:
        return Counts(*(getattr(self, n) + getattr(other, n) for n in self.__dataclass_fields__))


@dataclass(frozen=True)
class Record:
    """One photo's row of a part, as JSON, and what it counts for."""

    json: str
    counts: Counts


def record_of(scene: Scene) -> Record:
    """Return the row of a scene."""
    (photo,) = rows("photos", scene)
    nested = {
        table: [{k: v for k, v in row.items() if k != "photo"} for row in rows(table, scene)]
        for table in ("people", "pairs")
    }
    text = json.dumps({**photo, **nested, "scene": scene.to_json()}, allow_nan=False, ensure_ascii=False)
    return Record(text, _counts(scene))


def _counts(scene: Scene) -> Counts:
    return Counts(
        photos=1,
        failed=int(scene.status == "failed"),
        no_camera=int(scene.status == "no_camera"),
        people=len(scene),
        pairs=scene.distances.below(math.inf),
    )


@cache
def structure() -> str:
    """Return the rows' structure as DuckDB's `from_json` takes it."""
    fields: dict[str, Any] = {c.name: c.kind for c in TABLES["photos"]}
    for table in ("people", "pairs"):
        fields[table] = [{c.name: c.kind for c in TABLES[table] if c.name != "photo"}]
    fields["scene"] = "VARCHAR"
    return json.dumps([fields])


def name_of(shard: int) -> str:
    """Return the file name of a shard's part."""
    return f"{FOLDER}/part-{shard:06d}.parquet"


def finished(folder: Folder) -> set[int]:
    """Return the shards whose part is there."""
    return {int(name[5:-8]) for name in folder.names(FOLDER, ".parquet") if name.startswith("part-")}


def write(folder: Folder, shard: int, records: Iterable[Record], metadata: Mapping[str, str]) -> None:
    """Write a shard's part, whole or not at all; raises OutputError where it cannot be written."""
    text = f"[{','.join(r.json for r in records)}]"
    pairs = ", ".join(f"{key}: {quoted(value)}" for key, value in sorted(metadata.items()))
    with folder.writing(name_of(shard)) as temporary:
        connection().execute(
            f"COPY (SELECT unnest(from_json($rows::JSON, $structure), max_depth := 2)) TO {quoted(temporary)} "
            f"({_FORMAT}, KV_METADATA {{{pairs}}})",
            {"rows": text, "structure": structure()},
        )


def metadata_of(folder: Folder, shards: Iterable[int]) -> list[dict[str, str]]:
    """Return the distinct metadata of parts."""
    paths = [folder.path(name_of(s)) for s in shards]
    if not paths:
        return []
    found = (
        attached(folder)
        .execute(
            "SELECT DISTINCT map(list(decode(key) ORDER BY key), list(decode(value) ORDER BY key)) "
            "FROM parquet_kv_metadata($paths) WHERE decode(key) LIKE 'proxemetry%' GROUP BY file_name",
            {"paths": paths},
        )
        .fetchall()
    )
    return [dict(row[0]) for row in found]


def measured_files(folder: Folder, shards: Iterable[int], cursor: Any = None) -> list[tuple[str, str]]:
    """Return name and SHA-256 of one photo of each shard, none of a shard whose files could not be read.

    cursor: of DuckDB, for who is not the only thread.
    """
    paths = [folder.path(name_of(s)) for s in shards]
    if not paths:
        return []
    rows = (cursor or attached(folder)).execute(
        "SELECT arg_min(photo, photo), arg_min(sha256, photo) FROM read_parquet($paths, filename = true) "
        "WHERE coalesce(sha256, '') <> '' GROUP BY filename ORDER BY 1",
        {"paths": paths},
    )
    return rows.fetchall()


def scenes(folder: Folder, photos: Iterable[str] | None = None, *, with_copies: bool = False) -> Iterator[Scene]:
    """Yield the scenes of a results folder in the order of their names, as measured.

    photos: the names of some; with_copies: and of the other photos that are the same file.
    """
    if not finished(folder):
        return
    every = f"read_parquet({quoted(folder.path(FOLDER))} || '/part-*.parquet')"
    named = "SELECT unnest($names::VARCHAR[])"
    wanted = f"photo IN ({named})"
    if with_copies:
        wanted += f" OR sha256 IN (SELECT sha256 FROM {every} WHERE sha256 <> '' AND photo IN ({named}))"
    cursor = attached(folder).cursor()
    if photos is None:
        cursor.execute(f"SELECT scene FROM {every} ORDER BY photo")
    else:
        cursor.execute(f"SELECT scene FROM {every} WHERE {wanted} ORDER BY photo", {"names": sorted(set(photos))})
    while batch := cursor.fetchmany(64):
        yield from (Scene.from_json(text) for (text,) in batch)


def copied(folder: Folder, shard: int, sha256: str, photo: str) -> Record | None:
    """Return what a shard's part says of a file, as the row of `photo`, a copy; None where the part does not have it.

    The row as it stands, not one made of its scene: that would round twice.
    """
    if not folder.exists(name_of(shard)):
        return None
    found = attached(folder).execute(
        "SELECT to_json(part) FROM read_parquet($path) AS part WHERE sha256 = $sha256 LIMIT 1",
        {"path": folder.path(name_of(shard)), "sha256": sha256},
    )
    row = found.fetchone()
    if row is None:
        return None
    fields = json.loads(row[0])
    scene = Scene.from_json(fields["scene"]).renamed(photo)
    text = json.dumps({**fields, "photo": photo, "scene": scene.to_json()}, allow_nan=False, ensure_ascii=False)
    return Record(text, _counts(scene))


@cache
def connection(threads: int | None = 1) -> Any:
    """Return this process's DuckDB: with one thread, since whatever runs in parallel runs as processes, or with all."""
    import duckdb

    config: dict[str, Any] = {"autoinstall_known_extensions": False}
    return duckdb.connect(config=config if threads is None else {**config, "threads": threads})


def attached(folder: Folder, threads: int | None = 1) -> Any:
    """Return this process's DuckDB, able to read the folder."""
    connected = connection(threads)
    if folder.filesystem is not None and not connected.filesystem_is_registered(folder.location.partition("://")[0]):
        connected.register_filesystem(folder.filesystem)
    return connected


def quoted(text: str) -> str:
    """Return a text as an SQL literal."""
    return "'" + text.replace("'", "''") + "'"
