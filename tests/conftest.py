"""For all tests: hypothesis measures laws, not the machine's speed, and tries the same examples on every run of CI.

What is printed is as wide as in a file, whatever the width of the terminal that the tests run in. Results to try things
on are measured once a module.
"""

import os
import shutil
import signal
import threading
from pathlib import Path

import pytest
from hypothesis import settings

from proxemetry.text_tables import WIDTH

settings.register_profile("laws", deadline=None, print_blob=True)
settings.register_profile("ci", parent=settings.get_profile("laws"), derandomize=True)
settings.load_profile("ci" if os.environ.get("CI") else "laws")

# A shell's script that starts the tests in the background has them ignore Ctrl-C, and so would every command that they
# start and send it to.
if signal.getsignal(signal.SIGINT) == signal.SIG_IGN and threading.current_thread() is threading.main_thread():
    signal.signal(signal.SIGINT, signal.default_int_handler)


@pytest.fixture(autouse=True)
def as_wide_as_in_a_file(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let tables and sentences break where they do in a file."""
    monkeypatch.setenv("COLUMNS", str(WIDTH))


@pytest.fixture(scope="module")
def original(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder with five photos of two people each in photos, and their results in r."""
    from proxemetry.archive.run.run import run
    from proxemetry.archive.run.work import Job
    from synthetic.small_photos import write_photos

    folder = tmp_path_factory.mktemp("original")
    write_photos(folder / "photos", 5)
    run([str(folder / "photos")], Job(str(folder / "r"), "python:synthetic.small_photos:two_people"), jobs=0)
    return folder


@pytest.fixture
def results(original: Path, tmp_path: Path) -> Path:
    """Return a copy of these results, to be damaged or changed."""
    shutil.copytree(original / "r", tmp_path / "r")
    return tmp_path / "r"
