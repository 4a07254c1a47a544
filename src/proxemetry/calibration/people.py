"""A camera's place from the people of many of its photos or frames, robust, and as sure as different people make it."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ..arrays import FloatArray
from ..camera import Camera, FocalSource, Mount, Source
from ..camera.floor_view import to_floor
from ..errors import CameraError
from ..locate import LocateSettings
from ..locate.scenefit.pooled import Pooled, pooled
from ..people import People
from ..people.keypoint_noise import apparent_stature_px

#: A person seen less often in consecutive frames is left out: what flickers is not a person.
LEAST_SEEN = 5
#: So many detections are fitted together, and so many of one person; more take longer and add little.
MOST_DETECTIONS, MOST_OF_A_PERSON = 400, 30
#: Fewer different people than this make no calibration to rely on.
FEW_PEOPLE = 30
#: What is kept of a long clip: detections, sampled evenly.
_MOST_KEPT = 20_000
#: A person counts whose limbs are seen whole and large enough: shoulders, hips and ankles, so many pixels tall.
_NEEDED = (("left_shoulder", "right_shoulder"), ("left_hip", "right_hip"), ("left_ankle", "right_ankle"))
_LEAST_TALL_PX = 40.0
#: How much shorter than its parts the line from shoulder to ankle may be: walking people bend their knees.
_STRAIGHT = 0.85
#: A focal length that people leave open by more than this is no answer.
OPEN_FOCAL = 0.2
#: Where the focal length is unknown: a field of view of 60 degrees, and how far others are from it (logarithm).
_FOCAL_LOG_SD = 0.5


class Gathered:
    """People of many frames, gathered one frame after the other in bounded memory.

    Holds the whole, upright, large ones; `most_at_once` is the most people that one frame shows.
    """

    def __init__(self, seed: int = 0) -> None:
        self._rng = np.random.default_rng(seed)
        self._kept: list[tuple[People, int]] = []
        self._met = 0
        self.most_at_once = 0
        self.n_frames = 0

    def add(self, people: People, persons: Iterable[int]) -> None:
        """Add a frame's people, with numbers by which each is known again."""
        self.n_frames += 1
        usable = whole(people)
        self.most_at_once = max(self.most_at_once, int(usable.sum()))
        for row, person in enumerate(persons):
            if not usable[row]:
                continue
            self._met += 1
            if len(self._kept) < _MOST_KEPT:
                self._kept.append((people[row], int(person)))
            elif (place := int(self._rng.integers(self._met))) < _MOST_KEPT:
                self._kept[place] = (people[row], int(person))

    def __len__(self) -> int:
        return len(self._kept)

    def chosen(self, least_seen: int = 1) -> tuple[People, NDArray[np.intp]]:
        """Return the people to fit, large ones rather than small ones, and who each is; raises CameraError for none.

        People seen less often than `least_seen` are left out.
        """
        identities = np.array([person for _, person in self._kept], dtype=np.intp)
        names, index, often = np.unique(identities, return_inverse=True, return_counts=True)
        kept = np.flatnonzero(often[index] >= least_seen) if len(names) else np.zeros(0, dtype=np.intp)
        if not len(kept):
            raise CameraError(
                "no person stands upright in view from shoulders to ankles: no camera can be found from these people"
            )
        persons = identities[kept]
        tall = np.array([float(apparent_stature_px(self._kept[k][0])[0]) for k in kept])
        # the largest first, but for chance: keys of weighted sampling without replacement (Efraimidis and Spirakis)
        order = np.argsort(np.log(self._rng.random(len(tall))) / tall)[::-1]
        taken: list[int] = []
        of_person: dict[int, int] = {}
        for k in order:
            seen = of_person.get(int(persons[k]), 0)
            if seen < MOST_OF_A_PERSON and len(taken) < MOST_DETECTIONS:
                taken.append(int(k))
                of_person[int(persons[k])] = seen + 1
        taken.sort()
        return joined_people([self._kept[kept[k]][0] for k in taken]), persons[taken]


def whole(people: People) -> NDArray[np.bool_]:
    """Return which people are in view from shoulders to ankles, straight and large enough to use, shape (P,)."""
    seen = apparent_stature_px(people) >= _LEAST_TALL_PX
    for pair in _NEEDED:
        seen &= np.any([np.isfinite(people.joint(name)).all(axis=1) for name in pair], axis=0)
    for side in ("left", "right"):
        chain = np.stack([people.joint(f"{side}_{joint}") for joint in ("shoulder", "hip", "knee", "ankle")])
        walked = np.linalg.norm(np.diff(chain, axis=0), axis=-1).sum(axis=0)
        seen &= ~(np.linalg.norm(chain[-1] - chain[0], axis=-1) < _STRAIGHT * walked)
    return seen


def joined_people(parts: Sequence[People]) -> People:
    """Return the people of several photos as those of one."""
    return People(
        parts[0].skeleton,
        np.concatenate([p.keypoints_px for p in parts]),
        np.concatenate([p.scores for p in parts]),
        boxes_px=np.concatenate([p.boxes_px for p in parts]),
        person_scores=np.concatenate([p.person_scores for p in parts]),
        heading_rad=np.concatenate([p.heading_rad for p in parts]),
        heading_sd_rad=np.concatenate([p.heading_sd_rad for p in parts]),
        source=parts[0].source,
        depth_m=np.concatenate([p.depth_m for p in parts]),
        depth_sd_m=np.concatenate([p.depth_sd_m for p in parts]),
    )  # fmt: skip


@dataclass(frozen=True)
class PeopleFit:
    """The camera found from people, how many they are, and remarks on it.

    distances_m: how far the nearer, the middle and the farther of them are (10, 50 and 90 %). doubts: in words.
    """

    mount: Mount
    n_people: int
    n_detections: int
    n_frames: int
    distances_m: tuple[float, float, float]
    doubts: tuple[str, ...]


def from_people(
    gathered: Gathered, camera: Camera, *, focal_known: bool = True, recurring: bool = False,
    least_seen: int = 1, settings: LocateSettings | None = None,
) -> PeopleFit:  # fmt: skip
    """Return the mount that the people of many frames determine.

    camera: the intrinsics, believed within their standard deviations; with focal_known False its focal length is only
    where the search begins. recurring: the same people may be in every photo, and who is who is unknown: then they
    count as no more than one photo shows. least_seen: in consecutive frames, people seen less often are taken
    for false detections. Raises CameraError where they determine no camera.
    """
    settings = settings or LocateSettings()
    people, persons = gathered.chosen(least_seen)
    people = replace(people, keypoints_px=camera.undistorted(people.keypoints_px))
    ideal = camera.without_distortion()
    told = _pooled(people, persons, ideal, settings, focal_known)
    repeated = max(1.0, told.n_people / max(gathered.most_at_once, 1)) if recurring else 1.0
    covariance = told.covariance_if_met(repeated)
    n_people = round(told.n_people / repeated)
    mount = _mount(told, n_people, covariance, camera, focal_known)
    return PeopleFit(
        mount, n_people, told.n_detections, gathered.n_frames, _distances(people, mount), _doubts(mount, n_people),
    )  # fmt: skip


def _pooled(
    people: People, persons: NDArray[np.intp], camera: Camera, settings: LocateSettings, focal_known: bool
) -> Pooled:
    if not focal_known:
        camera = replace(camera, focal_rel_sd=_FOCAL_LOG_SD)
    told = pooled(people, camera, persons, settings)
    if told is not None and not focal_known:  # again from a closer start: the prior stays about where it was
        told = pooled(people, camera.with_focal(camera.f_px * math.exp(told.shared[3]), focal_rel_sd=_FOCAL_LOG_SD,
                                                source=camera.source), persons, settings)  # fmt: skip
    if told is None:
        raise CameraError("no camera can be found from these people: too little of them is seen")
    return told


def _mount(told: Pooled, n_people: int, covariance: FloatArray, camera: Camera, focal_known: bool) -> Mount:
    """Return the mount of what was found: pitch, roll, log height and log focal length are the first four.

    n_people: how many different ones count.
    """
    block = covariance[:4, :4].copy()
    pitch, roll, log_height, log_focal = map(float, told.shared[:4])
    scale = told.camera.f_px / camera.f_px * math.exp(log_focal)
    lens = replace(
        camera, fx=camera.fx * scale, fy=camera.fy * scale, cx=camera.cx + float(told.shared[4]) * told.camera.f_px,
        cy=camera.cy + float(told.shared[5]) * told.camera.f_px,
    )  # fmt: skip
    if focal_known and camera.focal_rel_sd == 0:
        block[3, :] = block[:, 3] = math.nan
    else:
        source = camera.source if focal_known else Source(FocalSource.PEOPLE, f"{n_people} of many photos")
        lens = replace(lens, focal_rel_sd=math.sqrt(block[3, 3]), source=source)
    rows = tuple(map(tuple, block.tolist()))
    source = f"{n_people} people, seen {told.n_detections} times"
    return Mount(pitch, roll, math.exp(log_height), rows, lens, source=source)


def _distances(people: People, mount: Mount) -> tuple[float, float, float]:
    """Return how far from the camera along the floor the people stand: 10, 50 and 90 %."""
    ankles = np.stack([people.joint("left_ankle"), people.joint("right_ankle")])
    feet = np.where(np.isfinite(ankles).all(axis=-1, keepdims=True), ankles, ankles[::-1]).mean(axis=0)
    assert mount.camera is not None
    away = np.linalg.norm(to_floor(replace(mount, camera=mount.camera.without_distortion()), feet), axis=1)
    low, middle, high = np.nanquantile(away, [0.1, 0.5, 0.9]) if np.isfinite(away).any() else (math.nan,) * 3
    return float(low), float(middle), float(high)


def _doubts(mount: Mount, n_people: int) -> tuple[str, ...]:
    doubts: list[str] = []
    if n_people < FEW_PEOPLE:
        doubts.append(f"only {n_people} different people: it takes {FEW_PEOPLE} for statures to even out")
    if mount.sd[3] > OPEN_FOCAL:
        doubts.append("the people leave the focal length open: the camera looks too level, state one")
    return tuple(doubts)
