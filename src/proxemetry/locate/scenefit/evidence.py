"""What of a detector's keypoints counts as evidence, and how noisy it is."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...arrays import FloatArray
from ...camera import Camera
from ...people import People
from ...people.keypoint_noise import law_of
from .body_model import BodyModel

#: Keypoints below this score are absent.
LOWEST_SCORE = 0.05
#: Detectors pile what lies outside the photo up at its edge: this share of the diagonal from it is outside.
_EDGE = 0.002
#: What no detector resolves, as a share of the photo's diagonal: about 0.7 px of a 1600 x 900 photo.
_RESOLUTION = 4e-4


@dataclass(frozen=True, eq=False)
class Evidence:
    """The K keypoints that the body model knows, of P people, in units of the focal length from the principal point.

    points: shape (P, K, 2), zero where absent. seen: shape (P, K). waver: shape (P, K), how far the
    detector strays at that score, in statures. resolution: the noise of a sharp point, in the same units as points.
    heading_rad, heading_sd_rad: shape (P,), what the back end says itself, in the camera frame; NaN where nothing.
    """

    points: FloatArray
    seen: NDArray[np.bool_]
    waver: FloatArray
    resolution: float
    heading_rad: FloatArray
    heading_sd_rad: FloatArray


def evidence_of(people: People, camera: Camera, model: BodyModel) -> Evidence:
    """Return the usable keypoints; what is outside the photo or scarcely believed by the detector is absent."""
    pixels = people.keypoints_px[:, model.columns]
    scores = people.scores[:, model.columns]
    diagonal = float(np.hypot(camera.width, camera.height))
    margin = _EDGE * diagonal
    inside = (pixels > margin).all(axis=-1) & (pixels < (camera.width - margin, camera.height - margin)).all(axis=-1)
    seen = inside & (scores >= LOWEST_SCORE)
    points = (pixels - (camera.cx, camera.cy)) / (camera.fx, camera.fy)
    return Evidence(
        points=np.where(seen[..., None], points, 0.0),
        seen=seen,
        waver=_waver(people, scores, model),
        resolution=_RESOLUTION * diagonal / camera.f_px,
        heading_rad=people.heading_rad - _azimuth(points, seen),
        heading_sd_rad=people.heading_sd_rad,
    )


def _azimuth(points: FloatArray, seen: NDArray[np.bool_]) -> FloatArray:
    """Return how far to the right of the camera's axis everybody is seen, radians (P,): headings count from there."""
    across = np.where(seen, points[..., 0], 0.0).sum(axis=1) / np.maximum(seen.sum(axis=1), 1)
    return np.arctan(across)


def _waver(people: People, scores: FloatArray, model: BodyModel) -> FloatArray:
    joints = [people.skeleton.joints[column] for column in model.columns]
    return np.nan_to_num(law_of(people.skeleton.name).waver(joints, scores))
