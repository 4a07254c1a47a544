"""Which squares of a photo are worth a look: from the person detector's boxes, or without it from bodies and faces.

The landmark network depends little on where exactly its square lies: it finds where the person is, and runs once more
there. So a box, a pose detection and the place under a face all serve as a first look.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...arrays import FloatArray
from ..detections import Detections
from .detectors import Detector, mean_of_groups, merged, windows_of
from .regions import Picture, Region

Windows = tuple[tuple[float, float], ...]

# MediaPipe's own rule: the square's side is 1.25 times the diameter of the circle around the body.
_BODY_FACTOR = 1.25
# The hips of a person upright are .52 of the stature below the crown (METHOD section 4: trochanterion .87 of 1.69 m),
# and the circle around them that reaches feet and crown has that radius.
_HIPS = 0.52
# Where the box ends at the waist (a person behind a table, or cut by the photo) the hips are near its lower edge.
_HIPS_OF_HALF = 0.9
# A box this many times as high as wide shows a person from head to foot.
_SLIM = 2.5
# The second try at such a body shows more around it.
_WIDE = 1.6
# A person cut by the photo's side may look slim and be half a body.
_AT_EDGE_PX = 2.0
# A face's box is about 1/4.3 of the way from hips to the circle's edge above the head (METHOD section 4: face height
# .12 of a stature of 1.7 m; hips .9 m below the crown); the same figure as in the measured prototype.
_HIPS_BELOW_FACE, _RADIUS_IN_FACES = 3.3, 4.3

# One body in two windows: hips and heads nearer than these shares of the circle's radius, and the circles' sizes alike.
# Set by hand: wider than the detector scatters between windows, narrower than people stand side by side (a shoulder's
# breadth is .2 of the circle's radius of .9 m, and two people's middles are two of them apart).
_SAME_HIPS, _SAME_HEAD, _SAME_LOG_SIZE = 0.35, 0.25, 0.4


@dataclass(frozen=True, eq=False)
class Proposal:
    """Squares where one person may be, likeliest first, the detector's score, and the person's box where it has one."""

    squares: tuple[Region, ...]
    score: float
    box_px: FloatArray | None = None


def in_boxes(people: Detections, picture: Picture) -> list[Proposal]:
    """Return the squares of a person detector's boxes, best first: of a whole body, else of half a one.

    Nearer people come first where scores are alike: what is small is rarely placed well, and a crowd has no end.
    """
    found: list[tuple[float, Proposal]] = []
    for box, score in zip(people.boxes_px, people.scores, strict=True):
        width, height = (float(side) for side in box[2:] - box[:2])
        x, top = float(box[0] + box[2]) / 2, float(box[1])
        hips = top + _HIPS * height
        whole = Region(x, hips, 2 * _BODY_FACTOR * _HIPS * max(width, height))
        wide = Region(x, hips, _WIDE * height)
        upper = Region(x, top + _HIPS_OF_HALF * height, 2 * _BODY_FACTOR * _HIPS_OF_HALF * height)
        cut = box[0] < _AT_EDGE_PX or box[2] > picture.width - _AT_EDGE_PX
        slim = height > _SLIM * width
        squares = (whole, *([wide] if slim else []), *([upper] if cut or not slim else []))
        found.append((float(score) * math.sqrt(height), Proposal(squares, float(score), box)))
    return [proposal for _, proposal in sorted(found, key=lambda ranked: -ranked[0])]


def without_boxes(
    picture: Picture, pose: Detector, face: Detector, pose_windows: Windows, face_windows: Windows,
    pose_minimum: float, face_minimum: float,
) -> list[Proposal]:  # fmt: skip
    """Return the squares around MediaPipe's bodies and under its faces, best first."""
    bodies = pose.find(picture, _windows(picture, pose_windows), pose_minimum)
    faces = merged(face.find(picture, _windows(picture, face_windows), face_minimum))
    bodies = mean_of_groups(bodies, _same_bodies(bodies))
    found = [
        Proposal((Region.around(p[0], p[1], _BODY_FACTOR),), float(s))
        for p, s in zip(bodies.keypoints_px, bodies.scores, strict=True)
    ]
    found += [Proposal((_below_face(box),), float(s)) for box, s in zip(faces.boxes_px, faces.scores, strict=True)]
    return sorted(found, key=lambda p: -p.score)


def _windows(picture: Picture, kinds: Windows) -> list[tuple[int, int, int, int]]:
    return [w for fraction, overlap in kinds for w in windows_of(picture.width, picture.height, fraction, overlap)]


def _below_face(box: FloatArray) -> Region:
    """Return the body's square under a face: hips 3.3 face heights below it, upright."""
    centre, height = (box[:2] + box[2:]) / 2, float((box[2:] - box[:2]).max())
    hips = centre + (0.0, _HIPS_BELOW_FACE * height)
    return Region.around(hips, hips - (0.0, _RADIUS_IN_FACES * height), _BODY_FACTOR)


def _same_bodies(bodies: Detections) -> list[NDArray[np.intp]]:
    """Return rows of detections that are one body seen in several windows: hips, head and size agree (`_SAME_...`)."""
    hips = bodies.keypoints_px[:, 0]
    radius = np.linalg.norm(bodies.keypoints_px[:, 1] - hips, axis=1) + 1e-6
    order = np.argsort(-bodies.scores, kind="stable")
    groups: list[NDArray[np.intp]] = []
    while len(order):
        best = order[0]
        same = (
            (np.linalg.norm(hips[order] - hips[best], axis=1) < _SAME_HIPS * radius[best])
            & (np.linalg.norm(bodies.centres_px[order] - bodies.centres_px[best], axis=1) < _SAME_HEAD * radius[best])
            & (np.abs(np.log(radius[order] / radius[best])) < _SAME_LOG_SIZE)
        )
        same[0] = True
        groups.append(order[same])
        order = order[~same]
    return groups
