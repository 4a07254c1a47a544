"""Which pictures are not those of one perspective: photo spheres, swept panoramas, fisheye lenses."""

from __future__ import annotations

import re

from ..photo import Photo
from ..photo.metadata import Metadata, Projection

#: Cameras whose only picture is a sphere, twice as wide as high.
_SPHERE_CAMERAS = re.compile(
    r"theta|insta360|gear ?360|SM-[CR]2[01]0|LG-R105|GoPro (fusion|max)|QooCam|VUZE|Mi Sphere|KeyMission 360", re.I
)
#: Wider than any cinema format: what is left of a picture by one lens is seldom such a strip.
_STRIP = 2.6
#: How lenses call themselves, in the makers' languages.
_FISHEYE = re.compile(r"fish[ -]?eye|fischauge|peleng|zenitar.*\b16|魚眼", re.I)
#: Cameras worn on the body, whose wide setting is a fisheye though no lens is named (GoPro: 122.6 degrees across where
#: a pinhole with its 15 mm equivalent would see 98), and the longest equivalent of that setting.
_ACTION_CAMERAS = re.compile(r"gopro|hero ?\d|sjcam|akaso|yi ?action|YDXJ|virb|osmo ?action|bebop|actioncam", re.I)
_ACTION_WIDE_MM = 19.0


def projection_of(photo: Photo) -> Projection | None:
    """Return how the picture was put together, None where it is one lens's."""
    metadata, aspect = photo.metadata, photo.width / photo.height
    if metadata.projection is not None:
        return metadata.projection
    if abs(aspect - 2) < 0.005 and _SPHERE_CAMERAS.search(_named(metadata)):
        return Projection.SPHERE
    return None


def is_strip(width_px: float, height_px: float) -> bool:
    """Whether a picture is so long that it was probably stitched from several."""
    return max(width_px, height_px) / min(width_px, height_px) >= _STRIP


def fisheye(metadata: Metadata) -> str | None:
    """Return what calls a photo's lens a fisheye, its name or the camera's wide setting; None where nothing does."""
    if metadata.lens is not None and _FISHEYE.search(metadata.lens):
        return metadata.lens
    if _ACTION_CAMERAS.search(_named(metadata)) and (metadata.focal_35mm or 0) <= _ACTION_WIDE_MM:
        return f"{metadata.model or metadata.make} in its wide setting"
    return None


def _named(metadata: Metadata) -> str:
    return f"{metadata.make or ''} {metadata.model or ''}"
