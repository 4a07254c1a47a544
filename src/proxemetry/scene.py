"""Everything known about one photo, as one value with a versioned JSON form.

The JSON form holds what was observed and fitted; distances follow from it and are computed again on reading.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from .arrays import FloatArray
from .bodies import Bodies
from .camera import CameraEstimate
from .distances import Distances, measure_distances
from .errors import OutputError, ProxemetryError
from .people import People
from .people.doubts import PersonDoubt, doubts_of
from .people.skeleton import COCO_17
from .photo.about import About
from .proxemics import Proxemics, measure_proxemics
from .scene_json import (
    bodies_from_dict,
    bodies_to_dict,
    camera_from_dict,
    camera_to_dict,
    none_if_nan,
    people_from_dict,
    people_to_dict,
)  # fmt: skip
from .settings import Settings

#: Name and version of the JSON form; the version changes when the meaning of a field does.
SCHEMA = "proxemetry.scene/2"

#: A photo's status: measured (with any number of people), no camera known, not readable, or excluded by a reviewer.
STATUSES = ("ok", "no_camera", "failed", "excluded")

if TYPE_CHECKING:
    import pandas
    from matplotlib.figure import Figure

    from .photo import Photo


@dataclass(frozen=True)
class Provenance:
    """What made a scene, apart from its settings.

    version: of the package. pose: the back end. models: sha256 of its files by name. camera_table: name and hash of
    the camera table, "" where there was none.
    """

    version: str = ""
    pose: str = ""
    models: Mapping[str, str] = field(default_factory=dict[str, str])
    camera_table: str = ""


@dataclass(frozen=True)
class Review:
    """Corrections made to a scene by hand, if any.

    corrections: how many corrections are in its numbers. kinds: of all that was done ("checked" and "note" included),
    sorted. who: the reviewers, sorted. note: the last remark.
    """

    corrections: int
    kinds: tuple[str, ...]
    who: tuple[str, ...]
    note: str | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "kinds", tuple(self.kinds))
        object.__setattr__(self, "who", tuple(self.who))


@dataclass(frozen=True, eq=False)
class Scene:
    """One photo's people, their positions and distances, and the origin of every number.

    photo: its name. sha256: of the file. width_px, height_px: upright full size. status: one of `STATUSES`, with the
    reason for any but "ok". camera: the estimate with all candidates. settings: those of the run, without its
    camera table. about: the photo's own metadata. review: None where it was not reviewed. Row i of
    `people`, of `bodies` and of every distance is the same person.
    """

    photo: str
    sha256: str
    width_px: int
    height_px: int
    status: str
    reason: str | None
    camera: CameraEstimate
    people: People
    bodies: Bodies
    settings: Settings = field(default_factory=Settings)
    made_by: Provenance = Provenance()
    about: About = field(default_factory=About)
    review: Review | None = None
    seconds: float = math.nan

    def __post_init__(self) -> None:
        if self.status not in STATUSES:
            raise OutputError(f"status {self.status!r} of a scene is unknown: it is one of {', '.join(STATUSES)}")

    @classmethod
    def failed(
        cls, photo: str, reason: str, sha256: str = "", *, settings: Settings | None = None,
        made_by: Provenance | None = None,
    ) -> Scene:  # fmt: skip
        """Return the scene of a photo that could not be read."""
        return cls(
            photo, sha256, 0, 0, "failed", reason, CameraEstimate(None, reason=reason), People.none(COCO_17),
            Bodies.unplaced(0, "", reason), settings or Settings(), made_by or Provenance(),
        )  # fmt: skip

    def __len__(self) -> int:
        return len(self.people)

    def __repr__(self) -> str:
        """The scene in one line: of the arrays only how many people they are about."""
        focal = "unknown" if self.camera.camera is None else f"{self.camera.camera.f_px:.0f} px"
        pairs = self.distances.below(math.inf)
        return f"Scene({self.photo!r}, {self.status}: {len(self)} people, {pairs} distances, focal length {focal})"

    @cached_property
    def distances(self) -> Distances:
        """Every pair's distance with intervals and zones."""
        return measure_distances(self.bodies)

    @cached_property
    def proxemics(self) -> Proxemics:
        """Nearest others, viewing angles, shot sizes and how people are turned to one another."""
        return measure_proxemics(self.people, self.bodies, self.distances, self.camera.camera, self.height_px)

    @cached_property
    def possible_duplicates(self) -> NDArray[np.bool_]:
        """Shape (P,): which people may be others found a second time."""
        return np.array([PersonDoubt.POSSIBLE_DUPLICATE in reasons for reasons in self.doubts], dtype=bool)

    @cached_property
    def doubts(self) -> tuple[tuple[PersonDoubt, ...], ...]:
        """Why each person may not be a person, or may be found twice; nothing for most. No one is left out for it."""
        return doubts_of(self.people)

    @property
    def distances_m(self) -> FloatArray:
        """Shape (P, P): metres on the ground plane (in space where gravity is unknown); NaN where unknown."""
        return self.distances.distance_m

    @property
    def positions_m(self) -> FloatArray:
        """Shape (P, 3): the middle of each torso in the camera frame (x right, y down, z forward)."""
        return self.bodies.positions_m

    def renamed(self, photo: str) -> Scene:
        """Return the same scene under another photo's name: a copy of the same file."""
        return replace(self, photo=photo)

    # For notebooks: each only calls what stands above it, loaded when it is asked for.

    def people_frame(self) -> pandas.DataFrame:
        """Return the people as a data frame with the columns of `people.csv`; needs the extra `notebook`."""
        from .display import frame

        return frame("people", self)

    def pairs_frame(self) -> pandas.DataFrame:
        """Return the pairs as a data frame with the columns of `pairs.csv`; needs the extra `notebook`."""
        from .display import frame

        return frame("pairs", self)

    def plot(self, photo: Photo | str | Path | None = None, *, faces: str = "show", all_pairs: bool = False) -> Figure:
        """Return the figure of `plots.overlay`; photo: its file, looked for under the scene's own name where None.

        Raises SettingsError where matplotlib is missing, PhotoError where the named photo cannot be read or is another.
        """
        from .plots import overlay, photo_of

        return overlay(self, photo_of(self, photo), faces=faces, all_pairs=all_pairs)

    def _repr_html_(self) -> str:
        """Return what a notebook shows: the scene in a line and its pairs, nearest first."""
        from .display import html

        return html(self)

    def to_json(self) -> str:
        """Return the scene as one line of JSON; missing numbers are null."""
        return json.dumps(_scene_to_dict(self), allow_nan=False, separators=(",", ":"))

    @classmethod
    def from_json(cls, text: str) -> Scene:
        """Read what `to_json` wrote; raises OutputError for any other text or another schema."""
        try:
            fields = json.loads(text)
            schema = fields["schema"]
        except (ValueError, KeyError, TypeError) as error:
            raise OutputError(f"not a scene of proxemetry ({error})") from error
        if schema != SCHEMA:
            raise OutputError(
                f"scene of schema {schema!r}: this version reads {SCHEMA!r}; measure the photo again, for a results "
                "folder with --restart"
            )
        try:
            return _scene_from_dict(fields)
        except (KeyError, ValueError, TypeError, AttributeError, ProxemetryError) as error:
            why = f"{error} is missing" if isinstance(error, KeyError) else str(error)
            whose = f"the scene of {fields['photo']!r}" if fields.get("photo") else "a scene"
            raise OutputError(
                f"{whose} was written by another version of proxemetry, or is damaged "
                f"({why}); measure the photo again: for a results folder, `proxemetry measure` with --restart"
            ) from error


def _scene_to_dict(scene: Scene) -> dict[str, Any]:
    return {
        "schema": SCHEMA,
        "photo": scene.photo,
        "sha256": scene.sha256,
        "width_px": scene.width_px,
        "height_px": scene.height_px,
        "status": scene.status,
        "reason": scene.reason,
        "camera": camera_to_dict(scene.camera),
        "people": people_to_dict(scene.people),
        "bodies": bodies_to_dict(scene.bodies),
        "settings": scene.settings.to_dict(),
        "made_by": asdict(scene.made_by),
        "about": asdict(scene.about),
        "review": None if scene.review is None else asdict(scene.review),
        "seconds": none_if_nan(scene.seconds),
    }


def _scene_from_dict(fields: Mapping[str, Any]) -> Scene:
    return Scene(
        photo=fields["photo"],
        sha256=fields["sha256"],
        width_px=fields["width_px"],
        height_px=fields["height_px"],
        status=fields["status"],
        reason=fields["reason"],
        camera=camera_from_dict(fields["camera"]),
        people=people_from_dict(fields["people"]),
        bodies=bodies_from_dict(fields["bodies"]),
        settings=Settings.from_dict(fields["settings"]),
        made_by=Provenance(**fields["made_by"]),
        about=About(**fields["about"]),
        review=None if fields["review"] is None else Review(**fields["review"]),
        seconds=math.nan if fields["seconds"] is None else fields["seconds"],
    )
