"""One file out of a zip or tar archive."""

from __future__ import annotations

import contextlib
import shutil
import tarfile
import zipfile
import zlib
from collections.abc import Generator
from pathlib import Path
from typing import IO

from ..errors import ModelError

#: How the names of tar archives end.
TAR_ENDINGS = (".tgz", ".tar.gz")


def take_out(archive: Path, member: str, target: Path, *, tar: bool = False) -> None:
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
                raise KeyError(f"{name} is not a file")
            with member:
                yield member
        return
    with zipfile.ZipFile(archive) as zipped:
        named = [path for path in zipped.namelist() if path == name or path.endswith(f"/{name}")]
        with zipped.open(named[0] if len(named) == 1 else name) as unzipped:
            yield unzipped
