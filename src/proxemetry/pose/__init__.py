"""The pose back ends by name, loaded when asked for.

A back end's name may carry an argument after a colon: `recorded:FILE`, `python:MODULE:FUNCTION`.
"""

from __future__ import annotations

import importlib
from collections.abc import Callable

from ..errors import SettingsError
from ..people import PoseBackend
from .registry import BACKENDS, DEVICES, EFFORTS, Entry, PoseOptions, available, is_available, lacking, replays

__all__ = [
    "BACKENDS",
    "DEVICES",
    "EFFORTS",
    "Entry",
    "PoseOptions",
    "available",
    "backend_named",
    "is_available",
    "lacking",
    "replays",
]


def backend_named(name: str, options: PoseOptions | None = None) -> PoseBackend:
    """Return the back end of that name, ready to detect.

    `auto` is the back end that was chosen on this machine (`default_eyes`); where none was, it is chosen now.
    Raises SettingsError for a name that is not in `BACKENDS` or an option that it does not take, ModelError where a
    network is absent or damaged, KeypointsError where recorded keypoints are malformed.
    """
    if name == "auto":
        from .default_eyes import chosen

        name = chosen(offline=options.offline if options else False)
    key, _, argument = name.partition(":")
    if key not in BACKENDS:
        raise SettingsError(f"pose back end {name!r} is unknown: use auto or one of {', '.join(BACKENDS)}")
    options = options or PoseOptions()
    _check_options(key, options)
    module, attribute = BACKENDS[key].target.split(":")
    factory: Callable[[str, PoseOptions], PoseBackend] = getattr(
        importlib.import_module(f"{__name__}.{module}"), attribute
    )
    return factory(argument or BACKENDS[key].argument, options)


def _check_options(key: str, options: PoseOptions) -> None:
    """Refuse what a back end would ignore silently: a user who asks for a GPU would believe that it is used."""
    takes = BACKENDS[key].takes
    if options.device != "cpu" and "device" not in takes:
        raise SettingsError(f"pose back end {key} runs on the processor alone, not on {options.device!r}")
    if options.flip and "flip" not in takes:
        raise SettingsError(f"pose back end {key} cannot look at a mirrored photo: leave flip out")
