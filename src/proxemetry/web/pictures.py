"""Photos for the browser: re-encoded without metadata, no larger than asked for, heads pixelated where asked for."""

from __future__ import annotations

import io
import threading
from collections import OrderedDict
from collections.abc import Callable, Hashable, Iterable

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


class PictureCache:
    """The latest pictures, up to a number of bytes."""

    def __init__(self, limit_bytes: int = 200_000_000) -> None:
        self._limit = limit_bytes
        self._size = 0
        self._lock = threading.Lock()
        self._kept: OrderedDict[Hashable, bytes] = OrderedDict()

    def get(self, key: Hashable, make: Callable[[], bytes]) -> bytes:
        """Return a picture, made where it is not kept."""
        with self._lock:
            if key in self._kept:
                self._kept.move_to_end(key)
                return self._kept[key]
        picture = make()
        with self._lock:
            if key not in self._kept:
                self._kept[key] = picture
                self._size += len(picture)
            while self._size > self._limit:
                self._size -= len(self._kept.popitem(last=False)[1])
        return picture
