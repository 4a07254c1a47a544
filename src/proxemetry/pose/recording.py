"""What a back end is that replays people found before: it knows of photos without their files, and maybe their cameras.

`measure` and an archive's workers ask for this type; a back end that wraps another hands its answers on.
"""

from __future__ import annotations

from typing import Protocol, runtime_checkable

from ..camera import Camera
from ..people import PoseBackend
from ..photo import Photo


@runtime_checkable
class Recording(PoseBackend, Protocol):
    """A pose back end that replays a recording."""

    @property
    def photos(self) -> tuple[str, ...]:
        """The names of the photos that can be measured without their files."""
        ...

    def photo(self, name: str) -> Photo:
        """Return one of them, without pixels; raises PhotoError where the recording does not state its size."""
        ...

    def camera_of(self, photo: Photo) -> Camera | None:
        """Return the camera that the recording states for a photo, in its full-size pixels, or None."""
        ...

    def why_no_people(self, photo: Photo) -> str | None:
        """Return why no person is found in a photo, None where the recording states that it is empty."""
        ...
