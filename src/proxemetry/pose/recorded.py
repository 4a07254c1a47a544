"""A back end that replays keypoint files, whatever program found the people."""

from __future__ import annotations

import hashlib
import os
import re
import unicodedata
from collections.abc import Iterable, Mapping
from dataclasses import replace
from itertools import islice
from pathlib import Path, PurePosixPath
from types import MappingProxyType

import numpy as np

from ..camera import Camera
from ..errors import KeypointsError, PhotoError, SettingsError
from ..files import is_file, is_whole, read_bytes, readable_name, reason_of, sha256_of
from ..people import People
from ..people.skeleton import COCO_17, Skeleton
from ..photo import Photo
from . import PoseOptions
from .formats import Beside, RecordedPhoto, read
from .turned import is_unturned, upright

#: How far the aspect ratios of a photo and of the photo in the file may be apart: what rounding a resize makes.
_ASPECT_TOLERANCE = 0.02
#: COCO's photos are called by their id. Numbers at the end of other names count something else.
#: Label Studio puts eight digits before the name of a photo that is uploaded.
_UPLOADED = re.compile(r"^[0-9a-f]{8}-")
_COCO_NAME = re.compile(r"(?:^|^COCO_\w+_)(\d+)$")


class Recorded:
    """Keypoints of a file or folder (see `formats`), found again by the photo's name.

    A photo is the recording of the same name, else of the same file name, else of the same name without ending, else
    of COCO's image id where that is its name: 139.jpg, 000000000139.jpg, or COCO_val2014_000000000139.jpg.
    """

    def __init__(self, path: str | Path, *, keep_beside: bool = False) -> None:
        """Read a file or folder. keep_beside: with what is not used of it, which takes several times the memory."""
        self._path = Path(path)
        recordings = read(self._path)
        if not keep_beside:
            recordings = replace(recordings, photos=tuple(replace(r, beside=Beside()) for r in recordings.photos))
        self._lists_empty = recordings.lists_empty
        self._by_name = _by_unique_name(self._path, recordings.photos)
        self._by_base = _unless_shared((PurePosixPath(name).name, r) for name, r in self._by_name.items())
        self._by_stem = _unless_shared((PurePosixPath(name).stem, r) for name, r in self._by_name.items())
        self._by_upload = _unless_shared(
            (_UPLOADED.sub("", PurePosixPath(name).name), r)
            for name, r in self._by_name.items()
            if _UPLOADED.match(PurePosixPath(name).name)
        )
        self._by_number = {r.number: r for r in recordings.photos if r.number is not None}
        self.name = f"recorded:{self._path.name}"
        # A recording stands where other back ends have networks: its content is what the results were made of.
        self.models: Mapping[str, str] = MappingProxyType({self._path.name: _digest(self._path)})
        skeletons = {r.people.skeleton.name: r.people.skeleton for r in recordings.photos if len(r.people)}
        if len(skeletons) > 1:
            raise KeypointsError(f"{self._path}: several skeletons in one recording ({', '.join(skeletons)}); split it")
        self.skeleton: Skeleton = next(iter(skeletons.values()), COCO_17)

    @property
    def photos(self) -> tuple[str, ...]:
        """The photos' names, as recorded, in the file's order."""
        return tuple(self._by_name)

    def photo(self, name: str) -> Photo:
        """Return a recorded photo without its pixels; raises PhotoError where the recording does not state its size."""
        recording = self._recording(name)
        if recording is None or recording.width is None or recording.height is None or recording.width <= 1:
            raise PhotoError(f"{name}: {self._path} does not state how large the photo is; give the photos too")
        digest = hashlib.sha256(f"{self.name}/{recording.photo}".encode()).hexdigest()
        return Photo(name, int(recording.width), int(recording.height), digest)

    def camera_of(self, photo: Photo) -> Camera | None:
        """Return the camera that the file gives for a photo, in its full-size pixels, or None."""
        recording = self._recording(photo.name)
        if recording is None or recording.camera is None:
            return None
        return recording.camera.resized(photo.width, photo.height)

    def detect(self, photo: Photo) -> People:
        """Return the people recorded for a photo, in its full-size pixels.

        Raises KeypointsError where the recording has no such photo, or one of another shape.
        """
        recording = self._recording(photo.name)
        if recording is None:
            if not self._lists_empty:
                return People.none(self.skeleton)  # a results file names only photos with people
            raise KeypointsError(f"{photo.name}: not among the {len(self._by_name)} photos of {self._path}")
        people = recording.people if len(recording.people) else People.none(self.skeleton)
        where = f"{photo.name}: its keypoints in {self._path}"
        if recording.width is None or recording.height is None:
            people = upright(people, photo, None, where)
            self._refuse_larger(people, photo)
            return people
        if recording.width == 1:
            return upright(people.scaled(photo.width, photo.height), photo, None, where)
        if is_unturned(photo, recording.width, recording.height):
            return upright(people, photo, (recording.width, recording.height), where)
        if not _same_shape(recording, photo):
            raise KeypointsError(
                f"{photo.name}: is {photo.width} x {photo.height}, but its keypoints in {self._path} are of "
                f"{recording.width:.0f} x {recording.height:.0f} (turned or cropped?)"
            )
        return people.scaled(photo.width / recording.width, photo.height / recording.height)

    def beside(self, photo: Photo) -> Beside:
        """Return what the file has of a photo and is not used, in the photo's full-size pixels, where it was kept.

        What is known to be pixels is left out where the tool saw the photo unturned. Raises what `detect` raises.
        """
        recording = self._recording(photo.name)
        if recording is None:
            return Beside()
        now = self.detect(photo).keypoints_px
        if np.array_equal(now, recording.people.keypoints_px, equal_nan=True):
            return recording.beside
        width, height = recording.width, recording.height
        if width is None or height is None or is_unturned(photo, width, height):
            return recording.beside.scaled(None)
        return recording.beside.scaled((photo.width / width, photo.height / height))

    def names(self, photo: str) -> bool:
        """Return whether the recording has a photo of that name."""
        return self._recording(photo) is not None

    def why_no_people(self, photo: Photo) -> str | None:
        """Return a message on a photo that the file does not name, None where it does: is it another photo's file?"""
        if self._recording(photo.name) is not None:
            return None
        if self._path.is_dir():
            return (
                f"no people recorded: {self._path.name} has no file for it, as tools write none where they find no one"
            )
        return f"no people recorded: {self._path.name} names only photos with people ({self._some()}), and not this one"

    def require_any(self, names: Iterable[str]) -> None:
        """Raise KeypointsError where none of the photos is recorded, though no photo need be: it is another's file."""
        if self._lists_empty or not self._by_name:
            return
        count = 0
        for name in names:
            if self._recording(name) is not None:
                return
            count += 1
        photos = "the photo is not" if count == 1 else f"not one of the {count} photos is"
        raise KeypointsError(f"{self._path}: {photos} named in it; it names {self._some()}")

    def _some(self) -> str:
        return (", ".join(islice(self._by_name, 2)) or "none") + (", ..." if len(self._by_name) > 2 else "")

    def _refuse_larger(self, people: People, photo: Photo) -> None:
        """Refuse pixels of a larger copy where no size is stated: no person is seen wholly outside a photo."""
        for number, points in enumerate(people.keypoints_px):
            seen = points[np.isfinite(points).all(axis=-1)]
            if not len(seen) or (seen <= (photo.width, photo.height)).all(axis=-1).any():
                continue
            raise KeypointsError(
                f"{photo.name}: person {number} in {self._path} is entirely outside its {photo.width} x "
                f"{photo.height} pixels: the keypoints are another photo's, or a larger copy's; state its size there"
            )

    def _recording(self, name: str) -> RecordedPhoto | None:
        path = PurePosixPath(unicodedata.normalize("NFC", name.replace("\\", "/")))
        found = (
            self._by_name.get(str(path))
            or self._by_base.get(path.name)
            or self._by_stem.get(path.stem)
            or self._by_upload.get(path.name)
        )
        if found is None and (digits := _COCO_NAME.search(path.stem)):
            found = self._by_number.get(int(digits[1]))
        return found


def _digest(path: Path) -> str:
    """Return the SHA-256 of a recording: of the file, or of all names and files of a folder."""
    try:
        if not path.is_dir():
            return sha256_of(path)
        digest = hashlib.sha256()
        for file in sorted(p for p in path.rglob("*") if is_file(p)):
            content = read_bytes(file)
            name = os.fsencode(file.relative_to(path).as_posix())
            digest.update(name + f"\n{len(content)}\n".encode() + content)
        return digest.hexdigest()
    except OSError as error:
        raise KeypointsError(f"{error.filename or path}: cannot be read ({reason_of(error)})") from error


def open_backend(argument: str, options: PoseOptions) -> Recorded:
    """Return the back end of `recorded:FILE`."""
    if not argument:
        raise SettingsError("--pose recorded needs a file or folder of keypoints: recorded:FILE")
    return Recorded(argument)


def _by_unique_name(path: Path, recordings: tuple[RecordedPhoto, ...]) -> dict[str, RecordedPhoto]:
    answer: dict[str, RecordedPhoto] = {}
    for recording in recordings:
        name = _name_of(recording)
        if name in answer:
            raise KeypointsError(f"{path}: the photo {name} is in it twice")
        answer[name] = replace(recording, photo=name)
    return answer


def _name_of(recording: RecordedPhoto) -> str:
    """Return a recorded photo's name as tables hold it; the names of OpenPose's files may be bytes that are no text."""
    if "\0" in recording.photo:
        raise KeypointsError(f"the photo {recording.photo!r:.80} has a zero byte in its name")
    # A Mac writes accents apart from their letters; the same name looks the same.
    name = unicodedata.normalize("NFC", recording.photo.replace("\\", "/"))
    return name if is_whole(name) else readable_name(name)


def _unless_shared(named: Iterable[tuple[str, RecordedPhoto]]) -> dict[str, RecordedPhoto]:
    """Return what each name stands for where it stands for one photo only: a/1.jpg and b/1.jpg are two."""
    answer: dict[str, RecordedPhoto] = {}
    shared: set[str] = set()
    for name, recording in named:
        if name in answer:
            shared.add(name)
        answer[name] = recording
    return {name: recording for name, recording in answer.items() if name not in shared}


def _same_shape(recording: RecordedPhoto, photo: Photo) -> bool:
    assert recording.width is not None and recording.height is not None
    ratio = (photo.width / photo.height) / (recording.width / recording.height)
    return abs(ratio - 1) < _ASPECT_TOLERANCE
