"""Which photos a run is about: files, folders, globs and URLs as given, each with its name in the results."""

from __future__ import annotations

import glob
import os
import posixpath
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from ..errors import SettingsError
from ..photo import EXTENSIONS
from .folder import is_url, local_path, open_filesystem

_ENDINGS = frozenset(ending[1:] for ending in EXTENSIONS)


@dataclass(frozen=True)
class Listing:
    """Photos by their name relative to `root`, the folder named (the deepest one that holds everything named)."""

    root: str
    names: tuple[str, ...]

    def location(self, name: str) -> str:
        """Return the path or URL of a photo."""
        return locate(self.root, name)


def locate(root: str, name: str) -> str:
    """Return the path or URL of the photo called `name` relative to `root`."""
    return posixpath.join(root, name) if is_url(root) else os.path.normpath(os.path.join(root, name))


def find_photos(paths: Sequence[str]) -> Listing:
    """Return all photos in the files, folders, globs and URLs given, in the order of their names.

    A file named outright is a photo whatever its ending; folders are searched, all the way down, for
    `photo.EXTENSIONS`. Raises SettingsError where something named does not exist or nothing is found.
    """
    if any(map(is_url, paths)):
        return _find_remote(paths)
    roots: list[str] = []
    files: list[str] = []
    for path in map(local_path, paths):
        for found in _expanded(path):
            folder = found if os.path.isdir(found) else os.path.dirname(found)
            roots.append(os.path.abspath(_fixed_part(path) if glob.has_magic(path) else folder or "."))
            files.extend(_walk(found) if os.path.isdir(found) else [os.path.abspath(found)])
    if not files:
        raise SettingsError(f"{', '.join(paths)}: no photos there ({' '.join(EXTENSIONS)} are looked for)")
    root = os.path.commonpath(roots)
    start = len(root) + (not root.endswith(os.sep))  # all files lie below the root: cutting it off is quick
    names = {file[start:] for file in files}
    if os.sep != "/":
        names = {name.replace(os.sep, "/") for name in names}
    return Listing(root, tuple(sorted(names)))


def has_photos(path: str) -> bool:
    """Return whether there is anything to find at a path; False only for a local folder without photos."""
    return is_url(path) or not os.path.isdir(local_path(path)) or bool(_walk(local_path(path)))


def _expanded(path: str) -> list[str]:
    if os.path.exists(path):
        return [path]
    if glob.has_magic(path):
        found = [p for p in glob.glob(path, recursive=True) if os.path.isdir(p) or p.lower().endswith(EXTENSIONS)]
        if found:
            return sorted(found)
        raise SettingsError(f"{path}: no photos match")
    raise SettingsError(f"{path}: no such file or folder")


def _fixed_part(pattern: str) -> str:
    """Return the deepest folder of a glob pattern without wildcards."""
    head = pattern
    while glob.has_magic(head):
        head = os.path.dirname(head)
    return head or "."


def _walk(folder: str) -> list[str]:
    """Return the photos in a folder and below, hidden ones left out."""
    found: list[str] = []
    open_folders = [os.path.abspath(folder)]
    while open_folders:
        where = open_folders.pop()
        prefix = os.path.join(where, "")
        try:
            entries = list(os.scandir(where))
        except OSError as error:
            raise SettingsError(f"{where}: cannot be read ({error.strerror})") from error
        for entry in entries:  # a million times in a large archive
            name = entry.name
            if name[0] == ".":
                continue
            if name.rpartition(".")[2].lower() in _ENDINGS and not entry.is_dir():
                found.append(prefix + name)
            elif entry.is_dir(follow_symlinks=False):  # a link may lead back here
                open_folders.append(prefix + name)
    return found


def _find_remote(paths: Sequence[str]) -> Listing:
    if not all(map(is_url, paths)):
        raise SettingsError("photos are either all at URLs or all local: run twice, into two folders")
    protocol = paths[0].partition("://")[0]
    if any(p.partition("://")[0] != protocol for p in paths):
        raise SettingsError("photos at URLs must all be on one kind of store: run twice, into two folders")
    filesystem: Any = open_filesystem(paths[0])
    roots: list[str] = []
    files: list[str] = []
    for path in paths:
        bare = filesystem._strip_protocol(path)
        matches = filesystem.glob(bare) if glob.has_magic(bare) else [bare]
        for match in matches:
            if filesystem.isdir(match):
                roots.append(match)
                files.extend(f for f in filesystem.find(match) if f.lower().endswith(EXTENSIONS))
            elif filesystem.exists(match):
                roots.append(posixpath.dirname(match))
                files.append(match)
            else:
                raise SettingsError(f"{path}: no such file or folder")
    if not files:
        raise SettingsError(f"{', '.join(paths)}: no photos there ({' '.join(EXTENSIONS)} are looked for)")
    root = posixpath.commonpath(roots)
    names = sorted({posixpath.relpath(file, root) for file in files})
    return Listing(f"{protocol}://{root}", tuple(names))
