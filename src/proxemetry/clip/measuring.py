"""Every frame of a clip into a scene, each exactly once, whatever is killed in between.

Frames are measured as photos are, by worker processes, and written in parts of `PART` frames that appear whole or not
at all. One process decodes; it holds no more frames than the workers can use, however long the clip.
"""

from __future__ import annotations

import json
import os
import traceback
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass, field, replace
from typing import Any

from ..archive.run.caller_script import defines_backend
from ..archive.run.interrupts import WorkerProcesses
from ..archive.run.schedule import Note, Progress
from ..archive.store import parts
from ..archive.store.damage import damaged_parts
from ..archive.store.folder import Folder
from ..archive.store.part_rows import Record, record_of
from ..errors import ClipError, OutputError, ProxemetryError
from ..measure import Settings, measure
from ..people import PoseBackend
from ..pose import PoseOptions, backend_named
from ..scene import Provenance, Scene
from ..version import __version__
from .boxes import Boxes
from .frames import Clip, Frame
from .orphans import end_with_parent
from .shots import Shot, ShotFinder

#: Frames of one part: what a kill costs at most, some seconds of work.
PART = 40
FRAMES_FILE = "frames.json"
_WAITING_A_JOB = 3


@dataclass(frozen=True)
class Job:
    """What every worker gets: which back end finds the people, and what is stated of camera and people.

    boxes: people found by another program, instead of a back end's.
    """

    pose: str = "auto"
    options: PoseOptions = field(default_factory=PoseOptions)
    settings: Settings = field(default_factory=Settings)
    boxes: Boxes | None = None


@dataclass(frozen=True)
class Measured:
    """A clip whose frames all are measured: their times in seconds, the shots, and remarks on it."""

    times_s: tuple[float, ...]
    shots: tuple[Shot, ...]
    width_px: int
    height_px: int
    notes: tuple[str, ...]

    def to_json(self) -> bytes:
        """Return it as `frames.json` holds it."""
        fields = {
            "times_s": [round(t, 4) for t in self.times_s], "shots": [s.to_dict() for s in self.shots],
            "width_px": self.width_px, "height_px": self.height_px, "notes": list(self.notes),
        }  # fmt: skip
        return json.dumps(fields).encode()

    @classmethod
    def from_json(cls, content: bytes) -> Measured:
        """Read what `to_json` wrote."""
        fields = json.loads(content)
        return cls(
            tuple(fields["times_s"]), tuple(Shot.from_dict(s) for s in fields["shots"]), fields["width_px"],
            fields["height_px"], tuple(fields["notes"]),
        )  # fmt: skip


def measure_clip(
    clip: Clip,
    job: Job,
    folder: Folder,
    metadata: Mapping[str, str],
    jobs: int,
    on_progress: Callable[[Progress | Note], None],
) -> Measured:
    """Measure every frame that the folder does not have whole, and return what the clip is; raises ClipError."""
    damaged = damaged_parts(folder, parts.names_of(folder))
    for name in damaged:
        folder.remove(name)
    if damaged:
        on_progress(Note(f"{folder.path(damaged[0])}: damaged since it was written: its frames are measured again"))
    there = parts.finished(folder)
    content = folder.read(FRAMES_FILE)
    if content is not None:
        known = Measured.from_json(content)
        if there.issuperset(range(-(-len(known.times_s) // PART))):
            return known
    finder, times, sizes, notes = ShotFinder(), list[float](), list[tuple[int, int]](), list[str]()
    writer = _Writer(folder, metadata, on_progress, clip.expected, len(there) * PART)

    def due() -> Iterator[Frame]:
        for frame in clip.frames():
            finder.see(frame.photo.pixels(), frame.t_s)
            times.append(frame.t_s)
            sizes.append((frame.photo.width, frame.photo.height))
            number = len(times) - 1  # a picture that cannot be decoded leaves no gap
            if number // PART not in there:
                yield replace(frame, number=number)

    for number, record in _records(due(), job, jobs, notes):
        writer.add(number, record)
    if not times:
        raise ClipError(f"{clip.name}: not a single frame that can be decoded")
    writer.close(len(times))
    if len(set(sizes)) > 1:
        raise ClipError(f"{clip.name}: frames of several sizes ({sizes[0]} and others): they are not of one camera")
    expected = clip.expected
    if expected is not None and len(times) < 0.9 * expected - 2:
        notes.append(
            f"the clip ends after {times[-1]:.1f} s, about {len(times) / expected:.0%} of what its header states"
        )
    measured = Measured(tuple(times), finder.shots(), *sizes[0], tuple(dict.fromkeys(notes)))
    folder.write(FRAMES_FILE, measured.to_json())
    return measured


class _Writer:
    """Collects the records of frames and writes a part as soon as it is full."""

    def __init__(
        self, folder: Folder, metadata: Mapping[str, str], on_progress: Callable[[Progress | Note], None],
        total: int | None,
        before: int,
    ) -> None:  # fmt: skip
        self._folder, self._metadata, self._on_progress = folder, metadata, on_progress
        self._total, self._before = total, before
        self._open: dict[int, dict[int, Record]] = {}
        self._done = self._failed = 0

    def add(self, number: int, record: Record) -> None:
        part = self._open.setdefault(number // PART, {})
        part[number] = record
        self._done += 1
        self._failed += record.counts.failed
        total = max((self._total or 0) - self._before, self._done)
        self._on_progress(Progress(self._done, total, self._failed))
        if len(part) == PART:
            self._write(number // PART)

    def close(self, frames: int) -> None:
        """Write what is left when the clip has ended after so many frames."""
        for number in sorted(self._open):
            wanted = min(PART, frames - number * PART)
            if len(self._open[number]) != wanted:
                raise OutputError(f"{self._folder.location}: part {number} has {len(self._open[number])} of {wanted}")
            self._write(number)

    def _write(self, number: int) -> None:
        records = self._open.pop(number)
        parts.write(self._folder, number, [records[k] for k in sorted(records)], self._metadata)


def _records(frames: Iterator[Frame], job: Job, jobs: int, notes: list[str]) -> Iterator[tuple[int, Record]]:
    """Yield every frame's record as it is done, in whatever order."""
    if jobs == 0:
        worker = Worker(job)
        for frame in frames:
            yield frame.number, worker.record(frame)
        return
    for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "OPENCV_FOR_THREADS_NUM"):
        os.environ.setdefault(name, "1")
    job = replace(job, options=replace(job.options, threads=1, offline=True))
    pool, pending, again = _pool(job, jobs), dict[Future[Record], Frame](), set[int]()
    try:
        waiting = iter(frames)
        ended = False
        while pending or not ended:
            while not ended and len(pending) < jobs * _WAITING_A_JOB:
                frame = next(waiting, None)
                ended = frame is None
                if frame is not None:
                    pending[pool.submit(_work, frame)] = frame
            if not pending:
                break
            done, _ = wait(pending, return_when=FIRST_COMPLETED)
            try:
                for future in done:
                    record = future.result()
                    yield pending.pop(future).number, record
            except BrokenProcessPool:
                # a worker died; all that were waiting are tried again, a frame that was there twice is given up
                left = list(pending.values())
                pending.clear()
                pool = _pool(job, jobs)
                for frame in left:
                    if frame.number in again:
                        notes.append(f"{frame.photo.name}: the process measuring it died, twice")
                        yield frame.number, record_of(Scene.failed(frame.photo.name, "the process measuring it died"))
                    else:
                        again.add(frame.number)
                        pending[pool.submit(_work, frame)] = frame
    finally:
        pool.shutdown(wait=False, cancel_futures=True)


def _pool(job: Job, jobs: int) -> ProcessPoolExecutor:
    return WorkerProcesses(jobs, _begin, job, script_needed=defines_backend(job.pose))


_worker: Worker | None = None


def _begin(job: Job) -> None:
    global _worker
    end_with_parent()
    _worker = Worker(job)


def _work(frame: Frame) -> Record:
    assert _worker is not None
    return _worker.record(frame)


class Worker:
    """A loaded back end that turns frames into records."""

    def __init__(self, job: Job) -> None:
        self.job = job
        self.backend: PoseBackend | None = None if job.boxes else backend_named(job.pose, job.options)

    @property
    def pose(self) -> str:
        """The back end that finds the people."""
        return self.job.boxes.name if self.job.boxes else self.backend.name if self.backend else ""

    @property
    def models(self) -> dict[str, str]:
        """The networks' files and their hashes."""
        if self.job.boxes:
            return {self.job.boxes.name: self.job.boxes.sha256}
        return dict(self.backend.models) if self.backend else {}

    def record(self, frame: Frame) -> Record:
        """Return a frame's record; whatever goes wrong with one frame is in its row."""
        try:
            return record_of(self._scene(frame))
        except ProxemetryError as error:
            reason = str(error).removeprefix(f"{frame.photo.name}: ")
        except Exception as error:  # a bug costs one frame, never the clip
            last = traceback.extract_tb(error.__traceback__)[-1]
            reason = (
                f"internal error ({type(error).__name__}: {error}, {last.filename.rpartition('/')[2]}:{last.lineno})"
            )
        failed = Scene.failed(
            frame.photo.name, " ".join(reason.split()), frame.photo.sha256, settings=self.job.settings,
            made_by=self._made_by(),
        )  # fmt: skip
        return record_of(failed)

    def _scene(self, frame: Frame) -> Scene:
        if self.job.boxes is not None:
            scene = self.job.boxes.scene(frame.photo, frame.source, self.job.settings)
            return replace(scene, made_by=self._made_by())
        assert self.backend is not None
        return measure(frame.photo, pose=self.backend, settings=self.job.settings)

    def _made_by(self) -> Provenance:
        return Provenance(__version__, self.pose, self.models)


def scenes(folder: Folder) -> Iterator[tuple[int, list[str]]]:
    """Yield the scenes of each part as JSON, in the order of the frames, with the number of the part's first frame."""
    for part in sorted(parts.finished(folder)):
        yield part * PART, scenes_of(folder, part)


def scenes_of(folder: Folder, part: int) -> list[str]:
    """Return the scenes of one part as JSON, in the order of the frames."""
    query = "SELECT scene FROM read_parquet($path)"
    found: list[tuple[Any, ...]] = (
        parts.attached(folder).execute(query, {"path": folder.path(parts.name_of(part))}).fetchall()
    )
    return [row[0] for row in found]
