"""Measure how far apart people stand in ordinary photographs.

    import proxemetry as px
    scene = px.measure("photo.jpg")
    scene.distances_m

Importing this loads no network's runtime, no plotting and no web framework; those come when they are used.
"""

from .bodies import Bodies
from .camera import Camera, CameraEstimate
from .camera.focal import FocalRequest
from .distances import Distances, zone_of
from .errors import ProxemetryError
from .locate import LocateSettings
from .measure import Settings, measure, remeasure
from .people import People, PoseBackend
from .people.skeleton import SKELETONS, Skeleton
from .photo import Photo
from .scene import Scene
from .version import __version__

__all__ = [
    "SKELETONS",
    "Bodies",
    "Camera",
    "CameraEstimate",
    "Distances",
    "FocalRequest",
    "LocateSettings",
    "People",
    "Photo",
    "PoseBackend",
    "ProxemetryError",
    "Scene",
    "Settings",
    "Skeleton",
    "__version__",
    "measure",
    "remeasure",
    "zone_of",
]
