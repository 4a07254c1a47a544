"""A camera calibrated on a picture in a real browser: click, type metres, see grid, horizon and misses, undo, save."""

import json
import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import httpx
import numpy as np
import pytest

from proxemetry.archive.store.results import Results
from proxemetry.camera import FloorFrame, Mount
from proxemetry.camera.floor_view import to_pixels
from proxemetry.errors import CameraError, SettingsError
from proxemetry.web.calibrating import Clicked, found, mount_of
from proxemetry.web.session import Review
from proxemetry.web.stores import DropStore, FolderStore
from synthetic.reviewing import CAMERA, make_results, served
from tests.test_review_page import CONTRAST, UNNAMED, Tab
from tests.test_review_page import browser as browser  # the fixture

#: Five spots of a floor that a camera at 4 m, looking 24 degrees down, shows; the user counts from a corner elsewhere.
FLOOR = ((-2.0, 6.0), (2.5, 6.5), (3.0, 12.0), (-3.0, 14.0), (0.0, 9.0))
TRUE = Mount.stated(math.radians(24), math.radians(1), 4.0, camera=CAMERA, floor_frame=FloorFrame(10.0, -3.0, 0.3))
PLACES = TRUE.floor_frame.to_user(np.array(FLOOR)) if TRUE.floor_frame else np.zeros((0, 2))
PIXELS = to_pixels(TRUE, FLOOR)


def _scene(results: Results, name: str = "market/two.jpg") -> Any:
    return next(iter(results.scenes([name])))


@pytest.fixture
def results(tmp_path: Path) -> Results:
    return make_results(tmp_path)


def _clicked(count: int = 5, **more: Any) -> Clicked:
    rows = np.column_stack([PIXELS, PLACES])[:count]
    return Clicked.parsed({"points": rows.tolist(), **more})


def test_points_give_the_camera_back_with_everything_to_draw(results: Results) -> None:
    scene = _scene(results)
    answer = found(scene, _clicked())
    mount = mount_of(scene, _clicked())
    assert answer["status"] == "found" and answer["mount"] == mount.to_dict()
    assert mount.height_m == pytest.approx(4.0, rel=1e-4) and math.degrees(mount.pitch_rad) == pytest.approx(
        24, abs=0.01
    )
    assert max(p["off_px"] for p in answer["points"]) < 0.1 and not any(p["wrong"] for p in answer["points"])
    np.testing.assert_allclose([p["seen"] for p in answer["points"]], PIXELS, atol=0.2)
    (_, left), (_, right) = answer["horizon"]
    assert (left + right) / 2 == pytest.approx(CAMERA.cy - CAMERA.fy * math.tan(math.radians(24)), abs=2)
    crossings = {(round(u), round(v)) for g in answer["grid"] for u, v in g["line"]}
    assert len(answer["grid"]) > 20 and any(g["tenth"] for g in answer["grid"])
    assert any(abs(u - PIXELS[4, 0]) < 60 and abs(v - PIXELS[4, 1]) < 60 for u, v in crossings)
    assert any(line.startswith("at 25 m  half a degree") for line in answer["lines"])
    json.dumps(answer, allow_nan=False)


def test_a_wrong_point_and_a_taped_line_are_told(results: Results) -> None:
    scene, rows = _scene(results), np.column_stack([PIXELS, PLACES])
    rows = np.vstack([rows, [*to_pixels(TRUE, [(1.0, 8.0)])[0], *TRUE.floor_frame.to_user(np.array([(1.0, 8.0)]))[0]]])  # type: ignore[union-attr]
    rows[5, 2] += 2.0
    line = [*PIXELS[0], *PIXELS[3], float(np.linalg.norm(PLACES[0] - PLACES[3]))]
    answer = found(scene, Clicked.parsed({"points": rows.tolist(), "lengths": [line]}))
    assert max(answer["points"], key=lambda p: p["off_px"]) is answer["points"][5] and "are off" in answer["notes"][0]
    assert answer["lengths"][0]["metres"] == pytest.approx(line[4]) and answer["lengths"][0]["comes_out_m"] is not None


def test_less_than_it_takes_is_waited_for_and_not_refused(results: Results) -> None:
    scene, unknown = _scene(results), _scene(results, "park/unknown.jpg")
    line = [*PIXELS[0], *PIXELS[3], 8.0]
    for fields, said in (
        ({}, "4 more points of the floor"),
        ({"points": np.column_stack([PIXELS, PLACES])[:3].tolist()}, "1 more point of the floor"),
        ({"lengths": [line]}, "or one more taped length"),
    ):
        answer = found(scene, Clicked.parsed(fields))
        assert answer["status"] == "waiting" and said in answer["text"]
    two = {"lengths": [line, [*PIXELS[0], *PIXELS[1], 4.53]]}
    assert "state the focal length" in found(unknown, Clicked.parsed(two))["text"]
    assert found(scene, Clicked.parsed(two))["status"] == "found"
    assert found(unknown, Clicked.parsed({**two, "lens": {"focal_px": 780}}))["status"] == "found"
    with pytest.raises(CameraError, match="no camera yet"):
        mount_of(scene, Clicked.parsed({}))


@pytest.mark.parametrize(
    "fields",
    [
        {"points": 3}, {"points": [[1, 2, 3]]}, {"points": [[1, 2, 3, "4"]]}, {"points": [[1, 2, 3, True]]},
        {"points": [[1, 2, 3, 1e300]]}, {"points": [[1, 2, 3, float("nan")]]}, {"lengths": [[1, 2, 3, 4]]},
        {"points": [[0, 0, 0, 0]] * 500}, {"lens": 3}, {"points": {}}, {"points": [None]},
    ],
)  # fmt: skip
def test_what_is_no_calibration_is_one_line(fields: Any) -> None:
    with pytest.raises((SettingsError, CameraError)) as caught:
        Clicked.parsed(fields)
    assert len(str(caught.value)) < 120


def test_cameras_are_written_into_the_folder_and_nowhere_else(results: Results) -> None:
    review = Review(FolderStore(results.folder.location), "ada")
    kept = review.save_camera(2, _clicked(), "yard-1.a")
    file = Path(results.folder.location) / "cameras" / "yard-1.a.json"
    assert kept["file"] == str(file) and str(file) in kept["measure"]
    assert Mount.read(file).height_m == pytest.approx(4.0, rel=1e-4)
    for name in ("../up", "a/b", "", ".hidden", "a" * 61, "a\\b", "ü", "a\0b", "-x"):
        with pytest.raises(SettingsError, match="is not a name for a camera"):
            review.save_camera(2, _clicked(), name)
    assert [p.name for p in file.parent.iterdir()] == [file.name]
    with pytest.raises(LookupError):
        review.calibrate(99, _clicked())
    store = DropStore()
    try:
        with pytest.raises(SettingsError, match="download the camera"):
            store.save_camera("camera.json", b"{}")
    finally:
        store.close()


def test_the_page_s_own_requests_alone_are_answered(results: Results) -> None:
    """Another site's page, or one without the token, neither learns a camera nor writes one."""
    body = {"points": np.column_stack([PIXELS, PLACES]).tolist()}
    with served(Review(FolderStore(results.folder.location), "ada")) as (origin, token), httpx.Client() as client:
        addresses = [f"{origin}/api/photos/2/calibration", f"{origin}/api/photos/2/calibration/camera"]
        for address in addresses:
            assert client.post(address, json=body, headers={"Origin": origin}).status_code == 403
        client.get(f"{origin}/?token={token}")
        for address in addresses:
            assert client.post(address, json=body).status_code == 403
            assert client.post(address, json=body, headers={"Origin": "http://evil.example"}).status_code == 403
            assert client.get(address).status_code == 405
            assert client.post(address, content=b"[1", headers={"Origin": origin}).status_code == 400
            assert client.post(address, json=[1], headers={"Origin": origin}).status_code == 400
            assert client.post(address, content=b" " * 70_000, headers={"Origin": origin}).status_code == 413
        assert not (Path(results.folder.location) / "cameras").exists()
        answers = [client.post(address, json=body, headers={"Origin": origin}) for address in addresses]
        assert [a.status_code for a in answers] == [200, 200] and answers[0].json()["status"] == "found"
        collinear = {"points": [[10 * k, 300, k, 0] for k in range(5)]}
        refused = client.post(addresses[0], json=collinear, headers={"Origin": origin})
        assert refused.json()["status"] == "problem" and "line" in refused.json()["text"]


@pytest.fixture
def tab(browser: Any, results: Results) -> Iterator[Tab]:
    with served(Review(FolderStore(results.folder.location), "ada")) as (origin, token):
        opened = Tab(browser, origin)
        opened.page.goto(f"{origin}/?token={token}")
        opened.open_photo("two.jpg")
        yield opened
        assert opened.outside == [] and opened.problems == []
        opened.context.close()


def _click(tab: Tab, pixel: Any) -> None:
    """Click a pixel of the full-size photo."""
    at = tab.page.evaluate(
        "([x, y]) => { const m = document.querySelector('.canvas > svg').getScreenCTM();"
        " const p = new DOMPoint(x, y).matrixTransform(m); return [p.x, p.y]; }", [float(v) for v in pixel],
    )  # fmt: skip
    tab.page.mouse.click(*at)


def _point(tab: Tab, k: int) -> None:
    """Click the k-th spot and type its metres, as one does: x, Enter, y, Enter."""
    _click(tab, PIXELS[k])
    tab.page.wait_for_selector(f"tr[data-mark='point-{k}'] input:focus")
    tab.page.keyboard.type(f"{PLACES[k, 0]:.3f}".replace(".", ","))
    tab.page.keyboard.press("Enter")
    tab.page.keyboard.type(f"{PLACES[k, 1]:.3f}")
    tab.page.keyboard.press("Enter")


@pytest.mark.browser
def test_a_camera_is_found_by_clicks_and_metres(tab: Tab, results: Results) -> None:
    page = tab.page
    page.click("#tab-camera")
    page.click("#calibrate")
    page.wait_for_selector(".calibrating")
    tab.says(".found", "4 more points of the floor")
    for k in range(4):
        _point(tab, k)
    tab.says(".found", "at 10 m  half a degree")
    tab.says(".found", "at 25 m  half a degree")
    assert page.locator("path.floor.fine").get_attribute("d") and page.locator("line.floor.horizon").count() == 1
    height = float(page.locator(".found p").first.inner_text().split()[1])
    assert height == pytest.approx(4.0, abs=0.15)
    tab.shot("calibrate")
    _point(tab, 4)
    page.wait_for_function("() => document.querySelector(\"tr[data-mark='point-4'] .miss\").textContent.includes('px')")
    # a point that was typed wrongly shows itself
    field = page.locator("tr[data-mark='point-4'] input").first
    field.fill(f"{PLACES[4, 0] + 3:.2f}")
    field.press("Enter")
    tab.says(".miss", "check it")
    tab.shot("calibrate-wrong")
    page.locator("#undo").click()
    page.wait_for_function("() => !document.querySelector('.panel').textContent.includes('check it')")
    # by keyboard: remove, undo, and a cross hair that Space clicks
    page.keyboard.press("Escape")
    page.keyboard.press("5")
    page.keyboard.press("Delete")
    tab.counts("g.mark", 4)
    page.keyboard.press("u")
    tab.counts("g.mark", 5)
    page.keyboard.press("ArrowDown")
    page.keyboard.press("Space")
    tab.counts("g.mark", 6)
    page.keyboard.press("Escape")
    page.keyboard.press("u")
    tab.counts("g.mark", 5)
    page.keyboard.press("1")
    page.keyboard.press("Shift+ArrowLeft")
    tab.says("tr[data-mark='point-0'] .miss", "px")
    page.keyboard.press("u")
    page.keyboard.press("Escape")
    # a taped line
    page.keyboard.press("l")
    _click(tab, PIXELS[0])
    tab.says(".banner", "other end")
    _click(tab, PIXELS[3])
    page.keyboard.type(f"{np.linalg.norm(PLACES[0] - PLACES[3]):.2f}")
    page.keyboard.press("Enter")
    tab.says("tr[data-mark='length-0'] .miss", "m")
    # it survives a reload
    page.reload()
    page.wait_for_selector("g.mark")
    tab.counts("g.mark", 7)  # five points and a line's two ends
    tab.says(".found", "at 25 m")
    assert page.evaluate(UNNAMED) == 0 and page.evaluate(CONTRAST) == []
    with page.expect_download() as download:
        page.click("#download-camera")
    assert download.value.suggested_filename == "camera.json"
    assert Mount.read(download.value.path()).height_m == pytest.approx(4.0, abs=0.15)
    page.fill("#camera-name", "../../x")
    page.click("#save-camera")
    tab.settled("A name may have letters")
    page.fill("#camera-name", "yard")
    page.click("#save-camera")
    tab.settled("Saved as")
    mount = Mount.read(Path(results.folder.location) / "cameras" / "yard.json")
    assert mount.height_m == pytest.approx(4.0, abs=0.15) and math.degrees(mount.pitch_rad) == pytest.approx(
        24, abs=1.0
    )


@pytest.mark.browser
def test_dragging_a_mark_moves_it_and_refusals_are_told(tab: Tab) -> None:
    page = tab.page
    page.keyboard.press("c")
    page.wait_for_selector(".calibrating")
    for k, x in enumerate((100, 300, 500, 700)):  # all on one line of the picture and of the floor
        _click(tab, (x, 400))
        page.keyboard.type(str(k))
        page.keyboard.press("Enter")
        page.keyboard.type("0")
        page.keyboard.press("Enter")
    tab.says(".found .problem", "line")
    page.locator("tr[data-mark='point-3'] input").first.fill("twelve")
    page.keyboard.press("Tab")
    tab.settled("is no number of metres")
    mark = page.locator("g.mark").first.bounding_box()
    page.mouse.move(mark["x"] + mark["width"] / 2, mark["y"] + mark["height"] / 2)
    page.mouse.down()
    page.mouse.move(mark["x"] + 60, mark["y"] + 80, steps=4)
    page.mouse.up()
    page.wait_for_function(
        "x => Math.abs(document.querySelector('g.mark').getBoundingClientRect().x - x) > 20", arg=mark["x"]
    )
    tab.counts("g.mark", 4)


@pytest.mark.browser
def test_calibrating_fits_a_phone(tab: Tab) -> None:
    page = tab.page
    page.keyboard.press("c")
    page.wait_for_selector(".calibrating")
    for k in range(4):
        _point(tab, k)
    tab.says(".found", "at 25 m")
    page.set_viewport_size({"width": 390, "height": 844})
    widest = page.evaluate(
        "() => Math.max(document.documentElement.scrollWidth, document.querySelector('main').scrollWidth)"
    )
    tab.shot("phone-calibrate")
    assert widest <= 390
