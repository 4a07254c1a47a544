"""The review page's server: who may ask, what may be sent, and what the answers say."""

import contextlib
import csv
import http.client
import io
import json
import shutil
import struct
import zlib
from collections.abc import Iterator
from pathlib import Path

import httpx
import numpy as np
import pytest
from PIL import Image

from proxemetry.archive.figures.totals import totals
from proxemetry.archive.review.corrections import FILE
from proxemetry.archive.store.index import card_of, cards
from proxemetry.archive.store.results import Results
from proxemetry.camera import Camera, CameraEstimate
from proxemetry.cli import main
from proxemetry.errors import SettingsError
from proxemetry.measure import place
from proxemetry.people import People
from proxemetry.people.skeleton import COCO_17
from proxemetry.photo import Photo
from proxemetry.scene import Scene
from proxemetry.settings import Settings
from proxemetry.web.gallery import Query
from proxemetry.web.session import Review
from proxemetry.web.stores import DropStore, FolderStore
from synthetic.drawn import people_at
from synthetic.reviewing import CAMERA, draw_photo, make_results, scene_of, served, write_results

PNG = b"\x89PNG\r\n\x1a\n"


class Client:
    """The page as its own browser tab would ask."""

    def __init__(self, origin: str, token: str) -> None:
        self.origin, self.token = origin, token
        self.http = httpx.Client(base_url=origin, headers={"Origin": origin}, timeout=60)
        self.http.get("/", params={"token": token}, follow_redirects=True).raise_for_status()

    def photo(self, identity: int) -> dict:
        return self.http.get(f"/api/photos/{identity}").raise_for_status().json()

    def act(self, identity: int, action: str, value: dict) -> httpx.Response:
        return self.http.post(f"/api/photos/{identity}/actions", json={"action": action, "value": value})


@pytest.fixture
def results(tmp_path: Path) -> Results:
    return make_results(tmp_path)


@pytest.fixture
def client(results: Results) -> Iterator[Client]:
    with served(Review(FolderStore(results.folder.location), "ada")) as (origin, token):
        yield Client(origin, token)


def nobody(photo: Photo) -> Scene:
    estimate = CameraEstimate(Camera.centred(500, photo.width, photo.height))
    return place(
        photo.name, photo.sha256, photo.width, photo.height, People.none(COCO_17), estimate, Settings(method="torso")
    )


@pytest.fixture
def dropper() -> Iterator[Client]:
    store = DropStore(nobody)
    with served(Review(store, "ada")) as (origin, token):
        yield Client(origin, token)
    store.close()


def is_up(client: Client) -> bool:
    return client.http.get("/api/about").status_code == 200


# Who may ask


def test_without_the_token_nothing_is_told(client: Client) -> None:
    stranger = httpx.Client(base_url=client.origin)
    for path in ("/", "/api/about", "/api/photos/0/picture", "/static/main.js", "/?token=wrong", "/api/about?token=x"):
        answer = stranger.get(path)
        assert answer.status_code == 403 and "set-cookie" not in answer.headers
    stranger.cookies.set(next(iter(client.http.cookies)), "wrong")
    assert stranger.get("/api/about").status_code == 403


def test_the_token_becomes_a_cookie_that_scripts_and_other_sites_never_see(client: Client) -> None:
    answer = httpx.get(client.origin, params={"token": client.token})
    assert answer.status_code == 303 and answer.headers["location"] == "/"  # and leaves the address bar
    cookie = answer.headers["set-cookie"].lower()
    assert "httponly" in cookie and "samesite=strict" in cookie


def test_another_name_for_this_machine_is_refused(client: Client) -> None:
    """A name that an attacker turns to 127.0.0.1 (DNS rebinding) still says its own name as Host."""
    for host in ("evil.example", "evil.example:80", "127.0.0.1:1", ""):
        assert client.http.get("/api/about", headers={"Host": host}).status_code == 421


def test_other_pages_cannot_ask_through_the_browser(client: Client) -> None:
    body = {"action": "note", "value": {"text": "x"}}
    for headers in ({"Origin": "https://evil.example"}, {"Origin": "null"}, {"Sec-Fetch-Site": "cross-site"}):
        assert client.http.post("/api/photos/0/actions", json=body, headers=headers).status_code == 403
        assert client.http.get("/api/about", headers=headers).status_code == 403
    bare = httpx.Client(base_url=client.origin, cookies=dict(client.http.cookies))
    assert bare.post("/api/photos/0/actions", json=body).status_code == 403  # changing needs an Origin
    assert client.photo(0)["history"] == []


def test_every_answer_forbids_what_the_page_does_not_need(client: Client) -> None:
    for path in ("/", "/api/about", "/static/main.js", "/nothing", "/api/photos/0/picture"):
        headers = client.http.get(path).headers
        policy = headers["content-security-policy"]
        assert "default-src 'none'" in policy and "unsafe" not in policy and "http" not in policy
        assert headers["x-content-type-options"] == "nosniff" and headers["x-frame-options"] == "DENY"
        assert "access-control-allow-origin" not in headers


def test_no_path_leads_out_of_the_page(client: Client, tmp_path: Path) -> None:
    (tmp_path / "secret.txt").write_text("SECRET")
    cookie = "; ".join(f"{k}={v}" for k, v in client.http.cookies.items())
    host = client.origin.removeprefix("http://")
    for path in (
        "/static/../app.py", "/static/%2e%2e/app.py", "/static/..%2fapp.py", "/../../../../etc/passwd",
        "//etc/passwd", "/static//etc/passwd", "/api/photos/../../secret.txt/picture", "/static/\\..\\app.py",
        "/api/photos/-1", "/api/photos/99", "/api/photos/1e3", "/static/index.html%00.js",
    ):  # fmt: skip
        connection = http.client.HTTPConnection(host, timeout=20)
        connection.putrequest("GET", path, skip_host=True)
        connection.putheader("Host", host)
        connection.putheader("Cookie", cookie)
        connection.endheaders()
        answer = connection.getresponse()
        content = answer.read()
        assert answer.status in (400, 404) and b"root:" not in content and b"import" not in content, path
        connection.close()
    assert is_up(client)


# What may be sent


def test_a_gigabyte_is_refused_before_it_is_read(dropper: Client) -> None:
    host = dropper.origin.removeprefix("http://")
    cookie = "; ".join(f"{k}={v}" for k, v in dropper.http.cookies.items())
    connection = http.client.HTTPConnection(host, timeout=20)
    connection.putrequest("POST", "/api/drop?name=big.jpg")
    for name, value in (("Cookie", cookie), ("Origin", dropper.origin), ("Content-Length", str(2**30))):
        connection.putheader(name, value)
    connection.endheaders()
    assert connection.getresponse().status == 413
    connection.close()
    assert is_up(dropper)


def test_an_endless_upload_ends_at_the_limit(dropper: Client, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("proxemetry.web.app.MOST_UPLOAD_BYTES", 300_000)
    sent = 0

    def endless() -> Iterator[bytes]:  # chunked: no length is announced
        nonlocal sent
        while sent < 500_000_000:
            sent += 65_536
            yield b"\0" * 65_536

    with contextlib.suppress(httpx.TransportError):  # the server hangs up while we are still sending
        assert dropper.http.post("/api/drop?name=x", content=endless()).status_code == 413
    assert sent < 100_000_000
    assert is_up(dropper)


def claimed_png(width: int, height: int) -> bytes:
    """Return a PNG of a few bytes that claims to be huge."""

    def chunk(kind: bytes, content: bytes) -> bytes:
        return struct.pack(">I", len(content)) + kind + content + struct.pack(">I", zlib.crc32(kind + content))

    head = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    return PNG + chunk(b"IHDR", head) + chunk(b"IDAT", zlib.compress(b"\0" * 100)) + chunk(b"IEND", b"")


SVG = b'<svg xmlns="http://www.w3.org/2000/svg"><script>alert(1)</script></svg>'


@pytest.mark.parametrize(
    ("content", "name"),
    [
        (claimed_png(20_000, 10_000), "200-megapixels.png"), (SVG, "script.svg"), (SVG, "script.jpg"),
        (b"<html><script>alert(1)</script></html>", "page.jpg"), (b"", "empty.jpg"), (b"\xff\xd8\xff\xe0", "cut.jpg"),
        (b"%PDF-1.7 ...", "paper.pdf"),
    ],
)  # fmt: skip
def test_what_is_no_photo_is_one_clear_line(dropper: Client, content: bytes, name: str) -> None:
    answer = dropper.http.post("/api/drop", params={"name": name}, content=content)
    said = answer.json()["error"]
    assert answer.status_code == 422 and len(said.splitlines()) == 1
    assert said.startswith(f"{name}: ")  # not the file's name here, which its owner never saw
    assert dropper.http.get("/api/about").json()["photos"] == 0
    assert is_up(dropper)


def small_jpeg() -> bytes:
    buffer = io.BytesIO()
    exif = Image.Exif()
    exif[0x010E] = "SECRET-CAPTION"
    Image.new("RGB", (640, 480), (120, 130, 140)).save(buffer, "JPEG", exif=exif)
    return buffer.getvalue()


def test_a_dropped_photo_keeps_its_name_as_text_only(dropper: Client) -> None:
    name = '../../<img src=x onerror="alert(1)">.jpg'
    identity = dropper.http.post("/api/drop", params={"name": name}, content=small_jpeg()).json()["id"]
    answer = dropper.http.get(f"/api/photos/{identity}")
    assert answer.headers["content-type"] == "application/json"
    assert answer.json()["photo"] == '<img src=x onerror="alert(1)">.jpg'
    picture = dropper.http.get(f"/api/photos/{identity}/picture").content
    assert picture.startswith(b"\xff\xd8") and b"SECRET" not in picture and b"Exif" not in picture
    again = dropper.http.post("/api/drop", params={"name": name}, content=small_jpeg()).json()["id"]
    assert dropper.photo(again)["photo"].endswith("(2)")


def test_dropping_belongs_to_a_page_without_a_folder(client: Client) -> None:
    assert client.http.post("/api/drop", params={"name": "a.jpg"}, content=small_jpeg()).status_code == 409


@pytest.mark.parametrize(
    "body",
    [b"", b"{", b"[]", b'{"action": "note"}', b'{"action": "note", "value": 3}', b'{"action": "sing", "value": {}}',
     b'{"action": "undo", "value": {"number": 1}}', b'{"action": "set_camera", "value": {"focal_px": NaN}}',
     b'{"action": "remove_person", "value": {"box": [1]}}', b"\xff\xfe"],
)  # fmt: skip
def test_a_correction_that_cannot_be_read_is_refused(client: Client, body: bytes) -> None:
    answer = client.http.post("/api/photos/0/actions", content=body)
    assert answer.status_code == 400 and answer.json()["error"]
    assert client.http.post("/api/photos/0/actions", content=b" " * 70_000).status_code == 413
    assert client.photo(0)["history"] == []


def test_pictures_come_in_three_sizes_only(client: Client) -> None:
    assert client.http.get("/api/photos/0/picture?size=320").status_code == 200
    assert client.http.get("/api/photos/0/picture?size=100000").status_code == 400


# What the answers say


def test_the_gallery_filters_sorts_and_counts(client: Client) -> None:
    def names(**query: str) -> list[str]:
        return [p["photo"] for p in client.http.get("/api/photos", params=query).json()["photos"]]

    assert len(names()) == 6
    assert names(show="nobody") == ["market/empty.jpg"]
    assert names(show="failed") == ["park/broken.jpg"]
    assert names(show="camera") == ["park/assumed.jpg", "park/unknown.jpg"]
    assert names(group="market", text="TWO") == ["market/two.jpg"]
    assert names(sort="people")[0] == "market/crowd.jpg"
    assert names(sort="nearest")[:3] == sorted(
        ["market/crowd.jpg", "market/two.jpg", "park/assumed.jpg"],
        key=lambda n: client.photo(sorted(names()).index(n))["pairs"][0]["distance_m"],
    )
    spread = {
        n: max((p["high_m"] - p["low_m"]) / p["distance_m"] for p in client.photo(sorted(names()).index(n))["pairs"])
        for n in ("market/crowd.jpg", "market/two.jpg", "park/assumed.jpg")
    }
    assert names(sort="uncertain")[:3] == sorted(spread, key=lambda n: -spread[n])
    assert client.http.get("/api/photos", params={"show": "everything"}).status_code == 400
    about = client.http.get("/api/about").json()
    assert about["groups"] == ["market", "park"] and about["counts"]["pairs"] == 3


def test_a_correction_changes_the_numbers_at_once_and_stays(client: Client, results: Results) -> None:
    two = next(p["id"] for p in client.http.get("/api/photos").json()["photos"] if p["photo"] == "market/two.jpg")
    before = client.photo(two)
    assert before["pairs"][0]["distance_m"] == pytest.approx(1.5, abs=0.01)
    # half the focal length at the same pixels: everyone is half as deep, and as far apart sideways
    after = client.act(two, "set_camera", {"focal_px": 390}).json()
    assert after["people"][0]["ground"][1] == pytest.approx(before["people"][0]["ground"][1] / 2, rel=1e-2)
    client.act(two, "remove_person", {"box": before["people"][0]["box"]})
    assert client.photo(two)["pairs"] == []
    with served(Review(FolderStore(results.folder.location), "ben")) as (origin, token):  # started anew
        again = Client(origin, token)
        assert len(again.photo(two)["people"]) == 1 and len(again.photo(two)["history"]) == 2
        assert again.http.post(f"/api/photos/{two}/undo").status_code == 409  # not ben's to undo
    assert client.http.post(f"/api/photos/{two}/undo").json()["pairs"]
    assert client.http.post(f"/api/photos/{two}/undo").json()["camera"]["focal_px"] == 780


def test_export_writes_the_corrected_tables_and_the_log(client: Client, results: Results) -> None:
    root = Path(results.folder.location)
    crowd = client.photo(0)
    client.act(0, "remove_person", {"box": crowd["people"][0]["box"]})
    client.act(0, "note", {"text": 'a "quoted", müde note'})
    client.http.post("/api/photos/0/undo")
    assert "corrections.csv" in client.http.post("/api/export").json()["files"]
    with (root / "people.csv").open() as file:
        assert sum(row["photo"] == "market/crowd.jpg" for row in csv.DictReader(file)) == 5
    assert "müde" in (root / "corrections.csv").read_text(encoding="utf-8")  # read by people, not only by JSON
    with (root / "corrections.csv").open(encoding="utf-8") as file:
        log = list(csv.DictReader(file))
    assert [row["action"] for row in log] == ["remove_person", "note", "undo"]
    assert json.loads(log[1]["value"]) == {"text": 'a "quoted", müde note'} and log[0]["who"] == "ada"
    with (root / "codebook.csv").open() as file:
        assert [row["column"] for row in csv.DictReader(file) if row["table"] == "corrections"] == list(log[0])


def test_originals_are_never_written_to(client: Client, results: Results) -> None:
    photos = Path(results.folder.location).parent / "photos"
    before = {p: p.read_bytes() for p in photos.rglob("*.jpg")}
    client.act(0, "exclude", {"excluded": True, "reason": "a mirror"})
    client.http.post("/api/export")
    assert {p: p.read_bytes() for p in photos.rglob("*.jpg")} == before


def test_a_file_that_was_exchanged_is_not_shown_with_the_old_numbers(client: Client, results: Results) -> None:
    photo = Path(results.folder.location).parent / "photos" / "market" / "two.jpg"
    photo.write_bytes(small_jpeg())
    answer = client.http.get("/api/photos/2/picture")
    assert answer.status_code == 422 and "not the one that was measured" in answer.json()["error"]
    photo.unlink()
    assert client.http.get("/api/photos/2/picture").status_code == 422
    assert client.photo(2)["people"]


def test_blurred_pages_show_no_face_even_after_a_removal(results: Results) -> None:
    store = FolderStore(results.folder.location)
    shown, hidden = Review(store, "ada"), Review(store, "ada", faces="blur")
    box = hidden.view(2, Query())["people"][0]["box"]
    x, y, radius = hidden.view(2, Query())["people"][0]["head"]

    def face(review: Review) -> np.ndarray:
        pixels = np.asarray(Image.open(io.BytesIO(review.picture(2, 1600))), dtype=float)
        return pixels[int(y - radius / 2) : int(y + radius / 2), int(x - radius / 2) : int(x + radius / 2)]

    blurred = face(hidden)
    assert np.abs(face(shown) - blurred).mean() > 10
    hidden.act(2, "remove_person", {"box": box})
    assert np.abs(face(hidden) - blurred).mean() < 2  # what is left is JPEG's own noise
    hidden.act(2, "exclude", {"excluded": True})
    assert np.abs(face(hidden) - blurred).mean() < 2


def test_two_blind_reviewers_do_not_see_each_other_and_can_be_compared(results: Results) -> None:
    store = FolderStore(results.folder.location)
    ada, ben = (Review(store, who, blind=True) for who in ("ada", "ben"))
    box = ada.view(0, Query())["people"][5]["box"]
    ada.act(0, "remove_person", {"box": box})
    assert len(ben.view(0, Query())["people"]) == 6
    for review in (ada, ben):
        review.act(2, "set_camera", {"focal_px": 800})
        review.act(1, "checked", {})
    ben.act(0, "checked", {})
    late = Review(store, "ben", blind=True)
    assert late.page(Query(), 0)["photos"][0]["people"] == 6
    found = ada.agreement("ada", "ben")
    assert (found.n_photos, found.n_alike, found.n_both_changed, found.n_one_only, found.n_none) == (3, 2, 1, 1, 1)
    assert (found.n_people, found.n_people_one, found.n_people_other) == (7, 0, 1)
    assert found.n_pairs == 11 and found.mean_difference_m == pytest.approx(0, abs=1e-4)  # 10 of five people, 1 of two
    # observed 2/3, expected 2/3 * 1/3 + 1/3 * 2/3 = 4/9: kappa (2/3 - 4/9) / (5/9) = 0.4
    assert found.kappa == pytest.approx(0.4)
    with pytest.raises(SettingsError, match="ada, ben"):
        ada.agreement("ada", "eve")
    # The same files under other names, as after a rerun of an archive that was tidied up.
    root = Path(results.folder.location).parent / "again"
    shutil.copytree(Path(results.folder.location).parent / "photos", root / "photos" / "moved")
    renamed = [scene.renamed(f"moved/{scene.photo}") for scene in results.scenes(corrected=False)]
    write_results(root / "results", root / "photos", renamed)
    shutil.copy(results.folder.path(FILE), root / "results")
    assert Review(FolderStore(str(root / "results")), "ada").agreement("ada", "ben") == found


def test_two_reviewers_at_once_see_what_the_other_did(results: Results) -> None:
    ada, ben = (Review(FolderStore(results.folder.location), who) for who in ("ada", "ben"))
    query = Query()
    number = next(p["id"] for p in ada.page(query, 0)["photos"] if p["people"] >= 3)
    boxes = [person["box"] for person in ben.view(number, query)["people"]]
    ada.act(number, "remove_person", {"box": boxes[0]})
    assert len(ben.view(number, query)["people"]) == len(boxes) - 1
    ben.act(number, "remove_person", {"box": boxes[1]})
    for reviewer in (ada, ben):
        assert len(reviewer.view(number, query)["people"]) == len(boxes) - 2
    ada.undo(number)
    assert len(ben.view(number, query)["people"]) == len(boxes) - 1


def test_agreement_on_the_command_line(results: Results, capsys: pytest.CaptureFixture[str]) -> None:
    store = FolderStore(results.folder.location)
    for who in ("ada", "ben"):
        Review(store, who).act(1, "checked", {})
    assert main(["review", results.folder.location, "--agreement", "ada", "ben"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["n_photos"] == 1 and found["share_alike"] == 1 and found["mean_difference_m"] is None


def test_what_cannot_be_reviewed_is_one_clear_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for arguments in (
        ["review", str(tmp_path)], ["review", "s3://bucket/x"], ["review", "--agreement", "a", "b"],
        ["review", "--no-browser", "--port", "99999"],
    ):  # fmt: skip
        assert main(arguments) == 2
        assert len(capsys.readouterr().err.strip().splitlines()) == 1
    assert not (tmp_path / FILE).exists()


def test_photos_with_a_person_perhaps_twice_are_picked_out(tmp_path: Path) -> None:
    once, twice = "market/crowd.jpg", "market/two.jpg"
    places = {once: [(-1.0, 0.1, 5.0), (1.0, 0.1, 5.0)], twice: [(0.0, 0.1, 5.0), (0.02, 0.1, 5.0)]}
    scenes = []
    for name, people_m in places.items():
        draw_photo(tmp_path / "photos" / name, people_at(people_m, CAMERA))
        scenes.append(scene_of(tmp_path / "photos" / name, name, people_m))
    results = write_results(tmp_path / "results", tmp_path / "photos", scenes)
    found = cards(results)
    assert [(c.photo, c.duplicates) for c in found] == [(once, 0), (twice, 1)]
    assert [card_of(scene).duplicates for scene in results.scenes()] == [0, 1]
    review = Review(FolderStore(results.folder.location), "ada")
    assert [p["photo"] for p in review.page(Query(show="doubles"), 0)["photos"]] == [twice]
    assert totals(results.folder).duplicates == 1
