"""A TensorFlow.js graph model (a .json file with its layers, one .bin with their weights) as a TensorFlow Lite file.

Read are the layers that MoveNet and NanoDet have; any other kind is refused. Formats: tfjs-converter's `GraphModel` and
tensorflow/core/framework/graph.proto as JSON. Weights in half precision are kept exactly, as 32-bit numbers.

A network that takes (1, channels, height, width) was turned from one library's order of axes into another's by
transposing to and fro around every layer. Here it takes (1, height, width, channels) and keeps to that: those
transpositions go.
"""

from __future__ import annotations

import base64
import json
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...errors import ModelError
from .tflite import ACTIVATIONS, Network, Tensor

_Node = dict[str, Any]
_CONVOLUTIONS = ("_FusedConv2D", "FusedDepthwiseConv2dNative", "DepthwiseConv2dNative", "Conv2D")
_ARITHMETIC = {
    "Add": "add", "AddV2": "add", "Sub": "subtract", "Mul": "multiply", "RealDiv": "divide", "FloorDiv": "floor_divide",
    "SquaredDifference": "squared_difference",
}  # fmt: skip
_FUNCTIONS = {"Sigmoid": "sigmoid", "Sqrt": "squareroot"}
_TYPES = {"DT_FLOAT": "float32", "DT_INT32": "int32"}


def converted(graph: bytes, weights: bytes) -> bytes:
    """Return the network as a TensorFlow Lite file; its input takes the same numbers as 32-bit floating point.

    Raises ModelError where the files are not such a network.
    """
    try:
        return _Conversion(json.loads(graph), weights).run()
    except (ValueError, KeyError, IndexError, TypeError) as error:
        raise ModelError(f"the TensorFlow.js files are damaged or of another kind ({error})") from error


def _weights(table: dict[str, Any], content: bytes) -> dict[str, NDArray[Any]]:
    found: dict[str, NDArray[Any]] = {}
    at = 0
    for weight in (weight for group in table["weightsManifest"] for weight in group["weights"]):
        stored = np.dtype(weight.get("quantization", weight)["dtype"]).newbyteorder("<")
        if "scale" in weight.get("quantization", {}):
            raise ModelError("the TensorFlow.js network has weights of 8 bits, which are not known here")
        values = np.frombuffer(content, stored, int(np.prod(weight["shape"], dtype=int)), at)
        found[weight["name"]] = values.reshape(weight["shape"]).astype(weight["dtype"])
        at += values.nbytes
    if at != len(content):
        raise ModelError(f"the weights have {len(content)} bytes, the network's layers {at}")
    return found


class _Conversion:
    def __init__(self, table: dict[str, Any], weights: bytes) -> None:
        self.network = Network()
        self._constants = _weights(table, weights)
        self._nodes: list[_Node] = _needed(table)
        self._outputs = sorted(output["name"] for output in table["signature"]["outputs"].values())
        self._tensors: dict[str, list[Tensor]] = {}
        (given,) = (node for node in self._nodes if node["op"] == "Placeholder")
        self._shape = [int(side["size"]) for side in given["attr"]["shape"]["shape"]["dim"]]
        self._channels_first = self._shape[1] == 3
        # a bias that is added after a convolution goes into it
        self._biases = {
            node["input"][0]: node["input"][1]
            for node in self._nodes
            if node["op"] == "Add" and node["input"][1] in self._constants
        }

    def run(self) -> bytes:
        for node in self._nodes:
            self._tensors[node["name"]] = self._layer(node)
        return self.network.written([self._tensor(name) for name in self._outputs])

    def _tensor(self, reference: str) -> Tensor:
        """Return what a node's input refers to, `node` or `node:output`; a constant becomes a tensor when needed."""
        name, _, output = reference.partition(":")
        if name not in self._tensors:
            self._tensors[name] = [self.network.constant(self._constants[name])]
        return self._tensors[name][int(output or 0)]

    def _constant(self, reference: str) -> NDArray[Any]:
        return self._constants[reference.partition(":")[0]]

    def _layer(self, node: _Node) -> list[Tensor]:
        kind, attributes, inputs = node["op"], node.get("attr", {}), node.get("input", [])
        network = self.network
        if kind == "Placeholder":
            _, *sides = self._shape
            return [network.input((1, *sides[1:], 3) if self._channels_first else self._shape)]
        if kind in _CONVOLUTIONS:
            return [self._convolution(node)]
        if inputs[0] in self._biases:
            return [self._tensor(inputs[0])]
        if kind in _ARITHMETIC:
            return [network.arithmetic(_ARITHMETIC[kind], self._tensor(inputs[0]), self._tensor(inputs[1]))]
        if kind in _FUNCTIONS:
            return [network.function(_FUNCTIONS[kind], self._tensor(inputs[0]))]
        if kind == "LeakyRelu":
            return [network.leaky_relu(self._tensor(inputs[0]), float(attributes["alpha"]["f"]))]
        if kind == "MaxPool":
            return [self._max_pool(node)]
        if self._channels_first:
            return self._turned(kind, inputs)
        return self._rearranged(kind, attributes, inputs)

    def _turned(self, kind: str, inputs: list[str]) -> list[Tensor]:
        """Add a layer that rearranges (1, channels, height, width), for (1, height, width, channels)."""
        network, x = self.network, self._tensor(inputs[0])
        match kind:
            case "Transpose" | "Identity":
                return [x]
            case "Pad" | "PadV2":
                _, _, rows, columns = self._constant(inputs[1]).reshape(4, 2).tolist()
                value = float(self._constant(inputs[2])) if kind == "PadV2" else 0.0
                return [network.pad(x, (*rows, *columns), value) if any(rows + columns) else x]
            case "ConcatV2":
                return [network.concatenation([self._tensor(name) for name in inputs[:-1]], 3)]
            case "SplitV":
                first, second = self._constant(inputs[1]).tolist()
                return [network.channels(x, 0, first), network.channels(x, first, first + second)]
            case "Reshape":  # to (1, channels, pixels), whose axes are exchanged at last
                _, height, width, channels = x.shape
                return [network.reshape(x, (1, height * width, channels))]
            case "ResizeBilinear":
                height, width = self._constant(inputs[1]).tolist()
                return [network.bilinear(x, (int(height), int(width)), corners=False)]
            case _:
                raise ModelError(f"the TensorFlow.js network has a layer {kind}, which is not known here")

    def _max_pool(self, node: _Node) -> Tensor:
        attributes = node["attr"]
        kernel, stride = (int(attributes[name]["list"]["i"][1]) for name in ("ksize", "strides"))
        same = _text(attributes["padding"]["s"]) == "SAME"
        return self.network.max_pool(self._tensor(node["input"][0]), kernel, stride=stride, same=same)

    def _rearranged(self, kind: str, attributes: dict[str, Any], inputs: list[str]) -> list[Tensor]:
        """Add a layer that moves, picks or reads numbers otherwise."""
        network, x = self.network, self._tensor(inputs[0])
        axis = int(attributes.get("axis", {}).get("i", 0))
        match kind:
            case "Identity":
                return [x]
            case "Cast":
                type_ = _TYPES[attributes["DstT"]["type"]]
                return [x if x.type == type_ else network.cast(x, type_)]
            case "ExpandDims":
                return [network.reshape(x, np.expand_dims(np.empty(x.shape), int(self._constant(inputs[1]))).shape)]
            case "Squeeze":
                dropped = tuple(int(i) for i in attributes["squeeze_dims"]["list"]["i"])
                return [network.reshape(x, np.squeeze(np.empty(x.shape), dropped).shape)]
            case "Reshape":
                wanted = self._constant(inputs[1]).ravel().tolist()
                return [network.reshape(x, np.empty(x.shape).reshape(wanted).shape)]
            case "Unpack":
                return network.unpack(x, axis)
            case "Pack":
                return [network.pack([self._tensor(name) for name in inputs], axis)]
            case "ConcatV2":
                parts = [self._tensor(name) for name in inputs[:-1]]
                return [network.concatenation(parts, int(self._constant(inputs[-1])))]
            case "ArgMax":
                return [network.argmax(x, int(self._constant(inputs[1])))]
            case "GatherNd":
                return [network.gather(x, self._tensor(inputs[1]))]
            case "ResizeBilinear":
                height, width = self._constant(inputs[1]).tolist()
                return [network.bilinear(x, (height, width), corners=bool(attributes["align_corners"]["b"]))]
            case _:
                raise ModelError(f"the TensorFlow.js network has a layer {kind}, which is not known here")

    def _convolution(self, node: _Node) -> Tensor:
        attributes, inputs = node["attr"], node["input"]
        x, weights = self._tensor(inputs[0]), self._constant(inputs[1])
        stride = int(attributes["strides"]["list"]["i"][1])
        fused = [_text(name) for name in attributes.get("fused_ops", {}).get("list", {}).get("s", [])]
        depthwise = "epthwise" in node["op"]
        # height, width, in, out (or multiplier) -> what TensorFlow Lite wants
        ordered = weights.reshape(1, *weights.shape[:2], -1) if depthwise else weights.transpose(3, 0, 1, 2)
        channels = ordered.shape[3] if depthwise else ordered.shape[0]
        bias_of = inputs[2] if "BiasAdd" in fused else self._biases.get(node["name"])
        bias = self._constant(bias_of).ravel() if bias_of else np.zeros(channels, np.float32)
        activation = next((name.lower() for name in fused if name != "BiasAdd"), "")
        padding = _text(attributes["padding"]["s"])
        if activation not in ACTIVATIONS or padding not in ("SAME", "VALID"):
            raise ModelError(f"the TensorFlow.js network has a convolution {fused}, {padding}, which is not known here")
        pad = _same(x.shape[1:3], weights.shape[:2], stride) if padding == "SAME" else (0, 0, 0, 0)
        return self.network.convolution(
            x, ordered, bias, stride=stride, pad=pad, activation=activation, depthwise=depthwise
        )


def _needed(table: dict[str, Any]) -> list[_Node]:
    """Return the layers that compute something from the picture, in order; constants and what is made of them alone go.

    NanoDet's file computes shapes from constants, which are known here without.
    """
    alive: set[str] = set()
    kept: list[_Node] = []
    for node in table["modelTopology"]["node"]:
        if node["op"] == "Placeholder" or alive.intersection(name.partition(":")[0] for name in node.get("input", [])):
            alive.add(node["name"])
            kept.append(node)
    return kept


def _same(sides: tuple[int, ...], kernel: tuple[int, ...], stride: int) -> tuple[int, int, int, int]:
    """Return the zeros above, below, left and right that TensorFlow's padding SAME stands for."""
    (top, bottom), (left, right) = (
        (total // 2, total - total // 2)
        for side, size in zip(sides, kernel, strict=True)
        for total in [max((-(-side // stride) - 1) * stride + size - side, 0)]
    )
    return top, bottom, left, right


def _text(encoded: str) -> str:
    return base64.b64decode(encoded).decode()
