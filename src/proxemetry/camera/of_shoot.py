"""A photo's camera as found from the people in all photos of its shoot, unless its own people contradict it."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from ..intervals import HALF_WIDTH_SD
from ..people import People
from ..photo import Photo
from .camera import Camera
from .estimate import CameraEstimate, Candidate, Testimony, Witness
from .focal import flags_beside_focal
from .frame import frame_of
from .from_people.self_calibration import focal_posterior
from .others import SameShoot
from .sources import Doubt, Flag, FocalSource, Source

#: A photo whose own people are so much surer of another focal length, in nats, is not of the same camera or zoom.
_ANOTHER_LENS = 4.5


def contradiction(shoot: SameShoot, people: People, photo: Photo) -> Flag | None:
    """Return the doubt where a photo's own people say that it is of another lens than those of its shoot."""
    own = focal_posterior(people, photo.width, photo.height)
    if isinstance(own, str):
        return None
    reach = np.abs(own.log_f - shoot.log_focal_px) <= HALF_WIDTH_SD * shoot.log_sd
    within = own.log_likelihood[reach].max() if reach.any() else -math.inf
    if own.log_likelihood.max() - within < _ANOTHER_LENS:
        return None
    said = f"its own people say {own.f_px:.0f} px, those of the other photos {math.exp(shoot.log_focal_px):.0f} px"
    return Flag(Doubt.CONTRADICTED, f"not of the same camera or zoom as the others: {said}")


def of_shoot(estimate: CameraEstimate, shoot: SameShoot, photo: Photo) -> CameraEstimate:
    """Return the camera found from a shoot, with the place where it stood if it stayed."""
    frame = frame_of(photo.width, photo.height, photo.metadata)
    source = Source(FocalSource.PEOPLE_OF_PHOTOS, f"{shoot.photos} photos")
    chosen = Candidate(math.exp(shoot.log_focal_px), shoot.log_sd, source)
    flags = (*flags_beside_focal(estimate.flags), Flag(Doubt.ESTIMATED, shoot.text))
    heard = (*estimate.testimony, Testimony(Witness.OTHERS, shoot.text, counted=True))
    camera = Camera.centred(chosen.focal_px, photo.width, photo.height, focal_rel_sd=chosen.rel_sd, source=source)
    camera, mount = replace(camera, principal_sd_px=frame.principal_sd_px), estimate.mount
    if shoot.mount is not None and shoot.mount.camera is not None:
        camera = replace(shoot.mount.camera, source=source)
        mount = mount or replace(shoot.mount, camera=camera)
    return CameraEstimate(camera, (chosen, *estimate.candidates), flags, mount=mount, testimony=heard)
