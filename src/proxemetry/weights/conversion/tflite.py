"""A TensorFlow Lite network, layer by layer, as a file that LiteRT runs.

Layers are added in the order they run in; each method returns the tensor that comes out, its shape known. Pictures are
(1, height, width, channels). Numbers of fields, operators and options are those of tensorflow/lite/schema/schema.fbs.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .flatbuffer import Bytes, Ints, Number, Table, Tables, Value, written

Array = NDArray[Any]

TYPES = {"float32": 0, "int32": 2}
_VERSION, _IDENTIFIER = 3, b"TFL3"
_BUFFER_ALIGNMENT = 16
#: Operators: the schema's number and that of their options' type, 0 where they have none.
OPERATORS = {
    "add": (0, 11), "concatenation": (2, 10), "conv": (3, 1), "depthwise": (4, 2), "depth_to_space": (5, 94),
    "sigmoid": (14, 0), "max_pool": (17, 5), "multiply": (18, 21), "relu": (19, 0), "reshape": (22, 17),
    "bilinear": (23, 15), "pad": (34, 22), "transpose": (39, 26), "subtract": (41, 28), "divide": (42, 29),
    "split": (49, 35), "cast": (53, 37), "argmax": (56, 40), "squareroot": (75, 0),
    "pack": (83, 59), "unpack": (88, 64), "floor_divide": (90, 65), "squared_difference": (99, 76),
    "slice": (65, 48), "leaky_relu": (98, 75), "gather_nd": (107, 83), "pad_with": (60, 43),
}  # fmt: skip
#: Activations that a layer does itself.
ACTIVATIONS = {"": 0, "relu": 1, "relu6": 3}
_SAME, _VALID = 0, 1


@dataclass(frozen=True)
class Tensor:
    """One tensor of a network by its number."""

    index: int
    shape: tuple[int, ...]
    type: str = "float32"


class Network:
    """A network under construction."""

    def __init__(self) -> None:
        self._tensors: list[Table] = []
        self._buffers: list[Table] = [Table()]  # the first is empty: what is computed has no content
        self._operators: list[Table] = []
        self._codes: dict[tuple[int, int], int] = {}
        self._inputs: list[Tensor] = []

    def input(self, shape: Sequence[int], type_: str = "float32") -> Tensor:
        """Add an input."""
        self._inputs.append(self._tensor(tuple(shape), type_))
        return self._inputs[-1]

    def constant(self, values: Array) -> Tensor:
        """Add numbers that the network holds."""
        content = np.ascontiguousarray(values)
        little_endian = content.astype(content.dtype.newbyteorder("<")).tobytes()
        self._buffers.append(Table({0: Bytes(little_endian, _BUFFER_ALIGNMENT)}))
        return self._tensor(content.shape, str(content.dtype), len(self._buffers) - 1)

    def convolution(
        self, x: Tensor, weights: Array, bias: Array, *, stride: int = 1, pad: tuple[int, int, int, int] = (0, 0, 0, 0),
        activation: str = "", depthwise: bool = False,
    ) -> Tensor:  # fmt: skip
        """Add a convolution, an activation in it.

        weights: (out, height, width, in), or (1, height, width, channels) where each channel has its own (depthwise).
        pad: zeros above, below, left and right.
        """
        same = _is_same(x.shape, weights.shape[1:3], stride, pad)
        x = x if same or not any(pad) else self.pad(x, pad)
        sides = [
            -(-side // stride) if same else (side - kernel) // stride + 1
            for side, kernel in zip(x.shape[1:3], weights.shape[1:3], strict=True)
        ]
        channels = weights.shape[3] if depthwise else weights.shape[0]
        padding, act = Number(_SAME if same else _VALID, "b"), Number(ACTIVATIONS[activation], "b")
        one, step = Number(1), Number(stride)
        options: dict[int, Value] = (
            {0: padding, 1: step, 2: step, 3: Number(weights.shape[3] // x.shape[3]), 4: act, 5: one, 6: one}
            if depthwise
            else {0: padding, 1: step, 2: step, 3: act, 4: one, 5: one}
        )
        inputs = [x, self.constant(weights.astype(np.float32)), self.constant(bias.astype(np.float32))]
        return self._one("depthwise" if depthwise else "conv", inputs, (1, *sides, channels), options)

    def pad(self, x: Tensor, pad: tuple[int, int, int, int], value: float = 0.0) -> Tensor:
        """Add zeros, or another number, above, below, left and right."""
        top, bottom, left, right = pad
        _, height, width, channels = x.shape
        shape = (1, height + top + bottom, width + left + right, channels)
        around = np.array([[0, 0], [top, bottom], [left, right], [0, 0]], np.int32)
        if value:
            return self._one("pad_with", [x, self.constant(around), self.constant(np.array(value, np.float32))], shape)
        return self._one("pad", [x, self.constant(around)], shape)

    def arithmetic(self, name: str, a: Tensor, b: Tensor) -> Tensor:
        """Add an operation on two tensors, number by number: add, subtract, multiply, divide, floor_divide ..."""
        options: dict[int, Value] = {0: Number(0, "b")} if name in ("add", "subtract", "multiply", "divide") else {}
        return self._one(name, [a, b], np.broadcast_shapes(a.shape, b.shape), options)

    def function(self, name: str, x: Tensor) -> Tensor:
        """Add a function of each number: relu, sigmoid or squareroot."""
        return self._one(name, [x], x.shape)

    def leaky_relu(self, x: Tensor, slope: float) -> Tensor:
        """Add a function that leaves positive numbers alone and multiplies others by `slope`."""
        return self._one("leaky_relu", [x], x.shape, {0: Number(slope, "f")})

    def reshape(self, x: Tensor, shape: Sequence[int]) -> Tensor:
        """Read the same numbers in another shape."""
        target = tuple(int(side) for side in shape)
        return self._one("reshape", [x, self.constant(np.array(target, np.int32))], target, {0: Ints(target)})

    def transpose(self, x: Tensor, order: Sequence[int]) -> Tensor:
        """Change the order of the axes."""
        shape = tuple(x.shape[axis] for axis in order)
        return self._one("transpose", [x, self.constant(np.array(order, np.int32))], shape)

    def concatenation(self, parts: Sequence[Tensor], axis: int) -> Tensor:
        """Join tensors along an axis."""
        shape = list(parts[0].shape)
        shape[axis] = sum(part.shape[axis] for part in parts)
        return self._one("concatenation", parts, tuple(shape), {0: Number(axis), 1: Number(0, "b")})

    def halves(self, x: Tensor) -> list[Tensor]:
        """Split along the last axis into two."""
        shape = (*x.shape[:-1], x.shape[-1] // 2)
        axis = self.constant(np.array(len(x.shape) - 1, np.int32))
        return self._many("split", [axis, x], [shape] * 2, {0: Number(2)}, x.type)

    def channels(self, x: Tensor, begin: int, end: int) -> Tensor:
        """Take some of the last axis."""
        shape = (*x.shape[:-1], end - begin)
        at = self.constant(np.array([0] * (len(shape) - 1) + [begin], np.int32))
        return self._one("slice", [x, at, self.constant(np.array(shape, np.int32))], shape)

    def bilinear(self, x: Tensor, size: tuple[int, int], *, corners: bool) -> Tensor:
        """Resize to (height, width); corners: the corners' middles stay, else the corners do (half-pixel centres)."""
        shape = (1, *size, x.shape[3])
        options: dict[int, Value] = {2: Number(corners, "b"), 3: Number(not corners, "b")}
        return self._one("bilinear", [x, self.constant(np.array(size, np.int32))], shape, options)

    def doubled(self, x: Tensor) -> Tensor:
        """Show each pixel as 2 x 2, by layers that run as fast as the convolutions around them do."""
        four = self.concatenation([x] * 4, 3)
        _, height, width, channels = x.shape
        return self._one("depth_to_space", [four], (1, 2 * height, 2 * width, channels), {0: Number(2)})

    def max_pool(self, x: Tensor, kernel: int, *, stride: int = 1, same: bool = True) -> Tensor:
        """Take the largest of kernel x kernel pixels: around each pixel (same), or only where there are that many."""
        sides = [-(-side // stride) if same else (side - kernel) // stride + 1 for side in x.shape[1:3]]
        options: dict[int, Value] = {
            0: Number(_SAME if same else _VALID, "b"), 1: Number(stride), 2: Number(stride), 3: Number(kernel),
            4: Number(kernel), 5: Number(0, "b"),
        }  # fmt: skip
        return self._one("max_pool", [x], (1, *sides, x.shape[3]), options)

    def cast(self, x: Tensor, type_: str) -> Tensor:
        """Change the type of the numbers."""
        options: dict[int, Value] = {0: Number(TYPES[x.type], "b"), 1: Number(TYPES[type_], "b")}
        return self._one("cast", [x], x.shape, options, type_)

    def argmax(self, x: Tensor, axis: int) -> Tensor:
        """Find where an axis has its largest number."""
        shape = tuple(side for number, side in enumerate(x.shape) if number != axis % len(x.shape))
        inputs = [x, self.constant(np.array(axis, np.int32))]
        return self._one("argmax", inputs, shape, {0: Number(TYPES["int32"], "b")}, "int32")

    def pack(self, parts: Sequence[Tensor], axis: int) -> Tensor:
        """Stack tensors of one shape along a new axis."""
        axis = axis % (len(parts[0].shape) + 1)
        shape = (*parts[0].shape[:axis], len(parts), *parts[0].shape[axis:])
        return self._one("pack", parts, shape, {0: Number(len(parts)), 1: Number(axis)})

    def unpack(self, x: Tensor, axis: int) -> list[Tensor]:
        """Take a tensor apart along an axis, which goes."""
        axis = axis % len(x.shape)
        shape = (*x.shape[:axis], *x.shape[axis + 1 :])
        return self._many("unpack", [x], [shape] * x.shape[axis], {0: Number(x.shape[axis]), 1: Number(axis)})

    def gather(self, x: Tensor, indices: Tensor) -> Tensor:
        """Take the numbers at indices, of which the last axis has one for each of x's first axes."""
        shape = (*indices.shape[:-1], *x.shape[indices.shape[-1] :])
        return self._one("gather_nd", [x, indices], shape, None, x.type)

    def layer(
        self, name: str, inputs: Sequence[Tensor], shapes: Sequence[tuple[int, ...]], options: Mapping[int, Value],
        type_: str,
    ) -> list[Tensor]:  # fmt: skip
        """Add a layer whose options' fields are known, and the shapes and the one type of all that comes out."""
        return self._many(name, inputs, shapes, dict(options), type_)

    def written(self, outputs: Sequence[Tensor]) -> bytes:
        """Return the file."""
        graph = Table({
            0: Tables(self._tensors), 1: Ints([t.index for t in self._inputs]), 2: Ints([t.index for t in outputs]),
            3: Tables(self._operators),
        })  # fmt: skip
        codes = [
            Table({0: Number(min(code, 127), "b"), 2: Number(version), 3: Number(code)})
            for code, version in self._codes
        ]
        model = {0: Number(_VERSION, "I"), 1: Tables(codes), 2: Tables([graph]), 4: Tables(self._buffers)}
        return written(Table(model), _IDENTIFIER)

    def _tensor(self, shape: tuple[int, ...], type_: str, buffer: int = 0) -> Tensor:
        fields: dict[int, Value] = {0: Ints(shape), 1: Number(TYPES[type_], "b"), 2: Number(buffer, "I")}
        self._tensors.append(Table(fields))
        return Tensor(len(self._tensors) - 1, shape, type_)

    def _one(
        self, name: str, inputs: Sequence[Tensor], shape: tuple[int, ...], options: dict[int, Value] | None = None,
        type_: str | None = None,
    ) -> Tensor:  # fmt: skip
        return self._many(name, inputs, [shape], options, type_)[0]

    def _many(
        self, name: str, inputs: Sequence[Tensor], shapes: Sequence[tuple[int, ...]],
        options: dict[int, Value] | None = None, type_: str | None = None,
    ) -> list[Tensor]:  # fmt: skip
        code, kind = OPERATORS[name]
        opcode = self._codes.setdefault((code, 1), len(self._codes))
        outputs = [self._tensor(tuple(shape), type_ or inputs[0].type) for shape in shapes]
        fields: dict[int, Value] = {
            0: Number(opcode, "I"), 1: Ints([t.index for t in inputs]), 2: Ints([t.index for t in outputs]),
        }  # fmt: skip
        if kind:
            fields |= {3: Number(kind, "B"), 4: Table(options or {})}
        self._operators.append(Table(fields))
        return outputs


def _is_same(
    shape: tuple[int, ...], kernel: tuple[int, ...], stride: int, pad: tuple[int, int, int, int]
) -> bool:  # fmt: skip
    """Return whether these zeros around a picture are those of TensorFlow's padding SAME."""
    wanted: list[int] = []
    for side, size in zip(shape[1:3], kernel, strict=True):
        total = max((-(-side // stride) - 1) * stride + size - side, 0)
        wanted += [total // 2, total - total // 2]
    return list(pad) == wanted
