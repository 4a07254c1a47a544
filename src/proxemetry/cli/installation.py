"""What is installed on this machine: `proxemetry doctor` without photos."""

from __future__ import annotations

import importlib.util
import platform

from .. import weights
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
    return [*found, *_networks()]


def _networks() -> list[str]:
    """Return where the networks are, and which back end would find the people, or what is in the way."""
    found = [f"networks are in: {', '.join(map(str, weights.cache_folders()))}"]
    try:
        return [*found, *_eyes()]
    except (ModelError, SettingsError) as error:
        return [*found, str(error)]


def _eyes() -> list[str]:
    """Return which back end would find the people, and which of its networks are not here yet."""
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
            return [*found, f"people would be found by: {default_eyes.EYES[0]}, once its networks are here"]
        return [*found, f"people would be found by: {here}, until `proxemetry models fetch` gets a better one"]
    absent = [model for model in BACKENDS[name].models if not weights.is_here(model)]
    if absent:
        return [*found, f"not here any more: {', '.join(absent)}; `proxemetry models fetch` gets them"]
    return [*found, f"people are found by: {name} ({BACKENDS[name].summary})", "nothing is missing for measuring"]
