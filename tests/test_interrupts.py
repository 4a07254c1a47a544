"""Ctrl-C is the parent's to answer: workers never hear it, and it is not lost while they start."""

import os
import signal
import sys
import threading
import time
from collections.abc import Iterator
from multiprocessing import get_context
from pathlib import Path

import pytest

from proxemetry.archive.run.interrupts import WorkerProcesses, held_interrupts

pytestmark = pytest.mark.skipif(not hasattr(signal, "pthread_sigmask"), reason="no signal masks on this system")


def _hears_ctrl_c(process: int) -> bool:
    lines = dict(line.split(":", 1) for line in Path(f"/proc/{process}/status").read_text().splitlines())
    bit = 1 << (signal.SIGINT - 1)
    return not (int(lines["SigBlk"], 16) | int(lines["SigIgn"], 16)) & bit


@pytest.fixture(autouse=True)
def answered() -> Iterator[None]:
    """Answer Ctrl-C as Python does by default, in a shell's background too, where it is ignored."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


def test_ctrl_c_while_held_is_answered_afterwards() -> None:
    reached = False
    with pytest.raises(KeyboardInterrupt), held_interrupts():
        signal.pthread_kill(threading.get_ident(), signal.SIGINT)
        reached = True
    assert reached
    assert signal.SIGINT not in signal.pthread_sigmask(signal.SIG_BLOCK, [])


@pytest.mark.skipif(sys.platform != "linux", reason="reads /proc")
def test_a_worker_never_hears_ctrl_c_from_its_first_moment() -> None:
    process = get_context("spawn").Process(target=time.sleep, args=(30,), daemon=True)
    with held_interrupts():
        process.start()
    assert not _hears_ctrl_c(process.pid or 0)
    process.kill()
    process.join()
    with WorkerProcesses(1) as pool:
        worker = pool.submit(os.getpid).result()
        assert not _hears_ctrl_c(worker)
    assert _hears_ctrl_c(os.getpid())
