"""What straight segments in the picture show about its camera: gravity, and often the focal length."""

from .focal import FocalFromLines, focal_from_lines
from .gravity import Gravity, gravity_from_lines

__all__ = ["FocalFromLines", "Gravity", "focal_from_lines", "gravity_from_lines"]
