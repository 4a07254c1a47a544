"""People and a camera in, bodies out: the methods by name, loaded when asked for."""

from __future__ import annotations

import importlib
import math
from collections.abc import Callable
from dataclasses import dataclass

from ..anthropometry import CHILD_WEIGHT
from ..bodies import Bodies
from ..camera import Camera, Mount
from ..errors import SettingsError
from ..people import People

#: Option name -> "module:function".
METHODS = {
    "scene": "unsure_focal:locate",
    "combined": "pinhole:locate_combined",
    "torso": "pinhole:locate_torso",
    "shoulder": "pinhole:locate_shoulder",
    "pupil": "pinhole:locate_pupil",
}

#: Those that may place a person by the distance between the eyes.
MEASURE_PUPILS = ("combined", "pupil")

#: Peculiarities of the published code that change its numbers; off unless named in `LocateSettings.quirks`.
QUIRKS = {
    "code-torso-length": "the torso constant is the code's 444.5 mm, not the paper's 444 mm",
    "shoulder-counter": "shoulders refused by the 1.25 test do not advance the person counter, so that later people"
    " get a neighbour's shoulders",
    "zero-length": "a pair of keypoints on the same spot puts the person into the camera, at (0, 0, 0)",
}

BODY_SIZES = ("adults", "women", "men", "mixed", "children")
FLOORS = ("shared", "none")


@dataclass(frozen=True)
class LocateSettings:
    """What the user states about the people, for all methods.

    body_size: the population of `anthropometry`; "adults" is half women, half men, "mixed" also has children,
        with the share `child_weight`.
    body_sizes: the same for single people by row, None for the run's.
    statures: of single people by row, metres and their standard deviation, None where unknown: measured, or found from
        other pictures of the same person. floor: "shared" or "none".
    off_floor: rows of people who do not stand on the shared floor.
    quirks: names of the published code's peculiarities to reproduce (`QUIRKS`).
    """

    body_size: str = "mixed"
    body_sizes: tuple[str | None, ...] | None = None
    floor: str = "shared"
    off_floor: frozenset[int] = frozenset()
    quirks: frozenset[str] = frozenset()
    child_weight: float = CHILD_WEIGHT
    statures: tuple[tuple[float, float] | None, ...] | None = None

    def __post_init__(self) -> None:
        if self.body_sizes is not None:
            object.__setattr__(self, "body_sizes", tuple(self.body_sizes))
        if self.statures is not None:
            object.__setattr__(self, "statures", tuple(s and (float(s[0]), float(s[1])) for s in self.statures))
        for stature in self.statures or ():
            if stature is not None and not (0.3 < stature[0] < 3 and 0 < stature[1] < math.inf):
                raise SettingsError(f"stature {stature}: it is metres and their standard deviation, like (1.75, 0.02)")
        for size in (self.body_size, *(self.body_sizes or ())):
            if size is not None and size not in BODY_SIZES:
                raise SettingsError(f"body size {size!r} is unknown: use one of {', '.join(BODY_SIZES)}")
        if isinstance(self.child_weight, str) or not 0 <= self.child_weight < 1:
            raise SettingsError(f"child weight is {self.child_weight!r}: it must be a share from 0 up to, but not, 1")
        object.__setattr__(self, "quirks", frozenset(self.quirks))
        if unknown := sorted(self.quirks - set(QUIRKS)):
            raise SettingsError(f"quirk {unknown[0]!r} is unknown: use some of {', '.join(QUIRKS)}")
        if self.floor not in FLOORS:
            raise SettingsError(f"floor {self.floor!r} is unknown: use one of {', '.join(FLOORS)}")


#: Takes people in undistorted pixels of the camera given, and returns as many bodies, row for row. The mount says what
#: is known of the camera's place; the paper's estimators, which know of no floor, make nothing of it.
Method = Callable[[People, Camera, LocateSettings, Mount | None], Bodies]


def method_named(name: str) -> Method:
    """Return the function of a method; raises SettingsError for a name that is not in `METHODS`."""
    if name not in METHODS:
        raise SettingsError(f"method {name!r} is unknown: use one of {', '.join(METHODS)}")
    module, function = METHODS[name].split(":")
    return getattr(importlib.import_module(f"{__name__}.{module}"), function)
