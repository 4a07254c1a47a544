"""Where a focal length came from and what is doubtful about a camera, as types; text is made of them when printed."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from enum import StrEnum
from typing import Any


class FocalBasis(StrEnum):
    """What a focal length rests on: a statement, the photo's file, the picture or others of the camera, or a guess."""

    STATED = "stated"
    RECORDED = "recorded"
    ESTIMATED = "estimated"
    ASSUMED = "assumed"


class FocalSource(StrEnum):
    """What gave a focal length. The values are those of the JSON form."""

    USER = "user"
    CAMERA_TABLE = "camera_table"
    KEYPOINT_FILE = "keypoint_file"
    LABELS = "labels"
    FOCAL_PLANE = "focal_plane"
    EQUIVALENT = "equivalent_35mm"
    CROP_FACTOR = "crop_factor"
    PEOPLE = "people"
    LINES = "lines"
    SAME_CAMERA = "same_camera"
    PEOPLE_OF_PHOTOS = "people_of_photos"
    ASSUMED_EQUIVALENT = "assumed_equivalent"
    ASSUMED_FOV = "assumed_fov"
    ASSUMED_PRIOR = "assumed_prior"

    @property
    def words(self) -> str:
        """The source as a person reads it."""
        return _WORDS[self]

    @property
    def is_stated(self) -> bool:
        """Whether a person stated it, rather than the photo's file."""
        return self in (FocalSource.USER, FocalSource.CAMERA_TABLE, FocalSource.KEYPOINT_FILE, FocalSource.LABELS)

    @property
    def is_recorded(self) -> bool:
        """Whether the photo's metadata gave it."""
        return self in (FocalSource.FOCAL_PLANE, FocalSource.EQUIVALENT, FocalSource.CROP_FACTOR)

    @property
    def is_estimated(self) -> bool:
        """Whether it was found out from what photos show: people, straight lines, other photos of the camera."""
        return self in (FocalSource.PEOPLE, FocalSource.LINES, FocalSource.SAME_CAMERA, FocalSource.PEOPLE_OF_PHOTOS)

    @property
    def is_assumed(self) -> bool:
        """Whether it is a guess: neither measured nor recorded."""
        return self in (FocalSource.ASSUMED_EQUIVALENT, FocalSource.ASSUMED_FOV, FocalSource.ASSUMED_PRIOR)

    @property
    def is_evidence(self) -> bool:
        """Whether it is evidence on this very camera: a user's rough guess is, the spread of all photos is not."""
        return self is not FocalSource.ASSUMED_PRIOR

    @property
    def basis(self) -> FocalBasis:
        """What it rests on, the one of four that counts are made by."""
        if self.is_stated:
            return FocalBasis.STATED
        if self.is_recorded:
            return FocalBasis.RECORDED
        return FocalBasis.ESTIMATED if self.is_estimated else FocalBasis.ASSUMED


_WORDS = {
    FocalSource.USER: "user",
    FocalSource.CAMERA_TABLE: "camera table",
    FocalSource.KEYPOINT_FILE: "keypoint file",
    FocalSource.LABELS: "labels",
    FocalSource.FOCAL_PLANE: "EXIF focal length and focal plane resolution",
    FocalSource.EQUIVALENT: "EXIF 35 mm equivalent",
    FocalSource.CROP_FACTOR: "EXIF focal length and crop factor",
    FocalSource.PEOPLE: "estimated from people",
    FocalSource.LINES: "estimated from straight lines",
    FocalSource.SAME_CAMERA: "estimated from other photos of the same camera",
    FocalSource.PEOPLE_OF_PHOTOS: "estimated from the people of",
    FocalSource.ASSUMED_EQUIVALENT: "ASSUMED: 35 mm equivalent",
    FocalSource.ASSUMED_FOV: "ASSUMED: field of view",
    FocalSource.ASSUMED_PRIOR: "ASSUMED: like published photos",
}
#: Sources that name themselves before what follows; the others read on.
_WITH_COLON = (FocalSource.USER, FocalSource.PEOPLE, FocalSource.LINES, FocalSource.SAME_CAMERA)


@dataclass(frozen=True)
class Source:
    """A focal length's source with its particulars: "user: focal length in pixels".

    detail: for print alone. reviewed: a reviewer stated it for this photo.
    """

    kind: FocalSource
    detail: str = ""
    reviewed: bool = False

    def __str__(self) -> str:
        between = ": " if self.kind in _WITH_COLON else " "
        return f"{'review: ' if self.reviewed else ''}{self.kind.words}{between if self.detail else ''}{self.detail}"

    @property
    def is_assumed(self) -> bool:
        """Whether the focal length is a guess."""
        return self.kind.is_assumed

    @classmethod
    def from_dict(cls, fields: Mapping[str, Any]) -> Source:
        """Return the source that was written as a dict; raises ValueError for an unknown kind, or odd values."""
        detail, reviewed = fields["detail"], fields["reviewed"]
        if not isinstance(detail, str) or not isinstance(reviewed, bool):
            raise ValueError("the source of a focal length has a text as its detail, and is reviewed or not")
        return cls(FocalSource(fields["kind"]), detail, reviewed)


class Doubt(StrEnum):
    """What may be wrong with a camera. The values are those of the JSON form."""

    ASSUMED = "assumed"
    CONTRADICTED = "contradicted"
    ESTIMATED = "estimated"
    METADATA = "metadata"
    SENSOR = "sensor"
    CROPPED = "cropped"
    ZOOMED = "zoomed"
    LENS = "lens"
    MOUNT = "mount"
    DEPTH = "depth"
    PROJECTION = "projection"
    OTHER = "other"

    @property
    def is_settled_by_focal(self) -> bool:
        """Whether a focal length that is stated anew settles it; crops, digital zooms and lenses stay."""
        return self in (Doubt.ASSUMED, Doubt.CONTRADICTED, Doubt.ESTIMATED, Doubt.METADATA, Doubt.SENSOR)


@dataclass(frozen=True)
class Flag:
    """One doubt about a camera, and in words what it is about."""

    doubt: Doubt
    text: str

    def __str__(self) -> str:
        return self.text

    @classmethod
    def from_dict(cls, fields: Mapping[str, Any]) -> Flag:
        """Return the flag that was written as a dict; raises ValueError for an unknown doubt."""
        return cls(Doubt(fields["doubt"]), fields["text"])
