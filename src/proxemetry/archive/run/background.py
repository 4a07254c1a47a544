"""Work in a thread of its own while a run goes on; it waits at a gate until the run opens it."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Future
from threading import Event, Thread
from typing import Generic, TypeVar

T = TypeVar("T")

_SECONDS_TO_END = 2.0


class BackgroundTask(Generic[T]):
    """A thread that does `work` once. `close` ends it, wherever it is: the work asks `stopped` now and then."""

    def __init__(self, work: Callable[[], T]) -> None:
        self.stopped, self.gate = Event(), Event()
        self._work, self._found = work, Future[T]()
        # A daemon: ending the run does not wait for a disk far away.
        self._thread = Thread(target=self._run, daemon=True)
        self._thread.start()

    def _run(self) -> None:
        try:
            self._found.set_result(self._work())
        except BaseException as error:
            self._found.set_exception(error)

    def done(self) -> bool:
        """Return whether `result` would not wait."""
        return self._found.done()

    def result(self) -> T:
        """Wait for what the work gives; raises what went wrong."""
        return self._found.result()

    def close(self) -> None:
        """End the thread, or leave it where it waits for a disk."""
        self.stopped.set()
        self.gate.set()
        self._thread.join(_SECONDS_TO_END)
