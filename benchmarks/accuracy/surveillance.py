"""Pedestrians in front of a camera on a mast: small people seen from above, whose places on the floor are known.

    python -m benchmarks.accuracy.surveillance [--data ../shared/data/video/pets] [--models DIR] [--pose A,B]

PETS 2009, view 1 (`vtest.avi`, 768 x 576): a camera 7 m high that looks down by 16 degrees, people 17 to 35 m away and
some 80 px tall. The truth is the authors' boxes of the first 400 frames, whose lower edges lie on the floor of Tsai's
calibration, accurate to 0.1 to 0.2 m. The focal length is given, the camera's place is not. One frame in twenty is
taken; neighbouring frames show the same people again, so the shares are less certain than their number suggests.

`alike` of `keypoint_noise.toml` was chosen with these frames in view; nothing else was.
"""

from __future__ import annotations

import argparse
import csv
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from xml.etree import ElementTree as ET

import cv2
import numpy as np
from numpy.typing import NDArray

from benchmarks.networks.networks_at_hand import add_models_option
from proxemetry.camera import Camera
from proxemetry.distances import measure_distances
from proxemetry.locate import LocateSettings, method_named
from proxemetry.people import People
from proxemetry.photo import Photo
from proxemetry.pose import PoseOptions, available, backend_named

FloatArray = NDArray[np.float64]

_FRAMES = range(0, 400, 20)
#: The middle of the torso above the floor.
_MIDDLE_M = 1.12
_TO_90 = 1.645
#: A box is a person's where its middle lies this near, of the person's width and height, and it is as tall.
_ASIDE, _UP, _TALL = 0.4, 0.15, 0.25


@dataclass(frozen=True, eq=False)
class Mast:
    """The calibrated camera: rotation (3, 3) and shift (3,) in metres from the floor's frame, z up."""

    camera: Camera
    rotation: FloatArray
    shift_m: FloatArray

    def seen(self, floor_m: FloatArray, height_m: float = 0.0) -> FloatArray:
        """Return points (P, 2) of the floor, or so far above it, in the camera frame, (P, 3)."""
        points = np.column_stack([floor_m, np.full(len(floor_m), height_m)])
        return points @ self.rotation.T + self.shift_m


@dataclass(frozen=True, eq=False)
class Standing:
    """Who stands where in one frame: boxes (P, 4) in pixels, places on the floor (P, 2) in metres."""

    boxes_px: FloatArray
    floor_m: FloatArray


def read_mast(file: Path) -> Mast:
    """Read Tsai's calibration; its lens distortion of 0.3 px is left out."""
    root = ET.parse(file).getroot()
    parts = [root.find(name) for name in ("Geometry", "Intrinsic", "Extrinsic")]
    geometry, lens, place = ({k: float(v) for k, v in part.attrib.items()} for part in parts if part is not None)
    (sx, cx), (sy, cy), (sz, cz) = ((math.sin(place[a]), math.cos(place[a])) for a in ("rx", "ry", "rz"))
    rotation = np.array([
        [cy * cz, cz * sx * sy - cx * sz, sx * sz + cx * cz * sy],
        [cy * sz, sx * sy * sz + cx * cz, cx * sy * sz - cz * sx],
        [-sy, cy * sx, cx * cy],
    ])  # fmt: skip
    fx, fy = lens["focal"] / geometry["dpx"] * lens["sx"], lens["focal"] / geometry["dpy"]
    camera = Camera(fx, fy, lens["cx"], lens["cy"], int(geometry["width"]), int(geometry["height"]))
    return Mast(camera, rotation, np.array([place[name] for name in ("tx", "ty", "tz")]) / 1000)


def read_truth(file: Path) -> dict[int, Standing]:
    """Return who stands where by frame."""
    rows: dict[int, list[list[float]]] = {}
    with file.open(newline="") as lines:
        for row in csv.DictReader(lines):
            names = ("box_x0", "box_y0", "box_x1", "box_y1", "x_m", "y_m")
            rows.setdefault(int(row["frame"]), []).append([float(row[name]) for name in names])
    return {frame: Standing(np.array(r)[:, :4], np.array(r)[:, 4:]) for frame, r in rows.items()}


def frames_of(clip: Path) -> Iterator[tuple[int, Photo]]:
    """Yield the frames that are taken."""
    video = cv2.VideoCapture(str(clip))
    for number in _FRAMES:
        video.set(cv2.CAP_PROP_POS_FRAMES, number)
        read, frame = video.read()
        if not read:
            raise OSError(f"{clip} has no frame {number}")
        yield number, Photo.from_array(cv2.cvtColor(np.asarray(frame, dtype=np.uint8), cv2.COLOR_BGR2RGB))  # pyright: ignore
    video.release()


def owners(people: People, standing: Standing) -> NDArray[np.intp]:
    """Return who of the truth each of the people is, -1 where nobody."""
    if not len(people):
        return np.zeros(0, dtype=np.intp)
    size = standing.boxes_px[:, 2:] - standing.boxes_px[:, :2]
    ours = people.boxes_px[:, 2:] - people.boxes_px[:, :2]
    middles = (people.boxes_px[:, :2] + people.boxes_px[:, 2:])[:, None] / 2
    off = np.abs(middles - (standing.boxes_px[:, :2] + standing.boxes_px[:, 2:]) / 2) / size
    fits = (off < (_ASIDE, _UP)).all(axis=-1) & (np.abs(ours[:, None, 1] / size[:, 1] - 1) < _TALL)
    cost = np.where(fits, off.sum(axis=-1), np.inf)
    return np.where(fits.any(axis=1), cost.argmin(axis=1), -1)


def lines(seen: Mapping[int, People], truth: Mapping[int, Standing], mast: Mast) -> str:
    """Return the figures of one back end."""
    depths: list[tuple[float, float, float]] = []
    pairs: list[tuple[float, float, float, float]] = []
    for number, people in seen.items():
        bodies = method_named("scene")(people, mast.camera, LocateSettings(), None)
        whom, distances = owners(people, truth[number]), measure_distances(bodies)
        known = np.flatnonzero((whom >= 0) & bodies.placed)
        true = mast.seen(truth[number].floor_m, _MIDDLE_M)
        depths += [(true[whom[i], 2], bodies.positions_m[i, 2], bodies.position_sd_m[i, 2]) for i in known]
        for k, i in enumerate(known):
            for j in known[:k]:
                apart = float(np.linalg.norm(truth[number].floor_m[whom[i]] - truth[number].floor_m[whom[j]]))
                if apart > 0:
                    pairs.append((apart, distances.distance_m[i, j], distances.low_m[i, j], distances.high_m[i, j]))
    true, found, sd = np.array(depths).T
    apart, between, low, high = np.array(pairs).T
    off, error = found / true - 1, np.abs(between / apart - 1)
    held = (low <= apart) & (apart <= high)
    return (
        f"{len(true)} people, depth {np.abs(off).mean():.1%} off, bias {off.mean():+.1%}, "
        f"{np.mean(np.abs(found - true) <= _TO_90 * sd):.0%} in 90 %; {len(apart)} pairs {error.mean():.1%} off, "
        f"median {np.median(error):.1%}, {held.mean():.0%} in 90 %, width {np.median((high - low) / between):.0%}"
    )


def main(arguments: Sequence[str] | None = None) -> None:
    """Print a line for each back end."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--data", type=Path, default=Path("../shared/data/video/pets"))
    add_models_option(parser)
    parser.add_argument("--pose", default="", help="comma-separated names (default: all that are available)")
    parser.add_argument("--effort", default="thorough")
    args = parser.parse_args(arguments)
    mast = read_mast(args.data / "calibration_tsai.xml")
    truth = read_truth(args.data / "truth_frames_0-399.csv")
    for name in args.pose.split(",") if args.pose else available():
        backend = backend_named(name, PoseOptions(effort=args.effort))
        seen = {number: backend.detect(photo) for number, photo in frames_of(args.data / "vtest.avi")}
        print(f"{name}: {lines(seen, truth, mast)}", flush=True)


if __name__ == "__main__":
    main()
