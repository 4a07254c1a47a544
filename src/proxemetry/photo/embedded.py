"""Metadata that the image library passes over: behind a PNG's pixels, in JPEG 2000, IPTC of a TIFF as integers.

Nothing here raises for hostile bytes: what is damaged is not there.
"""

from __future__ import annotations

import struct
import zlib
from collections.abc import Iterator
from pathlib import Path
from typing import IO, Any

#: No more of one block than this, and no more blocks: a hostile file ends here.
_MOST_BYTES, _MOST_BLOCKS = 64_000_000, 100_000
_PNG = b"\x89PNG\r\n\x1a\n"
_JP2 = b"\x00\x00\x00\x0cjP  \r\n\x87\n"
_XMP_KEYWORD = b"XML:com.adobe.xmp"
#: UUIDs of the boxes in which JPEG 2000 files carry metadata (ISO 15444-2; XMP specification, part 3).
_EXIF_BOX = b"JpgTiffExif->JP2"
_XMP_BOX = bytes.fromhex("be7acfcb97a942e89c71999491e3afac")
_IPTC_BOX = bytes.fromhex("33c7a4d2b81d4723a0baf1a3e097ad38")
#: The tag of IPTC in a TIFF, and the type of 32-bit integers.
_IPTC_TAG, _LONG = 33723, 4


def embedded(path: Path) -> dict[str, Any]:
    """Return what a PNG or JPEG 2000 file carries where the image library does not look, as its `info` would have it.

    Keys: "exif" and "xmp" (bytes), "photoshop" (a dict of resources, IPTC being 0x0404).
    """
    try:
        with path.open("rb") as file:
            start = file.read(12)
            if start[:8] == _PNG:
                file.seek(8)
                return dict(_of_png(file))
            if start == _JP2:
                file.seek(0)
                return dict(_of_jpeg_2000(file))
    except (OSError, struct.error, ValueError, zlib.error):
        pass
    return {}


def _of_png(file: IO[bytes]) -> Iterator[tuple[str, Any]]:
    for _ in range(_MOST_BLOCKS):
        head = file.read(8)
        if len(head) < 8:
            return
        size, kind = struct.unpack(">I4s", head)
        if kind == b"eXIf" and size <= _MOST_BYTES:
            yield "exif", b"Exif\0\0" + file.read(size)
            file.seek(4, 1)
        elif kind == b"iTXt" and size <= _MOST_BYTES:
            text = _xmp_text(file.read(size))
            if text is not None:
                yield "xmp", text
            file.seek(4, 1)
        else:
            file.seek(size + 4, 1)  # and its checksum


def _xmp_text(chunk: bytes) -> bytes | None:
    """Return the XMP packet of an iTXt chunk: keyword, compression, language, translated keyword, text."""
    keyword, _, rest = chunk.partition(b"\0")
    if keyword != _XMP_KEYWORD or len(rest) < 2:
        return None
    text = rest[2:].split(b"\0", 2)[-1]
    return zlib.decompressobj().decompress(text, _MOST_BYTES) if rest[0] else text


def _of_jpeg_2000(file: IO[bytes]) -> Iterator[tuple[str, Any]]:
    for _ in range(_MOST_BLOCKS):
        at = file.tell()
        head = file.read(16)
        if len(head) < 8:
            return
        size, kind = struct.unpack(">I4s", head[:8])
        begins = 8
        if size == 1 and len(head) == 16:
            size, begins = struct.unpack(">Q", head[8:])[0], 16
        if kind == b"uuid" and begins + 16 < size <= _MOST_BYTES:
            file.seek(at + begins)
            uuid, content = file.read(16), file.read(size - begins - 16)
            if uuid == _EXIF_BOX:
                yield "exif", b"Exif\0\0" + content
            elif uuid == _XMP_BOX:
                yield "xmp", content
            elif uuid == _IPTC_BOX:
                yield "photoshop", {0x0404: content}
        if size < begins:  # 0: to the end of the file
            return
        file.seek(at + size)


def iptc_of_tiff(file: IO[bytes]) -> bytes | None:
    """Return the IPTC block of a TIFF where it is declared as 32-bit integers, of which the image library reads one.

    The bytes stand as they are, unless their writer took them for integers of another byte order.
    """
    try:
        file.seek(0)
        head = file.read(8)
        order = {b"II": "<", b"MM": ">"}.get(head[:2])
        if order is None or struct.unpack(f"{order}H", head[2:4])[0] != 42:
            return None
        (at,) = struct.unpack(f"{order}I", head[4:])
        for _ in range(16):  # pages
            if not at:
                return None
            file.seek(at)
            (count,) = struct.unpack(f"{order}H", file.read(2))
            entries = file.read(12 * count)
            (following,) = struct.unpack(f"{order}I", file.read(4))
            for start in range(0, 12 * count, 12):
                tag, kind, number, offset = struct.unpack(f"{order}HHII", entries[start : start + 12])
                if tag == _IPTC_TAG and kind == _LONG and 1 < number <= _MOST_BYTES // 4:
                    file.seek(offset)
                    return _in_order(file.read(4 * number))
            at = following
    except (OSError, struct.error, ValueError):
        pass
    return None


def _in_order(block: bytes) -> bytes:
    if block[:1] == b"\x1c":
        return block
    whole = block[: len(block) // 4 * 4]
    turned = b"".join(whole[k : k + 4][::-1] for k in range(0, len(whole), 4))
    return turned if turned[:1] == b"\x1c" else block
