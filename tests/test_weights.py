"""The networks' files: found, checked, fetched with resume and mirrors, added by hand; never silently wrong."""

from __future__ import annotations

import errno
import hashlib
import http.server
import io
import os
import tarfile
import threading
import zipfile
from pathlib import Path

import pytest

from proxemetry import weights
from proxemetry.errors import CacheError, ModelError, SettingsError
from proxemetry.weights import Model, packages, table, web
from proxemetry.weights import cache as cache_module

CONTENT = bytes(range(256)) * 400
SHA256 = hashlib.sha256(CONTENT).hexdigest()


class _Handler(http.server.BaseHTTPRequestHandler):
    """Serves `files` by path, with byte ranges where `ranges` is set; keeps what was asked for."""

    files: dict[str, bytes]
    ranges: bool
    asked: list[tuple[str, str | None]]

    def do_GET(self) -> None:
        wanted = self.headers.get("Range")
        self.asked.append((self.path, wanted))
        content = self.files.get(self.path)
        if content is None:
            self.send_error(404)
            return
        begin = int(wanted.removeprefix("bytes=").rstrip("-")) if wanted and self.ranges else 0
        if begin >= len(content):
            self.send_error(416)
            return
        self.send_response(206 if begin else 200)
        self.send_header("Content-Length", str(len(content) - begin))
        self.end_headers()
        self.wfile.write(content[begin:])

    def log_message(self, *_: object) -> None:
        pass


@pytest.fixture
def cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    folder = tmp_path / "cache"
    monkeypatch.setenv("PROXEMETRY_CACHE", str(folder))
    monkeypatch.delenv("PROXEMETRY_OFFLINE", raising=False)
    monkeypatch.delenv("PROXEMETRY_MIRROR", raising=False)
    return folder


@pytest.fixture
def server():
    handler = type("Handler", (_Handler,), {"files": {}, "ranges": True, "asked": []})
    running = http.server.ThreadingHTTPServer(("127.0.0.1", 0), handler)
    threading.Thread(target=running.serve_forever, daemon=True).start()
    handler.address = f"http://127.0.0.1:{running.server_port}"
    yield handler
    running.shutdown()
    running.server_close()


def _model(monkeypatch: pytest.MonkeyPatch, **changes: object) -> Model:
    values = {
        "name": "net.onnx", "sha256": SHA256, "size_bytes": len(CONTENT), "sources": (), "origin": "a test",
        "licence": "Apache-2.0", "training_data": "none", **changes,
    }  # fmt: skip
    model = Model(**values)  # type: ignore[arg-type]
    monkeypatch.setitem(table.MODELS, model.name, model)
    return model


def test_every_row_of_the_table_is_complete():
    for name, model in weights.MODELS.items():
        assert name == model.name
        assert len(model.sha256) in {0, *range(8, 65)}
        assert set(model.sha256) <= set("0123456789abcdef")
        assert model.licence and model.origin and model.training_data
        for source in model.sources:
            assert source.startswith(("https://", "pip:", "npm:")), source
        if model.conversion is not None:
            assert model.hash_is_complete and not model.sources
            assert set(model.conversion.parts) <= set(weights.MODELS)
        assert set(model.same_as) <= set(weights.MODELS)
        assert not model.upstream or (model.upstream in model.same_as and weights.MODELS[model.upstream].sources)
    assert all(weights.MODELS[name].hash_is_complete for name in (*weights.EMBEDDED, weights.EMBEDDED_FINDER))


def test_an_unknown_name_is_one_line():
    with pytest.raises(SettingsError, match="proxemetry models list"):
        weights.locate("no-such-network")


def test_fetches_over_the_web_and_is_whole(cache, server, monkeypatch):
    server.files["/net.onnx"] = CONTENT
    _model(monkeypatch, sources=(f"{server.address}/net.onnx",))
    said: list[str] = []
    (located,) = weights.fetch(["net"], log=said.append)
    assert located.path == cache / "net.onnx"
    assert located.path.read_bytes() == CONTENT
    assert located.sha256 == SHA256
    assert len(said) == 1
    assert weights.fetch(["net"], log=said.append) == [located]
    assert len(said) == 1  # what is there is not fetched again
    assert sorted(p.name for p in cache.iterdir()) == ["net.onnx"]


@pytest.mark.parametrize("ranges", [True, False])
@pytest.mark.parametrize("left", [1, 1000, len(CONTENT)])
def test_resumes_what_an_earlier_attempt_left(cache, server, monkeypatch, ranges, left):
    server.files["/net.onnx"], server.ranges = CONTENT, ranges
    _model(monkeypatch, sources=(f"{server.address}/net.onnx",))
    cache.mkdir()
    (cache / "net.onnx.part").write_bytes(CONTENT[:left])
    (located,) = weights.fetch(["net"], log=lambda _: None)
    assert located.path.read_bytes() == CONTENT
    assert server.asked[0] == ("/net.onnx", f"bytes={left}-")
    assert not (cache / "net.onnx.part").exists()


def test_a_part_of_another_version_is_thrown_away(cache, server, monkeypatch):
    server.files["/net.onnx"] = CONTENT
    _model(monkeypatch, sources=(f"{server.address}/net.onnx",))
    cache.mkdir()
    (cache / "net.onnx.part").write_bytes(b"something else entirely")
    (located,) = weights.fetch(["net"], log=lambda _: None)
    assert located.path.read_bytes() == CONTENT


def test_mirrors_are_tried_in_order_and_a_wrong_one_is_passed_over(cache, server, monkeypatch):
    server.files.update({"/wrong": b"x" * 500, "/right": CONTENT})
    base = server.address
    _model(monkeypatch, sources=(f"{base}/absent", f"{base}/wrong", f"{base}/right"))
    (located,) = weights.fetch(["net"], log=lambda _: None)
    assert located.sha256 == SHA256
    assert [path for path, _ in server.asked] == ["/absent", "/wrong", "/right"]


def test_the_users_own_mirror_comes_first(cache, server, monkeypatch):
    server.files["/mine/net.onnx"] = CONTENT
    monkeypatch.setenv("PROXEMETRY_MIRROR", f"{server.address}/mine/")
    _model(monkeypatch, sources=(f"{server.address}/absent",))
    weights.fetch(["net"], log=lambda _: None)
    assert [path for path, _ in server.asked] == ["/mine/net.onnx"]


def test_when_every_source_fails_all_are_named_and_nothing_is_left(cache, server, monkeypatch):
    server.files["/wrong"] = b"wrong"
    _model(monkeypatch, sources=(f"{server.address}/wrong", f"{server.address}/absent"))
    with pytest.raises(ModelError, match=r"net.onnx: could not be fetched; .*/wrong: .*sha256.*; .*/absent: .*404"):
        weights.fetch(["net"], log=lambda _: None)
    assert list(cache.iterdir()) == []


def test_a_full_disk_is_said_and_nothing_else_is_tried(cache, server, monkeypatch):
    server.files["/net.onnx"] = CONTENT
    _model(monkeypatch, sources=(f"{server.address}/net.onnx", f"{server.address}/other"))

    def full(*_):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(web.shutil, "copyfile", full)
    with pytest.raises(CacheError, match=r"cache: no space left for net.onnx; make room"):
        weights.fetch(["net.onnx"])
    assert [path for path, _ in server.asked] == ["/net.onnx"]
    assert list(cache.iterdir()) == []


def test_takes_a_member_out_of_a_zip(cache, server, monkeypatch):
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w") as archive:
        archive.writestr("deep/end2end.onnx", CONTENT)
    server.files["/a.zip"] = packed.getvalue()
    _model(monkeypatch, sources=(f"{server.address}/a.zip#deep/end2end.onnx",))
    (located,) = weights.fetch(["net"], log=lambda _: None)
    assert located.path.read_bytes() == CONTENT


def _tgz(**members: bytes) -> bytes:
    packed = io.BytesIO()
    with tarfile.open(fileobj=packed, mode="w:gz") as archive:
        for name, content in members.items():
            entry = tarfile.TarInfo(f"package/{name}")
            entry.size = len(content)
            archive.addfile(entry, io.BytesIO(content))
    return packed.getvalue()


@pytest.mark.parametrize(("before", "after"), [(b"", b""), (b"classes", b""), (b"classes", b"more")])
def test_takes_bytes_of_a_member_out_of_a_tar(cache, server, monkeypatch, before, after):
    server.files["/a.tgz"] = _tgz(assets=before + CONTENT + after, other=b"x" * 5000)
    extent = f"{len(before)}-{len(before) + len(CONTENT)}"
    _model(monkeypatch, sources=(f"{server.address}/a.tgz#package/assets@{extent}",))
    (located,) = weights.fetch(["net"], log=lambda _: None)
    assert located.path.read_bytes() == CONTENT
    assert sorted(p.name for p in cache.iterdir()) == ["net.onnx"]


def test_a_whole_member_of_a_tar_needs_no_bytes(cache, server, monkeypatch):
    server.files["/a.tar.gz"] = _tgz(network=CONTENT)
    _model(monkeypatch, sources=(f"{server.address}/a.tar.gz#package/network",))
    assert weights.fetch(["net"], log=lambda _: None)[0].sha256 == SHA256


@pytest.mark.parametrize("content", [b"", b"no archive", _tgz(other=CONTENT), _tgz(assets=CONTENT)[:-200]])
def test_a_tar_that_is_none_or_cut_short_or_lacks_the_member_is_one_line(cache, server, monkeypatch, content):
    server.files["/a.tgz"] = content
    _model(monkeypatch, sources=(f"{server.address}/a.tgz#package/assets@0-{len(CONTENT)}",))
    with pytest.raises(ModelError, match=r"could not be fetched; .*a.tgz#package/assets"):
        weights.fetch(["net"], log=lambda _: None)
    assert list(cache.iterdir()) == []


def test_bytes_beside_those_named_are_another_file(cache, server, monkeypatch):
    server.files["/a.tgz"] = _tgz(assets=b"ab" + CONTENT)
    _model(monkeypatch, sources=(f"{server.address}/a.tgz#package/assets@1-{1 + len(CONTENT)}",))
    with pytest.raises(ModelError, match="was not kept"):
        weights.fetch(["net"], log=lambda _: None)


def test_what_is_not_needed_is_done_without_and_says_so(cache, server, monkeypatch):
    server.files["/net.onnx"] = CONTENT
    _model(monkeypatch, sources=(f"{server.address}/absent",))
    said: list[str] = []
    assert weights.if_to_be_had("net", log=said.append) is None
    assert weights.if_to_be_had("net", log=said.append, offline=True) is None
    assert [line for line in said if line.startswith("fewer people are found: net.onnx: ")] == said[1:]
    _model(monkeypatch, sources=(f"{server.address}/net.onnx",))
    located = weights.if_to_be_had("net", log=said.append)
    assert located is not None and located.sha256 == SHA256
    located.path.write_bytes(b"damaged")
    with pytest.raises(ModelError, match="damaged"):
        weights.if_to_be_had("net", log=said.append)


def test_a_published_prefix_is_enough_and_the_full_hash_is_kept(cache, server, monkeypatch):
    server.files["/net.onnx"] = CONTENT
    _model(monkeypatch, sha256=SHA256[:8], sources=(f"{server.address}/net.onnx",))
    (located,) = weights.fetch(["net"], log=lambda _: None)
    assert located.sha256 == SHA256
    assert SHA256 in (cache / "net.onnx.sha256").read_text()
    (cache / "net.onnx").write_bytes(CONTENT[:-1])
    with pytest.raises(ModelError, match=f"expected {SHA256}"):
        weights.verify("net")


def test_the_licence_must_be_accepted_where_it_forbids_commercial_use(cache, server, monkeypatch):
    server.files["/net.onnx"] = CONTENT
    _model(monkeypatch, commercial_use=False, licence="CC BY-NC", sources=(f"{server.address}/net.onnx",))
    with pytest.raises(ModelError, match="--accept-licence"):
        weights.fetch(["net"])
    assert server.asked == []
    assert weights.fetch(["net"], accept_licence=True, log=lambda _: None)


def test_offline_forbids_and_says_what_to_do(cache, server, monkeypatch):
    _model(monkeypatch, sources=(f"{server.address}/net.onnx",))
    with pytest.raises(ModelError, match="offline"):
        weights.require(["net"], may_fetch=True, offline=True)
    monkeypatch.setenv("PROXEMETRY_OFFLINE", "1")
    with pytest.raises(ModelError, match=r"net.onnx: .*offline.*models fetch"):
        weights.require(["net"], may_fetch=True)
    assert server.asked == []


def test_an_absent_or_damaged_file_names_itself_and_the_remedy(cache, monkeypatch):
    _model(monkeypatch, sources=("https://example.invalid/net.onnx",))
    with pytest.raises(ModelError, match=r"models fetch net\.onnx"):
        weights.require(["net"])
    cache.mkdir()
    (cache / "net.onnx").write_bytes(b"damaged")
    with pytest.raises(ModelError, match=r"damaged.*delete it"):
        weights.require(["net"])


def test_a_file_that_nobody_may_hand_on_is_added_by_the_user(cache, tmp_path, monkeypatch):
    _model(monkeypatch, licence="non-commercial research", commercial_use=False)
    with pytest.raises(ModelError, match=r"models add FILE --name net\.onnx"):
        weights.fetch(["net"], accept_licence=True)
    own = tmp_path / "downloaded.bin"
    own.write_bytes(CONTENT)
    assert weights.add(own).path == cache / "net.onnx"
    own.write_bytes(CONTENT + b"!")
    with pytest.raises(ModelError, match="in no row of the table"):
        weights.add(own)
    with pytest.raises(ModelError, match="was not kept"):
        weights.add(own, "net")
    assert weights.verify("net").sha256 == SHA256  # what was there is untouched
    with pytest.raises(ModelError, match="no such file"):
        weights.add(tmp_path / "absent")


def test_a_shared_read_only_cache_serves_beside_ones_own(tmp_path, monkeypatch):
    shared, own = tmp_path / "shared", tmp_path / "own"
    shared.mkdir()
    (shared / "net.onnx").write_bytes(CONTENT)
    monkeypatch.setattr(cache_module.os, "access", lambda path, mode: Path(path) != shared)
    monkeypatch.setenv("PROXEMETRY_CACHE", f"{shared}{os.pathsep}{own}")
    _model(monkeypatch)
    assert weights.verify("net").path == shared / "net.onnx"
    assert cache_module.writable_folder() == own


def test_a_wheel_gives_all_its_networks_at_once(cache, tmp_path, monkeypatch):
    def pip(what: str, command: list[str], folder: Path, *_: object) -> None:
        calls.append(command)
        with zipfile.ZipFile(folder / "some-1.0-py3-none-any.whl", "w") as wheel:
            wheel.writestr("some/a.tflite", CONTENT)
            wheel.writestr("some/b.tflite", CONTENT + b"b")

    calls: list[list[str]] = []
    monkeypatch.setattr(packages, "_run_client", pip)
    _model(monkeypatch, name="a.tflite", sources=("pip:some==1.0#some/a.tflite",))
    digest = hashlib.sha256(CONTENT + b"b").hexdigest()
    _model(monkeypatch, name="b.tflite", sha256=digest, sources=("pip:some==1.0#some/b.tflite",))
    said: list[str] = []
    located = weights.fetch(["a.tflite", "b.tflite"], log=said.append)
    assert [one.path.name for one in located] == ["a.tflite", "b.tflite"]
    assert len(calls) == len(said) == 1
    assert "--no-deps" in calls[0] and "some==1.0" in calls[0]


def test_pip_that_is_missing_or_fails_is_one_line(cache, monkeypatch):
    _model(monkeypatch, sources=("pip:some==1.0#a",))
    monkeypatch.setattr(packages.sys, "executable", "/no/such/python")
    monkeypatch.setattr(packages.subprocess, "run", _no_pip)
    monkeypatch.setattr(packages.shutil, "which", lambda _: None)
    with pytest.raises(ModelError, match="ensurepip"):
        weights.fetch(["net"], log=lambda _: None)


def _no_pip(command, **_):
    return type("Done", (), {"returncode": 1, "stdout": "", "stderr": ""})()
