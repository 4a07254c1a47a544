"""The layers of a TensorFlow Lite network, read from its file.

Read are files of one graph, of the layers that `tflite` writes and with numbers that are not quantized; of any other
there is nothing to be had. Numbers of fields are those of tensorflow/lite/schema/schema.fbs.
"""

from __future__ import annotations

import struct
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .flatbuffer import Ints, Number, Reader, Value
from .tflite import OPERATORS, TYPES

_NAMES = {code: name for name, (code, _) in OPERATORS.items()}
_TYPE_NAMES = {number: name for name, number in TYPES.items()}
#: The options of each kind of layer: field -> struct format, "ints" for a vector of them.
_OPTIONS: Mapping[str, Mapping[int, str]] = {
    "add": {0: "b"}, "multiply": {0: "b"}, "subtract": {0: "b"}, "divide": {0: "b"}, "concatenation": {0: "i", 1: "b"},
    "conv": {0: "b", 1: "i", 2: "i", 3: "b", 4: "i", 5: "i"},
    "depthwise": {0: "b", 1: "i", 2: "i", 3: "i", 4: "b", 5: "i", 6: "i"},
    "depth_to_space": {0: "i"}, "max_pool": {0: "b", 1: "i", 2: "i", 3: "i", 4: "i", 5: "b"}, "split": {0: "i"},
    "reshape": {0: "ints"}, "bilinear": {2: "b", 3: "b"}, "leaky_relu": {0: "f"},
    "sigmoid": {}, "relu": {}, "pad": {}, "transpose": {}, "slice": {}, "pad_with": {},
}  # fmt: skip


@dataclass(frozen=True)
class Operator:
    """One layer: its name in `tflite.OPERATORS`, the numbers of the tensors it takes and gives, and its options."""

    name: str
    inputs: tuple[int, ...]
    outputs: tuple[int, ...]
    options: Mapping[int, Value]

    def option(self, number: int) -> float:
        """Return an option that is a number, 0 where it is left out."""
        value = self.options.get(number)
        return value.value if isinstance(value, Number) else 0


@dataclass(frozen=True, eq=False)
class Graph:
    """A network: of each tensor its shape and type, the content of constants, layers in order, what goes in and out."""

    shapes: tuple[tuple[int, ...], ...]
    types: tuple[str, ...]
    constants: Mapping[int, NDArray[Any]]
    operators: tuple[Operator, ...]
    inputs: tuple[int, ...]
    outputs: tuple[int, ...]


def read_graph(content: bytes) -> Graph | None:
    """Return the network of a file, None where the file is damaged or has anything that is not known here."""
    try:
        return _graph(Reader(content))
    except (struct.error, IndexError, ValueError, KeyError):
        return None


def _graph(file: Reader) -> Graph:
    model = file.led_to(0)
    codes = [max(file.number(table, 3, "i"), file.number(table, 0, "b")) for table in file.tables(model, 1)]
    (graph,) = file.tables(model, 2)
    buffers = file.tables(model, 4)
    tensors = file.tables(graph, 0)
    if any(file.vector(file.led_to(at), 2)[1] for at in (file.field(tensor, 4) for tensor in tensors) if at):
        raise ValueError("quantized numbers")
    shapes = tuple(tuple(file.ints(tensor, 0)) for tensor in tensors)
    if min((side for shape in shapes for side in shape), default=1) < 1:
        raise ValueError("a shape that no network has")
    types = tuple(_TYPE_NAMES[file.number(tensor, 1, "b")] for tensor in tensors)
    constants = {
        number: np.frombuffer(raw, np.dtype(types[number]).newbyteorder("<")).reshape(shapes[number])
        for number, tensor in enumerate(tensors)
        if (raw := file.bytes(buffers[file.number(tensor, 2, "I")], 0))
    }
    operators = tuple(_operator(file, table, codes) for table in file.tables(graph, 3))
    if min((index for operator in operators for index in operator.inputs), default=0) < 0:
        raise ValueError("an input that is left out")
    return Graph(shapes, types, constants, operators, tuple(file.ints(graph, 1)), tuple(file.ints(graph, 2)))


def _operator(file: Reader, table: int, codes: list[int]) -> Operator:
    name = _NAMES[codes[file.number(table, 0, "I")]]
    at = file.field(table, 4)
    options: dict[int, Value] = {}
    for number, format_ in _OPTIONS[name].items():
        if at and file.field(file.led_to(at), number):
            options[number] = _option(file, file.led_to(at), number, format_)
    return Operator(name, tuple(file.ints(table, 1)), tuple(file.ints(table, 2)), options)


def _option(file: Reader, options: int, number: int, format_: str) -> Value:
    if format_ == "ints":
        return Ints(file.ints(options, number))
    (value,) = struct.unpack_from(f"<{format_}", file.content, file.field(options, number))
    return Number(value, format_)
