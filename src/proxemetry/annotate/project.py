"""One folder of annotations: the photos, the log of what was done, and the label files that follow from it."""

from __future__ import annotations

import threading
from collections.abc import Callable, Mapping, Sequence
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from ..archive.review.action_log import ActionLog
from ..archive.review.actions import Action
from ..archive.store.folder import Folder, is_url
from ..benchmark.labels import BODY_FILE, PHOTOS_FILE, TRUTH_FILE
from ..benchmark.validate_labels import Fault, check_labels
from ..errors import OutputError, SettingsError
from ..files import is_file, read_bytes
from ..people import PoseBackend
from ..pose import BACKENDS, backend_named, replays
from ..pose.recorded import Recorded
from .actions import apply, replayed
from .completing import completed, next_key
from .history import PROPOSE, REDO, UNDO, History, history
from .label_files import label_files
from .photos import OwnPhoto, find_own_photos
from .places import Places, remarks_on
from .proposals import proposed_people
from .starting import LabelFolder, is_label_folder, of_photo, recorded_people
from .state import Annotations, PhotoNotes

#: The log in the folder of annotations.
LOG_FILE = "annotations.sqlite"
#: What stands for no back end: every point is clicked.
NO_POSE = "none"


class AnnotationLog(ActionLog):
    """The log of annotations; see `ActionLog`."""

    what = "annotations"


class Project:
    """Annotations of photos, kept in a folder. All methods may be called from several threads.

    paths: photos, folders, globs. out: the folder. pose: the back end that proposes points, `NO_POSE` for none; it is
    loaded when first asked. who: the name that entries are kept under.

    Raises SettingsError where there are no photos, OutputError where the folder cannot be written or holds label files
    that were not made here.
    """

    def __init__(
        self, paths: Sequence[str], out: str, *, pose: str = "auto", who: str = "annotator",
        on_progress: Callable[[int, int], None] = lambda done, total: None,
    ) -> None:  # fmt: skip
        if is_url(out):
            raise SettingsError(f"{out}: annotations are kept in a folder on this machine")
        if pose not in ("auto", NO_POSE) and pose.partition(":")[0] not in BACKENDS:
            raise SettingsError(
                f"pose back end {pose!r} is unknown: use auto, {NO_POSE} or one of {', '.join(BACKENDS)}"
            )
        self.out, self.pose, self.who = Path(out), pose, who
        self._require_own()
        self.photos, self.left_out = find_own_photos(paths, out, on_progress)
        try:
            self.out.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise OutputError(f"{out}: cannot be created as a folder ({error.strerror})") from error
        self._lock = threading.RLock()
        # Networks are loaded when the first photo is opened; what can be checked at once is.
        self._backend: PoseBackend | None = backend_named(pose) if replays(pose) else None
        self._looking = threading.Lock()
        self.log = AnnotationLog(self.out / LOG_FILE)
        self._entries: list[Action] = []
        #: How many entries of the log cannot be followed any more.
        self.lost = 0
        self.now, self._history = Annotations(), history(())
        self._catch_up()
        self.write()

    def _require_own(self) -> None:
        foreign = [name for name in (BODY_FILE, TRUTH_FILE, PHOTOS_FILE) if is_file(self.out / name)]
        if foreign and not is_file(self.out / LOG_FILE):
            raise OutputError(
                f"{self.out}: {foreign[0]} there was not made by annotate, which would overwrite it; name another --out"
            )

    @property
    def files(self) -> list[str]:
        """The hashes of all photos."""
        return [photo.sha256 for photo in self.photos]

    @property
    def history(self) -> History:
        """What may be undone and redone."""
        return self._history

    def photo(self, identity: int) -> OwnPhoto:
        """Return a photo by its number; raises LookupError."""
        if not 0 <= identity < len(self.photos):
            raise LookupError(f"there is no photo number {identity}")
        return self.photos[identity]

    def notes(self, identity: int) -> PhotoNotes:
        """Return what is annotated on a photo."""
        with self._lock:
            return self.now.photo(self.photo(identity).sha256)

    # What is done

    def act(self, identity: int | None, action: str, value: Mapping[str, Any]) -> None:
        """Keep an action, of a photo where it belongs to one; raises SettingsError for one that cannot be followed."""
        if action in (UNDO, REDO, PROPOSE):
            raise SettingsError(f"annotation: {action} has an address of its own")
        with self._lock:
            self._catch_up()
            photo = None if identity is None else self.photo(identity)
            if photo is not None:
                value = completed(photo, action, value, self.photos, self._next_key(photo))
            self._keep(photo, action, value)
            self.write()

    def _next_key(self, photo: OwnPhoto) -> int:
        return next_key(photo, self._entries)

    def propose(self, identity: int) -> None:
        """Run the back end on a photo and add the people that it finds, once; raises what back ends raise."""
        photo = self.photo(identity)
        with self._looking:  # one photo after the other: a network uses all cores
            if self.pose == NO_POSE or self.notes(identity).proposed is not None:
                return
            if self._backend is None:
                self._backend = backend_named(self.pose)
            people = self._backend.detect(photo.photo)
            with self._lock:
                self._catch_up()
                listed = proposed_people(people, photo.width, photo.height, self._next_key(photo))
                self._keep(photo, PROPOSE, {"pose": self._backend.name[:100], "people": listed})

    def start_from(self, path: str) -> tuple[int, int]:
        """Take in the labels of another tool on every photo that has none yet; return how many photos and people.

        path: a keypoint file or folder, or a folder of the benchmark's label files. Raises SettingsError,
        KeypointsError or LabelsError where it cannot be used or names none of the photos.
        """
        with self._lock:
            self._catch_up()
            return self._from_label_folder(path) if is_label_folder(path) else self._from_keypoints(path)

    def _from_keypoints(self, path: str) -> tuple[int, int]:
        recorded = Recorded(path, keep_beside=True)
        names = [photo.name for photo in self.photos]
        if not any(map(recorded.names, names)):
            raise SettingsError(f"{path}: names none of the {len(names)} photos, but {', '.join(recorded.photos[:2])}")
        counts: list[int] = []
        named = {"pose": Path(path).name[:100]}
        for photo in self._untouched():
            people = recorded_people(recorded, photo, self._next_key(photo))
            if people is not None:
                self._keep(photo, PROPOSE, {**named, "people": people, "read": of_photo(recorded, photo)})
                counts.append(len(people))
        self.write()
        return len(counts), sum(counts)

    def _from_label_folder(self, path: str) -> tuple[int, int]:
        found = LabelFolder(path)
        labelled = [(photo, image) for photo in self.photos if (image := found.image(photo)) is not None]
        if not labelled:
            raise SettingsError(f"{path}: names none of the {len(self.photos)} photos")
        fresh = {photo.sha256 for photo in self._untouched()}
        labelled = [(photo, image) for photo, image in labelled if photo.sha256 in fresh]
        known = {(n, tag) for n in self.now.shoots for tag in self.now.shoot(n).spots}
        for photo, image in labelled:
            people = found.people(photo, image, self._next_key(photo))
            self._keep(photo, PROPOSE, {"pose": Path(path).name[:100], "people": people})
            for action, value in found.photo_actions(photo, image, self.now.photo(photo.sha256)):
                self._keep(photo, action, value)
        for action, value in found.shoot_actions({image.shoot for _, image in labelled}):
            if (value["shoot"], value.get("tag")) not in known:  # what was measured here stays
                self._keep(None, action, value)
        self.write()
        return len(labelled), sum(len(image) for _, image in labelled)

    def _untouched(self) -> list[OwnPhoto]:
        """Return the photos on which no one has been marked or proposed yet."""
        notes = {photo.sha256: self.now.photo(photo.sha256) for photo in self.photos}
        return [p for p in self.photos if notes[p.sha256].proposed is None and not notes[p.sha256].people]

    def undo(self) -> Action | None:
        """Take back the latest action, whatever photo it was on; return it, None where there is none."""
        return self._step(UNDO, lambda: self._history.undoable)

    def redo(self) -> Action | None:
        """Bring back what was last taken back."""
        return self._step(REDO, lambda: self._history.redoable)

    def _step(self, name: str, what: Callable[[], Action | None]) -> Action | None:
        with self._lock:
            self._catch_up()
            action = what()
            if action is not None:
                self._append(Action(0, _time(), self.who, action.photo, action.sha256, name, {}))
                self._recount()
                self.write()
            return action

    def _keep(self, photo: OwnPhoto | None, action: str, value: Mapping[str, Any]) -> None:
        name, sha256 = ("", "") if photo is None else (photo.name, photo.sha256)
        draft = Action(0, _time(), self.who, name, sha256, action, dict(value))
        try:
            after = apply(self.now, draft)
        except (TypeError, AttributeError, KeyError) as error:
            raise SettingsError(f"annotation: {action} does not hold what it needs") from error
        self._append(draft)
        self.now, self._history = after, history(self._entries)

    def _append(self, draft: Action) -> None:
        self._entries.append(self.log.keep(draft))

    def _catch_up(self) -> None:
        """Take in what another program that has the same folder open wrote meanwhile."""
        entries = self.log.actions()
        if len(entries) != len(self._entries):
            self._entries = entries
            self._recount()

    def _recount(self) -> None:
        self._history = history(self._entries)
        self.now, lost = replayed(self._history.in_force)
        self.lost = len(lost)

    # What follows from it

    def places(self, shoot: int) -> Places:
        """Return where everyone in a shoot was."""
        with self._lock:
            return self.now.places(shoot, self.files)

    def write(self) -> list[str]:
        """Write the label files that changed, each whole or not at all; return the names of all that are there."""
        with self._lock:
            shoots = self.now.shoot_numbers(self.files)
            files = label_files(self.now, self.photos, {n: self.places(n) for n in shoots})
            folder = Folder(str(self.out))
            for name, content in files.items():
                path = self.out / name
                if content is None:
                    path.unlink(missing_ok=True)
                elif not is_file(path) or read_bytes(path) != content:
                    folder.write(name, content)
            return [name for name, content in files.items() if content is not None]

    def check(self) -> list[Fault]:
        """Write the files and return every fault of theirs, as `proxemetry score --check` does."""
        with self._lock:
            self.write()
            return check_labels(self.out)

    def doubts(self) -> list[str]:
        """Return what is wrong with the places of each shoot, which no check of the files can see."""
        with self._lock:
            return [
                f"shoot {number}: {remark.text}"
                for number in self.now.shoot_numbers(self.files)
                for remark in remarks_on(self.places(number))
                if remark.problem
            ]

    def close(self) -> None:
        """Close the log."""
        self.log.close()


def _time() -> str:
    return datetime.now(UTC).isoformat(timespec="seconds")
