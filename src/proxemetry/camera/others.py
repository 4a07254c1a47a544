"""What other photos of a run show about a photo's camera: those of the same model by their files, those of one shoot by
the people in them."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
from typing import Any

from ..intervals import HALF_WIDTH_SD
from .mount import Mount

#: Fewer photos than this that state a sensor do not count: one of two files is wrong often enough.
LEAST_PHOTOS = 3
#: Sensors behind one model's name are one where their crop factors differ by no more than this.
_ONE_SENSOR = 0.05
#: Focal lengths that belong to one lens of a phone: the tag is rounded.
_SAME_MM = 0.02


@dataclass(frozen=True)
class CropRange:
    """The crop factor at one focal length, by so many photos: between low and high (10 and 90 %)."""

    focal_mm: float
    low: float
    high: float
    photos: int


@dataclass(frozen=True)
class SameModel:
    """What the files of photos of one camera model record, without doubtful ones. crops: by focal length, rising."""

    make: str
    model: str
    crops: tuple[CropRange, ...]

    def crop_at(self, focal_mm: float) -> CropRange | None:
        """Return the crop factor of a photo of this model, None where too few show it or they disagree.

        A phone has a sensor for each lens: photos with the same focal length are used first, and all of them together
        where they agree.
        """
        near = [c for c in self.crops if abs(math.log(c.focal_mm / focal_mm)) <= _SAME_MM]
        for told in (near, list(self.crops)):
            photos = sum(c.photos for c in told)
            if photos >= LEAST_PHOTOS:
                low, high = min(c.low for c in told), max(c.high for c in told)
                if math.log(high / low) <= _ONE_SENSOR:
                    return CropRange(focal_mm, low, high, photos)
        return None

    @property
    def equivalents(self) -> tuple[tuple[float, int], ...]:
        """The 35 mm equivalents of its photos, with how many have each."""
        return tuple((c.focal_mm * math.sqrt(c.low * c.high), c.photos) for c in self.crops)


@dataclass(frozen=True)
class SameShoot:
    """What the people in many photos of one size show about their one camera (that it is one, the user states).

    log_focal_px, log_sd: of the focal length in pixels. photos, people: how many it rests on, people counted as no more
    than one photo shows at once where it is unknown who recurs. mount: where the camera stood, of the photos that show
    the same background; None where it moved.
    """

    log_focal_px: float
    log_sd: float
    photos: int
    people: int
    mount: Mount | None = None

    @property
    def without_place(self) -> SameShoot:
        """The same of a photo that was taken from elsewhere."""
        return replace(self, mount=None)

    @property
    def text(self) -> str:
        """The focal length with its interval, in words."""
        low, high = (math.exp(self.log_focal_px + side * HALF_WIDTH_SD * self.log_sd) for side in (-1, 1))
        return f"focal length estimated from the people of {self.photos} photos: {low:.0f} to {high:.0f} px"


@dataclass(frozen=True)
class Others:
    """What other photos show about one photo's camera. shoot: its mount is there only if it holds for this photo."""

    model: SameModel | None = None
    shoot: SameShoot | None = None


def model_to_dict(model: SameModel) -> dict[str, Any]:
    """Return it as JSON values."""
    return asdict(model)


def model_from_dict(fields: Mapping[str, Any]) -> SameModel:
    """Read what `model_to_dict` wrote."""
    return SameModel(fields["make"], fields["model"], tuple(CropRange(**crop) for crop in fields["crops"]))


def shoot_to_dict(shoot: SameShoot) -> dict[str, Any]:
    """Return it as JSON values."""
    fields = {name: getattr(shoot, name) for name in ("log_focal_px", "log_sd", "photos", "people")}
    return {**fields, "mount": None if shoot.mount is None else shoot.mount.to_dict()}


def shoot_from_dict(fields: Mapping[str, Any]) -> SameShoot:
    """Read what `shoot_to_dict` wrote."""
    mount = None if fields["mount"] is None else Mount.from_dict(fields["mount"])
    known = {name: fields[name] for name in ("log_focal_px", "log_sd", "photos", "people")}
    return SameShoot(**known, mount=mount)
