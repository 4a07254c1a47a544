"""Shards to workers, and what to do when one of them does not come back."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field

from . import parts
from .crew import Crew, Died, Done, Ticked
from .folder import Folder
from .manifest import Item, Manifest
from .parts import Counts, Record
from .work import Finished, Job, Task, died

#: How often a photo may end the process that measures it, before its row says so: a process may also be killed by
#: whoever else needs the memory.
_TRIES = 2


@dataclass(frozen=True)
class Progress:
    """How far a run is: photos done by this run, of how many, how many of them failed, and bugs met just now."""

    done: int
    total: int
    failed: int
    errors: tuple[str, ...] = ()


@dataclass
class _Apart:
    """A shard being measured photo by photo, after a worker died of it."""

    rows: dict[str, Record] = field(default_factory=dict[str, Record])
    deaths: dict[str, int] = field(default_factory=dict[str, int])


@dataclass
class Schedule:
    """One pass over the shards of a run. `run` returns what was counted; `tell` hears of every step."""

    crew: Crew
    job: Job
    folder: Folder
    manifest: Manifest
    metadata: Mapping[str, str]
    tell: Callable[[Progress], None] = lambda _: None

    def run(self, shards: Iterable[int]) -> Counts:
        """Measure these shards; raises OutputError where a part cannot be written."""
        self._waiting = deque(shards)
        self._total = sum(self.manifest.shard_size(s) for s in self._waiting)
        self._alone: deque[Task] = deque()
        self._apart: dict[int, _Apart] = {}
        self._running: dict[Task, int] = {}
        self._counts, self._photos = Counts(), 0
        while self._waiting or self._alone or self._running:
            while self.crew.idle() and (self._alone or self._waiting):
                task = self._next()
                self._running[task] = 0
                self.crew.submit(task)
            for event in self.crew.wait():
                self._hear(event)
        return self._counts

    def _next(self) -> Task:
        if self._alone:
            return self._alone.popleft()
        shard = self._waiting.popleft()
        return Task(shard, self.manifest.items(shard), self.metadata)

    def _hear(self, event: Ticked | Done | Died) -> None:
        errors: tuple[str, ...] = ()
        match event:
            case Ticked(task):
                self._running[task] += 1
            case Done(task, finished):
                del self._running[task]
                errors = finished.errors
                self._collect(task, finished)
            case Died(task, how):
                del self._running[task]
                self._retry(task, how)
        done = self._photos + sum(self._running.values())
        self.tell(Progress(done, self._total, self._counts.failed, errors))

    def _collect(self, task: Task, finished: Finished) -> None:
        if task.alone:
            assert finished.record is not None
            self._keep(task.shard, task.items[0], finished.record)
        else:
            self._add(finished.counts)

    def _add(self, counts: Counts) -> None:
        self._counts += counts
        self._photos += counts.photos

    def _retry(self, task: Task, how: str) -> None:
        """Measure the photos of a lost shard one by one; one that ends its process again becomes a row."""
        apart = self._apart.setdefault(task.shard, _Apart())
        if len(task.items) == 1:  # it was this photo, or bad luck: once more will tell
            (item,) = task.items
            apart.deaths[item.photo] = apart.deaths.get(item.photo, 0) + 1
        for item in task.items:
            if apart.deaths.get(item.photo, 0) < _TRIES:
                self._alone.append(Task(task.shard, (item,), task.metadata, alone=True))
            else:
                self._keep(task.shard, item, died(item, how, self.job, self.crew.pose, self.crew.models))

    def _keep(self, shard: int, item: Item, record: Record) -> None:
        """Keep a row of a shard measured photo by photo; with the last of them the part is written."""
        rows = self._apart[shard].rows
        rows[item.photo] = record
        self._add(record.counts)
        items = self.manifest.items(shard)
        if len(rows) == len(items):
            parts.write(self.folder, shard, [rows[i.photo] for i in items], self.metadata)
            del self._apart[shard]
