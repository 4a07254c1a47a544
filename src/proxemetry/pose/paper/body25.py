"""OpenPose's BODY_25 decoded: peaks of heatmaps, connected to people along part affinity fields.

Cao et al. 2019 (OpenPose). Coordinates here are whole-numbered positions of the network's input (0 is the middle of
the first pixel); `openpose_body25` takes them back to the photo.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from ...arrays import FloatArray
from ...people.skeleton import BODY_25

Maps = NDArray[np.float32]

JOINTS = len(BODY_25)
#: Channels of the network's answer: the joints, the background, then x and y of each limb's affinity field.
CHANNELS = JOINTS + 1 + 52

#: Each limb: its two joints, and the channel (behind the background's) of the field's x; y follows it.
LIMBS = (
    (1, 8, 0), (1, 2, 14), (1, 5, 22), (2, 3, 16), (3, 4, 18), (5, 6, 24), (6, 7, 26), (8, 9, 6), (9, 10, 2),
    (10, 11, 4), (8, 12, 8), (12, 13, 10), (13, 14, 12), (1, 0, 30), (0, 15, 32), (15, 17, 36), (0, 16, 34),
    (16, 18, 38), (2, 17, 20), (5, 18, 28), (14, 19, 40), (19, 20, 42), (14, 21, 44), (11, 22, 46), (22, 23, 48),
    (11, 24, 50),
)  # fmt: skip

_FEET = range(19, 25)

# OpenPose's defaults for BODY_25.
PEAK_THRESHOLD = 0.05
_FIELD_THRESHOLD = 0.05
_LEAST_ALONG_LIMB = 0.95
_FEWEST_JOINTS = 3
_LEAST_MEAN_SCORE = 0.4
_MOST_PEAKS = 127
_MOST_SAMPLES = 25


@dataclass
class _Person:
    """A person being put together: joint -> row of its peak, and the sum of peak and field scores."""

    peaks: dict[int, int] = field(default_factory=lambda: {})
    score: float = 0.0

    def is_kept(self) -> bool:
        # feet do not count: the same foot often appears as both the left and the right one
        counted = sum(joint not in _FEET for joint in self.peaks)
        return counted >= _FEWEST_JOINTS and self.score / counted >= _LEAST_MEAN_SCORE


def decode(maps: Maps) -> tuple[FloatArray, FloatArray]:
    """Return all people's joints, shape (P, 25, 2), and scores, shape (P, 25), NaN and 0 where unseen.

    maps: the network's answer at the size of its input, shape (78, H, W).
    """
    peaks = [peaks_of(maps[joint]) for joint in range(JOINTS)]
    people = [person for person in assembled(peaks, maps[JOINTS + 1 :]) if person.is_kept()]
    points, scores = np.full((len(people), JOINTS, 2), np.nan), np.zeros((len(people), JOINTS))
    for row, person in enumerate(people):
        for joint, peak in person.peaks.items():
            points[row, joint], scores[row, joint] = peaks[joint][peak, :2], peaks[joint][peak, 2]
    return points, scores.clip(0, 1)


def peaks_of(heatmap: Maps, threshold: float = PEAK_THRESHOLD) -> FloatArray:
    """Return a heatmap's peaks as x, y and height, shape (N, 3), in reading order.

    A peak is higher than its eight neighbours (as high, one pixel from the edge, where resizing makes plateaus); its
    place is the centre of gravity of the positive values up to three pixels away.
    """
    import cv2

    height, width = heatmap.shape
    if min(height, width) < 3:
        return np.zeros((0, 3))
    ring = np.ones((3, 3), np.uint8)
    ring[1, 1] = 0
    neighbours = cv2.dilate(heatmap, ring, borderType=cv2.BORDER_CONSTANT, borderValue=threshold)
    is_peak = (heatmap > threshold) & (heatmap > neighbours)
    edge = np.zeros_like(is_peak)
    edge[1:-1, 1:-1] = True
    edge[2:-2, 2:-2] = False
    is_peak |= edge & (heatmap > threshold) & (heatmap >= neighbours)
    is_peak[[0, -1]] = False
    is_peak[:, [0, -1]] = False
    found = np.argwhere(is_peak)[:_MOST_PEAKS]
    return np.array([_refined(heatmap, x, y) for y, x in found]).reshape(-1, 3)


def _refined(heatmap: Maps, x: int, y: int, reach: int = 3) -> tuple[float, float, float]:
    y0, x0 = max(0, y - reach), max(0, x - reach)
    around = heatmap[y0 : y + reach + 1, x0 : x + reach + 1].clip(0, None).astype(float)
    rows, columns = np.indices(around.shape)
    total = around.sum()
    return x0 + (around * columns).sum() / total, y0 + (around * rows).sum() / total, float(heatmap[y, x])


def assembled(peaks: list[FloatArray], fields: Maps) -> list[_Person]:
    """Return people put together greedily, the surest connection of all limbs first.

    peaks: of each joint, as `peaks_of` has them. fields: shape (52, H, W).
    A connection starts a person, gives one a joint they lack, or merges two who share no joint.
    """
    connections: list[tuple[float, float, int, int, int]] = []
    for limb, (a, b, channel) in enumerate(LIMBS):
        scores = _limb_scores(peaks[a], peaks[b], fields[channel], fields[channel + 1])
        for i, j in np.argwhere(scores > 0):
            # a tenth of the joints' own heights keeps strong fields from tying in joints that are hardly there
            total = scores[i, j] + 0.1 * (peaks[a][i, 2] + peaks[b][j, 2])
            connections.append((float(total), float(scores[i, j]), limb, int(i), int(j)))
    connections.sort(reverse=True)
    people: list[_Person] = []
    owner: dict[tuple[int, int], _Person] = {}
    for _, score, limb, i, j in connections:
        a, b, _ = LIMBS[limb]
        _connect(people, owner, (a, i, float(peaks[a][i, 2])), (b, j, float(peaks[b][j, 2])), score)
    return people


def _connect(
    people: list[_Person],
    owner: dict[tuple[int, int], _Person],
    a: tuple[int, int, float],
    b: tuple[int, int, float],
    score: float,
) -> None:
    """Use one connection; a and b are joint, row of the peak and its height."""
    of_a, of_b = owner.get(a[:2]), owner.get(b[:2])
    if of_a is None and of_b is None:
        person = _Person({a[0]: a[1], b[0]: b[1]}, a[2] + b[2] + score)
        people.append(person)
        owner[a[:2]] = owner[b[:2]] = person
    elif of_a is None or of_b is None:
        person, new = (of_b, a) if of_a is None else (of_a, b)
        assert person is not None
        if new[0] not in person.peaks:  # else a surer connection was there before
            person.peaks[new[0]] = new[1]
            person.score += new[2] + score
            owner[new[:2]] = person
    elif of_a is of_b:
        of_a.score += score
    elif not set(of_a.peaks) & set(of_b.peaks):
        of_a.peaks.update(of_b.peaks)
        of_a.score += of_b.score + score
        owner.update(dict.fromkeys(of_b.peaks.items(), of_a))
        people[:] = [person for person in people if person is not of_b]


def _limb_scores(a: FloatArray, b: FloatArray, field_x: Maps, field_y: Maps) -> FloatArray:
    """Return how well the field connects each peak of one joint with each of the other, shape (A, B); 0 is not at all.

    The mean of the field along the line between them where it exceeds the threshold, if nearly all of the line does.
    Joints that nearly coincide, where a field gives no direction, get the least score.
    """
    if not (len(a) and len(b)):
        return np.zeros((len(a), len(b)))
    gaps = b[None, :, :2] - a[:, None, :2]
    lengths = np.linalg.norm(gaps, axis=-1)
    height, width = field_x.shape
    number = np.rint(np.sqrt(5 * np.abs(gaps).max(axis=-1))).clip(5, _MOST_SAMPLES)
    sample = np.arange(_MOST_SAMPLES)
    used = sample < number[..., None]
    steps = sample / number[..., None]
    points = a[:, None, None, :2] + steps[..., None] * gaps[:, :, None]
    x, y = np.moveaxis(np.rint(points).astype(int).clip(0, (width - 1, height - 1)), -1, 0)
    directions = gaps / np.maximum(lengths, 1e-6)[..., None]
    along = field_x[y, x] * directions[..., None, 0] + field_y[y, x] * directions[..., None, 1]
    strong = (along > _FIELD_THRESHOLD) & used
    count = strong.sum(axis=-1)
    mean = np.where(strong, along, 0.0).sum(axis=-1) / np.maximum(count, 1)
    coincide = lengths < np.sqrt(width * height) / 150
    scores = np.where(count > _LEAST_ALONG_LIMB * number, mean, np.where(coincide, PEAK_THRESHOLD, 0.0))
    return np.where(lengths < 1e-6, 0.0, scores)
