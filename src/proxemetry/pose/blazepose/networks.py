"""Running the networks with LiteRT."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...errors import ModelError
from ...files import read_bytes, reason_of
from ..litert import interpreter
from .pruning import without_output

Float32Array = NDArray[np.float32]


class Network:
    """One network: NHWC float32 in, its outputs by number of elements out. Not for several threads at once."""

    def __init__(self, path: Path, threads: int, without: int | None = None) -> None:
        """Load a network, `without` the output of that many elements where one is named."""
        try:
            content = read_bytes(path)
        except OSError as error:
            raise ModelError(f"{path}: cannot be read ({reason_of(error)})") from error
        kept = content if without is None else without_output(content, without)
        self._interpreter: Any = interpreter(kept, threads, str(path))
        details = self._interpreter.get_input_details()[0]
        self._input = details["index"]
        self.side = int(details["shape"][1])
        outputs = self._interpreter.get_output_details()
        self._outputs = [d["index"] for d in outputs]
        sizes = [int(np.prod(d["shape"])) for d in outputs]
        if len(set(sizes)) < len(sizes):
            raise ModelError(f"{path}: outputs of {sizes} elements: two of one size cannot be distinguished")

    def __call__(self, image: Float32Array) -> dict[int, Float32Array]:
        """Run one input of shape (side, side, 3)."""
        self._interpreter.set_tensor(self._input, image[None])
        self._interpreter.invoke()
        outputs = [self._interpreter.get_tensor(index) for index in self._outputs]
        return {output.size: output for output in outputs}
