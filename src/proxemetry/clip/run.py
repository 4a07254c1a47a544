"""One clip into one folder: measured, analysed, written; the same call again continues where it was stopped."""

from __future__ import annotations

import json
import platform
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, cast

import numpy as np

from ..archive.run.pool import default_jobs
from ..archive.run.schedule import Note, Progress
from ..archive.store import parts
from ..archive.store.folder import RUN_FILE, Folder
from ..archive.store.identity import Identity, require_same
from ..archive.store.run_file import CLIP_SCHEMA
from ..arrays import FloatArray
from ..errors import ClipError, OutputError, SettingsError
from ..files import parse_json, read_json
from ..version import __version__
from .analysis import Analysis, Wanted, analyse
from .density import Region
from .exports import write_exports
from .frames import ENDINGS, Clip, open_clip
from .measuring import FRAMES_FILE, Job, Worker, measure_clip
from .summary import SUMMARY, Sums, summary, write_json
from .writing import remove_tracks, write_results

MOUNT_FILE = "mount.json"


@dataclass(frozen=True)
class Outcome:
    """What became of one clip: its summary, or the reason why there is none."""

    clip: str
    folder: str
    summary: dict[str, Any] | None
    reason: str | None = None


def clips_of(paths: Sequence[str]) -> list[Path]:
    """Return the clips that are named: files, folders of pictures, and the video files of folders that hold some."""
    found: list[Path] = []
    for name in paths:
        path = Path(name)
        inside = sorted(p for p in path.iterdir() if p.suffix.lower() in ENDINGS) if path.is_dir() else []
        found += inside or [path]
    if not found:
        raise SettingsError("no clip named: proxemetry video CLIP... --out DIR")
    return found


def run_clip(
    path: Path, out: str, job: Job, wanted: Wanted, *, fps: float, jobs: int | None = None, restart: bool = False,
    aggregate_only: bool = False, on_progress: Callable[[Progress | Note], None] = lambda _: None,
) -> tuple[Analysis, Sums, dict[str, Any]]:  # fmt: skip
    """Measure a clip into a folder and write everything but the page and the pictures; return what they are made of.

    Raises ClipError where the clip cannot be decoded, OutputError where the folder is of another clip or other
    settings, and what `measure` raises where a setting contradicts the clip.
    """
    folder = Folder(out)
    if restart:
        forget(folder)
    clip = open_clip(path, fps)
    _check_mount(clip, wanted)
    worker = Worker(replace(job, options=replace(job.options, threads=1)))
    settings = {
        **job.settings.to_dict(), "effort": job.options.effort, "device": job.options.device, "flip": job.options.flip,
        "fps": fps, "clip_sha256": clip.sha256,
    }  # fmt: skip
    identity = Identity(__version__, worker.pose, worker.models, settings)
    _join(folder, identity, clip, fps)
    folder.sweep(parts.FOLDER)
    jobs = default_jobs() if jobs is None else jobs
    measured = measure_clip(clip, job, folder, identity.metadata(), jobs, on_progress)
    found = analyse(folder, measured, wanted, jobs, on_progress)
    sums = write_results(found, folder, aggregate_only=aggregate_only)
    numbers = summary(found, sums, clip.name)
    write_json(folder, SUMMARY, numbers)
    main = found.cameras.get(found.main_camera)
    if main is not None and main.mount is not None:
        write_json(folder, MOUNT_FILE, main.mount.to_dict())
    if aggregate_only:
        remove_tracks(folder)
        folder.remove(FRAMES_FILE)
    else:
        write_exports(found, folder)
    return found, sums, numbers


def _check_mount(clip: Clip, wanted: Wanted) -> None:
    """Refuse the mount of pictures of another size before an hour is spent on them."""
    if wanted.mount is not None:
        first = next(clip.frames())
        wanted.mount.check_size(first.photo.width, first.photo.height)


def _join(folder: Folder, identity: Identity, clip: Clip, fps: float) -> None:
    fields = {
        "schema": CLIP_SCHEMA, "version": identity.version, "pose": identity.pose, "models": dict(identity.models),
        "settings": dict(identity.settings), "metadata": identity.metadata(), "clip": clip.name,
        "clip_sha256": clip.sha256, "fps": fps, "python": platform.python_version(),
        "platform": f"{platform.system()} {platform.machine()}",
    }  # fmt: skip
    if folder.create(RUN_FILE, (json.dumps(fields, indent=2) + "\n").encode()):
        return
    before = read_run(folder)
    if before.get("schema") != CLIP_SCHEMA:
        raise OutputError(f"{folder.location}: holds results of photos; name another --out for a clip")
    if before.get("clip_sha256") != clip.sha256:
        same = before.get("clip") == clip.name
        what = (
            f"{clip.name} as it was, and it has changed since"
            if same
            else f"the clip {before.get('clip')}, not {clip.name}"
        )
        raise OutputError(f"{folder.location}: holds {what}; name another --out, or start again with --restart")
    require_same(identity, before.get("metadata") or {}, folder.location)


def read_run(folder: Folder) -> dict[str, Any]:
    """Return the content of a folder's `run.json`; raises OutputError where there is none."""
    content = folder.read(RUN_FILE)
    if content is None:
        raise OutputError(f"{folder.location}: no results there")
    try:
        fields = parse_json(content.decode())
    except ValueError as error:
        raise OutputError(f"{folder.location}/{RUN_FILE}: damaged ({error}); measure again with --restart") from error
    if not isinstance(fields, dict):
        raise OutputError(f"{folder.location}/{RUN_FILE}: damaged (no JSON object); measure again with --restart")
    return cast("dict[str, Any]", fields)


def forget(folder: Folder) -> None:
    """Remove what an earlier run measured; the tables are rewritten."""
    for name in folder.names(parts.FOLDER, ".parquet"):
        folder.remove(f"{parts.FOLDER}/{name}")
    for name in (RUN_FILE, FRAMES_FILE, MOUNT_FILE, SUMMARY):
        folder.remove(name)


#: Corners of a region are nearer than this to the floor's origin, metres.
LARGEST_M = 1e6


def read_region(path: str | Path) -> Region:
    """Read a region: a JSON list of corners [[x, y], ...] in metres, or a GeoJSON polygon; raises SettingsError."""
    try:
        fields = read_json(path)
    except OSError as error:
        raise SettingsError(f"{path}: cannot be read ({error.strerror})") from error
    except ValueError as error:
        raise SettingsError(f"{path}: no JSON ({error})") from error
    corners: FloatArray | None = None
    with suppress(AttributeError, IndexError, KeyError, OverflowError, TypeError, ValueError):
        if isinstance(fields, dict):
            shape = fields.get("geometry", fields)
            fields = shape.get("corners_m") or shape["coordinates"][0]
        corners = np.array(fields, dtype=float)
    if corners is None or corners.shape[1:] != (2,) or len(corners) < 3 or not (abs(corners) <= LARGEST_M).all():
        raise SettingsError(f"{path}: a region is a list of three or more corners [x, y] in metres of the floor")
    region = Region(corners)
    if not region.area_m2 > 0:
        raise SettingsError(f"{path}: the region has no area")
    return region


__all__ = ["ClipError", "Outcome", "clips_of", "forget", "read_region", "read_run", "run_clip"]
