"""Photos for the browser: re-encoded without metadata, no larger than asked for, heads pixelated where asked for."""

from __future__ import annotations

import io
from collections.abc import Iterable

import numpy as np
from PIL import Image

from ..people import People
from ..photo import Photo
from ..plots.faces import heads_px, pixelated

#: Long sides that the page asks for; anything else would let a request fill the memory.
SIZES_PX = (320, 1600, 3200)
_QUALITY = {320: 78, 1600: 85, 3200: 88}


def jpeg(photo: Photo, long_side_px: int, blurred: Iterable[People] = ()) -> bytes:
    """Return an upright photo as JPEG, the heads of `blurred` pixelated; raises PhotoError where decoding fails."""
    pixels = photo.pixels(long_side_px)
    image = Image.fromarray(pixels)
    image.thumbnail((long_side_px, long_side_px), Image.Resampling.LANCZOS, reducing_gap=2.0)
    for people in blurred:
        scaled = people.scaled(image.width / photo.width, image.height / photo.height)
        image = Image.fromarray(pixelated(np.asarray(image), heads_px(scaled)))
    buffer = io.BytesIO()
    image.save(buffer, "JPEG", quality=_QUALITY[long_side_px])
    return buffer.getvalue()
