"""Making networks of their parts on the user's machine, and placing what was made like what was fetched."""

from __future__ import annotations

import importlib
from collections.abc import Callable

from ..errors import ModelError
from .cache import open_for_placing, verify
from .table import Model


def make(model: Model) -> None:
    """Make a network of its parts, which are here, and place it once its hash is that of the table.

    Raises ModelError where a part is damaged, or what came out is not what the table knows.
    """
    conversion = model.conversion
    if conversion is None:
        raise ModelError(f"{model.name}: it is not made of parts")
    parts = [verify(part).path.read_bytes() for part in conversion.parts]
    module = importlib.import_module(f"{__package__}.conversion.{conversion.kind}")
    converted: Callable[..., bytes] = module.converted
    size = () if conversion.input_size is None else (conversion.input_size,)
    with open_for_placing(model) as placing:
        placing.temporary.write_bytes(converted(*parts, *size))
        placing.place()
