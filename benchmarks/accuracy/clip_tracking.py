"""Tracking on real paths with a simulated detector: identities kept, identity switches, and speed.

    python -m benchmarks.accuracy.clip_tracking DATA [--fps 5] [--seeds 2]

DATA is a folder of scenes with `obsmat.txt`, as `clip_groups` reads them (ETH, UCY): paths in metres of real people
who meet, overtake and stand about. A camera on a mast sees them as boxes, and as places on the floor with errors along
the line of sight: small ones from frame to frame, larger ones from an uneven floor, which are the same for everyone who
stands there, and occasional gross errors, as of a body that is cut off. People hidden by a person in front of them are
mostly not found. No back end is used. IDF1 and switches are those of MOT Challenge, counted over sightings.
"""

from __future__ import annotations

import argparse
import math
import time
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from proxemetry.arrays import FloatArray
from proxemetry.assignment import assign
from proxemetry.camera import Camera, Mount
from proxemetry.camera.floor_view import to_pixels
from proxemetry.clip.floor import FLOOR_REACH_M
from proxemetry.clip.following import chains_of
from proxemetry.clip.sightings import Chain, Sightings
from proxemetry.overlap import areas_of, shared_areas

_STEP_S, FOCAL_PX = 0.4, 1190.0
#: What the synthetic eyes do, as shares of the distance along the line of sight: from frame to frame, by the floor, and
#: where a sighting goes wrong; how often one does, and how often someone in full view is missed. Across it in pixels.
DEPTH_SD, FLOOR_SD, WILD_SD, WILD_SHARE, MISSED, ACROSS_PX = 0.006, 0.013, 0.06, 0.03, 0.05, 2.0
_BOX_PX = 2.0
_WIDTH_SHARE = 0.33


@dataclass(frozen=True, eq=False)
class Seen:
    """One frame as seen: sightings, and of each who it is, shape (P,)."""

    sightings: Sightings
    persons: NDArray[np.intp]


def paths_of(scene: Path, fps: float) -> tuple[FloatArray, list[tuple[NDArray[np.intp], FloatArray]]]:
    """Return times and, for each, who is there and where, by straight lines between annotated places."""
    rows = np.loadtxt(scene / "obsmat.txt")
    frames = rows[:, 0] - rows[:, 0].min()
    at_s = frames / np.median(np.diff(np.unique(frames))) * _STEP_S
    times = np.arange(0.0, at_s.max(), 1 / fps)
    there: list[tuple[list[int], list[FloatArray]]] = [([], []) for _ in times]
    for person in np.unique(rows[:, 1]):
        mine = rows[:, 1] == person
        own_s, places = at_s[mine], rows[mine][:, [2, 4]]
        for k in np.flatnonzero((times >= own_s[0]) & (times <= own_s[-1])):
            there[k][0].append(int(person))
            there[k][1].append(np.array([np.interp(times[k], own_s, places[:, d]) for d in (0, 1)]))
    return times, [(np.array(who, dtype=np.intp), np.array(at).reshape(-1, 2)) for who, at in there]


def mast(places_m: FloatArray) -> tuple[Mount, FloatArray]:
    """Return a camera that sees the middle of all places from outside, and where its foot is."""
    low, high = places_m.min(axis=0), places_m.max(axis=0)
    reach = float((high - low).max())
    pitch, height = math.radians(16.5), 7.0
    camera = Camera.centred(FOCAL_PX, 768, 576)
    mount = Mount.stated(pitch, 0.0, height, pitch_sd_rad=1e-4, roll_sd_rad=1e-4, height_sd_m=1e-3, camera=camera)
    middle = (low + high) / 2
    return mount, np.array([middle[0], low[1] - max(9.0, 23.0 - reach / 2)])


def seen_by(
    mount: Mount, foot_m: FloatArray, times: FloatArray, there: list[tuple[NDArray[np.intp], FloatArray]], seed: int
) -> list[Seen]:
    """Return every frame as the synthetic eyes see it."""
    rng = np.random.default_rng(seed)
    statures: dict[int, float] = {}
    frames: list[Seen] = []
    for now, (who, places) in zip(times.tolist(), there, strict=True):
        own = places - foot_m
        tall = np.array([statures.setdefault(int(p), float(rng.normal(1.70, 0.09))) for p in who])
        boxes = _boxes(mount, own, tall)
        assert mount.camera is not None
        shown = (boxes[:, 0] > 0) & (boxes[:, 2] < mount.camera.width) & (boxes[:, 3] < mount.camera.height)
        found = shown & (rng.random(len(who)) > np.maximum(MISSED, _covered(boxes, own) ** 2))
        frames.append(Seen(_sightings(rng, now, own[found], boxes[found]), who[found]))
    return frames


def _boxes(mount: Mount, own_m: FloatArray, tall_m: FloatArray) -> FloatArray:
    """Return the boxes (n, 4) of people who stand at places (n, 2)."""
    feet = to_pixels(mount, own_m).reshape(-1, 2)
    heads = np.array([to_pixels(mount, at, high) for at, high in zip(own_m, tall_m, strict=True)]).reshape(-1, 2)
    half = _WIDTH_SHARE * (feet[:, 1] - heads[:, 1]) / 2
    return np.stack([heads[:, 0] - half, heads[:, 1], heads[:, 0] + half, feet[:, 1]], axis=1)


def _covered(boxes_px: FloatArray, own_m: FloatArray) -> FloatArray:
    """Return which share of each box the nearest person in front covers, shape (n,)."""
    shared = shared_areas(boxes_px, boxes_px)
    in_front = np.linalg.norm(own_m, axis=1)[None] < np.linalg.norm(own_m, axis=1)[:, None]
    area = np.maximum(areas_of(boxes_px), 1e-9)
    return np.asarray((np.where(in_front, shared, 0.0) / area[:, None]).max(axis=1, initial=0.0))


def _sightings(rng: np.random.Generator, now: float, own_m: FloatArray, boxes_px: FloatArray) -> Sightings:
    away = np.maximum(np.linalg.norm(own_m, axis=1), 1e-9)
    ahead = own_m / away[:, None]
    aside = np.stack([-ahead[:, 1], ahead[:, 0]], axis=1)
    wild = np.where(rng.random(len(own_m)) < WILD_SHARE, WILD_SD, 0.0)
    sd = np.stack([np.hypot(DEPTH_SD, wild), np.full(len(away), ACROSS_PX / FOCAL_PX)], axis=1) * away[:, None]
    stated = np.stack([np.full(len(away), DEPTH_SD), np.full(len(away), ACROSS_PX / FOCAL_PX)], axis=1) * away[:, None]
    error = rng.normal(size=(len(own_m), 2)) * sd
    error[:, 0] += FLOOR_SD * away * _uneven(own_m)
    axes = np.stack([ahead, aside], axis=-1)
    seen = Sightings.of_places(now, own_m + (axes @ error[..., None])[..., 0])
    return replace(
        seen, covariance_m2=(axes * (stated**2)[:, None, :]) @ axes.transpose(0, 2, 1),
        floor_m2=(FLOOR_SD * away)[:, None, None] ** 2 * ahead[:, :, None] * ahead[:, None, :],
        boxes_px=boxes_px + rng.normal(0, _BOX_PX, boxes_px.shape),
    )  # fmt: skip


def _uneven(own_m: FloatArray) -> FloatArray:
    """Return how a floor puts people wrong who stand at places (n, 2), in standard deviations, shape (n,)."""
    rng = np.random.default_rng(0)
    waves = np.cos(own_m @ rng.normal(0, 1 / FLOOR_REACH_M, (2, 64)) + rng.uniform(0, 2 * math.pi, 64))
    return np.asarray(waves @ rng.normal(size=64) * math.sqrt(2 / 64))


def score(chains: list[Chain], frames: list[Seen]) -> tuple[float, int, int]:
    """Return IDF1, switches and how many people were seen."""
    people = sorted({int(p) for f in frames for p in f.persons})
    row = {p: k for k, p in enumerate(people)}
    shared = np.zeros((len(people), len(chains)))
    of_sighting: dict[tuple[int, int], int] = {}
    for number, chain in enumerate(chains):
        for frame, place in zip(chain.frames.tolist(), chain.people.tolist(), strict=True):
            shared[row[int(frames[frame].persons[place])], number] += 1
            of_sighting[frame, place] = number
    right = sum(shared[i, j] for i, j in assign(-shared)) if len(chains) else 0.0
    total = sum(len(f.persons) for f in frames)
    last: dict[int, int] = {}
    switches = 0
    for number, frame in enumerate(frames):
        for place, person in enumerate(frame.persons.tolist()):
            track = of_sighting.get((number, place))
            if track is not None:
                switches += last.get(person, track) != track
                last[person] = track
    return 2 * right / (total + len(of_sighting)), switches, len(people)


def main() -> None:
    """Print one row a scene and seed."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("data", type=Path)
    parser.add_argument("--fps", type=float, default=5.0)
    parser.add_argument("--seeds", type=int, default=2)
    parser.add_argument("--seconds", type=float, default=240.0, help="of each scene, from its beginning")
    args = parser.parse_args()
    print("| scene | seed | people | sightings | tracks | IDF1 | switches a minute and person | ms a frame |")
    print("|---|---|---|---|---|---|---|---|")
    for scene in sorted(p.parent for p in args.data.glob("*/obsmat.txt")):
        times, there = paths_of(scene, args.fps)
        times, there = times[times < args.seconds], there[: int((times < args.seconds).sum())]
        mount, foot = mast(np.concatenate([at for _, at in there]))
        for seed in range(args.seeds):
            frames = seen_by(mount, foot, times, there, seed)
            assert mount.camera is not None
            begun = time.process_time()
            chains = chains_of([f.sightings for f in frames], times, mount.camera.width)
            spent = 1000 * (time.process_time() - begun) / len(times)
            idf1, switches, people = score(chains, frames)
            count = sum(len(f.persons) for f in frames)
            print(
                f"| {scene.name} | {seed} | {people} | {count} | {len(chains)} | {idf1:.3f} "
                f"| {switches / (count / args.fps / 60):.2f} | {spent:.1f} |", flush=True,
            )  # fmt: skip


if __name__ == "__main__":
    main()
