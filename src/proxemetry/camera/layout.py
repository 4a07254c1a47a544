"""Pictures that are not one whole photo: several photos side by side with gaps, or one photo between bars."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..arrays import FloatArray, RGBArray
from .sources import Doubt, Flag

#: The picture is reduced to this long side; nothing is said of what is smaller than the other.
_LONG_SIDE_PX, _LEAST_PX = 320, 8
#: A line of pixels is of one colour where all but this part of it is within so many steps of its mean: JPEG's noise.
_OUTLIERS, _STEPS = 0.02, 12
#: A gap has an edge where, within so many pixels, at least this part of the line beside it has another colour: the sky
#: above a roof, or fog, ends in places or gradually.
_EDGE_PX, _EDGE_SHARE = 3, 0.7
#: Each of two photos takes at least this part of the picture, and a gap between them at most that.
_LEAST_PART, _WIDEST_GAP = 0.15, 0.1
#: Bars are named where they take more than this part of the picture: frames of scans and prints take less.
_LEAST_BARS = 0.2


@dataclass(frozen=True)
class Layout:
    """How a picture is filled. part: width and height of what lies between bars, as parts of the picture's.

    gaps: how many gaps of one colour divide it, from edge to edge.
    """

    part: tuple[float, float]
    gaps: int

    @property
    def flags(self) -> tuple[Flag, ...]:
        """The doubts of a picture that is filled so."""
        found: list[Flag] = []
        if self.gaps:
            text = "perhaps several photos in one picture (distances from one to another mean nothing)"
            found.append(Flag(Doubt.PROJECTION, text))
        if self.part[0] * self.part[1] < 1 - _LEAST_BARS:
            text = "perhaps a screenshot or a photo between bars (cut it out: the bars count as a part of the photo)"
            found.append(Flag(Doubt.CROPPED, text))
        return tuple(found)


def layout_of(pixels: RGBArray) -> Layout:
    """Return how a picture (H, W, 3) is filled."""
    small = _reduced(pixels)
    height, width = small.shape[:2]
    gaps = _gaps(small)
    inner = small if gaps else small[_photo_rows(small), _photo_rows(small.swapaxes(0, 1))]
    if inner.shape == small.shape or min(inner.shape[:2]) < _LEAST_PX:
        return Layout((1.0, 1.0), gaps)
    return Layout((inner.shape[1] / width, inner.shape[0] / height), _gaps(inner))


def _reduced(pixels: RGBArray) -> RGBArray:
    import cv2

    height, width = pixels.shape[:2]
    scale = min(1.0, _LONG_SIDE_PX / max(width, height))
    size = max(1, round(width * scale)), max(1, round(height * scale))
    return np.asarray(cv2.resize(pixels, size, interpolation=cv2.INTER_AREA), dtype=np.uint8)


def _of_one_colour(pixels: RGBArray) -> NDArray[np.bool_]:
    """Return which rows are of one colour, shape (H,)."""
    channels = np.ascontiguousarray(pixels.transpose(2, 0, 1), dtype=np.int16)  # three times as fast to sum up
    off = np.abs(channels - channels.mean(axis=2, keepdims=True, dtype=np.float32).astype(np.int16)) > _STEPS
    return np.asarray(off.any(axis=0).mean(axis=1) <= _OUTLIERS, dtype=bool)


def _photo_rows(pixels: RGBArray) -> slice:
    """Return the rows of the largest thing between two bars of the same colour; all rows where there are no such bars.

    A bar may hold lines of text, as a screenshot's do. One edge at least is sharp along most of the width: a bright
    sky, or a white wall behind people, is no bar.
    """
    plain = _of_one_colour(pixels)
    start, stop = max(_runs(~plain), key=lambda run: run[1] - run[0], default=(0, len(plain)))
    if start == 0 or stop == len(plain):
        return slice(0, len(plain))
    bars = [slice(*run) for run in _runs(plain) if start in run or stop in run]
    above, below = (_colour(pixels[bar]) for bar in bars)
    first, last = pixels[start : start + _EDGE_PX], pixels[max(0, stop - _EDGE_PX) : stop]
    sharp = _differs(first, above) or _differs(last, below)
    alike = bool((np.abs(above - below) <= _STEPS).all())
    return slice(start, stop) if sharp and alike else slice(0, len(plain))


def _gaps(pixels: RGBArray) -> int:
    """Count the gaps of one colour from edge to edge, both ways."""
    return sum(_gaps_across(turned) for turned in (pixels, pixels.swapaxes(0, 1)))


def _gaps_across(pixels: RGBArray) -> int:
    """Count bands of rows of one colour, with an edge on both sides and a photo beyond each."""
    plain = _of_one_colour(pixels)
    count = 0
    for start, stop in _runs(plain):
        beyond = min(start, len(plain) - stop) >= _LEAST_PART * len(plain)
        if beyond and stop - start <= _WIDEST_GAP * len(plain):
            sides = (pixels[max(0, start - _EDGE_PX) : start], pixels[stop : stop + _EDGE_PX])
            count += all(_differs(side, _colour(pixels[start:stop])) for side in sides)
    return count


def _runs(of: NDArray[np.bool_]) -> list[tuple[int, int]]:
    """Return begin and end of every run of True."""
    ends = np.flatnonzero(np.diff(np.concatenate([[False], of, [False]]).astype(int)))
    return [(int(start), int(stop)) for start, stop in ends.reshape(-1, 2)]


def _colour(band: RGBArray) -> FloatArray:
    return np.asarray(np.median(band, axis=(0, 1)), dtype=float)


def _differs(side: RGBArray, colour: FloatArray) -> bool:
    """Return whether a few rows (R, W, 3) have another colour along most of their width."""
    other = (np.abs(side - colour) > 2 * _STEPS).any(axis=2).any(axis=0)
    return bool(other.mean() >= _EDGE_SHARE)
