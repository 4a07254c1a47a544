"""Pictures of people whose joints are known in space: which of them were found, and how accurate the results are.

Shared by `from_above.py`, whose people are rendered, and `calibrated_views.py`, whose people were seen by several
cameras at once.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Protocol

import numpy as np

from proxemetry.arrays import FloatArray
from proxemetry.assignment import assign
from proxemetry.bodies import Bodies
from proxemetry.camera import Camera, Mount
from proxemetry.distances import measure_distances
from proxemetry.locate import LocateSettings, method_named
from proxemetry.people import People
from proxemetry.people.skeleton import COCO_17, kind_of

_STATURE_M = 1.7
_TO_90 = 1.645
#: Someone is a known person where half of the joints lie nearer than this to theirs, in statures.
_SAME = 0.12
#: A known person who shows so many of the five joints of the frame can be found.
_ENOUGH_OF_FRAME = 3
#: Who shows fewer pixels is hidden.
_LEAST_SHOWN_PX = 800
_FRAME = [COCO_17.joints.index(j) for j in ("nose", "left_shoulder", "right_shoulder", "left_hip", "right_hip")]
_KINDS = ("nose", "eye", "ear", "shoulder", "hip", "knee", "ankle")


class KnownPhoto(Protocol):
    """A picture's truth.

    joints_m: shape (P, 17, 3), camera frame, NaN where unknown. to_camera: shape (3, 3), from the floor's frame (x
    right, y down, z forward). shown: shape (P,), how many pixels of each can be seen.
    """

    @property
    def camera(self) -> Camera:
        """The camera, as it bends the picture."""
        ...

    @property
    def pitch_rad(self) -> float:
        """How far it looks down."""
        ...

    @property
    def to_camera(self) -> FloatArray:
        """The floor's axes."""
        ...

    @property
    def joints_m(self) -> FloatArray:
        """COCO's joints."""
        ...

    @property
    def shown(self) -> np.ndarray:
        """The pixels of each."""
        ...


@dataclass
class Tally:
    """What one view's photos say: found, seeable, doubled and other people, depths (true, found, sd), pairs (true,
    found, low, high), pitches (error, sd) and headings (error, sd) in degrees, and joints' errors (2,) by kind, in
    statures: downwards in the picture, and towards the same joint of the other side, NaN where there is none."""

    found: int = 0
    seeable: int = 0
    doubled: int = 0
    others: int = 0
    depths: list[tuple[float, float, float]] = field(default_factory=list)
    pairs: list[tuple[float, float, float, float]] = field(default_factory=list)
    pitches: list[tuple[float, float]] = field(default_factory=list)
    headings: list[tuple[float, float]] = field(default_factory=list)
    joints: dict[str, list[tuple[float, float, float]]] = field(default_factory=dict)

    def line(self) -> str:
        """Return the figures of people and pairs."""
        parts = [f"{self.found:3d} of {self.seeable:3d}, {self.doubled} doubled, {self.others} others"]
        if self.depths:
            true, depth, sd = np.array(self.depths).T
            held = np.mean(np.abs(depth - true) <= _TO_90 * sd)
            parts.append(f"depth x{np.median(depth / true):.2f}, {held:4.0%} in 90 %")
        if self.pairs:
            apart, between, low, high = np.array(self.pairs).T
            held = np.mean((low <= apart) & (apart <= high))
            parts.append(
                f"{len(apart):3d} pairs {np.mean(np.abs(between / apart - 1)):5.1%} off, {held:4.0%} in 90 %, "
                f"width {np.median((high - low) / between):3.0%}"
            )
        for name, errors in (("pitch", self.pitches), ("heading", self.headings)):
            if errors:
                off, sd = np.array(errors).T
                held = np.mean(np.abs(off) <= _TO_90 * sd)
                typical = np.median(off) if name == "pitch" else np.median(np.abs(off))
                parts.append(f"{name} {typical:+5.1f}, {held:4.0%} in 90 %")
        return " | ".join(parts)

    def joint_line(self) -> str:
        """Return the joints' errors in percent of the stature: median size, mean downwards, mean inwards."""
        parts: list[str] = []
        for kind in _KINDS:
            errors = np.array(self.joints.get(kind, np.zeros((0, 3))))
            if len(errors):
                size, down = np.median(errors[:, 0]), errors[:, 1].mean()
                inwards = errors[np.isfinite(errors[:, 2]), 2]
                aside = f"{100 * inwards.mean():+.1f}" if len(inwards) else ""
                parts.append(f"{kind} {100 * size:.1f} {100 * down:+.1f} {aside}".rstrip())
        return "   ".join(parts)


def true_pixels(photo: KnownPhoto) -> tuple[FloatArray, FloatArray]:
    """Return the joints' pixels (P, 17, 2), NaN outside the picture, and statures in pixels (P,)."""
    pixels = photo.camera.project(photo.joints_m.reshape(-1, 3)).reshape(*photo.joints_m.shape[:2], 2)
    size = (photo.camera.width, photo.camera.height)
    inside = ((pixels > 0) & (pixels < size)).all(axis=-1) & (photo.joints_m[..., 2] > 0.3)
    return np.where(inside[..., None], pixels, np.nan), photo.camera.f_px * _STATURE_M / middles_m(photo)[:, 2]


def middles_m(photo: KnownPhoto) -> FloatArray:
    """Return the middles of the torsos in the camera frame, (P, 3)."""
    neck, hips = (photo.joints_m[:, [k, k + 1]].mean(axis=1) for k in (_FRAME[1], _FRAME[3]))
    return (neck + hips) / 2


def headings_rad(photo: KnownPhoto) -> FloatArray:
    """Return which way trunks face, 0 towards the camera, positive to the photo's right (P,)."""
    left, right = (photo.joints_m[:, [_FRAME[k], _FRAME[k + 2]]].mean(axis=1) for k in (1, 2))
    across = (left - right) @ photo.to_camera  # x right, y down, z forward; facing the camera is left to the right
    return np.arctan2(across[:, 2], across[:, 0])


def owners(people: People, pixels: FloatArray, statures_px: FloatArray) -> np.ndarray:
    """Return whom of the known each of the people is, -1 for nobody."""
    whom = np.full(len(people), -1)
    cost = _apart(people, pixels, statures_px)
    for row, column in assign(cost):
        if cost[row, column] < _SAME:
            whom[row] = column
    return whom


def _apart(people: People, pixels: FloatArray, statures_px: FloatArray) -> FloatArray:
    """Return the median distance of each of the people's joints to each of the known's, in statures."""
    if not len(people):
        return np.zeros((0, len(pixels)))
    seen = np.stack([people.joint(joint) for joint in COCO_17.joints], axis=1)
    gaps = np.linalg.norm(seen[:, None] - pixels, axis=-1) / statures_px[:, None]
    enough = np.isfinite(gaps).sum(axis=-1) >= 3
    return np.where(enough, np.nanmedian(np.where(enough[..., None], gaps, 9.0), axis=-1), 9.0)


def true_people(pixels: FloatArray, statures_px: FloatArray, rng: np.random.Generator) -> People:
    """Return the known of whom three joints are in the picture, as someone would see them who errs by 0.5 % of the
    stature."""
    moved = pixels + rng.normal(0, 0.005, pixels.shape) * statures_px[:, None, None]
    moved = moved[np.isfinite(moved).all(axis=-1).sum(axis=1) >= 3]
    return People(COCO_17, moved, np.where(np.isfinite(moved).all(axis=-1), 0.9, 0.0))


def count(tally: Tally, photo: KnownPhoto, people: People, whom: np.ndarray, mount: Mount | None = None) -> None:
    """Add what was found in one photo, and where the scene fit puts it; mount: what is known of the camera's place."""
    pixels, statures_px = true_pixels(photo)
    seeable = (np.isfinite(pixels[:, _FRAME]).all(axis=-1).sum(axis=1) >= _ENOUGH_OF_FRAME) & (
        photo.shown > _LEAST_SHOWN_PX
    )
    tally.seeable += int(seeable.sum())
    tally.found += int(seeable[whom[whom >= 0]].sum())
    twice = (whom < 0) & (_apart(people, pixels, statures_px).min(axis=1, initial=9.0) < _SAME)
    tally.doubled += int(twice.sum())
    tally.others += int(((whom < 0) & ~twice).sum())
    _count_joints(tally, people, whom, pixels, statures_px)
    if len(people):
        straight = replace(people, keypoints_px=photo.camera.undistorted(people.keypoints_px))
        camera = photo.camera.without_distortion()
        _count_places(tally, photo, method_named("scene")(straight, camera, LocateSettings(), mount), whom)


def _count_joints(
    tally: Tally, people: People, whom: np.ndarray, pixels: FloatArray, statures_px: FloatArray
) -> None:  # fmt: skip
    for row in np.flatnonzero(whom >= 0):
        owner = whom[row]
        for k, joint in enumerate(COCO_17.joints):
            error = (people.joint(joint)[row] - pixels[owner, k]) / statures_px[owner]
            if np.isfinite(error).all():
                inwards = pixels[owner, COCO_17.mirror[k]] - pixels[owner, k]
                length = float(np.linalg.norm(inwards)) or np.nan
                size, aside = float(np.linalg.norm(error)), float(error @ inwards) / length
                tally.joints.setdefault(kind_of(joint), []).append((size, float(error[1]), aside))


def _count_places(tally: Tally, photo: KnownPhoto, bodies: Bodies, whom: np.ndarray) -> None:
    distances, middles = measure_distances(bodies), middles_m(photo)
    on_floor = (middles @ photo.to_camera)[:, [0, 2]]
    known = np.flatnonzero((whom >= 0) & bodies.placed)
    turned = bodies.heading_rad[known] - headings_rad(photo)[whom[known]]
    off = np.rad2deg(np.angle(np.exp(1j * turned)))
    tally.headings += list(zip(off.tolist(), np.rad2deg(bodies.heading_sd_rad[known]).tolist(), strict=True))
    for k, i in enumerate(known):
        tally.depths.append((middles[whom[i], 2], bodies.positions_m[i, 2], bodies.position_sd_m[i, 2]))
        for j in known[:k]:
            apart = float(np.linalg.norm(on_floor[whom[i]] - on_floor[whom[j]]))
            tally.pairs.append((apart, distances.distance_m[i, j], distances.low_m[i, j], distances.high_m[i, j]))
    if bodies.floor is not None:
        pitch_off = np.rad2deg(bodies.floor.pitch_rad - photo.pitch_rad)
        tally.pitches.append((float(pitch_off), float(np.rad2deg(bodies.floor.pitch_sd_rad))))


def joined(tallies: Sequence[Tally]) -> Tally:
    """Return several views' figures as one's."""
    total = Tally()
    for one in tallies:
        for name in ("found", "seeable", "doubled", "others"):
            setattr(total, name, getattr(total, name) + getattr(one, name))
        total.depths += one.depths
        total.pairs += one.pairs
        total.pitches += one.pitches
        total.headings += one.headings
        for kind, errors in one.joints.items():
            total.joints.setdefault(kind, []).extend(errors)
    return total
