"""What was found out about a photo's camera: the one chosen, every candidate, and what is doubtful."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import StrEnum
from typing import Any

from .camera import Camera
from .mount import Mount
from .sources import Flag, Source


@dataclass(frozen=True)
class Candidate:
    """One answer to what the focal length is: pixels of the full-size photo, relative sd, and where it came from."""

    focal_px: float
    rel_sd: float
    source: Source


class Witness(StrEnum):
    """The sources of evidence on a photo's camera. The values are those of the JSON form."""

    FILE = "file"
    LINES = "lines"
    GRAVITY = "gravity"
    PEOPLE = "people"
    OTHERS = "others"
    PUBLISHED = "published"

    @property
    def words(self) -> str:
        """The source of evidence in words, and what it is evidence on."""
        return _WITNESSES[self]


_WITNESSES = {
    Witness.FILE: "the file",
    Witness.LINES: "focal length from straight lines",
    Witness.GRAVITY: "pitch and roll from straight lines",
    Witness.PEOPLE: "focal length from people",
    Witness.OTHERS: "other photos of the same camera",
    Witness.PUBLISHED: "published photos",
}


@dataclass(frozen=True)
class Testimony:
    """What a source of evidence says, or why nothing, in words. counted: whether it is part of the answer."""

    witness: Witness
    words: str
    counted: bool

    def __str__(self) -> str:
        return f"{self.witness.words}: {self.words}"

    @classmethod
    def from_dict(cls, fields: Mapping[str, Any]) -> Testimony:
        """Return the testimony that was written as a dict; raises ValueError for an unknown witness."""
        return cls(Witness(fields["witness"]), str(fields["words"]), bool(fields["counted"]))


@dataclass(frozen=True)
class CameraEstimate:
    """The camera chosen for a photo, every candidate, and what is doubtful.

    camera is None where no focal length is known; reason then states why and what to do. lens names the lens whose
    distortion is used, and its source; None if there is none. mount: what is known about the camera's place
    independently of the people, or None. why: the reason for the chosen candidate; testimony: what the picture and
    its people show. one_perspective: False if the file is known to be composed
    of several pictures; it is not stored with a scene.
    """

    camera: Camera | None
    candidates: tuple[Candidate, ...] = ()
    flags: tuple[Flag, ...] = ()
    reason: str | None = None
    lens: str | None = None
    mount: Mount | None = None
    why: str = ""
    testimony: tuple[Testimony, ...] = ()
    one_perspective: bool = field(default=True, compare=False)

    @property
    def source(self) -> Source | None:
        """Where the chosen focal length came from, None where none is known."""
        return None if self.camera is None else self.camera.source

    @property
    def is_assumed(self) -> bool:
        """Whether the focal length is a guess."""
        return self.camera is not None and self.camera.source.is_assumed

    @property
    def may_be_guessed(self) -> bool:
        """Whether there is a focal length to be found by other means: a photo sphere has none."""
        return self.one_perspective

    @property
    def is_doubtful(self) -> bool:
        """Whether anything is doubtful about the camera, a guessed focal length included."""
        return bool(self.flags) or self.is_assumed
