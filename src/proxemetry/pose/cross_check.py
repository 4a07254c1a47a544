"""A person counts only where two models agree: the paper's idea (Seker et al. 2021), for any pair of models.

`cross-check:A+B` keeps those people found by A that B finds too.
"""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from ..camera import Camera
from ..errors import PhotoError, SettingsError
from ..people import People, PoseBackend
from ..people.skeleton import Skeleton
from ..photo import Photo
from . import PoseOptions, backend_named
from .confirmation import confirmed_by_people
from .recording import Recording


class CrossChecked:
    """The people of one back end that another finds too, matched one to one."""

    def __init__(self, first: PoseBackend, second: PoseBackend) -> None:
        self.first, self.second = first, second

    @property
    def name(self) -> str:
        """Both names."""
        return f"cross-check:{self.first.name}+{self.second.name}"

    @property
    def skeleton(self) -> Skeleton:
        """The first back end's."""
        return self.first.skeleton

    @property
    def models(self) -> Mapping[str, str]:
        """Those of both back ends."""
        return MappingProxyType({**self.first.models, **self.second.models})

    def detect(self, photo: Photo) -> People:
        """Return the first back end's people that the second finds too; the second is not run where there are none."""
        people = self.first.detect(photo)
        return confirmed_by_people(people, self.second.detect(photo)) if len(people) else people


class CrossCheckedRecording(CrossChecked):
    """The same where one of the two replays a recording: what else that knows of a photo is passed on."""

    @property
    def photos(self) -> tuple[str, ...]:
        """Those of the first back end; the second cannot do without files where the first looks at them."""
        return self.first.photos if isinstance(self.first, Recording) else ()

    def photo(self, name: str) -> Photo:
        """Return the first back end's photo; raises PhotoError where it needs the file or does not state its size."""
        if isinstance(self.first, Recording):
            return self.first.photo(name)
        raise PhotoError(f"{name}: no file, and {self.first.name} looks at the photo")

    def camera_of(self, photo: Photo) -> Camera | None:
        """Return the camera that the first recording to state one states."""
        recordings = (backend for backend in (self.first, self.second) if isinstance(backend, Recording))
        return next((camera for r in recordings if (camera := r.camera_of(photo)) is not None), None)

    def why_no_people(self, photo: Photo) -> str | None:
        """Return why neither recording has people there, None where that is not for lack of a record."""
        recordings = (backend for backend in (self.first, self.second) if isinstance(backend, Recording))
        return next((why for r in recordings if (why := r.why_no_people(photo)) is not None), None)


def cross_checked(first: PoseBackend, second: PoseBackend) -> CrossChecked:
    """Return the back end of the first one's people that the second one confirms."""
    replays = isinstance(first, Recording) or isinstance(second, Recording)
    return (CrossCheckedRecording if replays else CrossChecked)(first, second)


def open_backend(argument: str, options: PoseOptions) -> CrossChecked:
    """Return the back end of `cross-check:FIRST+SECOND`; raises SettingsError where there are not two names."""
    names = argument.split("+")
    if len(names) != 2 or not all(names):
        raise SettingsError(f"--pose cross-check:{argument}: write cross-check:FIRST+SECOND")
    return cross_checked(backend_named(names[0], options), backend_named(names[1], options))
