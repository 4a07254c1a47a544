"""A photo: its formats, what its metadata state, upright pixels and hash."""

from .photo import EXTENSIONS, Metadata, Photo, RGBArray

__all__ = ["EXTENSIONS", "Metadata", "Photo", "RGBArray"]
