"""Ctrl-C, and what is answered likewise, where a library would make something else of it than KeyboardInterrupt.

Python answers signals in the main thread alone, whichever thread of the process the system gives them to: a mask on
the main thread does not keep KeyboardInterrupt out of it once there are others.
"""

from __future__ import annotations

import signal
import threading
from collections.abc import Callable, Generator
from contextlib import contextmanager
from typing import Any

#: Those that `cli.end_as_by_ctrl_c` has answered alike.
_NAMES = ("SIGINT", "SIGTERM", "SIGHUP")

Handler = Callable[[int, Any], Any]


@contextmanager
def answered_afterwards() -> Generator[None]:
    """Answer signals only afterwards: in the midst of loading DuckDB or of starting a process nothing can unwind."""
    heard: list[int] = []
    with _taken(lambda number, _: lambda *_: heard.append(number)):
        yield
    for number in heard:
        signal.raise_signal(number)


#: What libraries make of KeyboardInterrupt: DuckDB in a query, numpy and the bodies of classes while they load.
_MADE_OF_IT = (RuntimeError, ImportError, SystemError)


@contextmanager
def interruptible() -> Generator[None]:
    """Raise KeyboardInterrupt for what a library made of it."""
    heard: list[int] = []

    def noting(number: int, handler: Handler) -> Handler:
        def answer(_: int, frame: Any) -> Any:
            heard.append(number)
            return handler(number, frame)

        return answer

    try:
        with _taken(noting):
            yield
    except _MADE_OF_IT as error:
        if heard:
            raise KeyboardInterrupt from error
        raise


@contextmanager
def _taken(answer: Callable[[int, Handler], Handler]) -> Generator[None]:
    """Have signals answered by what `answer` makes of their number and of who answers them now, in the main thread."""
    before: dict[int, Handler] = {}
    if threading.current_thread() is threading.main_thread():
        numbers = [getattr(signal, name) for name in _NAMES if hasattr(signal, name)]
        before = {number: found for number in numbers if callable(found := signal.getsignal(number))}
    try:
        for number, handler in before.items():
            signal.signal(number, answer(number, handler))
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
