"""What the program adds to an action of the page before it is kept: the photos of its scope, and keys of new people."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any

from ..archive.review.actions import Action
from ..errors import SettingsError
from .photos import OwnPhoto

#: Which photos an action applies to, given one of them.
SCOPES: dict[str, Callable[[OwnPhoto, OwnPhoto], bool]] = {
    "photo": lambda one, other: one is other,
    "folder": lambda one, other: one.folder == other.folder,
    "camera": lambda one, other: (
        one.camera == other.camera and one.photo.metadata.focal_mm == other.photo.metadata.focal_mm
    ),
    "following": lambda one, other: other.name >= one.name,
    "all": lambda one, other: True,
}


def completed(
    photo: OwnPhoto, action: str, value: Mapping[str, Any], photos: Sequence[OwnPhoto], key: int
) -> dict[str, Any]:
    """Return an action's value with the photos that its scope means in place of that, and `key` for a new person.

    Raises SettingsError for points outside the photo and for an unknown scope.
    """
    full = dict(value)
    for point in (*_points_of(full.get("points")), *_points_of({"": full.get("to")})):
        if not (0 <= point[0] < photo.width and 0 <= point[1] < photo.height):
            raise SettingsError("annotation: the point lies outside the photo; what is outside is left out")
    if action == "add_person":
        full["person"] = key
    if "scope" in full:
        scope = full.pop("scope")
        if not isinstance(scope, str) or scope not in SCOPES:
            raise SettingsError(f"scope {scope!r} is unknown: use one of {', '.join(SCOPES)}")
        full["photos"] = [other.sha256 for other in photos if SCOPES[scope](photo, other)]
    return full


def next_key(photo: OwnPhoto, entries: Iterable[Action]) -> int:
    """Return a key that no one on a photo ever had, deleted people included."""
    used = [0]
    for entry in entries:
        if entry.sha256 == photo.sha256:
            listed = entry.value.get("people")
            people: list[Any] = listed if isinstance(listed, list) else []
            keys = [entry.value.get("person"), *(p.get("person") for p in people if isinstance(p, dict))]
            used += [key + 1 for key in keys if isinstance(key, int)]
    return max(used)


def _points_of(value: Any) -> list[tuple[float, float]]:
    """Return the pairs of numbers among points; what is none is for `actions` to refuse."""
    listed = value.values() if isinstance(value, dict) else ()
    return [
        (p[0], p[1])
        for p in listed
        if isinstance(p, list) and len(p) == 2 and all(isinstance(v, int | float) for v in p)
    ]
