"""How a rectangle of a photo gets into a network's input, and how points get back, exactly.

Coordinates are continuous with (0, 0) at the outer corner of the top-left pixel, in the photo and in the input alike,
so both ways are one multiplication and one shift an axis; nothing is rounded but the size of what is drawn, and the
scale is that of the size as drawn.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ...arrays import FloatArray
from ...photo import RGBArray

Region = tuple[int, int, int, int]

#: The grey around a letterboxed photo that YOLOX and RTMDet were trained with.
GREY = 114
#: A tile laid around a suspicion shows this much more of its sides, as fractions of the box.
_SUSPECT_MARGIN = 0.1
#: A box of more than this share of a tile's side would touch its edges, where it counts as cut.
_FILLS_A_TILE = 0.96


@dataclass(frozen=True)
class Placement:
    """Where a region of the photo lies in an input: input = (photo - origin) * scale + shift, x and y."""

    origin: tuple[float, float]
    scale: tuple[float, float]
    shift: tuple[float, float] = (0.0, 0.0)

    def to_input(self, points_px: ArrayLike) -> FloatArray:
        """Return points of the photo, shape (..., 2), as points of the input."""
        return (np.asarray(points_px, dtype=float) - self.origin) * self.scale + self.shift

    def to_photo(self, points: ArrayLike) -> FloatArray:
        """Return points of the input, shape (..., 2), as points of the photo."""
        return (np.asarray(points, dtype=float) - self.shift) / self.scale + self.origin

    def boxes_to_photo(self, boxes: ArrayLike) -> FloatArray:
        """Return boxes of the input, shape (N, 4) as x0, y0, x1, y1, as boxes of the photo."""
        return self.to_photo(np.asarray(boxes, dtype=float).reshape(-1, 2, 2)).reshape(-1, 4)


def letterbox(
    pixels: RGBArray, region: Region, size: tuple[int, int], *, fill: int = GREY, centred: bool = False
) -> tuple[RGBArray, Placement]:
    """Draw a region of the photo as large as fits into an input of `size` (width, height), keeping its shape.

    The region lies at the input's top left, or in its middle where `centred`; the rest is `fill`. Shrinking averages
    over areas, so that nothing aliases.
    """
    import cv2

    x0, y0, x1, y1 = region
    factor = min(size[0] / (x1 - x0), size[1] / (y1 - y0))
    width = min(size[0], max(1, round((x1 - x0) * factor)))
    height = min(size[1], max(1, round((y1 - y0) * factor)))
    left, top = ((size[0] - width) // 2, (size[1] - height) // 2) if centred else (0, 0)
    canvas = np.full((size[1], size[0], 3), fill, np.uint8)
    how = cv2.INTER_AREA if factor < 1 else cv2.INTER_LINEAR
    canvas[top : top + height, left : left + width] = cv2.resize(
        pixels[y0:y1, x0:x1], (width, height), interpolation=how
    )
    return canvas, Placement((x0, y0), (width / (x1 - x0), height / (y1 - y0)), (left, top))


def tiles(width: int, height: int, fraction: float, aspect: float = 1.0, overlap: float = 0.3) -> Iterator[Region]:
    """Yield tiles that cover a photo evenly, as large as fits into `fraction` of its longer side.

    The whole photo for a fraction of 1 or more. Else a tile has the input's `aspect` (width / height), cut to the
    photo, so that none of the input is wasted. Neighbours overlap by at least `overlap` of a tile, so that who stands
    on a seam is whole in one of them.
    """
    if fraction >= 1:
        yield 0, 0, width, height
        return
    tile_width, tile_height = _tile_size(width, height, fraction, aspect)
    for y0 in _starts(height, tile_height, overlap):
        for x0 in _starts(width, tile_width, overlap):
            yield x0, y0, x0 + tile_width, y0 + tile_height


def _starts(side: int, tile: int, overlap: float) -> list[int]:
    if tile >= side:
        return [0]
    count = math.ceil((side - tile) / (tile * (1 - overlap)) - 1e-9) + 1
    return [round(i * (side - tile) / (count - 1)) for i in range(count)]


def tiles_around(boxes_px: ArrayLike, width: int, height: int, fraction: float, aspect: float = 1.0) -> list[Region]:
    """Return few tiles of `tiles`' size that hold each of the boxes whole, those first in the list first.

    Boxes too large for a tile are passed over: the whole photo shows those better. No more tiles than cover the
    photo: where that many were needed, it is those.
    """
    tile_width, tile_height = _tile_size(width, height, fraction, aspect)
    boxes = np.asarray(boxes_px, dtype=float).reshape(-1, 4).clip(0, (width, height, width, height))
    sides, room = boxes[:, 2:] - boxes[:, :2], np.array([tile_width, tile_height]) - 1
    fits = (sides <= _FILLS_A_TILE * room).all(axis=1)
    # a margin, or the tile's edge would cut a person who is a little larger than suspected; a large one gets less
    margin = np.minimum(_SUSPECT_MARGIN * sides, (room - sides) / 2)
    grown = boxes + np.concatenate([-margin, margin], axis=1)
    left = grown[fits].clip(0, (width, height, width, height))
    found: list[Region] = []
    everywhere = list(tiles(width, height, fraction, aspect))
    while len(left):
        if len(found) == len(everywhere):
            return everywhere
        places = [
            (x, y)
            for x in _places(left[0, 0], left[0, 2], tile_width, width)
            for y in _places(left[0, 1], left[0, 3], tile_height, height)
        ]
        held = [
            (left[:, :2] >= p).all(axis=1) & (left[:, 2:] <= np.add(p, (tile_width, tile_height))).all(axis=1)
            for p in places
        ]
        best = int(np.argmax([rows.sum() for rows in held]))
        x, y = places[best]
        found.append((x, y, x + tile_width, y + tile_height))
        left = left[~held[best]]
    return found


def _places(low: float, high: float, tile: int, side: int) -> list[int]:
    """Return where a tile may begin that holds low..high: with it in the middle, at its end, or at its beginning."""
    starts = (math.floor((low + high - tile) / 2), math.ceil(high) - tile, math.floor(low))
    return [min(max(start, 0), side - tile) for start in starts]


def _tile_size(width: int, height: int, fraction: float, aspect: float) -> tuple[int, int]:
    side = fraction * max(width, height)
    return min(width, math.ceil(side * min(1.0, aspect))), min(height, math.ceil(side / max(1.0, aspect)))


def person_region(
    box_px: ArrayLike, size: tuple[int, int], padding: float = 1.25
) -> tuple[float, float, float, float]:  # fmt: skip
    """Return the region that a top-down network of input `size` gets to see of a box, grown by `padding`.

    It has the input's shape. Its middle is the box's as the networks' training reads it, counting from the middle of a
    pixel in the photo and in the input: half of both pixels' difference from ours, so that answers are comparable to
    other libraries' to a fraction of a pixel.
    """
    x0, y0, x1, y1 = np.asarray(box_px, dtype=float).tolist()
    aspect = size[0] / size[1]
    width = max(x1 - x0, (y1 - y0) * aspect) * padding
    height = width / aspect
    aside = (1 - width / size[0]) / 2
    centre_x, centre_y = (x0 + x1) / 2 + aside, (y0 + y1) / 2 + aside
    return centre_x - width / 2, centre_y - height / 2, centre_x + width / 2, centre_y + height / 2


def crop_placement(region: tuple[float, float, float, float], size: tuple[int, int]) -> Placement:
    """Return where a region of the photo lies in the input of `size` that it fills."""
    x0, y0, x1, y1 = region
    return Placement((x0, y0), (size[0] / (x1 - x0), size[1] / (y1 - y0)))


def crop(
    pixels: RGBArray, region: tuple[float, float, float, float], size: tuple[int, int], *, fill: int = 0
) -> tuple[RGBArray, Placement]:
    """Draw a region, which may reach beyond the photo and lie between pixels, onto an input of `size` exactly.

    What lies outside the photo is `fill` (black is what top-down networks were trained with).
    """
    import cv2

    placement = crop_placement(region, size)
    source, at = _shrunk(pixels, region, placement.scale)
    # cv2 counts from the middle of a pixel: source + 0.5 = (input + 0.5) / scale + start, an axis.
    step = at.scale[0] / placement.scale[0], at.scale[1] / placement.scale[1]
    start = at.to_input(region[:2])
    matrix = np.array(
        [
            [step[0], 0, start[0] + 0.5 * step[0] - 0.5],
            [0, step[1], start[1] + 0.5 * step[1] - 0.5],
        ]
    )
    flags = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
    drawn = cv2.warpAffine(source, matrix, size, flags=flags, borderMode=cv2.BORDER_CONSTANT, borderValue=(fill,) * 3)
    return np.asarray(drawn, np.uint8), placement


def _shrunk(
    pixels: RGBArray, region: tuple[float, float, float, float], scale: tuple[float, float]
) -> tuple[RGBArray, Placement]:
    """Return the photo's part in the region, area-averaged where it would be drawn at less than half its size."""
    import cv2

    height, width = pixels.shape[:2]
    x0, y0 = max(0, math.floor(region[0]) - 1), max(0, math.floor(region[1]) - 1)
    x1, y1 = min(width, math.ceil(region[2]) + 1), min(height, math.ceil(region[3]) + 1)
    part = pixels[min(y0, height - 1) : max(y1, y0 + 1), min(x0, width - 1) : max(x1, x0 + 1)]
    origin = (float(min(x0, width - 1)), float(min(y0, height - 1)))
    if min(scale) >= 0.5:
        return part, Placement(origin, (1.0, 1.0))
    # one and a half times the final size: enough for the linear step after it, little enough to leave no aliasing
    shrink = 1.5 * min(scale)
    new = max(1, round(part.shape[1] * shrink)), max(1, round(part.shape[0] * shrink))
    small = np.asarray(cv2.resize(part, new, interpolation=cv2.INTER_AREA), np.uint8)
    return small, Placement(origin, (new[0] / part.shape[1], new[1] / part.shape[0]))
