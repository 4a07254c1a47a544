"""What of the software is on this machine: `proxemetry doctor` without photos."""

from __future__ import annotations

import importlib.util
import platform

from .. import weights
from ..pose import AUTO_ORDER, BACKENDS, auto_name, is_available
from ..version import __version__

#: What a package is for, the package, and the extra that brings it.
_PACKAGES = (
    ("overlays and reports", "matplotlib", "plot"),
    ("the review page", "starlette", "web"),
    ("the review page", "uvicorn", "web"),
    ("more pose back ends", "onnxruntime", "onnx"),
    ("HEIC photos", "pi_heif", "heic"),
    ("raw photos", "rawpy", "raw"),
    ("SPSS files", "pyreadstat", "spss"),
)


def lines() -> list[str]:
    """Return what is here and what is missing, with what to do about it, as lines of text."""
    found = [f"proxemetry {__version__}, Python {platform.python_version()}, {platform.system()}"]
    missing = {purpose: extra for purpose, package, extra in _PACKAGES if importlib.util.find_spec(package) is None}
    here = dict.fromkeys(purpose for purpose, _, _ in _PACKAGES if purpose not in missing)
    found.append(f"can also do: {', '.join(here) or 'nothing'}")
    found += [f"cannot do: {purpose}; pip install 'proxemetry[{extra}]'" for purpose, extra in missing.items()]
    return [*found, *_networks()]


def _networks() -> list[str]:
    """Return who would find the people, and what of it is not here yet."""
    found = [f"networks lie in: {', '.join(map(str, weights.cache_folders()))}"]
    absent = [name for name in weights.EMBEDDED if weights.locate(name) is None]
    if absent:
        found.append(f"not here yet: {', '.join(absent)}; `proxemetry models fetch` gets them (needs the network once)")
    others = [name for name in AUTO_ORDER if is_available(name)]
    name = auto_name()
    if not others:
        return [*found, f"people would be found by: {name}, once its networks are here"]
    return [*found, f"people are found by: {name} ({BACKENDS[name].summary})", "nothing is missing for measuring"]
