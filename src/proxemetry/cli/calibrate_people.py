"""The people of a camera's photos, frames or recordings, gathered for `proxemetry calibrate`."""

from __future__ import annotations

import argparse
import itertools
from collections.abc import Iterable, Iterator
from pathlib import Path

from ..calibration.people import LEAST_SEEN, Gathered, PeopleFit, from_people
from ..camera import Camera
from ..clip.camera import from_frames
from ..errors import PhotoError, SettingsError
from ..people import People, PoseBackend
from ..photo import Photo
from ..pose import backend_named
from ..pose.recorded import Recorded
from .named_pictures import CLIPS, FPS, MOST_FRAMES, first_photos, frames_of


def people_fit(args: argparse.Namespace, camera: Camera, focal_known: bool) -> PeopleFit:
    """Return the camera that the people determine; raises SettingsError where there are no photos of them."""
    stream = _seen(args, backend_named(args.pose), camera)
    first = next(stream, None)
    if first is None:
        raise SettingsError("give photos or a clip of the camera, or --points, --length, --homography, --height-m")
    frames = itertools.chain([first], stream)
    if first[0] is None:
        return _of_photos(frames, camera, focal_known, args.different_people)
    return of_frames([(now or 0.0, people) for now, people in frames], camera, focal_known)


def _of_photos(
    photos: Iterable[tuple[float | None, People]], camera: Camera, focal_known: bool, different_people: bool
) -> PeopleFit:
    """Return the camera from unordered photos: it is unknown who is in two of them."""
    gathered, met = Gathered(), 0
    for _, people in photos:
        gathered.add(people, range(met, met + len(people)))
        met += len(people)
    return from_people(gathered, camera, focal_known=focal_known, recurring=not different_people)


def of_frames(frames: list[tuple[float, People]], camera: Camera, focal_known: bool) -> PeopleFit:
    """Return the camera from frames that follow each other."""
    block = [people for _, people in frames], [now for now, _ in frames]
    return from_frames([block], camera, focal_known=focal_known, least_seen=LEAST_SEEN)


def _seen(args: argparse.Namespace, backend: PoseBackend, camera: Camera) -> Iterator[tuple[float | None, People]]:
    """Yield time (None where photos do not follow each other) and people of everything given, of one size."""
    if not args.paths and isinstance(backend, Recorded):
        photos: Iterator[tuple[float | None, Photo]] = (
            (None if args.fps is None else n / args.fps, backend.photo(name)) for n, name in enumerate(backend.photos)
        )
    else:
        photos = _photos(args)
    for now, photo in itertools.islice(photos, MOST_FRAMES):
        if (photo.width, photo.height) != (camera.width, camera.height):
            raise PhotoError(
                f"{photo.name} has {photo.width} x {photo.height} pixels, the first one {camera.width} x "
                f"{camera.height}: photos of one fixed camera have one size"
            )
        yield now, backend.detect(photo)


def _photos(args: argparse.Namespace) -> Iterator[tuple[float | None, Photo]]:
    number = 0
    for path in args.paths:
        if Path(path).suffix.lower() in CLIPS:
            yield from frames_of(Path(path), args.fps or FPS)
        else:
            for photo in first_photos([path]):
                yield None if args.fps is None else number / args.fps, photo
                number += 1
