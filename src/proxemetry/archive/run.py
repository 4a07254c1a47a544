"""A whole run: which photos, with what, by whom, and the tables at the end."""

from __future__ import annotations

import json
import os
import platform
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from .. import __version__
from ..errors import SettingsError
from ..people import PoseBackend
from ..pose import backend_named
from . import manifest, parts
from .crew import Crew, OwnProcess
from .folder import Folder, is_url
from .identity import Identity, require_same
from .manifest import Manifest
from .parts import Counts
from .photos import Listing, find_photos, has_photos
from .results import RUN_FILE, Results, forget, write_run
from .schedule import Progress, Schedule
from .work import Job

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
    safe_distance_m: float | None = None,
    tell: Callable[[Progress], None] = lambda _: None,
) -> Outcome:
    """Measure photos into the folder `job.results`, going on where an earlier run with the same settings stopped.

    paths: photos, folders, globs, URLs; empty for recorded keypoints without photos, or to go on with the photos
    that the folder lists. jobs: worker processes, one a core where None; 0 measures in this process. engine: "local"
    or "ray". shard: (i, n) does only every n-th shard, the i-th from 1. restart: begin anew. tell: hears of progress.

    Raises SettingsError, ModelError or KeypointsError where what is asked for cannot be had, OutputError where the
    folder cannot be written or holds results made otherwise.
    """
    if engine not in ENGINES:
        raise SettingsError(f"engine {engine!r} is unknown: use one of {', '.join(ENGINES)}")
    if shard is not None and not 1 <= shard[0] <= shard[1]:
        raise SettingsError(f"--shard {shard[0]}/{shard[1]}: write i/N with i from 1 to N")
    listing = _listing(paths, job)
    folder = Folder(job.results)
    if restart:
        forget(folder)
    elif folder.read(RUN_FILE) is None and listing is None:
        raise SettingsError("no photos named: proxemetry measure PATH... --out DIR")
    folder.sweep(parts.FOLDER)
    crew = _crew(job, jobs, engine, len(listing.names) if isinstance(listing, Listing) else None)
    try:
        identity = Identity(__version__, crew.pose, dict(crew.models), _settings(job))
        _join(folder, identity)
        listed = manifest.frozen(folder, listing)
        there = parts.finished(folder)
        mine = [s for s in range(listed.n_shards) if s not in there and _is_mine(s, shard)]
        counts = Schedule(crew, job, folder, listed, identity.metadata(), tell).run(mine)
    finally:
        crew.close()
    folder.sweep(parts.FOLDER)
    return _concluded(folder, listed, counts, safe_distance_m)


def _listing(paths: Sequence[str], job: Job) -> Listing | Sequence[str] | None:
    """Return the photos named; those that recorded keypoints name where no photo is; None where nothing is named."""
    if job.pose.startswith("recorded:"):
        backend: PoseBackend = backend_named(job.pose, job.options)
        if not paths or not any(map(has_photos, paths)):
            return list(getattr(backend, "photos", ()))
    if not paths:
        return None
    listing = find_photos(paths)
    if is_url(job.results) or is_url(listing.root):
        return listing
    # Overlays of an earlier run are no photos of the archive.
    inside = os.path.relpath(Folder(job.results).location, listing.root).replace(os.sep, "/") + "/"
    inside = "overlays/" if inside == "./" else inside
    names = tuple(n for n in listing.names if not n.startswith(inside))
    if not names:
        raise SettingsError(f"{', '.join(paths)}: no photos there but those of the results folder")
    return Listing(listing.root, names)


def _crew(job: Job, jobs: int | None, engine: str, at_most: int | None) -> Crew:
    if engine == "ray":
        from .cluster import RayCrew

        return RayCrew(job, jobs)
    if jobs == 0:
        return OwnProcess(job)
    from .pool import Pool, default_jobs

    return Pool(job, min(jobs or default_jobs(), at_most or MAX_JOBS))


def _settings(job: Job) -> dict[str, Any]:
    """Return every setting that changes a number, as JSON values; what only changes the speed is not among them."""
    options = job.options
    return {
        **job.settings.to_dict(), "effort": options.effort, "device": options.device, "flip": options.flip,
        "with_names": job.with_names, "with_gps": job.with_gps,
    }  # fmt: skip


def _is_mine(shard: int, share: tuple[int, int] | None) -> bool:
    return share is None or shard % share[1] == share[0] - 1


def _join(folder: Folder, identity: Identity) -> None:
    """Begin a run, or make sure that what is there was made the same way; raises OutputError where it was not."""
    fields = {
        "schema": "proxemetry.run/1",
        "version": identity.version,
        "pose": identity.pose,
        "models": dict(identity.models),
        "settings": dict(identity.settings),
        "metadata": identity.metadata(),
        "python": platform.python_version(),
        "platform": platform.platform(),
        "packages": _packages(),
    }
    if folder.create(RUN_FILE, (json.dumps(fields, indent=2) + "\n").encode()):
        before = [identity.metadata()]
    else:
        before = [Results(folder).run["metadata"]]
    for other in (*before, *parts.metadata_of(folder, sorted(parts.finished(folder)))):
        require_same(identity, other, folder.location)


def _packages() -> dict[str, str]:
    from importlib.metadata import PackageNotFoundError, version

    found: dict[str, str] = {}
    for package in ("numpy", "scipy", "pillow", "duckdb", "ai-edge-litert", "onnxruntime", "opencv-python-headless"):
        try:
            found[package] = version(package)
        except PackageNotFoundError:
            continue
    return found


def _concluded(folder: Folder, listed: Manifest, counts: Counts, safe_distance_m: float | None) -> Outcome:
    """Write the tables where every part is there, corrections applied."""
    outcome = Outcome(counts, len(listed), len(parts.finished(folder)), listed.n_shards)
    if outcome.complete:
        results = Results(folder)
        if not results.tables_are_current(safe_distance_m):  # of a million photos it takes minutes
            results.write_tables(safe_distance_m)
        fields = results.run
        if fields.get("safe_distance_m") != safe_distance_m:
            write_run(folder, {**fields, "safe_distance_m": safe_distance_m})
    return outcome
