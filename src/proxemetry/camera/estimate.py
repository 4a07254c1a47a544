"""What was found out about a photo's camera: the one chosen, every candidate, and what is doubtful."""

from __future__ import annotations

from dataclasses import dataclass

from .camera import Camera
from .mount import Mount
from .sources import Doubt, Flag, Source


@dataclass(frozen=True)
class Candidate:
    """One answer to what the focal length is: pixels of the full-size photo, relative sd, and where it came from."""

    focal_px: float
    rel_sd: float
    source: Source


@dataclass(frozen=True)
class CameraEstimate:
    """The camera chosen for a photo, every candidate, and what is doubtful.

    camera is None where no focal length is known; reason then says so and what to do. lens says whose distortion the
    camera has, and where it is from; None where it has none. mount: what is known of the camera's place before the
    people are seen, or None. why says what spoke for the chosen candidate.
    """

    camera: Camera | None
    candidates: tuple[Candidate, ...] = ()
    flags: tuple[Flag, ...] = ()
    reason: str | None = None
    lens: str | None = None
    mount: Mount | None = None
    why: str = ""

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
        """Whether there is a focal length to be found by other means: a panorama has none."""
        return not any(flag.doubt is Doubt.PROJECTION for flag in self.flags)

    @property
    def is_doubtful(self) -> bool:
        """Whether anything is doubtful about the camera, a guessed focal length included."""
        return bool(self.flags) or self.is_assumed
