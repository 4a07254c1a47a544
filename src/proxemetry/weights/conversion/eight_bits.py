"""A TensorFlow Lite network whose convolutions hold their weights in 8 bits and compute in whole numbers.

Each output channel has a scale of its own, by which its largest weight is 127. What comes into such a layer the runtime
rounds to 8 bits too, by the range that it finds in it; sums, biases and all between layers keep 32 bits. That is what
TensorFlow Lite calls dynamic range quantization (Jacob et al. 2018); processors multiply small whole numbers faster.

The file is not written anew: the weights take the first quarter of their old place, tensors' new descriptions are
appended, and the offsets that led to the old ones lead to those. Numbers of
fields, operators and types are those of tensorflow/lite/schema/schema.fbs.
"""

from __future__ import annotations

import struct
from collections import Counter
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from ...errors import ModelError
from .flatbuffer import Floats, Ints, Longs, Number, Reader, Table, Writer

_CONVOLUTION, _DEQUANTIZE = 3, 6
_FLOAT32, _FLOAT16, _INT8 = 0, 1, 9
_STORED = {_FLOAT32: np.dtype("<f4"), _FLOAT16: np.dtype("<f2")}
#: The largest weight of a channel; -128 is left out, so that both signs are alike.
_TOP = 127
#: A convolution with fewer weights in each output channel stays as it is: rounding its input costs more than it saves
#: (`benchmarks/speed/eight_bits.py`), and joints scatter more.
LEAST_WEIGHTS = 64


def in_eight_bits(content: bytes, least_weights: int = LEAST_WEIGHTS) -> bytes:
    """Return the network with its convolutions' weights in 8 bits; those of small and of depthwise ones stay.

    least_weights: fewer in each output channel make a convolution small.
    Weights that are stored in 16 bits and widened by a layer of their own are read too. Weights that something else
    uses as well stay as they are. Raises ModelError where the file is no TensorFlow Lite network.
    """
    try:
        graph = _Graph(content)
        for convolution in graph.operators(_CONVOLUTION):
            graph.narrow(convolution, least_weights)
    except (struct.error, IndexError, ValueError) as error:
        raise ModelError(f"the TensorFlow Lite file is damaged or of another kind ({error})") from error
    return bytes(graph.writer.content)


class _Graph:
    """The first graph of a network: places in the file of its tensors, buffers and operators."""

    def __init__(self, content: bytes) -> None:
        self.writer = Writer(content)
        file = self._file = Reader(self.writer.content)
        model = file.led_to(0)
        self._codes = [self._code(table) for table in file.tables(model, 1)]
        graphs = file.tables(model, 2)
        self._buffers = file.slots(model, 4)
        self._tensors, self._operators = file.slots(graphs[0], 0), file.slots(graphs[0], 3)
        self._users = Counter(index for place in self._operators for index in file.ints(file.led_to(place), 1))
        self._users.update(file.ints(graphs[0], 2))
        self._holders = Counter(file.number(tensor, 2, "I") for graph in graphs for tensor in file.tables(graph, 0))
        #: Which operator widens stored weights into a tensor.
        self._widened = {file.ints(table, 2)[0]: table for table in self.operators(_DEQUANTIZE)}

    def operators(self, kind: int) -> Iterator[int]:
        """Yield where the operators of a kind begin."""
        for place in self._operators:
            table = self._file.led_to(place)
            if self._codes[self._file.number(table, 0, "I")] == kind:
                yield table

    def narrow(self, convolution: int, least_weights: int) -> None:
        """Let a convolution have its weights in 8 bits, where they are constants of its own and it is not small."""
        _, filter_, *_ = self._file.ints(convolution, 1)
        widening = self._widened.get(filter_)
        stored = filter_ if widening is None else self._file.ints(widening, 1)[0]
        tensor = self._file.led_to(self._tensors[stored])
        type_, buffer = self._file.number(tensor, 1, "b"), self._file.number(tensor, 2, "I")
        alone = self._users[filter_] == self._users[stored] == self._holders[buffer] == 1
        raw = self._file.bytes(self._file.led_to(self._buffers[buffer]), 0)
        shape = self._file.ints(tensor, 0)
        is_small = np.prod(shape[1:]) < least_weights
        if type_ not in _STORED or not alone or not raw or is_small:
            return
        narrow, scales = _quantized(np.frombuffer(raw, _STORED[type_]).reshape(shape).astype(np.float32))
        quantization = Table({2: Floats(scales.tolist()), 3: Longs([0] * len(scales)), 6: Number(0)})
        fields = {0: Ints(shape), 1: Number(_INT8, "b"), 2: Number(buffer, "I"), 4: quantization}
        self._shorten(self._file.led_to(self._buffers[buffer]), narrow.tobytes())
        self.writer.point(self._tensors[stored], self.writer.table(Table(fields)))
        if widening is not None:
            self._drop(widening)
            struct.pack_into("<i", self.writer.content, self._file.vector(convolution, 1)[0] + 4, stored)

    def _shorten(self, buffer: int, narrow: bytes) -> None:
        """Put fewer bytes in the place of a buffer's."""
        begin, _ = self._file.vector(buffer, 0)
        struct.pack_into("<I", self.writer.content, begin - 4, len(narrow))
        self.writer.content[begin : begin + len(narrow)] = narrow

    def _drop(self, operator: int) -> None:
        """Take an operator out of the list of those that run."""
        targets = [self._file.led_to(place) for place in self._operators if self._file.led_to(place) != operator]
        count_at = self._operators[0] - 4
        struct.pack_into("<I", self.writer.content, count_at, len(targets))
        self._operators = self._operators[: len(targets)]
        for place, target in zip(self._operators, targets, strict=True):
            self.writer.point(place, target)

    def _code(self, table: int) -> int:
        """Return an operator's number, which files of before 2020 have in a byte."""
        return max(self._file.number(table, 3, "i"), self._file.number(table, 0, "b"))


def _quantized(weights: NDArray[np.float32]) -> tuple[NDArray[np.int8], NDArray[np.float32]]:
    """Return weights (out, height, width, in) as whole numbers, and the scale (out,) of each output channel."""
    rows = weights.reshape(len(weights), -1)
    largest = np.maximum(rows.max(axis=1), -rows.min(axis=1))
    scales = np.where(largest > 0, largest / _TOP, 1.0).astype(np.float32)
    return np.rint(rows / scales[:, None]).astype(np.int8), scales
