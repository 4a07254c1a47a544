"""Networks from an address: downloaded with resume, placed once the hash is right."""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..errors import ModelError
from .archives import TAR_ENDINGS, take_out
from .cache import Log, Progress, open_for_placing, writable_folder
from .table import Model

if TYPE_CHECKING:
    import requests

# To connect, and for the next bytes: a firewall that swallows everything must not hold up the next source for long.
_TIMEOUTS_S = (8, 30)


def from_web(source: str, model: Model, log: Log, progress: Progress | None) -> None:
    """Download one file, resuming a part that an earlier attempt left, and place it once its hash is right."""
    address, _, member = source.partition("#")
    part = writable_folder() / f"{model.name}.part"
    size = f"{model.size_bytes / 1e6:.1f} MB, " if model.size_bytes else ""
    log(f"fetching {model.name} ({size}{model.licence}) from {address}")
    resumed = part.is_file()
    try:
        _download_persistently(address, part, progress)
        _place(model, part, address, member)
    except ModelError:
        if not resumed:
            raise
        part.unlink(missing_ok=True)
        _download(address, part, progress)  # it was another mirror's or another version's part: once more, whole
        _place(model, part, address, member)


def _download_persistently(address: str, part: Path, progress: Progress | None) -> None:
    """Download, and continue where a connection was cut as long as that brings more."""
    while True:
        before = part.stat().st_size if part.is_file() else 0
        try:
            return _download(address, part, progress)
        except ModelError:
            if not part.is_file() or part.stat().st_size <= before:
                raise


def _place(model: Model, part: Path, address: str, member: str) -> None:
    with open_for_placing(model) as placing:
        try:
            if member:
                take_out(part, member, placing.temporary, tar=address.endswith(TAR_ENDINGS))
            else:
                shutil.copyfile(part, placing.temporary)
            placing.place()
        finally:
            part.unlink(missing_ok=True)  # it was whole: what is wrong now would be wrong again


def _download(address: str, part: Path, progress: Progress | None) -> None:
    """Download to `part`, from where it ends if it exists; raises ModelError and leaves the part where it stops."""
    import pooch
    import requests

    begin = part.stat().st_size if part.is_file() else 0
    headers = {"Range": f"bytes={begin}-"} if begin else {}
    bar: Any = False if progress is None else _Bar(progress, begin)
    fetcher = pooch.HTTPDownloader(progressbar=bar, headers=headers, timeout=_TIMEOUTS_S)
    try:
        with part.open("ab") as stream:
            fetcher(address, stream, None)
    except requests.RequestException as error:
        refused = isinstance(error, requests.HTTPError)
        if refused or not part.stat().st_size:
            part.unlink()
        if refused and begin:  # a server that cannot continue from there
            _download(address, part, progress)
            return
        raise ModelError(_why(error)) from error


def _why(error: requests.RequestException) -> str:
    """Return in a few words why a download failed; the libraries' own take several lines."""
    import requests

    if isinstance(error, requests.HTTPError) and error.response is not None:
        return f"{error.response.status_code} {error.response.reason}"
    if isinstance(error, requests.Timeout):
        return "does not answer"
    return "cannot be reached" if isinstance(error, requests.ConnectionError) else "the connection was cut"


class _Bar:
    """What pooch takes for a progress bar, passed on."""

    def __init__(self, progress: Progress, begin: int) -> None:
        self._progress, self._begin, self._done, self.total = progress, begin, begin, 0

    def update(self, count: int) -> None:
        self._done += count
        self._progress(self._done, self._begin + self.total if self.total else None)

    def reset(self) -> None:
        """Pooch counts the whole once more at the end."""
        self._done = self._begin

    def close(self) -> None:
        """Nothing is held open."""
