"""Work that takes longer than an answer may: one at a time in a thread, with its progress, and a way to stop it."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

from ..archive.run.schedule import Note, Progress
from ..errors import ProxemetryError, SettingsError

#: Gets a function to call with progress; what it returns is the result.
Work = Callable[[Callable[[Progress | Note], None]], Any]


class _StoppedError(Exception):
    """The page asked to stop."""


@dataclass
class BackgroundWork:
    """At most one piece of work. All methods may be called from several threads."""

    _lock: threading.Lock = field(default_factory=threading.Lock)
    _thread: threading.Thread | None = None
    _state: dict[str, Any] = field(default_factory=lambda: {"status": "idle"})
    _stop: bool = False
    _started: float = 0.0

    def start(self, work: Work, **about: Any) -> None:
        """Begin; about: what else `state` shows. SettingsError while one runs."""
        with self._lock:
            if self._thread is not None and self._thread.is_alive():
                raise SettingsError("this is already running: wait for it, or stop it")
            self._stop, self._started = False, time.monotonic()
            self._state = {"status": "running", **about, "done": 0, "total": 0}
            self._thread = threading.Thread(target=self._run, args=(work,), daemon=True)
            self._thread.start()

    def stop(self) -> None:
        """Ask it to stop at its next step."""
        self._stop = True

    def state(self) -> dict[str, Any]:
        """Return status (idle, running, done, stopped, failed), done, total and seconds_left, note, error or result."""
        with self._lock:
            return dict(self._state)

    def _run(self, work: Work) -> None:
        try:
            self._set(result=work(self._on_progress), status="done")
        except _StoppedError:
            self._set(status="stopped")
        except ProxemetryError as error:
            self._set(status="failed", error=str(error))
        except Exception as error:  # a bug: the page reports it instead of waiting for ever
            self._set(status="failed", error=f"internal error: {error!r}")

    def _on_progress(self, progress: Progress | Note) -> None:
        if self._stop:
            raise _StoppedError
        if isinstance(progress, Note):
            self._set(note=progress.text)
        else:
            seconds = time.monotonic() - self._started
            left = (progress.total - progress.done) * seconds / progress.done if progress.done else None
            self._set(done=progress.done, total=progress.total, failed=progress.failed, seconds_left=left)

    def _set(self, **state: Any) -> None:
        with self._lock:
            self._state.update(state)
