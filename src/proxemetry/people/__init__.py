"""People in pixels: their joints, what a joint is worth, and what a pose back end is."""

from .people import People, PoseBackend

__all__ = ["People", "PoseBackend"]
