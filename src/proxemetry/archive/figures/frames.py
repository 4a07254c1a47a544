"""A folder of photos measured from Python, and results as pandas data frames. Needs the extra `notebook`."""

from __future__ import annotations

import importlib.util
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, cast

from ...errors import SettingsError
from ...scene import Scene
from ...settings import Settings
from ..run.run import run
from ..run.schedule import Note, Progress
from ..run.work import Job
from ..store.queries import attributes_in, table_query
from ..store.results import Results

if TYPE_CHECKING:
    import pandas


@dataclass(frozen=True, eq=False)
class ResultsFrames:
    """The tables of a results folder as data frames, corrections applied; columns as the codebook explains them."""

    results: Results

    @cached_property
    def photos(self) -> pandas.DataFrame:
        """One row per photo."""
        return self._frame("photos")

    @cached_property
    def people(self) -> pandas.DataFrame:
        """One row per person."""
        return self._frame("people")

    @cached_property
    def pairs(self) -> pandas.DataFrame:
        """One row per pair of people."""
        return self._frame("pairs")

    def scenes(self) -> Iterator[Scene]:
        """Yield every photo's scene."""
        return self.results.scenes()

    def _frame(self, table: str) -> pandas.DataFrame:
        safe_m = self.results.run.get("safe_distance_m")
        duck = self.results.view()
        return duck.execute(table_query(table, safe_m, attributes_in(duck))).fetchdf()

    def __repr__(self) -> str:
        return f"ResultsFrames({self.results.folder.location!r}: photos, people, pairs)"


def read_results(folder: str | Path) -> ResultsFrames:
    """Return the tables of a results folder.

    Raises OutputError where there are none or the run is not finished, SettingsError where pandas is missing.
    """
    _require_pandas()
    results = Results.open(folder)
    results.require_finished()
    return ResultsFrames(results)


def _require_pandas() -> None:
    if importlib.util.find_spec("pandas") is None:
        raise SettingsError("data frames need an extra: pip install 'proxemetry[notebook]'")


def measure_folder(
    photos: str | Path | Sequence[str | Path],
    out: str | Path,
    *,
    pose: str = "auto",
    settings: Settings | None = None,
    same_camera: bool = False,
    jobs: int | None = None,
    restart: bool = False,
    on_progress: Callable[[Progress | Note], None] = lambda _: None,
) -> ResultsFrames:
    """Measure photos, folders or globs into a results folder, as `proxemetry measure` does, and return its tables.

    A folder that an earlier call with the same settings left unfinished is continued. same_camera: photos of
    one size without a focal length were taken with one camera and lens, which is found from the people in all of
    them. jobs: worker processes, one per core if None; 0 measures in this process. Raises what
    `proxemetry.archive.run.run.run` raises.
    """
    named = [photos] if isinstance(photos, str | Path) else photos
    if not isinstance(cast(object, pose), str):
        raise SettingsError(
            "pose must be a back end's name: worker processes load it by name; name a function of your own "
            "as python:MODULE:FUNCTION"
        )
    _require_pandas()  # before hours of work, not after
    told = settings or Settings()
    job = Job(str(out), pose, settings=replace(told, same_camera=same_camera or told.same_camera))
    run([str(photo) for photo in named], job, jobs=jobs, restart=restart, on_progress=on_progress)
    return read_results(out)
