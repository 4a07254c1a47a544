"""From a photo to its camera: intrinsics, and everything that decides which focal length is used."""

from .camera import NO_DISTORTION, Camera, CameraEstimate, Candidate

__all__ = ["NO_DISTORTION", "Camera", "CameraEstimate", "Candidate"]
