"""Every frame's people on the floor of their camera, which is held: measured again from what was found in pixels."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ..archive.run.interrupts import WorkerProcesses
from ..archive.store import parts
from ..archive.store.folder import Folder
from ..bodies import Bodies
from ..camera import Mount
from ..measure import Settings, remeasure
from ..people.attributes import Attributes
from ..people.doubts import PersonDoubt
from ..scene import Scene
from .boxes import standing
from .camera import ClipCamera
from .floor import held, sightings_of
from .measuring import PART, Measured, scenes_of
from .orphans import end_with_parent
from .sightings import Sightings
from .statures import Known

#: Fewer parts than this are not worth starting processes for.
_FEWEST_PARTS = 3


@dataclass(frozen=True, eq=False)
class Placed:
    """One frame's people on the floor; facing: (row, row) -> probability of an F-formation, where not small.

    attributes, doubts, keypoints_px: of all people in the scene, by its rows; keypoints are of shape (P, K, 2). No
    doubts and no keypoints where only boxes are known.
    """

    sightings: Sightings
    status: str
    reason: str | None
    n_detected: int
    facing: dict[tuple[int, int], float]
    attributes: Sequence[Attributes] = ()
    doubts: Sequence[tuple[PersonDoubt, ...]] = ()
    keypoints_px: NDArray[np.float32] | None = None


@dataclass(frozen=True)
class _Task:
    """One part of a clip: a frame each in times_s, mounts and statures."""

    location: str
    part: int
    times_s: Sequence[float]
    mounts: Sequence[Mount | None]
    statures: Sequence[Known]
    settings: Settings


def everybody_placed(
    folder: Folder, measured: Measured, cameras: Mapping[int, ClipCamera], settings: Settings, jobs: int,
    statures: Sequence[Known] | None = None,
) -> list[Placed]:  # fmt: skip
    """Return every frame's people on the floor; statures: of each frame's people, by row."""
    tasks = list(_tasks(folder, measured, cameras, replace(settings, mount=None), statures))
    if jobs == 0 or len(tasks) < _FEWEST_PARTS:
        return [p for task in tasks for p in _place_part(task)]
    with WorkerProcesses(jobs, end_with_parent) as pool:
        return [p for block in pool.map(_place_part, tasks) for p in block]


def _tasks(
    folder: Folder, measured: Measured, cameras: Mapping[int, ClipCamera], settings: Settings,
    statures: Sequence[Known] | None,
) -> Iterator[_Task]:  # fmt: skip
    mounts = [cameras[s.camera].mount for s in measured.shots for _ in range(s.first, s.last + 1)]
    for part in sorted(parts.finished(folder)):
        rows = slice(part * PART, (part + 1) * PART)
        known = [{}] * PART if statures is None else statures[rows]
        yield _Task(folder.location, part, measured.times_s[rows], mounts[rows], known, settings)


def _place_part(task: _Task) -> list[Placed]:
    """Place the people of one part's frames."""
    answer: list[Placed] = []
    scenes = map(Scene.from_json, scenes_of(Folder(task.location), task.part))
    for scene, t_s, mount, known in zip(scenes, task.times_s, task.mounts, task.statures, strict=False):
        facing = _facing_each_other(scene)
        bodies = scene.bodies
        if scene.status != "ok" or not len(scene):
            mount = None
        if mount is not None:
            bodies = _held_fit(scene, mount, task.settings, known)
        seen = sightings_of(t_s, scene.people, bodies, mount)
        doubts, joints = (), None
        if scene.bodies.method != "box":
            doubts, joints = scene.doubts, scene.people.keypoints_px.astype(np.float32)
        about = scene.people.attributes, doubts, joints
        answer.append(Placed(seen, scene.status, scene.reason, len(scene), facing, *about))
    return answer


def _held_fit(scene: Scene, mount: Mount, settings: Settings, known: Known) -> Bodies:
    if scene.bodies.method == "box":
        return standing(scene.people, mount)
    if known:
        told = replace(settings.locate, statures=tuple(known.get(row) for row in range(len(scene))))
        settings = replace(settings, locate=told)
    camera = mount.camera or scene.camera.camera
    assert camera is not None  # a scene that is ok has one
    estimate = replace(scene.camera, camera=replace(camera, focal_rel_sd=0.0, principal_sd_px=0.0), mount=held(mount))
    return remeasure(scene, settings, camera=estimate).bodies


def _facing_each_other(scene: Scene) -> dict[tuple[int, int], float]:
    """Return the pairs that form an F-formation, by rows of the scene, where that is more likely than 2 %."""
    if len(scene) < 2 or scene.status != "ok":
        return {}
    p = scene.distances.group_probability
    return {(int(a), int(b)): float(p[a, b]) for a, b in np.argwhere(np.nan_to_num(p) > 0.02) if a < b}
