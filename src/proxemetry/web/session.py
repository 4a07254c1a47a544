"""One review: the photos, what was corrected, and every question that the page asks."""

from __future__ import annotations

import json
import re
import shlex
import threading
from collections.abc import Callable, Collection, Hashable, Iterator, Mapping
from typing import Any

from ..archive.review.actions import Action
from ..archive.review.agreement import Agreement, agreement
from ..archive.review.corrections import FileKey, by_file, in_force
from ..archive.review.edits import applied
from ..archive.store.index import PhotoCard, card_of
from ..errors import CameraError, PhotoError, SettingsError
from ..scene import Scene
from .cache import LruCache
from .calibrating import Clicked, found, mount_of
from .gallery import FILTERS, Query, ordered
from .pictures import jpeg
from .stores import Store
from .tables_zip import tables_zip
from .view import scene_view, summary_view

PAGE_SIZE = 60
#: What a correction may also be kept for -> what photos share then, None where nothing is known.
SCOPES: dict[str, Callable[[PhotoCard], str | None]] = {"folder": lambda s: s.group, "camera": lambda s: s.camera}
#: What a camera's file may be called: nothing that leads elsewhere.
_CAMERA_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9_.-]{0,59}")
_SCENES_KEPT, _ORDERS_KEPT, _PICTURES_BYTES = 64, 8, 200_000_000


class Review:
    """The state of one review. All methods may be called from several threads.

    who: the name that corrections are kept under. faces: "blur" pixelates heads in every picture. blind: only one's
    own corrections are seen and applied, as two independent reviewers need it.
    """

    def __init__(self, store: Store, who: str, *, faces: str = "show", blind: bool = False) -> None:
        self.store, self.who, self.faces, self.blind = store, who, faces, blind
        self._lock = threading.RLock()
        self._pictures: LruCache[Hashable, bytes] = LruCache(_PICTURES_BYTES, len)
        self._measured: LruCache[str, Scene] = LruCache(_SCENES_KEPT)
        self._applied: LruCache[tuple[str | int, ...], Scene] = LruCache(_SCENES_KEPT)
        self._orders: LruCache[Query, list[int]] = LruCache(_ORDERS_KEPT)
        self._load()

    def _load(self) -> None:
        self._summaries = self.store.cards()
        self._actions = by_file(in_force(self.store.log.actions(who=self.who if self.blind else None)))
        if self.blind:  # the index shows all reviewers' corrections
            for number, summary in enumerate(self._summaries):
                if summary.corrections or summary.status == "excluded":
                    self._summaries[number] = card_of(self._scene(summary))
        self._orders.clear()

    def _key(self, summary: PhotoCard) -> FileKey:
        return FileKey(summary.sha256, "" if summary.sha256 else summary.photo)

    def _marks(self, summary: PhotoCard) -> frozenset[str]:
        return frozenset(a.action for a in self._actions.get(self._key(summary), ()))

    def _measured_scene(self, photo: str) -> Scene:
        return self._measured.get(photo, lambda: next(iter(self.store.scenes([photo]))))

    def _scene(self, summary: PhotoCard) -> Scene:
        return self._corrected(self._measured_scene(summary.photo))

    def _corrected(self, scene: Scene) -> Scene:
        """Return a measured scene with what is in force applied; the fit runs once for the same corrections."""
        actions = self._actions.get(FileKey.of(scene), ())
        key = (scene.photo, *(a.number for a in actions))
        return self._applied.get(key, lambda: applied(scene, actions))

    def _summary(self, number: int) -> PhotoCard:
        if not 0 <= number < len(self._summaries):
            raise LookupError(f"there is no photo number {number}")
        return self._summaries[number]

    def about(self) -> dict[str, Any]:
        """Return the content of the page's head and of its menus."""
        with self._lock:
            shown = [(s, self._marks(s)) for s in self._summaries]
            return {
                **self.store.about(),
                "who": self.who,
                "blind": self.blind,
                "photos": len(shown),
                "reviewed": sum("checked" in marks for _, marks in shown),
                "groups": sorted({s.group for s, _ in shown}),
                "counts": {name: sum(belongs(s, m) for s, m in shown) for name, belongs in FILTERS.items()},
                "page_size": PAGE_SIZE,
            }

    def page(self, query: Query, page: int) -> dict[str, Any]:
        """Return one page of the gallery; page 0 looks again at what belongs to it."""
        with self._lock:
            order = self._order(query, fresh=page == 0)
            shown = order[page * PAGE_SIZE : (page + 1) * PAGE_SIZE]
            cards = [summary_view(i, self._summaries[i], sorted(self._marks(self._summaries[i]))) for i in shown]
            return {"total": len(order), "page": page, "photos": cards}

    def _order(self, query: Query, fresh: bool = False) -> list[int]:
        """Return the photos of a query in their order, which stays while one walks through it and corrects."""
        if fresh:
            self._orders.put(query, ordered(query, self._summaries, self._marks))
        return self._orders.get(query, lambda: ordered(query, self._summaries, self._marks))

    def view(self, number: int, query: Query) -> dict[str, Any]:
        """Return everything about one photo, and its neighbours in the gallery's order."""
        with self._lock:
            summary = self._caught_up(number)
            order = self._order(query)
            place = order.index(number) if number in order else None
            return {
                **scene_view(self._scene(summary), self._actions.get(self._key(summary), ())),
                "id": number,
                "others": {scope: len(self.alike(number, scope)) for scope in SCOPES},
                "who": self.who,
                "place": place,
                "total": len(order),
                "previous": order[place - 1] if place else None,
                "next": order[place + 1] if place is not None and place + 1 < len(order) else None,
            }

    def act(self, number: int, action: str, value: Mapping[str, Any]) -> None:
        """Keep a correction; raises SettingsError for one that cannot be read or applied."""
        with self._lock:
            scene = self._measured_scene(self._caught_up(number).photo)
            if action == "undo":
                raise SettingsError("correction: undo has an address of its own")
            before = self._actions.get(FileKey.of(scene), [])
            draft, corrected = self.store.log.tried(scene, action, value, self.who, before)
            actions = [*before, self.store.log.keep(draft)]
            self._applied.put((scene.photo, *(a.number for a in actions)), corrected)  # the fit runs once
            self._take_in(number, scene, actions)

    def alike(self, number: int, scope: str) -> list[int]:
        """Return the other readable photos that share a photo's folder or camera.

        scope: one of `SCOPES`; raises SettingsError for another. Photos whose files name no camera share none.
        """
        if scope not in SCOPES:
            raise SettingsError(f"scope {scope!r} is unknown: use one of {', '.join(SCOPES)}")
        with self._lock:
            of = SCOPES[scope]
            own = of(self._summary(number))
            return [
                i for i, s in enumerate(self._summaries)
                if own is not None and i != number and s.status != "failed" and of(s) == own
            ]  # fmt: skip

    def undo(self, number: int) -> Action | None:
        """Take back one's own latest correction of a photo; return it."""
        with self._lock:
            scene = self._measured_scene(self._caught_up(number).photo)
            undone = self.store.log.undo(scene, self.who)
            if undone is not None:
                left = [a for a in self._actions.get(FileKey.of(scene), ()) if a.number != undone.number]
                self._take_in(number, scene, left)
            return undone

    def _caught_up(self, number: int) -> PhotoCard:
        """Return a photo's summary with what another reviewer, in a program of their own, did to it in the meantime."""
        key = self._key(self._summary(number))
        actions = in_force(self.store.log.actions(key, who=self.who if self.blind else None))
        if actions != self._actions.get(key, []):
            self._take_in(number, self._measured_scene(self._summary(number).photo), actions)
        return self._summary(number)

    def _take_in(self, number: int, scene: Scene, actions: list[Action]) -> None:
        self._actions[FileKey.of(scene)] = actions
        self._summaries[number] = card_of(self._corrected(scene))

    def calibrate(self, number: int, clicked: Clicked) -> dict[str, Any]:
        """Return what clicked points and lengths show about the camera of a photo, see `calibrating.found`.

        Input that determines no camera is answered with the status "problem": half of the clicks may be missing yet.
        """
        with self._lock:
            scene = self._scene(self._summary(number))
        try:
            return found(scene, clicked)
        except CameraError as error:
            return {"status": "problem", "text": str(error)}

    def save_camera(self, number: int, clicked: Clicked, name: str) -> dict[str, str]:
        """Write the camera found from points and lengths into the results folder; return where, and what to do next.

        Raises SettingsError for an impossible name, and where there is no folder; CameraError without a camera.
        """
        if not _CAMERA_NAME.fullmatch(name):
            raise SettingsError(
                f"{name!r:.60} is not a name for a camera: use letters, digits, dots, hyphens and underscores"
            )
        with self._lock:
            scene = self._scene(self._summary(number))
        mount = mount_of(scene, clicked)
        text = json.dumps(mount.to_dict(), indent=2, allow_nan=False) + "\n"
        file = self.store.save_camera(f"{name}.json", text.encode())
        return {"file": file, "measure": f"proxemetry measure PHOTOS --out RESULTS --mount {shlex.quote(file)}"}

    def picture(self, number: int, long_side_px: int) -> bytes:
        """Return a photo as JPEG without metadata; raises PhotoError where the file is gone or another one."""
        with self._lock:
            summary = self._summary(number)
            scene = self._measured_scene(summary.photo)
            # A person removed by hand stays pixelated too.
            blurred = (scene.people, self._scene(summary).people) if self.faces == "blur" else ()
        key = (number, long_side_px, *(people.keypoints_px.tobytes() for people in blurred))

        def make() -> bytes:
            photo = self.store.open_photo(summary.photo)
            if scene.sha256 and photo.sha256 != scene.sha256:
                raise PhotoError(
                    f"{summary.photo}: the file is not the one that was measured; run `proxemetry measure` again"
                )
            return jpeg(photo, long_side_px, blurred)

        return self._pictures.get(key, make)

    def added(self, photo: str) -> int:
        """Take in what the store has just got; return the number of one of its photos."""
        with self._lock:
            fresh = self.store.cards()
            self._summaries.extend(fresh[len(self._summaries) :])
            self._orders.clear()
            return next(i for i, s in enumerate(self._summaries) if s.photo == photo)

    def export(self) -> list[str]:
        """Write the corrected tables and the log; return the files' names."""
        with self._lock:
            return self.store.export()

    def tables(self) -> bytes:
        """Return the corrected tables as a zip archive, for photos that have no results folder."""
        with self._lock:
            return tables_zip(self._scene(summary) for summary in self._summaries)

    def agreement(self, one: str, other: str) -> Agreement:
        """Return how two reviewers of this log agree; raises SettingsError for names that are not in it."""
        with self._lock:
            known = self.store.log.people()
            for name in (one, other):
                if name not in known:
                    raise SettingsError(f"reviewer {name!r} is not in the log: it has {', '.join(known) or 'no names'}")
            log = self.store.log
            return agreement(one, log.actions(who=one), other, log.actions(who=other), self._scenes_of)

    def _scenes_of(self, files: Collection[FileKey]) -> Iterator[Scene]:
        """Yield the measured scenes of files."""
        return self.store.scenes([s.photo for s in self._summaries if self._key(s) in files])
