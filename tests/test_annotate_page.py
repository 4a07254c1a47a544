"""The whole way of annotating in a real browser: points, names, tapes, check and score; by mouse, keys and finger."""

from collections.abc import Iterator
from functools import partial
from pathlib import Path
from typing import Any

import httpx
import pytest

from proxemetry.annotate.project import Project
from proxemetry.annotate.scoring import score_own_run
from proxemetry.benchmark import read_labels
from proxemetry.benchmark.validate_labels import check_labels
from proxemetry.web import annotate_app
from proxemetry.web.annotate_app import create_annotate_app
from synthetic.reviewing import CAMERA, HEIGHT, WIDTH, serving
from tests.test_annotate_project import POSE, TWO, draw_photo, people_at
from tests.test_review_page import CONTRAST, UNNAMED, Tab
from tests.test_review_page import browser as browser  # the fixture

pytestmark = pytest.mark.browser


@pytest.fixture
def project(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Project]:
    monkeypatch.setattr(annotate_app, "score_own_run", partial(score_own_run, jobs=0))  # no processes of its own
    for k, name in enumerate(("a.jpg", "b.jpg")):
        draw_photo(tmp_path / "photos" / name, people_at([*TWO, (0.3 * k, 0.0, 9.0)], CAMERA))
    opened = Project([str(tmp_path / "photos")], str(tmp_path / "labels"), pose=POSE)
    yield opened
    opened.close()


@pytest.fixture
def tab(browser: Any, project: Project) -> Iterator[Tab]:
    with serving(partial(create_annotate_app, project)) as (origin, token):
        opened = Tab(browser, origin)
        opened.page.goto(f"{origin}/?token={token}")
        opened.page.wait_for_selector(".card")
        yield opened
        assert opened.outside == [] and opened.problems == []
        opened.context.close()


def open_photo(tab: Tab, number: int = 0) -> None:
    tab.page.evaluate(f"location.hash = '#/photo/{number}'")
    tab.page.wait_for_function(
        "n => document.querySelector('.stage .place')?.textContent.startsWith(n)", arg=f"{number + 1} of"
    )
    tab.page.wait_for_selector("g.point")


def kept(tab: Tab, press: str) -> None:
    """Press a key and wait until what it does is kept."""
    with tab.page.expect_response("**/api/actions"):
        tab.page.keyboard.press(press)
    tab.page.wait_for_timeout(60)


def middle_of(tab: Tab, key: int, part: str) -> tuple[float, float]:
    box = tab.page.locator(f'g.point[data-key="{key}"][data-part="{part}"] .reach').bounding_box()
    return box["x"] + box["width"] / 2, box["y"] + box["height"] / 2


def add_tape(tab: Tab, a: str, b: str, metres: str) -> None:
    page = tab.page
    page.fill("#from", a)
    page.fill("#to", b)
    page.fill("#length", metres)
    page.keyboard.press("Enter")
    page.wait_for_selector(f'tr[data-tape="{a}-{b}"]')


def test_the_whole_way(tab: Tab, project: Project) -> None:
    page = tab.page
    assert "token" not in page.url and page.locator(".card").count() == 2
    tab.shot("annotate-photos")
    page.locator(".card a").first.click()
    page.wait_for_selector("g.point")  # proposed by the back end
    assert page.locator("g.body").count() == 2 and "no name yet" in page.locator(".banner").inner_text()

    page.locator("g.badge").first.click()
    kept(tab, "0")
    page.keyboard.press("]")
    kept(tab, "1")
    assert [p.tag for p in project.notes(0).people] == ["P0", "P1"]
    tab.shot("annotate-photo")

    before = project.notes(0).person(0).points["Torso"]
    page.keyboard.press("[")
    x, y = middle_of(tab, 0, "Torso")
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x + 10, y + 20, steps=3)
    with page.expect_response("**/api/actions"):
        page.mouse.up()
    page.wait_for_timeout(60)
    moved = project.notes(0).person(0).points["Torso"]
    assert moved[0] > before[0] and moved[1] > before[1]

    kept_at = project.notes(0)
    page.click("#undo")
    tab.settled("Undone: Torso set in a.jpg")
    assert project.notes(0).person(0).points["Torso"] == before
    page.keyboard.press("y")
    tab.settled("Done again")
    assert project.notes(0) == kept_at

    page.keyboard.press("c")
    page.fill("#dialog-focal_35mm", f"{CAMERA.f_px * 43.2666 / (WIDTH**2 + HEIGHT**2) ** 0.5:.2f}".replace(".", ","))
    page.check("#dialog input[value=all]")
    tab.shot("annotate-lens")
    page.keyboard.press("Enter")
    tab.settled("Lens stated")

    page.keyboard.press("Enter")  # done, next
    page.wait_for_function("() => document.querySelector('.stage .place').textContent.startsWith('2 of')")
    page.wait_for_function("() => document.querySelectorAll('g.body').length === 2")
    kept(tab, "m")  # names as on the photo before
    assert [p.tag for p in project.notes(1).people] == ["P0", "P1"]
    page.keyboard.press("Enter")
    tab.settled("last photo")

    page.click("#nav-places")
    page.wait_for_selector("#from")
    assert page.locator(".remarks .problem").count() == 3  # nothing was measured yet
    add_tape(tab, "C0", "P0", "5,056")
    add_tape(tab, "C0", "P1", "5.056")
    add_tape(tab, "P0", "P1", "1,5")
    assert page.locator(".distances tbody tr").inner_text().split("\t")[1] == "1.50"
    assert page.locator(".remarks .problem").count() == 0
    tab.shot("annotate-places")

    page.click("#nav-score")
    page.wait_for_selector(".verdict.good")
    assert check_labels(project.out) == []
    page.click("#run")
    page.wait_for_selector('table[data-protocol="seker2021"]')
    for protocol in ("v1", "seker2021"):
        cells = page.locator(f'table[data-protocol="{protocol}"] tbody tr').last.inner_text()
        assert "1.70 m for every pair" in cells and "13.3" in cells  # |1.7 - 1.5| / 1.5
    combined = page.locator('table[data-protocol="v1"] tbody tr', has_text="combined").inner_text().split("\t")
    assert combined[1] == "2 of 2" and float(combined[2]) < 10
    tab.shot("annotate-score")
    labels = read_labels(project.out)
    assert labels.by_name["a.jpg"].parts_px[0, 2].tolist() == list(moved)
    assert labels.by_name["b.jpg"].distances_mm(ground=True)[0, 1] == pytest.approx(1500, abs=1)


def test_a_person_is_added_by_four_clicks_and_what_is_not_seen_is_skipped(tab: Tab, project: Project) -> None:
    page = tab.page
    open_photo(tab)
    page.keyboard.press("a")
    assert "the middle of the eyes" in page.locator(".banner").inner_text()
    canvas = page.locator(".canvas > svg").bounding_box()
    at = lambda dy: (canvas["x"] + canvas["width"] * 0.5, canvas["y"] + canvas["height"] * (0.4 + dy))  # noqa: E731
    page.keyboard.press("v")  # no eyes to be seen
    assert "the middle of the shoulders" in page.locator(".banner").inner_text()
    assert "one shoulder" in page.locator(".rules").inner_text()  # the rule stands beside
    tab.shot("annotate-adding")
    for dy in (0.0, 0.08, -0.05):  # shoulders, torso, head, as fast as one clicks
        page.mouse.click(*at(dy))
    page.wait_for_function("() => document.querySelectorAll('.who li').length === 3")
    page.wait_for_function("() => document.querySelectorAll('.who li.chosen .part.set').length === 3")
    person = project.notes(0).people[-1]
    assert set(person.points) == {"Shoulder", "Torso", "Head"}
    assert person.points["Head"][1] < person.points["Shoulder"][1] < person.points["Torso"][1]
    kept(tab, "x")
    assert len(project.notes(0).people) == 2


def test_the_keyboard_alone_places_moves_and_hides_points(tab: Tab, project: Project) -> None:
    page = tab.page
    open_photo(tab)
    page.keyboard.press("]")
    page.keyboard.press("t")
    x, y = project.notes(0).person(0).points["Torso"]
    step = max(1, round(page.evaluate(f"{WIDTH} / document.querySelector('.canvas > svg').clientWidth")))
    page.keyboard.press("ArrowRight")
    kept(tab, "Shift+ArrowDown")  # kept once the keys rest
    assert project.notes(0).person(0).points["Torso"] == (x + step, y + 10 * step)
    kept(tab, "Delete")
    assert "Torso" not in project.notes(0).person(0).points
    page.keyboard.press("t")  # not set: the next Space places it, where the cross was moved
    page.keyboard.press("Enter")
    tab.settled("move the cross")
    assert "Torso" not in project.notes(0).person(0).points
    page.keyboard.press("ArrowDown")
    kept(tab, " ")
    assert "Torso" in project.notes(0).person(0).points
    page.keyboard.press("Escape")
    page.keyboard.press("Escape")
    assert page.locator(".who li.chosen").count() == 0
    page.keyboard.press("z")  # nobody chosen: nothing happens
    page.keyboard.press("]")
    page.keyboard.press("z")
    assert page.evaluate("document.querySelector('.canvas > svg').viewBox.baseVal.width") < WIDTH / 2


def test_names_typed_fast_go_to_whom_they_were_meant_for(tab: Tab, project: Project) -> None:
    page = tab.page
    open_photo(tab)
    for key in ("]", "4", "]", "1", "2"):
        page.keyboard.press(key)
    page.wait_for_function(
        "() => [...document.querySelectorAll('.who .tag')].map(b => b.textContent).join() === 'P4,P12'"
    )
    assert {p.key: p.tag for p in project.notes(0).people} == {0: "P4", 1: "P12"}


def test_people_shoots_and_cameras_have_names(tab: Tab, project: Project) -> None:
    page = tab.page
    open_photo(tab)
    page.keyboard.press("]")
    page.keyboard.press("n")
    page.fill("#dialog-tag", "p3")
    page.fill("#dialog-name", "<b>Anna</b>")
    tab.shot("annotate-name")
    page.keyboard.press("Enter")
    page.wait_for_function("() => document.querySelector('.who').textContent.includes('P3 <b>Anna</b>')")
    page.keyboard.press("o")
    page.fill("#dialog-shoot", "1")
    page.fill("#dialog-shootName", "terrace")
    page.fill("#dialog-camera", "2")
    page.fill("#dialog-cameraName", "by the door")
    page.check("#dialog input[value=all]")
    page.keyboard.press("Enter")
    page.wait_for_function("() => document.querySelector('.side').textContent.includes('C2: by the door')")
    assert [project.notes(k).camera for k in range(2)] == ["C2", "C2"]
    assert project.now.shoot(1).name == "terrace" and project.now.names == {"P3": "<b>Anna</b>"}
    assert page.locator("main b").count() == 0
    page.keyboard.press("l")
    page.wait_for_selector(".marks")
    assert page.locator('tr[data-tag="P3"] input.label').input_value() == "<b>Anna</b>"


def test_what_tapes_cannot_tell_and_what_contradicts_is_said(tab: Tab, project: Project) -> None:
    page = tab.page
    page.click("#nav-places")
    page.wait_for_selector("#from")
    square = {"P0": (0, 0), "P1": (2, 0), "P2": (2, 2), "P3": (0, 2), "P4": (4.5, 1.2)}
    pairs = [("P0", "P1"), ("P1", "P2"), ("P2", "P3"), ("P0", "P3"), ("P0", "P2")]
    length = lambda a, b: sum((p - q) ** 2 for p, q in zip(square[a], square[b], strict=True)) ** 0.5  # noqa: E731
    for a, b in pairs:
        add_tape(tab, a, b, f"{length(a, b):.3f}")
    assert "mirror images" in page.locator(".remarks .problem").inner_text()
    add_tape(tab, "P1", "P3", f"{length('P1', 'P3'):.3f}")
    assert page.locator(".remarks .problem").count() == 0
    for other in ("P0", "P1", "P2"):
        add_tape(tab, other, "P4", f"{length(other, 'P4'):.3f}")
    add_tape(tab, "P3", "P4", "5,07")  # for 4.57
    told = page.locator(".remarks .problem").inner_text()
    assert "P3–P4 (5.07 m; the others say 4.57)" in told and page.locator("tr.suspect").count() == 1
    tab.shot("annotate-contradiction")
    page.click("#nav-score")
    page.wait_for_selector(".remarks .problem")
    assert "contradicts all others" in page.locator(".remarks").inner_text()
    page.click("#nav-places")
    page.wait_for_selector("tr.suspect")
    page.fill('[data-control="P3P4"]', "4,570")
    page.keyboard.press("Tab")
    page.wait_for_function("() => !document.querySelector('tr.suspect')")
    for text, what in (("abc", "no number of metres"), ("-2", "no number of metres"), ("5000", "0.01 to 1000 metres")):
        page.fill("#from", "P0")
        page.fill("#to", "P9")
        page.fill("#length", text)
        page.keyboard.press("Enter")
        tab.settled(what)
    page.fill("#from", "X1")
    page.fill("#length", "2")
    page.locator("#length").press("Enter")
    tab.settled("A mark is P or C")
    tab.problems.clear()  # the browser logs the refused one
    assert len(project.now.shoot(0).tapes) == 10


def test_coordinates_are_typed_in_pairs_with_comma_or_point(tab: Tab, project: Project) -> None:
    page = tab.page
    project.propose(0)
    for key, tag in ((0, "P0"), (1, "P1")):
        project.act(0, "name_person", {"person": key, "tag": tag})
    page.click("#nav-places")
    page.wait_for_selector('[data-control="P0x"]')
    for tag, (x, y) in {"P0": ("-1,2", "1.2"), "P1": ("0", "2,4"), "C0": ("0", "0")}.items():
        page.fill(f'[data-control="{tag}x"]', x)
        page.keyboard.press("Tab")
        page.keyboard.type(y)
        with page.expect_response("**/api/actions"):
            page.keyboard.press("Tab")
        page.wait_for_timeout(150)
    assert project.places(0).by_tag["P0"] == pytest.approx((-1.2, 1.2))
    assert page.locator(".distances tbody tr").inner_text().split("\t")[1] == "1.70"
    page.click("#undo")
    tab.settled("Undone: coordinates of C0")
    assert page.locator(".distances tbody tr").count() == 1
    page.keyboard.press("y")
    tab.settled("Done again")
    assert project.places(0).by_tag["C0"] == pytest.approx((0, 0))


def test_an_unusual_lens_is_asked_about_and_no_number_is_told(tab: Tab, project: Project) -> None:
    page = tab.page
    open_photo(tab)
    page.keyboard.press("c")
    page.fill("#dialog-focal_35mm", "1200")
    page.keyboard.press("Enter")
    assert "8 to 800 mm" in page.locator("#dialog [role=alert]").inner_text() and project.notes(0).lens is None
    page.fill("#dialog-focal_35mm", "fifty")
    page.keyboard.press("Enter")
    assert "not a number" in page.locator("#dialog [role=alert]").inner_text()
    page.keyboard.press("Escape")


def test_what_is_missing_is_told_before_the_score(tab: Tab, project: Project) -> None:
    page = tab.page
    open_photo(tab)
    page.keyboard.press("]")
    kept(tab, "7")
    page.click("#nav-score")
    page.wait_for_selector(".verdict.problem")
    assert "shoot 0 has no P7" in page.locator(".faults").inner_text()
    page.click("#run")
    page.wait_for_function("() => document.querySelector('#main').textContent.includes('has no P7, who is')")
    page.evaluate("location.hash = '#/photo/0'")
    page.wait_for_selector("g.point")
    kept(tab, "i")
    page.click("#nav-score")
    page.wait_for_selector(".verdict")
    assert "P7" not in page.locator("main").inner_text()


def test_all_is_there_after_a_reload(tab: Tab, project: Project) -> None:
    open_photo(tab)
    tab.page.keyboard.press("]")
    kept(tab, "5")
    tab.page.reload()
    tab.page.wait_for_selector("g.point")
    assert "P5" in tab.page.locator(".who").inner_text()
    assert tab.page.locator("#undo").is_enabled()


@pytest.mark.parametrize("where", ["", "photo/0", "places/0", "score"])
def test_every_view_fits_a_phone_names_its_controls_and_stands_out(tab: Tab, where: str) -> None:
    page = tab.page
    page.set_viewport_size({"width": 390, "height": 844})
    page.evaluate(f"location.hash = '#/{where}'")
    page.wait_for_selector({"": ".card", "photo/0": "g.point", "places/0": "#from", "score": ".verdict"}[where])
    page.wait_for_timeout(200)
    widest = "() => Math.max(document.documentElement.scrollWidth, document.querySelector('main').scrollWidth)"
    tab.shot(f"annotate-phone-{where.split('/')[0] or 'photos'}")
    assert page.evaluate(widest) <= 390
    assert page.evaluate(UNNAMED) == 0 and page.evaluate(CONTRAST) == []
    page.keyboard.press("?")
    assert page.evaluate(widest) <= 390


def test_a_finger_places_points(browser: Any, project: Project) -> None:
    with serving(partial(create_annotate_app, project)) as (origin, token):
        context = browser.new_context(viewport={"width": 390, "height": 844}, has_touch=True, is_mobile=True)
        page = context.new_page()
        page.goto(f"{origin}/?token={token}")
        page.wait_for_selector(".card")
        page.evaluate("location.hash = '#/photo/0'")
        page.wait_for_selector("g.point")
        page.locator(".who .part").nth(2).tap()  # torso of the first: set; again to place it anew
        page.locator(".who .part").nth(2).tap()
        page.wait_for_selector(".canvas.armed")
        box = page.locator(".canvas > svg").bounding_box()
        with page.expect_response("**/api/actions"):
            page.touchscreen.tap(box["x"] + box["width"] * 0.5, box["y"] + box["height"] * 0.5)
        page.wait_for_timeout(100)
        x, _ = project.notes(0).person(0).points["Torso"]
        assert x == pytest.approx(WIDTH / 2, abs=5)
        context.close()


# The server


@pytest.fixture
def client(project: Project) -> Iterator[httpx.Client]:
    with serving(partial(create_annotate_app, project)) as (origin, token):
        asking = httpx.Client(base_url=origin, headers={"Origin": origin}, timeout=60)
        asking.get("/", params={"token": token}, follow_redirects=True).raise_for_status()
        yield asking


def test_strangers_are_told_nothing(client: httpx.Client) -> None:
    stranger = httpx.Client(base_url=client.base_url)
    for path in ("/", "/api/about", "/api/photos/0/picture", "/static/annotate_main.js", "/?token=wrong"):
        assert stranger.get(path).status_code == 403
    assert client.post("/api/undo", headers={"Origin": "http://evil.example"}).status_code == 403
    assert client.get("/api/about", headers={"Host": "evil.example"}).status_code == 421
    assert client.get("/static/index.html").status_code == 404
    assert "default-src 'none'" in client.get("/").headers["content-security-policy"]


@pytest.mark.parametrize(
    ("body", "status"),
    [
        ("{", 400), ("[]", 400), ('{"value": 3}', 400),
        ('{"photo": 99, "action": "finish", "value": {"done": true}}', 404),
        ('{"photo": -1, "action": "finish", "value": {"done": true}}', 404),
        ('{"photo": "0", "action": "finish", "value": {"done": true}}', 400),
        ('{"photo": 0, "action": "add_person", "value": {"points": {"Head": [NaN, 1]}}}', 400),
        ('{"photo": 0, "action": "add_person", "value": {"points": {"Head": [1e999, 1]}}}', 400),
        ('{"photo": null, "action": "name_tag", "value": {"tag": "P0", "name": "\\ud800"}}', 400),
        ('{"photo": null, "action": "set_tape", "value": {"shoot": 0, "a": "P0", "b": "../x", "metres": 1}}', 400),
        ('{"photo": null, "action": "finish", "value": {"done": true}}', 400),
        ('{"photo": 0, "action": "add_person", "value": {"points": {"Head": [0, 1' + "0" * 400 + "]}}}", 400),
        ('{"photo": 0, "action": "set_lens", "value": {"scope": ["all"], "lens": null}}', 400),
        ('{"photo": 0, "action": "undo", "value": {}}', 400),
        ('{"photo": 0, "action": "finish", "value": ' + "[" * 9000 + "}", 400),
        ("x" * 70_000, 413),
    ],
)  # fmt: skip
def test_hostile_requests_get_one_line(client: httpx.Client, project: Project, body: str, status: int) -> None:
    answer = client.post("/api/actions", content=body)
    assert answer.status_code == status and "\n" not in answer.json()["error"]
    assert client.get("/api/about").status_code == 200 and project.history.undoable is None


def test_addresses_of_what_is_not_there(client: httpx.Client) -> None:
    assert client.get("/api/photos/77").status_code == 404
    assert client.get("/api/photos/0/picture", params={"size": 99999}).status_code == 400
    assert client.post("/api/undo").status_code == 409
    assert client.get("/api/places/3").status_code == 200  # a shoot of which nothing is known yet


def test_pictures_hold_no_metadata(client: httpx.Client) -> None:
    content = client.get("/api/photos/0/picture", params={"size": 320}).content
    assert content.startswith(b"\xff\xd8") and b"SECRET-CAPTION" not in content and b"Exif" not in content
