"""A folder measured from the page: which folders there are, a run in the background, and how far it is."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from ..archive.run.run import run
from ..archive.run.schedule import Note, Progress
from ..archive.run.work import Job
from ..camera.focal import FocalRequest
from ..errors import SettingsError
from ..photo import EXTENSIONS
from ..settings import Settings
from .background import BackgroundWork

#: Subfolders that are listed, and files of a folder that are counted, at most.
_MOST_FOLDERS, _MOST_FILES = 500, 100_000
#: What is added to a folder's name for its results.
_RESULTS = " proxemetry results"

Run = Callable[..., Any]


def folders(path: str) -> dict[str, Any]:
    """Return a folder's path, its parent, its subfolders by name, and how many photos lie in it itself.

    path: "" is the folder that the program was started in, where photos lie in it, else the user's home.
    Raises SettingsError where it cannot be listed.
    """
    folder = Path(path).expanduser() if path else _first_folder()
    try:
        entries = sorted(folder.resolve().iterdir(), key=lambda entry: entry.name.casefold())
        inside = [e.name for e in entries if not e.name.startswith(".") and e.is_dir()]
    except (OSError, ValueError) as error:
        raise SettingsError(f"{folder}: cannot be listed ({getattr(error, 'strerror', None) or error})") from error
    photos = sum(e.suffix.lower() in EXTENSIONS for e in entries[:_MOST_FILES])
    here = folder.resolve()
    return {
        "path": str(here),
        "parent": None if here.parent == here else str(here.parent),
        "folders": inside[:_MOST_FOLDERS],
        "photos": photos,
        "results": str(here.with_name(here.name + _RESULTS)),
    }


def _first_folder() -> Path:
    """Return the folder to show first."""
    try:
        started_in = Path.cwd()
        has_photos = any(e.suffix.lower() in EXTENSIONS for e in itertools.islice(started_in.iterdir(), _MOST_FILES))
    except OSError:  # it was removed meanwhile, or may not be read
        return Path.home()
    return started_in if has_photos else Path.home()


@dataclass
class Measuring:
    """One run at a time. `run` is the archive's, or a test's. All methods may be called from several threads."""

    run: Run = run
    _work: BackgroundWork = field(default_factory=BackgroundWork)

    def start(self, folder: str, out: str, focal_35mm: float | None = None) -> None:
        """Begin to measure a folder; raises SettingsError where it is none, or where another run is under way."""
        if not Path(folder).is_dir():
            raise SettingsError(f"{folder}: there is no such folder")
        if not out.strip():
            raise SettingsError("name a folder for the results")
        job = Job(str(Path(out).expanduser()), settings=Settings(focal=FocalRequest(focal_35mm=focal_35mm)))

        def measured(on_progress: Callable[[Progress | Note], None]) -> None:
            self.run([folder], job, on_progress=on_progress)

        self._work.start(measured, folder=folder, out=job.results)

    def stop(self) -> None:
        """Ask the run to stop; what is finished stays, and the same folder continues from there."""
        self._work.stop()

    def state(self) -> dict[str, Any]:
        """Return the status (idle, running, done, stopped or failed), photos done and in all, and seconds left."""
        return self._work.state()
