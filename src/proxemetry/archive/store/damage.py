"""What became of the files of a results folder: each part carries a digest, and every damage is one line.

The digest is the SHA-256 of the part's file with zeros in its own place. It stands in the Parquet file's metadata,
which is not compressed, so that it travels with the file wherever that is copied.
"""

from __future__ import annotations

import hashlib
import json
import re
from collections.abc import Generator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from ...errors import OutputError
from ...tables import TABLES
from .folder import RUN_FILE, Folder

#: Key of a part's metadata, and what stands there until the file is whole.
DIGEST, BLANK = "proxemetry_sha256", "0" * 64
#: Thrift's compact protocol: a text (0x18) of 64 bytes (0x40) follows the key.
_BEFORE_DIGEST = DIGEST.encode() + b"\x18\x40"

_THREADS = 8
#: Files that a folder's own commands read: name of the subfolder, pattern, and what to do about a damaged one.
_KINDS = (
    (
        "scenes",
        r"part-\d{6,}\.parquet",
        "delete it (or add --repair), and the same `proxemetry measure` measures its photos again",
    ),
    ("manifest", r"manifest-\d{3,}\.parquet", "begin anew with --restart"),
    ("", r"(photos|people|pairs)\.parquet", "delete it, and `proxemetry export DIR` writes it again"),
)


def seal(path: str | Path) -> None:
    """Write the digest of a part that was written with `BLANK` in its place."""
    content = Path(path).read_bytes()
    at = content.rfind(_BEFORE_DIGEST + BLANK.encode()) + len(_BEFORE_DIGEST)
    with Path(path).open("r+b") as file:
        file.seek(at)
        file.write(hashlib.sha256(content).hexdigest().encode())


def is_whole(content: bytes) -> bool:
    """Return whether a part's content is what was written."""
    at = content.rfind(_BEFORE_DIGEST)
    if at < 0:
        return False
    start = at + len(_BEFORE_DIGEST)
    digest = hashlib.sha256(content[:start])
    digest.update(BLANK.encode())
    digest.update(content[start + 64 :])
    return digest.hexdigest().encode() == content[start : start + 64]


def damaged_parts(folder: Folder, names: Sequence[str]) -> list[str]:
    """Return which of these parts, by their names in the folder, are not what was written, or cannot be read."""

    def check(name: str) -> bool:
        try:
            content = folder.read(name)
        except OutputError:
            return False
        return content is not None and is_whole(content)

    with ThreadPoolExecutor(_THREADS) as pool:
        return [name for name, whole in zip(names, pool.map(check, names), strict=True) if not whole]


def require_whole(folder: Folder, names: Sequence[str]) -> None:
    """Raise OutputError naming the damaged ones among these parts."""
    found = damaged_parts(folder, names)
    if found:
        others = f" and {len(found) - 1} more" if len(found) > 1 else ""
        raise OutputError(f"{folder.path(found[0])}{others}: damaged since it was written; {_KINDS[0][2]}")


@contextmanager
def explained(folder: Folder) -> Generator[None]:
    """Turn DuckDB's errors into OutputError that names the damaged file; a mistake in a query stays as it is."""
    import duckdb

    try:
        yield
    except duckdb.Error as error:
        refusal = _refusal(folder, error)
        if refusal is None:
            raise
        raise refusal from error


def _refusal(folder: Folder, error: Exception) -> OutputError | None:
    import duckdb

    if isinstance(error, duckdb.OutOfMemoryException):
        return OutputError(f"{folder.location}: not enough memory ({_first_line(error)})")
    found = _find(folder)
    if found is not None:
        return found
    # Nothing that is there is at fault: the disk, which who writes explains, or the query.
    mistakes = (duckdb.BinderException, duckdb.CatalogException, duckdb.ParserException, duckdb.SyntaxException)
    if isinstance(error, (duckdb.IOException, *mistakes)):
        return None
    return OutputError(f"{folder.location}: cannot be read ({_first_line(error)})")


def _first_line(error: Exception) -> str:
    return (str(error).splitlines() or [type(error).__name__])[0]


def _find(folder: Folder) -> OutputError | None:
    """Return a message about the first damaged file of a folder, None where all can be read."""
    for subfolder, pattern, advice in _KINDS:
        names = [name for name in folder.names(subfolder, ".parquet") if re.fullmatch(pattern, name)]
        paths = [f"{subfolder}/{name}".lstrip("/") for name in names]
        if subfolder == "scenes":
            bad = damaged_parts(folder, paths)[:1]
        else:
            bad = [path for path in paths if not _is_readable(folder, path)][:1]
        if bad:
            return OutputError(f"{folder.path(bad[0])}: damaged; {advice}")
    return None


def _is_readable(folder: Folder, name: str) -> bool:
    """Return whether a Parquet file without a digest can be read to its end, with the columns it should have."""
    import duckdb

    table = TABLES.get(name.removesuffix(".parquet"))
    wanted = ["shard", "photo"] if table is None else [column.name for column in table]
    try:
        # A connection of its own: some damages leave the other one unusable.
        with duckdb.connect(config={"threads": 1, "autoload_known_extensions": False}) as duck:
            if folder.filesystem is not None:
                duck.register_filesystem(folder.filesystem)
            columns = ", ".join(f'"{column}"' for column in wanted)
            duck.execute(f"SELECT {columns} FROM read_parquet($path)", {"path": folder.path(name)})
            while duck.fetchmany(10_000):
                pass
    except duckdb.Error:
        return False
    return True


class Guarded:
    """DuckDB's connection, or a cursor, on a results folder: what it raises names the file that is damaged."""

    def __init__(self, duck: Any, folder: Folder) -> None:
        self._duck, self._folder = duck, folder

    def execute(self, query: str, parameters: Any = None) -> Guarded:
        """Run a query; the answer is fetched from what comes back."""
        with explained(self._folder):
            self._duck.execute(query, parameters)
        return self

    def _fetched(self, method: str, *arguments: Any) -> Any:
        with explained(self._folder):
            return getattr(self._duck, method)(*arguments)

    def fetchone(self) -> Any:
        """Return the next row, None after the last."""
        return self._fetched("fetchone")

    def fetchall(self) -> list[Any]:
        """Return the rows that are left."""
        return self._fetched("fetchall")

    def fetchmany(self, size: int) -> list[Any]:
        """Return some more rows."""
        return self._fetched("fetchmany", size)

    def fetchdf(self) -> Any:
        """Return the rows as a pandas data frame."""
        return self._fetched("df")

    def fetchnumpy(self) -> dict[str, Any]:
        """Return the columns as arrays."""
        return self._fetched("fetchnumpy")

    def fetch_df_chunk(self, vectors: int) -> Any:
        """Return some more rows as a data frame."""
        return self._fetched("fetch_df_chunk", vectors)

    @property
    def description(self) -> Any:
        """The columns of the answer."""
        return self._duck.description

    def cursor(self) -> Guarded:
        """Return another connection to the same database: a thread needs one of its own."""
        return Guarded(self._duck.cursor(), self._folder)

    def register(self, name: str, columns: Any) -> None:
        """Make arrays a table of that name."""
        self._duck.register(name, columns)

    def unregister(self, name: str) -> None:
        """Forget a table that was registered."""
        self._duck.unregister(name)


def require_run(content: Any, path: str) -> dict[str, Any]:
    """Return what `run.json` holds; raises OutputError where it is not what a run writes there."""
    kinds: dict[str, tuple[type, ...]] = {
        "version": (str,), "pose": (str,), "models": (dict,), "settings": (dict,), "metadata": (dict,),
        "photos_in": (str, type(None)), "safe_distance_m": (float, int, type(None)),
    }  # fmt: skip
    fits = isinstance(content, dict) and all(isinstance(content.get(k, None), kinds[k]) for k in kinds if k in content)
    if not fits or not all(isinstance(value, str) for value in content.get("metadata", {}).values()):
        raise OutputError(f"{path}: not what a run writes; delete it, and the same `proxemetry measure` makes it again")
    return content


def run_of(folder: Folder) -> dict[str, Any] | None:
    """Return the content of `run.json`, None where there is none; raises OutputError where it is damaged."""
    content = folder.read(RUN_FILE)
    if content is None:
        return None
    try:
        fields = json.loads(content)
    except (ValueError, RecursionError):
        fields = None
    return require_run(fields, folder.path(RUN_FILE))
