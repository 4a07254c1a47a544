"""A results folder as it is read: scenes with corrections applied, and the tables made of them."""

from __future__ import annotations

import hashlib
import heapq
import json
import logging
from collections.abc import Collection, Generator, Iterable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from functools import cached_property
from operator import attrgetter
from pathlib import Path
from typing import Any

from ...errors import OutputError
from ...scene import Scene
from ...tables import (
    TABLES,
    codebook_csv,
)
from ...version import __version__
from ..review.corrections import FILE as LOG_FILE
from ..review.corrections import by_file, corrected_scenes, digest, entries_at, in_force
from . import manifest, parts
from .damage import require_whole
from .duck import attached, quoted
from .folder import RUN_FILE, Folder, is_url
from .identity import SETTINGS_SHA256
from .part_rows import record_of, structure
from .queries import as_cells, attributes_in, table_query
from .run_file import is_of_clip, run_of
from .scratch import scratch_folder
from .usable import Usable, usable_parts

TABLE_FORMATS = ("csv", "parquet")

#: Key of the Parquet tables' metadata that holds the state of the results they were made from.
_MADE_OF = "proxemetry_made_of"
#: And in that, where there are any, the parts that were damaged.
_DAMAGED = "damaged"


@dataclass(frozen=True)
class Results:
    """The results folder at `location` (a path or an fsspec URL), complete or not."""

    folder: Folder

    @classmethod
    def open(cls, location: str | Path, *, or_clip: bool = False) -> Results:
        """Return an existing results folder; raises OutputError where there is none.

        or_clip: one of a clip is wanted too, of which the scenes alone are as those of photos.
        """
        folder = Folder(location)
        if folder.read(RUN_FILE) is None:
            raise OutputError(f"{folder.location}: no results there; `proxemetry measure PHOTOS --out DIR` makes them")
        if not or_clip and is_of_clip(folder):
            raise OutputError(
                f"{folder.location}: results of a clip, not of photos: its page is report.html, its numbers are in "
                "summary.json, and `proxemetry export` writes its tables for other programs"
            )
        return cls(folder)

    @property
    def run(self) -> dict[str, Any]:
        """The content of `run.json`."""
        fields = run_of(self.folder)
        if fields is None:
            raise OutputError(f"{self.folder.path(RUN_FILE)}: missing; was the folder removed or renamed meanwhile?")
        return fields

    def require_finished(self) -> None:
        """Raise OutputError where parts of the run are still to come."""
        listed = manifest.read(self.folder)
        missing = None if listed is None else len(self.missing_shards())
        if missing is None or missing:
            what = "its photos are not listed yet" if missing is None else f"{missing} parts are missing"
            raise OutputError(
                f"{self.folder.location}: the run there is not finished ({what}); wait for it, or run the same "
                "`proxemetry measure` again"
            )

    @property
    def is_finished(self) -> bool:
        """Whether the photos are listed and every part of the run is there."""
        return manifest.read(self.folder) is not None and not self.missing_shards()

    def missing_shards(self) -> list[int]:
        """Return the shards of the manifest whose part is not there."""
        listed = manifest.read(self.folder)
        if listed is None:
            return []
        there = parts.finished(self.folder)
        return [s for s in range(listed.n_shards) if s not in there]

    @cached_property
    def _root(self) -> str | None:
        """Where the photos were when the run was finished last, else when it began; None for recorded keypoints."""
        listed = manifest.read(self.folder)
        last = self.run.get("photos_in")
        return manifest.absolute(self.folder, last) if last else None if listed is None else listed.root

    def location(self, photo: str) -> str | None:
        """Return where a photo's file is, or was when the run went on last; None for recorded keypoints."""
        return None if self._root is None else manifest.locate(self._root, photo)

    def locations(self) -> dict[str, str | None]:
        """Return every photo's `location` by its name."""
        listed = manifest.read(self.folder)
        return {} if listed is None else {name: self.location(name) for name in listed.names()}

    def usable(self, photos: Collection[str] | None = None) -> Usable:
        """Return which parts can be read now, and the photos of those that cannot; `photos`: only the parts of these.

        Every part is read to its end for this, once in a process.
        """
        return usable_parts(self.folder, photos)

    def require_whole(self) -> None:
        """Raise OutputError where a part is damaged: for those who must not do without any photo."""
        require_whole(self.folder, parts.names_of(self.folder))

    def scenes(self, photos: Iterable[str] | None = None, *, corrected: bool = True) -> Iterator[Scene]:
        """Yield the scenes in the order of their names, corrections applied; `photos` names some of them.

        A photo whose results are damaged has a scene that failed.
        """
        changed = self.corrected() if corrected else {}
        wanted = None if photos is None else set(photos)
        usable = self.usable(wanted)
        lost = [scene for scene in usable.scenes() if wanted is None or scene.photo in wanted]
        measured = parts.scenes(self.folder, usable.names, wanted)
        for scene in heapq.merge(measured, lost, key=attrgetter("photo")) if lost else measured:
            yield changed.get(scene.photo, scene)

    def corrected(self) -> dict[str, Scene]:
        """Return the scenes that a person corrected, by photo, with the corrections applied to what was measured."""
        with self._beside_log() as location:
            return corrected_scenes(
                location, lambda names, files: parts.scenes(self.folder, self.usable().names, names, files=files)
            )

    def touched(self) -> set[str]:
        """Return the photos that were corrected by hand, corrections taken back included."""
        with self._beside_log() as location:
            entries = entries_at(location)
        if not entries:
            return set()
        names, files = {a.photo for a in entries}, {a.sha256 for a in entries} - {""}
        return parts.photos_of(self.folder, self.usable().names, names, files)

    def corrections_of_no_photo(self) -> list[str]:
        """Return the photos that were corrected and whose file is not among those measured any more, by their names."""
        with self._beside_log() as location:
            wanted = by_file(in_force(entries_at(location)))
        files = {key.sha256 for key in wanted} - {""}
        usable = self.usable()
        if not files or not usable.names or usable.damaged:  # it may be among those that cannot be read
            return []
        rows = attached(self.folder).execute(
            f"SELECT DISTINCT sha256 FROM {parts.every_row(self.folder, usable.names, only=('sha256',))} "
            "WHERE sha256 IN (SELECT unnest($files::VARCHAR[]))",
            {"files": sorted(files)},
        )
        there = {sha256 for (sha256,) in rows.fetchall()}
        return sorted({actions[-1].photo for key, actions in wanted.items() if key.sha256 not in {"", *there}})

    @contextmanager
    def _beside_log(self) -> Generator[str]:
        """Yield the folder of the log of corrections, which is brought here for the while from behind a URL."""
        if not is_url(self.folder.location):
            yield self.folder.location
            return
        with scratch_folder("log") as scratch:
            content = self.folder.read(LOG_FILE)
            if content is not None:
                Path(scratch, LOG_FILE).write_bytes(content)
            yield scratch

    def write_tables(
        self, safe_distance_m: float | None = None, target: Folder | None = None, formats: Sequence[str] = TABLE_FORMATS
    ) -> tuple[str, ...]:
        """Write photos, people and pairs with corrections applied, and the codebook, here or into `target`.

        Return the damaged parts, whose photos are in them as failed. Raises OutputError where they cannot be written.
        """
        target = target or self.folder
        # Before anything is read: where a part is replaced meanwhile, the tables are known to be of an older state.
        # Those that lack what is damaged are never current.
        damaged = self.usable().damaged
        state = self._state(safe_distance_m, damaged)
        made_of = f"KV_METADATA {{{_MADE_OF}: {quoted(state)}}}"
        duck = self.view()
        options = {"parquet": f"FORMAT parquet, COMPRESSION zstd, {made_of}", "csv": "FORMAT csv, HEADER"}
        attributes = attributes_in(duck)
        for table in TABLES:
            query = table_query(table, safe_distance_m, attributes)
            # The Parquet file appears last, since it holds the state that the tables are made from.
            with ExitStack() as files:
                for form in (form for form in options if form in formats):
                    temporary = files.enter_context(target.writing(f"{table}.{form}"))
                    rows = query if form == "parquet" else as_cells(table, query, attributes)
                    duck.execute(f"COPY ({rows}) TO {quoted(temporary)} ({options[form]})")
                    if form == "parquet":  # the same rows, sorted already
                        query = f"FROM read_parquet({quoted(temporary)})"
        target.write("codebook.csv", codebook_csv(attributes).encode())
        return damaged

    def tables_are_current(self, safe_distance_m: float | None = None) -> bool:
        """Return whether all tables are there and hold what `write_tables` would write now."""
        there = all(self.folder.exists(f"{table}.{form}") for table in TABLES for form in TABLE_FORMATS)
        return there and self._made_of(self.folder, *TABLES) == {self._state(safe_distance_m)}

    def tables_belong_together(self, tables: Folder | None = None) -> bool:
        """Return whether photos and pairs were written of one state of the results. tables: the folder they are in."""
        made_of = self._made_of(tables or self.folder, "photos", "pairs")
        return len(made_of) == 1 and None not in made_of

    def damaged_in_tables(self) -> tuple[str, ...]:
        """Return the parts that were damaged when the tables in the folder were written."""
        found: set[str] = set()
        for state in self._made_of(self.folder, *(t for t in TABLES if self.folder.exists(f"{t}.parquet"))):
            found.update(json.loads(state or "{}").get(_DAMAGED, ()))
        return tuple(sorted(found))

    def _made_of(self, where: Folder, *tables: str) -> set[str | None]:
        """Return the state of the results that the Parquet tables in a folder were made from."""
        query = f"SELECT decode(value) FROM parquet_kv_metadata($path) WHERE decode(key) = '{_MADE_OF}'"
        duck = attached(self.folder, threads=None)
        rows = [duck.execute(query, {"path": where.path(f"{t}.parquet")}).fetchone() for t in tables]
        return {None if row is None else row[0] for row in rows}

    def _state(self, safe_distance_m: float | None, damaged: Sequence[str] = ()) -> str:
        """Return what tables written now are made of; damaged: the parts that they lack."""
        with self._beside_log() as location:
            state = {
                "version": __version__,
                "columns": hashlib.sha256(structure().encode()).hexdigest(),
                "settings": self.run.get("metadata", {}).get(SETTINGS_SHA256),
                "parts": parts.state(self.folder),
                "corrections": digest(location),
                "safe_distance_m": safe_distance_m,
                **({_DAMAGED: damaged} if damaged else {}),
            }
        return json.dumps(state, separators=(",", ":"))

    def view(self) -> Any:
        """Return a DuckDB in which `table_query` finds the rows of all photos, corrections applied.

        Those whose part is damaged are photos that failed. Raises OutputError where no part is there, or none is whole.
        """
        self._require_parts()
        duck = attached(self.folder, threads=None)
        duck.execute(f"CREATE OR REPLACE TEMP VIEW measured AS {self._rows(duck)}")
        return duck

    def _require_parts(self) -> None:
        if not parts.finished(self.folder):
            raise OutputError(f"{self.folder.location}: nothing is measured there yet")
        for name in parts.strays(self.folder)[:1]:
            logging.getLogger("proxemetry").warning(f"{self.folder.path(name)}: no part of a run (a copy?); not read")

    def _rows(self, duck: Any) -> str:
        """Return the query for the rows of all photos, those of corrected scenes replaced."""
        usable = self.usable()
        every = f"SELECT * EXCLUDE (scene) FROM {parts.every_row(self.folder, usable.names)}"
        changed = {scene.photo: scene for scene in usable.scenes()} | self.corrected()
        if not changed:
            return every
        rows = f"[{','.join(record_of(scene).json for scene in changed.values())}]"
        duck.execute(
            "CREATE OR REPLACE TEMP TABLE corrected AS SELECT * EXCLUDE (scene) FROM "
            "(SELECT unnest(from_json($rows::JSON, $structure), max_depth := 2))",
            {"rows": rows, "structure": structure()},
        )
        return f"{every} WHERE photo NOT IN (SELECT photo FROM corrected) UNION ALL BY NAME FROM corrected"
