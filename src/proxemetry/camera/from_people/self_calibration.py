"""The focal length from the people themselves, for photos whose files state nothing about their camera.

Upright people on one floor are verticals of nearly one length. Where they converge lies the vertical vanishing point,
where their size would shrink to nothing the horizon, and the two lie f^2 apart as seen from the principal point (on
either side of it). A level camera has the one at infinity and the other in the middle: then every focal length fits,
and then there is no answer.

RANSAC over triples of people with a direct linear solution finds who stands upright; the posterior of the focal
length then uses all people, with statures that differ, people who lean, noise of the keypoints and a principal
point that is not quite in the middle.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ...arrays import FloatArray
from ...intervals import HALF_WIDTH_SD
from ...people import People
from ...photo.metadata import Metadata
from ..camera import Camera
from ..estimate import CameraEstimate, Candidate
from ..frame import frame_of
from ..sources import Doubt, Flag, FocalSource, Source
from .focal_profile import consensus, profile_around, profile_everywhere
from .verticals import segments_of

#: Widest central 90 % interval that is still an answer: plus or minus this part of the focal length.
WIDEST = 0.30
#: Central 90 % intervals of log f wider than this do not become answers on a finer grid.
_HOPELESS = 8 * math.log1p(WIDEST)
_TOO_FEW_AGREE = "fewer than 3 people agree on how the camera looks"


@dataclass(frozen=True, eq=False)
class FocalPosterior:
    """The focal length as the people determine it.

    f_px, low_px, high_px: median and central 90 % interval. log_sd: standard deviation of its logarithm.
    pitch_rad: of the camera, positive where it looks down. upright: shape (P,), who supports it. log_f, log_likelihood:
    the logarithm of focal lengths in pixels, shape (G,), rising, and the log likelihood of each given the people.
    """

    f_px: float
    low_px: float
    high_px: float
    log_sd: float
    pitch_rad: float
    upright: NDArray[np.bool_]
    log_f: FloatArray
    log_likelihood: FloatArray


def calibrate(people: People, width: int, height: int) -> CameraEstimate:
    """Return the camera that people in a photo of `width` x `height` pixels determine, or the reason why they do not.

    It takes three or more upright people with feet and head or shoulders in view, and a camera that looks down (or
    up) at them by some five degrees or more. The estimate's camera is None where the interval of the focal length is
    wider than `WIDEST`; the candidate then still holds what was found.
    """
    posterior = focal_posterior(people, width, height)
    if isinstance(posterior, str):
        return CameraEstimate(None, reason=f"none from the people: {posterior}")
    count, pitch = int(posterior.upright.sum()), math.degrees(posterior.pitch_rad)
    source = Source(FocalSource.PEOPLE, f"{count} upright, camera pitched {pitch:.0f} degrees")
    candidate = Candidate(posterior.f_px, posterior.log_sd, source)
    interval = f"{posterior.low_px:.0f} to {posterior.high_px:.0f} px"
    if HALF_WIDTH_SD * posterior.log_sd > math.log1p(WIDEST):
        reason = f"the people leave it open within {interval}: too wide"
        return CameraEstimate(None, (candidate,), reason=reason)
    camera = Camera.centred(posterior.f_px, width, height, focal_rel_sd=posterior.log_sd, source=source)
    camera = replace(camera, principal_sd_px=frame_of(width, height, Metadata()).principal_sd_px)
    flag = Flag(Doubt.ESTIMATED, f"focal length {FocalSource.PEOPLE.words}: {interval}")
    return CameraEstimate(camera, (candidate,), (flag,))


def focal_posterior(people: People, width: int, height: int) -> FocalPosterior | str:
    """Return the posterior of the focal length in pixels, or why there is none."""
    segments = segments_of(people, width, height)
    if len(segments.rows) < 3:
        return f"only {len(segments.rows)} upright with feet and head in view; 3 people are needed"
    start = consensus(segments)
    if start.explains(segments).sum() < 3:
        return _TOO_FEW_AGREE
    profile = profile_everywhere(segments, start)
    low, middle, high = profile.quantiles()
    if high - low < _HOPELESS:
        profile = profile.with_finer(profile_around(segments, profile))
        low, middle, high = profile.quantiles()
    fits = profile.best.explains(segments)
    if fits.sum() < 3:
        return _TOO_FEW_AGREE
    upright = np.zeros(len(people), dtype=bool)
    upright[segments.rows[fits]] = True
    f_px, low_px, high_px = (math.exp(value) * segments.long_side_px for value in (middle, low, high))
    return FocalPosterior(
        f_px, low_px, high_px, (high - low) / (2 * HALF_WIDTH_SD), float(profile.best.parameters[0]), upright,
        profile.log_f + math.log(segments.long_side_px), profile.log_likelihood,
    )  # fmt: skip
