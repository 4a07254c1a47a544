"""Workers on a Ray cluster: actors hold the back ends, a shard is a piece of work, the actor writes its own part.

Ray schedules; what was done is known from the parts alone, as everywhere.
"""

from __future__ import annotations

import logging
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from ...errors import ModelError, ProxemetryError, SettingsError
from ...pose import lacking
from .work import Finished, Job, Measurer, Task, quiet_threads
from .workers import Event, TaskDone, WorkerDied, require_same_networks

_STARTS_BEFORE_GIVING_UP = 3


class _Actor:
    """What runs on the cluster. Errors that are meant are handed back as values: they keep their class that way."""

    def __init__(self, job: Job) -> None:
        self._job = quiet_threads(job)
        self._measurer: Measurer | None = None

    def load(self) -> tuple[str, dict[str, str]] | ProxemetryError:
        try:
            self._measurer = Measurer(self._job)
        except ProxemetryError as error:
            return error
        return self._measurer.backend.name, dict(self._measurer.backend.models)

    def run(self, task: Task) -> Finished | ProxemetryError:
        assert self._measurer is not None
        try:
            return self._measurer.run(task)
        except ProxemetryError as error:
            return error


@dataclass
class _Worker:
    actor: Any
    answer: Any
    ready: bool = False
    task: Task | None = None


@dataclass
class RayWorkers:
    """One actor a processor of the cluster, or `jobs` of them.

    RAY_ADDRESS names a running cluster; without it one is started on this machine for this run. The results folder
    must be reachable from every machine under the same path or URL.
    """

    job: Job
    jobs: int | None = None
    pose: str = ""
    models: Mapping[str, str] = field(default_factory=dict[str, str])

    def __post_init__(self) -> None:
        try:
            import ray
        except ImportError as error:
            raise SettingsError("--engine ray needs Ray: pip install 'proxemetry[cluster]'") from error
        self._ray: Any = ray
        self._started_here = not ray.is_initialized()
        if self._started_here:
            try:
                ray.init(include_dashboard=False, log_to_driver=False, logging_level=logging.ERROR)
            except Exception as error:  # Ray's own: plain exceptions, too
                ray.shutdown()
                why = " ".join(str(error).split()) or type(error).__name__
                raise SettingsError(f"Ray does not start here ({why}); try again, or --engine local") from error
        self._remote: Any = ray.remote(num_cpus=1, max_restarts=0)(_Actor)
        self._failed_starts = 0
        count = self.jobs or max(1, int(ray.cluster_resources().get("CPU", 1)))
        self._workers = [self._started() for _ in range(count)]

    def load(self) -> None:
        """Wait until an actor is ready; raises ModelError where none comes to that."""
        while not any(w.ready for w in self._workers):
            self.wait()

    def expect(self, photos: int) -> None:
        """The actors were started at once: a cluster takes its time."""

    def _started(self) -> _Worker:
        actor = self._remote.remote(self.job)
        return _Worker(actor, actor.load.remote())

    def idle(self) -> int:
        """Return how many actors wait for a task."""
        return sum(w.ready and w.task is None for w in self._workers)

    def submit(self, task: Task) -> None:
        """Give a task to a waiting actor."""
        worker = next(w for w in self._workers if w.ready and w.task is None)
        worker.task = task
        worker.answer = worker.actor.run.remote(task)

    def wait(self) -> list[Event]:
        """Wait until an actor answers, becomes ready or dies."""
        waiting = {w.answer: w for w in self._workers if w.answer is not None}
        (reference, *_), _ = self._ray.wait(list(waiting), num_returns=1)
        worker = waiting[reference]
        worker.answer = None
        try:
            answer = self._ray.get(reference)
        except self._ray.exceptions.RayActorError as error:
            return self._replace_dead(worker, error)
        if isinstance(answer, ProxemetryError):
            raise answer
        if worker.task is None:
            require_same_networks(self.pose, self.models, answer[1])
            if not self.pose:  # what an actor prints stays where it runs
                for name in lacking(*answer):
                    logging.getLogger("proxemetry").warning(f"fewer people are found: {name} could not be had")
            worker.ready = True
            self.pose, self.models = answer
            self._failed_starts = 0
            return []
        done = TaskDone(worker.task, answer)
        worker.task = None
        return [done]

    def _replace_dead(self, worker: _Worker, error: Exception) -> list[Event]:
        if not worker.ready:
            self._failed_starts += 1
            if self._failed_starts >= _STARTS_BEFORE_GIVING_UP:
                raise ModelError(f"actors die while loading the back end {self.job.pose!r} ({type(error).__name__})")
        self._workers[self._workers.index(worker)] = self._started()
        return [] if worker.task is None else [WorkerDied(worker.task, type(error).__name__)]

    def close(self) -> None:
        """End all actors, and the cluster where it was started for this run."""
        for worker in self._workers:
            self._ray.kill(worker.actor)
        if self._started_here:
            self._ray.shutdown()
