"""The report: its numbers are those of the tables, and the page needs nothing but itself."""

import csv
import os
import re
import shutil
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from urllib.parse import unquote

import duckdb
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from proxemetry.archive.figures.overlays import draw
from proxemetry.archive.figures.summary import summarise
from proxemetry.archive.review.corrections import FILE as LOG_FILE
from proxemetry.archive.review.corrections import Log
from proxemetry.archive.store.current_tables import current_tables
from proxemetry.archive.store.results import Results
from proxemetry.camera.sources import Doubt, Flag
from proxemetry.cli import main
from proxemetry.errors import OutputError, SettingsError
from proxemetry.report import FILE, write_report
from proxemetry.report import numbers as numbers_module
from proxemetry.report.distance_figures import ratio_over_photos
from proxemetry.report.numbers import Numbers, count
from proxemetry.scene import Scene
from synthetic.drawn import people_at
from synthetic.reviewing import CAMERA, PHOTOS, draw_photo, make_results, scene_of, write_results

CHROMIUM = Path(os.environ.get("CHROMIUM", "/usr/bin/chromium"))


@pytest.fixture(scope="module")
def results(tmp_path_factory: pytest.TempPathFactory) -> Results:
    return make_results(tmp_path_factory.mktemp("report"))


@pytest.fixture(scope="module")
def numbers(results: Results) -> Numbers:
    return count(results.folder, "folder", 4, 10)


def rows(results: Results, table: str) -> list[dict[str, str]]:
    with (Path(results.folder.location) / f"{table}.csv").open() as file:
        return list(csv.DictReader(file))


def test_counts_are_those_of_the_tables(results: Results, numbers: Numbers) -> None:
    assert (numbers.photos, numbers.people) == (6, 13) == (6, len(rows(results, "people")))
    assert numbers.pairs == 15 + 1 + 3 == sum(r["distance_m"] != "" for r in rows(results, "pairs"))
    assert dict(numbers.statuses) == {"ok": 4, "no_camera": 1, "failed": 1}
    assert ("not a photo that can be read", 1) in numbers.refusals
    assert sum(n for _, n in numbers.focal_sources) == 5
    assert numbers.flags == [("the field of view is assumed", 1)]


def test_doubts_that_begin_with_a_photos_size_are_counted_together(tmp_path: Path) -> None:
    names, folder = ("a.jpg", "b.jpg", "c.jpg"), tmp_path / "photos"
    scenes: list[Scene] = []
    for name, size in zip(names, ("600 x 199: ", "1135 x 356: ", ""), strict=True):
        draw_photo(folder / name, people_at([(0.0, 0.0, 4.0)], CAMERA))
        scene = Scene.failed(name, "x")
        doubt = Flag(Doubt.PROJECTION, f"{size}perhaps a panorama" if size else "a fisheye of 8 mm")
        scenes.append(replace(scene, camera=replace(scene.camera, flags=(doubt,))))
    results = write_results(tmp_path / "results", folder, scenes)
    assert count(results.folder, "folder", 1, 1).flags == [("perhaps a panorama", 2), ("a fisheye of 8 mm", 1)]


def test_what_a_list_leaves_out_is_counted_on_its_last_line(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    names = [f"{k}/{number}.jpg" for k in range(4) for number in range(k + 1)]
    scenes = [Scene.failed(name, f"reason {min(k, 7)}") for k, name in enumerate(sorted(names))]
    monkeypatch.setattr(numbers_module, "_LINES", 5)
    monkeypatch.setattr(numbers_module, "_GROUPS", 2)
    for name in names:
        draw_photo(tmp_path / "photos" / name, people_at([], CAMERA))
    results = write_results(tmp_path / "results", tmp_path / "photos", scenes)
    found = count(results.folder, "folder", 1, 1)
    assert found.refusals == [("reason 7", 3), *((f"reason {k}", 1) for k in range(4)), ("3 others", 3)]
    assert [(group.name, group.photos) for group in found.groups] == [("3", 4), ("2", 3)]
    page = write_report(results.folder.location).path.read_text()
    assert "The 2 with the most photos; there are 2 more." in page


def test_doubts_of_each_kind_are_counted_whatever_they_occur_with(tmp_path: Path) -> None:
    results = make_results(tmp_path)
    with current_tables(results) as tables:
        path = tables.folder.path("people.parquet")
    columns = duckdb.execute(f"SELECT * FROM '{path}'").fetchall()
    kinds = ["none", "other_class", "other_class+in_picture", "in_picture", "of a later version"]
    cases = " ".join(f"WHEN row = {k} THEN '{kinds[k % 5]}'" for k in range(len(columns)))
    duckdb.execute(
        f"COPY (SELECT * EXCLUDE (row) REPLACE (CASE {cases} END AS doubt) FROM "
        f"(SELECT *, row_number() OVER () - 1 AS row FROM '{path}')) TO '{tmp_path / 'p.parquet'}' (FORMAT parquet)"
    )
    shutil.copy(tmp_path / "p.parquet", path)
    n = [sum(kinds[k % 5] == kind for k in range(len(columns))) for kind in kinds]
    assert dict(count(results.folder, "folder", 1, 1).doubts) == {
        "may be another kind of thing": n[1] + n[2], "may be on a screen or in a picture": n[2] + n[3],
        "of a later version": n[4],
    }  # fmt: skip


def test_nearest_others_are_each_persons_smallest_distance(results: Results, numbers: Numbers) -> None:
    nearest: dict[tuple[str, str], float] = {}
    for row in rows(results, "pairs"):
        for person in (row["person_a"], row["person_b"]):
            if row["distance_m"]:
                key = (row["photo"], person)
                nearest[key] = min(nearest.get(key, np.inf), float(row["distance_m"]))
    assert numbers.nearest.n == len(nearest) == 11 and numbers.nearest.n_photos == 3
    assert numbers.nearest.median_m == pytest.approx(np.median(list(nearest.values())))
    assert sum(numbers.nearest.counts) == 11 and sum(numbers.every.counts) == 19


def test_zone_shares_sum_to_one_and_lie_in_their_intervals(numbers: Numbers) -> None:
    for distances in (numbers.nearest, numbers.every):
        assert sum(z.value for z in distances.zones) == pytest.approx(1, abs=1e-6)
        for share in distances.zones:
            assert 0 <= share.low <= share.value <= share.high <= 1
        assert distances.low_m <= distances.median_m <= distances.high_m


def test_groups_are_folders(numbers: Numbers) -> None:
    assert [(g.name, g.photos, g.people) for g in numbers.groups] == [("market", 3, 8), ("park", 3, 5)]
    assert numbers.groups[0].nearest.n + numbers.groups[1].nearest.n == numbers.nearest.n


def test_the_lists_begin_with_the_nearest_and_the_least_certain(numbers: Numbers) -> None:
    distances = [p.distance_m for p in numbers.nearest_pairs]
    assert distances == sorted(distances) and len(distances) == 10
    widths = [(p.high_m - p.low_m) / p.distance_m for p in numbers.uncertain_pairs]
    assert widths == sorted(widths, reverse=True)


@settings(deadline=None)
@given(st.lists(st.tuples(st.integers(0, 20), st.integers(0, 20)), min_size=2, max_size=30))
def test_a_share_over_photos_is_a_share(counts: list[tuple[int, int]]) -> None:
    parts = np.array([a for a, _ in counts], dtype=float)
    totals = parts + [b for _, b in counts] + 1
    share = ratio_over_photos(parts, totals)
    assert share.value == pytest.approx(parts.sum() / totals.sum())
    assert 0 <= share.low <= share.value + 1e-12 and share.value - 1e-12 <= share.high <= 1


def test_the_interval_holds_nine_times_out_of_ten() -> None:
    random, inside = np.random.default_rng(4), 0
    for _ in range(400):
        totals = random.integers(1, 12, 80)
        rates = random.beta(2, 5, 80)  # photos differ: pairs in one are not independent
        share = ratio_over_photos(random.binomial(totals, rates).astype(float), totals.astype(float))
        inside += share.low <= 2 / 7 <= share.high
    assert 0.85 <= inside / 400 <= 0.94


def test_a_report_and_a_summary_state_the_same_intervals(numbers: Numbers, results: Results) -> None:
    (group,) = summarise(results).groups
    assert (numbers.nearest.median_m, numbers.nearest.low_m, numbers.nearest.high_m) == pytest.approx(
        (group.nearest_m.value, group.nearest_m.low, group.nearest_m.high)
    )
    ours, theirs = ([[z.value, z.low, z.high] for z in zones] for zones in (numbers.every.zones, group.zones))
    assert np.array(ours) == pytest.approx(np.array(theirs), rel=1e-6)


def test_one_photo_has_no_interval() -> None:
    share = ratio_over_photos(np.array([3.0]), np.array([4.0]))
    assert share.value == 0.75 and np.isnan(share.low)


def test_the_page_needs_nothing_but_itself(results: Results) -> None:
    path = write_report(results.folder.location, photos=2).path
    text = path.read_text()
    assert path.name == FILE
    assert not re.findall(r"""(?:src|href)\s*=\s*["'](?!data:|#figure-|(?:[.][.]/)+photos/|overlays/)""", text)
    assert "<script" not in text
    assert text.count("data:image/jpeg;base64,") == 2 and "SECRET-CAPTION" not in text
    for heading in ("Distances", "By folder", "Why photos have no distances", "Limits", "How to cite", "What was run"):
        assert heading in text
    assert "Heads are pixelated" in text and "ab" * 32 in text


def test_corrections_are_in_the_report(tmp_path: Path) -> None:
    results = make_results(tmp_path)
    scene = next(iter(results.scenes(["market/two.jpg"])))
    log = Log(Path(results.folder.location) / LOG_FILE)
    log.append(scene, "exclude", {"excluded": True, "reason": "a mirror"}, "ada")
    log.close()
    text = write_report(results.folder.location, photos=0).path.read_text()
    assert "excluded by a reviewer" in text and "excluded in review: a mirror" in text
    assert "1 photo was corrected by hand" in text


def test_assumed_focal_lengths_stand_beside_the_distances(results: Results, tmp_path: Path) -> None:
    text = write_report(results.folder.location, tmp_path / "r.html").path.read_text()
    assert "In 1 of 4 measured photos the focal length is ASSUMED" in text


def test_listed_pairs_link_to_figure_overlay_and_photo(tmp_path: Path) -> None:
    results = make_results(tmp_path)
    draw(results)
    folder = Path(results.folder.location)
    for path in (folder / FILE, tmp_path / "elsewhere" / "r.html"):
        path.parent.mkdir(exist_ok=True)
        text = write_report(folder, path, photos=1).path.read_text()
        links = set(re.findall(r"href='([^']+)'>(figure|overlay|photo)<", text))
        assert {what for _, what in links} == {"figure", "overlay", "photo"}
        for address, what in links:
            if what == "figure":
                assert f"id='{address[1:]}'" in text
            else:
                assert (path.parent / unquote(address)).is_file() and not address.startswith("/")
    for photo in (tmp_path / "photos").rglob("*.jpg"):
        photo.unlink()
    assert ">photo</a>" not in write_report(folder, photos=0).path.read_text()  # no link to what is gone


def test_names_are_text_not_markup(tmp_path: Path) -> None:
    name = "<img src=x onerror=alert(1)>\"'.jpg"
    draw_photo(tmp_path / "photos" / name, people_at(PHOTOS["market/two.jpg"][0], CAMERA))
    scene = replace(scene_of(tmp_path / "photos" / name, "market/two.jpg"), photo=name)
    results = write_results(tmp_path / "results", tmp_path / "photos", [scene])
    text = write_report(results.folder.location, photos=1).path.read_text()
    assert "<img src=x" not in text and "&lt;img src=x onerror=alert(1)&gt;" in text


def test_a_run_that_found_nobody_still_has_a_report(tmp_path: Path) -> None:
    draw_photo(tmp_path / "photos" / "market" / "empty.jpg", people_at([], CAMERA))
    scene = scene_of(tmp_path / "photos" / "market" / "empty.jpg", "market/empty.jpg")
    results = write_results(tmp_path / "results", tmp_path / "photos", [scene])
    assert "There is none." in write_report(results.folder.location).path.read_text()


def test_photos_that_are_gone_leave_their_people(tmp_path: Path) -> None:
    results = make_results(tmp_path)
    for photo in (tmp_path / "photos").rglob("*.jpg"):
        photo.unlink()
    assert "data:image/jpeg" in write_report(results.folder.location, photos=1).path.read_text()


def test_errors_say_what_to_do(results: Results, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(OutputError, match="no results there"):
        write_report(tmp_path)
    with pytest.raises(SettingsError, match="folder, country"):
        write_report(results.folder.location, group_by="mood")
    with pytest.raises(OutputError, match="cannot be written"):
        write_report(results.folder.location, Path(results.folder.location, "run.json", "report.html"), photos=0)
    assert main(["report", str(tmp_path)]) == 2
    assert len(capsys.readouterr().err.strip().splitlines()) == 1
    assert main(["report", results.folder.location, "--photos", "0", "--out", str(tmp_path / "r.html")]) == 0


@pytest.fixture
def page(results: Results) -> Iterator[object]:
    playwright = pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
    if not CHROMIUM.exists():
        pytest.skip(f"no Chromium at {CHROMIUM}: apt-get install chromium, or set CHROMIUM")
    path = write_report(results.folder.location, photos=2).path
    with playwright.sync_playwright() as running:
        browser = running.chromium.launch(executable_path=str(CHROMIUM), args=["--no-sandbox", "--disable-gpu"])
        opened = browser.new_page(viewport={"width": 1100, "height": 900})
        opened.asked = []
        opened.on("request", lambda r: opened.asked.append(r.url))
        opened.problems = []
        opened.on("console", lambda m: opened.problems.append(m.text))
        opened.goto(path.as_uri())
        yield opened
        browser.close()


@pytest.mark.browser
def test_it_opens_from_the_disk_and_prints(page, tmp_path: Path) -> None:
    assert [u for u in page.asked if not u.startswith(("file:", "data:"))] == [] and page.problems == []
    assert page.evaluate("[...document.images].every(i => i.complete && i.naturalWidth > 600)")
    assert page.evaluate("document.documentElement.scrollWidth <= innerWidth")
    content = page.pdf(format="A4")
    assert content.startswith(b"%PDF") and len(content) > 50_000
    if os.environ.get("SCREENSHOTS"):
        page.screenshot(path=f"{os.environ['SCREENSHOTS']}/report.png", full_page=True)


def test_the_methods_paragraph_has_the_run_s_own_figures(tmp_path, capsys):
    results = make_results(tmp_path)
    assert main(["summary", results.folder.location, "--methods"]) == 0
    said = " ".join(capsys.readouterr().out.split())
    assert "in 6 photographs with proxemetry" in said and "pose back end drawn" in said
    assert "Of the 4 measured photographs, the focal length was assumed in 1 (25%)" in said
    assert "1 had no usable focal length; 1 could not be read" in said
    assert "13 people were found" in said and "which gave 19 pairs" in said
    write_report(results.folder.location)
    page = " ".join((tmp_path / "results" / "report.html").read_text().split())
    assert "which gave 19 pairs" in page
