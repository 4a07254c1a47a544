"""Damaged and hostile input files of every kind that a user hands in: each gives a result or one clear line.

    python -m benchmarks.robustness.fuzz [--inputs 10000] [--seed 0] [--kinds recording,labels,...] [--show 20]

A seeded generator takes whole files and replaces values, breaks structure, cuts, flips and repeats bytes. Counted is
what must not happen: a traceback, a message of several lines, more than ten seconds of processor time, more than 2 GB
of memory, and an answer called "ok" with a distance that is not finite, negative, or outside its interval.

Inputs run in worker processes, each with a limit on its memory, so that an input that ends its process is counted as
well.
"""

from __future__ import annotations

import argparse
import collections
import contextlib
import io
import json
import logging
import multiprocessing
import os
import resource
import shutil
import signal
import sys
import tempfile
import time
import traceback
import warnings
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from multiprocessing.connection import Connection
from pathlib import Path

import numpy as np

from benchmarks.robustness.fuzz_files import WHOLE, damaged
from benchmarks.robustness.process_memory import memory_bytes
from proxemetry.errors import ProxemetryError
from proxemetry.scene import Scene

#: Processor seconds and bytes that one input may take.
MOST_SECONDS, MOST_BYTES = 10, 2_000_000_000
#: A worker that says nothing for so long, in wall time, waits for something that never comes.
_SILENCE_SECONDS = 90


@dataclass(frozen=True)
class Outcome:
    """What became of one input: "result", "line", or what must not happen, with what tells more."""

    kind: str
    number: int
    what: str
    detail: str = ""
    seconds: float = 0.0

    @property
    def is_fault(self) -> bool:
        """Whether it must not happen."""
        return self.what not in ("result", "line")


class _TooLongError(BaseException):
    pass


def check_scene(scene: Scene) -> None:
    """Raise AssertionError where a scene called "ok" has distances that are none, or cannot be written."""
    from proxemetry.archive.store.part_rows import record_of

    json.loads(record_of(scene).json.encode())
    if scene.status != "ok":
        return
    placed, found = scene.bodies.placed, scene.distances
    known = np.isfinite(found.distance_m)
    assert known[np.ix_(placed, placed)].sum() in (known.sum(), known.sum() + placed.sum()), "an unplaced pair"
    if found.reach_m is None:
        expected = np.outer(placed, placed) & ~np.eye(len(placed), dtype=bool)
        assert (known == expected).all(), "a distance that is not finite"
    low, high, middle = (array[known] for array in (found.low_m, found.high_m, found.distance_m))
    assert np.isfinite(low).all() and np.isfinite(high).all(), "an interval that is not finite"
    assert (low >= 0).all() and (low <= middle + 1e-9).all() and (middle <= high + 1e-9).all(), "an inverted interval"
    assert (middle < 1e6).all(), "over a thousand kilometres"
    assert (scene.width_px or 0) > 0


def run_one(kind: str, number: int, seed: int, folder: Path) -> Outcome:
    """Make one damaged input of a kind, hand it in, and return what became of it."""
    generator = np.random.default_rng((seed, number, sorted(WHOLE).index(kind)))
    started = time.process_time()
    said = io.StringIO()
    try:
        with contextlib.redirect_stderr(said), contextlib.redirect_stdout(io.StringIO()), warnings.catch_warnings():
            warnings.simplefilter("ignore")
            hand_in = damaged(kind, generator, folder)
            said.truncate(said.seek(0))  # making the first whole files says something, too
            signal.setitimer(signal.ITIMER_PROF, MOST_SECONDS)
            try:
                for scene in hand_in():
                    check_scene(scene)
            finally:
                signal.setitimer(signal.ITIMER_PROF, 0)
        what, detail = "result", ""
    except ProxemetryError as error:
        what, detail = _judged(str(error))
    except SystemExit as end:
        text = said.getvalue().strip()
        what, detail = _judged(text) if end.code == 2 else ("exit", f"{end.code}: {text[:300]}")
    except _TooLongError:
        what, detail = "too long", traceback.format_exc(limit=-3)
    except MemoryError:
        what, detail = "memory", traceback.format_exc(limit=-3)
    except AssertionError as error:
        what, detail = "wrong answer", str(error) or traceback.format_exc(limit=-2)
    except Exception:
        what, detail = "traceback", traceback.format_exc(limit=-4)
    return Outcome(kind, number, what, detail, time.process_time() - started)


def _judged(message: str) -> tuple[str, str]:
    """Return "line" for one clear line."""
    if "\n" in message or len(message) > 1500 or not message:
        return "no line", message[:500]
    return "line", message


def _work(pipe: Connection, seed: int, folder: str) -> None:
    """Be a worker: run the inputs that are asked for."""

    def late(*_: object) -> None:
        raise _TooLongError

    signal.signal(signal.SIGPROF, late)
    logging.disable(logging.CRITICAL)
    os.environ["OPENCV_FFMPEG_LOGLEVEL"] = "-8"  # its decoders remark on every damaged frame
    resource.setrlimit(resource.RLIMIT_AS, (3 * MOST_BYTES, 3 * MOST_BYTES))
    while (asked := pipe.recv()) is not None:
        kind, number = asked
        where = Path(tempfile.mkdtemp(dir=folder))
        outcome = run_one(kind, number, seed, where)
        shutil.rmtree(where, ignore_errors=True)
        peak = memory_bytes()[1]
        if peak > MOST_BYTES and not outcome.is_fault:
            outcome = Outcome(kind, number, "memory", f"{peak / 1e9:.1f} GB", outcome.seconds)
        pipe.send((outcome, peak))


class _Worker:
    """One process that runs inputs; a new one takes the place of one that dies or waits."""

    def __init__(self, seed: int, folder: str) -> None:
        self._seed, self._folder = seed, folder
        self._start()

    def _start(self) -> None:
        context = multiprocessing.get_context("spawn")
        self._pipe, theirs = context.Pipe()
        self._process = context.Process(target=_work, args=(theirs, self._seed, self._folder), daemon=True)
        self._process.start()
        theirs.close()

    def run(self, kind: str, number: int) -> tuple[Outcome, int]:
        """Return what became of one input, and the worker's peak memory."""
        self._pipe.send((kind, number))
        try:
            if self._pipe.poll(_SILENCE_SECONDS):
                outcome, peak = self._pipe.recv()
                if peak > MOST_BYTES:
                    self.close()
                    self._start()
                return outcome, peak
            what = "hang"
        except EOFError:
            what = "death"
        self.close()
        self._start()
        return Outcome(kind, number, what), 0

    def close(self) -> None:
        """End the process."""
        self._process.kill()
        self._process.join()


def plan(inputs: int, kinds: list[str]) -> Iterator[tuple[str, int]]:
    """Yield kinds and numbers of inputs, each kind by its share; files of a results folder take longest."""
    shares = {kind: WHOLE[kind].share for kind in kinds}
    total = sum(shares.values())
    for kind in kinds:
        for number in range(max(1, round(inputs * shares[kind] / total))):
            yield kind, number


def fuzz(
    inputs: int, seed: int, kinds: list[str], on_outcome: Callable[[Outcome], None] = lambda _: None
) -> tuple[list[Outcome], int]:
    """Return what became of so many inputs, and the peak memory in bytes of who ran them."""
    outcomes, peak = list[Outcome](), 0
    with tempfile.TemporaryDirectory(prefix="proxemetry-fuzz-") as folder:
        worker = _Worker(seed, folder)
        try:
            for kind, number in plan(inputs, kinds):
                outcome, used = worker.run(kind, number)
                peak = max(peak, used)
                outcomes.append(outcome)
                on_outcome(outcome)
        finally:
            worker.close()
    return outcomes, peak


def main() -> int:
    """Run, print a table, and return 1 where something happened that must not."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--inputs", type=int, default=10_000)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--kinds", default=",".join(WHOLE))
    parser.add_argument("--show", type=int, default=20, help="number of faults to print in full")
    args = parser.parse_args()
    started = time.monotonic()
    shown = 0

    def on_outcome(outcome: Outcome) -> None:
        nonlocal shown
        if outcome.is_fault and shown < args.show:
            shown += 1
            print(f"{outcome.kind} {outcome.number}: {outcome.what}\n{outcome.detail}", file=sys.stderr, flush=True)

    outcomes, peak = fuzz(args.inputs, args.seed, args.kinds.split(","), on_outcome)
    print(f"seed {args.seed}: {len(outcomes)} inputs, {time.monotonic() - started:.0f} s, peak {peak / 1e6:.0f} MB")
    print("| kind | inputs | result | one line | faults | slowest, s (CPU) |\n|---|---|---|---|---|---|")
    for kind in dict.fromkeys(o.kind for o in outcomes):
        mine = [o for o in outcomes if o.kind == kind]
        counts = collections.Counter(o.what for o in mine)
        faults = ", ".join(f"{n} {what}" for what, n in counts.items() if what not in ("result", "line")) or "0"
        slowest = max(o.seconds for o in mine)
        print(f"| {kind} | {len(mine)} | {counts['result']} | {counts['line']} | {faults} | {slowest:.1f} |")
    faulty = sum(o.is_fault for o in outcomes)
    print(f"faults: {faulty}")
    return int(faulty > 0)


if __name__ == "__main__":
    sys.exit(main())
