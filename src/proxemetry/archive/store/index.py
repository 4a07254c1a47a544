"""One line a photo of a results folder: what a person sorts, filters and picks by."""

from __future__ import annotations

import math
import posixpath
from dataclasses import dataclass
from operator import attrgetter

import numpy as np

from ...arrays import nan_if_none
from ...scene import Scene
from ...tables import DOUBT, NO_DOUBT
from . import parts
from .duck import attached
from .results import Results


@dataclass(frozen=True)
class PhotoCard:
    """What is known of a photo at a glance.

    group: the folder it lies in. nearest_m: the nearest pair's distance. spread: the widest of its intervals relative
    to the distance; NaN where there is none. doubtful: the camera carries a flag or a guessed focal length; assumed:
    the latter. duplicates: people who may be others seen a second time; doubts: these, and those who may be no
    people. camera: maker and model as the file names them.
    """

    photo: str
    sha256: str
    status: str
    reason: str
    n_people: int
    n_pairs: int
    nearest_m: float
    spread: float
    doubtful: bool
    corrections: int = 0
    camera: str | None = None
    assumed: bool = False
    duplicates: int = 0
    doubts: int = 0

    @property
    def group(self) -> str:
        """The folder that the photo lies in, "" for the one named."""
        return posixpath.dirname(self.photo)


def card_of(scene: Scene) -> PhotoCard:
    """Return the summary of one scene."""
    metres = scene.distances_m
    known = np.isfinite(metres)
    widths = (scene.distances.high_m - scene.distances.low_m)[known] / metres[known]
    return PhotoCard(
        scene.photo,
        scene.sha256,
        scene.status,
        scene.reason or "",
        len(scene),
        int(known.sum()) // 2,
        float(metres[known].min(initial=math.inf)) if known.any() else math.nan,
        float(np.nanmax(widths)) if np.isfinite(widths).any() else math.nan,
        scene.camera.is_doubtful,
        0 if scene.review is None else scene.review.corrections,
        _camera_name(scene.about.camera_make, scene.about.camera_model),
        scene.camera.is_assumed,
        int(scene.possible_duplicates.sum()),
        sum(map(bool, scene.doubts)),
    )


def cards(results: Results) -> list[PhotoCard]:
    """Return the cards of a results folder in the order of the photos' names, corrections applied.

    The measured ones come from the tables inside the parts: no scene is read for them.
    """
    if not parts.finished(results.folder):
        return []
    changed = {photo: card_of(scene) for photo, scene in results.corrected().items()}
    usable = results.usable()
    rows = (
        attached(results.folder)
        .execute(
            "SELECT photo, coalesce(sha256, ''), status, coalesce(reason, ''), coalesce(n_people, 0), "
            "coalesce(n_pairs, 0), "
            "list_min(list_transform(pairs, lambda p: p.distance_m)), "
            "list_max(list_transform(pairs, lambda p: (p.high_m - p.low_m) / p.distance_m)), "
            "coalesce(camera_flags, '') != '' OR coalesce(focal_assumed, false), camera_make, camera_model, "
            "coalesce(focal_assumed, false), len(list_filter(people, lambda p: p.possible_duplicate)), "
            f"len(list_filter(people, lambda p: p.{DOUBT} <> '{NO_DOUBT}')) "
            f"FROM {parts.every_row(results.folder, usable.names)} ORDER BY photo"
        )
        .fetchall()
    )
    found = [
        changed.get(photo)
        or PhotoCard(
            photo,
            sha256,
            status,
            reason,
            people,
            pairs,
            nan_if_none(nearest),
            nan_if_none(spread),
            doubtful,
            camera=_camera_name(make, model),
            assumed=assumed,
            duplicates=twice or 0,
            doubts=doubts or 0,
        )
        for photo, sha256, status, reason, people, pairs, *figures in rows
        for nearest, spread, doubtful, make, model, assumed, twice, doubts in [figures]
    ]
    return sorted([*found, *map(card_of, usable.scenes())], key=attrgetter("photo")) if usable.left_out else found


def _camera_name(make: str | None, model: str | None) -> str | None:
    """Return how a file names its camera; None where it does not name a model."""
    return None if model is None else f"{make or ''} {model}".strip()
