"""The XMP and IPTC packets in a file, as plain texts. Damaged ones are empty; nothing here raises."""

from __future__ import annotations

import re
import struct
from typing import TYPE_CHECKING, Any

from .embedded import iptc_of_tiff

if TYPE_CHECKING:
    from PIL import Image

_MAX_XMP_BYTES = 4_000_000
_XMP_PREFIXES = {
    "http://ns.adobe.com/exif/1.0/": "exif",
    "http://cipa.jp/exif/1.0/": "exifEX",
    "http://ns.adobe.com/exif/1.0/aux/": "aux",
    "http://ns.adobe.com/tiff/1.0/": "tiff",
    "http://ns.adobe.com/xap/1.0/": "xmp",
    "http://ns.google.com/photos/1.0/panorama/": "GPano",
    "http://ns.google.com/videos/1.0/spherical/": "GSpherical",
    "http://ns.adobe.com/camera-raw-settings/1.0/": "crs",
    "http://ns.adobe.com/photoshop/1.0/": "photoshop",
    "http://www.dji.com/drone-dji/1.0/": "drone-dji",
    "http://purl.org/dc/elements/1.1/": "dc",
    "http://iptc.org/std/Iptc4xmpExt/2008-02-29/": "iptcExt",
}
_RDF = "{http://www.w3.org/1999/02/22-rdf-syntax-ns#}"


def xmp_of(image: Image.Image, exif: dict[int, Any], remarks: list[str]) -> dict[str, tuple[str, ...]]:
    """Return the simple properties and lists of an XMP packet as prefix:name -> texts."""
    packet = image.info.get("xmp") or image.info.get("XML:com.adobe.xmp") or exif.get(700) or b""
    data = _utf_8(packet if isinstance(packet, str) else bytes(packet))
    # An entity can expand without end, and XMP has no use for one.
    if not data or len(data) > _MAX_XMP_BYTES or b"<!DOCTYPE" in data or b"<!ENTITY" in data:
        return {}
    from xml.etree import ElementTree

    try:
        root = ElementTree.fromstring(data)
    except (ElementTree.ParseError, ValueError, RecursionError, LookupError):
        remarks.append("XMP is damaged")
        return {}
    found: dict[str, tuple[str, ...]] = {}
    for description in root.iter(f"{_RDF}Description"):
        for name, value in description.attrib.items():
            found.setdefault(_prefixed(name), (value,))
        for element in description:
            items = tuple(item.text or "" for item in element.iter(f"{_RDF}li"))
            found.setdefault(_prefixed(element.tag), items or (element.text or "",))
    return found


def _utf_8(packet: str | bytes) -> bytes:
    """Return a packet as UTF-8 from its first bracket on; it may be in UTF-16 or 32, marked or not."""
    if isinstance(packet, bytes):
        at = packet.find(b"<")
        around = packet[max(at - 3, 0) : at + 4]
        wide = next((codec for sign, codec in _WIDE.items() if sign in around), None)
        if at >= 0 and wide is not None:
            start = at - _WIDE_START[wide]
            packet = packet[max(start, 0) :].decode(wide, "replace")
    if isinstance(packet, str):
        # A declaration would name the encoding that it had.
        packet = re.sub(r"^\s*<\?xml[^>]*\?>", "", packet[max(packet.find("<"), 0) :]).encode("utf-8", "replace")
    return packet[max(packet.find(b"<"), 0) :].rstrip(b"\0 \r\n\t")


#: How a bracket looks in wide encodings, the widest first, and how far into it the bracket's own byte stands.
_WIDE = {b"\0\0\0<": "utf-32-be", b"<\0\0\0": "utf-32-le", b"\0<": "utf-16-be", b"<\0": "utf-16-le"}
_WIDE_START = {"utf-32-be": 3, "utf-32-le": 0, "utf-16-be": 1, "utf-16-le": 0}


def _prefixed(name: str) -> str:
    namespace, _, local = name.rpartition("}")
    return f"{_XMP_PREFIXES.get(namespace.lstrip('{'), '?')}:{local}"


def first(xmp: dict[str, tuple[str, ...]], name: str) -> str:
    """Return the first text of a property, "" where there is none."""
    return next(iter(xmp.get(name, ())), "").strip()


def iptc_of(image: Image.Image, exif: dict[int, Any]) -> dict[int, tuple[str, ...]]:
    """Return the datasets of IPTC-IIM record 2 as number -> texts."""
    resources = image.info.get("photoshop")
    block = resources.get(0x0404) if isinstance(resources, dict) else exif.get(33723)
    if isinstance(block, int | tuple) and image.format == "TIFF":  # bytes declared as integers, of which one is read
        file = getattr(image, "fp", None)
        block = None if file is None else iptc_of_tiff(file)
    return _iim(block) if isinstance(block, bytes) else {}


def _iim(block: bytes) -> dict[int, tuple[str, ...]]:
    """Parse IPTC-IIM 4.2 datasets: 0x1C, record, dataset, two bytes of size, content."""
    found: dict[int, tuple[str, ...]] = {}
    at, codec = 0, "utf-8"
    while at + 5 <= len(block) and block[at] == 0x1C:
        record, dataset, size = struct.unpack(">BBH", block[at + 1 : at + 5])
        if size & 0x8000:  # extended datasets carry nothing we read
            break
        content, at = block[at + 5 : at + 5 + size], at + 5 + size
        if (record, dataset) == (1, 90) and not content.startswith(b"\x1b%G"):
            codec = "latin-1"
        if record == 2 and dataset in (55, 80, 90, 101, 110, 115, 120, 122):
            try:
                text = content.decode(codec)
            except UnicodeDecodeError:
                text = content.decode("latin-1")
            found[dataset] = (*found.get(dataset, ()), text)
    return found
