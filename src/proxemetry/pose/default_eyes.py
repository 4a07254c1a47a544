"""Which back end `auto` is: the best whose networks could be had when they were fetched, written down and kept to.

Other files in a cache change nothing: the choice is made once, by `proxemetry models fetch` or at first
use, and stands in a file next to the networks until `models fetch` makes it again.
"""

from __future__ import annotations

import json
import logging
import os
from collections.abc import Callable
from pathlib import Path

from .. import weights
from ..errors import CacheError, ModelError, SettingsError
from ..files import read_json
from ..weights.cache import folders_text, writable_folder
from .registry import BACKENDS, is_available

_LOG = logging.getLogger("proxemetry")
_RECORD = "default-eyes.json"

#: Best first: measured on photos with known distances (docs/backends.md).
EYES = ("yolox-tinypose", "nanodet-movenet", "blazepose")

Log = Callable[[str], None]


def recorded() -> str | None:
    """Return the back end that was chosen on this machine, None where none was.

    Raises SettingsError where the record is damaged or names a back end that does not exist.
    """
    for folder in weights.cache_folders():
        path = folder / _RECORD
        if os.path.lexists(path):
            return _read(path)
    return None


def _read(path: Path) -> str:
    try:
        name = read_json(path)["pose"]
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise SettingsError(f"{path}: damaged; delete it and run `proxemetry models fetch`") from error
    if name not in BACKENDS:
        raise SettingsError(f"{path}: names the back end {name!r}, which is unknown; run `proxemetry models fetch`")
    return name


def chosen(*, offline: bool = False, log: Log | None = None) -> str:
    """Return the back end that `auto` is; where none was chosen before, choose, fetch and write it down."""
    return recorded() or choose(offline=offline, log=log)


def choose(*, offline: bool = False, log: Log | None = None, progress: weights.Progress | None = None) -> str:
    """Choose the best back end whose networks are here or can be fetched, write it down, and return its name.

    log: takes a line for each download, for each back end that cannot be had, and for the choice; without it they go to
    the `proxemetry` logger as warnings. Raises ModelError where none can be had, or where something else than a file
    lies in the place of a network; CacheError where networks cannot be kept and none are here.
    """
    log = log or _LOG.warning
    without: list[str] = []
    forbidden = offline or weights.is_offline()
    unkept: CacheError | None = None
    for name in EYES:
        here = is_available(name)  # not below: that a folder lies in a network's place is no reason to take others
        try:
            if not here and unkept is not None:
                raise unkept
            if not here:
                _have(name, offline=forbidden, log=log, progress=progress)
        except ModelError as error:
            if isinstance(error, CacheError):
                unkept = error
            elif not forbidden:  # one cause that all share is given once
                log(f"{name} is not available ({error})")
            without.append(name)
            continue
        rank = (
            "the first choice" if name == EYES[0] else f"the next choice after {' and '.join(EYES[: EYES.index(name)])}"
        )
        log(f"people will be found by {name}, {rank}; another: `--pose NAME`")
        _write_down(name)
        return name
    if forbidden and unkept is None:
        raise ModelError(
            f"no network that finds people is in {folders_text()}, and fetching is forbidden (offline); run "
            "`proxemetry models fetch` once with an internet connection"
        )
    raise unkept or ModelError(
        f"no network that finds people could be had ({', '.join(without)}; the lines before this one tell why): run "
        f"`proxemetry models fetch` where there is an internet connection, and copy the files to {writable_folder()}, "
        "or name people that another program has found: `--pose recorded:FILE`"
    )


def _have(name: str, *, offline: bool, log: Log, progress: weights.Progress | None) -> None:
    weights.fetch(BACKENDS[name].models, offline=offline, log=log, progress=progress)
    for wanted in BACKENDS[name].wants:
        weights.if_to_be_had(wanted, offline=offline, log=log)


def _write_down(name: str) -> None:
    try:
        folder = writable_folder()
        temporary = folder / f".{_RECORD}.new"
        temporary.write_text(json.dumps({"pose": name}) + "\n", encoding="utf-8")
        temporary.replace(folder / _RECORD)
    except (ModelError, OSError) as error:
        _LOG.warning("the choice of %s could not be saved (%s): it is made again next time", name, error)
