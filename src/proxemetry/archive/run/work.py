"""What a worker does with a shard: measure its photos, each into a row whatever happens, and write the part."""

from __future__ import annotations

import os
import traceback
import warnings
from collections.abc import Callable, Generator, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from pathlib import Path

from ...camera.lens import require_lens_database
from ...errors import AssumedFocalWarning, OutputError, PhotoError, ProxemetryError
from ...locate import MEASURE_PUPILS
from ...measure import measure
from ...people import People, PoseBackend
from ...people.skeleton import Skeleton
from ...photo import Photo
from ...pose import PoseOptions, backend_named
from ...pose.recording import Recording
from ...scene import Provenance, Scene
from ...settings import Settings
from ...version import __version__
from ..store import parts
from ..store.file_state import FileState
from ..store.folder import Folder, is_url, open_filesystem, overlay_name
from ..store.manifest import Item
from ..store.part_rows import Counts, PreviousRow, Record, record_of
from ..store.scratch import scratch_folder
from .camera_pool import CameraPool, is_open, read_pool
from .duplicates import sha256_of


@dataclass(frozen=True)
class Job:
    """What every worker of a run gets at its start.

    results: path or URL of the results folder. with_names, with_gps: whether the names in the photos' metadata (people,
    creator, caption) and the coordinates of the place are copied into the results.
    """

    results: str
    pose: str = "auto"
    options: PoseOptions = field(default_factory=PoseOptions)
    settings: Settings = field(default_factory=Settings)
    with_names: bool = False
    with_gps: bool = False

    @property
    def pose_options(self) -> PoseOptions:
        """The back end's options: with pupils where the method measures the distance between them."""
        return replace(self.options, pupils=self.settings.method in MEASURE_PUPILS)

    def open_photo(self, path: str | Path, name: str) -> Photo:
        """Return the photo at a path, with the metadata that this run may take along; raises PhotoError."""
        return Photo.open(path, name, with_names=self.with_names, with_gps=self.with_gps)


@dataclass(frozen=True)
class Task:
    """A piece of work: a shard to measure and write, or (alone) one photo of it whose row is handed back.

    pool: the digest of `cameras.json` where the photos are measured already and only the evidence from others is new.
    """

    shard: int
    items: tuple[Item, ...]
    metadata: Mapping[str, str] = field(hash=False)
    alone: bool = False
    pool: str = ""


@dataclass(frozen=True)
class Finished:
    """What became of a task; `record` is the row of a photo measured alone. errors: tracebacks of bugs met."""

    counts: Counts
    record: Record | None = None
    errors: tuple[str, ...] = ()


@dataclass(frozen=True, eq=False)
class _FoundBefore:
    """A back end that gives the people found before."""

    people: People
    made_by: Provenance

    @property
    def name(self) -> str:
        """The name of the back end that found them."""
        return self.made_by.pose

    @property
    def models(self) -> Mapping[str, str]:
        """The networks that found them."""
        return self.made_by.models

    @property
    def skeleton(self) -> Skeleton:
        """Their joints."""
        return self.people.skeleton

    def detect(self, photo: Photo) -> People:
        """Return them."""
        return self.people


class Measurer:
    """A loaded back end and the run's settings: what a worker keeps between tasks."""

    def __init__(self, job: Job) -> None:
        self.job = job
        self.folder = Folder(job.results)
        self.backend: PoseBackend = backend_named(job.pose, job.pose_options)
        if not isinstance(self.backend, Recording):  # of which the photos need not be there
            require_lens_database()
        self._made_by = Provenance(__version__, self.backend.name, dict(self.backend.models), job.settings.table)
        table = job.settings.focal.camera_table
        # Copies of a file may give other results under another name: their keypoints or camera go by name.
        self._names_matter = isinstance(self.backend, Recording) or (
            table is not None and any(row.photo for row in table.rows)
        )
        self._errors: list[str] = []
        self._pooled: tuple[str, CameraPool] | None = None

    def run(self, task: Task, tick: Callable[[], None] = lambda: None) -> Finished:
        """Do a task; `tick` is called after every photo. Raises OutputError where a part cannot be written."""
        self._errors.clear()
        records: list[Record] = []
        for record in self._told_records(task) if task.pool else self._records(task):
            records.append(record)
            tick()
        counts = sum((r.counts for r in records), Counts())
        errors = tuple(self._errors)
        if task.alone:
            return Finished(counts, records[0], errors)
        parts.write(self.folder, task.shard, records, task.metadata)
        return Finished(counts, None, errors)

    def _records(self, task: Task) -> Iterator[Record]:
        """Yield the rows of a task's photos; a file is measured once however many copies there are of it.

        Where the part is there already, the rows of files that are still the same are kept.
        """
        measured: dict[str, Scene] = {}
        before = parts.previous_rows(self.folder, task.shard)
        for item in task.items:
            file, known = FileState.of(item.location), before.get(item.photo)
            if known is None:
                yield self._record(item, file, measured)
            elif file in (None, known.file) or (known.sha256 and known.sha256 == _sha256(item)):
                yield known.record(known.file if file is None else file)
            else:
                record = self._record(item, file, measured)
                if not is_url(self.folder.location):
                    self.folder.remove(overlay_name(item.photo))  # it shows the old one
                yield replace(record, counts=replace(record.counts, again=int(bool(known.sha256))))

    def _told_records(self, task: Task) -> Iterator[Record]:
        """Yield the rows of photos that are measured, again where the evidence from other photos has changed."""
        pool, before = self._pool(task.pool), parts.previous_rows(self.folder, task.shard)
        for item in task.items:
            known = before.get(item.photo)
            if known is None:
                raise OutputError(f"{self.folder.path(parts.name_of(task.shard))}: {item.photo} is not there any more")
            others = pool.digest_for(known.fields) if is_open(known.fields) else ""
            if others == (known.fields["others"] or ""):
                yield known.record(known.file)
                continue
            scene = self._told_scene(item, known, pool)
            if scene is None:
                yield known.told(others).record(known.file)
            else:
                if not is_url(self.folder.location):
                    self.folder.remove(overlay_name(item.photo))
                yield record_of(scene, known.file, others, known.own_focal)

    def _pool(self, digest: str) -> CameraPool:
        """Return the pool of that digest; raises OutputError where the folder has another one meanwhile."""
        if self._pooled is None or self._pooled[0] != digest:
            self._pooled = (digest, read_pool(self.folder, digest))
        return self._pooled[1]

    def _told_scene(self, item: Item, known: PreviousRow, pool: CameraPool) -> Scene | None:
        """Return the scene of a photo with the people found before; None where it cannot be opened any more."""
        before = known.scene
        try:
            with warnings.catch_warnings(), _opened(item, self.backend, self.job) as photo:
                warnings.simplefilter("ignore", AssumedFocalWarning)
                if before.sha256 and photo.sha256 != before.sha256:
                    return None  # replaced meanwhile: the next run measures it
                found = _FoundBefore(before.people, before.made_by)
                told = pool.others_of(known.fields, photo)
                scene = measure(photo, pose=found, settings=self.job.settings, others=told)
        except ProxemetryError:
            return None
        return replace(scene, made_by=before.made_by, seconds=before.seconds + scene.seconds)

    def _record(self, item: Item, file: FileState | None, measured: dict[str, Scene]) -> Record:
        """Return the row of a photo; `measured` is what this task measured of files that may have copies."""
        may_be_copy = (item.duplicate_of, item.original_shard) != (None, None) and not self._names_matter
        sha256 = _sha256(item) if may_be_copy else ""
        if sha256 in measured:
            return record_of(measured[sha256].renamed(item.photo), file)
        if sha256 and item.original_shard is not None:
            record = parts.copied(self.folder, item.original_shard, sha256, item.photo, file)
            if record is not None:
                return record
        scene = self._scene(item)
        if sha256 and scene.sha256 == sha256:
            measured[sha256] = scene
        return record_of(scene, file if scene.sha256 else None)  # what could not be read is tried again

    def _scene(self, item: Item) -> Scene:
        try:
            with warnings.catch_warnings(), _opened(item, self.backend, self.job) as photo:
                warnings.simplefilter("ignore", AssumedFocalWarning)  # the summary counts them
                return measure(photo, pose=self.backend, settings=self.job.settings)
        except ProxemetryError as error:
            reason = _without_name(str(error), item)
        except MemoryError:
            reason = "not enough memory; use fewer --jobs"
        except Exception as error:  # a bug costs one photo, never the run; its traceback is shown
            reason = f"internal error ({type(error).__name__}: {error})"
            self._errors.append(f"{item.photo}\n{traceback.format_exc()}")
        return Scene.failed(
            item.photo, " ".join(reason.split()), _sha256(item), settings=self.job.settings.without_table,
            made_by=self._made_by,
        )  # fmt: skip


def died(item: Item, how: str, job: Job, pose: str, models: Mapping[str, str]) -> Record:
    """Return the row of a photo that ended the process measuring it, twice."""
    made_by = Provenance(__version__, pose, dict(models), job.settings.table)
    reason = f"the process measuring it died ({how}), also when tried alone; look at the file"
    settings = job.settings.without_table
    scene = Scene.failed(item.photo, reason, _sha256(item), settings=settings, made_by=made_by)
    return record_of(scene, FileState.of(item.location))


def _without_name(reason: str, item: Item) -> str:
    """Return a message without the photo's path: the row names the photo, and the path is this machine's alone."""
    for name in (item.location, item.photo, os.path.basename(item.photo)):
        reason = reason.removeprefix(f"{name}: ")
    return reason if item.location is None else reason.replace(item.location, item.photo)


@contextmanager
def _opened(item: Item, backend: PoseBackend, job: Job) -> Generator[Photo]:
    """Yield a photo under its name in the results, fetched for the while where it is behind a URL."""
    if item.location is None and isinstance(backend, Recording):
        yield backend.photo(item.photo)
    elif item.location is None:
        raise PhotoError(f"{item.photo}: no file, and the back end {backend.name} has no record of it")
    elif is_url(item.location):
        with scratch_folder("photo") as scratch:
            path = Path(scratch) / os.path.basename(item.photo)
            try:
                path.write_bytes(open_filesystem(item.location).cat_file(item.location))
            except FileNotFoundError as error:
                raise PhotoError(f"{item.location}: no such file") from error
            except OSError as error:
                raise PhotoError(f"{item.location}: cannot be fetched ({error})") from error
            yield job.open_photo(path, item.photo)
    else:
        yield job.open_photo(item.location, item.photo)


def _sha256(item: Item) -> str:
    return "" if item.location is None else sha256_of(item.location)


def quiet_threads(job: Job) -> Job:
    """Return the job with one thread a worker; the numeric libraries of its processes get one thread each."""
    for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "OPENCV_FOR_THREADS_NUM"):
        os.environ.setdefault(name, "1")
    return replace(job, options=replace(job.options, threads=1))
