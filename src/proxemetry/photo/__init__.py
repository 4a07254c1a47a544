"""A photo: its formats, what its metadata state, upright pixels and hash."""

from .photo import EXTENSIONS, LARGEST_PX, Metadata, Photo, RGBArray

__all__ = ["EXTENSIONS", "LARGEST_PX", "Metadata", "Photo", "RGBArray"]
