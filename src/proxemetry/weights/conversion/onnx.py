"""An ONNX detector (YOLOX) as a TensorFlow Lite file, so that the default needs one runtime only.

Read are the layers that YOLOX has; any other kind is refused. The format is that of onnx/onnx.proto in the encoding of
https://protobuf.dev/programming-guides/encoding. Pictures are turned from (channels, height, width), as ONNX has them,
to (height, width, channels), and flattened ones from (channels, pixels) to (pixels, channels).
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...errors import ModelError
from .tflite import Network, Tensor

_GRAPH = 7  # of a model
_NODES, _INITIALIZERS, _INPUTS, _OUTPUTS = 1, 5, 11, 12  # of a graph
_FLOAT, _INT64 = 1, 7  # types of numbers
_CHANNELS_LAST = {0: 0, 1: 3, 2: 1, 3: 2}  # axis of a picture there -> here
_FLATTENED = {0: 0, 1: 2, 2: 1}


@dataclass(frozen=True)
class _Node:
    kind: str
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]
    attributes: dict[str, list[int]]


@dataclass(frozen=True)
class _Slices:
    """Slices of a picture, one after the other along the channels: the row and column where each begins."""

    of: Tensor
    begin: tuple[tuple[int, int], ...]


def converted(content: bytes, input_size: tuple[int, int]) -> bytes:
    """Return the network as a TensorFlow Lite file; input_size is its (width, height).

    It takes (1, height, width, 3), and answers what the ONNX file does. Raises ModelError where it is no such network.
    """
    try:
        return _Conversion(memoryview(content), input_size).run()
    except (ValueError, KeyError, IndexError) as error:
        raise ModelError(f"the ONNX file is damaged or of another kind ({error})") from error


def _varint(content: memoryview, at: int) -> tuple[int, int]:
    value = shift = 0
    while True:
        byte = content[at]
        value, shift, at = value | (byte & 127) << shift, shift + 7, at + 1
        if byte < 128:
            return value, at


def _message(content: memoryview) -> Iterator[tuple[int, int | memoryview]]:
    """Yield the number of each field of a message and what it holds: a number, or bytes."""
    at = 0
    while at < len(content):
        key, at = _varint(content, at)
        kind = key & 7
        if kind == 0:
            value, at = _varint(content, at)
            yield key >> 3, value
            continue
        if kind == 2:
            length, at = _varint(content, at)
        else:
            length = {1: 8, 5: 4}[kind]
        if at + length > len(content):
            raise ValueError("it ends too early")
        yield key >> 3, content[at : at + length]
        at += length


def _fields(content: memoryview) -> dict[int, list[int | memoryview]]:
    found: dict[int, list[int | memoryview]] = defaultdict(list)
    for number, value in _message(content):
        found[number].append(value)
    return found


def _bytes(value: int | memoryview) -> memoryview:
    if isinstance(value, int):
        raise ValueError("a number where bytes were expected")
    return value


def _text(value: int | memoryview) -> str:
    return bytes(_bytes(value)).decode()


def _integers(values: list[int | memoryview]) -> list[int]:
    """Return whole numbers, which are one a field or many packed in one, negative ones as two's complement."""
    numbers: list[int] = []
    for value in values:
        if isinstance(value, int):
            numbers.append(value)
            continue
        at = 0
        while at < len(value):
            number, at = _varint(value, at)
            numbers.append(number)
    return [number - (1 << 64) if number >> 63 else number for number in numbers]


def _array(content: memoryview) -> tuple[str, NDArray[np.float32] | NDArray[np.int64]]:
    fields = _fields(content)
    shape, (kind,) = _integers(fields[1]), _integers(fields[2])
    if kind not in (_FLOAT, _INT64):
        raise ModelError(f"the ONNX network has numbers of type {kind}, which is not known here")
    type_ = "<f4" if kind == _FLOAT else "<i8"
    packed = fields[4] if kind == _FLOAT else []
    raw = fields[9] or packed
    values = np.frombuffer(_bytes(raw[0]), type_) if raw else np.array(_integers(fields[7]), type_)
    return _text(fields[8][0]), values.reshape(shape)


def _node(content: memoryview) -> _Node:
    fields = _fields(content)
    attributes: dict[str, list[int]] = {}
    for attribute in fields[5]:
        parts = _fields(_bytes(attribute))
        attributes[_text(parts[1][0])] = _integers(parts[3] or parts[8])
    names = [tuple(_text(name) for name in fields[number]) for number in (1, 2)]
    return _Node(_text(fields[4][0]), names[0], names[1], attributes)


class _Conversion:
    def __init__(self, content: memoryview, input_size: tuple[int, int]) -> None:
        graph = _fields(_bytes(_fields(content)[_GRAPH][0]))
        self._nodes = [_node(_bytes(node)) for node in graph[_NODES]]
        self._constants = dict(_array(_bytes(values)) for values in graph[_INITIALIZERS])
        (self._output,) = (_text(_fields(_bytes(output))[1][0]) for output in graph[_OUTPUTS])
        names = [_text(_fields(_bytes(value))[1][0]) for value in graph[_INPUTS]]
        (name,) = (name for name in names if name not in self._constants)
        self.network = Network()
        width, height = input_size
        self._tensors: dict[str, Tensor] = {name: self.network.input((1, height, width, 3))}
        self._slices = {name: _Slices(self._tensors[name], ((0, 0),))}
        self._methods = {
            "Conv": self._convolution, "Sigmoid": self._sigmoid, "Mul": self._multiply, "Add": self._add,
            "Concat": self._concat, "MaxPool": self._max_pool, "Resize": self._resize, "Reshape": self._flatten,
            "Transpose": self._transpose,
        }  # fmt: skip

    def run(self) -> bytes:
        for node in self._nodes:
            (name,) = node.outputs
            if node.kind == "Slice":
                self._slices[name] = self._every_other(node)
            elif node.kind == "Concat" and all(part in self._slices for part in node.inputs):
                parts = [self._slices[part] for part in node.inputs]
                self._slices[name] = _Slices(parts[0].of, tuple(at for part in parts for at in part.begin))
            elif node.kind in self._methods:
                self._tensors[name] = self._methods[node.kind](node)
            else:
                raise ModelError(f"the ONNX network has a layer {node.kind}, which is not known here")
        return self.network.written([self._tensors[self._output]])

    def _every_other(self, node: _Node) -> _Slices:
        """Read a slice of the input that takes every other row or column."""
        slices = self._slices[node.inputs[0]]
        starts, _, axes, steps = (self._constants[name].tolist() for name in node.inputs[1:])
        ((row, column),) = slices.begin
        if (axes, steps) == ([2], [2]):
            return _Slices(slices.of, ((row + starts[0], column),))
        if (axes, steps) == ([3], [2]):
            return _Slices(slices.of, ((row, column + starts[0]),))
        raise ModelError("the ONNX network has a Slice of another kind than YOLOX's, which is not known here")

    def _convolution_of_slices(self, node: _Node) -> Tensor:
        """Return what a convolution sees in the four slices of a picture by one of the picture itself (YOLOX's Focus).

        The kernel is twice as large and moves twice as far: the same sums without cutting the picture up first, which
        takes LiteRT as long as all the rest.
        """
        slices, weights = self._slices[node.inputs[0]], self._constants[node.inputs[1]]
        out, _, height, width = weights.shape
        channels = slices.of.shape[3]
        if sorted(slices.begin) != [(0, 0), (0, 1), (1, 0), (1, 1)] or weights.shape[1] != 4 * channels:
            raise ModelError("the ONNX network has slices of another kind than YOLOX's, which are not known here")
        large = np.zeros((out, 2 * height, 2 * width, channels), np.float32)
        for number, (row, column) in enumerate(slices.begin):
            part = weights[:, number * channels : (number + 1) * channels]
            large[:, row::2, column::2] = part.transpose(0, 2, 3, 1)
        top, left, bottom, right = (2 * side for side in node.attributes["pads"])
        return self.network.convolution(
            slices.of, large, self._constants[node.inputs[2]], stride=2 * node.attributes["strides"][0],
            pad=(top, bottom, left, right),
        )  # fmt: skip

    def _convolution(self, node: _Node) -> Tensor:
        if node.inputs[0] in self._slices:
            return self._convolution_of_slices(node)
        x, weights = self._tensors[node.inputs[0]], self._constants[node.inputs[1]]
        bias = self._constants[node.inputs[2]] if len(node.inputs) > 2 else np.zeros(len(weights), np.float32)
        (groups,) = node.attributes.get("group", [1])
        depthwise = groups > 1
        if depthwise and not groups == len(weights) == x.shape[3]:
            raise ModelError("the ONNX network has a grouped convolution, which is not known here")
        ordered = weights.transpose(1, 2, 3, 0) if depthwise else weights.transpose(0, 2, 3, 1)
        top, left, bottom, right = node.attributes.get("pads", [0] * 4)
        return self.network.convolution(
            x, ordered, bias, stride=node.attributes.get("strides", [1])[0], pad=(top, bottom, left, right),
            depthwise=depthwise,
        )  # fmt: skip

    def _two(self, node: _Node) -> tuple[Tensor, Tensor]:
        return self._tensors[node.inputs[0]], self._tensors[node.inputs[1]]

    def _sigmoid(self, node: _Node) -> Tensor:
        return self.network.function("sigmoid", self._tensors[node.inputs[0]])

    def _multiply(self, node: _Node) -> Tensor:
        return self.network.arithmetic("multiply", *self._two(node))

    def _add(self, node: _Node) -> Tensor:
        return self.network.arithmetic("add", *self._two(node))

    def _concat(self, node: _Node) -> Tensor:
        parts = [self._tensors[name] for name in node.inputs]
        axes = _CHANNELS_LAST if len(parts[0].shape) == 4 else _FLATTENED
        return self.network.concatenation(parts, axes[node.attributes["axis"][0]])

    def _max_pool(self, node: _Node) -> Tensor:
        kernel = node.attributes["kernel_shape"][0]
        if set(node.attributes["pads"]) != {kernel // 2} or set(node.attributes.get("strides", [1])) != {1}:
            raise ModelError("the ONNX network has a MaxPool that shrinks, which is not known here")
        return self.network.max_pool(self._tensors[node.inputs[0]], kernel)

    def _resize(self, node: _Node) -> Tensor:
        scales = next(self._constants[name] for name in node.inputs[1:] if name and self._constants[name].size == 4)
        if scales.tolist() != [1, 1, 2, 2]:
            raise ModelError(f"the ONNX network has a Resize by {scales.tolist()}, which is not known here")
        return self.network.doubled(self._tensors[node.inputs[0]])

    def _flatten(self, node: _Node) -> Tensor:
        x = self._tensors[node.inputs[0]]
        _, height, width, channels = x.shape
        return self.network.reshape(x, (1, height * width, channels))

    def _transpose(self, node: _Node) -> Tensor:
        x = self._tensors[node.inputs[0]]
        if node.attributes["perm"] != [0, 2, 1] or len(x.shape) != 3:
            raise ModelError("the ONNX network has a Transpose of pictures, which is not known here")
        return x  # it is in that order here already
