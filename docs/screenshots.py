"""Make the guide's pictures with the program itself: `python -m docs.screenshots` writes docs/images/*.webp.

The photos are the drawn example and parts of it, so nobody real is shown. Needs Playwright and Chromium (CHROMIUM names
another one than /usr/bin/chromium).
"""

import json
import os
import sys
import tempfile
from pathlib import Path
from typing import Any

from PIL import Image, ImageOps
from playwright.sync_api import Page, sync_playwright

from proxemetry.cli import main as proxemetry
from proxemetry.people import People
from proxemetry.people.skeleton import COCO_17
from proxemetry.report import write_report
from proxemetry.web.session import Review
from proxemetry.web.stores import DropStore, FolderStore
from synthetic.reviewing import served

ROOT = Path(__file__).resolve().parent.parent
IMAGES = ROOT / "docs" / "images"

#: Photo -> the part of the example (x0, y0, x1, y1; None for all of it), and whether it is mirrored.
PARTS: dict[str, tuple[tuple[int, int, int, int] | None, bool]] = {
    "plaza/evening.jpg": (None, False),
    "plaza/morning.jpg": (None, True),
    "plaza/left_half.jpg": ((0, 0, 800, 1068), False),
    "street/right_half.jpg": ((800, 0, 1600, 1068), False),
    "street/nobody.jpg": ((500, 0, 1100, 300), False),
}


def draw_photos(folder: Path) -> Path:
    """Write the photos and what is recorded of their people; return the file of the recorded people."""
    recorded = json.loads((ROOT / "examples" / "plaza.json").read_text())["images"][0]
    whole = Image.open(ROOT / "examples" / "plaza.jpg")
    points = [p["keypoints"] for p in recorded["people"]]
    people = People(COCO_17, [[k[:2] for k in p] for p in points], [[k[2] for k in p] for p in points])
    images: list[dict[str, Any]] = []
    for name, (part, mirrored) in PARTS.items():
        x0, y0, x1, y1 = part or (0, 0, *whole.size)
        image = whole.crop((x0, y0, x1, y1))
        middle = people.boxes_px.reshape(-1, 2, 2).mean(axis=1)
        inside = (middle > (x0, y0)).all(axis=1) & (middle < (x1, y1)).all(axis=1)
        shown = People(COCO_17, people.keypoints_px[inside] - (x0, y0), people.scores[inside])
        if mirrored:
            image, shown = ImageOps.mirror(image), shown.mirrored(image.width)
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        image.save(path, quality=90, exif=whole.getexif())
        keypoints = [
            [[*map(float, xy), float(s)] for xy, s in zip(k, scores, strict=True)]
            for k, scores in zip(shown.keypoints_px, shown.scores, strict=True)
        ]
        images.append({"filename": name, "width": image.width, "height": image.height,
                       "people": [{"keypoints": k} for k in keypoints]})  # fmt: skip
    path = folder.parent / "people.json"
    path.write_text(json.dumps({"skeleton": "coco17", "images": images}))
    return path


def keep(page: Page, name: str, **clip: Any) -> None:
    """Keep what the page shows as docs/images/NAME.webp."""
    page.wait_for_timeout(500)
    path = IMAGES / f"{name}.png"
    page.screenshot(path=path, **clip)
    Image.open(path).save(path.with_suffix(".webp"), quality=82, method=6)
    path.unlink()


def show_review(page: Page, results: str) -> None:
    """Keep the views of the review page."""
    with served(Review(FolderStore(results), "ada")) as (origin, token):
        page.goto(f"{origin}/?token={token}")
        page.wait_for_selector(".card")
        keep(page, "review-gallery")
        page.locator(".card a", has_text="evening").click()
        page.wait_for_selector(".joint")
        keep(page, "review-photo")
        page.keyboard.press("0")
        page.locator("#tab-panel tr[data-pair]").first.hover()
        keep(page, "review-linked")
        page.keyboard.press("f")
        keep(page, "review-focal")
    store = DropStore()
    with served(Review(store, "ada")) as (origin, token):
        page.goto(f"{origin}/?token={token}")
        page.wait_for_selector(".drop")
        keep(page, "review-drop", clip={"x": 0, "y": 0, "width": 1280, "height": 420})
    store.close()


def main() -> None:
    """Write all pictures."""
    IMAGES.mkdir(exist_ok=True)
    with tempfile.TemporaryDirectory() as root, sync_playwright() as playwright:
        os.chdir(root)  # the page shows the folder as it is given: a reader's own, not this machine's
        results, photos = "results", Path("photos")
        recorded = draw_photos(photos)
        code = proxemetry(["measure", str(photos), "--out", results, "--pose", f"recorded:{recorded}", "--jobs", "1"])
        if code == 2:
            sys.exit("the example photos could not be measured")
        browser = playwright.chromium.launch(
            executable_path=os.environ.get("CHROMIUM", "/usr/bin/chromium"), args=["--no-sandbox", "--disable-gpu"]
        )
        page = browser.new_page(viewport={"width": 1280, "height": 800})
        page.goto(write_report(results, photos=2).path.resolve().as_uri())
        keep(page, "report")
        show_review(page, results)
        browser.close()
    print(f"written: {', '.join(sorted(p.name for p in IMAGES.glob('*.webp')))}")


if __name__ == "__main__":
    main()
