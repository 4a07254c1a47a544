"""The people of a camera's photos, frames or recordings, gathered for `proxemetry calibrate`."""

from __future__ import annotations

import argparse
import itertools
from collections.abc import Iterator
from pathlib import Path

from ..calibration.identity import linked
from ..calibration.people import LEAST_SEEN, Gathered, PeopleFit, from_people
from ..camera import Camera
from ..errors import PhotoError, SettingsError
from ..people import People, PoseBackend
from ..photo import Photo
from ..pose import backend_named
from ..pose.recorded import Recorded
from .named_pictures import CLIPS, FPS, MOST_FRAMES, first_photos, frames_of

#: Frames are linked together so many at a time: what is kept of a clip that never ends.
_AT_ONCE = 200


def people_fit(args: argparse.Namespace, camera: Camera, focal_known: bool) -> PeopleFit:
    """Return the camera that the people tell; raises SettingsError where there are no photos of them."""
    backend = backend_named(args.pose)
    gathered, following = Gathered(), False
    stream = _seen(args, backend, camera)
    number = 0
    while batch := list(itertools.islice(stream, _AT_ONCE)):
        following = batch[0][0] is not None
        times = [n if t is None else t for n, (t, _) in enumerate(batch)]
        frames = [people for _, people in batch]
        who = linked(frames, times) if following else [range(len(p)) for p in frames]
        highest = number
        for people, persons in zip(frames, who, strict=True):
            named = [number + int(k) for k in persons]
            gathered.add(people, named)
            highest = max([highest, *(n + 1 for n in named)])
            if not following:
                number = highest
        number = highest
    if not gathered.n_frames:
        raise SettingsError("give photos or a clip of the camera, or --points, --length, --homography, --height-m")
    return from_people(
        gathered,
        camera,
        focal_known=focal_known,
        recurring=not (following or args.different_people),
        least_seen=LEAST_SEEN if following else 1,
    )


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
