"""What the review page's program leaves behind, and how it treats who keeps it waiting."""

import os
import re
import signal
import socket
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from contextlib import closing
from pathlib import Path

import httpx
import numpy as np
import pytest
from PIL import Image

from proxemetry.archive.store import scratch
from proxemetry.camera import Camera, CameraEstimate
from proxemetry.measure import Settings, place
from proxemetry.people import People
from proxemetry.people.skeleton import COCO_17
from proxemetry.photo import Photo
from proxemetry.scene import Scene
from proxemetry.web import answers, app, serve
from proxemetry.web.session import Review
from proxemetry.web.stores import DropStore
from synthetic.reviewing import served
from synthetic.small_photos import write_photo


def _nobody(photo: Photo) -> Scene:
    camera = CameraEstimate(Camera.centred(700, photo.width, photo.height))
    none = People.none(COCO_17)
    scene = place(photo.name, photo.sha256, photo.width, photo.height, none, camera, Settings())
    time.sleep(0.05)  # so that others come meanwhile
    return scene


def test_photos_dropped_at_once_are_each_their_own(tmp_path: Path) -> None:
    sizes = [(40 + k, 30 + k) for k in range(8)]
    for width, height in sizes:
        Image.fromarray(np.zeros((height, width, 3), np.uint8)).save(tmp_path / f"{width}.png")
    store = DropStore(_nobody)
    review = Review(store, "ada")

    def drop(width: int) -> int:
        # two of each name
        return review.added(store.add((tmp_path / f"{width}.png").read_bytes(), f"{width // 2}.png"))

    with ThreadPoolExecutor(8) as pool:
        identities = list(pool.map(drop, [width for width, _ in sizes]))
    assert sorted(identities) == list(range(8))
    for (width, height), identity in zip(sizes, identities, strict=True):
        view = review.view(identity, app.Query())
        assert (view["width"], view["height"]) == (width, height)
        assert review.picture(identity, 320).startswith(b"\xff\xd8")
    store.close()


@pytest.mark.skipif(os.name != "posix", reason="signals")
@pytest.mark.parametrize("end", [signal.SIGTERM, signal.SIGHUP, signal.SIGINT])
def test_dropped_photos_go_with_the_program(end: signal.Signals, tmp_path: Path) -> None:
    photo = write_photo(tmp_path / "a.jpg", 1)
    program = (
        "import proxemetry.web.stores as stores, proxemetry.cli as cli, sys\n"
        "from tests.test_review_lifetime import _nobody\n"
        "stores.DropStore.__init__.__defaults__ = (_nobody,)\n"
        "sys.exit(cli.main(['review', '--no-browser']))"
    )
    environment = {**os.environ, "TMPDIR": str(tmp_path / "tmp"), "PYTHONPATH": os.pathsep.join(filter(None, sys.path))}
    (tmp_path / "tmp").mkdir()
    with subprocess.Popen(
        [sys.executable, "-c", program],
        env=environment,
        stdout=subprocess.PIPE,
        text=True,
        preexec_fn=lambda: signal.signal(end, signal.SIG_DFL),  # nohup and the background have it ignored
    ) as server:
        assert server.stdout is not None
        address = re.search(r"http://\S+", server.stdout.readline())
        assert address is not None
        origin = address[0].partition("/?")[0]
        with httpx.Client(base_url=origin, headers={"Origin": origin}, timeout=60) as browser:
            browser.get(address[0], follow_redirects=True).raise_for_status()
            browser.post("/api/drop?name=a.jpg", content=photo.read_bytes()).raise_for_status()
        assert list((tmp_path / "tmp").rglob("*.photo"))
        server.send_signal(end)
        server.wait(30)
    assert list((tmp_path / "tmp").iterdir()) == []


def test_what_a_killed_program_left_goes_with_the_next(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(scratch.tempfile, "tempdir", str(tmp_path))
    gone = subprocess.Popen([sys.executable, "-c", ""])
    gone.wait()
    host = socket.gethostname()
    stale = tmp_path / f"proxemetry-review@{host}+{gone.pid}-abc"
    kept = [f"proxemetry-review@{host}+{os.getpid()}-abc", f"proxemetry-review@elsewhere+{gone.pid}-a", "proxemetry-x"]
    for path in (stale, *(tmp_path / name for name in kept)):
        path.mkdir()
        (path / "000001.photo").write_bytes(b"x")
    DropStore(_nobody).close()
    assert sorted(p.name for p in tmp_path.iterdir()) == sorted(kept)


def test_answers_on_a_kept_connection_are_quick() -> None:
    listener = serve._listener(0)
    with closing(listener), socket.create_connection(listener.getsockname()) as client:
        accepted, _ = listener.accept()
        # asyncio sets TCP_NODELAY on these alone; without it each answer waits for the other side's timer, some 40 ms
        assert accepted.proto == socket.IPPROTO_TCP
        accepted.close()
        client.close()


def test_nobody_is_waited_for_without_end(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(serve, "_SECONDS_FOR_A_HEAD", 2.0)
    monkeypatch.setattr(answers, "_SECONDS_FOR_A_PIECE", 0.3)
    with served(Review(DropStore(_nobody), "ada")) as (origin, token):
        host = origin.removeprefix("http://")
        address = (host.partition(":")[0], int(host.partition(":")[2]))
        for start in (b"", b"GET /slow HTTP/1.1\r\nHost: x\r\n"):
            with socket.create_connection(address, timeout=20) as slow:
                slow.sendall(start)
                assert slow.recv(1000) == b""  # closed
        with httpx.Client(base_url=origin, headers={"Origin": origin}) as browser:
            browser.get("/", params={"token": token}, follow_redirects=True).raise_for_status()
            time.sleep(2.5)
            assert browser.get("/api/about").status_code == 200  # a browser that comes back connects again
            cookie = "; ".join(f"{k}={v}" for k, v in browser.cookies.items())
        head = f"POST /api/drop HTTP/1.1\r\nHost: {host}\r\nOrigin: {origin}\r\nCookie: {cookie}\r\n"
        with socket.create_connection(address, timeout=20) as slow:
            slow.sendall(f"{head}Content-Length: 1000\r\n\r\nabc".encode())
            answer = b""
            while b"nothing came for" not in answer and (piece := slow.recv(4000)):
                answer += piece
            assert b"nothing came for" in answer


@pytest.mark.parametrize(
    "body", ["[" * 30_000, '{"action": "note", "value": {"text": 1%s}}' % ("0" * 400), '{"a": NaN}']
)
def test_json_that_nobody_means_is_refused(body: str) -> None:
    with served(Review(DropStore(_nobody), "ada")) as (origin, token), httpx.Client(base_url=origin) as browser:
        browser.headers["Origin"] = origin
        browser.get("/", params={"token": token}, follow_redirects=True)
        answer = browser.post("/api/photos/0/actions", content=body)
        assert answer.status_code in (400, 404)
        assert "Traceback" not in answer.text
