"""The scene fit where the focal length is hardly known: fitted at several, and their explanations combined.

The fit is linear about one focal length, and from people who lean, gait and floors that fall it infers a focal length
in a photo that has no evidence on it: a level camera's people fit every one. What people do show is used before
(`camera.from_people`), so the fit must not use it again. Where the focal length is less sure than `UNSURE_SD`, it
is held at three values instead, Gauss and Hermite's of a normal distribution, and each fit is a mode of the bodies.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from ..arrays import FloatArray
from ..bodies import Bodies, Floor, Mode
from ..camera import Camera, Mount
from ..people import People
from . import LocateSettings
from .scenefit import locate as fitted

#: From this relative standard deviation on. What the file records is surer, and so is most of what lines show.
UNSURE_SD = 0.25
#: More people than this are fitted at one focal length, whose doubt stretches their depths: three fits of a crowd take
#: three times its seconds and memory.
CROWD = 60
#: With a camera pitched by more than this, the people on the floor show its focal length, and the fit may use it.
PITCHED_RAD = math.radians(12.0)
#: In standard deviations of the log focal length, with their weights: exact for polynomials of the fifth degree. The
#: outer ones are where central 90 % intervals end, about.
_NODES = ((-math.sqrt(3), 1 / 6), (0.0, 2 / 3), (math.sqrt(3), 1 / 6))
#: Focal lengths of lenses that exist, in long sides of the photo: 8 to 2000 mm on the 36 x 24 mm frame.
_BOUNDS = (8 / 36, 2000 / 36)
#: How far each fit may move its own focal length.
_HELD_SD = 0.05


def locate(people: People, camera: Camera, settings: LocateSettings, mount: Mount | None = None) -> Bodies:
    """Return where people stand by `scenefit.locate`, at several focal lengths where the camera's is hardly known."""
    if camera.focal_rel_sd < UNSURE_SD or (mount is not None and mount.camera is not None) or not len(people):
        return fitted(people, camera, settings, mount)
    free = fitted(people, camera, settings, mount)
    if free.floor is not None and abs(free.floor.pitch_rad) > PITCHED_RAD:
        return free
    if len(people) > CROWD:
        return _stretched(fitted(people, _at(camera, 0.0), settings, mount), camera.focal_rel_sd)
    fits = [fitted(people, _at(camera, z), settings, mount) for z, _ in _NODES]
    middle = fits[1]
    if not all((fit.placed == middle.placed).all() for fit in fits):
        return free
    modes: list[Mode] = []
    for fit, (_, weight) in zip(fits, _NODES, strict=True):
        own = fit.modes or (Mode(1.0, fit.positions_m, fit.covariance_m2),)
        modes += [replace(mode, weight=mode.weight * weight) for mode in own]
    about = [(mode.positions_m - middle.positions_m).ravel() for mode in modes]
    covariance = np.sum(
        [m.weight * (m.covariance_m2 + np.outer(a, a)) for m, a in zip(modes, about, strict=True)], axis=0
    )
    return replace(middle, covariance_m2=covariance, modes=tuple(modes), floor=_floor(fits))


def _stretched(bodies: Bodies, rel_sd: float) -> Bodies:
    """Return people of a held focal length with depths that all go with it, by the spread of the nodes.

    Their places across the picture stay, as in every fit of people whose size is known.
    """
    variance = sum(weight * math.expm1(z * rel_sd) ** 2 for z, weight in _NODES)

    def stretched(positions_m: FloatArray, covariance_m2: FloatArray) -> FloatArray:
        depth = np.zeros_like(positions_m)
        depth[:, 2] = positions_m[:, 2]
        return covariance_m2 + variance * np.outer(depth, depth)

    modes = tuple(replace(m, covariance_m2=stretched(m.positions_m, m.covariance_m2)) for m in bodies.modes)
    return replace(bodies, covariance_m2=stretched(bodies.positions_m, bodies.covariance_m2), modes=modes)


def _at(camera: Camera, z: float) -> Camera:
    """Return the camera with a focal length that is so many standard deviations off, and sure."""
    low, high = (bound * max(camera.width, camera.height) for bound in _BOUNDS)
    f_px = camera.f_px * math.exp(z * camera.focal_rel_sd)
    nearest = min(max(f_px, min(low, camera.f_px)), max(high, camera.f_px))
    return camera.with_focal(nearest, focal_rel_sd=_HELD_SD, source=camera.source)


def _floor(fits: list[Bodies]) -> Floor | None:
    """Return the middle fit's floor with deviations that hold the others."""
    middle = fits[1].floor
    if middle is None or any(fit.floor is None for fit in fits):
        return middle
    sds = {
        f"{name}_sd_{unit}": math.sqrt(
            sum(
                weight
                * (
                    getattr(fit.floor, f"{name}_sd_{unit}") ** 2
                    + (getattr(fit.floor, f"{name}_{unit}") - getattr(middle, f"{name}_{unit}")) ** 2
                )
                for fit, (_, weight) in zip(fits, _NODES, strict=True)
            )
        )
        for name, unit in (("height", "m"), ("pitch", "rad"), ("roll", "rad"))
    }
    return replace(middle, **sds)
