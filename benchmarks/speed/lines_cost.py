"""Processor time of finding straight lines, compared with decoding the same photo in the same run.

    python -m benchmarks.speed.lines_cost --photos DIR [--count 8] [--megapixels 24] [--repeats 7]

The first photos of a folder are enlarged to so many megapixels and written as JPEG, since small ones decode faster than
cameras' files. Processor time of one core, milliseconds, the least of several repeats: decoding the photo as the
default back ends do, in whose pixels lines are looked for; OpenCV's detector alone; segments (the picture reduced, the
detector, pieces of one line joined); the focal length from them; and gravity. `in all` is the time for a photo of
unknown focal length: segments and focal length. The ratio is that to its decoding; on a busy machine it says more than
milliseconds.
"""

from __future__ import annotations

import os

os.environ.setdefault("OMP_NUM_THREADS", "1")  # before NumPy is loaded: one core

import argparse
import math
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import TypeVar

import cv2
import numpy as np

from proxemetry.camera import Camera
from proxemetry.camera.lines.focal import focal_profile
from proxemetry.camera.lines.gravity import read_gravity
from proxemetry.camera.lines.segments import LONG_SIDE_PX, segments_of
from proxemetry.photo import EXTENSIONS, Photo

COLUMNS = ("decoding", "LSD", "segments", "focal", "gravity", "in all", "ratio")
#: A field of view for gravity, which is asked once the focal length is settled.
_FOV_DEG = 60.0
#: As small as the default back ends have a photo decoded, long side.
_DECODED_PX = 2000
_T = TypeVar("_T")


def least_ms(task: Callable[[], _T], repeats: int) -> tuple[_T, float]:
    """Return what the task returns, and the least processor time that it took, milliseconds."""
    times: list[float] = []
    for _ in range(repeats):
        started = time.process_time()
        answer = task()
        times.append(time.process_time() - started)
    return answer, 1000 * min(times)


def costs(path: Path, repeats: int) -> list[float]:
    """Return one photo's row of the table."""
    nobody = np.zeros((0, 4))
    photo, decoding = least_ms(lambda: _decoded(path), repeats)
    pixels = photo.pixels(LONG_SIDE_PX)  # those decoded before
    grey = cv2.cvtColor(pixels, cv2.COLOR_RGB2GRAY)
    scale = min(1.0, LONG_SIDE_PX / max(grey.shape))
    grey = cv2.resize(grey, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA)
    _, detector = least_ms(lambda: cv2.createLineSegmentDetector(cv2.LSD_REFINE_NONE).detect(grey), repeats)
    segments, looked = least_ms(lambda: segments_of(photo, nobody), repeats)
    assert segments is not None
    _, focal = least_ms(lambda: focal_profile(segments, photo.width, photo.height), repeats)
    f_px = math.hypot(photo.width, photo.height) / 2 / math.tan(math.radians(_FOV_DEG / 2))
    camera = Camera(f_px, f_px, photo.width / 2, photo.height / 2, photo.width, photo.height)
    _, gravity = least_ms(lambda: read_gravity(segments, camera), repeats)
    return [decoding, detector, looked, focal, gravity, looked + focal, (looked + focal) / decoding]


def _decoded(path: Path) -> Photo:
    photo = Photo.open(path)
    photo.pixels(_DECODED_PX)
    return photo


def enlarged(path: Path, folder: Path, megapixels: float) -> Path:
    """Write a photo as a JPEG of so many megapixels into a folder, and return it."""
    pixels = Photo.open(path).pixels()
    factor = math.sqrt(1e6 * megapixels / (pixels.shape[0] * pixels.shape[1]))
    large = cv2.resize(pixels, None, fx=factor, fy=factor, interpolation=cv2.INTER_CUBIC)
    target = folder / f"{path.stem}.jpg"
    cv2.imwrite(str(target), cv2.cvtColor(large, cv2.COLOR_RGB2BGR), [cv2.IMWRITE_JPEG_QUALITY, 90])
    return target


def main() -> None:
    """Print a line a photo, and the medians."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--photos", type=Path, required=True)
    parser.add_argument("--count", type=int, default=8)
    parser.add_argument("--megapixels", type=float, default=24.0)
    parser.add_argument("--repeats", type=int, default=7)
    args = parser.parse_args()
    cv2.setNumThreads(1)
    paths = [path for path in sorted(args.photos.iterdir()) if path.suffix.lower() in EXTENSIONS][: args.count]
    print(f"{'photo':32}" + "".join(f"{name:>10}" for name in COLUMNS))
    rows: list[list[float]] = []
    with tempfile.TemporaryDirectory() as folder:
        for path in paths:
            rows.append(costs(enlarged(path, Path(folder), args.megapixels), args.repeats))
            _print(path.name, rows[-1])
    for name, of in (("least", np.min), ("median", np.median), ("most", np.max)):
        _print(name, of(rows, axis=0).tolist())


def _print(name: str, row: list[float]) -> None:
    print(f"{name[:32]:32}" + "".join(f"{value:10.1f}" for value in row[:-1]) + f"{row[-1]:10.2f}", flush=True)


if __name__ == "__main__":
    main()
