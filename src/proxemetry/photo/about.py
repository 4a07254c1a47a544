"""What a photo's metadata state of the picture itself, as it is copied into the results."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class About:
    """When and where a photo was taken and who made it, as its own metadata state; None where they state nothing.

    date: ISO 8601. camera_make, camera_model, focal_mm, digital_zoom: as the file has them of its camera. creator,
    caption, people (the names of those shown) and the coordinates of the place are there only where asked for.
    """

    date: str | None = None
    country: str | None = None
    city: str | None = None
    source: str | None = None
    creator: str | None = None
    caption: str | None = None
    people: tuple[str, ...] = ()
    latitude_deg: float | None = None
    longitude_deg: float | None = None
    camera_make: str | None = None
    camera_model: str | None = None
    focal_mm: float | None = None
    digital_zoom: float | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "people", tuple(self.people))
