"""The networks' files: where they lie, whether they are intact, and how they get there.

They lie in the user's cache folder; `PROXEMETRY_CACHE` names another, or several separated as in `PATH`: all are
searched in order, and the first that can be written receives what is fetched (the others may be read-only and
shared). `PROXEMETRY_OFFLINE=1` forbids fetching; `PROXEMETRY_MIRROR` is a web address tried before all others.
"""

from __future__ import annotations

import logging
import shutil
from collections.abc import Callable, Iterable
from pathlib import Path

from ..errors import ModelError
from ..files import reason_of, sha256_of
from .cache import (
    LocatedModel,
    Progress,
    cache_folders,
    folders_text,
    is_here,
    is_offline,
    locate,
    open_for_placing,
    parts_are_here,
    verify,
)
from .table import EMBEDDED, EMBEDDED_FINDER, MODELS, PUPILS, Model, model_named

__all__ = [
    "EMBEDDED", "EMBEDDED_FINDER", "MODELS", "PUPILS", "LocatedModel", "Model", "Progress", "add", "cache_folders",
    "fetch", "if_to_be_had", "is_here", "is_offline", "locate", "model_named", "obtain", "require", "verify",
]  # fmt: skip


_LOG = logging.getLogger("proxemetry")


def obtain(name: str) -> LocatedModel:
    """Return a network's file, checked: its own, made of its parts where those are here, or the same in another form.

    Raises ModelError as `verify` does where there is none of these.
    """
    model = model_named(name)
    others = [form for form in model.same_as if locate(form) is not None]
    if locate(model.name) is None and parts_are_here(model):
        from .making import make

        try:
            make(model)
        except (ModelError, OSError):
            if not others:
                raise
    if locate(model.name) is None and others:
        return verify(others[0])
    return verify(model.name)


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


def if_to_be_had(
    name: str, *, may_fetch: bool = True, offline: bool = False, log: Callable[[str], None] | None = None
) -> LocatedModel | None:
    """Return a network that is of use but not needed, fetched where that may be; None where it cannot be had.

    may_fetch: False where it was tried before: a run neither waits for it again nor finds other people one day.
    Why not is one line for `log`, or a warning of the `proxemetry` logger. Raises ModelError where the file is there
    and damaged.
    """
    if locate(name) is None:
        if not may_fetch:
            (log or _LOG.warning)(
                f"fewer people are found: {name} is not here; `proxemetry models fetch {name}` gets it"
            )
            return None
        try:
            fetch([name], offline=offline, log=log)
        except ModelError as error:
            (log or _LOG.warning)(f"fewer people are found: {error}")
            return None
    return verify(name)


def fetch(
    names: Iterable[str],
    *,
    accept_licence: bool = False,
    offline: bool = False,
    log: Callable[[str], None] | None = None,
    progress: Progress | None = None,
) -> list[LocatedModel]:
    """Fetch the named networks' files into the cache where they are not there yet, and check them.

    accept_licence: needed for files whose licence forbids commercial use. log: is called with one line for each
    download; without it the line goes to the `proxemetry` logger as a warning. progress: called while a download runs.
    Raises ModelError where a file cannot be had: offline, licence not accepted, no source, every source failed.
    """
    from .fetching import fetch_absent

    models = [model_named(name) for name in names]
    absent = [model for model in models if not is_here(model.name)]
    for model in absent:
        if not model.commercial_use and not accept_licence:
            raise ModelError(
                f"{model.name}: its licence ({model.licence}) forbids commercial use; "
                "give --accept-licence if yours is not"
            )
    if absent and (offline or is_offline()):
        listed = ", ".join(model.name for model in absent)
        raise ModelError(
            f"{listed}: not in {folders_text()}, and fetching is forbidden (offline); "
            "run `proxemetry models fetch` once with a network"
        )
    if absent:
        fetch_absent(absent, log, progress)
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
