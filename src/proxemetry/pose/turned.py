"""Keypoints by tools that ignore a photo's orientation tag: all its people lie, or stand on their heads."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..arrays import FloatArray
from ..errors import KeypointsError
from ..people import People
from ..photo import Photo

#: EXIF orientations that swap the sides, and those that mirror (EXIF 2.32, 4.6.4, tag 0x0112).
_SWAPPED, _MIRRORED = (5, 6, 7, 8), (2, 4, 5, 7)
#: A person who leans further from the vertical than this, in degrees, lies.
_LYING_DEG = 60.0


def is_unturned(photo: Photo, width: float, height: float) -> bool:
    """Whether a size is that of the photo before its orientation tag was applied, and cannot be the upright one's."""
    if photo.metadata.orientation not in _SWAPPED or photo.width == photo.height:
        return False
    ratio, unturned = width / height, photo.height / photo.width
    return abs(np.log(ratio / unturned)) < abs(np.log(ratio * unturned))


def upright(people: People, photo: Photo, size: tuple[float, float] | None, where: str) -> People:
    """Return people in pixels of the upright photo.

    size: of the picture that the tool saw, known to be unturned; None where nothing states it. Then pixels beyond the
    upright photo, or all people on their heads, show the same; that all lie, heads the way the tag would turn them,
    may also be true. Raises KeypointsError, which begins with `where`, where it may be either.
    """
    orientation = photo.metadata.orientation
    if size is not None:
        unturned = (photo.height, photo.width)
        return _turned(people.scaled(unturned[0] / size[0], unturned[1] / size[1]), photo)
    if orientation in (1, 2) or not len(people):
        return people
    turned = _turned(people, photo)
    if orientation in _SWAPPED and _reaches_beyond(people, photo) and not _reaches_beyond(turned, photo):
        return turned
    now, then = _lean_deg(people), _lean_deg(turned)
    known = np.isfinite(now)
    if not known.any() or (now[known] < _LYING_DEG).any() or (then[known] > _LYING_DEG).any():
        return people
    if orientation not in _SWAPPED:
        return turned
    all_of = "the one person lies" if len(people) == 1 else f"all {len(people)} people lie"
    raise KeypointsError(
        f"{where}: {all_of}, heads the same way, and an orientation tag ({orientation}) turns the photo: did the tool "
        "ignore the tag? State width and height of the picture as the tool saw it"
    )


def _reaches_beyond(people: People, photo: Photo) -> bool:
    """Whether joints lie beyond the photo by more than a detector overshoots its edge."""
    points = people.keypoints_px[np.isfinite(people.keypoints_px).all(axis=-1)]
    return bool((points > np.array([photo.width, photo.height]) * 1.05).any())


def _lean_deg(people: People) -> FloatArray:
    """Return how far each person's trunk leans from the picture's vertical in degrees, shape (P,); NaN where unseen."""
    up = people.part("Shoulder") - (people.joint("left_hip") + people.joint("right_hip")) / 2
    up = np.where(np.isfinite(up), up, people.part("Eyes") - people.part("Shoulder"))
    return np.degrees(np.arctan2(np.abs(up[:, 0]), -up[:, 1]))


def _turned(people: People, photo: Photo) -> People:
    """Return people found in the unturned photo in pixels of the upright one."""
    orientation = photo.metadata.orientation
    boxes = _moved(people.boxes_px.reshape(-1, 2, 2), photo)
    keypoints = _moved(people.keypoints_px, photo)
    scores = people.scores
    if orientation in _MIRRORED:  # the tool took left for right
        order = list(people.skeleton.mirror)
        keypoints, scores = keypoints[:, order], scores[:, order]
    corners = np.concatenate([boxes.min(axis=1), boxes.max(axis=1)], axis=-1)
    return replace(people, keypoints_px=keypoints, scores=scores, boxes_px=corners)


def _moved(points_px: FloatArray, photo: Photo) -> FloatArray:
    orientation = photo.metadata.orientation
    x, y = points_px[..., 0], points_px[..., 1]
    if orientation in _SWAPPED:
        x, y = y, x
    if orientation in (3, 4, 7, 8):
        y = photo.height - y
    if orientation in (2, 3, 6, 7):
        x = photo.width - x
    return np.stack([x, y], axis=-1)
