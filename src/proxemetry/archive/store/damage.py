"""What became of the files of a results folder: each part carries a digest, and every damage is one line.

The digest is the SHA-256 of the part's file with zeros in its own place. It stands in the Parquet file's metadata,
which is not compressed, so that it travels with the file wherever that is copied.
"""

from __future__ import annotations

import hashlib
import re
from collections.abc import Generator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from ...errors import OutputError
from ...tables import TABLES
from .folder import Folder
from .identity import MODELS, SETTINGS, SETTINGS_SHA256, VERSION
from .signals import interruptible

#: Key of a part's metadata, and its value until the file is complete.
DIGEST, BLANK = "proxemetry_sha256", "0" * 64
#: Thrift's compact protocol: a text (0x18) of 64 bytes (0x40) follows the key.
_BEFORE_DIGEST = DIGEST.encode() + b"\x18\x40"
#: What a Parquet file begins and ends with.
_PARQUET = b"PAR1"
_TEXT = "VARCHAR"

_THREADS = 8
#: Subfolder of the parts.
_SCENES = "scenes"
_REPAIR = "delete it (or add --repair), and the same `proxemetry measure` measures its photos again"
#: Files that a folder's own commands read: name of the subfolder, pattern, and what to do about a damaged one.
_KINDS = (
    (_SCENES, r"part-\d{6,}\.parquet", _REPAIR),
    ("manifest", r"manifest-\d{3,}\.parquet", "start again with --restart"),
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


#: The parts that this process has read and found whole, by folder, name, and the file's size and date.
_found_whole: set[tuple[object, ...]] = set()


def damaged_parts(folder: Folder, names: Sequence[str]) -> list[str]:
    """Return which of these parts, by their names in the folder, are not what was written, or cannot be read.

    A process reads a part once for this, as long as its size and date stay the same.
    """
    states = {f"{_SCENES}/{name}": state for name, state in folder.states(_SCENES).items()}

    def check(name: str) -> bool:
        key = (folder.location, name, states.get(name))
        if key in _found_whole:
            return True
        try:
            content = folder.read(name)
        except OutputError:
            return False
        whole = content is not None and (is_whole(content) or _is_of_before_digests(folder, name, content))
        if whole and name in states:
            _found_whole.add(key)
        return whole

    with ThreadPoolExecutor(_THREADS) as pool:
        return [name for name, whole in zip(names, pool.map(check, names), strict=True) if not whole]


def _is_of_before_digests(folder: Folder, name: str, content: bytes) -> bool:
    """Return whether a version that wrote no digests yet wrote a part, and it can be read to its end."""
    import duckdb

    if not (content.startswith(_PARQUET) and content.endswith(_PARQUET)):
        return False
    try:
        with _apart(folder) as duck:
            path = {"path": folder.path(name)}
            found = duck.execute("SELECT decode(key) FROM parquet_kv_metadata($path)", path).fetchall()
            # Every key, since one bit makes another key of the digest's.
            if {key for (key,) in found} != {VERSION, SETTINGS, SETTINGS_SHA256, MODELS}:
                return False
            _read_to_end(duck, "SELECT * FROM read_parquet($path)", path)
    except duckdb.Error:
        return False
    return True


def require_whole(folder: Folder, names: Sequence[str]) -> None:
    """Raise OutputError naming the damaged ones among these parts."""
    refusal = _of_damaged_parts(folder, names)
    if refusal is not None:
        raise refusal


def _of_damaged_parts(folder: Folder, names: Sequence[str]) -> OutputError | None:
    """Return the message of `require_whole`, None where every part is whole."""
    found = damaged_parts(folder, names)
    if not found:
        return None
    others = f" and {len(found) - 1} more" if len(found) > 1 else ""
    return OutputError(f"{folder.path(found[0])}{others}: damaged since it was written; {_REPAIR}")


@contextmanager
def explained(folder: Folder) -> Generator[None]:
    """Turn DuckDB's errors into OutputError that names the damaged file; a mistake in a query stays as it is."""
    import duckdb

    try:
        with interruptible():
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
    # No file is at fault: the disk is, which the writer's error explains, or the query.
    mistakes = (duckdb.BinderException, duckdb.CatalogException, duckdb.ParserException, duckdb.SyntaxException)
    if isinstance(error, (duckdb.IOException, *mistakes)):
        return None
    return OutputError(f"{folder.location}: cannot be read ({_first_line(error)})")


def _first_line(error: Exception) -> str:
    return (str(error).splitlines() or [type(error).__name__])[0]


def _find(folder: Folder) -> OutputError | None:
    """Return a message about the first file of a folder that is damaged or of another version, None without any."""
    for subfolder, pattern, advice in _KINDS:
        names = [name for name in folder.names(subfolder, ".parquet") if re.fullmatch(pattern, name)]
        paths = [f"{subfolder}/{name}".lstrip("/") for name in names]
        if subfolder == _SCENES:
            refusal = _of_damaged_parts(folder, paths)
        else:
            bad = next((path for path in paths if not _is_readable(folder, path)), None)
            refusal = None if bad is None else OutputError(f"{folder.path(bad)}: damaged; {advice}")
        if refusal is not None:
            return refusal
    with _apart(folder) as duck:
        return _of_another_version(folder, duck, {t: [c.name for c in columns] for t, columns in TABLES.items()})


def require_columns(folder: Folder, duck: Any, needed: Mapping[str, Sequence[str]]) -> None:
    """Raise OutputError where a table's Parquet file lacks a column, or has a text for a number, or the reverse.

    duck: to read the tables with. needed: names of columns by table.
    """
    refusal = _of_another_version(folder, duck, needed)
    if refusal is not None:
        raise refusal


def _of_another_version(folder: Folder, duck: Any, needed: Mapping[str, Sequence[str]]) -> OutputError | None:
    """Return the message of `require_columns`, None where every table that is there has the columns."""
    for table, names in needed.items():
        path = folder.path(f"{table}.parquet")
        if not folder.exists(f"{table}.parquet"):
            continue
        rows = duck.execute("DESCRIBE SELECT * FROM read_parquet($path)", {"path": path}).fetchall()
        found = {str(row[0]): str(row[1]) for row in rows}
        wanted = {column.name: column.kind for column in TABLES[table] if column.name in names}
        unlike = [n for n, kind in wanted.items() if n not in found or (found[n] == _TEXT) != (kind == _TEXT)]
        if unlike:
            return OutputError(
                f"{path}: written by another version of proxemetry (column {unlike[0]} is missing or of another type); "
                f"`proxemetry export {folder.location}` writes it again"
            )
    return None


def _is_readable(folder: Folder, name: str) -> bool:
    """Return whether a Parquet file without a digest can be read to its end; a list of photos with its columns."""
    import duckdb

    columns = "*" if name.removesuffix(".parquet") in TABLES else "shard, photo"
    try:
        with _apart(folder) as duck:
            _read_to_end(duck, f"SELECT {columns} FROM read_parquet($path)", {"path": folder.path(name)})
    except duckdb.Error:
        return False
    return True


@contextmanager
def _apart(folder: Folder) -> Generator[Any]:
    """Yield a DuckDB of its own: some damages leave the process's one unusable."""
    import duckdb

    with duckdb.connect(config={"threads": 1, "autoload_known_extensions": False}) as duck:
        if folder.filesystem is not None:
            duck.register_filesystem(folder.filesystem)
        with interruptible():
            yield duck


def _read_to_end(duck: Any, query: str, parameters: Mapping[str, str]) -> None:
    duck.execute(query, parameters)
    while duck.fetchmany(10_000):
        pass
