"""How fast the review page is on a large run, in a real browser: first page, a photo, a correction's new numbers.

    python -m benchmarks.speed.review_speed [--photos 5000] [--repeat 15]

Makes a results folder of that many photos (the example photo, each file made different by a few bytes at its end, with
6 or 25 people placed by the scene fit), serves it, and times what a reviewer waits for: from the click or key to the
numbers on the screen. Needs Playwright and Chromium (CHROMIUM names another one than /usr/bin/chromium).
"""

import argparse
import hashlib
import json
import os
import statistics
import tempfile
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
from playwright.sync_api import Page, sync_playwright

from proxemetry import __version__
from proxemetry.archive.store import parts
from proxemetry.archive.store.folder import Folder
from proxemetry.archive.store.part_rows import record_of
from proxemetry.archive.store.photos import search
from proxemetry.archive.store.run_file import write_run
from proxemetry.camera import CameraEstimate
from proxemetry.camera.focal import estimate_camera
from proxemetry.measure import place
from proxemetry.people import People
from proxemetry.people.skeleton import skeleton_named
from proxemetry.photo import Photo
from proxemetry.settings import Settings
from proxemetry.web.session import Review
from proxemetry.web.stores import FolderStore
from synthetic.manifests import listed_photos
from synthetic.reviewing import served

ROOT = Path(__file__).resolve().parents[2]

#: What the page is meant to keep to, milliseconds.
LIMITS_MS = {"first page": 1000, "photo view": 300, "correction": 200}


_NAME, _HASH = "@name@", "@hash@"


def example_people() -> People:
    """Return the people of the example photo."""
    recorded = json.loads((ROOT / "examples" / "plaza.json").read_text())
    keypoints = np.array([p["keypoints"] for p in recorded["images"][0]["people"]])
    return People(skeleton_named(recorded["skeleton"]), keypoints[..., :2], keypoints[..., 2])


def crowd(people: People, count: int) -> People:
    """Return `count` people: those of the example over and over, each a little further to the side."""
    rows = [i % len(people) for i in range(count)]
    shift = np.array([[[37.0 * (k // len(people)), 11.0 * (k // len(people))]] for k in range(count)])
    return People(people.skeleton, people.keypoints_px[rows] + shift, people.scores[rows])


def make_run(root: Path, count: int) -> str:
    """Return the location of a results folder with `count` photos."""
    photos, content = root / "photos", (ROOT / "examples" / "plaza.jpg").read_bytes()
    photo = Photo.open(ROOT / "examples" / "plaza.jpg")
    estimate: CameraEstimate = estimate_camera(photo)
    # One row of the results for each variant; the photos' rows differ in the file's name and hash alone.
    rows = [
        record_of(place(_NAME, _HASH, photo.width, photo.height, people, estimate, Settings(method="scene")))
        for people in (example_people(), crowd(example_people(), 25))
    ]
    for number in range(count):
        path = photos / f"{number // 500:02d}" / f"photo_{number:05d}.jpg"
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(content + number.to_bytes(4, "big"))
    results = Folder(root / "results")
    listed = listed_photos(results, search([str(photos)]))
    for shard in range(listed.n_shards):
        records = []
        for item in listed.items(shard):
            row = rows[int(item.photo[-9:-4]) % 20 == 7]
            digest = hashlib.sha256(Path(item.location or "").read_bytes()).hexdigest()
            records.append(replace(row, json=row.json.replace(_NAME, item.photo).replace(_HASH, digest)))
        parts.write(results, shard, records, {"proxemetry_version": __version__})
    settings = Settings(method="scene").to_dict()
    write_run(results, {"version": __version__, "pose": "drawn", "models": {}, "settings": settings})
    return results.location


def timed(page: Page, run: str, until: str) -> float:
    """Return the milliseconds from doing `run` in the page until `until` holds after the browser has painted."""
    return page.evaluate(
        f"""async () => {{
          const start = performance.now();
          {run};
          const holds = {until};
          while (!holds()) await new Promise(requestAnimationFrame);
          await new Promise(requestAnimationFrame);
          return performance.now() - start;
        }}"""
    )


def press(key: str) -> str:
    """Return the script that presses a key."""
    return f"document.body.dispatchEvent(new KeyboardEvent('keydown', {{key: '{key}', bubbles: true}}))"


def first_page(page: Page, address: str) -> float:
    """Return the milliseconds from opening the address to the first page's cards."""
    started = time.perf_counter()
    page.goto(address, wait_until="commit")
    page.wait_for_selector(".card")
    return 1000 * (time.perf_counter() - started)


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--photos", type=int, default=5000)
    parser.add_argument("--repeat", type=int, default=15)
    args = parser.parse_args()
    with tempfile.TemporaryDirectory() as root, sync_playwright() as playwright:
        location = make_run(Path(root), args.photos)
        started = time.perf_counter()
        review = Review(FolderStore(location), "benchmark")
        opening = 1000 * (time.perf_counter() - started)
        browser = playwright.chromium.launch(
            executable_path=os.environ.get("CHROMIUM", "/usr/bin/chromium"), args=["--no-sandbox", "--disable-gpu"]
        )
        page = browser.new_page(viewport={"width": 1440, "height": 860})
        times: dict[str, list[float]] = {name: [] for name in LIMITS_MS}
        with served(review) as (origin, token):
            for _ in range(5):
                times["first page"].append(first_page(page, f"{origin}/?token={token}"))
            page.locator(".card a").first.click()
            page.wait_for_selector(".joint")
            for _ in range(args.repeat):
                title = page.locator(".photo h1").inner_text()
                shown = f"() => document.querySelector('.photo h1').textContent !== {json.dumps(title)}"
                times["photo view"].append(timed(page, press("ArrowRight"), shown))
                page.wait_for_timeout(150)
                people = page.locator("g.person").count()
                page.evaluate(f"() => {press('0')}")
                less = f"() => document.querySelectorAll('g.person').length === {people - 1}"
                times["correction"].append(timed(page, press("x"), less))
                page.wait_for_timeout(100)
        browser.close()
    print(f"{args.photos} photos; opening the folder {opening:.0f} ms; medians and worst of what a reviewer waits for")
    for name, values in times.items():
        print(
            f"{name:12} {statistics.median(values):6.0f} ms  worst {max(values):6.0f} ms  of {len(values):3}"
            f"  meant: {LIMITS_MS[name]} ms"
        )


if __name__ == "__main__":
    main()
