"""Links to themselves, pipes, devices and sockets where a file is expected: one row or line at once, never a wait."""

import os
import shutil
import signal
import socket
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from proxemetry.archive.store.results import Results
from proxemetry.cli import main
from synthetic.small_photos import write_photos

_SECONDS = 60


def _pipe(path: Path) -> None:
    os.mkfifo(path)


def _link_to_itself(path: Path) -> None:
    path.symlink_to(path.name)


def _link_to_nothing(path: Path) -> None:
    path.symlink_to("absent")


def _device(path: Path) -> None:
    path.symlink_to("/dev/zero")


def _socket(path: Path) -> None:
    where = Path.cwd()
    os.chdir(path.parent)  # a socket's whole path may have a hundred letters
    with socket.socket(socket.AF_UNIX) as listener:
        listener.bind(path.name)
    os.chdir(where)


def _folder(path: Path) -> None:
    path.mkdir()


KINDS: dict[str, Callable[[Path], None]] = {
    "pipe": _pipe, "link to itself": _link_to_itself, "link to nothing": _link_to_nothing, "device": _device,
    "socket": _socket,
}  # fmt: skip


@pytest.fixture(autouse=True)
def _no_waiting() -> Iterator[None]:
    """End a test that waits for a pipe or reads a device."""
    if not hasattr(signal, "SIGALRM"):
        pytest.skip("no pipes here")

    def late(*_: object) -> None:
        raise AssertionError("it waits")

    before = signal.signal(signal.SIGALRM, late)
    signal.alarm(_SECONDS)
    yield
    signal.alarm(0)
    signal.signal(signal.SIGALRM, before)


@pytest.fixture(params=KINDS)
def special(request: pytest.FixtureRequest, tmp_path: Path) -> Path:
    """A special file called x.jpg beside a photo."""
    shutil.copy(write_photos(tmp_path / "made", 1) / "00/photo_00000.jpg", _parent(tmp_path) / "a.jpg")
    KINDS[request.param](tmp_path / "photos/x.jpg")
    return tmp_path / "photos/x.jpg"


def _parent(tmp_path: Path) -> Path:
    (tmp_path / "photos").mkdir()
    return tmp_path / "photos"


def _measure(*arguments: str | Path) -> int:
    pose = ("--pose", "python:synthetic.small_photos:two_people", "--jobs", "0")
    return main(["measure", *map(str, arguments), *(() if "--pose" in arguments else pose)])


def test_one_in_a_folder_is_a_row_that_says_so(special: Path, tmp_path: Path) -> None:
    (tmp_path / "photos/y.jpg").write_bytes(b"")  # empty files are compared with one another
    assert _measure(special.parent, "--out", tmp_path / "r") == 1
    found = {scene.photo: scene for scene in Results.open(tmp_path / "r").scenes()}
    assert found["a.jpg"].status == "ok"
    assert found["x.jpg"].status == "failed"
    assert any(word in (found["x.jpg"].reason or "") for word in ("pipe", "link", "device", "socket"))
    assert _measure(special.parent, "--out", tmp_path / "r") == 1  # looked at again, and at once


def test_doctor_looks_at_the_others(special: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["doctor", str(special.parent)]) == 1
    assert "1 that cannot be read" in capsys.readouterr().out


def test_one_named_outright_is_refused(special: Path, tmp_path: Path) -> None:
    assert _measure(special, "--out", tmp_path / "r") == 2


@pytest.mark.parametrize(
    "arguments",
    [
        ["measure", "--pose", "recorded:SPECIAL", "--out", "OUT"],
        ["measure", "PHOTOS", "--camera-table", "SPECIAL", "--out", "OUT"],
        ["measure", "PHOTOS", "--pose", "onnx:SPECIAL", "--out", "OUT", "--jobs", "0"],
        ["doctor", "PHOTOS", "--camera-table", "SPECIAL"],
        ["score", "SPECIAL", "--labels", "SPECIAL"],
        ["score", "--check", "SPECIAL"],
        ["report", "SPECIAL"],
        ["review", "SPECIAL"],
        ["models", "add", "SPECIAL"],
    ],
    ids=lambda a: " ".join(a[:4]),
)
def test_one_as_an_input_is_one_line(
    arguments: list[str], special: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    names = {"SPECIAL": str(special), "PHOTOS": str(special.parent / "a.jpg"), "OUT": str(tmp_path / "r")}
    for name, text in names.items():
        arguments = [argument.replace(name, text) for argument in arguments]
    assert main(arguments) == 2
    said = capsys.readouterr().err
    assert said.count("\n") == 1
    assert "Errno" not in said


def test_one_among_labels_is_a_fault(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    os.mkfifo(tmp_path / "body_pixel_locations.csv")
    assert main(["score", "--check", str(tmp_path)]) == 1
    assert "is a pipe, not a file" in capsys.readouterr().out
    os.mkfifo(tmp_path / "a_keypoints.json")
    assert main(["measure", "--pose", f"recorded:{tmp_path}", "--out", str(tmp_path / "r")]) == 2
