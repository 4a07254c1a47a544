"""The face of a person who was found: one pass of the face detector over the head."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...arrays import FloatArray
from .detectors import Detector
from .duplicates import head_px, torso_px
from .landmarks import Candidate
from .regions import Picture

#: The part of the photo that is looked at is this many torsos wide; nearer to its edges than that it is cut.
_WINDOW = 2.0
#: A window of fewer pixels shows no face.
_SMALLEST_PX = 4
#: The face detector's score from which its box is looked at: low, since where the face must be is known.
_MINIMUM = 0.1
# Where the middle of a face may lie from the middle of eyes, nose and ears, in heights of its box, and that height in
# torsos: METHOD section 4 has about .4 for an adult.
_ASIDE, _HEIGHTS = 0.6, (0.15, 1.2)


@dataclass(frozen=True, eq=False)
class Face:
    """A detected face: its box (4,), its points (6, 2), right eye and left eye first, and its score."""

    box_px: FloatArray
    points_px: FloatArray
    score: float


def face_of(candidate: Candidate, picture: Picture, detector: Detector) -> Face | None:
    """Return the best face where a candidate's head is, None where there is none."""
    head, torso = head_px(candidate), torso_px(candidate)
    limits = np.array([picture.width, picture.height])
    low = np.rint(head - _WINDOW / 2 * torso).clip(0, limits).astype(int)
    high = np.rint(head + _WINDOW / 2 * torso).clip(0, limits).astype(int)
    if (high - low).min() < _SMALLEST_PX:
        return None
    faces = detector.find(picture, [(int(low[0]), int(low[1]), int(high[0] - low[0]), int(high[1] - low[1]))], _MINIMUM)
    heights = faces.boxes_px[:, 3] - faces.boxes_px[:, 1]
    aside = np.linalg.norm(faces.centres_px - head, axis=1)
    fits = (aside < _ASIDE * heights) & (heights > _HEIGHTS[0] * torso) & (heights < _HEIGHTS[1] * torso)
    if not fits.any():
        return None
    best = int(np.argmax(np.where(fits, faces.scores, -1)))
    return Face(faces.boxes_px[best], faces.keypoints_px[best], float(faces.scores[best]))
