"""Three hundred damaged and hostile files: each is read, or is one PhotoError in one line, and memory stays small."""

from __future__ import annotations

import io
import json
import struct
import subprocess
import sys
import zlib
from collections.abc import Iterator

import numpy as np
import pytest
from PIL import Image

from synthetic.camera_files import FOCAL, FOCAL_35, MAKE, exif_of, gradient

COUNT = 300
MEMORY_LIMIT_MB = 1000
SUFFIXES = {"JPEG": "jpg", "PNG": "png", "TIFF": "tif", "WEBP": "webp", "GIF": "gif", "BMP": "bmp"}

#: Opens every file of a folder as a batch would, and tells what became of each and how much memory it took.
READER = """
import json, sys
from pathlib import Path
from benchmarks.robustness.process_memory import memory_bytes
from proxemetry.errors import PhotoError
from proxemetry.camera.focal import FocalRequest, estimate_camera
from proxemetry.photo import Photo
rows = {}
for path in sorted(Path(sys.argv[1]).iterdir()):
    try:
        photo = Photo.open(path, with_names=True, with_gps=True)
        estimate_camera(photo, FocalRequest(assume_fov_deg=60))
        shapes = [photo.pixels(size).shape for size in (200, None)]
        assert all(shape[2] == 3 for shape in shapes) and shapes[1][:2] == (photo.height, photo.width), shapes
        rows[path.name] = "ok"
    except PhotoError as error:
        rows[path.name] = f"PhotoError: {error}"
print(json.dumps({"rows": rows, "peak_mb": memory_bytes()[1] / 1e6}))
"""


def whole(rng: np.random.Generator, kind: str) -> bytes:
    """Return an undamaged photo with EXIF."""
    pixels = gradient(160, 120) ^ rng.integers(0, 32, (120, 160, 3), dtype=np.uint8)
    exif = exif_of({MAKE: "Canon", FOCAL: (50, 1), FOCAL_35: 50}, gps={1: "N", 2: (60.0, 10.0, 0.0)})
    buffer = io.BytesIO()
    options = {"exif": exif} if kind in ("JPEG", "PNG", "TIFF", "WEBP") else {}
    if kind == "JPEG" and rng.random() < 0.5:
        options["progressive"] = True
    Image.fromarray(pixels).save(buffer, kind, **options)
    return buffer.getvalue()


def damaged(rng: np.random.Generator) -> Iterator[tuple[str, bytes]]:
    """Yield truncated files, files with flipped bits, overwritten stretches, wrong endings and no content."""
    kinds = list(SUFFIXES)
    while True:
        kind = kinds[int(rng.integers(len(kinds)))]
        content, suffix = bytearray(whole(rng, kind)), SUFFIXES[kind]
        harm = ("cut", "flip", "head", "stretch", "suffix", "empty", "noise")[int(rng.integers(7))]
        if harm == "cut":
            del content[int(rng.integers(len(content))) :]
        elif harm in ("flip", "head"):
            reach = len(content) if harm == "flip" else min(400, len(content))
            for at in rng.integers(0, reach, 12):
                content[at] ^= 1 << int(rng.integers(8))
        elif harm == "stretch":
            at = int(rng.integers(len(content) - 50))
            content[at : at + 50] = rng.bytes(50)
        elif harm == "suffix":
            suffix = [s for s in (*SUFFIXES.values(), "heic", "dng", "nef", "avif") if s != suffix][
                int(rng.integers(8))
            ]
        elif harm == "empty":
            content.clear()
        else:
            content[:] = rng.bytes(int(rng.integers(1, 5000)))
        yield f"{harm}.{suffix}", bytes(content)


def png_chunk(kind: bytes, body: bytes) -> bytes:
    """Return one chunk of a PNG file."""
    return struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))


def png_header(width: int, height: int) -> bytes:
    """Return the beginning of a PNG file that declares that size."""
    header = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + png_chunk(b"IHDR", header)


def jpeg_with_exif(block: bytes) -> bytes:
    """Return a small JPEG whose EXIF block is these bytes."""
    plain = io.BytesIO()
    Image.new("RGB", (64, 48), "red").save(plain, "JPEG")
    segment = b"Exif\0\0" + block
    return plain.getvalue()[:2] + b"\xff\xe1" + struct.pack(">H", len(segment) + 2) + segment + plain.getvalue()[2:]


def hostile() -> Iterator[tuple[str, bytes]]:
    """Yield files that are made to do harm."""
    yield "huge_header.png", png_header(30000, 30000) + png_chunk(b"IDAT", zlib.compress(b"\0" * 1000))
    # 13000 x 13000 white pixels: 507 MB of bytes that shrink to half a megabyte
    bomb = zlib.compressobj(9)
    rows = b"".join(bomb.compress(b"\xff" * (13000 * 3 + 1)) for _ in range(20)) + bomb.flush()
    yield "bomb.png", png_header(13000, 13000) + png_chunk(b"IDAT", rows) + png_chunk(b"IEND", b"")
    huge = io.BytesIO()
    Image.new("L", (64, 64)).save(huge, "JPEG")
    at = huge.getvalue().index(b"\xff\xc0")
    grown = huge.getvalue()[: at + 5] + struct.pack(">HH", 30000, 30000) + huge.getvalue()[at + 9 :]
    yield "huge_header.jpg", grown
    yield (
        "huge_header.bmp",
        b"BM" + struct.pack("<IHHIIiiHHIIiiII", 100, 0, 0, 54, 40, 30000, 30000, 1, 24, 0, 0, 1, 1, 0, 0),
    )
    # an EXIF directory whose Exif pointer is itself, and whose next directory is itself
    loop = b"II*\0" + struct.pack("<IHHHIIHHIII", 8, 2, 0x8769, 4, 1, 8, 0x0112, 3, 1, 6, 8)
    yield "exif_loop.jpg", jpeg_with_exif(loop)
    yield "exif_far_pointer.jpg", jpeg_with_exif(b"II*\0" + struct.pack("<IHHHIII", 8, 1, 0x8769, 4, 1, 2**32 - 2, 0))
    yield "exif_huge_count.jpg", jpeg_with_exif(b"II*\0" + struct.pack("<IHHHIII", 8, 1, 0x010F, 2, 2**32 - 1, 8, 0))
    yield "exif_many_tags.jpg", jpeg_with_exif(b"II*\0" + struct.pack("<IH", 8, 65535) + b"\x0f\x01\x02\0" * 3000)
    tiff_loop = b"II*\0" + struct.pack("<IH", 8, 1) + struct.pack("<HHII", 0x0100, 4, 1, 10) + struct.pack("<I", 8)
    yield "directory_loop.tif", tiff_loop
    laughs = b'<!DOCTYPE x [<!ENTITY a "ha">' + b"".join(
        b'<!ENTITY %c "%s">' % (98 + i, b"&%c;" % (97 + i) * 10) for i in range(12)
    )
    xmp = b'<x:xmpmeta xmlns:x="adobe:ns:meta/">&m;</x:xmpmeta>'
    laughing = io.BytesIO()
    Image.new("RGB", (64, 48)).save(laughing, "PNG", exif=b"")
    body = b"XML:com.adobe.xmp\0\0\0\0\0" + laughs + b"]>" + xmp
    content = laughing.getvalue()
    yield "entities.png", content[:33] + png_chunk(b"iTXt", body) + content[33:]
    text = b"Raw profile type exif\0\0" + zlib.compress(b"\nexif\n" + b"41" * 40_000_000)
    yield "text_bomb.png", content[:33] + png_chunk(b"zTXt", text) + content[33:]
    yield "not_a_photo.jpg", b"<html><body>404</body></html>"
    yield "script.eps", b"%!PS-Adobe-3.0 EPSF-3.0\n%%BoundingBox: 0 0 30000 30000\n"
    yield "script.jpg", b"%!PS-Adobe-3.0 EPSF-3.0\n%%BoundingBox: 0 0 100 100\n%%EndComments\nshowpage\n"
    yield "fake.heic", struct.pack(">I", 24) + b"ftypheic" + bytes(100)
    yield "fake.cr2", b"II*\0\x10\0\0\0CR\x02\0" + bytes(200)


@pytest.fixture(scope="module")
def outcome(tmp_path_factory: pytest.TempPathFactory) -> dict[str, str]:
    folder = tmp_path_factory.mktemp("hostile")
    files = list(hostile())
    harm = damaged(np.random.default_rng(3))
    files += [next(harm) for _ in range(COUNT - len(files))]
    for number, (name, content) in enumerate(files):
        (folder / f"{number:03d}_{name}").write_bytes(content)
    run = subprocess.run(
        [sys.executable, "-W", "error", "-c", READER, str(folder)], capture_output=True, text=True, timeout=300
    )
    assert run.returncode == 0, run.stderr[-2000:]
    told = json.loads(run.stdout.splitlines()[-1])
    assert told["peak_mb"] < MEMORY_LIMIT_MB
    return told["rows"]


def test_every_file_has_its_row(outcome: dict[str, str]) -> None:
    assert len(outcome) == COUNT


def test_reasons_are_one_line_that_names_the_file(outcome: dict[str, str]) -> None:
    for name, said in outcome.items():
        assert said == "ok" or (name in said and "\n" not in said and len(said) < 500), said


def test_what_cannot_be_a_photo_is_refused(outcome: dict[str, str]) -> None:
    refused = ("empty", "noise", "huge_header", "bomb", "not_a_photo", "script", "fake", "directory_loop")
    for name, said in outcome.items():
        if name[4:].partition(".")[0] in refused:
            assert said.startswith("PhotoError"), (name, said)


def test_hostile_metadata_do_not_cost_the_photo(outcome: dict[str, str]) -> None:
    harmless = ("exif_loop", "exif_far_pointer", "exif_huge_count", "exif_many_tags", "entities")
    for name, said in outcome.items():
        if name[4:].partition(".")[0] in harmless:
            assert said == "ok", (name, said)
    assert sum(said == "ok" for name, said in outcome.items() if "suffix" in name) > 10  # the content decides
