"""A clip as frames with times: a video file, or a folder of pictures of one camera taken in turn.

Decoding is OpenCV's, upright and with the file's own times: clips of variable frame rate are common, and a frame
number over a nominal rate is not when it was taken.
"""

from __future__ import annotations

import hashlib
import os
import re
from collections import Counter
from collections.abc import Generator, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from datetime import datetime
from pathlib import Path
from typing import Protocol

import cv2
import numpy as np

from ..arrays import RGBArray
from ..errors import ClipError, PhotoError, ProxemetryError
from ..files import sha256_of
from ..photo import EXTENSIONS, Photo

#: File name endings that are taken for clips where a folder is named.
ENDINGS = (".mp4", ".m4v", ".mov", ".avi", ".mkv", ".webm", ".mpg", ".mpeg", ".mts", ".m2ts", ".ts", ".wmv", ".3gp")
#: Frames are due this much before their moment: times are rounded to milliseconds.
_EARLY_S = 0.004


@dataclass(frozen=True, eq=False)
class Frame:
    """One frame that is measured. number: its place among those, from 0. t_s: when, from the clip's beginning.

    photo: its pixels under its name in the results; its hash is that of the clip and the moment. source: its place
    among all frames of the clip, from 0.
    """

    number: int
    t_s: float
    photo: Photo
    source: int


class Clip(Protocol):
    """What can be gone through frame by frame, any number of times, always with the same frames."""

    @property
    def name(self) -> str:
        """How results call it."""
        ...

    @property
    def sha256(self) -> str:
        """The hash of the file, or of all files."""
        ...

    @property
    def expected(self) -> int | None:
        """About how many frames there will be, where anything is known of it."""
        ...

    @property
    def fps(self) -> float:
        """How many frames per second are measured, at most."""
        ...

    def frames(self) -> Iterator[Frame]:
        """Go through the frames, each decoded once; raises ClipError where there is none."""
        ...


def open_clip(path: str | Path, fps: float) -> Clip:
    """Return the clip at a path: a video file or a folder of pictures; raises ClipError where it is neither."""
    path = Path(path)
    if path.is_dir():
        return PictureFolder.open(path, fps)
    return VideoFile.open(path, fps)


@contextmanager
def _quiet() -> Generator[None]:
    """Keep the decoder's own remarks off stderr: what matters of them comes back as an error."""
    before = cv2.utils.logging.getLogLevel()
    os.environ.setdefault("OPENCV_FFMPEG_LOGLEVEL", "-8")
    cv2.utils.logging.setLogLevel(cv2.utils.logging.LOG_LEVEL_SILENT)
    try:
        yield
    finally:
        cv2.utils.logging.setLogLevel(before)


@dataclass(frozen=True)
class VideoFile:
    """A video file. width, height: of the upright picture, pixels. seconds: as its header has it, 0 where unknown."""

    path: Path
    name: str
    sha256: str
    width: int
    height: int
    rate: float
    seconds: float
    fps: float

    @classmethod
    def open(cls, path: Path, fps: float) -> VideoFile:
        """Read a file's header and hash; raises ClipError where there is no picture in it."""
        try:
            digest = sha256_of(path)
        except FileNotFoundError as error:
            raise ClipError(f"{path}: no such file or folder") from error
        except OSError as error:
            raise ClipError(f"{path}: cannot be read ({error.strerror})") from error
        if not path.stat().st_size:
            raise ClipError(f"{path}: the file is empty")
        with _quiet():
            capture = _capture(path)
            got, first = capture.read()
            rate, count = capture.get(cv2.CAP_PROP_FPS), capture.get(cv2.CAP_PROP_FRAME_COUNT)
            capture.release()
        if not got:
            raise ClipError(f"{path}: a video without a single frame that can be decoded; is it whole?")
        rate = rate if 0 < rate < 1000 else 25.0
        return cls(path, path.name, digest, first.shape[1], first.shape[0], rate, max(0.0, count / rate), fps)

    @property
    def expected(self) -> int | None:
        """About how many frames there will be: headers may be wrong."""
        return max(1, round(self.seconds * min(self.fps, self.rate))) if self.seconds else None

    def frames(self) -> Iterator[Frame]:
        """Go through the frames that are due, every one decoded, since others build on it."""
        with _quiet():
            capture = _capture(self.path)
            try:
                yield from self._due(capture)
            finally:
                capture.release()

    def _due(self, capture: cv2.VideoCapture) -> Iterator[Frame]:
        number, last_due, read, origin, previous = 0, -1, 0, None, -1.0
        while capture.grab():
            t_s = capture.get(cv2.CAP_PROP_POS_MSEC) / 1000
            origin = t_s if origin is None else origin
            t_s -= origin
            if read and t_s <= previous:  # no times in the file, or broken ones
                t_s = previous + 1 / self.rate
            previous, read = t_s, read + 1
            due = int((t_s + _EARLY_S) * self.fps)
            if due <= last_due:
                continue
            last_due = due
            got, pixels = capture.retrieve()
            if got:
                yield Frame(number, t_s, self._photo(t_s, np.asarray(pixels, dtype=np.uint8)), read - 1)
                number += 1

    def _photo(self, t_s: float, bgr: RGBArray) -> Photo:
        name = f"{self.name}#t={t_s:.3f}"
        pixels = np.ascontiguousarray(bgr[..., ::-1])
        pixels.setflags(write=False)
        digest = hashlib.sha256(f"{self.sha256}#t={t_s:.3f}".encode()).hexdigest()
        return Photo(name, pixels.shape[1], pixels.shape[0], digest, _pixels=pixels)


def _capture(path: Path) -> cv2.VideoCapture:
    """Open a file with the one decoder that knows times; others would take a numbered name for a series."""
    capture = cv2.VideoCapture(str(path), cv2.CAP_FFMPEG)
    if not capture.isOpened():
        raise ClipError(f"{path}: no video in it that can be decoded (sound only, cut short, or not a video)")
    return capture


@dataclass(frozen=True)
class PictureFolder:
    """A folder of pictures of one fixed camera, in the order of their times, else of their names.

    times_s: when each was taken, from the first one on. timed: whether that is known from the pictures themselves;
    else they are taken to be 1 / fps apart.
    """

    path: Path
    name: str
    sha256: str
    files: tuple[Path, ...]
    times_s: tuple[float, ...]
    timed: bool
    fps: float = 5.0
    unreadable: tuple[str, ...] = field(default=())

    @classmethod
    def open(cls, path: Path, fps: float) -> PictureFolder:
        """List a folder's pictures; raises ClipError where there is none, or where they are of several sizes."""
        files = sorted((p for p in path.iterdir() if p.suffix.lower() in EXTENSIONS), key=_natural)
        if not files:
            raise ClipError(
                f"{path}: no pictures in this folder; name a video file, or a folder of consecutive pictures"
            )
        photos: list[Photo] = []
        readable: list[Path] = []
        bad: list[str] = []
        for file in files:
            try:
                photos.append(Photo.open(file))
                readable.append(file)
            except PhotoError as error:
                bad.append(str(error))
        if not readable:
            raise ClipError(f"{path}: none of its {len(files)} pictures can be read ({bad[0]})")
        _require_one_size(path, photos)
        content = "\n".join(f"{p.name} {photo.sha256}" for p, photo in zip(readable, photos, strict=True))
        digest = hashlib.sha256(content.encode(errors="surrogateescape")).hexdigest()
        times = _increasing([_taken(photo) for photo in photos])
        timed = times is not None
        order = np.argsort(times, kind="stable") if times is not None else np.arange(len(readable))
        seconds = [times[k] for k in order] if times is not None else [k / fps for k in range(len(readable))]
        return cls(
            path, path.name, digest, tuple(readable[k] for k in order), tuple(float(s) for s in seconds), timed, fps,
            tuple(bad),
        )  # fmt: skip

    @property
    def expected(self) -> int | None:
        """How many frames there will be."""
        return len(self.files)

    def frames(self) -> Iterator[Frame]:
        """Go through the pictures; one that cannot be decoded comes as an error when its pixels are asked for."""
        for number, (file, t_s) in enumerate(zip(self.files, self.times_s, strict=True)):
            photo = Photo.open(file, f"{self.name}/{file.name}")
            try:
                photo = replace(photo, _pixels=photo.pixels(), path=None)
            except ProxemetryError:
                continue
            yield Frame(number, t_s, photo, number)


def _require_one_size(path: Path, photos: Sequence[Photo]) -> None:
    """Raise ClipError, before an hour is spent on them, where pictures are of several sizes: not of one camera."""
    counts = Counter((photo.width, photo.height) for photo in photos)
    (usual, _), *others = counts.most_common()
    if others:
        odd = next(photo for photo in photos if (photo.width, photo.height) != usual)
        count = sum(count for _, count in others) - 1
        more = f", and {count} more" if count else ""
        raise ClipError(
            f"{path}: {Path(odd.name).name} has {odd.width} x {odd.height} pixels{more}, most "
            f"have {usual[0]} x {usual[1]}: they are not of one camera; take out what does not belong"
        )


def _natural(path: Path) -> list[tuple[int, int | str]]:
    """Order names as people would: 2.jpg before 10.jpg."""
    return [(0, int(part)) if part.isdigit() else (1, part) for part in re.split(r"(\d+)", path.name.lower()) if part]


def _taken(photo: Photo) -> datetime | None:
    date = photo.metadata.about().date or ""
    for pattern in ("%Y-%m-%dT%H:%M:%S", "%Y-%m-%d %H:%M:%S", "%Y:%m:%d %H:%M:%S"):
        try:
            return datetime.strptime(date[:19], pattern)
        except ValueError:
            continue
    return None


def _increasing(taken: list[datetime | None]) -> list[float] | None:
    """Return seconds since the first, None where a picture has no time or two have the same: seconds are coarse."""
    known = [t for t in taken if t is not None]
    if len(known) < len(taken) or len(set(known)) < len(known):
        return None
    first = min(known)
    return [(t - first).total_seconds() for t in known]
