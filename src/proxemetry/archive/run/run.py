"""A whole run: the photos, the settings, the workers, and the tables at the end."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial

from ...errors import OutputError, SettingsError
from ...pose import backend_named, replays
from ...pose.recorded import Recorded
from ...pose.recording import Recording
from ...settings import DEFAULT_METHOD
from ...version import __version__
from ..store import manifest, parts
from ..store.current_tables import MANY
from ..store.damage import damaged_parts
from ..store.folder import OVERLAYS, RUN_FILE, Folder, is_url
from ..store.identity import Identity
from ..store.manifest import Manifest
from ..store.part_rows import Counts
from ..store.photos import Search, search
from ..store.removal import forget
from ..store.results import Results
from ..store.run_file import write_run
from ..store.scratch import sweep_scratch
from . import notes
from .camera_pool import stale_shards, write_pool
from .changed_files import FileScan
from .joining import join, settings_of
from .manifest_update import ManifestUpdate, mixed_folders_note
from .schedule import Note, Pass, Progress, Schedule
from .shoots import LEAST_PHOTOS, pool_of
from .work import Job
from .workers import InlineWorker, WorkerPool

ENGINES = ("local", "ray")
MAX_JOBS = 1024


@dataclass(frozen=True)
class Outcome:
    """What a run did. measured: this time. finished: shards there now, of n_shards; tables are there once all are."""

    measured: Counts
    photos: int
    finished: int
    n_shards: int

    @property
    def complete(self) -> bool:
        """Whether every shard is there, and so the tables."""
        return self.finished == self.n_shards


def run(
    paths: Sequence[str],
    job: Job,
    *,
    jobs: int | None = None,
    engine: str = "local",
    shard: tuple[int, int] | None = None,
    restart: bool = False,
    repair: bool = False,
    safe_distance_m: float | None = None,
    on_progress: Callable[[Progress | Note], None] = lambda _: None,
) -> Outcome:
    """Measure photos into the folder `job.results`, continuing where an earlier run with the same settings stopped.

    paths: photos, folders, globs, URLs; empty for recorded keypoints without photos, or to continue with the photos
    that the folder lists. jobs: worker processes, one a core where None; 0 measures in this process. engine: "local"
    or "ray". shard: (i, n) does only every n-th shard, the i-th from 1. restart: start again. repair: measure
    again what damaged parts hold. on_progress: is called with every step.

    Raises SettingsError, ModelError or KeypointsError where what is asked for cannot be had, OutputError where the
    folder cannot be written or holds results made with other settings.
    """
    if engine not in ENGINES:
        raise SettingsError(f"engine {engine!r} is unknown: use one of {', '.join(ENGINES)}")
    if shard is not None and not 1 <= shard[0] <= shard[1]:
        raise SettingsError(f"--shard {shard[0]}/{shard[1]}: write i/N with i from 1 to N")
    named, folder = _named(paths, job), Folder(job.results)
    if restart:
        forget(folder)
    elif named is None and not folder.exists(RUN_FILE):
        raise SettingsError("no photos named: proxemetry measure PATH... --out DIR")
    if repair:
        _repair(folder, on_progress)
    _sweep(folder)
    sweep_scratch()
    is_mine = partial(_is_mine, share=shard)
    workers = _workers(job, jobs, engine)
    try:
        found = _measured(workers, job, folder, named, is_mine, on_progress)
    finally:
        workers.close()
        _sweep(folder)  # after a refusal as well: a worker may have been too busy to unwind
    _require_own(folder, found.manifest, is_mine)
    return _concluded(folder, found, safe_distance_m, on_progress)


def _measured(
    workers: WorkerPool, job: Job, folder: Folder, named: Search | Sequence[str] | None,
    is_mine: Callable[[int], bool], on_progress: Callable[[Progress | Note], None],
) -> Pass:  # fmt: skip
    """Begin the run or continue it: measure the shards that are this run's and are not there."""
    update, scan = None, None
    try:
        listed, there = _listed(folder), parts.finished(folder)
        if named is not None:
            update = ManifestUpdate(folder, named, listed)
        workers.load()
        identity = Identity(__version__, workers.pose, dict(workers.models), settings_of(job))
        join(folder, identity, there)
        listed, pending = _starting_manifest(folder, named, listed, update)
        scan = None if update is None else FileScan(folder, update, is_mine)
        schedule = Schedule(workers, job, folder, listed, identity.metadata(), on_progress, pending, scan, is_mine)
        if measured := sum(listed.shard_sizes[s] for s in there if s < listed.n_shards):
            on_progress(Note(f"{measured} of {len(listed)} photos are measured already"))
        if isinstance(named, Search) and (mixed := mixed_folders_note(listed, named.root)):
            on_progress(Note(mixed))
        found = schedule.run(s for s in range(listed.n_shards) if s not in there and is_mine(s))
        if found.counts.photos and not found.counts.people:
            _require_recorded(job, found.manifest)
        if note := notes.measured_again(found.counts.again):
            on_progress(note)
        _told_by_others(schedule, found.manifest)
        table = job.settings.focal.camera_table
        if table is not None and (note := notes.unused_rows(table, found.manifest)):
            on_progress(note)
        if update is not None and update.passed_over:
            on_progress(Note(update.passed_over))
        return found
    finally:
        for thread in (update, scan):
            if thread is not None:
                thread.close()


def _told_by_others(schedule: Schedule, listed: Manifest) -> None:
    """Once every photo is measured, measure those again about whose cameras other photos show something.

    People are not searched for again. The evidence comes from the first measurement alone, so that a run that was
    stopped continues with what is left.
    """
    folder, settings = schedule.folder, schedule.job.settings
    asked = settings.other_photos or settings.same_camera
    if not asked or settings.method != DEFAULT_METHOD or len(parts.finished(folder)) < max(1, listed.n_shards):
        return
    pool = pool_of(folder, listed.moved_to or listed.root, settings)
    shards = stale_shards(folder, pool)
    if pool or pool.shoots or shards:  # why a shoot shows nothing is worth reading too
        digest = write_pool(folder, pool)
        again = Schedule(
            schedule.workers, schedule.job, folder, listed, schedule.metadata, schedule.on_progress, pool=digest
        )
        if shards:
            schedule.on_progress(Note("measuring again the photos whose cameras other photos have determined"))
            again.run(shards)
    for _, shoot in sorted(pool.shoots.items()):
        schedule.on_progress(Note(shoot.said))
    if settings.same_camera and not pool.shoots:
        schedule.on_progress(Note(
            f"--same-camera had no effect: no {LEAST_PHOTOS} photos of one size show people and lack a focal length"
        ))  # fmt: skip


def _sweep(folder: Folder) -> None:
    folder.sweep(parts.FOLDER, written_once=True)
    folder.sweep(manifest.FOLDER, written_once=True)
    folder.sweep()


def _require_own(folder: Folder, listed: Manifest, is_mine: Callable[[int], bool]) -> None:
    """Raise OutputError where what this run wrote is gone: the folder was removed, renamed or emptied meanwhile."""
    there = parts.finished(folder)
    lost = sum(is_mine(s) and s not in there for s in range(listed.n_shards))
    if lost or not folder.exists(RUN_FILE):
        raise OutputError(
            f"{folder.location}: was removed, renamed or emptied while it was written to ({lost} parts are gone); run "
            "the same command again"
        )


def _repair(folder: Folder, on_progress: Callable[[Progress | Note], None]) -> None:
    """Remove the parts that are not what was written: their photos are measured again."""
    damaged = damaged_parts(folder, parts.names_of(folder))
    for name in damaged:
        folder.remove(name)
    if damaged:
        word = "part" if len(damaged) == 1 else "parts"
        on_progress(Note(f"{len(damaged)} damaged {word} removed: the photos are measured again"))


def _named(paths: Sequence[str], job: Job) -> Search | Sequence[str] | None:
    """Return where photos are named; those that recorded keypoints name where no photo is; None without either."""
    found = search(paths) if paths else None
    if replays(job.pose) and (found is None or not found.any()):
        backend = backend_named(job.pose, job.pose_options)
        return list(backend.photos) if isinstance(backend, Recording) else []
    if found is None:
        return None
    if not found.any():
        raise found.nothing()
    if is_url(job.results) or is_url(found.root):
        return found
    # What an earlier run drew is no photo of the archive.
    results = Folder(job.results).location
    return replace(found, without=f"{results}/{OVERLAYS}" if results in found.folders else results)


def _listed(folder: Folder) -> Manifest | None:
    """Return the photos listed so far, where they were when the run went on last, if that is still there."""
    listed = manifest.read(folder)
    if listed is None or not folder.exists(RUN_FILE):
        return listed
    last = manifest.absolute(folder, Results(folder).run.get("photos_in"))
    moved = last is not None and last != listed.root and (is_url(last) or os.path.isdir(last))
    return listed.moved(last) if moved else listed


def _starting_manifest(
    folder: Folder, named: Search | Sequence[str] | None, listed: Manifest | None, update: ManifestUpdate | None
) -> tuple[Manifest, ManifestUpdate | None]:
    """Return the manifest to begin with, and what may still come: a resumed run does not wait for the walk."""
    if update is None:
        if listed is None:
            raise OutputError(f"{folder.location}: no run to continue there; name the photos to measure")
        return listed, None
    update.allow()
    if listed is not None and isinstance(named, Search) and named.root == (listed.moved_to or listed.root):
        return listed, update
    return update.result(), None


def _workers(job: Job, jobs: int | None, engine: str) -> WorkerPool:
    if engine == "ray":
        from .cluster import RayWorkers

        return RayWorkers(job, jobs)
    if jobs == 0:
        return InlineWorker(job)
    from .pool import Pool, default_jobs

    return Pool(job, min(jobs or default_jobs(), MAX_JOBS))


def _is_mine(shard: int, share: tuple[int, int] | None) -> bool:
    return share is None or shard % share[1] == share[0] - 1


def _require_recorded(job: Job, listed: Manifest) -> None:
    """Raise KeypointsError where a keypoint file names none of the photos: no person in any photo is no result."""
    if job.pose.startswith("recorded:"):
        backend = backend_named(job.pose, job.pose_options)
        if isinstance(backend, Recorded):
            backend.require_any(listed.names())


def _concluded(
    folder: Folder, found: Pass, safe_distance_m: float | None, on_progress: Callable[[Progress | Note], None]
) -> Outcome:
    """Write the tables where every part is there, corrections applied."""
    listed = found.manifest
    outcome = Outcome(found.counts, len(listed), len(parts.finished(folder)), listed.n_shards)
    if outcome.complete:
        results = Results(folder)
        if not results.tables_are_current(safe_distance_m):
            results.require_whole()
            if len(listed) > MANY:
                on_progress(Note("writing the tables; a million photos take minutes"))
            results.write_tables(safe_distance_m)
        fields = results.run
        photos_in = manifest.relative(folder, listed.moved_to or listed.root)
        last = {**fields, "safe_distance_m": safe_distance_m, "photos_in": photos_in}
        if last != fields:
            write_run(folder, last)
        if note := notes.lost_corrections(results):
            on_progress(note)
    return outcome
