"""A TFLite network without the layers that only one of its outputs needs.

The landmark network also draws a silhouette, which most passes over a square have no use for. Without
this module a photo takes 21 % more CPU time (nine photos, normal effort), so that it stays although it edits bytes by
hand. The file itself stays as it is: what is run is a copy in memory whose lists of outputs and of
operators are shortened, by the schema of TensorFlow Lite (tensorflow/lite/schema/schema.fbs) in the FlatBuffers
encoding (https://flatbuffers.dev/internals).
"""

from __future__ import annotations

import struct

from ...errors import ModelError

# Fields by their position in the schema's tables.
_MODEL_SUBGRAPHS = 2
_GRAPH_TENSORS, _GRAPH_OUTPUTS, _GRAPH_OPERATORS = 0, 2, 3
_OPERATOR_INPUTS, _OPERATOR_OUTPUTS = 1, 2
_TENSOR_SHAPE = 0


class _Buffer:
    """A FlatBuffer that is read and shortened in place."""

    def __init__(self, content: bytes) -> None:
        self.content = bytearray(content)

    def number(self, at: int) -> int:
        return struct.unpack_from("<i", self.content, at)[0]

    def follow(self, at: int) -> int:
        return at + self.number(at)

    def vector(self, table: int, field: int) -> range:
        """Return where the four-byte entries of a table's vector lie; the vector's length lies before them."""
        layout = table - self.number(table)
        size = struct.unpack_from("<H", self.content, layout)[0]
        entry = 4 + 2 * field
        offset = struct.unpack_from("<H", self.content, layout + entry)[0] if entry < size else 0
        if not offset:
            return range(0)
        start = self.follow(table + offset)
        return range(start + 4, start + 4 + 4 * self.number(start), 4)

    def numbers(self, table: int, field: int) -> list[int]:
        return [self.number(at) for at in self.vector(table, field)]

    def tables(self, table: int, field: int) -> list[int]:
        return [self.follow(at) for at in self.vector(table, field)]

    def shorten(self, table: int, field: int, entries: list[int], *, relative: bool) -> None:
        """Replace a vector's entries by fewer; tables' places are written relative to the entry."""
        places = self.vector(table, field)
        for at, entry in zip(places, entries, strict=False):
            struct.pack_into("<i", self.content, at, entry - at if relative else entry)
        struct.pack_into("<i", self.content, places.start - 4, len(entries))


def without_output(content: bytes, elements: int) -> bytes:
    """Return a network without its output of that many elements, and without the operators that nothing else needs.

    Raises ModelError where there is no such output, or where the bytes are no network.
    """
    try:
        return _without_output(_Buffer(content), elements)
    except struct.error as error:
        raise ModelError(f"a network of {len(content)} bytes is no TFLite file ({error})") from error


def _without_output(buffer: _Buffer, elements: int) -> bytes:
    graph = buffer.tables(buffer.follow(0), _MODEL_SUBGRAPHS)[0]
    tensors = buffer.tables(graph, _GRAPH_TENSORS)
    outputs = buffer.numbers(graph, _GRAPH_OUTPUTS)
    kept = [output for output in outputs if _elements(buffer, tensors[output]) != elements]
    if len(kept) == len(outputs):
        raise ModelError(f"the network has no output of {elements} elements")
    needed, operators = set(kept), list[int]()
    for operator in reversed(buffer.tables(graph, _GRAPH_OPERATORS)):  # they stand in the order they run in
        if needed.intersection(buffer.numbers(operator, _OPERATOR_OUTPUTS)):
            needed.update(buffer.numbers(operator, _OPERATOR_INPUTS))
            operators.append(operator)
    buffer.shorten(graph, _GRAPH_OUTPUTS, kept, relative=False)
    buffer.shorten(graph, _GRAPH_OPERATORS, operators[::-1], relative=True)
    return bytes(buffer.content)


def _elements(buffer: _Buffer, tensor: int) -> int:
    total = 1
    for side in buffer.numbers(tensor, _TENSOR_SHAPE):
        total *= side
    return total
