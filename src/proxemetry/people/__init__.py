"""People in pixels: their joints, the noise of a joint, and what a pose back end is."""

from .people import People, PoseBackend

__all__ = ["People", "PoseBackend"]
