"""Channels of several pictures, side by side in any order, written as few layers of a TensorFlow Lite network.

Taking, joining and exchanging channels moves numbers and computes nothing, and takes a network of small layers a
quarter of its time. Channels of a convolution cost nothing to choose or to put in order: its kernels are chosen and
ordered instead.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from .flatbuffer import Number, Value
from .tflite import ACTIVATIONS, Array, Network, Tensor

#: A transposition takes as long as so many parts take that are cut out or joined (LiteRT's XNNPACK on an x86
#: processor, sizes of PP-TinyPose: 38 and 8 to 10 microseconds for 64 x 48 pixels, 18 and 3.5 for 32 x 24).
_TRANSPOSITION = 5
_MOST_GROUPS = 16
#: No network has so many channels; the number of a damaged file may be anything.
_MOST_CHANNELS = 1 << 14
_ACTIVATION = 3  # a field of a convolution's options


@dataclass(frozen=True, eq=False)
class Convolution:
    """A convolution that is not written yet: weights (out, height, width, in), bias (out,), and the layer's options."""

    x: Tensor
    weights: Array
    bias: Array
    shape: tuple[int, ...]
    options: Mapping[int, Value]

    @property
    def is_scalable(self) -> bool:
        """Whether answers are twice as large where weights and bias are."""
        activation = self.options.get(_ACTIVATION, Number(ACTIVATIONS[""]))
        return isinstance(activation, Number) and activation.value in (ACTIVATIONS[""], ACTIVATIONS["relu"])


#: One channel: whose, and which of its own.
Channel = tuple[Tensor | Convolution, int]


class ChannelWriter:
    """What writes channels into a network, each part of a picture and of a convolution once."""

    def __init__(self, network: Network) -> None:
        self._network = network
        # by the source's identity; the source is kept, so that no other takes its place
        self._parts: dict[tuple[int, tuple[int, ...], int], tuple[Tensor | Convolution, Tensor]] = {}

    def in_order(self, channels: Sequence[Channel], times: int = 1) -> Tensor:
        """Write a picture of these channels in the cheapest way, multiplied by 1 or 2.

        That is part by part, or, where parts take turns, as the rows of a matrix whose columns are then the channels: a
        channel shuffle (ShuffleNet, Zhang et al. 2018), of two or more groups.
        """
        divisors = [n for n in range(1, _MOST_GROUPS + 1) if len(channels) % n == 0]
        groups = min(divisors, key=lambda n: _cost(channels, n))
        rows = [self._beside(channels[row::groups], times) for row in range(groups)]
        if groups == 1:
            return rows[0]
        # whole pictures one after the other: moved at once, where channels would be moved pixel by pixel
        shape = rows[0].shape
        x = self._network.reshape(self._network.concatenation(rows, 0), (groups, math.prod(shape)))
        return self._network.reshape(self._network.transpose(x, (1, 0)), (*shape[:-1], len(channels)))

    def in_any_order(self, channels: Sequence[Channel]) -> tuple[Tensor, list[int]]:
        """Write a picture of these channels, and return also which channel stands at each place."""
        sources = {id(source): number for number, (source, _) in reversed(list(enumerate(channels)))}
        order = sorted(range(len(channels)), key=lambda i: (sources[id(channels[i][0])], channels[i][1]))
        return self._beside([channels[i] for i in order]), order

    def _beside(self, channels: Sequence[Channel], times: int = 1) -> Tensor:
        pieces = [self._piece(run, times) for run in _runs(channels)]
        return pieces[0] if len(pieces) == 1 else self._network.concatenation(pieces, len(pieces[0].shape) - 1)

    def _piece(self, run: Sequence[Channel], times: int) -> Tensor:
        source, numbers = run[0][0], tuple(number for _, number in run)
        if times == 1 and isinstance(source, Tensor) and len(run) == source.shape[-1]:
            return source
        key = id(source), numbers, times
        if key not in self._parts:
            self._parts[key] = source, self._new_piece(source, run, times)
        return self._parts[key][1]

    def _new_piece(self, source: Tensor | Convolution, run: Sequence[Channel], times: int) -> Tensor:
        if times > 1 and not (isinstance(source, Convolution) and source.is_scalable):
            once = self._piece(run, 1)
            return self._network.arithmetic("add", once, once)
        numbers = [number for _, number in run]
        if isinstance(source, Tensor):
            return self._network.channels(source, numbers[0], numbers[-1] + 1)
        chosen = [values[numbers] for values in (source.weights, source.bias)]
        weights, bias = (self._network.constant(values * times if times > 1 else values) for values in chosen)
        shape = (*source.shape[:-1], len(numbers))
        return self._network.layer("conv", [source.x, weights, bias], [shape], source.options, "float32")[0]


def channels_of(source: Tensor | Convolution) -> list[Channel]:
    """Return all channels of a picture, in order.

    Raises:
        ValueError: there are more than any network has, as a damaged file may state.
    """
    if source.shape[-1] > _MOST_CHANNELS:
        raise ValueError(f"{source.shape[-1]} channels")
    return [(source, number) for number in range(source.shape[-1])]


def _cost(channels: Sequence[Channel], groups: int) -> int:
    """Return how many parts are moved to write channels in so many groups."""
    parts = sum(len(_runs(channels[row::groups])) for row in range(groups))
    return parts + (_TRANSPOSITION if groups > 1 else 0)


def _runs(channels: Sequence[Channel]) -> list[list[Channel]]:
    """Return channels parted into runs that are one piece: neighbours of a picture, any of one convolution."""
    runs: list[list[Channel]] = []
    for source, number in channels:
        last, at = runs[-1][-1] if runs else (None, 0)
        if last is source and (isinstance(source, Convolution) or number == at + 1):
            runs[-1].append((source, number))
        else:
            runs.append([(source, number)])
    return runs
