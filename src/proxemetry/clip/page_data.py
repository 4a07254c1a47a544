"""What the script of a clip's page draws: moments, paths, pairs and maps, thinned out to what a screen shows."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from ..arrays import FloatArray
from .analysis import Analysis, places_by_frame
from .density import classic_density
from .summary import Sums

#: The page shows so many moments and positions at most; the tables have all of them.
_MOST_MOMENTS, _MOST_POSITIONS = 3000, 60_000


def _rounded(value: float, digits: int = 3) -> float | None:
    return round(float(value), digits) if math.isfinite(value) else None


def _all_rounded(values: Sequence[float] | FloatArray, digits: int = 3) -> list[float | None]:
    return [_rounded(v, digits) for v in values]


def page_data(found: Analysis, sums: Sums, aggregate_only: bool) -> dict[str, Any]:
    """Return what the script draws, thinned out to what a screen shows."""
    every = max(1, math.ceil(len(found.frames) / _MOST_MOMENTS))
    rows = range(0, len(found.frames), every)
    times = np.array([f.t_s for f in found.frames])
    places, region, main = places_by_frame(found), found.region, found.main_camera
    measured = [f.status == "ok" for f in found.frames]
    density = [
        None
        if region is None or found.frames[k].camera != main or not measured[k] or not found.followed[k]
        else _rounded(classic_density(places[k], region), 4)
        for k in rows
    ]
    tracks = [] if aggregate_only else _tracks(found)
    pairs = [] if aggregate_only else [_pair(p) for p in sums.shown if p.seconds.sum() > 0]
    data: dict[str, Any] = {
        "t": _all_rounded(times[::every]), "step": float(np.median(np.diff(times))) * every if len(times) > 1 else 1.0,
        "n": [found.frames[k].n_people if measured[k] else None for k in rows], "density": density,
        "within": [_all_rounded(sums.within[::every, k]) for k in range(sums.within.shape[1])],
        "apart": [_all_rounded(sums.within_apart[::every, k]) for k in range(sums.within.shape[1])],
        "limits": list(found.wanted.within_m), "tracks": tracks, "pairs": pairs, "extent": _extent(found),
        "maps": None,
    }  # fmt: skip
    if sums.maps is not None and not aggregate_only:
        last = sums.maps.risk()[-1] if len(sums.maps.limits_m) else np.zeros((1, 1))
        data |= {
            "maps": {
                "density": [_all_rounded(r, 4) for r in sums.maps.density().mean(axis=0)],
                "risk": [_all_rounded(r, 3) for r in last],
            },
            "mapOrigin": _all_rounded(sums.maps.origin_m), "mapCell": sums.maps.cell_m,
        }  # fmt: skip
    return data


def _tracks(found: Analysis) -> list[dict[str, Any]]:
    main = found.main_camera
    shown = [p for p in found.people if found.measured.shots[p.shot].camera == main]
    every = max(1, math.ceil(sum(len(p.track) for p in shown) / _MOST_POSITIONS))
    answer: list[dict[str, Any]] = []
    for person in shown:
        track = person.track
        rows = slice(None, None, every)
        answer.append({
            "n": track.number, "g": person.group, "t": _all_rounded(track.t_s[rows]),
            "x": _all_rounded(track.positions_m[rows, 0], 2), "y": _all_rounded(track.positions_m[rows, 1], 2),
            "s": track.seen[rows].astype(int).tolist(), "h": _all_rounded(person.heading_rad[rows], 2),
        })  # fmt: skip
    return answer


def _pair(pair: Any) -> dict[str, Any]:
    near = pair.near
    return {
        "a": pair.a, "b": pair.b, "t": _all_rounded(pair.t_s), "d": _all_rounded(near.distance_m, 2),
        "low": _all_rounded(near.low_m, 2), "high": _all_rounded(near.high_m, 2),
    }  # fmt: skip


def _extent(found: Analysis) -> list[float]:
    if found.region is None:
        return [0.0, 0.0, 1.0, 1.0]
    low, high = found.region.corners_m.min(axis=0), found.region.corners_m.max(axis=0)
    return [round(float(v), 2) for v in (*low, *high)]
