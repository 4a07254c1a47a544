"""Kill a run at random moments, 20 times, and count what is left: every photo exactly once, nothing half written.

    python -m benchmarks.robustness.kills [--photos 2000] [--kills 20] [--engine local|ray] [--seed 1]

Worker, parent and both are killed in turn with SIGKILL, over small photos with recorded keypoints. A killed
worker costs the run nothing; after the parent is killed, the same command is given again. Linux only (reads /proc).
Exits with 1 if a photo is missing, duplicated or failed, or if any temporary file is left.
"""

from __future__ import annotations

import argparse
import contextlib
import csv
import os
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter
from pathlib import Path

from benchmarks.speed.recorded_archive import name_of, write_keypoints, write_photos

_NOT_STARTED, _MOST_STARTS = 2, 20
_WORKER_TITLES = (b"--multiprocessing-fork", b"ray::_Actor")


def main() -> int:
    """Run the benchmark and return the exit code."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--photos", type=int, default=2000)
    parser.add_argument("--kills", type=int, default=20)
    parser.add_argument("--engine", default="local")
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--seed", type=int, default=1)
    args = parser.parse_args()
    with tempfile.TemporaryDirectory() as scratch:
        return _run(Path(scratch), args)


def _run(folder: Path, args: argparse.Namespace) -> int:
    photos, out, keypoints = folder / "photos", folder / "out", folder / "keypoints.json"
    write_photos(photos, args.photos)
    write_keypoints(keypoints, args.photos)
    chance = random.Random(args.seed)
    kills, starts, resumed_at, not_started = Counter[str](), 0, list[int](), 0
    process, n_parts = None, 0
    while sum(kills.values()) < args.kills and not_started < _MOST_STARTS:
        if process is None:
            process = _start(photos, out, keypoints, args)
            starts += 1
            n_parts = len(_parts(out))
            resumed_at.append(n_parts)
        _await_moment(process, out, n_parts, chance)
        if process.poll() == _NOT_STARTED and args.engine == "ray":
            # On a busy machine Ray gives up on its own start after half a minute: then it is started again.
            not_started, process = not_started + 1, None
            continue
        if process.poll() is not None:  # it ended before it could be killed: look, and begin anew
            problems = _check(out, args.photos)
            if process.returncode or problems:
                output = (folder / "output.txt").read_text(errors="replace")[-2000:]
                print(f"a run ended with exit code {process.returncode}; {'; '.join(problems)}; its output:\n{output}")
                return 1
            shutil.rmtree(out)
            process = None
            continue
        n_parts = len(_parts(out))
        kind = ("worker", "parent", "both")[sum(kills.values()) % 3]
        if _kill(process.pid, kind, args.engine):
            kills[kind] += 1
        if kind != "worker":
            process.wait()
            process = None
    if process is not None:
        process.wait()
    return _finish(folder, args, kills, starts, not_started, resumed_at)


def _await_moment(process: subprocess.Popen[bytes], out: Path, n_parts: int, chance: random.Random) -> None:
    """Wait for the next kill: mostly after some more parts, sometimes while starting, listing or loading."""
    goal, until = n_parts + chance.randrange(1, 6), time.monotonic() + 600
    if chance.random() < 0.25:
        until = time.monotonic() + chance.uniform(0.2, 4.0)
    while process.poll() is None and len(_parts(out)) < goal and time.monotonic() < until:
        time.sleep(0.002)
    time.sleep(chance.uniform(0, 0.05))


def _finish(
    folder: Path, args: argparse.Namespace, kills: Counter[str], starts: int, not_started: int, resumed_at: list[int]
) -> int:
    """Give the command once more, to its end; print what is there then and return the exit code."""
    photos, out, keypoints = folder / "photos", folder / "out", folder / "keypoints.json"
    code = _NOT_STARTED
    while code == _NOT_STARTED and not_started < _MOST_STARTS:
        code = _start(photos, out, keypoints, args).wait()
        not_started += code == _NOT_STARTED
    problems = _check(out, args.photos)
    print(f"{sum(kills.values())} kills ({dict(kills)}), {starts + 1} starts, parts there at each: {resumed_at}")
    if not_started:
        print(f"Ray did not start {not_started} times")
    print(
        f"last exit code {code}; {'; '.join(problems) or f'all {args.photos} photos exactly once, nothing left over'}"
    )
    return 1 if problems or code else 0


def _start(photos: Path, out: Path, keypoints: Path, args: argparse.Namespace) -> subprocess.Popen[bytes]:
    with (out.parent / "output.txt").open("wb") as output:
        return subprocess.Popen(
            [sys.executable, "-m", "proxemetry", "measure", photos, "--out", out, "--pose", f"recorded:{keypoints}",
             "--jobs", str(args.jobs), "--engine", args.engine],
            stdout=subprocess.DEVNULL, stderr=output, start_new_session=True,
        )  # fmt: skip


def _parts(out: Path) -> list[Path]:
    return list(out.glob("scenes/part-*.parquet"))


def _workers(parent: int, engine: str) -> list[int]:
    """Return the worker processes of a run: Ray's hang below others of its session, known by their title."""
    found: list[int] = []
    for path in Path("/proc").glob("[0-9]*"):
        with contextlib.suppress(OSError):
            if any(title in (path / "cmdline").read_bytes() for title in _WORKER_TITLES):
                above, _, session = (path / "stat").read_text().rpartition(")")[2].split()[1:4]
                if parent == int(session if engine == "ray" else above):
                    found.append(int(path.name))
    return found


def _kill(parent: int, kind: str, engine: str) -> bool:
    workers = _workers(parent, engine)
    victims = {"worker": workers[:1], "parent": [parent], "both": [parent, *workers]}[kind]
    for victim in victims:
        with contextlib.suppress(ProcessLookupError):
            os.kill(victim, signal.SIGKILL)
    if kind != "worker" and engine == "ray":  # the cluster that the run had started would stay
        _end_session(parent)
    return bool(victims)


def _end_session(session: int) -> None:
    """Kill what a killed driver leaves of the cluster that it had started."""
    for path in Path("/proc").glob("[0-9]*/stat"):
        with contextlib.suppress(OSError):
            if int(path.read_text().rpartition(")")[2].split()[3]) == session:
                os.kill(int(path.parent.name), signal.SIGKILL)


def _check(out: Path, count: int) -> list[str]:
    problems: list[str] = []
    try:
        with (out / "photos.csv").open(newline="") as file:
            rows = list(csv.DictReader(file))
    except FileNotFoundError:
        return ["there are no tables"]
    found = Counter(row["photo"] for row in rows)
    missing = [name_of(n) for n in range(count) if name_of(n) not in found]
    double = [name for name, times in found.items() if times > 1]
    failed = [row["photo"] for row in rows if row["status"] != "ok"]
    hidden = [str(p) for p in out.rglob("*") if p.name.startswith(".") or p.name.endswith(".tmp")]
    for what, which in (("missing", missing), ("double", double), ("failed", failed), ("left over", hidden)):
        if which:
            problems.append(f"{len(which)} {what}, such as {which[0]}")
    return problems


if __name__ == "__main__":
    sys.exit(main())
