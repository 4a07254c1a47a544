"""Which photos a run is about: files, folders, globs and URLs as given, each with its name in the results."""

from __future__ import annotations

import glob
import os
import posixpath
import re
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any

from ...errors import SettingsError
from ...files import readable_name
from ...photo import EXTENSIONS
from .folder import OVERLAYS, RUN_FILE, is_url, local_path, open_filesystem, path_in_store

_ESCAPED = re.compile(rb"\\x([89a-f][0-9a-f]|5c)")
_ENDINGS = frozenset(ending[1:] for ending in EXTENSIONS)


#: Folders in which file servers, cards and photo managers keep copies of their own making, or what was deleted.
_NOT_PHOTOGRAPHED = frozenset(
    (
        "@eadir", "@__thumb", "#recycle", "#snapshot", "@recycle", "@recently-snapshot", "__macosx", "$recycle.bin",
        "system volume information", "lost+found",
    )
)  # fmt: skip
_PREVIEWS = (".lrdata", ".lrprev")
#: Photo managers' libraries: what else lies in them is previews.
_LIBRARIES, _ORIGINALS = (".photoslibrary", ".aplibrary", ".migratedphotolibrary"), ("originals", "masters")


@dataclass
class PassedOver:
    """What a search saw and left out: files by their ending, and folders of thumbnails by their name."""

    endings: Counter[str] = field(default_factory=Counter[str])
    folders: Counter[str] = field(default_factory=Counter[str])

    def __str__(self) -> str:
        """One line, "" where nothing was left out."""
        parts: list[str] = []
        if self.endings:
            often = sorted(self.endings.items(), key=lambda found: (-found[1], found[0]))[:_ENDINGS_SHOWN]
            shown = ", ".join(f"{count} {ending}" for ending, count in often)
            rest = len(self.endings) - _ENDINGS_SHOWN
            more = f" and {rest} more endings" if rest > 0 else ""
            parts.append(f"{_counted(self.endings.total(), 'file')} passed over by their endings ({shown}{more})")
        if self.folders:
            names = ", ".join(sorted(self.folders)[:_ENDINGS_SHOWN])
            parts.append(f"{_counted(self.folders.total(), 'folder')} of thumbnails left out ({names})")
        return "; ".join(parts)


_ENDINGS_SHOWN = 6


def _counted(count: int, what: str) -> str:
    return f"{count} {what}{'' if count == 1 else 's'}"


@dataclass(frozen=True)
class Listing:
    """Photos by their name relative to `root`, the folder named (the deepest one that holds everything named).

    passed_over: the files next to them that were not taken for photos, in a line; "" for none.
    """

    root: str
    names: tuple[str, ...]
    passed_over: str = ""

    def location(self, name: str) -> str:
        """Return the path or URL of a photo."""
        return locate(self.root, name)


def locate(root: str, name: str) -> str:
    """Return the path or URL of the photo called `name` relative to `root`."""
    if is_url(root):
        return posixpath.join(root, name)
    if "\\x" in name:  # a name of bytes that are no text, see `files.readable_name`
        name = os.fsdecode(_ESCAPED.sub(lambda found: bytes([int(found[1], 16)]), os.fsencode(name)))
    return os.path.normpath(os.path.join(root, name))


@dataclass(frozen=True)
class Search:
    """What was named, before any folder is walked.

    found: files named outright. without: a folder that is not walked. given: the paths as they were given.
    """

    root: str
    folders: tuple[str, ...] = ()
    found: tuple[str, ...] = ()
    given: str = ""
    without: str = ""

    def any(self) -> bool:
        """Return whether there is a photo at all, looking no further than the first; a store is taken to have some."""
        if self.found or is_url(self.root):
            return True
        return any(True for folder in self.folders for _ in _files(folder, self.without))

    def listing(self, stop: Callable[[], bool] = lambda: False) -> Listing:
        """Return all photos in the order of their names; raises SettingsError where there is none.

        stop: asked now and then whether to end early, with what was found so far.
        """
        files, passed = list(self.found), PassedOver()
        for folder in self.folders:
            files.extend(_files(folder, self.without, stop, passed))
        if not files:
            raise self.nothing()
        if is_url(self.root):
            bare = self.root.partition("://")[2]
            return Listing(self.root, tuple(sorted({posixpath.relpath(file, bare) for file in files})), str(passed))
        start = len(self.root) + (not self.root.endswith(os.sep))  # all files lie below the root: cutting is quick
        names = [file[start:] for file in files]
        if os.sep != "/":
            names = [name.replace(os.sep, "/") for name in names]
        if not all(map(str.isascii, names)) or any("\\x" in name for name in names):
            names = [readable_name(name) for name in names]
        once = names if len(self.folders) == 1 and not self.found else set(names)
        return Listing(self.root, tuple(sorted(once)), str(passed))

    def nothing(self) -> SettingsError:
        """Return what to raise where no photo is found."""
        return SettingsError(f"{self.given}: no photos there ({' '.join(EXTENSIONS)} are looked for)")


def find_photos(paths: Sequence[str]) -> Listing:
    """Return all photos in the files, folders, globs and URLs given; raises SettingsError, see `search`."""
    return search(paths).listing()


def search(paths: Sequence[str]) -> Search:
    """Return what is named by files, folders, globs and URLs.

    A file named outright is a photo whatever its ending; folders are searched, all the way down, for
    `photo.EXTENSIONS`. Raises SettingsError where something named does not exist.
    """
    if any(map(is_url, paths)):
        return _search_remote(paths)
    roots: list[str] = []
    files: list[str] = []
    folders: list[str] = []
    for path in map(local_path, paths):
        for found in _expanded(path):
            is_folder = os.path.isdir(found)
            folder = found if is_folder else os.path.dirname(found)
            roots.append(os.path.abspath(_fixed_part(path) if glob.has_magic(path) else folder or "."))
            (folders if is_folder else files).append(os.path.abspath(found))
    return Search(os.path.commonpath(roots), tuple(dict.fromkeys(folders)), tuple(files), ", ".join(paths))


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


def _files(
    folder: str, without: str = "", stop: Callable[[], bool] = lambda: False, passed: PassedOver | None = None
) -> Iterator[str]:
    """Yield the photos in a folder and below.

    Hidden ones are left out, and what earlier runs drew of others; into `passed` goes what else is no photo.
    """
    passed = passed or PassedOver()
    if "://" in folder:
        yield from _remote_files(folder, passed)
        return
    open_folders = [folder]
    while open_folders and not stop():
        where = open_folders.pop()
        if where == without:
            continue
        prefix = os.path.join(where, "")
        try:
            entries = list(os.scandir(where))
        except OSError as error:
            raise SettingsError(f"{where}: cannot be read ({error.strerror})") from error
        in_library = where.lower().endswith(_LIBRARIES)
        for entry in entries:  # a million times in a large archive
            name = entry.name
            if name[0] == ".":
                continue
            ending = name.rpartition(".")[2].lower()
            if ending in _ENDINGS and not _is_folder(entry):
                yield prefix + name
            elif not _is_folder(entry, follow=False):  # a link may lead back here
                if not _is_folder(entry):
                    passed.endings[f".{ending}" if "." in name else "without one"] += 1
            elif _is_left_out(name, in_library):
                passed.folders[name] += 1
            elif not (name == OVERLAYS and os.path.isfile(prefix + RUN_FILE)):
                open_folders.append(prefix + name)


def _is_folder(entry: os.DirEntry[str], *, follow: bool = True) -> bool:
    """Return whether a folder's entry is a folder; not where it cannot be looked at, as a link to itself."""
    try:
        return entry.is_dir(follow_symlinks=follow)
    except OSError:
        return False


def _is_left_out(name: str, in_library: bool) -> bool:
    """Whether a folder, by its name, holds thumbnails that a program made, or what was thrown away."""
    lower = name.lower()
    return lower in _NOT_PHOTOGRAPHED or lower.endswith(_PREVIEWS) or (in_library and lower not in _ORIGINALS)


def _remote_files(folder: str, passed: PassedOver) -> Iterator[str]:
    filesystem: Any = open_filesystem(folder)
    bare = path_in_store(folder)
    for file in filesystem.find(bare):
        parts = posixpath.relpath(file, bare).split("/")
        nested = zip(parts[:-1], ["", *parts], strict=False)  # each folder with the one that it lies in
        left_out = next((n for n, above in nested if _is_left_out(n, above.lower().endswith(_LIBRARIES))), None)
        ending = parts[-1].rpartition(".")[2].lower()
        if left_out is not None:
            passed.folders[left_out] = 1
        elif ending in _ENDINGS:
            yield file
        elif parts[-1][0] != ".":
            passed.endings[f".{ending}" if "." in parts[-1] else "without one"] += 1


def _search_remote(paths: Sequence[str]) -> Search:
    if not all(map(is_url, paths)):
        raise SettingsError("photos are either all at URLs or all local: run twice, into two folders")
    protocol = paths[0].partition("://")[0]
    if any(p.partition("://")[0] != protocol for p in paths):
        raise SettingsError("photos at URLs must all be on one kind of store: run twice, into two folders")
    filesystem: Any = open_filesystem(paths[0])
    roots: list[str] = []
    files: list[str] = []
    folders: list[str] = []
    for path in paths:
        bare = path_in_store(path)
        matches = filesystem.glob(bare) if glob.has_magic(bare) else [bare]
        for match in matches:
            if filesystem.isdir(match):
                roots.append(match)
                folders.append(f"{protocol}://{match}")
            elif filesystem.exists(match):
                roots.append(posixpath.dirname(match))
                files.append(match)
            else:
                raise SettingsError(f"{path}: no such file or folder")
    if not roots:
        raise SettingsError(f"{', '.join(paths)}: no photos match")
    root = f"{protocol}://{posixpath.commonpath(roots)}"
    return Search(root, tuple(dict.fromkeys(folders)), tuple(files), ", ".join(paths))
