"""A results folder, on a disk or behind an fsspec URL: whole files appear at once or not at all."""

from __future__ import annotations

import errno
import hashlib
import os
import socket
import tempfile
from collections.abc import Generator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

from ...errors import OutputError, SettingsError
from ...files import is_file, read_bytes
from .scratch import is_alive, scratch_folder

#: In a results folder: the record of the run, by which the folder is recognised, and the drawings, which are no photos.
RUN_FILE, OVERLAYS = "run.json", "overlays"
#: What its photos show about each other's cameras.
CAMERAS_FILE = "cameras.json"

#: Stores whose upload is atomic: an object is there whole or not at all.
_OBJECT_STORES = {"s3", "s3a", "gs", "gcs", "az", "abfs", "abfss", "oss", "memory"}
_TEMPORARY = ".tmp"
#: Bytes of a file name that every usual disk takes.
_LONGEST_NAME = 255


def is_url(location: str) -> bool:
    """Return whether a location is an fsspec URL; `file://` counts as a local path."""
    return "://" in location and not location.startswith("file://")


def local_path(location: str) -> str:
    """Return a local location without its `file://`."""
    return location.removeprefix("file://")


def open_filesystem(url: str) -> Any:
    """Return the fsspec file system of a URL; raises SettingsError where its package is missing."""
    protocol = url.partition("://")[0]
    try:
        import fsspec
    except ImportError as error:
        raise SettingsError(f"{url}: URLs need fsspec; pip install 'proxemetry[cluster]'") from error
    try:
        return fsspec.filesystem(protocol)
    except (ImportError, ValueError) as error:
        raise SettingsError(f"{url}: {error}") from error


def path_in_store(url: str) -> str:
    """Return a URL's path as its file system has it: a bucket and a key, for instance."""
    open_filesystem(url)  # raises with what is missing
    from fsspec.core import url_to_fs  # pyright: ignore[reportUnknownVariableType]

    return str(url_to_fs(url)[1])


def overlay_name(photo: str) -> str:
    """Return the name of a photo's drawing, relative to the results folder."""
    stays = photo.lower().endswith((".jpg", ".jpeg", ".png"))
    # A photo outside the folder named is called ../x: its overlay stays inside.
    inside = "/".join("_" if part == ".." else part for part in photo.split("/"))
    name = f"{OVERLAYS}/{inside}" if stays else f"{OVERLAYS}/{inside}.jpg"
    folder, _, base = name.rpartition("/")
    if len(os.fsencode(base)) > _LONGEST_NAME:  # as a photo may be called whose ending is not one of a drawing
        base = f"{hashlib.sha256(os.fsencode(base)).hexdigest()}.jpg"
    return f"{folder}/{base}"


class Folder:
    """Files by their name relative to the folder. Every failure to write raises OutputError with what to do."""

    def __init__(self, location: str | Path) -> None:
        self.location = str(location).rstrip("/") or "/"
        self._remote = open_filesystem(self.location) if is_url(self.location) else None
        if self._remote is None:
            self.location = os.path.abspath(local_path(self.location))

    def path(self, name: str) -> str:
        """Return the path or URL of a file, as DuckDB reads it once `attach` was called."""
        return f"{self.location}/{name}"

    @property
    def filesystem(self) -> Any:
        """The fsspec file system, None for a local folder."""
        return self._remote

    def names(self, subfolder: str = "", ending: str = "") -> list[str]:
        """Return the sorted names of the files right in a subfolder; none where there is no such folder."""
        where = self.path(subfolder) if subfolder else self.location
        if self._remote is None:
            try:
                found = [e.name for e in os.scandir(where) if e.is_file()]
            except (FileNotFoundError, NotADirectoryError):
                return []
            except OSError as error:
                raise OutputError(f"{where}: {error.strerror or error}") from error
        else:
            self._remote.invalidate_cache()
            try:
                found = [os.path.basename(p) for p in self._remote.ls(where, detail=False)]
            except FileNotFoundError:
                return []
        return sorted(n for n in found if n.endswith(ending) and not n.startswith("."))

    def states(self, subfolder: str) -> dict[str, tuple[Any, ...]]:
        """Return size and date (behind a URL the entity tag, where there is one) of the files in a subfolder."""
        if self._remote is None:
            try:
                entries = [e for e in os.scandir(self.path(subfolder)) if e.is_file()]
                return {e.name: (e.stat().st_size, e.stat().st_mtime_ns) for e in entries}
            except FileNotFoundError:
                return {}
        self._remote.invalidate_cache()
        try:
            found: list[dict[str, Any]] = self._remote.ls(self.path(subfolder), detail=True)
        except FileNotFoundError:
            return {}
        dates = ("ETag", "etag", "LastModified", "mtime", "created", "updated")
        return {
            os.path.basename(about["name"]): (about.get("size"), *(str(about[key]) for key in dates if about.get(key)))
            for about in found
        }

    def read(self, name: str) -> bytes | None:
        """Return a file's content, None where there is none."""
        try:
            if self._remote is not None:
                return self._remote.cat_file(self.path(name))
            return read_bytes(self.path(name))
        except (FileNotFoundError, NotADirectoryError):
            return None
        except OSError as error:
            raise OutputError(f"{self.path(name)}: cannot be read ({error.strerror or error})") from error

    def exists(self, name: str) -> bool:
        """Return whether there is such a file."""
        return bool(self._remote.exists(self.path(name))) if self._remote is not None else is_file(self.path(name))

    def write(self, name: str, content: bytes) -> None:
        """Write a whole file, replacing what was there."""
        with self.writing(name) as temporary:
            Path(temporary).write_bytes(content)

    def create(self, name: str, content: bytes) -> bool:
        """Write a file unless it is there; return whether it was written. Of several writers one wins."""
        if self._remote is not None:
            # Object stores differ in conditional puts: two machines that start within a moment of each other may
            # both write, and both write the same bytes.
            if self._remote.exists(self.path(name)):
                return False
            self.write(name, content)
            return True
        if is_file(self.path(name)):  # also where nothing can be written any more
            return False
        with _explained(self.path(name)):
            self._make_parent(name)
            temporary = self._temporary(name)
            try:
                _write_synced(temporary, content)
                os.link(temporary, self.path(name))
            except FileExistsError:
                return False
            except OSError as error:
                if error.errno not in (errno.EPERM, errno.ENOTSUP, errno.EOPNOTSUPP):
                    raise
                return self._create_without_links(name, content)
            finally:
                Path(temporary).unlink(missing_ok=True)
            _sync_folder(os.path.dirname(self.path(name)))
        return True

    def _create_without_links(self, name: str, content: bytes) -> bool:
        if os.path.lexists(self.path(name)):
            return False
        self.write(name, content)
        return True

    @contextmanager
    def writing(self, name: str) -> Generator[str]:
        """Yield a local path to write to; on leaving, the file appears under its name, synced and at once."""
        with _explained(self.path(name)):
            if self._remote is not None:
                with scratch_folder("upload") as scratch:
                    temporary = os.path.join(scratch, os.path.basename(name))
                    yield temporary
                    self._upload(temporary, self.path(name))
                return
            self._make_parent(name)
            temporary = self._temporary(name)
            try:
                yield temporary
                _sync_file(temporary)
                os.replace(temporary, self.path(name))
            except BaseException:
                Path(temporary).unlink(missing_ok=True)
                raise
            _sync_folder(os.path.dirname(self.path(name)))

    def _upload(self, source: str, target: str) -> None:
        assert self._remote is not None
        self._remote.makedirs(os.path.dirname(target), exist_ok=True)
        if target.partition("://")[0] in _OBJECT_STORES:
            self._remote.put_file(source, target)
        else:
            self._remote.put_file(source, target + _TEMPORARY)
            self._remote.mv(target + _TEMPORARY, target)

    @contextmanager
    def scratch(self) -> Generator[str]:
        """Yield a local path for a file that does not stay."""
        with _explained(tempfile.gettempdir()), scratch_folder("file") as folder:
            yield os.path.join(folder, "scratch")

    def remove(self, name: str) -> None:
        """Remove a file if it is there."""
        with _explained(self.path(name)), suppress(FileNotFoundError):
            if self._remote is not None:
                self._remote.rm_file(self.path(name))
            else:
                Path(self.path(name)).unlink()

    def sweep(self, subfolder: str = "", *, written_once: bool = False) -> None:
        """Remove what processes of this machine that are gone left half written.

        written_once: and what others left of files that are there now and are never written again.
        """
        if self._remote is not None:
            return
        where = Path(self.path(subfolder) if subfolder else self.location)
        for leftover in where.glob(f".*{_TEMPORARY}"):
            name, _, writer = leftover.name[1 : -len(_TEMPORARY)].rpartition("@")
            host, _, pid = writer.rpartition("+")
            dead = host == socket.gethostname() and pid.isdigit() and not is_alive(int(pid))
            if dead or (written_once and (where / name).exists()):
                with suppress(OSError):  # a disk that cannot be written any more
                    leftover.unlink(missing_ok=True)

    def _make_parent(self, name: str) -> None:
        Path(self.path(name)).parent.mkdir(parents=True, exist_ok=True)

    def _temporary(self, name: str) -> str:
        folder, base = os.path.split(self.path(name))
        return os.path.join(folder, f".{base}@{socket.gethostname()}+{os.getpid()}{_TEMPORARY}")


@contextmanager
def _explained(path: str) -> Generator[None]:
    """Turn the system's refusals to write into OutputError."""
    try:
        yield
    except OSError as error:
        raise _refusal(path, error) from error
    except Exception as error:
        import duckdb  # only now: most commands need none

        if isinstance(error, duckdb.IOException):
            raise _refusal(path, error) from error
        raise


def _refusal(path: str, error: Exception) -> OutputError:
    full = getattr(error, "errno", None) == errno.ENOSPC or "No space left" in str(error)
    if full:
        return OutputError(f"{path}: no space left; make room and run the same command again to continue")
    what = getattr(error, "strerror", None) or " ".join(str(error).split())
    in_the_way = next((p for p in Path(path).parents if p.is_file()), None)
    if in_the_way is not None:
        what = f"{in_the_way} is a file, not a folder"
    return OutputError(f"{path}: cannot be written ({what})")


def _write_synced(path: str, content: bytes) -> None:
    with open(path, "wb") as file:
        file.write(content)
        file.flush()
        os.fsync(file.fileno())


def _sync_file(path: str) -> None:
    with open(path, "rb+") as file:
        os.fsync(file.fileno())


def _sync_folder(path: str) -> None:
    if os.name != "posix":  # Windows has no handle on a folder
        return
    descriptor = os.open(path, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)
