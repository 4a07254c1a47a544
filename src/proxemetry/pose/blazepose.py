"""The embedded pose back end."""

from __future__ import annotations

from ..errors import ModelError
from ..people import PoseBackend
from . import PoseOptions


def open_backend(argument: str, options: PoseOptions) -> PoseBackend:
    """Return the embedded back end."""
    raise ModelError("blazepose: not there yet")
