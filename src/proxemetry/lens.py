"""What lensfun's database knows of cameras and lenses: crop factors and lens distortion."""

from __future__ import annotations

from functools import lru_cache
from typing import Any


@lru_cache(maxsize=1)
def _database() -> Any:
    """Return lensfun's database; reading it takes a tenth of a second, so only where a photo needs it."""
    import lensfunpy

    return lensfunpy.Database()  # pyright: ignore[reportAttributeAccessIssue]


@lru_cache(maxsize=256)
def _camera(make: str, model: str) -> Any | None:
    """Return lensfun's entry of a camera named as EXIF names it, or None."""
    for name in (model, f"{make} {model}"):
        found = _database().find_cameras(make, name)
        if found:
            return found[0]
    return None


def _has_fixed_lens(camera: Any) -> bool:
    """Tell a compact camera or a phone: lensfun gives each a mount of its own, beginning with a small letter."""
    return bool(camera.mount) and camera.mount[0].islower()


@lru_cache(maxsize=1024)
def crop_factor(make: str | None, model: str | None, focal_mm: float) -> float | None:
    """Return the ratio of 43.267 mm to the diagonal of a camera's sensor, or None where the camera is unknown.

    A phone has several sensors behind one model name: an entry counts only where its lens has that focal length.
    """
    camera = _camera(make or "", model) if model else None
    if camera is None:
        return None
    if _has_fixed_lens(camera):
        lenses = _database().find_lenses(camera)
        if lenses and not any(0.97 * lens.min_focal <= focal_mm <= 1.03 * lens.max_focal for lens in lenses):
            return None
    return float(camera.crop_factor)
