"""The people of a camera's photos, frames or recordings, gathered for `proxemetry calibrate`."""

from __future__ import annotations

import argparse
import itertools
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ..calibration.identity import linked
from ..calibration.people import LEAST_SEEN, OPEN_FOCAL, Gathered, PeopleFit, from_people
from ..camera import Camera
from ..clip.floor_identity import followed
from ..errors import CameraError, PhotoError, SettingsError
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
    """Return the camera from frames that follow each other.

    People are followed by their boxes first. Unless they leave the focal length open, the camera found from them is
    good enough to follow them over the floor, which loses fewer of them behind others, and they are asked again.
    """
    times, seen = [now for now, _ in frames], [people for _, people in frames]
    fit = _of_people_followed(seen, linked(seen, times), camera, focal_known)
    if not focal_known and fit.mount.sd[3] > OPEN_FOCAL:
        return fit
    try:
        return _of_people_followed(seen, followed(seen, times, fit.mount), camera, focal_known)
    except CameraError:  # no person could be followed so
        return fit


def _of_people_followed(
    frames: Sequence[People], who: Sequence[NDArray[np.intp]], camera: Camera, focal_known: bool
) -> PeopleFit:
    gathered = Gathered()
    for people, persons in zip(frames, who, strict=True):
        gathered.add(people, persons.tolist())
    return from_people(gathered, camera, focal_known=focal_known, least_seen=LEAST_SEEN)


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
