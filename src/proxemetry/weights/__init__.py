"""The networks' files: where they lie, whether they are whole, and how they get there.

They lie in the user's cache folder; `PROXEMETRY_CACHE` names another, or several separated as in `PATH`: all are
searched in order, and the first that can be written receives what is fetched (the others may be read-only and
shared). `PROXEMETRY_OFFLINE=1` forbids fetching; `PROXEMETRY_MIRROR` is a web address tried before all others.
"""

from __future__ import annotations

import logging
import os
import shutil
import tempfile
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from pathlib import Path

from ..errors import ModelError
from ..files import reason_of, sha256_of
from .table import EMBEDDED, EMBEDDED_FINDER, MODELS, Model, model_named

__all__ = [
    "EMBEDDED", "EMBEDDED_FINDER", "MODELS", "LocatedModel", "Model", "Progress", "add", "cache_folders", "fetch",
    "if_to_be_had", "is_here", "is_offline", "locate", "model_named", "obtain", "require", "verify",
]  # fmt: skip

#: Called while something large is fetched: bytes that are here, and of how many (None where unknown).
Progress = Callable[[int, int | None], None]

_LOG = logging.getLogger("proxemetry")


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
    """Return where a network's file lies, unchecked, or None where it is in no cache folder."""
    model = model_named(name)
    for folder in cache_folders():
        if (folder / model.name).is_file():
            return folder / model.name
    return None


def verify(name: str) -> LocatedModel:
    """Return a network's file with its hash checked.

    Raises ModelError where it is absent or its content is not what the table, or the record of its first arrival,
    says.
    """
    model = model_named(name)
    path = locate(model.name)
    if path is None:
        raise ModelError(f"{model.name}: not in {_folders_text()}; get it with `proxemetry models {_how(model)}`")
    try:
        found, expected = sha256_of(path), _expected_hash(model, path)
    except OSError as error:
        raise ModelError(f"{path}: cannot be read ({reason_of(error)})") from error
    if not found.startswith(expected):
        raise ModelError(
            f"{path}: damaged or another file: sha256 is {found}, expected {expected}; "
            f"delete it and run `proxemetry models {_how(model)}`"
        )
    return LocatedModel(model, path, found)


def is_here(name: str) -> bool:
    """Return whether a network runs without fetching: its file, its parts, or the same in another form is here."""
    model = model_named(name)
    forms = (model.name, *model.same_as)
    return any(locate(form) is not None for form in forms) or _parts_are_here(model)


def obtain(name: str) -> LocatedModel:
    """Return a network's file, checked: its own, made of its parts where those are here, or the same in another form.

    Raises ModelError as `verify` does where there is none of these.
    """
    model = model_named(name)
    others = [form for form in model.same_as if locate(form) is not None]
    if locate(model.name) is None and _parts_are_here(model):
        from .making import make

        try:
            make(model)
        except (ModelError, OSError):
            if not others:
                raise
    if locate(model.name) is None and others:
        return verify(others[0])
    return verify(model.name)


def _parts_are_here(model: Model) -> bool:
    return model.conversion is not None and all(locate(part) is not None for part in model.conversion.parts)


def require(names: Iterable[str], *, may_fetch: bool = False, offline: bool = False) -> dict[str, LocatedModel]:
    """Return the named networks' files, each checked.

    Absent files are fetched only with `may_fetch`, and never with `offline` or PROXEMETRY_OFFLINE.
    Raises ModelError where one is absent or damaged.
    """
    names = list(names)
    absent = [name for name in names if not is_here(name)]
    if absent and may_fetch:
        fetch(absent, offline=offline)
    return {model_named(name).name: obtain(name) for name in names}


def if_to_be_had(name: str, *, offline: bool = False, say: Callable[[str], None] | None = None) -> LocatedModel | None:
    """Return a network that is of use but not needed, fetched where that may be; None where it cannot be had.

    Why not is one line for `say`, or a warning of the `proxemetry` logger. Raises ModelError where the file is there
    and damaged.
    """
    if locate(name) is None:
        try:
            fetch([name], offline=offline, say=say)
        except ModelError as error:
            (say or _LOG.warning)(f"fewer people are found: {error}")
            return None
    return verify(name)


def fetch(
    names: Iterable[str],
    *,
    accept_licence: bool = False,
    offline: bool = False,
    say: Callable[[str], None] | None = None,
    progress: Progress | None = None,
) -> list[LocatedModel]:
    """Fetch the named networks' files into the cache where they are not there yet, and check them.

    accept_licence: needed for files whose licence forbids commercial use. say: takes one line for each download;
    without it the line goes to the `proxemetry` logger as a warning. progress: called while a download runs.
    Raises ModelError where a file cannot be had: offline, licence not accepted, no source, every source failed.
    """
    from .fetching import fetch_absent

    models = [model_named(name) for name in names]
    absent = [model for model in models if not is_here(model.name)]
    for model in absent:
        if not model.commercial_use and not accept_licence:
            raise ModelError(
                f"{model.name}: its licence ({model.licence}) forbids commercial use; "
                "say --accept-licence if yours is not"
            )
    if absent and (offline or is_offline()):
        listed = ", ".join(model.name for model in absent)
        raise ModelError(
            f"{listed}: not in {_folders_text()}, and fetching is forbidden (offline); "
            "run `proxemetry models fetch` once with a network"
        )
    if absent:
        fetch_absent(absent, say, progress)
    return [obtain(model.name) for model in models]


def add(file: str | Path, name: str | None = None) -> LocatedModel:
    """Copy a file that the user has into the cache and return it; its content must be a network of the table.

    name: which network it is; without it the hash decides. Raises ModelError where the content is not that network.
    """
    file = Path(file)
    try:
        digest = sha256_of(file)
    except FileNotFoundError as error:
        raise ModelError(f"{file}: no such file") from error
    except OSError as error:
        raise ModelError(f"{file}: cannot be read ({reason_of(error)})") from error
    if name is None:
        known = [model for model in MODELS.values() if model.sha256 and digest.startswith(model.sha256)]
        if not known:
            raise ModelError(f"{file}: its sha256 {digest} is in no row of the table (`proxemetry models list`)")
        model = known[0]
    else:
        model = model_named(name)
    with open_for_placing(model) as placing:
        shutil.copyfile(file, placing.temporary)
        placing.place()
    return verify(model.name)


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
            raise ModelError(
                f"{self.model.name}: what arrived has sha256 {digest}, expected {self.model.sha256}; it was not kept"
            )
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
    raise ModelError(f"{_folders_text()}: cannot be written; name a folder that can with PROXEMETRY_CACHE")


def _record_path(path: Path) -> Path:
    return path.with_name(path.name + ".sha256")


def _expected_hash(model: Model, path: Path) -> str:
    """Return the whole hash where it is known: from the table, or from the record of the file's first arrival."""
    record = _record_path(path)
    if model.hash_is_complete or not record.is_file():
        return model.sha256
    recorded = record.read_text().split(maxsplit=1)
    return recorded[0] if recorded and recorded[0].startswith(model.sha256) else model.sha256


def _folders_text() -> str:
    return os.pathsep.join(str(folder) for folder in cache_folders())


def _how(model: Model) -> str:
    return f"fetch {model.name}" if model.can_be_had else f"add FILE --name {model.name}"
