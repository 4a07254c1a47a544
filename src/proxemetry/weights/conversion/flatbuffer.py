"""FlatBuffers: tables, vectors and numbers, written as bytes (the same wherever and whenever it runs) and read.

The encoding is that of https://flatbuffers.dev/internals. A library's writer may lay out the same content otherwise in
its next version; a converted network is pinned by its hash, so the layout is written here: every table directly after
its own list of offsets, then what it points to, in the order of the fields.
"""

from __future__ import annotations

import struct
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field


@dataclass(frozen=True)
class Number:
    """One scalar: its value and its struct format (b, B, i, I, f)."""

    value: float
    format: str = "i"


@dataclass(frozen=True)
class Table:
    """A table: field number -> what it holds. A field that is left out has its default."""

    fields: Mapping[int, Value] = field(default_factory=dict[int, "Value"])


@dataclass(frozen=True)
class Bytes:
    """A vector of bytes whose first lies at a multiple of `alignment`."""

    content: bytes
    alignment: int = 4


@dataclass(frozen=True)
class Ints:
    """A vector of 32-bit integers."""

    values: Sequence[int]


@dataclass(frozen=True)
class Floats:
    """A vector of 32-bit floating-point numbers."""

    values: Sequence[float]


@dataclass(frozen=True)
class Longs:
    """A vector of 64-bit integers."""

    values: Sequence[int]


@dataclass(frozen=True)
class Tables:
    """A vector of tables."""

    values: Sequence[Table]


Value = Number | Table | Bytes | Ints | Floats | Longs | Tables


def written(root: Table, identifier: bytes) -> bytes:
    """Return a FlatBuffer with this root table and file identifier of four bytes."""
    writer = Writer(b"\0\0\0\0" + identifier)
    writer.point(0, writer.table(root))
    return bytes(writer.content)


class Writer:
    """What is written so far, `content`, and what appends to it."""

    def __init__(self, content: bytes = b"") -> None:
        self.content = bytearray(content)

    def align(self, size: int, ahead: int = 0) -> None:
        """Add zeros until what follows after `ahead` more bytes lies at a multiple of `size`."""
        self.content += b"\0" * (-(len(self.content) + ahead) % size)

    def point(self, at: int, target: int) -> None:
        """Let the offset at `at` lead to `target`, which lies after it."""
        struct.pack_into("<I", self.content, at, target - at)

    def value(self, value: Value) -> int:
        """Append what a field points to, and return where it begins."""
        match value:
            case Table():
                return self.table(value)
            case Bytes():
                return self.bytes(value)
            case Ints():
                return self.bytes(Bytes(struct.pack(f"<{len(value.values)}i", *value.values)), len(value.values))
            case Floats():
                return self.bytes(Bytes(struct.pack(f"<{len(value.values)}f", *value.values)), len(value.values))
            case Longs():
                return self.bytes(Bytes(struct.pack(f"<{len(value.values)}q", *value.values), 8), len(value.values))
            case Tables():
                return self.tables(value.values)
            case Number():
                raise TypeError("a number lies in its table")

    def table(self, table: Table) -> int:
        """Append a table and what it points to, and return where it begins."""
        offsets, size = _layout(table)
        self.align(4, ahead=4 + 2 * len(offsets))
        self.content += struct.pack(f"<{2 + len(offsets)}H", 4 + 2 * len(offsets), size, *offsets)
        begin = len(self.content)
        self.content += struct.pack("<i", 4 + 2 * len(offsets)) + bytes(size - 4)
        for number, value in sorted(table.fields.items()):
            at = begin + offsets[number]
            if isinstance(value, Number):
                struct.pack_into(f"<{value.format}", self.content, at, value.value)
            else:
                self.point(at, self.value(value))
        return begin

    def bytes(self, value: Bytes, count: int | None = None) -> int:
        """Append a vector of so many numbers, and return where it begins."""
        self.align(max(value.alignment, 4), ahead=4)
        begin = len(self.content)
        self.content += struct.pack("<I", len(value.content) if count is None else count) + value.content
        return begin

    def tables(self, values: Sequence[Table]) -> int:
        """Append a vector of tables, and return where it begins."""
        self.align(4)
        begin = len(self.content)
        self.content += struct.pack("<I", len(values)) + bytes(4 * len(values))
        for place, table in enumerate(values):
            self.point(begin + 4 + 4 * place, self.table(table))
        return begin


class Reader:
    """Tables, vectors and numbers of a FlatBuffer, by where they lie in it; 0 or nothing for what is left out.

    Raises struct.error, IndexError or ValueError where an offset leads out of the file.
    """

    def __init__(self, content: bytes | bytearray) -> None:
        self.content = content

    def led_to(self, place: int) -> int:
        """Return where the offset at `place` leads."""
        return place + struct.unpack_from("<I", self.content, place)[0]

    def field(self, table: int, number: int) -> int:
        """Return where a table's field lies, 0 where it is left out."""
        layout = table - struct.unpack_from("<i", self.content, table)[0]
        size = struct.unpack_from("<H", self.content, layout)[0]
        at = 4 + 2 * number
        offset = struct.unpack_from("<H", self.content, layout + at)[0] if at < size else 0
        return table + offset if offset else 0

    def number(self, table: int, number: int, format_: str) -> int:
        """Return a whole number in a table's field, by its struct format."""
        at = self.field(table, number)
        return int(struct.unpack_from(f"<{format_}", self.content, at)[0]) if at else 0

    def vector(self, table: int, number: int) -> tuple[int, int]:
        """Return where the numbers of a table's vector begin, and how many there are."""
        at = self.field(table, number)
        if not at:
            return 0, 0
        begin = self.led_to(at)
        count = int(struct.unpack_from("<I", self.content, begin)[0])
        if count > len(self.content) - begin:
            raise ValueError(f"{count} numbers from byte {begin} on")
        return begin + 4, count

    def slots(self, table: int, number: int) -> list[int]:
        """Return where each offset of a table's vector of tables lies."""
        begin, count = self.vector(table, number)
        return [begin + 4 * i for i in range(count)]

    def tables(self, table: int, number: int) -> list[int]:
        """Return where each table of a table's vector begins."""
        return [self.led_to(place) for place in self.slots(table, number)]

    def ints(self, table: int, number: int) -> list[int]:
        """Return a table's vector of 32-bit integers."""
        begin, count = self.vector(table, number)
        return list(struct.unpack_from(f"<{count}i", self.content, begin))

    def bytes(self, table: int, number: int) -> bytes:
        """Return a table's vector of bytes."""
        begin, count = self.vector(table, number)
        return bytes(self.content[begin : begin + count])


def _layout(table: Table) -> tuple[list[int], int]:
    """Return each field's offset in the table, 0 for those left out, and the table's size in bytes."""
    offsets, size = [0] * (max(table.fields, default=-1) + 1), 4
    for number, value in sorted(table.fields.items()):
        width = struct.calcsize(value.format) if isinstance(value, Number) else 4
        size += -size % width
        offsets[number] = size
        size += width
    return offsets, size + -size % 4
