"""Running the networks with LiteRT."""

from __future__ import annotations

import os
import sys
import threading
from collections.abc import Generator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...errors import ModelError
from .pruning import without_output

Float32Array = NDArray[np.float32]

_LOADING = threading.Lock()


class Network:
    """One network: NHWC float32 in, its outputs by number of elements out. Not for several threads at once."""

    def __init__(self, path: Path, threads: int, without: int | None = None) -> None:
        """Load a network, `without` the output of that many elements where one is named."""
        from ai_edge_litert.interpreter import Interpreter  # type: ignore[import-untyped]

        try:
            with _LOADING, _without_banner():
                content = path.read_bytes()
                kept = content if without is None else without_output(content, without)
                self._interpreter: Any = Interpreter(model_content=kept, num_threads=threads)
                self._interpreter.allocate_tensors()
        except (ValueError, RuntimeError) as error:
            raise ModelError(f"{path}: LiteRT cannot load it ({error})") from error
        details = self._interpreter.get_input_details()[0]
        self._input = details["index"]
        self.side = int(details["shape"][1])
        self._outputs = [d["index"] for d in self._interpreter.get_output_details()]

    def __call__(self, image: Float32Array) -> dict[int, Float32Array]:
        """Run one input of shape (side, side, 3)."""
        self._interpreter.set_tensor(self._input, image[None])
        self._interpreter.invoke()
        outputs = [self._interpreter.get_tensor(index) for index in self._outputs]
        return {output.size: output for output in outputs}


@contextmanager
def _without_banner() -> Generator[None, None, None]:
    """Keep the line that the runtime's C++ writes on loading out of the user's terminal."""
    try:
        sys.stderr.flush()
        kept = os.dup(2)
    except (OSError, ValueError, AttributeError):  # no standard error to protect
        yield
        return
    silent = os.open(os.devnull, os.O_WRONLY)
    try:
        os.dup2(silent, 2)
        yield
    finally:
        os.dup2(kept, 2)
        os.close(kept)
        os.close(silent)
