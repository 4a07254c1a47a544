"""Shards to workers, and what to do when one of them does not come back."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterable, Mapping
from dataclasses import InitVar, dataclass, field

from ..store import parts
from ..store.folder import Folder
from ..store.manifest import Item, Manifest
from ..store.part_rows import Counts, Record
from .changed_files import ChangedFiles, FileScan
from .manifest_update import ManifestUpdate
from .work import Finished, Job, Task, died
from .workers import PhotoDone, TaskDone, WorkerDied, WorkerPool

#: How often a photo may end the process that measures it before that becomes its result: a process may also be killed
#: because another program needs the memory.
_TRIES = 2
#: How many shards that have to wait for others are passed over.
_LOOK_AHEAD = 64


@dataclass(frozen=True)
class Progress:
    """How far a run is: photos done by this run, of how many, how many of them failed. errors: bugs met just now."""

    done: int
    total: int
    failed: int
    errors: tuple[str, ...] = ()


@dataclass(frozen=True)
class Note:
    """What else a user should know while a run goes on, as one line."""

    text: str


@dataclass(frozen=True)
class Pass:
    """What one pass over the shards of a run found: the manifest as it is now, and what was counted."""

    manifest: Manifest
    counts: Counts


@dataclass
class SingleFileRetry:
    """A shard being measured photo by photo, after a worker died of it."""

    rows: dict[str, Record] = field(default_factory=dict[str, Record])
    deaths: dict[str, int] = field(default_factory=dict[str, int])


@dataclass
class Schedule:
    """One pass over the shards of a run; on_progress is called with every step.

    is_mine: which shards this run does. update: photos that may be added while it works. scan: photos that may have
    to be measured again. pool: the digest of the evidence from other photos, where that alone is new (`work.Task`).
    """

    workers: WorkerPool
    job: Job
    folder: Folder
    manifest: InitVar[Manifest]
    metadata: Mapping[str, str]
    on_progress: Callable[[Progress | Note], None] = lambda _: None
    update: InitVar[ManifestUpdate | None] = None
    scan: InitVar[FileScan | None] = None
    is_mine: Callable[[int], bool] = lambda _: True
    pool: str = ""

    def __post_init__(self, manifest: Manifest, update: ManifestUpdate | None, scan: FileScan | None) -> None:
        self._manifest, self._update, self._scan = manifest, update, scan
        self._waiting: deque[int] = deque()
        self._unfinished: set[int] = set()
        self._alone: deque[Task] = deque()
        self._retries: dict[int, SingleFileRetry] = {}
        self._running: dict[Task, int] = {}
        self._counts, self._photos, self._total = Counts(), 0, 0

    def run(self, shards: Iterable[int]) -> Pass:
        """Measure these shards, and what is added meanwhile; raises OutputError where a part cannot be written."""
        self._extend(shards)
        while True:
            busy = bool(self._waiting or self._alone or self._running)
            if self._update is not None and (not busy or self._update.done()):
                self._use_updated(self._update.result())
            elif self._scan is not None and (not busy or self._scan.done()):
                self._remeasure(self._scan.result())
            elif not busy:
                return Pass(self._manifest, self._counts)
            else:
                self._step()

    def _extend(self, shards: Iterable[int]) -> None:
        new = list(shards)
        self._waiting.extend(new)
        self._unfinished.update(new)
        self._total += sum(self._manifest.shard_sizes[s] for s in new)
        if new:
            self.workers.expect(self._total - self._photos)
            self._report()

    def _use_updated(self, manifest: Manifest) -> None:
        """Go on with the whole manifest, photos that were added included."""
        before, self._manifest, self._update = self._manifest.n_shards, manifest, None
        self._extend(s for s in range(before, manifest.n_shards) if self.is_mine(s))

    def _remeasure(self, found: ChangedFiles) -> None:
        """Do the shards again in which photos are not what was measured."""
        self._scan = None
        if found.gone:
            which = "photo that was measured is", "photos that were measured are"
            self._note(
                f"{_counted(found.gone, *which)} not there any more ({found.example}): what was deleted, renamed or "
                "moved keeps its rows until --restart, next to those under its new name"
            )
        if found.unlike:
            counted = _counted(found.unlike, "photo has", "photos have")
            self._note(f"{counted} another size or date than when measured: what is another picture is measured again")
        self._extend(sorted(found.shards - self._unfinished))

    def _note(self, text: str) -> None:
        self.on_progress(Note(text))

    def _step(self) -> None:
        while self.workers.idle() and (task := self._next()) is not None:
            self._running[task] = 0
            self.workers.submit(task)
        for event in self.workers.wait():
            self._handle(event)

    def _next(self) -> Task | None:
        """Return the next task; a shard with copies of photos whose shard is being measured has to wait for that."""
        if self._alone:
            return self._alone.popleft()
        for place, shard in enumerate(self._waiting):
            items = self._manifest.items(shard)
            if self._unfinished.isdisjoint(i.original_shard for i in items if i.original_shard is not None):
                del self._waiting[place]
                return Task(shard, items, self.metadata, pool=self.pool)
            if place >= _LOOK_AHEAD:
                break
        return None

    def _handle(self, event: PhotoDone | TaskDone | WorkerDied) -> None:
        errors: tuple[str, ...] = ()
        if self._scan is not None:
            self._scan.begin()  # the first photo does not wait for it
        match event:
            case PhotoDone(task):
                self._running[task] += 1
            case TaskDone(task, finished):
                del self._running[task]
                errors = finished.errors
                self._collect(task, finished)
            case WorkerDied(task, how):
                del self._running[task]
                self._retry(task, how)
        self._report(errors)

    def _report(self, errors: tuple[str, ...] = ()) -> None:
        done = self._photos + sum(self._running.values())
        self.on_progress(Progress(done, self._total, self._counts.failed, errors))

    def _collect(self, task: Task, finished: Finished) -> None:
        if task.alone:
            assert finished.record is not None
            self._keep_retried(task.shard, task.items[0], finished.record)
        else:
            self._add(finished.counts)
            self._unfinished.discard(task.shard)

    def _add(self, counts: Counts) -> None:
        self._counts += counts
        self._photos += counts.photos

    def _retry(self, task: Task, how: str) -> None:
        """Measure the photos of a lost shard one by one; one that ends its process again becomes a row."""
        retry = self._retries.setdefault(task.shard, SingleFileRetry())
        if len(task.items) == 1:  # it was this photo, or bad luck: one more try shows which
            (item,) = task.items
            retry.deaths[item.photo] = retry.deaths.get(item.photo, 0) + 1
        for item in task.items:
            if retry.deaths.get(item.photo, 0) < _TRIES:
                self._alone.append(Task(task.shard, (item,), task.metadata, alone=True, pool=task.pool))
            else:
                self._keep_retried(task.shard, item, died(item, how, self.job, self.workers.pose, self.workers.models))

    def _keep_retried(self, shard: int, item: Item, record: Record) -> None:
        """Keep a row of a shard measured photo by photo; with the last of them the part is written."""
        rows = self._retries[shard].rows
        rows[item.photo] = record
        self._add(record.counts)
        items = self._manifest.items(shard)
        if len(rows) == len(items):
            parts.write(self.folder, shard, [rows[i.photo] for i in items], self.metadata)
            del self._retries[shard]
            self._unfinished.discard(shard)


def _counted(count: int, one: str, many: str) -> str:
    return f"{count} {one if count == 1 else many}"
