"""Ctrl-C is the parent's to answer: workers never hear it, and it is not lost while they start."""

import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from multiprocessing import get_context
from pathlib import Path

import pytest

import proxemetry
from proxemetry import cli
from proxemetry.archive.run.interrupts import WorkerProcesses, held_interrupts
from proxemetry.archive.store.duck import attached
from proxemetry.archive.store.folder import Folder
from proxemetry.archive.store.signals import answered_afterwards, interruptible

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


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_what_comes_while_a_library_loads_is_answered_afterwards(number: signal.Signals) -> None:
    before, reached = signal.signal(number, signal.default_int_handler), False
    try:
        with pytest.raises(KeyboardInterrupt), answered_afterwards():
            signal.raise_signal(number)
            reached = True
        assert reached
        assert signal.getsignal(number) is signal.default_int_handler
        signal.signal(number, signal.SIG_IGN)  # as in a shell's background
        with answered_afterwards():
            signal.raise_signal(number)
        assert signal.getsignal(number) == signal.SIG_IGN
    finally:
        signal.signal(number, before)


def test_a_library_that_does_not_load_is_told_and_signals_are_answered_again() -> None:
    with pytest.raises(ImportError), answered_afterwards():
        raise ImportError("made up")
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler
    told: list[BaseException] = []

    def load() -> None:
        try:
            with answered_afterwards():
                pass
        except BaseException as error:  # a signal's handler is the main thread's to set
            told.append(error)

    other = threading.Thread(target=load)
    other.start()
    other.join()
    assert not told


def test_ctrl_c_that_another_thread_takes_is_held_too() -> None:
    reached, now = False, threading.Event()
    other = threading.Thread(target=lambda: now.wait(10) and signal.pthread_kill(threading.get_ident(), signal.SIGINT))
    other.start()
    with pytest.raises(KeyboardInterrupt), held_interrupts():
        now.set()
        other.join()
        time.sleep(0.01)
        reached = True
    assert reached


def test_a_query_that_ctrl_c_ends_is_ended_by_ctrl_c(tmp_path: Path) -> None:
    threading.Timer(0.3, os.kill, (os.getpid(), signal.SIGINT)).start()
    query = "SELECT count(*) FROM range(3000000000) numbers(n) WHERE n * 7 % 13 = 4"
    with pytest.raises(KeyboardInterrupt):
        attached(Folder(tmp_path)).execute(query).fetchone()


def test_an_error_of_another_kind_is_not_taken_for_ctrl_c() -> None:
    with pytest.raises(RuntimeError, match="made up"), interruptible():
        raise RuntimeError("made up")
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


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


@pytest.mark.parametrize("where", ["while a command runs", "while the command line loads"])
def test_ctrl_c_while_a_dataclass_is_made_still_ends_with_the_exit_code(where: str, tmp_path: Path) -> None:
    interrupted = "exec('raise KeyboardInterrupt')"  # dataclasses and named tuples are made this way
    if where == "while a command runs":
        way = f"from proxemetry import cli\ncli._run = lambda arguments: {interrupted}\n"
    else:
        way = f"import proxemetry\n__main__._name_files_in_utf8 = lambda: {interrupted}\n"
    (tmp_path / "ended.py").write_text(f"import sys\nfrom proxemetry import __main__\n{way}sys.exit(__main__.main())\n")
    path = os.pathsep.join([str(tmp_path), os.environ.get("PYTHONPATH", "")])
    done = subprocess.run(
        [sys.executable, "-m", "ended"], env={**os.environ, "PYTHONPATH": path}, capture_output=True, text=True
    )
    assert (done.returncode, "Traceback" in done.stderr) == (130, False), done.stderr


def _interrupted(arguments: object) -> int:
    """Do as C code does that is interrupted and has its own word for it."""
    try:
        signal.raise_signal(signal.SIGINT)
    except KeyboardInterrupt:
        raise ImportError("importing the C extensions failed") from None
    return 0


def test_what_a_library_makes_of_ctrl_c_is_ctrl_c(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(cli, "_run", _interrupted)
    assert cli.main([]) == 130
    assert capsys.readouterr().err == "proxemetry: stopped; what was finished is kept\n"
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler

    def broken(arguments: object) -> int:
        raise ImportError("made up")

    monkeypatch.setattr(cli, "_run", broken)
    with pytest.raises(ImportError, match="made up"):
        cli.main([])


def test_ctrl_c_waits_until_a_command_s_modules_are_loaded(monkeypatch: pytest.MonkeyPatch) -> None:
    load, loaded = cli.importlib.import_module, []

    def interrupted(name: str) -> object:
        signal.raise_signal(signal.SIGINT)
        loaded.append(load(name))
        return loaded[-1]

    monkeypatch.setattr(cli.importlib, "import_module", interrupted)
    assert cli.main(["models", "list"]) == 130
    assert [module.__name__ for module in loaded] == ["proxemetry.cli.models"]


def test_importing_the_package_takes_no_longer_than_it_must() -> None:
    """Until the command line begins, Ctrl-C is a traceback: `typing` and its like are for later."""
    source = str(Path(proxemetry.__file__).parents[1])
    code = f"import sys; sys.path[:0] = [{source!r}]; import proxemetry; print(*sys.modules)"
    done = subprocess.run([sys.executable, "-I", "-S", "-c", code], capture_output=True, text=True, check=True)
    assert not {"typing", "re", "enum", "importlib", "collections"} & set(done.stdout.split())
