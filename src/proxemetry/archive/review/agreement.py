"""How well two people who reviewed the same photos agree: figures to publish beside the distances."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Collection, Iterable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from ...arrays import FloatArray
from ...assignment import assign
from ...overlap import pairwise_iou
from ...scene import Scene
from .actions import Action
from .corrections import FileKey, by_file, in_force
from .edits import SAME_PERSON_IOU, applied

#: Focal lengths this alike (relative) count as the same statement.
_SAME_FOCAL = 0.01

#: Bland and Altman 1986: the differences of most pairs lie within mean +- 1.96 standard deviations.
_LIMITS_SD = 1.96


@dataclass(frozen=True)
class Agreement:
    """What two reviewers did with the photos that both of them looked at (any action of each, "checked" included).

    n_photos: looked at by both. n_alike: left in the same state: people, camera, floor, body sizes, excluded or not.
    n_both_changed, n_one_only, n_other_only, n_none: who changed anything. kappa: Cohen's, on changed or not; NaN where
    either did the same with all photos. n_people: found in both versions; n_people_one, n_people_other: in one only.
    n_pairs: distances in both versions. mean_difference_m (one minus other), sd_difference_m, mean_absolute_m, and the
    95 % limits of agreement low_m, high_m (Bland and Altman 1986): NaN without pairs.
    """

    one: str
    other: str
    n_photos: int
    n_alike: int
    n_both_changed: int
    n_one_only: int
    n_other_only: int
    n_none: int
    kappa: float
    n_people: int
    n_people_one: int
    n_people_other: int
    n_pairs: int
    mean_difference_m: float
    sd_difference_m: float
    mean_absolute_m: float
    low_m: float
    high_m: float

    @property
    def share_alike(self) -> float:
        """The share of photos left in the same state; NaN where no photo was looked at by both."""
        return self.n_alike / self.n_photos if self.n_photos else math.nan


@dataclass(frozen=True)
class _Compared:
    changed: tuple[bool, bool]
    alike: bool
    people: tuple[int, int, int]
    distances_m: FloatArray  # shape (n, 2): one's and the other's


def agreement(
    one: str,
    actions_one: Iterable[Action],
    other: str,
    actions_other: Iterable[Action],
    scenes: Callable[[Collection[FileKey]], Iterator[Scene]],
) -> Agreement:
    """Return how two logs agree; one, other: what to call the reviewers.

    scenes: yields the measured scenes of these files, whatever the photos are called by now.
    """
    mine, yours = by_file(in_force(actions_one)), by_file(in_force(actions_other))
    shared = set(mine) & set(yours)
    compared: dict[FileKey, _Compared] = {}
    for scene in scenes(shared) if shared else ():
        key = FileKey.of(scene)
        if key in shared and key not in compared:  # copies of one file count once
            compared[key] = _compare(scene, mine[key], yours[key])
    return _summed(one, other, list(compared.values()))


def _compare(scene: Scene, mine: Sequence[Action], yours: Sequence[Action]) -> _Compared:
    a, b = applied(scene, mine), applied(scene, yours)
    pairs = matched_people(a, b)
    rows = [
        (a.distances_m[i, j], b.distances_m[k, m])
        for (i, k), (j, m) in ((p, q) for n, p in enumerate(pairs) for q in pairs[n + 1 :])
    ]
    distances = np.array(rows, dtype=float).reshape(-1, 2)
    return _Compared(
        (_changes(mine), _changes(yours)),
        _alike(a, b, pairs),
        (len(pairs), len(a) - len(pairs), len(b) - len(pairs)),
        distances[np.isfinite(distances).all(axis=1)],
    )


def _changes(actions: Sequence[Action]) -> bool:
    return any(a.action not in ("checked", "note") for a in actions)


def matched_people(a: Scene, b: Scene) -> list[tuple[int, int]]:
    """Return which people are the same in two versions of a scene, one to one, by the overlap of their boxes."""
    if not len(a) or not len(b):
        return []
    overlap = np.nan_to_num(pairwise_iou(a.people.boxes_px, b.people.boxes_px))
    return [(i, k) for i, k in assign(-overlap) if overlap[i, k] >= SAME_PERSON_IOU]


def _alike(a: Scene, b: Scene, pairs: list[tuple[int, int]]) -> bool:
    if a.status != b.status or not len(pairs) == len(a) == len(b):
        return False
    one, other = a.camera.camera, b.camera.camera
    if (one is None) != (other is None):
        return False
    if one is not None and other is not None and abs(math.log(one.f_px / other.f_px)) > _SAME_FOCAL:
        return False
    mine, yours = _stated(a), _stated(b)
    return all(mine[i] == yours[k] for i, k in pairs)


def _stated(scene: Scene) -> list[tuple[bool, str | None]]:
    """Return what was stated of each person: off the floor, body size."""
    locate = scene.settings.locate
    sizes = locate.body_sizes or (None,) * len(scene)
    return [(i in locate.off_floor, sizes[i]) for i in range(len(scene))]


def _summed(one: str, other: str, compared: list[_Compared]) -> Agreement:
    distances = np.concatenate([np.zeros((0, 2)), *(c.distances_m for c in compared)])
    difference = distances[:, 0] - distances[:, 1]
    mean = float(difference.mean()) if len(difference) else math.nan
    sd = float(difference.std(ddof=1)) if len(difference) > 1 else math.nan
    absolute = float(np.abs(difference).mean()) if len(difference) else math.nan
    outcomes = Counter(c.changed for c in compared)
    both, only_one, only_other, neither = (outcomes[k, m] for k in (True, False) for m in (True, False))
    return Agreement(
        one=one,
        other=other,
        n_photos=len(compared),
        n_alike=sum(c.alike for c in compared),
        n_both_changed=both,
        n_one_only=only_one,
        n_other_only=only_other,
        n_none=neither,
        kappa=cohens_kappa(both, only_one, only_other, neither),
        n_people=sum(c.people[0] for c in compared),
        n_people_one=sum(c.people[1] for c in compared),
        n_people_other=sum(c.people[2] for c in compared),
        n_pairs=len(difference),
        mean_difference_m=mean,
        sd_difference_m=sd,
        mean_absolute_m=absolute,
        low_m=mean - _LIMITS_SD * sd,
        high_m=mean + _LIMITS_SD * sd,
    )


def cohens_kappa(both: int, only_one: int, only_other: int, neither: int) -> float:
    """Return Cohen's kappa of two yes-or-no raters from the counts of their four outcomes; NaN where undefined."""
    total = both + only_one + only_other + neither
    if not total:
        return math.nan
    observed = (both + neither) / total
    one, other = (both + only_one) / total, (both + only_other) / total
    expected = one * other + (1 - one) * (1 - other)
    return (observed - expected) / (1 - expected) if expected < 1 else math.nan
