"""The whole review page in a real browser, outside hosts unresolvable: open, filter, correct, undo, reload, export."""

import csv
import io
import os
import zipfile
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from proxemetry.archive.run.run import run
from proxemetry.archive.store.results import Results
from proxemetry.photo import Photo
from proxemetry.photo.about import About
from proxemetry.web.measuring import Measuring
from proxemetry.web.session import Review
from proxemetry.web.stores import DropStore, FolderStore
from synthetic.drawn import people_at
from synthetic.reviewing import CAMERA, PHOTOS, draw_photo, make_results, scene_of, served, write_results
from synthetic.small_photos import write_photos

pytestmark = pytest.mark.browser

CHROMIUM = Path(os.environ.get("CHROMIUM", "/usr/bin/chromium"))
#: Where screenshots of every view are kept, for people to look at; none are kept where this is not set.
SCREENSHOTS = os.environ.get("SCREENSHOTS")


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    playwright = pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
    if not CHROMIUM.exists():
        pytest.skip(f"no Chromium at {CHROMIUM}: apt-get install chromium, or set CHROMIUM")
    with playwright.sync_playwright() as running:
        opened = running.chromium.launch(
            executable_path=str(CHROMIUM),
            args=["--no-sandbox", "--host-resolver-rules=MAP * ~NOTFOUND, EXCLUDE 127.0.0.1", "--disable-gpu"],
        )
        yield opened
        opened.close()


class Tab:
    """A browser tab that keeps account of what it asked and of everything that went wrong."""

    def __init__(self, browser: Any, origin: str) -> None:
        self.origin = origin
        self.context = browser.new_context(viewport={"width": 1440, "height": 860})
        self.page = self.context.new_page()
        self.outside: list[str] = []
        self.problems: list[str] = []
        self.page.set_default_timeout(60_000)  # a machine that does other things besides
        self.page.on("request", self._asked)
        self.page.on("pageerror", lambda error: self.problems.append(str(error)))
        self.page.on("console", lambda m: m.type == "error" and "422" not in m.text and self.problems.append(m.text))
        self.page.on("dialog", lambda dialog: (self.problems.append(f"dialog: {dialog.message}"), dialog.dismiss()))

    def _asked(self, request: Any) -> None:
        if not request.url.startswith((self.origin, "blob:", "data:")):
            self.outside.append(request.url)

    def shot(self, name: str) -> None:
        if SCREENSHOTS:
            Path(SCREENSHOTS).mkdir(parents=True, exist_ok=True)
            self.page.wait_for_timeout(300)
            self.page.screenshot(path=f"{SCREENSHOTS}/{name}.png")

    def open_photo(self, name: str) -> None:
        self.page.locator(f'.card a[title*="{name}"]').first.click()
        self.page.wait_for_selector(".photo h1")
        self.page.wait_for_selector(".joint")

    def first_distance(self) -> str:
        return self.page.locator("#tab-panel tbody tr").first.locator("td").first.inner_text()

    def says(self, selector: str, text: str) -> None:
        """Wait until an element shows a text: a busy machine draws it late."""
        self.page.locator(selector).filter(has_text=text).first.wait_for()

    def counts(self, selector: str, count: int) -> None:
        self.page.wait_for_function("([s, n]) => document.querySelectorAll(s).length === n", arg=[selector, count])

    @contextmanager
    def corrected(self) -> Iterator[None]:
        """Wait until what is done inside was answered and the photo is drawn anew."""
        self.page.evaluate("document.querySelectorAll('g.person').forEach(e => { e.dataset.before = '' })")
        with self.page.expect_response("**/actions*"):
            yield
        self.counts("g.person[data-before]", 0)

    def settled(self, text: str) -> None:
        self.page.wait_for_function("t => document.getElementById('status').textContent.includes(t)", arg=text)


@pytest.fixture
def results(tmp_path: Path) -> Results:
    return make_results(tmp_path)


@pytest.fixture
def tab(browser: Any, results: Results) -> Iterator[Tab]:
    with served(Review(FolderStore(results.folder.location), "ada")) as (origin, token):
        opened = Tab(browser, origin)
        opened.page.goto(f"{origin}/?token={token}")
        opened.page.wait_for_selector(".card")
        yield opened
        assert opened.outside == [] and opened.problems == []
        opened.context.close()


def test_the_whole_way(tab: Tab, results: Results) -> None:
    page = tab.page
    assert "token" not in page.url
    tab.counts(".card", 6)
    tab.shot("gallery")
    page.select_option("#show", "pairs")
    page.wait_for_function("() => document.querySelectorAll('.card').length === 3")
    page.select_option("#show", "all")
    page.wait_for_function("() => document.querySelectorAll('.card').length === 6")

    tab.open_photo("crowd")
    tab.counts("g.person", 6)
    tab.shot("photo")
    page.keyboard.press("0")
    page.keyboard.press("x")  # remove person 0
    tab.settled("removed")
    tab.counts("g.person", 5)
    page.keyboard.press("u")
    tab.settled("Undone")
    tab.counts("g.person", 6)

    page.keyboard.press("g")
    page.wait_for_selector(".card")
    tab.open_photo("two.jpg")
    assert tab.first_distance() == "1.5 m"
    page.keyboard.press("f")
    page.fill("#focal-focal_px", "390")
    tab.shot("focal")
    page.keyboard.press("Enter")
    tab.settled("Focal length set")
    changed = tab.first_distance()
    page.click("#tab-camera")
    tab.says("#tab-panel", "review")
    tab.shot("camera")
    page.click("#tab-history")
    tab.says("#tab-panel", "set the focal length")
    page.reload()
    page.wait_for_selector(".joint")
    assert tab.first_distance() == changed  # still there
    page.click("#export")
    tab.settled("corrections.csv")
    with (Path(results.folder.location) / "photos.csv").open() as file:
        row = next(r for r in csv.DictReader(file) if r["photo"] == "market/two.jpg")
    assert float(row["focal_px"]) == pytest.approx(390) and row["corrections"] == "1"


def test_dragging_a_joint_moves_the_person(tab: Tab) -> None:
    page = tab.page
    tab.open_photo("two.jpg")
    before = page.locator(".plan text").all_text_contents()
    for side in ("left_hip", "right_hip"):
        box = page.locator(f'.joint[data-person="0"][data-joint="{side}"]').bounding_box()
        x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
        page.mouse.move(x, y)
        page.mouse.down()
        page.mouse.move(x, y + 30, steps=4)
        page.mouse.move(x, y + 60, steps=4)
        with tab.corrected():
            page.mouse.up()
    assert page.locator(".plan text").all_text_contents() != before
    page.click("#tab-history")
    tab.counts("#tab-panel li", 2)
    tab.shot("history")


def test_a_missed_person_is_added_by_clicks(tab: Tab) -> None:
    page = tab.page
    tab.open_photo("two.jpg")
    page.keyboard.press("a")
    tab.shot("adding")
    canvas = page.locator(".canvas > svg").bounding_box()
    middle = canvas["x"] + canvas["width"] * 0.5
    for x, y in ((20, 0.42), (-20, 0.42), (12, 0.58), (-12, 0.58)):  # shoulders and hips
        page.mouse.click(middle + x, canvas["y"] + canvas["height"] * y)
    page.keyboard.press("Enter")
    tab.settled("Person added")
    tab.counts("g.person", 3)
    tab.counts("#tab-panel tbody tr", 3)


def test_hovering_lights_up_the_same_pair_everywhere(tab: Tab) -> None:
    page = tab.page
    tab.open_photo("crowd")
    row = page.locator("#tab-panel tr[data-pair]").last
    pair = row.get_attribute("data-pair")
    row.hover()
    tab.counts(f'.pairline[data-pair="{pair}"].lit', 1)
    assert page.locator(f'.plan [data-pair="{pair}"].lit').count() >= 1
    tab.counts("tr.lit", 1)
    tab.shot("linked")
    page.click("#tab-people")
    page.locator('#tab-panel tr[data-person="2"]').hover()
    tab.counts('g.person[data-person="2"].lit', 1)
    assert page.locator('.plan [data-person="2"].lit').count() >= 1


def test_every_action_has_a_key(tab: Tab) -> None:
    page = tab.page
    tab.open_photo("two.jpg")
    for keys in (("1", "b", "a"), ("o",)):
        for key in keys[:-1]:
            page.keyboard.press(key)
        with tab.corrected():
            page.keyboard.press(keys[-1])
    page.click("#tab-people")
    tab.says("#tab-panel", "adult, off the floor")
    page.keyboard.press("n")
    page.fill("#dialog-text", "<script>alert(1)</script>")
    page.locator("#dialog button.first").click()
    tab.settled("Note saved")
    page.keyboard.press("e")
    page.fill("#dialog-text", "a mirror")
    page.locator("#dialog button.first").click()
    tab.settled("Excluded")
    tab.says(".banner", "a mirror")
    tab.shot("excluded")
    page.keyboard.press("e")
    tab.settled("counts again")
    page.keyboard.press("?")
    tab.shot("keys")
    page.keyboard.press("Escape")
    page.keyboard.press("p")
    assert page.locator("#all").get_attribute("aria-pressed") == "true"


def test_the_keyboard_alone_walks_through_all_photos(tab: Tab) -> None:
    page = tab.page
    page.keyboard.press("Tab")  # the skip link
    page.keyboard.press("Tab")
    tab.open_photo("crowd")
    seen = []
    for _ in range(5):
        seen.append(page.locator(".photo h1").inner_text())
        page.keyboard.press("Enter")  # all right, next
        page.wait_for_function("t => document.querySelector('.photo h1')?.textContent !== t", arg=seen[-1])
    assert len(set(seen)) == 5
    page.keyboard.press("ArrowLeft")
    page.wait_for_function("t => document.querySelector('.photo h1').textContent === t", arg=seen[-1])
    page.keyboard.press("g")
    page.wait_for_selector(".card")
    tab.counts(".chip.done", 5)


def test_a_joint_is_moved_by_arrow_keys(tab: Tab) -> None:
    page = tab.page
    tab.open_photo("two.jpg")
    page.keyboard.press("0")
    page.keyboard.press(".")
    page.keyboard.press("Shift+ArrowDown")
    tab.says("main", "move it with the arrow keys")
    with tab.corrected():
        page.keyboard.press("Enter")
    page.click("#tab-history")
    tab.says("#tab-panel", "moved a joint")


UNNAMED = """() => {
  const controls = [...document.querySelectorAll('button, a[href], input, select, textarea, [role=button]')];
  const named = e => e.getAttribute('aria-label') || e.textContent.trim() || e.labels?.length;
  return controls.filter(e => e.offsetParent !== null && !named(e)).length; }"""


def test_every_control_has_a_name(tab: Tab) -> None:
    assert tab.page.evaluate(UNNAMED) == 0
    tab.open_photo("crowd")
    assert tab.page.evaluate(UNNAMED) == 0


CONTRAST = """() => {
  const parse = c => c.match(/[\\d.]+/g).map(Number);
  const light = ([r, g, b]) => { const f = v => (v /= 255) <= 0.04045 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4;
    return 0.2126 * f(r) + 0.7152 * f(g) + 0.0722 * f(b); };
  const ground = e => { for (; e; e = e.parentElement) { const c = parse(getComputedStyle(e).backgroundColor);
    if (c.length < 4 || c[3] > 0.9) return c; } return [255, 255, 255]; };
  const bad = [];
  for (const e of document.querySelectorAll('body *:not(svg *):not(dialog *)')) {
    const own = [...e.childNodes].some(n => n.nodeType === 3 && n.textContent.trim());
    if (!e.offsetParent || e.disabled || !own) continue;
    if (e.closest('#status, .skip')) continue;
    const [a, b] = [light(parse(getComputedStyle(e).color)), light(ground(e))].sort((x, y) => y - x);
    if ((a + 0.05) / (b + 0.05) < 4.5) bad.push(`${e.className || e.tagName}: ${e.textContent.slice(0, 30)}`);
  }
  return bad; }"""


def test_text_stands_out_as_wcag_aa_asks(tab: Tab) -> None:
    assert tab.page.evaluate(CONTRAST) == []
    tab.open_photo("crowd")
    for name in ("pairs", "people", "camera"):
        tab.page.click(f"#tab-{name}")
        assert tab.page.evaluate(CONTRAST) == []


def test_the_agreement_of_two_reviewers_is_shown(tab: Tab, results: Results) -> None:
    store = FolderStore(results.folder.location)
    for who in ("ada", "ben"):
        Review(store, who).act(0, "checked", {})
    tab.page.click("#nav-agreement")
    tab.page.locator("button", has_text="Compare").click()
    tab.page.wait_for_selector("#agreement")
    tab.says("#agreement", "1 (100.0 %)")
    tab.shot("agreement")


def test_one_dropped_photo_shows_its_distances(browser: Any, results: Results) -> None:
    photo = Path(results.folder.location).parent / "photos" / "market" / "two.jpg"

    def measured(opened: Photo) -> Any:

        return replace(scene_of(photo, "market/two.jpg"), photo=opened.name)

    store = DropStore(measured)
    with served(Review(store, "ada")) as (origin, token):
        tab = Tab(browser, origin)
        tab.page.goto(f"{origin}/?token={token}")
        tab.page.wait_for_selector(".drop")
        tab.shot("drop")
        tab.page.set_input_files("#file", str(photo))
        tab.page.wait_for_selector(".joint")
        assert tab.first_distance() == "1.5 m"
        tab.says(".photo h1", "two.jpg")
        assert tab.outside == [] and tab.problems == []
        tab.context.close()
    store.close()


def test_a_folder_is_measured_from_the_page_and_opens(
    browser: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    photos = write_photos(tmp_path / "photos", 4)
    pose = "python:synthetic.small_photos:two_people"
    monkeypatch.setattr(
        Measuring,
        "run",
        staticmethod(
            lambda paths, job, on_progress: run(paths, replace(job, pose=pose), jobs=0, on_progress=on_progress)
        ),
    )
    store = DropStore()
    with served(Review(store, "ada")) as (origin, token):
        tab = Tab(browser, origin)
        tab.page.goto(f"{origin}/?token={token}")
        tab.page.wait_for_function("() => document.getElementById('folder')?.value")  # the home folder is listed
        tab.page.fill("#folder", str(photos.parent))
        tab.page.get_by_role("button", name="Open").click()
        tab.page.locator(".folders button", has_text="photos").click()
        tab.page.wait_for_function("() => document.getElementById('folder').value.endsWith('photos')")
        tab.shot("folder")
        tab.page.fill("#focal", "35,5")
        tab.page.click("#measure")
        tab.page.wait_for_selector(".card")
        tab.counts(".card", 4)
        assert "photos proxemetry results" in tab.page.locator("#where").get_attribute("title")
        assert tab.outside == [] and tab.problems == []
        tab.context.close()
    assert (tmp_path / "photos proxemetry results" / "pairs.csv").exists()
    assert "35.5" in (tmp_path / "photos proxemetry results" / "run.json").read_text()


def test_script_in_file_names_is_shown_as_text(browser: Any, tmp_path: Path) -> None:

    name = '<img src=x onerror=alert(1)>&amp;"quoted".jpg'
    photos = tmp_path / "photos"
    draw_photo(photos / name, people_at(PHOTOS["market/two.jpg"][0], CAMERA))
    scene = replace(scene_of(photos / name, "market/two.jpg"), photo=name, about=About(city="<b>Oulu</b>"))
    results = write_results(tmp_path / "results", photos, [scene])
    with served(Review(FolderStore(results.folder.location), "<i>eve</i>")) as (origin, token):
        tab = Tab(browser, origin)
        tab.page.goto(f"{origin}/?token={token}")
        tab.page.wait_for_selector(".card")
        tab.says(".card .name", name)
        tab.page.locator(".card a").click()
        tab.page.wait_for_selector(".joint")
        tab.says(".photo h1", name)
        tab.page.click("#tab-camera")
        tab.says("#tab-panel", "<b>Oulu</b>")
        tab.says("#where", "<i>eve</i>")
        tab.counts("main img[src=x], main b, main i", 0)
        assert tab.outside == [] and tab.problems == []
        tab.context.close()


def actions_of(results: Results) -> list[tuple[str, dict[str, Any]]]:
    """Return the log of a results folder: photo and value of each correction."""
    return [(a.photo, dict(a.value)) for a in FolderStore(results.folder.location).log.actions()]


@pytest.mark.parametrize(("typed", "meant"), [("50,5", 50.5), ("50.5", 50.5), (" 35 ", 35.0)])
def test_a_focal_length_may_be_typed_with_comma_or_point(tab: Tab, results: Results, typed: str, meant: float) -> None:
    tab.open_photo("two.jpg")
    tab.page.keyboard.press("f")
    tab.page.fill("#focal-focal_35mm", typed)
    tab.page.keyboard.press("Enter")
    tab.settled("Focal length set")
    assert actions_of(results) == [("market/two.jpg", {"focal_35mm": meant})]


@pytest.mark.parametrize(
    ("typed", "told"),
    [
        ("0", "more than 0"),
        ("-5", "not a number"),
        ("1.000,5", "not a number"),
        ("fifty", "not a number"),
        ("", "Fill in one"),
    ],
)
def test_what_is_no_focal_length_is_told_and_not_kept(tab: Tab, results: Results, typed: str, told: str) -> None:
    tab.open_photo("two.jpg")
    tab.page.keyboard.press("f")
    tab.page.fill("#focal-focal_35mm", typed)
    tab.page.keyboard.press("Enter")
    tab.says("#dialog [role=alert]", told)
    tab.page.keyboard.press("Escape")
    assert actions_of(results) == []


def test_an_unusual_focal_length_is_asked_about_once(tab: Tab, results: Results) -> None:
    tab.open_photo("two.jpg")
    tab.page.keyboard.press("f")
    tab.page.fill("#focal-focal_35mm", "1200")
    tab.page.keyboard.press("Enter")
    tab.says("#dialog [role=alert]", "8 to 800 mm")
    assert actions_of(results) == []
    tab.shot("unusual")
    tab.page.keyboard.press("Enter")
    tab.settled("Focal length set")
    assert actions_of(results) == [("market/two.jpg", {"focal_35mm": 1200.0})]


@pytest.mark.parametrize(("key", "size", "name"), [("c", "children", "child"), ("a", "adults", "adult")])
def test_a_body_size_is_chosen_by_name_and_undone(tab: Tab, results: Results, key: str, size: str, name: str) -> None:
    page = tab.page
    tab.open_photo("two.jpg")
    page.keyboard.press("1")
    page.keyboard.press("b")
    tab.shot("size")
    page.keyboard.press(key)
    tab.settled(f"Person 1: {name}")
    assert actions_of(results)[0][1]["body_size"] == size
    page.click("#tab-people")
    tab.says("#tab-panel", name)
    page.keyboard.press("u")
    tab.settled("Undone")
    page.wait_for_function("n => !document.getElementById('tab-panel').textContent.includes(n)", arg=name)
    page.keyboard.press("b")
    page.keyboard.press("Escape")  # leaving the question changes nothing
    assert len(actions_of(results)) == 2


def test_a_focal_length_is_set_for_a_whole_folder_and_taken_back(tab: Tab, results: Results) -> None:
    page = tab.page
    tab.open_photo("two.jpg")
    page.keyboard.press("f")
    page.fill("#focal-focal_35mm", "28")
    page.check("#dialog input[value=folder]")
    tab.shot("scope")
    page.keyboard.press("Enter")
    tab.settled("Focal length set on 3 of 3 photos")
    told = page.locator(".banner")
    assert "set on 3 photos" in told.inner_text()
    assert {photo for photo, _ in actions_of(results)} == {"market/crowd.jpg", "market/empty.jpg", "market/two.jpg"}
    told.locator("button", has_text="Undo all").click()
    tab.settled("Undone on 3 of 3 photos")
    assert tab.first_distance() == "1.5 m"


def test_a_focal_length_is_set_for_the_photos_of_one_camera(tab: Tab, results: Results) -> None:
    page = tab.page
    tab.open_photo("assumed.jpg")
    page.keyboard.press("f")
    page.fill("#focal-focal_35mm", "28")
    page.check("#dialog input[value=camera]")
    page.keyboard.press("Enter")
    tab.settled("Focal length set on 2 of 2 photos")
    assert {photo for photo, _ in actions_of(results)} == {"park/assumed.jpg", "park/unknown.jpg"}


def test_only_accepted_photos_count_as_reviewed(tab: Tab) -> None:
    page = tab.page
    tab.open_photo("two.jpg")
    page.keyboard.press("n")
    page.fill("#dialog-text", "by the market")
    page.keyboard.press("Enter")
    tab.settled("Note saved")
    page.keyboard.press("g")
    page.wait_for_selector(".card")
    tab.says(".total", "0 of 6 reviewed")
    tab.open_photo("two.jpg")
    page.keyboard.press("Enter")
    page.wait_for_function("() => !document.querySelector('.photo h1')?.textContent.includes('two')")
    page.keyboard.press("g")
    page.wait_for_selector(".card")
    tab.says(".total", "1 of 6 reviewed")


def test_a_note_is_kept_without_stray_lines(tab: Tab, results: Results) -> None:
    tab.open_photo("two.jpg")
    tab.page.keyboard.press("n")
    tab.page.locator("#dialog-text").press_sequentially("  two women ")
    tab.page.keyboard.press("Shift+Enter")
    tab.page.locator("#dialog-text").press_sequentially("talk")
    tab.page.keyboard.press("Shift+Enter")
    tab.page.keyboard.press("Enter")
    tab.settled("Note saved")
    assert actions_of(results) == [("market/two.jpg", {"text": "two women \ntalk"})]


def test_no_button_moves_when_a_person_is_chosen(tab: Tab) -> None:
    page = tab.page
    tab.open_photo("crowd")
    where = (
        "() => [...document.querySelectorAll('.actions button')].map(b => JSON.stringify(b.getBoundingClientRect()))"
    )
    before = page.evaluate(where)
    page.keyboard.press("3")
    assert page.evaluate(where) == before
    bar = page.locator(".actions")
    assert bar.evaluate("e => e.scrollWidth <= e.clientWidth") and bar.bounding_box()["height"] < 50
    tab.shot("chosen")


@pytest.mark.parametrize("where", ["gallery", "photo", "agreement", "keys"])
def test_nothing_is_wider_than_a_phone(tab: Tab, where: str) -> None:
    page = tab.page
    page.set_viewport_size({"width": 390, "height": 844})
    if where == "photo":
        tab.open_photo("crowd")
    elif where == "agreement":
        page.click("#nav-agreement")
        page.wait_for_selector(".sheet")
    elif where == "keys":
        page.keyboard.press("?")
    widest = page.evaluate(
        "() => Math.max(document.documentElement.scrollWidth, document.querySelector('main').scrollWidth)"
    )
    tab.shot(f"phone-{where}")
    assert widest <= 390


def test_a_person_beyond_nine_is_chosen_by_two_digits(browser: Any, tmp_path: Path) -> None:
    many = [(-3.0 + 0.55 * k, 0.1, 6.0 + 0.4 * (k % 3)) for k in range(12)]
    draw_photo(tmp_path / "photos" / "market" / "two.jpg", people_at(many, CAMERA))
    scene = scene_of(tmp_path / "photos" / "market" / "two.jpg", "market/two.jpg", many)
    results = write_results(tmp_path / "results", tmp_path / "photos", [scene])
    with served(Review(FolderStore(results.folder.location), "ada")) as (origin, token):
        tab = Tab(browser, origin)
        tab.page.goto(f"{origin}/?token={token}")
        tab.open_photo("two.jpg")
        tab.page.keyboard.type("11")
        tab.says(".actions .who", "Person 11")
        tab.page.keyboard.press("u")  # not a digit: the next number begins anew
        tab.page.wait_for_timeout(800)
        tab.page.keyboard.type("2")
        tab.says(".actions .who", "Person 2")
        tab.context.close()


def test_every_dropped_photo_is_taken_and_exported(browser: Any, results: Results, tmp_path: Path) -> None:
    photos = Path(results.folder.location).parent / "photos"

    def measured(opened: Photo) -> Any:
        name = opened.name if opened.name.startswith("market") else f"market/{opened.name}"
        return replace(scene_of(photos / name, name), photo=opened.name)

    store = DropStore(measured)
    with served(Review(store, "ada")) as (origin, token):
        tab = Tab(browser, origin)
        tab.page.goto(f"{origin}/?token={token}")
        tab.page.wait_for_selector(".drop")
        (tmp_path / "letter.txt").write_text("not a photo")
        files = [photos / "market" / "two.jpg", photos / "market" / "crowd.jpg", tmp_path / "letter.txt"]
        tab.page.set_input_files("#file", [str(f) for f in files])
        tab.page.wait_for_selector(".card")
        tab.counts(".card", 2)
        assert "letter.txt" in tab.page.locator(".queue .problem").locator("..").inner_text()
        tab.shot("dropped")
        with tab.page.expect_download() as download:
            tab.page.click("#export")
        with zipfile.ZipFile(download.value.path()) as packed:
            assert sorted(packed.namelist()) == ["codebook.csv", "pairs.csv", "people.csv", "photos.csv"]
            rows = list(csv.DictReader(io.StringIO(packed.read("pairs.csv").decode())))
        assert len(rows) == 1 + 15 and {r["photo"] for r in rows} == {"two.jpg", "crowd.jpg"}
        tab.context.close()
    store.close()


def test_what_people_were_recorded_as_is_shown_and_pairs_are_picked_by_it(browser: Any, tmp_path: Path) -> None:
    photos = tmp_path / "photos"
    name = "market/crowd.jpg"
    people = people_at(PHOTOS[name][0], CAMERA)
    draw_photo(photos / name, people)
    scene = scene_of(photos / name, name)
    masks = ["no", "no", "yes", "no", "<b>maybe</b>", ""]
    worn = tuple({"mask": mask} if mask else {} for mask in masks)
    write_results(tmp_path / "out", photos, [replace(scene, people=replace(scene.people, attributes=worn))])
    with served(Review(FolderStore(str(tmp_path / "out")), "ada")) as (origin, token):
        tab = Tab(browser, origin)
        tab.page.goto(f"{origin}/?token={token}")
        tab.page.wait_for_selector(".card")
        tab.open_photo("crowd")
        tab.counts("#tab-panel tbody tr", 15)
        tab.page.select_option("#only", "mask=no")
        tab.counts("#tab-panel tbody tr", 3)  # of three people
        tab.says("#tab-panel", "3 of 15")
        tab.shot("attributes")
        tab.page.select_option("#only", "")
        tab.counts("#tab-panel tbody tr", 15)
        tab.page.click("#tab-people")
        tab.says('#tab-panel tr[data-person="4"]', "mask <b>maybe</b>")
        tab.shot("attributes-people")
        assert tab.outside == [] and tab.problems == []
        tab.context.close()
