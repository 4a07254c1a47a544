"""Measure how far apart people stand in ordinary photographs.

    import proxemetry as px
    scene = px.measure("photo.jpg")
    scene.distances_m

Importing this loads nothing else: each name loads its module when it is first used, and networks' runtimes, plotting
and the web framework come when they are needed. Even `typing` would be too slow: until the command line begins, Ctrl-C
is a traceback. Packages that report to their makers are kept from it.
"""

from __future__ import annotations

import sys
from types import ModuleType

from . import telemetry
from .version import __version__

TYPE_CHECKING = False  # to a type checker it is that of `typing`
if TYPE_CHECKING:
    from typing import Any

    from .archive.figures.frames import ResultsFrames, measure_folder, read_results
    from .bodies import Bodies
    from .camera import Camera, CameraEstimate, Mount
    from .camera.focal import FocalRequest
    from .distances import Distances, zone_of
    from .errors import ProxemetryError
    from .locate import LocateSettings
    from .measure import measure, remeasure
    from .people import People, PoseBackend
    from .people.skeleton import SKELETONS, Skeleton
    from .photo import Photo
    from .scene import Scene
    from .settings import Settings

__all__ = [
    "SKELETONS",
    "Bodies",
    "Camera",
    "CameraEstimate",
    "Distances",
    "FocalRequest",
    "LocateSettings",
    "Mount",
    "People",
    "Photo",
    "PoseBackend",
    "ProxemetryError",
    "ResultsFrames",
    "Scene",
    "Settings",
    "Skeleton",
    "__version__",
    "measure",
    "measure_folder",
    "read_results",
    "remeasure",
    "zone_of",
]

telemetry.turn_off()

#: Name -> the module that it comes from; the same as above.
_HOME = {
    "SKELETONS": "people.skeleton",
    "Bodies": "bodies",
    "Camera": "camera",
    "CameraEstimate": "camera",
    "Distances": "distances",
    "FocalRequest": "camera.focal",
    "LocateSettings": "locate",
    "Mount": "camera",
    "People": "people",
    "Photo": "photo",
    "PoseBackend": "people",
    "ProxemetryError": "errors",
    "ResultsFrames": "archive.figures.frames",
    "Scene": "scene",
    "Settings": "settings",
    "Skeleton": "people.skeleton",
    "measure": "measure",
    "measure_folder": "archive.figures.frames",
    "read_results": "archive.figures.frames",
    "remeasure": "measure",
    "zone_of": "distances",
}


def __getattr__(name: str) -> Any:
    import importlib

    if name not in _HOME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value = getattr(importlib.import_module(f"{__name__}.{_HOME[name]}"), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})


class _Package(ModuleType):
    """The package as a module: `proxemetry.measure` is the function, also once the module of that name is loaded."""

    def __setattr__(self, name: str, value: object) -> None:
        # Importing a.b sets b on a, which would hide the name that a gives out itself.
        if not (name in _HOME and isinstance(value, ModuleType)):
            super().__setattr__(name, value)


sys.modules[__name__].__class__ = _Package
