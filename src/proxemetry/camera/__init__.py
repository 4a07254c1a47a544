"""From a photo to its camera: intrinsics, and everything that decides which focal length is used."""

from .camera import NO_DISTORTION, Camera
from .estimate import CameraEstimate, Candidate, Testimony, Witness
from .floor_frame import FloorFrame
from .mount import Mount
from .sources import Doubt, Flag, FocalBasis, FocalSource, Source

__all__ = [
    "NO_DISTORTION",
    "Camera",
    "CameraEstimate",
    "Candidate",
    "Doubt",
    "Flag",
    "FloorFrame",
    "FocalBasis",
    "FocalSource",
    "Mount",
    "Source",
    "Testimony",
    "Witness",
]
