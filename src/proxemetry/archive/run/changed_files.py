"""Photos that are not what was measured any more: replaced under their own name, or gone from where they were.

A file whose size and date are as they were when it was measured is taken for the same. Of the others the shards are
done again, which compares the files themselves and measures those that are another picture.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import Any

from ..store import parts
from ..store.duck import attached, connection
from ..store.file_state import FileState
from ..store.folder import Folder, is_url, open_filesystem
from ..store.manifest import Manifest
from ..store.photos import locate
from .background import BackgroundTask
from .manifest_update import ManifestUpdate

#: Looks at files that wait for a disk or a server at a time, and rows read at once.
_THREADS, _ROWS_AT_ONCE = 16, 4096


@dataclass(frozen=True)
class ChangedFiles:
    """What a look at the files found. shards: to be done again. unlike: photos whose file has another size or date.

    gone: photos that were measured and whose file is not there any more, of which `example` is one. What could not be
    read before is tried again, and is neither.
    """

    shards: frozenset[int] = frozenset()
    unlike: int = 0
    gone: int = 0
    example: str = ""


class FileScan(BackgroundTask[ChangedFiles]):
    """A thread that looks at the files of the measured photos, once the manifest is updated and `begin` was called.

    A million files take some seconds to look at, over a network minutes: meanwhile what is new is measured. is_mine:
    which shards this run does. `close` ends the thread, wherever it is.
    """

    def __init__(self, folder: Folder, update: ManifestUpdate, is_mine: Callable[[int], bool]) -> None:
        connection()  # loaded in the main thread, where Ctrl-C can wait for it
        super().__init__(lambda: self._scanned(folder, update, is_mine))

    def _scanned(self, folder: Folder, update: ManifestUpdate, is_mine: Callable[[int], bool]) -> ChangedFiles:
        self.gate.wait()
        if self.stopped.is_set():
            return ChangedFiles()
        manifest = update.result()
        there = [s for s in sorted(parts.finished(folder)) if s < manifest.n_shards and is_mine(s)]
        return self._compare(folder, manifest, there)

    def _compare(self, folder: Folder, manifest: Manifest, shards: list[int]) -> ChangedFiles:
        root = manifest.moved_to or manifest.root
        if root is None or not shards:
            return ChangedFiles()
        again: set[int] = set()
        unlike, gone, example = 0, 0, ""
        state_of = _states(root)
        with ThreadPoolExecutor(_THREADS) as pool:
            for rows in self._measured(folder, shards):
                batches = [rows[k : k + 256] for k in range(0, len(rows), 256)]
                states = pool.map(lambda batch: [state_of(row[0]) for row in batch], batches)
                now = [state for batch in states for state in batch]
                for (photo, size, modified_ns, shard), state in zip(rows, now, strict=True):
                    was_measured = size is not None
                    if state is None and was_measured:
                        gone, example = gone + 1, example or photo
                    elif state is not None and not (was_measured and state == FileState(size, modified_ns)):
                        unlike += was_measured
                        again.add(shard)
        return ChangedFiles(frozenset(again), unlike, gone, example)

    def _measured(self, folder: Folder, shards: list[int]) -> Iterator[list[tuple[Any, ...]]]:
        """Yield name, size, date and shard of measured photos, many at a time."""
        names = [parts.name_of(shard) for shard in shards]
        rows = attached(folder).execute(
            "SELECT photo, file_bytes, file_modified_ns, "
            "regexp_extract(filename, 'part-(\\d+)[.]parquet$', 1)::INTEGER "
            f"FROM {parts.every_row(folder, names, with_names=True)}"
        )
        while not self.stopped.is_set() and (found := rows.fetchmany(_ROWS_AT_ONCE)):
            yield found

    def begin(self) -> None:
        """Start looking: what has to be measured in any case has been started."""
        self.gate.set()

    def result(self) -> ChangedFiles:
        """Wait for what is found; raises what went wrong."""
        self.begin()
        return super().result()


def _states(root: str) -> Callable[[str], FileState | None]:
    """Return a function from a photo's name to the state of its file; a store is listed once for all of them."""
    if not is_url(root):

        def local_state_of(photo: str) -> FileState | None:  # a million times in a large archive
            return FileState.of(f"{root}/{photo}" if "\\x" not in photo else locate(root, photo))

        return local_state_of
    found: dict[str, Any] = open_filesystem(root).find(root, detail=True)
    sizes = {path.lstrip("/"): about.get("size") for path, about in found.items()}

    def state_of(photo: str) -> FileState | None:
        size = sizes.get(locate(root, photo).partition("://")[2].lstrip("/"))
        return None if size is None else FileState(int(size), None)

    return state_of
