"""The photos and clips that a command line names, opened one after another."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from ..errors import PhotoError
from ..photo import EXTENSIONS, Photo

CLIPS = (".avi", ".mp4", ".mov", ".m4v", ".mkv", ".webm", ".mts", ".mpg", ".mpeg")
#: Frames per second of a clip that are used, and how many at most.
FPS, MOST_FRAMES = 5.0, 600


def first_photos(paths: list[str]) -> Iterator[Photo]:
    """Yield the photos that paths name, clips' first frames among them; raises PhotoError where one is not there."""
    for path in map(Path, paths):
        if path.suffix.lower() in CLIPS:
            yield next(frames_of(path, 1.0))[1]
        elif path.is_dir():
            yield from (Photo.open(p) for p in sorted(path.rglob("*")) if p.suffix.lower() in EXTENSIONS)
        else:
            yield Photo.open(path)


def frames_of(path: Path, fps: float) -> Iterator[tuple[float, Photo]]:
    """Yield time in seconds and picture of a clip's frames, so many a second; raises PhotoError for no clip."""
    import cv2

    capture = cv2.VideoCapture(str(path))
    due, number = 0.0, 0
    try:
        while capture.grab():
            now = capture.get(cv2.CAP_PROP_POS_MSEC) / 1000
            if now + 1e-6 >= due:
                ok, pixels = capture.retrieve()
                if ok:
                    due = max(due, now) + 1 / fps - 1e-3
                    number += 1
                    yield (
                        now,
                        Photo.from_array(
                            np.ascontiguousarray(pixels[:, :, ::-1], dtype=np.uint8), f"{path.name}#t={now:.3f}"
                        ),
                    )
    finally:
        capture.release()
    if not number:
        raise PhotoError(f"{path}: no clip that can be read")
