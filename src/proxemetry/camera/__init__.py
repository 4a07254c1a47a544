"""From a photo to its camera: intrinsics, and everything that decides which focal length is used."""

from .camera import NO_DISTORTION, Camera, CameraEstimate, Candidate
from .sources import Doubt, Flag, FocalSource, Source

__all__ = ["NO_DISTORTION", "Camera", "CameraEstimate", "Candidate", "Doubt", "Flag", "FocalSource", "Source"]
