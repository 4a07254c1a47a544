"""Which files may be copies of each other: found by size and end, so that an archive need not be read for it.

Only files of equal size are looked into, and only at their end, where compressed pixels differ between any two photos:
one small read each. The measurement compares whole files, so that a chance likeness costs one comparison.
"""

from __future__ import annotations

import hashlib
import os
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ... import files
from ...files import open_file
from ..store.folder import is_url, open_filesystem
from ..store.photos import locate

Sizes = NDArray[np.int64]
Ends = NDArray[np.uint64]

_TAIL_BYTES = 4096
#: Reads that wait for a disk or a server at a time, and files given to a thread at once.
_THREADS, _FILES_AT_ONCE = 16, 256


@dataclass(frozen=True, eq=False)
class Duplicates:
    """What is alike among `n` new files and some older ones.

    duplicate_of: shape (n,), the number of the first new file that may be the same one, -1 where none is. original:
    shape (n,), the number of an older one, -1 where none is.
    """

    duplicate_of: NDArray[np.int64]
    original: NDArray[np.int64]


def sizes_of(root: str, names: Sequence[str]) -> Sizes:
    """Return the files' sizes in bytes, -1 where one is unknown: measuring the file shows what is wrong."""
    if not is_url(root):
        return _mapped(lambda name: _size(root, name), names, np.int64)
    found: dict[str, Any] = open_filesystem(root).find(root, detail=True)
    prefix = root.partition("://")[2].rstrip("/").lstrip("/") + "/"
    sizes = {path.lstrip("/").removeprefix(prefix): info.get("size") for path, info in found.items()}
    return np.array([-1 if sizes.get(name) is None else sizes[name] for name in names], dtype=np.int64)


def ends_of(root: str, names: Sequence[str], sizes: Sizes) -> Ends:
    """Return a digest of each file's end."""
    known = dict(zip(names, sizes.tolist(), strict=True))
    return _mapped(lambda name: _end(locate(root, name), known[name]), names, np.uint64)


def sha256_of(location: str) -> str:
    """Return the SHA-256 of a whole file, "" where there is none that can be read."""
    try:
        if is_url(location):
            return hashlib.sha256(open_filesystem(location).cat_file(location)).hexdigest()
        return files.sha256_of(location)
    except OSError:
        return ""


def repeated(sizes: Sizes, older: Sizes) -> NDArray[np.bool_]:
    """Return which files have a size that another new file or an older one has too, shape (n,)."""
    values, place, times = np.unique(sizes, return_inverse=True, return_counts=True)
    return ((times > 1) | np.isin(values, older))[place] & (sizes >= 0)


def find_duplicates(sizes: Sizes, ends: Ends, older_sizes: Sizes, older_ends: Ends) -> Duplicates:
    """Return which new files, shape (n,), may be copies of each other or of older ones, shape (m,)."""
    n = len(sizes)
    size, end = np.concatenate([sizes, older_sizes]), np.concatenate([ends, older_ends])
    order = np.lexsort((np.arange(len(size)), end, size))  # the new ones first in each run of like ones
    begins = np.append(True, (np.diff(size[order]) != 0) | (np.diff(end[order]) != 0))[: len(order)]
    run = np.cumsum(begins) - 1
    first = order[begins][run]
    is_old = order >= n
    n_new = np.bincount(run, weights=~is_old)[run] if len(run) else run
    old = np.full(int(run[-1]) + 1 if len(run) else 0, -1, dtype=np.int64)
    old[run[is_old][::-1]] = order[is_old][::-1] - n  # the first of several
    duplicate_of, original = np.full(n, -1, dtype=np.int64), np.full(n, -1, dtype=np.int64)
    mine = ~is_old
    duplicate_of[order[mine]] = np.where(n_new > 1, first, -1)[mine]
    original[order[mine]] = old[run][mine]
    return Duplicates(duplicate_of, original)


def _mapped(function: Callable[[str], int], names: Sequence[str], kind: Any) -> NDArray[Any]:
    """Return the function of every name, many at a time: a disk far away takes its time for each."""
    batches = [names[start : start + _FILES_AT_ONCE] for start in range(0, len(names), _FILES_AT_ONCE)]
    with ThreadPoolExecutor(_THREADS) as pool:
        found = pool.map(lambda batch: [function(name) for name in batch], batches)
        return np.fromiter((value for batch in found for value in batch), dtype=kind, count=len(names))


def _size(root: str, name: str) -> int:
    try:
        return os.stat(f"{root}/{name}" if "\\x" not in name else locate(root, name)).st_size
    except OSError:
        return -1


def _end(location: str, size: int) -> int:
    start = max(0, size - _TAIL_BYTES)
    try:
        if is_url(location):
            end = open_filesystem(location).cat_file(location, start=start)
        else:
            with open_file(location) as file:
                file.seek(start)
                end = file.read()
    except OSError:
        end = location.encode(errors="surrogateescape")  # like nothing else
    return int.from_bytes(hashlib.blake2b(end, digest_size=8).digest(), "little")
