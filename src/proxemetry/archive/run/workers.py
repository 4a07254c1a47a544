"""Workers as the schedule sees them, whatever runs them: this process, a pool of processes, a cluster."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Protocol

from ...errors import ModelError
from .work import Finished, Job, Measurer, Task


@dataclass(frozen=True)
class PhotoDone:
    """One more photo of a task is done."""

    task: Task


@dataclass(frozen=True)
class TaskDone:
    """A task is done."""

    task: Task
    finished: Finished


@dataclass(frozen=True)
class WorkerDied:
    """The worker that had a task is gone."""

    task: Task
    how: str


Event = PhotoDone | TaskDone | WorkerDied


class WorkerPool(Protocol):
    """Workers that take tasks one at a time, once `load` was called."""

    @property
    def pose(self) -> str:
        """The back end's name."""
        ...

    @property
    def models(self) -> Mapping[str, str]:
        """The back end's files and their sha256."""
        ...

    def load(self) -> None:
        """Wait until a worker has its back end loaded; raises what kept it from that."""
        ...

    def expect(self, photos: int) -> None:
        """Start the workers that so many photos are worth."""
        ...

    def idle(self) -> int:
        """Return how many tasks would be taken at once."""
        ...

    def submit(self, task: Task) -> None:
        """Give a task to an idle worker."""
        ...

    def wait(self) -> list[Event]:
        """Wait until something happened, if only that a worker is ready; raises what a worker raised on purpose."""
        ...

    def close(self) -> None:
        """End all workers, whatever they are at."""
        ...


def require_same_networks(pose: str, models: Mapping[str, str], others: Mapping[str, str]) -> None:
    """Raise ModelError where a worker loaded other networks than those before it; `pose` is empty for the first one.

    What is fetched where it can be had may be had by one and not by the next.
    """
    different = sorted(name for name in {*models, *others} if models.get(name) != others.get(name))
    if pose and different:
        raise ModelError(
            f"workers have different networks ({', '.join(different)}): run `proxemetry models fetch` wherever they "
            "run, then start again"
        )


class InlineWorker:
    """One worker, this process. A photo that ends the process ends the run."""

    def __init__(self, job: Job) -> None:
        self._measurer = Measurer(job)
        self._waiting: list[Task] = []

    def load(self) -> None:
        """It is loaded."""

    def expect(self, photos: int) -> None:
        """There is one."""

    @property
    def pose(self) -> str:
        """The back end's name."""
        return self._measurer.backend.name

    @property
    def models(self) -> Mapping[str, str]:
        """The back end's files and their sha256."""
        return self._measurer.backend.models

    def idle(self) -> int:
        """Return 1 where no task waits."""
        return 1 - len(self._waiting)

    def submit(self, task: Task) -> None:
        """Take a task."""
        self._waiting.append(task)

    def wait(self) -> list[Event]:
        """Do the task that waits."""
        task = self._waiting.pop()
        ticks: list[Event] = []
        finished = self._measurer.run(task, lambda: ticks.append(PhotoDone(task)))
        return [*ticks, TaskDone(task, finished)]

    def close(self) -> None:
        """Nothing to end."""
