"""Who is who in frames that follow each other closely: boxes that keep overlapping, in the picture alone.

A person who is hidden for longer than `MEMORY_S` counts as a new one. Appearance is not used.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ..assignment import assign
from ..overlap import iou
from ..people import People

#: A person unseen for longer is forgotten.
MEMORY_S = 1.5
#: A box overlaps the one forecast for it by so much at least.
_LEAST_IOU = 0.25
#: How much of its last step a box is expected to move on by.
_PERSISTENCE = 0.7
_FORBIDDEN = 1e3


def linked(frames: Sequence[People], times_s: Sequence[float]) -> list[NDArray[np.intp]]:
    """Return for every frame who each of its people is, shape (P,): numbers from 0, the same for the same person."""
    boxes, speed, seen_s = np.zeros((0, 4)), np.zeros((0, 4)), np.zeros(0)
    answer: list[NDArray[np.intp]] = []
    for people, now in zip(frames, times_s, strict=True):
        waited = now - seen_s
        forecast = boxes + _PERSISTENCE * speed * waited[:, None]
        cost = np.full((len(people), len(boxes)), _FORBIDDEN)
        for track in np.flatnonzero(waited <= MEMORY_S):
            overlap = iou(forecast[track], people.boxes_px)
            cost[:, track] = np.where(overlap >= _LEAST_IOU, 1 - overlap, _FORBIDDEN)
        who = np.full(len(people), -1)
        for row, track in assign(cost):
            if cost[row, track] >= _FORBIDDEN:
                continue
            who[row] = track
            step = (people.boxes_px[row] - boxes[track]) / max(waited[track], 1e-3)
            speed[track] = np.where(speed[track].any(), (speed[track] + step) / 2, step)
            boxes[track], seen_s[track] = people.boxes_px[row], now
        new = np.flatnonzero(who < 0)
        who[new] = len(boxes) + np.arange(len(new))
        boxes, speed = np.concatenate([boxes, people.boxes_px[new]]), np.concatenate([speed, np.zeros((len(new), 4))])
        seen_s = np.concatenate([seen_s, np.full(len(new), now)])
        answer.append(who)
    return answer
