"""Who is who from frame to frame: forecasts on the floor, in metres, matched to what is seen.

Tracking by detection with a Kalman filter (Bewley et al. 2016, SORT), two score stages (Zhang et al. 2022, ByteTrack)
and the scene fit's own covariance in place of a tuned noise. Appearance is not used: a person who leaves and comes back
later than `MEMORY_S` is a new track.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from ..arrays import FloatArray
from ..assignment import assign
from ..overlap import pairwise_iou
from .motion import PLACE, first_state, transition
from .sightings import Chain, Sightings

#: A person out of sight for longer is forgotten.
MEMORY_S = 2.0
#: A person last seen at the left or right edge of the picture, within this share of its width, has probably left it:
#: the next to come in there is another person.
_EDGE_SHARE, _EDGE_MEMORY_S = 0.012, 0.6
#: A sighting and a forecast may be this far apart: squared Mahalanobis distance, 99.9 % of a chi-squared with two
#: degrees of freedom.
GATE = 13.8
#: How many people that are not followed, false ones included, a frame shows per square metre: a forecast must explain a
#: sighting better than that (Blackman and Popoli 1999). A vague one, of a person hardly seen before, does not. Among
#: others a sighting may be any of theirs: of so large a share of those who are seen within so many metres. Chosen on
#: ETH's and UCY's paths (`benchmarks/accuracy/clip_tracking.py`), where half and double are nearly as good.
_UNKNOWN_M2, _UNKNOWN_SHARE, _NEAR_M = 0.03, 0.5, 2.0
#: People with a higher score than this are matched first, and a track that never had such a score is not a person;
#: where a back end is hardly ever so sure, this share of its median score stands for it.
SURE_SCORE, _SURE_SHARE = 0.5, 0.75
#: A track is a person once seen so often; what appears more seldom and not at the edge of a clip is a false detection.
CONFIRMED_SIGHTINGS = 3
#: Two boxes that share this much of their union, at most this far apart on the floor, are one person found twice.
_TWICE_IOU, _TWICE_M = 0.6, 0.6
#: What boxes that do not overlap at all cost, in units of squared Mahalanobis distance, while the box seen last is
#: this fresh and is expected to have gone on as before.
_BOX_COST, _BOX_FRESH_S = 2.0, 0.6
#: Measurement noise beyond the fit's own: a body sways about its feet, and a torso bends. With 0.05 the 90 % intervals
#: of PETS 2009 S2.L1's pairs held 88 %, with 0.15 they held 95 %, under the data set's own calibration.
SWAY_SD_M = 0.1
_FORBIDDEN = 1e6


@dataclass
class _Open:
    """Tracks not yet forgotten, as arrays of as many rows."""

    state: FloatArray = field(default_factory=lambda: np.zeros((0, 4)))
    covariance: FloatArray = field(default_factory=lambda: np.zeros((0, 4, 4)))
    boxes: FloatArray = field(default_factory=lambda: np.zeros((0, 4)))
    speed_px_s: FloatArray = field(default_factory=lambda: np.zeros((0, 4)))
    seen_s: FloatArray = field(default_factory=lambda: np.zeros(0))
    links: list[list[tuple[int, int]]] = field(default_factory=list[list[tuple[int, int]]])

    def kept(self, mask: NDArray[np.bool_]) -> _Open:
        links = [link for link, stays in zip(self.links, mask, strict=True) if stays]
        return _Open(
            self.state[mask], self.covariance[mask], self.boxes[mask], self.speed_px_s[mask], self.seen_s[mask], links
        )

    def with_new(self, frame: int, seen: Sightings, who: NDArray[np.intp], noise: FloatArray) -> _Open:
        state, covariance = first_state(seen.positions_m[who], noise[who])
        return _Open(
            np.concatenate([self.state, state]),
            np.concatenate([self.covariance, covariance]),
            np.concatenate([self.boxes, seen.boxes_px[who]]),
            np.concatenate([self.speed_px_s, np.zeros((len(who), 4))]),
            np.concatenate([self.seen_s, np.full(len(who), seen.t_s)]),
            [*self.links, *([(frame, int(p))] for p in who)],
        )


def track(
    shot: Sequence[Sightings], noise_scale: float = 1.0, memory_s: float = MEMORY_S, width_px: float = np.inf
) -> list[Chain]:
    """Return each person's chain of sightings through the frames of one shot, in the order of first sight.

    noise_scale: what the stated covariances are multiplied by. width_px: of the picture, where there is one.
    """
    tracks, done, now = _Open(), list[list[tuple[int, int]]](), 0.0
    sure = sure_score(shot)
    for number, seen in enumerate(shot):
        noise = noise_scale * seen.covariance_m2 + SWAY_SD_M**2 * np.eye(2)
        if len(tracks.links):
            forward, spread = transition(seen.t_s - now)
            tracks.state = tracks.state @ forward.T
            tracks.covariance = forward @ tracks.covariance @ forward.T + spread
            left = at_picture_edge(tracks.boxes, width_px)
            away_s = seen.t_s - tracks.seen_s
            fresh = away_s <= np.where(left, np.minimum(_EDGE_MEMORY_S, memory_s), memory_s)
            done += [link for link, stays in zip(tracks.links, fresh, strict=True) if not stays]
            tracks = tracks.kept(fresh)
        now = seen.t_s
        free = _matched(tracks, seen, number, noise, sure)
        if len(free):
            tracks = tracks.with_new(number, seen, free, noise)
    return _confirmed(done + tracks.links, shot, sure)


def at_picture_edge(boxes_px: FloatArray, width_px: float) -> NDArray[np.bool_]:
    """Return which boxes (..., 4) touch the left or right edge of a picture of this width."""
    touches = (boxes_px[..., 0] <= _EDGE_SHARE * width_px) | (boxes_px[..., 2] >= (1 - _EDGE_SHARE) * width_px)
    return np.asarray(touches & np.isfinite(width_px))


def sure_score(shot: Sequence[Sightings]) -> float:
    """Return the score from which this back end counts as sure of a person."""
    scores = np.concatenate([np.zeros(0), *(seen.scores for seen in shot)])
    return min(SURE_SCORE, _SURE_SHARE * float(np.median(scores))) if len(scores) else SURE_SCORE


def _matched(tracks: _Open, seen: Sightings, number: int, noise: FloatArray, sure: float) -> NDArray[np.intp]:
    """Match sightings to tracks and update these; return the sightings that begin tracks of their own."""
    free = np.arange(len(seen))
    open_tracks = np.arange(len(tracks.links))
    taken: list[int] = []
    for stage in (seen.scores >= sure, seen.scores < sure):
        who = free[stage[free]]
        pairs = _assigned(tracks, open_tracks, seen, who, noise)
        for row, person in pairs:
            tracks.links[row].append((number, person))
        rows = np.array([r for r, _ in pairs], dtype=np.intp)
        people = np.array([p for _, p in pairs], dtype=np.intp)
        if len(rows):
            _update(tracks, rows, seen.positions_m[people], noise[people])
            _see_boxes(tracks, rows, seen.boxes_px[people], seen.t_s)
        taken += people.tolist()
        open_tracks = np.setdiff1d(open_tracks, rows)
        free = np.setdiff1d(free, people)
    return _not_seen_twice(seen, free, np.array(taken, dtype=np.intp))


def _assigned(
    tracks: _Open, rows: NDArray[np.intp], seen: Sightings, who: NDArray[np.intp], noise: FloatArray
) -> list[tuple[int, int]]:
    """Return (track, sighting) pairs of least total cost, none beyond the gate."""
    if not len(rows) or not len(who):
        return []
    apart = seen.positions_m[who][None] - tracks.state[rows][:, None, PLACE]
    spread = tracks.covariance[rows][:, None, PLACE, PLACE] + noise[who][None]
    (a, b), (c, d) = (spread[..., 0, 0], spread[..., 0, 1]), (spread[..., 1, 0], spread[..., 1, 1])
    determinant = a * d - b * c
    x, y = apart[..., 0], apart[..., 1]
    distance2 = (d * x * x - (b + c) * x * y + a * y * y) / determinant
    away_s = seen.t_s - tracks.seen_s[rows]
    overlap = pairwise_iou(tracks.boxes[rows] + tracks.speed_px_s[rows] * away_s[:, None], seen.boxes_px[who])
    fresh = (away_s <= _BOX_FRESH_S)[:, None] & np.isfinite(overlap)
    # a vague forecast fits everywhere: its density is the lower
    cost = distance2 + np.log(determinant) + np.where(fresh, _BOX_COST * (1 - overlap), 0.0)
    unknown = -2 * np.log(2 * np.pi * _unknown_m2(seen)[who])
    allowed = (distance2 <= GATE) & (distance2 + np.log(determinant) <= unknown)
    pairs = assign(np.where(allowed, cost, _FORBIDDEN))
    return [(int(rows[r]), int(who[c])) for r, c in pairs if allowed[r, c]]


def _unknown_m2(seen: Sightings) -> FloatArray:
    """Return how many people a forecast is not about, per square metre at each sighting, shape (P,)."""
    apart = np.linalg.norm(seen.positions_m[:, None] - seen.positions_m[None], axis=-1)
    others = (apart <= _NEAR_M).sum(axis=1) - 1
    return _UNKNOWN_M2 + _UNKNOWN_SHARE * others / (np.pi * _NEAR_M**2)


def _see_boxes(tracks: _Open, rows: NDArray[np.intp], boxes_px: FloatArray, now: float) -> None:
    """Take in the boxes in which tracks are seen now: how fast each moves is the mean of its last steps."""
    step = (boxes_px - tracks.boxes[rows]) / (now - tracks.seen_s[rows])[:, None]
    before = tracks.speed_px_s[rows]
    speed = np.where(before.any(axis=1, keepdims=True), (before + step) / 2, step)
    tracks.speed_px_s[rows] = np.nan_to_num(speed)
    tracks.boxes[rows], tracks.seen_s[rows] = boxes_px, now


def _update(tracks: _Open, rows: NDArray[np.intp], places: FloatArray, noise: FloatArray) -> None:
    covariance = tracks.covariance[rows]
    gain = covariance[:, :, PLACE] @ np.linalg.inv(covariance[:, PLACE, PLACE] + noise)
    surprise = places - tracks.state[rows][:, PLACE]
    tracks.state[rows] += (gain @ surprise[..., None])[..., 0]
    updated = covariance - gain @ covariance[:, PLACE, :]
    tracks.covariance[rows] = (updated + updated.transpose(0, 2, 1)) / 2


def _not_seen_twice(seen: Sightings, free: NDArray[np.intp], taken: NDArray[np.intp]) -> NDArray[np.intp]:
    """Return the free sightings but those of a person who has been matched already."""
    if not len(free) or not len(taken):
        return free
    overlap = pairwise_iou(seen.boxes_px[free], seen.boxes_px[taken])
    apart = np.linalg.norm(seen.positions_m[free][:, None] - seen.positions_m[taken][None], axis=-1)
    twice = (np.nan_to_num(overlap) > _TWICE_IOU) & (apart < _TWICE_M)
    return free[~twice.any(axis=1)]


def _confirmed(links: list[list[tuple[int, int]]], shot: Sequence[Sightings], sure: float) -> list[Chain]:
    """Return the chains worth calling a person: seen often enough and surely, or cut off by the clip's own ends."""
    chains: list[Chain] = []
    for link in sorted(links, key=lambda k: k[0]):
        at_edge = link[0][0] >= len(shot) - CONFIRMED_SIGHTINGS + 1 or link[-1][0] < CONFIRMED_SIGHTINGS - 1
        surely = len(link) >= CONFIRMED_SIGHTINGS and max(shot[f].scores[p] for f, p in link) >= sure
        if surely or at_edge:
            found = np.array(link, dtype=np.intp)
            chains.append(Chain(found[:, 0], found[:, 1]))
    return chains
