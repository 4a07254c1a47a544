"""Where the photos that are reviewed come from: a results folder, or photos dropped onto the page."""

from __future__ import annotations

import csv
import io
import json
import os
import threading
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import Any, Protocol

from ..archive.review.actions import Action
from ..archive.review.corrections import FILE, Log
from ..archive.store.folder import is_url
from ..archive.store.index import PhotoCard, card_of, cards
from ..archive.store.results import Results
from ..archive.store.scratch import scratch_folder, sweep_scratch
from ..errors import PhotoError, SettingsError
from ..files import cell_of
from ..measure import measure
from ..photo import Photo
from ..scene import Scene
from ..tables import CORRECTIONS

#: A dropped photo may have this many pixels; a file of a few bytes may claim more than the memory holds.
MOST_PIXELS = 120_000_000
#: Folder of the results that cameras found on the page are kept in.
CAMERAS = "cameras"


class Store(Protocol):
    """Photos under review."""

    @property
    def log(self) -> Log:
        """The log of corrections."""
        ...

    def about(self) -> dict[str, Any]:
        """Return what the page shows about all of them."""
        ...

    def cards(self) -> list[PhotoCard]:
        """Return what is known of each at a glance."""
        ...

    def scenes(self, photos: Iterable[str] | None) -> Iterator[Scene]:
        """Yield scenes as measured."""
        ...

    def open_photo(self, photo: str) -> Photo:
        """Return a photo; raises PhotoError where its file is not there."""
        ...

    def export(self) -> list[str]:
        """Write the corrected tables and the log; return the files' names."""
        ...

    def save_camera(self, name: str, content: bytes) -> str:
        """Write a camera's file; return where it is."""
        ...


class FolderStore:
    """A results folder on this machine."""

    def __init__(self, location: str) -> None:
        if is_url(location):
            raise SettingsError(f"{location}: a review needs a results folder on this machine; copy it here first")
        self.results = Results.open(location)
        place = Path(self.results.folder.location)
        self.log = Log(place / FILE, read_only=not os.access(place, os.W_OK))
        self._locations = self.results.locations()

    def about(self) -> dict[str, Any]:
        """Return where it is and what was run."""
        run = self.results.run
        return {
            "mode": "folder",
            "folder": self.results.folder.location,
            "version": run.get("version"),
            "pose": run.get("pose"),
            "method": (run.get("settings") or {}).get("method"),
        }

    def cards(self) -> list[PhotoCard]:
        """Return all photos' cards."""
        return cards(self.results)

    def scenes(self, photos: Iterable[str] | None) -> Iterator[Scene]:
        """Yield scenes as measured."""
        return self.results.scenes(photos, corrected=False)

    def open_photo(self, photo: str) -> Photo:
        """Return a photo from where the run found it."""
        location = self._locations.get(photo)
        if location is None or is_url(location):
            raise PhotoError(f"{photo}: the photo itself is not on this machine")
        return Photo.open(location, photo)

    def export(self) -> list[str]:
        """Rewrite the tables, corrections applied, and the log as `corrections.csv`."""
        run = self.results.run
        self.results.write_tables(run.get("safe_distance_m"))
        self.results.folder.write("corrections.csv", log_csv(self.log.actions()))
        return ["photos.csv", "people.csv", "pairs.csv", "corrections.csv"]

    def save_camera(self, name: str, content: bytes) -> str:
        """Write a camera's file into the folder `cameras` of the results; return its path."""
        self.results.folder.write(f"{CAMERAS}/{name}", content)
        return self.results.folder.path(f"{CAMERAS}/{name}")


class DropStore:
    """Photos dropped onto the page: measured here, kept until the page is closed down."""

    def __init__(self, measure_photo: Callable[[Photo], Scene] = measure) -> None:
        self.log = Log(":memory:")
        self._measure = measure_photo
        self._scenes: dict[str, Scene] = {}
        self._files: dict[str, Path] = {}
        self._lock, self._labels = threading.Lock(), set[str]()
        sweep_scratch()
        self._folder = scratch_folder("review")

    def about(self) -> dict[str, Any]:
        """Return that there is no folder."""
        return {"mode": "drop", "folder": None, "version": None, "pose": None, "method": None}

    def cards(self) -> list[PhotoCard]:
        """Return the cards in the order of arrival."""
        with self._lock:
            scenes = list(self._scenes.values())
        return [card_of(scene) for scene in scenes]

    def scenes(self, photos: Iterable[str] | None) -> Iterator[Scene]:
        """Yield scenes as measured."""
        wanted = None if photos is None else set(photos)
        with self._lock:
            scenes = list(self._scenes.items())
        return (s for name, s in scenes if wanted is None or name in wanted)

    def open_photo(self, photo: str) -> Photo:
        """Return a dropped photo."""
        return Photo.open(self._files[photo], photo)

    def export(self) -> list[str]:
        """There is no folder to write to."""
        raise SettingsError("dropped photos have no results folder: run `proxemetry measure` and review its results")

    def save_camera(self, name: str, content: bytes) -> str:
        """There is no folder to write to."""
        raise SettingsError("dropped photos have no results folder: download the camera instead")

    def add(self, content: bytes, name: str) -> str:
        """Measure a dropped photo and return its name here; raises PhotoError for anything but a photo.

        The file gets a name of our own: what the browser calls it is only shown.
        """
        label = " ".join(name.replace("\\", "/").rpartition("/")[2].split())[:200] or "photo"
        photo, path = self._reserved(label)
        try:
            path.write_bytes(content)
            opened = Photo.open(path, photo)
            if opened.width * opened.height > MOST_PIXELS:
                raise PhotoError(
                    f"{photo}: {opened.width} x {opened.height} pixels are more than this page takes "
                    f"({MOST_PIXELS // 1_000_000} megapixels); `proxemetry measure` takes larger ones"
                )
            scene = self._measure(opened)
        except PhotoError as error:  # of the name that its owner knows, not of ours
            path.unlink(missing_ok=True)
            raise PhotoError(str(error).replace(str(path), photo)) from error
        except Exception:
            path.unlink(missing_ok=True)
            raise
        with self._lock:  # in the order of arrival
            self._files[photo], self._scenes[photo] = path, scene
        return photo

    def _reserved(self, label: str) -> tuple[str, Path]:
        """Return a name and a file for one more photo that no other has, nor gets while this one is measured."""
        with self._lock:
            number = len(self._labels)
            photo = label
            while photo in self._labels:
                number += 1
                photo = f"{label} ({number})"
            self._labels.add(photo)
            return photo, Path(self._folder.name) / f"{len(self._labels):06d}.photo"

    def close(self) -> None:
        """Remove the dropped photos."""
        self._folder.cleanup()


def log_csv(actions: Iterable[Action]) -> bytes:
    """Return a log as CSV: every entry, those taken back and the taking back included."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(column.name for column in CORRECTIONS)
    for a in actions:
        value = json.dumps(dict(a.value), sort_keys=True, ensure_ascii=False)
        writer.writerow((a.number, *map(cell_of, (a.time, a.who, a.photo, a.sha256, a.action, value))))
    return text.getvalue().encode()
