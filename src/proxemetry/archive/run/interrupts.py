"""Ctrl-C belongs to the process that a person started: its workers do not hear it, nor while they are starting."""

from __future__ import annotations

import multiprocessing
import signal
from collections.abc import Callable, Generator
from concurrent.futures import Future, ProcessPoolExecutor
from contextlib import contextmanager
from multiprocessing import resource_tracker
from typing import Any

from ..store.signals import answered_afterwards
from .caller_script import script_left_out


@contextmanager
def held_interrupts() -> Generator[None]:
    """Hold Ctrl-C back; it is answered afterwards. Processes started meanwhile never hear it.

    A new process inherits what is held back, and so has no moment, while it imports, in which Ctrl-C makes a traceback.
    Where a system has no such thing (Windows), they may.
    """
    with answered_afterwards():
        if not hasattr(signal, "pthread_sigmask"):
            yield
            return
        # Its start lets Ctrl-C through again, and would do so in the midst of the first worker's start.
        resource_tracker.ensure_running()
        before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
        try:
            yield
        finally:
            signal.pthread_sigmask(signal.SIG_SETMASK, before)


class WorkerProcesses(ProcessPoolExecutor):
    """Processes of their own interpreter that leave Ctrl-C to the one that started them, and its script alone.

    script_needed: whether what they do is defined in that script.
    """

    def __init__(
        self, jobs: int, initializer: Callable[..., object] | None = None, *initargs: Any, script_needed: bool = False
    ) -> None:
        super().__init__(jobs, multiprocessing.get_context("spawn"), initializer, initargs)
        self._script_needed = script_needed

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
        """Give out a task, as `concurrent.futures` has it."""
        with held_interrupts(), script_left_out(self._script_needed):
            return super().submit(fn, *args, **kwargs)
