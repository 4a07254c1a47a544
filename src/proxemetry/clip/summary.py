"""A clip in numbers: what adds up over its pairs, and `summary.json`."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from typing import Any

import numpy as np

from ..archive.store.folder import Folder
from ..arrays import FloatArray
from .analysis import Analysis, places_by_frame
from .columns import limit_name
from .critical import critical_density, rate
from .density import Maps, classic_density
from .events import Event
from .exposure import PairOverTime, Totals

SUMMARY = "summary.json"


@dataclass
class Sums:
    """What adds up while pairs pass by, for the tables and the page that come after them."""

    within: FloatArray
    within_apart: FloatArray
    totals: Totals | None = None
    of_person: dict[int, FloatArray] = field(default_factory=dict[int, FloatArray])
    of_person_apart: dict[int, FloatArray] = field(default_factory=dict[int, FloatArray])
    events: list[tuple[Event, float]] = field(default_factory=list[tuple[Event, float]])
    shown: list[PairOverTime] = field(default_factory=list[PairOverTime])
    maps: Maps | None = None
    n_pairs: int = 0


def summary(found: Analysis, sums: Sums, clip: str) -> dict[str, Any]:
    """Return the clip in numbers, as `summary.json` holds it; missing numbers are None."""
    times = np.array([f.t_s for f in found.frames])
    ok = np.array([f.status == "ok" for f in found.frames], dtype=bool)
    people = np.array([f.n_people for f in found.frames], dtype=float)
    step = found.weight_s
    seen = len(found.people)
    at_once = int(people.max(initial=0))
    totals, rows = sums.totals, found.followed
    any_followed, unknown, per = bool(rows.any()), np.full(3, np.nan), people[rows] * step[rows]
    per_limit: dict[str, Any] = {}
    for k, limit in enumerate(found.wanted.within_m):
        events = [(e, p) for e, p in sums.events if e.within_m == limit]
        assert totals is not None
        all_of_them = np.array([totals.seconds[k], totals.low_s[k], totals.high_s[k]])
        apart = np.array([totals.apart_seconds[k], totals.apart_low_s[k], totals.apart_high_s[k]])
        per_limit[limit_name(limit)] = {
            "pair_seconds": _with_interval(*(all_of_them if any_followed else unknown)),
            "pair_seconds_apart": _with_interval(*(apart if any_followed else unknown)),
            "share_within_groups": _share(totals.seconds[k] - totals.apart_seconds[k], totals.seconds[k]),
            "events": len(events) if any_followed else None,
            "events_apart": sum(p <= 0.5 for _, p in events) if any_followed else None,
            "seconds_per_person_minute": asdict(rate(60 * sums.within[rows, k] * step[rows], per, times[rows])),
            "seconds_per_person_minute_apart": asdict(
                rate(60 * sums.within_apart[rows, k] * step[rows], per, times[rows])
            ),
        }
    return _as_json({
        "schema": "proxemetry.clip/1", "clip": clip, "seconds": float(step.sum()), "n_frames": len(found.frames),
        "n_frames_failed": int((~ok).sum()), "width_px": found.measured.width_px, "height_px": found.measured.height_px,
        "pairs_where": None if found.wanted.where is None else str(found.wanted.where),
        "n_tracks": seen, "people_at_least": at_once, "people_at_most": seen + _unfollowed(found),
        "seconds_not_followed": _seconds_not_followed(found),
        "n_groups": len({p.group for p in found.people if _size(found, p.group) > 1}) if any_followed else None,
        "people_bound": "a person who leaves and comes back has two tracks, so there were at most so many people, "
        "and at least as many as were there at one time",
        "density_persons_m2": _density(found), "region_area_m2": found.region.area_m2 if found.region else None,
        "within_m": per_limit, "critical_density": _critical(found, sums),
        "cameras": {str(k): c.note for k, c in found.cameras.items()},
        "shots": [s.to_dict() for s in found.measured.shots], "notes": _notes(found),
        "noise_scale": {str(k): v for k, v in found.noise_scale.items()},
    })  # fmt: skip


def _unfollowed(found: Analysis) -> int:
    """Return how many people were seen in frames in which nobody is followed: each may be another."""
    return sum(f.n_people for f, followed in zip(found.frames, found.followed, strict=True) if not followed)


def _seconds_not_followed(found: Analysis) -> float:
    return float(found.weight_s[~found.followed].sum())


def _notes(found: Analysis) -> list[str]:
    where = found.wanted.where
    only = [] if where is None else [f"only people with {where} count in pairs, and pairs of two such people"]
    lost, doubtful = _seconds_not_followed(found), sum(bool(p.doubt) for p in found.people)
    doubts = [] if not doubtful else [
        f"{doubtful} of {len(found.people)} tracks may not be people, or may be people found twice (column doubt)"
    ]  # fmt: skip
    unseen = [] if not lost else [
        f"nobody was followed for {lost:.1f} of {float(found.weight_s.sum()):.1f} s: who was near whom then is "
        "unknown, and not in these numbers"
    ]  # fmt: skip
    return [*found.measured.notes, *doubts, *only, *unseen]


def _size(found: Analysis, group: int) -> int:
    return sum(p.group == group for p in found.people)


def _share(part: float, whole: float) -> float | None:
    return part / whole if whole > 0 else None


def _with_interval(value: float, low: float, high: float) -> dict[str, float]:
    return {"seconds": float(value), "low_s": float(low), "high_s": float(high)}


def _main_frames(found: Analysis) -> tuple[FloatArray, FloatArray, list[int]]:
    """Return time and density of the main camera's frames with placed people, and their numbers."""
    main, places = found.main_camera, places_by_frame(found)
    rows = [k for k, f in enumerate(found.frames) if f.camera == main and f.status == "ok" and found.followed[k]]
    region = found.region
    density = [0.0 if region is None else classic_density(places[k], region) for k in rows]
    return np.array([found.frames[k].t_s for k in rows]), np.array(density), rows


def _density(found: Analysis) -> dict[str, Any] | None:
    if found.region is None:
        return None
    times, density, rows = _main_frames(found)
    most = float(density.max()) if rows else math.nan
    return {**asdict(rate(density * found.weight_s[rows], found.weight_s[rows], times)), "max": most}


def _critical(found: Analysis, sums: Sums) -> dict[str, Any]:
    if found.region is None:
        return {"reason": "no person was followed"}
    times, density, rows = _main_frames(found)
    answer: dict[str, Any] = {}
    for k, limit in enumerate(found.wanted.within_m):
        for name, within in (("", sums.within), ("_apart", sums.within_apart)):
            told = critical_density(density, np.round(within[rows, k]), times)
            answer[f"{limit_name(limit)}{name}"] = asdict(told)
    return answer


def _as_json(value: Any) -> Any:
    if isinstance(value, dict):
        return {str(k): _as_json(v) for k, v in value.items()}  # pyright: ignore[reportUnknownVariableType]
    if isinstance(value, list | tuple):
        return [_as_json(v) for v in value]  # pyright: ignore[reportUnknownVariableType]
    if isinstance(value, float | np.floating):
        return float(f"{value:.7g}") if math.isfinite(value) else None
    return int(value) if isinstance(value, np.integer) else value


def write_json(folder: Folder, name: str, fields: Mapping[str, Any]) -> None:
    """Write a JSON file of the folder."""
    folder.write(name, (json.dumps(fields, indent=1, allow_nan=False) + "\n").encode())
