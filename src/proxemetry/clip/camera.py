"""Where a clip's camera is: stated, or found from the clip's own people, who are pooled over its frames."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ..arrays import FloatArray
from ..calibration.identity import MEMORY_S, linked
from ..calibration.people import LEAST_SEEN, OPEN_FOCAL, Gathered, PeopleFit, from_people
from ..camera import Camera, CameraEstimate, Mount
from ..errors import CameraError
from ..locate import LocateSettings
from ..people import People
from ..scene import Scene
from .floor import is_complete
from .floor_identity import followed

#: People of frames in a row, and the frames' times in seconds.
Frames = tuple[list[People], list[float]]

#: So many frames are looked at for the camera's place, in blocks spread over the clip, each of so many in a row: within
#: a block it is known who is who, so that no person's stature counts as many people's.
BLOCKS, BLOCK_FRAMES = 10, 150
#: Fewer people than this give no camera that could be relied on.
_FEWEST_PEOPLE = 2


@dataclass(frozen=True)
class ClipCamera:
    """What is known of one camera of a clip. mount: complete, or None where every frame is on its own; note: why."""

    mount: Mount | None
    camera: Camera | None
    note: str = ""


def chosen_frames(first: int, last: int) -> list[range]:
    """Return the blocks of a shot's frames (both ends included) that the camera is found from."""
    count = last - first + 1
    if count <= BLOCKS * BLOCK_FRAMES:
        return [range(first, last + 1)]
    starts = np.linspace(first, last + 1 - BLOCK_FRAMES, BLOCKS).astype(int)
    return [range(int(s), int(s) + BLOCK_FRAMES) for s in starts]


def told_by_people(
    blocks: Iterable[tuple[list[Scene], list[float]]], stated: Mount | None, settings: LocateSettings
) -> ClipCamera:
    """Return the camera that people determine, given blocks of frames in a row with their times.

    stated: what else is known of the camera; it is weighed against the people.
    """
    estimate, recurring = CameraEstimate(None), False
    seen: list[Frames] = []
    for scenes, times in blocks:
        # pictures further apart than tracks last: the same few people may be in all of them
        recurring |= len(times) > 1 and float(np.median(np.diff(times))) > MEMORY_S
        usable = [(s, t) for s, t in zip(scenes, times, strict=True) if s.status == "ok"]
        if estimate.camera is None and usable:
            estimate = usable[0][0].camera
        seen.append(([s.people for s, _ in usable], [t for _, t in usable]))
    camera = estimate.camera if stated is None else stated.camera or estimate.camera
    known = estimate.source is None or estimate.source.kind.is_evidence
    if camera is None:
        return ClipCamera(None, None, "the focal length is unknown: state it, or a mount that has it")
    try:
        found = from_frames(seen, camera, focal_known=known, recurring=recurring, settings=settings)
    except CameraError as error:
        return ClipCamera(None, camera, f"{error}; every frame is measured by itself")
    if found.n_people < _FEWEST_PEOPLE:
        return ClipCamera(
            None, camera, "a single person is too little to find the camera from: every frame is measured by itself"
        )
    mount = weighed(found.mount, stated)
    doubts = "".join(f"; {doubt}" for doubt in found.doubts)
    place = f"{mount.height_m:.1f} m high, looking down by {math.degrees(mount.pitch_rad):.0f} degrees"
    text = f"the camera's place was found from {found.n_people} people: {place}{doubts}"
    return ClipCamera(mount, mount.camera, text)


def from_frames(
    blocks: Sequence[Frames], camera: Camera, *, focal_known: bool, recurring: bool = False, least_seen: int = 1,
    settings: LocateSettings | None = None,
) -> PeopleFit:  # fmt: skip
    """Return the camera from blocks of frames in a row, the people of no two blocks taken to be the same.

    People are followed by their boxes first. Boxes lose people behind others, and one person in several pieces counts
    as several: the stature of a handful would be believed like that of many. Unless they leave the focal length open,
    the camera found from them is good enough to follow them over the floor, and they are asked again.

    recurring: see `from_people`; such people cannot be followed. least_seen: for the first time; see `from_people`.
    Raises CameraError where they determine no camera.
    """

    def fit(identities: Callable[[Frames], list[NDArray[np.intp]]], seen: int) -> PeopleFit:
        gathered, met = Gathered(), 0
        for frames in blocks:
            who = identities(frames)
            for people, persons in zip(frames[0], who, strict=True):
                gathered.add(people, (met + int(p) for p in persons))
            met += 1 + max((int(p.max()) for p in who if len(p)), default=0)
        return from_people(
            gathered, camera, focal_known=focal_known, recurring=recurring, least_seen=seen, settings=settings
        )

    first = fit(lambda frames: linked(*frames), least_seen)
    if recurring or (not focal_known and first.mount.sd[3] > OPEN_FOCAL):
        return first
    try:
        return fit(lambda frames: followed(*frames, first.mount), LEAST_SEEN)
    except CameraError:  # no person could be followed so
        return first


def weighed(told: Mount, stated: Mount | None) -> Mount:
    """Return the people's and the stated pitch, roll and height combined, each by its certainty."""
    known = [] if stated is None or is_complete(stated) else [k for k in stated.known if k < 3]
    if stated is None or not known:
        return told
    covariance = np.array(told.covariance)
    rows = [k for k in range(4) if math.isfinite(covariance[k, k])]
    own = covariance[np.ix_(rows, rows)]
    mean, said = _values(told), _values(stated)
    picked = np.array([[float(k == r) for r in rows] for k in known])
    noise = np.array(stated.covariance)[np.ix_(known, known)]
    gain = own @ picked.T @ np.linalg.inv(picked @ own @ picked.T + noise)
    step = gain @ (said[known] - mean[known])
    covariance[np.ix_(rows, rows)] = own - gain @ picked @ own
    moved = mean.copy()
    for k, row in enumerate(rows):
        moved[row] += step[k]
    camera = told.camera
    if camera is not None and 3 in rows:
        camera = camera.with_focal(
            camera.f_px * math.exp(moved[3]), focal_rel_sd=math.sqrt(covariance[3, 3]), source=camera.source
        )
    plain = tuple(tuple(float(v) for v in row) for row in covariance)
    return replace(
        told, pitch_rad=float(moved[0]), roll_rad=float(moved[1]), height_m=math.exp(moved[2]), covariance=plain,
        camera=camera, floor_frame=stated.floor_frame, source=f"{told.source}, and {stated.source}",
    )  # fmt: skip


def _values(mount: Mount) -> FloatArray:
    return np.array([mount.pitch_rad, mount.roll_rad, math.log(mount.height_m), 0.0])
