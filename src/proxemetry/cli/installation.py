"""What is installed on this machine: `proxemetry doctor` without photos."""

from __future__ import annotations

import importlib.util
import platform

from .. import weights
from ..camera.lens import require_lens_database
from ..errors import ModelError, SettingsError
from ..pose import BACKENDS, default_eyes, is_available
from ..version import __version__

#: What a package is for, the package, and the extra that brings it.
_PACKAGES = (
    ("overlays and reports", "matplotlib", "plot"),
    ("the review page", "starlette", "web"),
    ("the review page", "uvicorn", "web"),
    ("more pose back ends", "onnxruntime", "onnx"),
    ("HEIC photos", "pi_heif", "heic"),
    ("raw photos", "rawpy", "raw"),
    ("clips", "av", "video"),
    ("Excel workbooks", "xlsxwriter", "xlsx"),
    ("SPSS files", "pyreadstat", "spss"),
    ("SPSS files", "pandas", "spss"),
    ("data frames", "pandas", "notebook"),
)


def lines() -> list[str]:
    """Return what is here and what is missing, with what to do about it, as lines of text."""
    found = [f"proxemetry {__version__}, Python {platform.python_version()}, {platform.system()}"]
    missing = {purpose: extra for purpose, package, extra in _PACKAGES if importlib.util.find_spec(package) is None}
    here = dict.fromkeys(purpose for purpose, _, _ in _PACKAGES if purpose not in missing)
    found.append(f"also available: {', '.join(here) or 'nothing'}")
    found += [f"not available: {purpose}; pip install 'proxemetry[{extra}]'" for purpose, extra in missing.items()]
    found.append(f"networks are in: {', '.join(map(str, weights.cache_folders()))}")
    complete = True
    for part in (_eyes, _lens_database):
        try:
            said, is_here = part()
        except (ModelError, SettingsError) as error:
            said, is_here = [str(error)], False
        found += said
        complete = complete and is_here
    return [*found, "nothing is missing for measuring"] if complete else found


def _lens_database() -> tuple[list[str], bool]:
    """Return nothing to say, and that it can be loaded; raises SettingsError where it cannot."""
    require_lens_database()
    return [], True


def _eyes() -> tuple[list[str], bool]:
    """Return which back end would find the people, what is not here yet, and whether nothing is missing."""
    found: list[str] = []
    name = default_eyes.recorded()
    if name is None:
        here = next((eyes for eyes in default_eyes.EYES if is_available(eyes)), None)
        wanted = BACKENDS[default_eyes.EYES[0]].models
        absent = [model for model in wanted if not weights.is_here(model)]
        if absent:
            found.append(
                f"not here yet: {', '.join(absent)}; `proxemetry models fetch` gets them (needs an internet "
                "connection once)"
            )
        if here is None:
            return [*found, f"people would be found by: {default_eyes.EYES[0]}, once its networks are here"], False
        return [*found, f"people would be found by: {here}, until `proxemetry models fetch` gets a better one"], False
    absent = [model for model in BACKENDS[name].models if not weights.is_here(model)]
    if absent:
        return [*found, f"not here any more: {', '.join(absent)}; `proxemetry models fetch` gets them"], False
    return [*found, f"people are found by: {name} ({BACKENDS[name].summary})"], True
