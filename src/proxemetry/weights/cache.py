"""The cache of networks on this machine: where a file is, whether it is intact, and how a new one gets in."""

from __future__ import annotations

import os
import stat
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from ..errors import CacheError, ModelError
from ..files import reason_of, sha256_of
from .table import Model, model_named

#: What may lie in a file's place.
_KINDS = {stat.S_IFDIR: "a folder", stat.S_IFIFO: "a pipe", stat.S_IFSOCK: "a socket"}

#: Called while something large is fetched: bytes that are here, and of how many (None where unknown).
Progress = Callable[[int, int | None], None]
#: Called with a line that the user should read.
Log = Callable[[str], None]


@dataclass(frozen=True)
class LocatedModel:
    """A network's file that is there and whole: its path and its full sha256."""

    model: Model
    path: Path
    sha256: str


def cache_folders() -> list[Path]:
    """Return the folders that are searched for networks, in order."""
    stated = [part for part in os.environ.get("PROXEMETRY_CACHE", "").split(os.pathsep) if part]
    if stated:
        return [Path(part).expanduser() for part in stated]
    from platformdirs import user_cache_path

    return [user_cache_path("proxemetry", appauthor=False) / "models"]


def is_offline() -> bool:
    """Return whether the environment forbids fetching."""
    return os.environ.get("PROXEMETRY_OFFLINE", "").lower() not in ("", "0", "false", "no")


def locate(name: str) -> Path | None:
    """Return where a network's file lies, its content unchecked, or None where it is in no cache folder.

    Raises ModelError where what has its name is no file: a folder, a link to nowhere, a pipe. It is not absent, and
    what would be put in its place must not hide that.
    """
    model = model_named(name)
    for folder in cache_folders():
        path = folder / model.name
        try:
            kind = stat.S_IFMT(path.stat().st_mode) if os.path.lexists(path) else None
        except OSError as error:
            what = "a link to nowhere" if path.is_symlink() else f"not to be read ({reason_of(error)})"
            raise ModelError(f"{path}: is {what}; {_remedy(model)}") from error
        if kind == stat.S_IFREG:
            return path
        if kind is not None:
            raise ModelError(f"{path}: is {_KINDS.get(kind, 'no file')}, not a network; {_remedy(model)}")
    return None


def verify(name: str) -> LocatedModel:
    """Return a network's file with its hash checked.

    Raises ModelError where it is absent or its content is not what the table, or the record of its first arrival,
    says.
    """
    model = model_named(name)
    path = locate(model.name)
    if path is None:
        raise ModelError(f"{model.name}: not in {folders_text()}; get it with `proxemetry models {_how(model)}`")
    try:
        found, expected = sha256_of(path), _expected_hash(model, path)
    except OSError as error:
        raise ModelError(f"{path}: cannot be read ({reason_of(error)})") from error
    if not found.startswith(expected):
        raise ModelError(f"{path}: damaged or another file: sha256 is {found}, expected {expected}; {_remedy(model)}")
    return LocatedModel(model, path, found)


def is_here(name: str) -> bool:
    """Return whether a network runs without fetching: its file, its parts, or the same in another form is here.

    Raises ModelError as `locate` does for any of these, whatever else is here.
    """
    model = model_named(name)
    forms = [locate(form) for form in (model.name, *model.same_as)]
    return parts_are_here(model) or any(path is not None for path in forms)


def parts_are_here(model: Model) -> bool:
    """Return whether all files are here that a network can be made of."""
    parts = [locate(part) for part in model.conversion.parts] if model.conversion else [None]
    return all(path is not None for path in parts)


class open_for_placing:  # noqa: N801 - used as a context, like open()
    """A temporary file in the cache that becomes a network's file, whole and checked, in one step."""

    def __init__(self, model: Model) -> None:
        self.model = model
        self.folder = writable_folder()
        handle, name = tempfile.mkstemp(prefix=f".{model.name}.", dir=self.folder)
        os.close(handle)
        self.temporary = Path(name)

    def __enter__(self) -> open_for_placing:
        return self

    def __exit__(self, *_: object) -> None:
        self.temporary.unlink(missing_ok=True)

    def place(self) -> None:
        """Check the temporary file's hash, record it where the table knows a prefix only, and put it in place."""
        digest = sha256_of(self.temporary)
        if not digest.startswith(self.model.sha256):
            raise ModelError(f"what arrived has sha256 {digest}, expected {self.model.sha256}; it was not kept")
        self.temporary.chmod(0o644)  # temporary files are private, a cache may be shared
        if not self.model.hash_is_complete:
            record = self.temporary.with_suffix(".sha256")
            record.write_text(f"{digest}  {self.model.name}\n")
            record.replace(_record_path(self.folder / self.model.name))
        self.temporary.replace(self.folder / self.model.name)


def writable_folder() -> Path:
    """Return the first cache folder that can be written, made where need be; raises ModelError where none can."""
    for folder in cache_folders():
        try:
            folder.mkdir(parents=True, exist_ok=True)
        except OSError:
            continue
        if os.access(folder, os.W_OK):
            return folder
    raise CacheError(f"{folders_text()}: cannot be written; name a folder that can with PROXEMETRY_CACHE")


def _record_path(path: Path) -> Path:
    return path.with_name(path.name + ".sha256")


def _expected_hash(model: Model, path: Path) -> str:
    """Return the whole hash where it is known: from the table, or from the record of the file's first arrival."""
    record = _record_path(path)
    if model.hash_is_complete or not record.is_file():
        return model.sha256
    recorded = record.read_text().split(maxsplit=1)
    return recorded[0] if recorded and recorded[0].startswith(model.sha256) else model.sha256


def folders_text() -> str:
    """Return the cache folders as a message names them."""
    return os.pathsep.join(str(folder) for folder in cache_folders())


def _how(model: Model) -> str:
    return f"fetch {model.name}" if model.can_be_had else f"add FILE --name {model.name}"


def _remedy(model: Model) -> str:
    return f"delete it and run `proxemetry models {_how(model)}`"
