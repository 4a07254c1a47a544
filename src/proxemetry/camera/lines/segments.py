"""Straight segments in a photo: OpenCV's detector on the reduced picture, people and the picture's edge left out."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import cast

import numpy as np
from numpy.typing import NDArray

from ...arrays import FloatArray, RGBArray
from ...errors import PhotoError
from ...photo import Photo

#: The picture is reduced to this long side: edges of things stay, texture goes. As large as York Urban's pictures, on
#: which the noise of segments was measured.
LONG_SIDE_PX = 640
#: Segments shorter than this part of the diagonal show little; of the others, the longest are used.
_SHORTEST, _MOST = 0.016, 300
#: Along the picture's edge, within this part of its sides, run the borders of scans and prints.
_MARGIN = 0.012
#: Along the picture's axes within this angle, at most this part of all lengths: 1 to 9 % in 43 photos without graphics,
#: 31 % in one with pedestrians' boxes drawn in; of York Urban's pictures of level buildings one has 26 %.
_EXACT_RAD, _MOST_EXACT = math.radians(0.2), 0.2
#: A person's box grows by this part of its sides: limbs and clothes reach beyond it.
_AROUND = 0.06
#: Pieces of one line: as parallel as this, and as near to one another across and along it, in reduced pixels.
_PARALLEL_RAD, _ACROSS_PX, _GAP_PX = math.radians(2.5), 1.2, 12.0


@dataclass(frozen=True, eq=False)
class Detected:
    """All segments that the detector finds in a reduced picture.

    segments: shape (N, 4), u0 v0 u1 v1 in its pixels. size: its width and height. to_pixels, to_photo: shape (4,), from
    its pixels to those of the picture that was given, and from these to the full-size photo's.
    """

    segments: FloatArray
    size: tuple[int, int]
    to_pixels: FloatArray
    to_photo: FloatArray

    def outside(self, boxes_px: FloatArray) -> FloatArray:
        """Return segments (N, 4) in full-size pixels, outside people's boxes (P, 4): as `segments_of` does."""
        return without_graphics(_outside_people(self, boxes_px / self.to_photo)) * self.to_photo

    def reduced(self, boxes_px: FloatArray) -> FloatArray:
        """Return boxes (P, 4) of the full-size photo in pixels of the reduced picture."""
        return boxes_px / (self.to_photo * self.to_pixels)


def detected_in(photo: Photo) -> Detected | None:
    """Return all segments of a photo, None where its pixels are not at hand or cannot be decoded."""
    if photo.path is None and not photo.has_pixels:
        return None
    try:
        pixels = photo.pixels(LONG_SIDE_PX)
    except PhotoError:
        return None
    return _detected(pixels, np.tile((photo.width / pixels.shape[1], photo.height / pixels.shape[0]), 2))


def segments_of(photo: Photo, boxes_px: FloatArray) -> FloatArray | None:
    """Return straight segments (N, 4), u0 v0 u1 v1 in full-size pixels, outside people's boxes (P, 4).

    None where the photo's pixels are not at hand or cannot be decoded.
    """
    found = detected_in(photo)
    return None if found is None else found.outside(boxes_px)


def without_graphics(segments: FloatArray) -> FloatArray:
    """Return segments (N, 4) without those along the picture's axes, where there are too many of them for a photo.

    Frames, captions and boxes drawn into a picture run so, to a fraction of a pixel, and would be taken for a building
    before a level camera.
    """
    across = np.abs(segments[:, 2:] - segments[:, :2])
    exact = across.min(axis=1) < math.tan(_EXACT_RAD) * across.max(axis=1)
    lengths = _lengths(segments)
    drawn = lengths[exact].sum() > _MOST_EXACT * lengths.sum()
    return segments[~exact] if drawn else segments


def straight_segments(pixels: RGBArray, boxes_px: FloatArray) -> FloatArray:
    """Return straight segments (N, 4), the longest first, in pixels (H, W, 3) outside people's boxes (P, 4)."""
    return _outside_people(_detected(pixels, np.ones(4)), boxes_px)


def _detected(pixels: RGBArray, to_photo: FloatArray) -> Detected:
    """Return what OpenCV's detector finds in pixels (H, W, 3), nothing in the tiniest."""
    import cv2

    height, width = pixels.shape[:2]
    scale = min(1.0, LONG_SIDE_PX / max(width, height))
    size = max(1, round(width * scale)), max(1, round(height * scale))
    grey, times = halved(np.asarray(cv2.cvtColor(pixels, cv2.COLOR_RGB2GRAY), np.uint8))
    to_pixels, nothing = np.tile(times * np.flip(grey.shape) / size, 2), np.zeros((0, 4))
    if min(size) < 8:
        return Detected(nothing, size, to_pixels, to_photo)
    if scale < 1:
        grey = cv2.resize(grey, size, interpolation=cv2.INTER_AREA)
    found = cv2.createLineSegmentDetector(cv2.LSD_REFINE_NONE).detect(grey)[0]
    if cast(object, found) is None:
        return Detected(nothing, size, to_pixels, to_photo)
    # a pixel is looked up at its middle, where OpenCV counts it from
    segments = np.asarray(found, dtype=float).reshape(-1, 4) + 0.5
    return Detected(segments, size, to_pixels, to_photo)


def halved(grey: NDArray[np.uint8]) -> tuple[NDArray[np.uint8], int]:
    """Return a picture halved as often as it stays twice as large as it is to be, and how much smaller it is now.

    A last odd row or column goes. Means of 2 x 2 pixels take a tenth of the time of those of fractions of pixels.
    """
    import cv2

    times = 1
    while max(grey.shape) >= 4 * LONG_SIDE_PX and min(grey.shape) > 1:
        height, width = grey.shape[0] // 2, grey.shape[1] // 2
        even = grey[: 2 * height, : 2 * width]
        grey, times = np.asarray(cv2.resize(even, (width, height), interpolation=cv2.INTER_AREA), np.uint8), 2 * times
    return grey, times


def _outside_people(found: Detected, boxes_px: FloatArray) -> FloatArray:
    """Return the longest lines (N, 4) outside boxes (P, 4), both in pixels of the picture that was given."""
    segments, size = found.segments, found.size
    segments = segments[_outside(segments, boxes_px / found.to_pixels) & ~_at_edge(segments, size)]
    diagonal = math.hypot(*size)
    merged = _merged(_longest(segments[_lengths(segments) > _SHORTEST * diagonal / 2], _MOST))
    return _longest(merged[_lengths(merged) > _SHORTEST * diagonal], _MOST) * found.to_pixels


def _lengths(segments: FloatArray) -> FloatArray:
    return np.hypot(segments[:, 2] - segments[:, 0], segments[:, 3] - segments[:, 1])


def _longest(segments: FloatArray, count: int) -> FloatArray:
    return segments[np.argsort(-_lengths(segments), kind="stable")[:count]]


def _outside(segments: FloatArray, boxes: FloatArray) -> NDArray[np.bool_]:
    """Return which segments have their middle outside every person's box, shape (N,)."""
    boxes = boxes[np.isfinite(boxes).all(axis=1)]
    around = _AROUND * (boxes[:, 2:] - boxes[:, :2])
    low, high = boxes[:, :2] - around, boxes[:, 2:] + around
    middle = (segments[:, None, :2] + segments[:, None, 2:]) / 2
    inside = np.all((middle > low) & (middle < high), axis=-1)
    return np.asarray(~np.any(inside, axis=1), dtype=bool)


def _at_edge(segments: FloatArray, size: tuple[int, int]) -> NDArray[np.bool_]:
    """Return which segments run along the picture's edge, shape (N,)."""
    ends = segments.reshape(-1, 2, 2)
    margin = _MARGIN * np.array(size)
    along = np.all(ends < margin, axis=1) | np.all(ends > np.array(size) - margin, axis=1)
    return np.asarray(np.any(along, axis=1), dtype=bool)


def _merged(segments: FloatArray) -> FloatArray:
    """Return segments with the pieces of one line made one; pieces of a bend stay apart."""
    count = len(segments)
    if count < 2:
        return segments
    ends = segments.reshape(-1, 2, 2)
    middles = ends.mean(axis=1)
    along = (ends[:, 1] - ends[:, 0]) / _lengths(segments)[:, None]
    across = np.stack([-along[:, 1], along[:, 0]], axis=1)
    # few pairs are parallel with the middle of one on the other's line; only these are looked at closely
    aside = across @ middles.T - (across * middles).sum(axis=1)[:, None]
    parallel = (np.abs(along @ across.T) < math.sin(_PARALLEL_RAD)) & (np.abs(aside) < _ACROSS_PX + 0.01)
    first, second = np.nonzero(np.triu(parallel, 1))
    away = ends[second] - middles[first][:, None]  # the second's ends, as the first sees them
    off = np.abs((away * across[first][:, None]).sum(axis=-1)).max(axis=1)
    place = (away * along[first][:, None]).sum(axis=-1)
    half = _lengths(segments)[first] / 2
    gap = np.maximum(place.min(axis=1) - half, -half - place.max(axis=1))
    near = (off < _ACROSS_PX) & (gap < _GAP_PX)
    group = _components(count, first[near], second[near])
    single = np.bincount(group, minlength=count)[group] == 1
    joined = [_joined(ends[group == k]) for k in np.unique(group[~single])]
    return np.concatenate([segments[single], *joined])


def _components(count: int, first: NDArray[np.intp], second: NDArray[np.intp]) -> NDArray[np.intp]:
    """Return for each of `count` nodes the lowest one that it is linked to, by whatever way; links join two (L,)."""
    label = np.arange(count)
    while True:
        lowest = label.copy()
        np.minimum.at(lowest, first, label[second])
        np.minimum.at(lowest, second, label[first])
        lowest = lowest[lowest]
        if (lowest == label).all():
            return label
        label = lowest


def _joined(pieces: FloatArray) -> FloatArray:
    """Return pieces (k, 2, 2) of one line as one segment (1, 4), or as they are (k, 4) where they bend."""
    points = pieces.reshape(-1, 2)
    middle = points.mean(axis=0)
    _, _, axes = np.linalg.svd(points - middle, full_matrices=False)
    place = (points - middle) @ axes.T
    if np.abs(place[:, 1]).max() > _ACROSS_PX:
        return pieces.reshape(-1, 4)
    reach = np.array([place[:, 0].min(), place[:, 0].max()])
    return (middle + reach[:, None] * axes[0]).reshape(1, 4)
