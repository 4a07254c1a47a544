"""The option that gives a benchmark more networks than those in the cache."""

from __future__ import annotations

import argparse
import os
from pathlib import Path

from proxemetry import weights


def add_models_option(parser: argparse.ArgumentParser) -> None:
    """Add `--models DIR`: networks are looked for in DIR too, by this process and those that it starts."""
    parser.add_argument("--models", type=_also_from, metavar="DIR", help="a folder with more networks")


def _also_from(text: str) -> Path:
    folder = Path(text).resolve()
    os.environ["PROXEMETRY_CACHE"] = os.pathsep.join([*map(str, weights.cache_folders()), str(folder)])
    return folder
