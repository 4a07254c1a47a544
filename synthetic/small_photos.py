"""Small photos to run archives over, and detectors for them that need no network."""

from __future__ import annotations

import os
import signal
from pathlib import Path

import numpy as np
from PIL import Image

WIDTH, HEIGHT = 64, 48
#: Shoulders, hips, eyes and ankles of a person 1 unit tall with the neck at the origin (COCO-17 rows).
_JOINTS = {1: (0.02, -0.1), 2: (-0.02, -0.1), 5: (0.1, 0), 6: (-0.1, 0), 11: (0.06, 0.3), 12: (-0.06, 0.3)}


def write_photo(path: Path, number: int) -> Path:
    """Write a photo that is like no other of another number, with a 35 mm equivalent of 28 mm."""
    pixels = np.random.default_rng(number).integers(0, 255, (HEIGHT, WIDTH, 3), dtype=np.uint8)
    image = Image.fromarray(pixels)
    exif = image.getexif()
    exif.get_ifd(0x8769)[0xA405] = 28
    path.parent.mkdir(parents=True, exist_ok=True)
    image.save(path, exif=exif)
    return path


def write_photos(folder: Path, count: int) -> Path:
    for number in range(count):
        write_photo(folder / f"{number // 100:02d}" / f"photo_{number:05d}.jpg", number)
    return folder


def two_people(pixels: np.ndarray) -> np.ndarray:
    """Return two people whose places follow from the pixels, shape (2, 17, 3)."""
    shift = float(pixels[:8, :8].mean()) / 255
    people = np.zeros((2, 17, 3))
    for i, (x, size) in enumerate(((0.3, 0.6), (0.5 + 0.3 * shift, 0.5))):
        for joint, (u, v) in _JOINTS.items():
            people[i, joint] = ((x + u * size) * WIDTH, (0.3 + v * size) * HEIGHT, 0.9)
    return people


def is_number(pixels: np.ndarray, number: int) -> bool:
    """Return whether this is the photo of that number (JPEG moves pixels a little)."""
    original = np.random.default_rng(number).integers(0, 255, (HEIGHT, WIDTH, 3), dtype=np.uint8)
    return bool(
        abs(original.astype(float) - pixels).mean() < 70 and np.corrcoef(original.ravel(), pixels.ravel())[0, 1] > 0.5
    )


def killed_by_seven(pixels: np.ndarray) -> np.ndarray:
    """End the whole process, as a crash in a decoder does, at photo number 7."""
    if is_number(pixels, 7):
        os.kill(os.getpid(), signal.SIGKILL)
    return two_people(pixels)


def broken_at_seven(pixels: np.ndarray) -> np.ndarray:
    """Have a bug at photo number 7."""
    if is_number(pixels, 7):
        raise ZeroDivisionError("seven")
    return two_people(pixels)


COUNT = {"calls": 0}


def counted(pixels: np.ndarray) -> np.ndarray:
    """Count how often it is asked."""
    COUNT["calls"] += 1
    return two_people(pixels)


def a_crowd(pixels: np.ndarray) -> np.ndarray:
    """Return 70 people: more pairs than one piece of a table has."""
    one = two_people(pixels)[:1]
    people = np.repeat(one, 70, axis=0)
    people[:, :, 0] = (people[:, :, 0] + 0.6 * np.arange(70)[:, None]) % WIDTH
    return people
