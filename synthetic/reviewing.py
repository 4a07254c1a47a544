"""A small results folder with photos, for what a person looks at: drawn people on plain pictures."""

import socket
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
import uvicorn
from PIL import Image, ImageDraw

from proxemetry.archive.store import parts
from proxemetry.archive.store.folder import Folder
from proxemetry.archive.store.part_rows import record_of
from proxemetry.archive.store.photos import search
from proxemetry.archive.store.results import Results
from proxemetry.archive.store.run_file import write_run
from proxemetry.camera import Camera, CameraEstimate, Doubt, Flag, FocalSource, Source
from proxemetry.measure import place
from proxemetry.people import People
from proxemetry.photo import Photo
from proxemetry.scene import Scene
from proxemetry.settings import Settings
from proxemetry.web.app import create_app
from proxemetry.web.serve import Application, configuration
from proxemetry.web.session import Review
from synthetic.drawn import people_at
from synthetic.manifests import listed_photos

TOKEN = "the-token-of-a-test"

WIDTH, HEIGHT = 900, 600
CAMERA = Camera.centred(780, WIDTH, HEIGHT, focal_rel_sd=0.02, source="test")
ASSUMED = Camera.centred(
    780, WIDTH, HEIGHT, focal_rel_sd=0.2, source=Source(FocalSource.ASSUMED_FOV, "60 degrees")
)  # fmt: skip

#: Photo -> where people stand in metres of the camera frame, and the camera.
PHOTOS: dict[str, tuple[list[tuple[float, float, float]], Camera | None]] = {
    "market/crowd.jpg": ([(-2.4 + 0.9 * k, 0.1, 6.0 + 0.7 * (k % 3)) for k in range(6)], CAMERA),
    "market/empty.jpg": ([], CAMERA),
    "market/two.jpg": ([(-0.75, 0.0, 5.0), (0.75, 0.0, 5.0)], CAMERA),
    "park/assumed.jpg": ([(-1.0, 0.0, 4.0), (0.2, 0.0, 6.5), (1.4, 0.0, 5.0)], ASSUMED),
    "park/unknown.jpg": ([(-0.5, 0.0, 4.0), (0.6, 0.0, 4.5)], None),
}
SETTINGS = Settings(method="torso")


def draw_photo(path: Path, people: People, marked: bool = True) -> None:
    """Write a JPEG with a grey figure for everyone, and metadata that must go nowhere."""
    image = Image.new("RGB", (WIDTH, HEIGHT), (205, 214, 205))
    pen = ImageDraw.Draw(image)
    pen.rectangle((0, HEIGHT * 0.55, WIDTH, HEIGHT), fill=(172, 168, 158))
    for i in range(len(people)):
        for a, b in people.skeleton.bones:
            ends = [tuple(people.joint(j)[i]) for j in (a, b)]
            if np.isfinite(ends).all():
                pen.line(ends, fill=(70, 78, 92), width=16)
        x, y = people.part("Head")[i]
        pen.ellipse((x - 17, y - 20, x + 17, y + 22), fill=(196, 160, 138))
        for k in range(-12, 13, 6):  # a face with something to recognise
            pen.line((x - 12, y + k, x + 12, y - k), fill=(40, 30, 30), width=2)
    exif = Image.Exif()
    exif[0x010F], exif[0x0110] = "Maker", f"Model of {path.parent.name}"
    if marked:
        exif[0x010E] = "SECRET-CAPTION"
    path.parent.mkdir(parents=True, exist_ok=True)
    image.save(path, quality=88, exif=exif)


def scene_of(path: Path, name: str, people_m: list[tuple[float, float, float]] | None = None) -> Scene:
    """Return the scene of one of `PHOTOS`, or of other people before its camera."""
    places_m, camera = PHOTOS[name]
    places_m = people_m or places_m
    photo = Photo.open(path, name)
    assumed = Flag(Doubt.ASSUMED, "the field of view is assumed")
    estimate = CameraEstimate(camera, flags=(assumed,) if camera is ASSUMED else (),
                              reason=None if camera else "no focal length: state one with --focal-35mm")  # fmt: skip
    people = people_at(places_m, CAMERA)
    scene = place(name, photo.sha256, photo.width, photo.height, people, estimate, SETTINGS)
    return replace(scene, about=photo.metadata.about())


def make_results(root: Path) -> Results:
    """Return a finished results folder at root/results of photos at root/photos, one of which cannot be read."""
    photos = root / "photos"
    for name, (places_m, _) in PHOTOS.items():
        draw_photo(photos / name, people_at(places_m, CAMERA))
    (photos / "park" / "broken.jpg").write_bytes(b"\xff\xd8\xff\xe0 no more than the beginning")
    scenes = [scene_of(photos / name, name) for name in PHOTOS]
    scenes.append(Scene.failed("park/broken.jpg", "park/broken.jpg: not a photo that can be read"))
    return write_results(root / "results", photos, scenes)


def write_results(location: Path, photos: Path, scenes: list[Scene]) -> Results:
    """Write a results folder holding these scenes of the photos in a folder."""
    folder = Folder(location)
    listed = listed_photos(folder, search([str(photos)]))
    by_name = {s.photo: s for s in scenes}
    for shard in range(listed.n_shards):
        records = [record_of(by_name[item.photo]) for item in listed.items(shard)]
        parts.write(folder, shard, records, {"proxemetry_version": "test"})
    write_run(folder, {
        "schema": "proxemetry.run/1", "version": "0.1.0", "pose": "drawn", "models": {"net.onnx": "ab" * 32},
        "settings": SETTINGS.to_dict(), "python": "3.11", "platform": "test", "packages": {"numpy": "2.0"},
    })  # fmt: skip
    results = Results(folder)
    results.write_tables()
    return results


@contextmanager
def served(review: Review) -> Iterator[tuple[str, str]]:
    """Yield the origin and the token of a review's page, served by a thread."""
    with serving(partial(create_app, review)) as address:
        yield address


@contextmanager
def serving(application: Application) -> Iterator[tuple[str, str]]:
    """Yield the origin and the token of a page, served by a thread."""
    listener = socket.socket()
    listener.bind(("127.0.0.1", 0))
    listener.listen()  # before anyone asks
    host = f"127.0.0.1:{listener.getsockname()[1]}"
    app = application(TOKEN, (host, host.replace("127.0.0.1", "localhost")))
    server = uvicorn.Server(configuration(app))
    thread = threading.Thread(target=server.run, kwargs={"sockets": [listener]}, daemon=True)
    thread.start()
    try:
        yield f"http://{host}", TOKEN
    finally:
        server.should_exit = True
        thread.join(10)
        listener.close()
