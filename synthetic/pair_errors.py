"""Estimates against the truth of synthetic photos: one record a pair and one a person, and their summaries."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from proxemetry.camera import Camera, Mount
from proxemetry.distances import measure_distances
from proxemetry.locate import LocateSettings, method_named
from proxemetry.people import People
from proxemetry.people.skeleton import COCO_17
from synthetic.scenes import SyntheticPhoto

FEET = [COCO_17.joints.index(joint) for joint in ("left_ankle", "right_ankle")]


@dataclass
class Records:
    """All pairs and people of a set under one method.

    Pairs: true_m, estimate_m, low_m, high_m, and `group`, whether both show feet, the photo's number. People:
    true_depth_m, depth_m, depth_sd_m (along the optical axis), person_group. seconds: processor time of the method.
    """

    method: str
    true_m: list[float] = field(default_factory=list)
    estimate_m: list[float] = field(default_factory=list)
    low_m: list[float] = field(default_factory=list)
    high_m: list[float] = field(default_factory=list)
    group: list[str] = field(default_factory=list)
    true_depth_m: list[float] = field(default_factory=list)
    depth_m: list[float] = field(default_factory=list)
    depth_sd_m: list[float] = field(default_factory=list)
    person_group: list[str] = field(default_factory=list)
    seconds: float = 0.0
    people: int = 0


def group_of(photo: SyntheticPhoto, feet: bool) -> str:
    """Return the row of the table that a pair belongs to."""
    return f"{photo.kind}, {'feet seen' if feet else 'feet hidden'}"


def record(
    photos: Iterable[SyntheticPhoto], methods: tuple[str, ...], settings: LocateSettings | None = None,
    camera_of: Callable[[SyntheticPhoto], Camera] = lambda photo: photo.camera,
    people_of: Callable[[SyntheticPhoto], People] = lambda photo: photo.people,
    group: Callable[[SyntheticPhoto, bool], str] = group_of,
    mount_of: Callable[[SyntheticPhoto], Mount | None] = lambda photo: None,
) -> dict[str, Records]:  # fmt: skip
    """Run methods over photos; camera_of, people_of and mount_of say what they are told of each."""
    answer = {method: Records(method) for method in methods}
    for photo in photos:
        people, camera, mount = people_of(photo), camera_of(photo), mount_of(photo)
        feet = (people.scores[:, FEET] > 0).any(axis=1) if people.skeleton is COCO_17 else np.zeros(len(people), bool)
        for method, records in answer.items():
            begin = time.process_time()
            bodies = method_named(method)(people, camera, settings or LocateSettings(), mount)
            records.seconds += time.process_time() - begin
            records.people += len(people)
            distances = measure_distances(bodies)
            for i, owner in enumerate(photo.owners):
                records.true_depth_m.append(photo.positions_m[owner, 2])
                records.depth_m.append(bodies.positions_m[i, 2])
                records.depth_sd_m.append(bodies.position_sd_m[i, 2])
                records.person_group.append(group(photo, bool(feet[i])))
                for j in range(i):
                    other = photo.owners[j]
                    if owner != other:
                        records.true_m.append(photo.distances_m[owner, other])
                        records.estimate_m.append(distances.distance_m[i, j])
                        records.low_m.append(distances.low_m[i, j])
                        records.high_m.append(distances.high_m[i, j])
                        records.group.append(group(photo, bool(feet[i] and feet[j])))
    return answer


@dataclass(frozen=True)
class Summary:
    """Pairs of one group: how many, share without an answer, percent errors, coverage of the 90 % interval."""

    pairs: int
    missing_pct: float
    mean_error_pct: float
    median_error_pct: float
    bias_pct: float
    coverage_pct: float
    width_pct: float


def _among(groups: list[str], group: str | None) -> NDArray[np.bool_]:
    """Return which rows belong to a group, or to all whose names end like that ("feet hidden"), or to any."""
    return np.array([group is None or g == group or g.endswith(f", {group}") for g in groups], dtype=bool)


def summary(records: Records, group: str | None = None) -> Summary:
    """Return the summary of one group, or of all pairs."""
    keep = _among(records.group, group)
    true, estimate = np.array(records.true_m)[keep], np.array(records.estimate_m)[keep]
    low, high = np.array(records.low_m)[keep], np.array(records.high_m)[keep]
    error = 100 * (estimate / true - 1)
    known = np.isfinite(error)
    if not known.any():
        return Summary(int(keep.sum()), 100.0, *[float("nan")] * 5)
    inside = (low <= true) & (true <= high)
    return Summary(
        int(keep.sum()), float(100 * (1 - known.mean())), float(np.abs(error[known]).mean()),
        float(np.median(np.abs(error[known]))), float(error[known].mean()), float(100 * inside[known].mean()),
        float(np.median(100 * (high - low)[known] / estimate[known])),
    )  # fmt: skip


def constant_error_pct(records: Records, constant_m: float, group: str | None = None) -> float:
    """Return the mean error of answering the same distance for every pair."""
    keep = _among(records.group, group)
    return float(100 * np.abs(constant_m / np.array(records.true_m)[keep] - 1).mean())


def depth_summary(records: Records, group: str | None = None) -> tuple[float, float, float]:
    """Return mean absolute and signed relative depth error in percent, and the rms of error over stated deviation."""
    keep = _among(records.person_group, group)
    true, depth, sd = (np.array(x)[keep] for x in (records.true_depth_m, records.depth_m, records.depth_sd_m))
    relative = 100 * (depth / true - 1)
    z = np.clip((depth - true) / sd, -6, 6)
    return float(np.nanmean(np.abs(relative))), float(np.nanmean(relative)), float(np.sqrt(np.nanmean(z**2)))
