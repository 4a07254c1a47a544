"""How far a run is, on stderr: a bar on a terminal, a line now and then in a log file."""

from __future__ import annotations

import sys
import time
from types import TracebackType
from typing import Any

from ..archive.run.schedule import Note, Progress
from ..errors import one_line

_SECONDS_BETWEEN_LINES = 30.0


class Reporter:
    """Call it with every step; leaving it closes the bar."""

    def __init__(self, unit: str = "photo") -> None:
        self._unit = unit
        self._bar: Any = None
        self._started = self._said = 0.0
        self._last = Progress(0, 0, 0)

    def __enter__(self) -> Reporter:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._ended()

    def _ended(self) -> None:
        """Tell how a pass over the photos ended; the time of another is counted from its own beginning."""
        if self._bar is not None:
            self._bar.close()
        elif self._started and self._last.total and not sys.stderr.isatty():
            self._say()
        self._bar, self._started, self._last = None, 0.0, Progress(0, 0, 0)

    def __call__(self, progress: Progress | Note) -> None:
        """Show one step."""
        if isinstance(progress, Note):
            if self._last.done and self._last.done == self._last.total:
                self._ended()
            self._write(f"proxemetry: {one_line(progress.text)}")
            return
        if progress.done < self._last.done:  # a second pass
            self._ended()
        if not self._started:
            self._started = self._said = time.monotonic()
        self._last = progress
        for trace in progress.errors:
            self._write(f"proxemetry: a bug in one {self._unit}; the run continues. Please report it:\n{trace}")
        if sys.stderr.isatty():
            self._show()
        elif time.monotonic() - self._said >= _SECONDS_BETWEEN_LINES:
            self._say()

    def _show(self) -> None:
        from tqdm import tqdm

        if self._bar is None:
            self._bar = tqdm(total=self._last.total, unit=self._unit, dynamic_ncols=True, smoothing=0.05)
        self._bar.total = self._last.total  # photos may be found while others are measured
        self._bar.update(self._last.done - self._bar.n)
        if self._last.failed:
            self._bar.set_postfix_str(f"{self._last.failed} failed", refresh=False)

    def _say(self) -> None:
        """Write one line that reads well in a log."""
        self._said = time.monotonic()
        done, total = self._last.done, self._last.total
        rate = done / max(self._said - self._started, 1e-9)
        left = f", {_duration((total - done) / rate)} left" if rate and done < total else ""
        failed = f", {self._last.failed} failed" if self._last.failed else ""
        self._write(
            f"{time.strftime('%H:%M:%S')} {done}/{total} {self._unit}s, {rate:.2f} {self._unit}s/s{left}{failed}"
        )

    def _write(self, text: str) -> None:
        if self._bar is not None:
            self._bar.write(text, file=sys.stderr)
        else:
            print(text, file=sys.stderr, flush=True)


def _duration(seconds: float) -> str:
    """Return a duration in words."""
    minutes, hours = round(seconds / 60), seconds / 3600
    if seconds < 90:
        return f"{seconds:.0f} s"
    return f"{minutes} min" if hours < 2 else f"{hours:.0f} h" if hours < 72 else f"{hours / 24:.0f} days"
