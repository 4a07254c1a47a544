"""From a clip's measured frames to paths, groups and exposure: the order of the steps."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ..archive.run.schedule import Note, Progress
from ..archive.store.folder import Folder
from ..arrays import FloatArray
from ..camera import Mount
from ..measure import Settings
from ..people.attributes import Attributes, PairsWhere, most_frequent
from ..people.doubts import PersonDoubt
from ..scene import Scene
from .camera import ClipCamera, chosen_frames, told_by_people
from .density import Region
from .doubts import counts, of_sightings, of_track, require_some, stays_put
from .events import SHORTEST_S
from .exposure import (
    DRAWS,
    PairOverTime,
    Sensitivity,
    exactly_known,
    pairs_over_time,
    weights_s,
)
from .floor import SharedError, is_complete
from .following import Followed, follow, smoothed, with_statures
from .groups import group_probabilities, groups_of
from .measuring import PART, Measured, scenes_of
from .placing import Placed, everybody_placed
from .shots import Shot
from .sightings import Sightings
from .smoothing import Track
from .statures import Stature


@dataclass(frozen=True)
class Wanted:
    """What is asked about a clip. within_m: limits in metres, ascending. region: of densities; None: the whole floor.

    mount: as stated, for the camera that the clip begins with. shortest_event_s: what is shorter is no event. where:
    only pairs count both of whose people have these attributes.
    """

    within_m: tuple[float, ...] = (1.0, 1.5, 2.0)
    region: Region | None = None
    mount: Mount | None = None
    settings: Settings = field(default_factory=Settings)
    shortest_event_s: float = SHORTEST_S
    where: PairsWhere | None = None


@dataclass(frozen=True, eq=False)
class Person:
    """One track with what holds for the whole of it.

    heading_rad: shape (n,), NaN where unseen. rows: shape (n,), the person's row in each scene, -1 where unseen.
    attributes: of each the value that most of the sightings have. doubts: of each sighting, None where unseen or not
    asked. motionless: whether no part of the body ever moved. doubt: what holds for the whole track, None where none
    was asked.
    """

    track: Track
    shot: int
    stature_m: float
    stature_sd_m: float
    group: int
    heading_rad: FloatArray
    rows: NDArray[np.intp]
    attributes: Attributes = field(default_factory=dict[str, str])
    doubts: Sequence[tuple[PersonDoubt, ...] | None] = ()
    motionless: bool = False

    @cached_property
    def doubt(self) -> tuple[PersonDoubt, ...] | None:
        """What most of the sightings say, and all of them together."""
        return of_track([reasons for reasons in self.doubts if reasons is not None], self.motionless)


@dataclass(frozen=True, eq=False)
class FrameState:
    """One frame: how many people, and what the camera was.

    followed: whether no pair in the tables means that no one was near anyone. Where the camera moves, or people could
    not be placed and no track bridges the frame, it means that nothing is known.
    """

    t_s: float
    shot: int
    camera: int
    status: str
    reason: str | None
    n_people: int
    n_detected: int
    followed: bool


@dataclass(eq=False)
class Analysis:
    """What is known of a clip; pairs come by `pairs`, one after the other, since they may be millions."""

    measured: Measured
    wanted: Wanted
    cameras: dict[int, ClipCamera]
    frames: list[FrameState]
    people: list[Person]
    probability: dict[tuple[int, int], float]
    weight_s: FloatArray
    region: Region | None
    noise_scale: dict[int, float]
    facing: dict[tuple[int, int, int], float]

    def sensitivity(self, camera: int) -> Sensitivity:
        """Return what places owe to the errors of a camera and of its floor."""
        known = self.cameras.get(camera)
        if known is None or known.mount is None or known.camera is None:
            return exactly_known
        return SharedError(known.mount, known.mount.camera or known.camera)

    def pairs(self) -> Iterator[PairOverTime]:
        """Yield every pair of tracks that were there at one time and count."""
        where = self.wanted.where
        for number, shot in enumerate(self.measured.shots):
            counted = [
                p for p in self.people if p.shot == number and (where is None or counts(where, p.attributes, p.doubt))
            ]
            tracks = [p.track for p in counted]
            yield from pairs_over_time(
                tracks, self.weight_s, self.wanted.within_m, self.sensitivity(shot.camera), DRAWS
            )

    @property
    def followed(self) -> NDArray[np.bool_]:
        """Shape (F,), `FrameState.followed` of every frame."""
        return np.array([f.followed for f in self.frames], dtype=bool)

    @property
    def main_camera(self) -> int:
        """The camera of most of the frames: maps and densities are of its floor."""
        cameras = [f.camera for f in self.frames] or [0]
        return max(sorted(set(cameras)), key=cameras.count)


def analyse(
    folder: Folder, measured: Measured, wanted: Wanted, jobs: int, on_progress: Callable[[Progress | Note], None]
) -> Analysis:
    """Return the paths in a clip whose frames are all measured.

    In two passes: people are followed, and the stature by all sightings of one goes back into the fit of each.
    """
    cameras = _cameras(folder, measured, wanted)
    on_progress(Note("placing everyone on one floor"))
    placed = everybody_placed(folder, measured, cameras, wanted.settings, jobs)
    followed = follow(measured, placed, {k for k, c in cameras.items() if c.mount is not None}, wanted.settings.locate)
    if any(followed.told):
        on_progress(Note("placing everyone again, with one stature for each person"))
        again = everybody_placed(folder, measured, cameras, wanted.settings, jobs, followed.told)
        placed, followed = with_statures(measured, followed, placed, again)
    return assembled(measured, wanted, cameras, placed, followed)


def assembled(
    measured: Measured, wanted: Wanted, cameras: dict[int, ClipCamera], placed: Sequence[Placed],
    followed: Followed | None = None,
) -> Analysis:  # fmt: skip
    """Return the paths, from all people's places in every frame."""
    followed = follow(measured, placed) if followed is None else followed
    step = float(np.median(np.diff(measured.times_s))) if len(measured.times_s) > 1 else 0.2
    times = np.array(measured.times_s)
    weight = np.zeros(len(times))
    people: list[Person] = []
    scales: dict[int, float] = {}
    for number, shot in enumerate(measured.shots):
        rows = slice(shot.first, shot.last + 1)
        weight[rows] = weights_s(times[rows], step)
        if shot.moving:
            continue
        seen = [s.sightings for s in placed[rows]]
        of_shot = followed.shots[number]
        tracks, scales[number] = smoothed(of_shot.chains, seen, times[rows])
        people += [
            _person(t, seen, shot, number, 1 + len(people) + k, stature)
            for k, (t, stature) in enumerate(zip(tracks, of_shot.statures, strict=True))
        ]
    tracks = [p.track for p in people]
    probability = {
        pair: p
        for number in range(len(measured.shots))
        for pair, p in group_probabilities([x.track for x in people if x.shot == number]).items()
    }
    member = {t: k for k, group in enumerate(groups_of([t.number for t in tracks], probability), 1) for t in group}
    people = [
        replace(
            p,
            group=member[p.track.number],
            attributes=_attributes(p, placed),
            doubts=of_sightings(p.track.frames, p.rows, placed),
            motionless=stays_put(p.track.frames, p.track.t_s, p.rows, placed),
        )
        for p in people
    ]
    if wanted.where is not None and people:
        require_some(wanted.where, [(p.attributes, p.doubt) for p in people])
    found = Analysis(
        measured, wanted, cameras, [], people, probability, weight, wanted.region, scales, _facing(people, placed)
    )
    found.frames = _frames(measured, placed, people)
    if found.region is None:
        found.region = _floor_walked(found)
    return found


def _attributes(person: Person, placed: Sequence[Placed]) -> Attributes:
    """Return the attributes that most of a person's sightings have."""
    seen = [(frame, row) for frame, row in zip(person.track.frames, person.rows, strict=True) if row >= 0]
    return most_frequent([placed[frame].attributes[row] for frame, row in seen if placed[frame].attributes])


def _cameras(folder: Folder, measured: Measured, wanted: Wanted) -> dict[int, ClipCamera]:
    """Return the clip's cameras by their numbers: the first as stated, others found from their own people."""
    found: dict[int, ClipCamera] = {}
    for camera in sorted({s.camera for s in measured.shots}):
        shots = [s for s in measured.shots if s.camera == camera]
        stated = wanted.mount if camera == 0 else None
        if all(s.moving for s in shots):
            found[camera] = ClipCamera(
                None,
                None,
                "the camera moves, or its pictures cannot be compared: every frame is measured by itself, no one is "
                "followed",
            )
        elif stated is not None and is_complete(stated) and stated.camera is not None:
            found[camera] = ClipCamera(stated, stated.camera, f"the camera's place: {stated.source}")
        else:
            blocks = _blocks(folder, shots, measured.times_s)
            found[camera] = told_by_people(blocks, stated, wanted.settings.locate)
    return found


def _blocks(
    folder: Folder, shots: Sequence[Shot], times_s: Sequence[float]
) -> Iterator[tuple[list[Scene], list[float]]]:
    """Yield the scenes of the frames that a camera is found from, block by block, with their times."""
    for block in (b for s in shots if not s.moving for b in chosen_frames(s.first, s.last)):
        texts: list[str] = []
        for part in range(block.start // PART, (block.stop - 1) // PART + 1):
            of_part = scenes_of(folder, part)
            first = part * PART
            texts += [of_part[k - first] for k in range(max(block.start, first), min(block.stop, first + len(of_part)))]
        yield [Scene.from_json(t) for t in texts], [times_s[k] for k in block]


def _person(
    track: Track, seen: Sequence[Sightings], shot: Shot, number: int, name: int, stature: Stature | None
) -> Person:
    """Return a shot's track as one of the clip's, its frames numbered through the clip."""
    height = sd = np.nan
    if stature is not None:
        height = float(np.exp(stature.mean))
        sd = height * stature.sd
    heading = np.array(
        [seen[f].heading_rad[p] if p >= 0 else np.nan for f, p in zip(track.frames, track.people, strict=True)]
    )
    moved = replace(track, number=name, frames=track.frames + shot.first)
    of_scene = [int(seen[f].rows[p]) if p >= 0 else -1 for f, p in zip(track.frames, track.people, strict=True)]
    return Person(moved, number, height, sd, 0, heading, np.array(of_scene, dtype=np.intp))


def _facing(people: Sequence[Person], placed: Sequence[Placed]) -> dict[tuple[int, int, int], float]:
    """Return the probability of facing each other by (frame, track, track), a first, where it is not small."""
    who: list[dict[int, int]] = [{} for _ in placed]
    for person in people:
        for frame, k in zip(person.track.frames, person.track.people, strict=True):
            if k >= 0:
                who[frame][int(placed[frame].sightings.rows[k])] = person.track.number
    found: dict[tuple[int, int, int], float] = {}
    for frame, state in enumerate(placed):
        for (a, b), p in state.facing.items():
            if a in who[frame] and b in who[frame]:
                first, second = sorted((who[frame][a], who[frame][b]))
                found[frame, first, second] = p
    return found


def _frames(measured: Measured, placed: Sequence[Placed], people: Sequence[Person]) -> list[FrameState]:
    count = np.zeros(len(placed), dtype=int)
    for person in people:
        np.add.at(count, person.track.frames, 1)
    states: list[FrameState] = []
    for number, shot in enumerate(measured.shots):
        for k in range(shot.first, shot.last + 1):
            of_frame, tracks = placed[k], int(count[k])
            followed = not shot.moving and (tracks > 0 or _tells_that_nobody_was_near(of_frame))
            there = len(of_frame.sightings) if shot.moving else tracks if followed else of_frame.n_detected
            states.append(FrameState(
                measured.times_s[k], number, shot.camera, of_frame.status, of_frame.reason, there,
                of_frame.n_detected, followed,
            ))  # fmt: skip
    return states


def _tells_that_nobody_was_near(frame: Placed) -> bool:
    """Return whether an empty frame in the tables is a finding: its people could be placed."""
    return frame.status == "ok" or (frame.status != "failed" and frame.n_detected < 2)


def _floor_walked(found: Analysis) -> Region | None:
    """Return the hull of where people were on the main camera's floor."""
    main = found.main_camera
    places = [p.track.positions_m for p in found.people if found.measured.shots[p.shot].camera == main]
    return Region.around(np.concatenate(places)) if places else None


def places_by_frame(found: Analysis) -> list[FloatArray]:
    """Return where people were in each frame of the main camera, (n, 2) each; empty in other frames."""
    main = found.main_camera
    answer: list[list[FloatArray]] = [[] for _ in found.measured.times_s]
    for person in found.people:
        if found.measured.shots[person.shot].camera == main:
            for frame, place in zip(person.track.frames, person.track.positions_m, strict=True):
                answer[frame].append(place)
    return [np.array(a).reshape(-1, 2) for a in answer]
