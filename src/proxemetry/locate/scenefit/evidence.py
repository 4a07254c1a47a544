"""What of a detector's keypoints counts as evidence, and how noisy it is."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from ...anthropometry import LENGTHS
from ...arrays import FloatArray
from ...camera import Camera
from ...people import People
from ...people.keypoint_noise import law_for
from .body_model import BodyModel

#: How long each of `anthropometry.LENGTHS` is seen, of its true length, and by how much that differs between people.
SeenLengths = tuple[tuple[float, float], ...]

#: Detectors pile what lies outside the photo up at its edge: this share of the diagonal from it is outside.
_EDGE = 0.002
#: What no detector resolves, as a share of the photo's diagonal: about 0.7 px of a 1600 x 900 photo. The back end's own
#: floor holds where that is more.
_RESOLUTION = 4e-4
#: What a stated depth is not known better than, metres: an instrument and the body model do not mean the same
#: point of a body that leans and breathes. An assumption.
_LEAST_DEPTH_SD_M = 0.05


@dataclass(frozen=True, eq=False)
class Evidence:
    """The K keypoints that the body model knows, of P people, in units of the focal length from the principal point.

    points: shape (P, K, 2), zero where absent. seen: shape (P, K). score_noise: shape (P, K), how far the
    detector strays at that score, in statures. resolution: the noise of a sharp point, in the same units as points.
    heading_rad, heading_sd_rad: shape (P,), the back end's own, in the camera frame; NaN where it gives none.
    log_depth, depth_rel_sd: shape (P,), the log of the stated depth in metres of the torso's middle along the camera's
        axis, and its standard deviation; NaN where nothing is stated.
    lengths: what the back end makes of body lengths, in the order of `anthropometry.LENGTHS`. from_above: shape (K,),
        what the sine of the angle from above adds to the noise, as a share. too_level_rad: by how much less far from
        above bodies are seen. alike: by what the variance of all that people together show of pitch, roll and height is
        multiplied.
    """

    points: FloatArray
    seen: NDArray[np.bool_]
    score_noise: FloatArray
    resolution: float
    heading_rad: FloatArray
    heading_sd_rad: FloatArray
    log_depth: FloatArray
    depth_rel_sd: FloatArray
    lengths: SeenLengths = ()
    from_above: FloatArray = field(default_factory=lambda: np.zeros(1))
    too_level_rad: float = 0.0
    alike: float = 1.0


def evidence_of(people: People, camera: Camera, model: BodyModel) -> Evidence:
    """Return the usable keypoints; what is outside the photo or scarcely believed by the detector is absent."""
    pixels = people.keypoints_px[:, model.columns]
    scores = people.scores[:, model.columns]
    diagonal = float(np.hypot(camera.width, camera.height))
    margin = _EDGE * diagonal
    inside = (pixels > margin).all(axis=-1) & (pixels < (camera.width - margin, camera.height - margin)).all(axis=-1)
    law = law_for(people)
    seen = inside & (scores >= law.lowest_score)
    points = (pixels - (camera.cx, camera.cy)) / (camera.fx, camera.fy)
    joints = [people.skeleton.joints[column] for column in model.columns]
    return Evidence(
        points=np.where(seen[..., None], points, 0.0),
        seen=seen,
        score_noise=np.nan_to_num(law.score_noise(joints, scores)),
        resolution=max(_RESOLUTION * diagonal, law.floor_px) / camera.f_px,
        heading_rad=people.heading_rad - _azimuth(points, seen),
        heading_sd_rad=people.heading_sd_rad,
        log_depth=np.log(people.depth_m),
        depth_rel_sd=np.hypot(people.depth_sd_m, _LEAST_DEPTH_SD_M) / people.depth_m,
        lengths=tuple((law.scale.get(name, 1.0), law.common.get(name, 0.0)) for name in LENGTHS),
        from_above=law.grows_from_above(joints),
        too_level_rad=math.radians(law.too_level_deg),
        alike=law.alike,
    )


def _azimuth(points: FloatArray, seen: NDArray[np.bool_]) -> FloatArray:
    """Return how far to the right of the camera's axis each person is seen, radians (P,): headings count from there."""
    across = np.where(seen, points[..., 0], 0.0).sum(axis=1) / np.maximum(seen.sum(axis=1), 1)
    return np.arctan(across)
