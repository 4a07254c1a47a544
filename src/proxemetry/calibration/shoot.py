"""One lens from the people of many photos of it: of a camera that stayed, with its place, or of one that moved."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ..camera import Camera, Mount
from ..camera.sensors import FULL_FRAME_DIAGONAL_MM
from ..errors import CameraError
from ..intervals import HALF_WIDTH_SD
from ..locate import LocateSettings
from ..locate.scenefit.pooled import Pooled, pooled
from ..people import People
from .people import MOST_DETECTIONS, Gathered, from_people, joined_people, whole
from .points import PRINCIPAL_REL_SD

#: Fewer photos with people than this are no shoot.
LEAST_PHOTOS = 3
#: 35 mm equivalents that the search begins from, and how far others are from them (logarithm).
_STARTS_MM, _OPEN_LOG_SD = (28.0, 60.0), 0.5
#: A photo that disagrees with the others by so many standard deviations is of another lens or zoom; they are left out
#: one at a time, at most this share of them.
_ANOTHER, _MOST_LEFT_OUT = 3.0, 1 / 3
#: A focal length to which one photo contributes more than this is that photo's: if it is of another lens, that would go
#: unnoticed.
_MOST_BY_ONE = 0.5
#: A camera that moves is found from how it looks down: below this, how people lean and walk matters as much.
_LEAST_PITCH_RAD = math.radians(5)
#: Widest interval that is an answer, as high over low: as that of a photo by itself (`camera.unstated.WIDEST_RATIO`).
WIDEST_RATIO = 1.3 / 0.7


@dataclass(frozen=True, eq=False)
class ShootFit:
    """What the people in a shoot show about the camera.

    log_focal_px, log_sd: of the focal length. mount: the camera's place, where it stayed. photos, people: how many it
    rests on, people counted as no more than one photo shows at once. left_out: which photos are of another lens.
    largest_share: how much of the evidence on it comes from one photo. pitch_rad: how far the camera looks down (or
    up) in the middle one of the photos; infinite where that does not matter.
    """

    log_focal_px: float
    log_sd: float
    photos: int
    people: int
    mount: Mount | None = None
    left_out: tuple[int, ...] = ()
    largest_share: float = 0.0
    pitch_rad: float = math.inf

    @property
    def doubt(self) -> str | None:
        """Why it is not to be measured by, None where it is."""
        if 2 * HALF_WIDTH_SD * self.log_sd > math.log(WIDEST_RATIO):
            return "too wide"
        if self.largest_share > _MOST_BY_ONE:
            return "most of the evidence is from a single photo"
        if self.pitch_rad < _LEAST_PITCH_RAD:
            return "the camera looks too level: seen so, every focal length fits"
        return None


def told_by_shoot(
    photos: Sequence[People], width: int, height: int, settings: LocateSettings, *, stayed: bool
) -> ShootFit:
    """Return the camera found from the people in photos of `width` x `height` pixels; raises CameraError.

    stayed: whether the camera stood in one place for all of them. The same people may be in every photo, and nobody
    knows who is who: the errors of their bodies count as if all were.
    """
    usable = [people[whole(people)] for people in photos]
    kept = [k for k, people in enumerate(usable) if len(people)]
    if len(kept) < LEAST_PHOTOS:
        raise CameraError(f"{len(kept)} photos show a person from shoulders to ankles; {LEAST_PHOTOS} are needed")
    lens = replace(
        Camera.centred(float(max(width, height)), width, height), principal_sd_px=PRINCIPAL_REL_SD * max(width, height),
        focal_rel_sd=_OPEN_LOG_SD,
    )  # fmt: skip
    if stayed:
        return _of_one_place([usable[k] for k in kept], lens, settings)
    left_out: list[int] = []
    while True:
        fit, repeated = _carried([usable[k] for k in kept], lens, settings)
        off = np.abs(fit.by_view[:, 0]) / np.sqrt(np.maximum(fit.by_view[:, 1], 1e-12))
        worst = int(off.argmax())
        may_go = len(left_out) + 1 <= _MOST_LEFT_OUT * (len(kept) + len(left_out)) and len(kept) > LEAST_PHOTOS
        if off[worst] < _ANOTHER or not may_go:
            break
        left_out.append(kept.pop(worst))
    variance = float(fit.covariance_if_met(repeated)[3, 3])
    log_f = math.log(fit.camera.f_px) + float(fit.shared[3])
    people = round(fit.n_people / repeated)
    pitch = float(np.median(np.abs(fit.places[:, 0])))
    share = float(fit.by_view[:, 1].max() / fit.by_view[:, 1].sum())
    return ShootFit(log_f, math.sqrt(variance), len(kept), people, None, tuple(sorted(left_out)), share, pitch)


def _carried(photos: Sequence[People], lens: Camera, settings: LocateSettings) -> tuple[Pooled, float]:
    """Return the likeliest lens of a camera that moved, and how often each person may be there."""
    counts = np.array([len(people) for people in photos])
    enough = int(np.searchsorted(np.cumsum(counts), MOST_DETECTIONS)) + 1
    photos, counts = photos[:enough], counts[:enough]
    people = joined_people(photos)
    persons, views = np.arange(len(people)), np.repeat(np.arange(len(photos)), counts)
    unit = math.hypot(lens.width, lens.height) / FULL_FRAME_DIAGONAL_MM
    fits = [_from(people, persons, views, lens, mm * unit, settings) for mm in _STARTS_MM]
    told = [fit for fit in fits if fit is not None]
    if not told:
        raise CameraError("no camera can be determined from the people: too little of them is visible")
    best = min(told, key=lambda fit: fit.cost)
    again = _from(people, persons, views, lens, best.camera.f_px * math.exp(best.shared[3]), settings)
    return again or best, max(1.0, len(people) / int(counts.max()))


def _from(
    people: People, persons: NDArray[np.intp], views: NDArray[np.intp], lens: Camera, f_px: float,
    settings: LocateSettings,
) -> Pooled | None:  # fmt: skip
    camera = replace(lens, fx=f_px, fy=f_px)
    return pooled(people, camera, persons, settings, views)


def _of_one_place(photos: Sequence[People], lens: Camera, settings: LocateSettings) -> ShootFit:
    gathered, met = Gathered(), 0
    for people in photos:
        gathered.add(people, range(met, met + len(people)))
        met += len(people)
    unit = math.hypot(lens.width, lens.height) / FULL_FRAME_DIAGONAL_MM
    f_px = math.sqrt(math.prod(_STARTS_MM)) * unit
    start = replace(lens, fx=f_px, fy=f_px, focal_rel_sd=0.0)
    fit = from_people(gathered, start, focal_known=False, recurring=True, settings=settings)
    mount = replace(fit.mount, source=f"the people of {len(photos)} photos", size_px=(lens.width, lens.height))
    assert mount.camera is not None
    return ShootFit(math.log(mount.camera.f_px), float(mount.sd[3]), len(photos), fit.n_people, mount)
