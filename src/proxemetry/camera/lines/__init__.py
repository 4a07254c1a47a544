"""What the picture itself tells of its camera, by straight segments: gravity, and often the focal length."""

from .focal import FocalFromLines, focal_from_lines
from .gravity import Gravity, gravity_from_lines

__all__ = ["FocalFromLines", "Gravity", "focal_from_lines", "gravity_from_lines"]
