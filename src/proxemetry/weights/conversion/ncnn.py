"""A network of ncnn's two files (.param: its layers as text, .bin: their weights) as a TensorFlow Lite file.

Read are the layers that PP-TinyPose has; any other kind is refused. Formats: https://github.com/Tencent/ncnn/wiki,
"param and model file structure". Weights in half precision are kept exactly, as 32-bit numbers.
"""

from __future__ import annotations

import struct
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...errors import ModelError
from .tflite import Network, Tensor

_MAGIC = "7767517"
_HALF_PRECISION = 0x01306B47  # the tag before weights of 16 bits; 0 stands before those of 32
_RELU = "1"


@dataclass(frozen=True)
class _Layer:
    kind: str
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]
    settings: dict[str, str]

    def number(self, key: int, default: int = 0) -> int:
        return int(float(self.settings.get(str(key), default)))


def converted(param: bytes, weights: bytes, input_size: tuple[int, int]) -> bytes:
    """Return the network as a TensorFlow Lite file; input_size is its (width, height).

    It takes (1, height, width, 3), and answers (1, channels, height, width): heatmaps as ncnn and ONNX have them.
    Raises ModelError where the files are not such a network.
    """
    try:
        return _Conversion(weights, input_size).run(_layers(param.decode()))
    except (ValueError, KeyError, IndexError, struct.error) as error:
        raise ModelError(f"the ncnn files are damaged or of another kind ({error})") from error


def _layers(text: str) -> list[_Layer]:
    lines = text.splitlines()
    if lines[0].strip() != _MAGIC:
        raise ModelError("the ncnn .param file does not begin as one")
    layers: list[_Layer] = []
    for line in lines[2:]:
        kind, _, n_in, n_out, *rest = line.split()
        inputs, outputs = int(n_in), int(n_in) + int(n_out)
        settings = dict(setting.split("=", 1) for setting in rest[outputs:])
        layers.append(_Layer(kind, tuple(rest[:inputs]), tuple(rest[inputs:outputs]), settings))
    return layers


class _Conversion:
    def __init__(self, weights: bytes, input_size: tuple[int, int]) -> None:
        self.network = Network()
        self._weights, self._at = weights, 0
        self._size = input_size
        self._tensors: dict[str, Tensor] = {}
        self._methods = {
            "Convolution": self._convolution, "ConvolutionDepthWise": self._convolution, "ReLU": self._relu,
            "BinaryOp": self._add, "Concat": self._concat, "Slice": self._slice, "Interp": self._resize,
        }  # fmt: skip

    def run(self, layers: list[_Layer]) -> bytes:
        remaining = iter(layers)
        last = layers[-1].outputs[0]
        for layer in remaining:
            match layer.kind:
                case "Input":
                    width, height = self._size
                    self._tensors[layer.outputs[0]] = self.network.input((1, height, width, 3))
                case "Split":  # the same tensor for several layers
                    self._tensors.update(dict.fromkeys(layer.outputs, self._tensors[layer.inputs[0]]))
                case "Reshape":
                    self._shuffle(layer, remaining)
                case kind if kind in self._methods:
                    answers = self._methods[kind](layer)
                    self._tensors.update(zip(layer.outputs, answers, strict=True))
                case _:
                    raise ModelError(f"the ncnn network has a layer {layer.kind}, which is not known here")
        if self._at != len(self._weights):
            raise ModelError(f"the ncnn .bin file has {len(self._weights)} bytes, its layers {self._at}")
        return self.network.written([self.network.transpose(self._tensors[last], (0, 3, 1, 2))])

    def _inputs(self, layer: _Layer) -> list[Tensor]:
        return [self._tensors[name] for name in layer.inputs]

    def _take(self, count: int, type_: str) -> NDArray[np.float32]:
        values = np.frombuffer(self._weights, type_, count, self._at)
        self._at += -(-values.nbytes // 4) * 4
        return values.astype(np.float32)

    def _convolution(self, layer: _Layer) -> list[Tensor]:
        (x,) = self._inputs(layer)
        out, kernel, stride, pad = layer.number(0), layer.number(1), layer.number(3, 1), layer.number(4)
        groups = layer.number(7, 1)
        (tag,) = struct.unpack_from("<I", self._weights, self._at)
        if tag not in (0, _HALF_PRECISION):
            raise ModelError("the ncnn .bin file has weights of a kind that is not known here")
        self._at += 4
        values = self._take(layer.number(6), "<f2" if tag else "<f4")
        bias = self._take(out, "<f4") if layer.number(5) else np.zeros(out, np.float32)
        depthwise = groups > 1
        if depthwise and not groups == out == x.shape[3]:
            raise ModelError("the ncnn network has a grouped convolution, which is not known here")
        shaped = values.reshape(out, -1, kernel, kernel)  # out, in, height, width
        ordered = shaped.transpose(1, 2, 3, 0) if depthwise else shaped.transpose(0, 2, 3, 1)
        activation = "relu" if layer.settings.get("9") == _RELU else ""
        return [
            self.network.convolution(
                x, ordered, bias, stride=stride, pad=(pad, pad, pad, pad), activation=activation, depthwise=depthwise
            )
        ]

    def _relu(self, layer: _Layer) -> list[Tensor]:
        return [self.network.function("relu", *self._inputs(layer))]

    def _add(self, layer: _Layer) -> list[Tensor]:
        if layer.number(0):
            raise ModelError("the ncnn network has a BinaryOp other than a sum, which is not known here")
        a, b = self._inputs(layer)
        return [self.network.arithmetic("add", a, b)]

    def _concat(self, layer: _Layer) -> list[Tensor]:
        return [self.network.concatenation(self._inputs(layer), 3)]

    def _slice(self, layer: _Layer) -> list[Tensor]:
        return self.network.halves(*self._inputs(layer))

    def _resize(self, layer: _Layer) -> list[Tensor]:
        (x,) = self._inputs(layer)
        if layer.number(0) == 2:
            return [self.network.bilinear(x, (layer.number(3), layer.number(4)), corners=bool(layer.number(6)))]
        for _ in range(layer.number(2).bit_length() - 1):  # nearest, by a power of two
            x = self.network.doubled(x)
        return [x]

    def _shuffle(self, first: _Layer, remaining: Iterator[_Layer]) -> None:
        """Read a channel shuffle (ShuffleNet, Zhang et al. 2018), three layers there: groups, exchanged, flat again."""
        permute, last = next(remaining), next(remaining)
        (x,) = self._inputs(first)
        _, height, width, channels = x.shape
        groups = first.number(2)
        expected = (height * width, channels // groups, groups)
        if (permute.kind, permute.number(0), last.kind) != ("Permute", 2, "Reshape") or expected != tuple(
            first.number(key) for key in (0, 1, 2)
        ):
            raise ModelError("the ncnn network has a Reshape that is not a channel shuffle, which is not known here")
        parted = self.network.reshape(x, (1, height, width, groups, channels // groups))
        exchanged = self.network.transpose(parted, (0, 1, 2, 4, 3))
        self._tensors[last.outputs[0]] = self.network.reshape(exchanged, x.shape)
