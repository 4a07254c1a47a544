"""The same network in fewer layers: what is made of a TensorFlow Lite file when it is loaded to run.

Three rewritings, whose answers are the file's but for rounding:

- Channels that are split, joined and shuffled are only looked up, and written where a layer needs them (`channels`).
- Sums of enlarged pictures are taken before they are enlarged: x + double(a) + double(double(b)) is
  x + double(a + double(b)).
- Of the maxima around each pixel a larger one is taken of the next smaller: 9 x 9 is 5 x 5 of 5 x 5.

The file stays as it was fetched or converted, and so do its hash and its name in results.
`benchmarks/speed/simplified.py` measures what that saves.
"""

from __future__ import annotations

import functools
import struct
from collections import Counter
from dataclasses import dataclass, replace

import numpy as np

from .channels import Channel, ChannelWriter, Convolution, channels_of
from .flatbuffer import Number
from .graph import Graph, Operator, read_graph
from .tflite import Network, Tensor

_NO_ACTIVATION, _SAME = 0, 0


@dataclass(frozen=True, eq=False)
class _Beside:
    """Channels side by side that are not written yet."""

    channels: list[Channel]


@dataclass(frozen=True, eq=False)
class _Sum:
    """Pictures that are not added yet, each to be enlarged by a power of two before."""

    terms: tuple[tuple[int, _Value], ...]


_Value = Tensor | Convolution | _Beside | _Sum


def simplified(content: bytes) -> bytes:
    """Return the network in fewer layers; the file itself where nothing is gained, or it has layers unknown here."""
    graph = read_graph(content)
    if graph is None:
        return content
    try:
        rewriting = _Rewriting(graph)
        answer = rewriting.run()
    except (ArithmeticError, IndexError, KeyError, ValueError, struct.error):
        return content  # a damaged file, of which the runtime will complain
    return answer if rewriting.is_simpler else content


class _Rewriting:
    """A network's layers in order, each written once something needs it."""

    def __init__(self, graph: Graph) -> None:
        self._graph, self._network = graph, Network()
        self._writer = ChannelWriter(self._network)
        self.is_simpler = False
        self._makers = {index: operator for operator in graph.operators for index in operator.outputs}
        self._users: dict[int, list[Operator | None]] = {index: [None] for index in graph.outputs}
        for operator in graph.operators:
            for index in set(operator.inputs):
                self._users.setdefault(index, []).append(operator)
        #: The last layer of a channel shuffle -> what comes in and how many groups; of a doubling -> what comes in.
        self._shuffles: dict[int, tuple[int, int]] = {}
        self._doublings: dict[int, int] = {}
        self._inner: set[int] = set()  # what the other layers of these give
        for operator in graph.operators:
            self._find_shuffle(operator)
            self._find_doubling(operator)
        self._values: dict[int, _Value] = {}
        self._written: dict[int, tuple[_Value, Tensor]] = {}
        self._maxima: dict[int, list[tuple[int, Tensor]]] = {}

    def run(self) -> bytes:
        """Return the network, written."""
        graph = self._graph
        for index in graph.inputs:
            self._values[index] = self._network.input(graph.shapes[index], graph.types[index])
        for operator in graph.operators:
            if operator.outputs[0] not in self._inner:
                self._values.update(zip(operator.outputs, self._answers(operator), strict=True))
        return self._network.written([self._tensor(index) for index in graph.outputs])

    # --- what the file has

    def _find_shuffle(self, last: Operator) -> None:
        """Find groups, exchanged, flat again: a channel shuffle (ShuffleNet, Zhang et al. 2018)."""
        transpose = self._only_for(last, "reshape", last.inputs[0], "transpose")
        first = transpose and self._only_for(transpose, "transpose", transpose.inputs[0], "reshape")
        if not transpose or not first:
            return
        shapes = self._graph.shapes
        picture, parted, flat = (shapes[i] for i in (first.inputs[0], first.outputs[0], last.outputs[0]))
        axes = self._graph.constants.get(transpose.inputs[1], np.zeros(0)).tolist()
        end = len(picture) - 1
        if picture == flat and parted[:-2] == picture[:-1] and axes == [*range(end), end + 1, end]:
            self._shuffles[last.outputs[0]] = first.inputs[0], parted[-2]
            self.is_simpler = True
            self._inner |= {transpose.outputs[0], first.outputs[0]}

    def _find_doubling(self, last: Operator) -> None:
        """Find four times the same, laid out as 2 x 2 pixels (`tflite.Network.doubled`)."""
        fourfold = self._only_for(last, "depth_to_space", last.inputs[0], "concatenation")
        if fourfold is None or last.option(0) != 2 or not _joins_channels(fourfold, self._graph):
            return
        one = fourfold.inputs[0]
        if fourfold.inputs == (one,) * 4 and self._graph.shapes[one][0] == 1:
            self._doublings[last.outputs[0]] = one
            self._inner.add(fourfold.outputs[0])

    def _only_for(self, user: Operator, kind: str, index: int, maker: str) -> Operator | None:
        """Return the layer of that name that gives a tensor, where it is for this user of this kind alone."""
        found = self._makers.get(index)
        if user.name != kind or found is None or found.name != maker or self._users[index] != [user]:
            return None
        return found

    def _role(self, operator: Operator | None) -> str:
        """Return what becomes of what a layer gets: it is added up ("sum"), its channels are moved, or neither."""
        if operator is None:
            return ""
        if _is_sum(operator, self._graph) or (operator.outputs[0] in self._inner and operator.name == "concatenation"):
            return "sum"
        return "channels" if _joins_channels(operator, self._graph) or _splits_channels(operator, self._graph) else ""

    # --- layer by layer

    def _answers(self, operator: Operator) -> list[_Value]:
        (output, *_), graph = operator.outputs, self._graph
        if output in self._shuffles:
            index, groups = self._shuffles[output]
            channels = self._channels(index)
            size = len(channels) // groups
            return [_Beside([channels[group * size + i] for i in range(size) for group in range(groups)])]
        if output in self._doublings:
            return [_Sum(tuple((2 * scale, value) for scale, value in self._terms(self._doublings[output])))]
        if _is_sum(operator, graph):
            return [_Sum(tuple(term for index in operator.inputs for term in self._terms(index)))]
        if _joins_channels(operator, graph):
            return [_Beside([channel for index in operator.inputs for channel in self._channels(index)])]
        if _splits_channels(operator, graph):
            channels = self._channels(operator.inputs[1])
            size = len(channels) // len(operator.outputs)
            return [_Beside(channels[at : at + size]) for at in range(0, len(channels), size)]
        if operator.name == "conv" and set(operator.inputs[1:]) <= set(graph.constants):
            return [self._convolution(operator)]
        if operator.name == "max_pool" and _is_maximum_around(operator):
            return [self._maximum(operator)]
        return list(self._copied(operator, [self._tensor(index) for index in operator.inputs]))

    def _copied(self, operator: Operator, inputs: list[Tensor]) -> list[Tensor]:
        shapes, types = self._graph.shapes, self._graph.types
        outputs = operator.outputs
        return self._network.layer(
            operator.name, inputs, [shapes[i] for i in outputs], operator.options, types[outputs[0]]
        )

    def _convolution(self, operator: Operator) -> _Value:
        index, weights, bias = operator.inputs
        value, kernels = self._values.get(index), self._graph.constants[weights]
        if isinstance(value, _Beside) and len(self._users[index]) == 1 and kernels.shape[3] == len(value.channels):
            x, order = self._writer.in_any_order(value.channels)
            kernels = kernels[..., order]
        else:
            x = self._tensor(index)
        (output,) = operator.outputs
        shape = self._graph.shapes[output]
        convolution = Convolution(x, kernels, self._graph.constants[bias], shape, operator.options)
        roles = {self._role(user) for user in self._users.get(output, [])}
        # a larger kernel's zeros around the picture are the runtime's own only where one convolution needs them
        is_free = kernels.shape[1:3] == (1, 1) and roles in ({"sum"}, {"channels"})
        return convolution if is_free else self._solid(convolution)

    def _maximum(self, operator: Operator) -> Tensor:
        """Write the maxima around each pixel, of those in a smaller square around it where these are written."""
        x, size = self._tensor(operator.inputs[0]), int(operator.option(3))
        done = self._maxima.setdefault(x.index, [(1, x)])
        smaller, of = max((known for known in done if known[0] <= size), key=lambda known: known[0])
        self.is_simpler |= smaller > 1
        options = {**operator.options, 3: (rest := Number(size - smaller + 1)), 4: rest}
        (answer,) = self._copied(replace(operator, options=options), [of])
        done.append((size, answer))
        return answer

    # --- what is not written yet

    def _channels(self, index: int) -> list[Channel]:
        value = self._values.get(index)
        if isinstance(value, _Beside):
            return value.channels
        return channels_of(value if isinstance(value, Convolution) else self._tensor(index))

    def _terms(self, index: int) -> tuple[tuple[int, _Value], ...]:
        """Return the terms of a sum that nothing else needs; of anything else, itself."""
        value = self._values.get(index)
        if isinstance(value, _Sum) and len(self._users[index]) == 1:
            return value.terms
        return ((1, self._tensor(index) if value is None else value),)

    def _tensor(self, index: int) -> Tensor:
        if index in self._graph.constants and index not in self._values:
            self._values[index] = self._network.constant(self._graph.constants[index])
        return self._solid(self._values[index])

    def _solid(self, value: _Value) -> Tensor:
        if isinstance(value, Tensor):
            return value
        if id(value) not in self._written:  # the value is kept, so that no other gets its identity
            self._written[id(value)] = value, self._write(value)
        return self._written[id(value)][1]

    def _write(self, value: Convolution | _Beside | _Sum) -> Tensor:
        match value:
            case Convolution():
                return self._writer.in_order(channels_of(value))
            case _Beside():
                return self._writer.in_order(value.channels)
            case _Sum():
                return self._added(value)

    def _added(self, value: _Sum) -> Tensor:
        """Write a sum, the smallest pictures first."""
        total: Tensor | None = None
        scale = max(scale for scale, _ in value.terms)
        while True:
            pictures = self._pictures([term for of_scale, term in value.terms if of_scale == scale])
            own = functools.reduce(functools.partial(self._network.arithmetic, "add"), pictures) if pictures else None
            if total is not None:
                own = self._network.doubled(total) if own is None else self._on_double(own, total)
            if scale == 1:
                assert own is not None  # the largest term or what became of it
                return own
            total, scale = own, scale // 2

    def _on_double(self, large: Tensor, small: Tensor) -> Tensor:
        """Add to each 2 x 2 pixels the one pixel of a picture of half the size."""
        self.is_simpler = True
        _, height, width, channels = small.shape
        pixels = self._network.reshape(small, (height, 1, width, 1, channels))
        squares = self._network.reshape(large, (height, 2, width, 2, channels))
        return self._network.reshape(self._network.arithmetic("add", squares, pixels), large.shape)

    def _pictures(self, terms: list[_Value]) -> list[Tensor]:
        """Write the terms of one size; what is not written yet and is there twice is written twice as large."""
        times = Counter(id(term) for term in terms)
        pictures: list[Tensor] = []
        for term in {id(term): term for term in terms}.values():
            count = times[id(term)]
            if isinstance(term, Convolution) and count == 2:
                pictures.append(self._writer.in_order(channels_of(term), 2))
            elif isinstance(term, _Beside) and count == 2:
                pictures.append(self._writer.in_order(term.channels, 2))
            else:
                pictures += [self._solid(term)] * count
        return pictures


def _is_sum(operator: Operator, graph: Graph) -> bool:
    shapes = {graph.shapes[index] for index in (*operator.inputs, *operator.outputs)}
    return operator.name == "add" and operator.option(0) == _NO_ACTIVATION and len(shapes) == 1


def _joins_channels(operator: Operator, graph: Graph) -> bool:
    if operator.name != "concatenation" or operator.option(1) != _NO_ACTIVATION:
        return False
    rank = len(graph.shapes[operator.outputs[0]])
    return rank == 4 and operator.option(0) % rank == rank - 1


def _splits_channels(operator: Operator, graph: Graph) -> bool:
    if operator.name != "split" or operator.inputs[0] not in graph.constants:
        return False
    rank = len(graph.shapes[operator.outputs[0]])
    return rank == 4 and int(graph.constants[operator.inputs[0]].ravel()[0]) % rank == rank - 1


def _is_maximum_around(operator: Operator) -> bool:
    """Return whether a layer takes the maximum of as many pixels to each side, around every pixel."""
    padding, *steps, width, height, activation = (operator.option(number) for number in range(6))
    is_plain = (padding, activation) == (_SAME, _NO_ACTIVATION) and steps == [1, 1]
    return is_plain and width == height and width % 2 == 1
