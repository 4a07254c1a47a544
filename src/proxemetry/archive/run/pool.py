"""A pool of worker processes on this machine that survives the death of any of them."""

from __future__ import annotations

import logging
import multiprocessing
import os
import signal
import traceback
from collections import deque
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass, field, replace
from multiprocessing.connection import Connection, wait
from multiprocessing.process import BaseProcess
from typing import Any

from ...errors import ModelError, ProxemetryError
from .caller_script import defines_backend, script_left_out
from .interrupts import held_interrupts
from .work import Finished, Job, Measurer, Task, quiet_threads
from .workers import Event, PhotoDone, TaskDone, WorkerDied, require_same_networks

_STARTS_BEFORE_GIVING_UP = 3
_SECONDS_TO_END = 5.0


def default_jobs() -> int:
    """Return how many workers use this machine fully: one a core that this process may run on."""
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    return max(1, min(cores, _container_cores() or cores))


def _container_cores() -> int | None:
    """Return the processor share that a container is held to, None without a limit."""
    try:
        with open("/sys/fs/cgroup/cpu.max") as file:
            quota, period = file.read().split()
        return None if quota == "max" else max(1, round(int(quota) / int(period)))
    except (OSError, ValueError):
        return None


@dataclass
class _Worker:
    process: BaseProcess
    pipe: Connection
    ready: bool = False
    task: Task | None = None


@dataclass
class Pool:
    """Spawned processes, each with its own back end and one thread, talking through one pipe each.

    The first begins to load at once; more come with `expect`, up to `jobs` of them.
    """

    job: Job
    jobs: int
    pose: str = ""
    models: Mapping[str, str] = field(default_factory=dict[str, str])

    def __post_init__(self) -> None:
        self.job = quiet_threads(self.job)
        self._failed_starts = 0
        self._context = multiprocessing.get_context("spawn")
        self._workers = [self._started()]
        self._events: deque[Event] = deque()

    def load(self) -> None:
        """Wait until a worker is ready; raises ModelError where none comes to that."""
        while not any(w.ready for w in self._workers):
            self._listen()

    def expect(self, photos: int) -> None:
        """Start the workers that so many photos are worth, one at least."""
        while len(self._workers) < min(self.jobs, photos):
            self._workers.append(self._started())

    def _started(self) -> _Worker:
        ours, theirs = self._context.Pipe()
        process = self._context.Process(target=serve, args=(self.job, theirs, bool(self.pose)), daemon=True)
        with held_interrupts(), script_left_out(needed=defines_backend(self.job.pose)):
            process.start()
        theirs.close()
        return _Worker(process, ours)

    def idle(self) -> int:
        """Return how many workers wait for a task."""
        return sum(w.ready and w.task is None for w in self._workers)

    def submit(self, task: Task) -> None:
        """Give a task to a waiting worker."""
        worker = next(w for w in self._workers if w.ready and w.task is None)
        worker.task = task
        with suppress(OSError):  # it died a moment ago: its sentinel reports it
            worker.pipe.send(task)

    def wait(self) -> list[Event]:
        """Wait until a worker reports, becomes ready or dies."""
        self._listen()
        events = list(self._events)
        self._events.clear()
        return events

    def _listen(self) -> None:
        sources: dict[Any, _Worker] = {}
        for worker in self._workers:
            sources[worker.pipe] = worker
            sources[worker.process.sentinel] = worker
        heard = wait(list(sources))
        for worker in {id(sources[s]): sources[s] for s in heard}.values():
            if not self._read(worker):
                self._replace_dead(worker)

    def _read(self, worker: _Worker) -> bool:
        """Receive all messages that a worker has sent; return whether more can follow."""
        try:
            while worker.pipe.poll():
                self._receive(worker, worker.pipe.recv())
        except (EOFError, OSError):
            return False
        return worker.process.is_alive() or worker.pipe.poll()

    def _receive(self, worker: _Worker, message: Any) -> None:
        match message:
            case ("ready", pose, models):
                require_same_networks(self.pose, self.models, models)
                worker.ready = True
                self.pose, self.models = pose, models
                self._failed_starts = 0
            case ("photo",):
                assert worker.task is not None
                self._events.append(PhotoDone(worker.task))
            case ("done", Finished() as finished):
                assert worker.task is not None
                self._events.append(TaskDone(worker.task, finished))
                worker.task = None
            case ("refused", ProxemetryError() as error):
                raise error
            case ("bug", str(trace)):
                raise RuntimeError(f"a worker met a bug:\n{trace}")
            case _:
                raise RuntimeError(f"unknown message from a worker: {message!r}")

    def _replace_dead(self, worker: _Worker) -> None:
        worker.process.join()
        worker.pipe.close()
        how = _end_of(worker.process.exitcode)
        if not worker.ready:
            self._failed_starts += 1
            if self._failed_starts >= _STARTS_BEFORE_GIVING_UP:
                raise ModelError(
                    f"worker processes die while loading the back end {self.job.pose!r} ({how}); "
                    "`proxemetry doctor` shows why"
                )
        if worker.task is not None:
            self._events.append(WorkerDied(worker.task, how))
        self._workers[self._workers.index(worker)] = self._started()

    def close(self) -> None:
        """End all workers, whatever they are at; nothing half written is kept."""
        for worker in self._workers:
            worker.process.terminate()
        for worker in self._workers:
            worker.process.join(_SECONDS_TO_END)
            if worker.process.is_alive():
                worker.process.kill()
                worker.process.join()
            worker.pipe.close()


def _end_of(exit_code: int | None) -> str:
    if exit_code is not None and exit_code < 0:
        with suppress(ValueError):
            return signal.Signals(-exit_code).name
    return f"exit code {exit_code}"


def _follower(job: Job) -> Measurer:
    logger = logging.getLogger("proxemetry")
    level = logger.level
    logger.setLevel(logging.ERROR)
    try:
        return Measurer(replace(job, options=replace(job.options, offline=True)))
    finally:
        logger.setLevel(level)


def serve(job: Job, pipe: Connection, follows: bool = False) -> None:
    """Be a worker: load the back end, do tasks until the pipe closes.

    follows: another worker has loaded it already, so that nothing is left to fetch or to warn of.
    """
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is the parent's to answer
    # A parent that is gone shows as a closed pipe, on the next word at the latest.
    with suppress(EOFError, BrokenPipeError, ConnectionError, KeyboardInterrupt):
        signal.signal(signal.SIGTERM, signal.default_int_handler)  # unwinds, so that temporary files go
        try:
            measurer = _follower(job) if follows else Measurer(job)
            pipe.send(("ready", measurer.backend.name, dict(measurer.backend.models)))
            while True:
                task: Task = pipe.recv()
                pipe.send(("done", measurer.run(task, lambda: pipe.send(("photo",)))))
        except ProxemetryError as error:
            pipe.send(("refused", error))
        except (EOFError, BrokenPipeError, ConnectionError):
            raise
        except Exception:
            pipe.send(("bug", traceback.format_exc()))
        finally:
            # Nothing is left to unwind: a worker that is ended while it ends by itself is not to show a traceback.
            signal.signal(signal.SIGTERM, signal.SIG_DFL)
