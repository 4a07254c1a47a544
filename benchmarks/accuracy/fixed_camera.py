"""Fixed cameras: pair errors by how the camera's place is known, on a real clip with known positions.

    python -m benchmarks.accuracy.fixed_camera --data DIR [--keypoints FILE] [--pose yolox-tinypose] [--every 3]

DIR is the folder of PETS 2009 S2.L1 view 1 (`fixed_camera_data`). Every pair of people whose detections show two boxes
of the truth enters the errors, frame by frame, nothing smoothed. Rows: nothing known about the camera's place;
estimated from the people of all frames, matched by overlapping boxes, with the focal length known or not; from four
points on the floor, clicked to 2 px and taped to 5 cm, ten times; the calibration itself. In all but the last row the
principal point is taken to be the middle of the picture, within one per cent of its width (it is 60 px off). The
mount's uncertainty is carried into every interval.
"""

from __future__ import annotations

import argparse
import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from benchmarks.accuracy.fixed_camera_data import (
    FixedCamera,
    Frame,
    clip_detector,
    pets_camera,
    pets_frames,
    recorded_detector,
)
from proxemetry.arrays import FloatArray
from proxemetry.calibration.people import PeopleFit
from proxemetry.calibration.points import FloorPoints, from_points, open_camera
from proxemetry.camera import Camera, CameraEstimate, Mount
from proxemetry.cli.calibrate_people import of_frames
from proxemetry.measure import Settings, place

FRAMES_PER_S = 10.0
#: How well the principal point of a video camera is known, of the picture's width.
PRINCIPAL_REL_SD = 0.01
#: Four points of the floor about where people walk, in metres of the truth: two near ones and two far ones.
CORNERS = np.array([(-14.0, -11.0), (-9.0, -14.0), (3.0, 0.0), (-9.0, 4.0)])


@dataclass(frozen=True, eq=False)
class Pairs:
    """Pairs of matched people: truth and answer in metres with its interval, shape (N,) each."""

    truth_m: FloatArray
    found_m: FloatArray
    low_m: FloatArray
    high_m: FloatArray

    def line(self) -> str:
        """Return the figures."""
        error = self.found_m / self.truth_m - 1
        near = self.truth_m < 4
        holds = (self.low_m <= self.truth_m) & (self.truth_m <= self.high_m)
        return (
            f"{len(error):5d}{100 * np.abs(error).mean():7.1f}{100 * np.median(np.abs(error)):7.1f}"
            f"{100 * error.mean():+7.1f}{np.abs(self.found_m - self.truth_m)[near].mean():7.2f}"
            f"{100 * holds.mean():6.0f}"
        )

    @classmethod
    def joined(cls, parts: Sequence[Pairs]) -> Pairs:
        """Return all of several."""
        return cls(*(
            np.concatenate([getattr(p, name) for p in parts]) for name in ("truth_m", "found_m", "low_m", "high_m")
        ))  # fmt: skip


def pairs_of(frames: Sequence[Frame], camera: Camera, mount: Mount | None) -> Pairs:
    """Return all pairs of people, measured frame by frame."""
    rows: list[tuple[float, float, float, float]] = []
    for frame in frames:
        scene = place("", "", camera.width, camera.height, frame.people, CameraEstimate(camera), Settings(), mount)
        there = np.flatnonzero(frame.owners >= 0)
        d = scene.distances
        for i, a in enumerate(there):
            for b in there[:i]:
                truth = float(np.linalg.norm(frame.floor_m[frame.owners[a]] - frame.floor_m[frame.owners[b]]))
                if math.isfinite(d.distance_m[a, b]):
                    rows.append((truth, d.distance_m[a, b], d.low_m[a, b], d.high_m[a, b]))
    return Pairs(*np.array(rows).reshape(-1, 4).T)


def by_people(frames: Sequence[Frame], camera: Camera, focal_known: bool) -> PeopleFit:
    """Return what the people of all frames say, false detections included."""
    return of_frames([(f.number / FRAMES_PER_S, f.people) for f in frames], camera, focal_known)


def by_points(true: FixedCamera, camera: Camera, rng: np.random.Generator, focal_known: bool) -> Mount:
    """Return what four points say, clicked and taped with errors."""
    seen = true.project(np.column_stack([CORNERS, np.zeros(4)]))
    points = FloorPoints(seen + rng.normal(0, 2.0, seen.shape), CORNERS + rng.normal(0, 0.05, CORNERS.shape))
    return from_points(points, camera, focal_known=focal_known).mount


def place_line(mount: Mount) -> str:
    """Return a mount's numbers."""
    lens = "" if mount.camera is None else f" f {mount.camera.f_px:5.0f} +- {100 * np.nan_to_num(mount.sd[3]):4.1f} %"
    return (
        f" height {mount.height_m:5.2f} +- {mount.height_sd_m:4.2f} m, pitch {math.degrees(mount.pitch_rad):5.2f} +- "
        f"{math.degrees(mount.sd[0]):4.2f}, roll {math.degrees(mount.roll_rad):5.2f} +- "
        f"{math.degrees(mount.sd[1]):4.2f}{lens}"
    )


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--data", type=Path, required=True)
    parser.add_argument("--keypoints", type=Path, help="recorded keypoints of the frames, instead of a back end")
    parser.add_argument("--pose", default="yolox-tinypose")
    parser.add_argument("--every", type=int, default=3, help="measure every n-th of every second frame")
    args = parser.parse_args()
    true = pets_camera(args.data / "calibration_tsai.xml")
    detect = recorded_detector(args.keypoints) if args.keypoints else clip_detector(args.data / "vtest.avi", args.pose)
    frames = pets_frames(args.data, detect)
    judged = frames[:: args.every]
    width, height = true.camera.width, true.camera.height
    sd_px = PRINCIPAL_REL_SD * width
    known = replace(Camera.centred(true.camera.f_px, width, height), principal_sd_px=sd_px)
    open_lens = replace(open_camera(width, height), principal_sd_px=sd_px)

    print(f"{'camera':28s}{'pairs':>5s}{'mean%':>7s}{'median':>7s}{'bias%':>7s}{'<4m, m':>7s}{'in 90':>6s}  its place")
    print(f"{'each frame by itself':28s}{pairs_of(judged, known, None).line()}")
    for label, lens, focal_known in (("people, f known", known, True), ("people, f unknown", open_lens, False)):
        fit = by_people(frames, lens, focal_known)
        assert fit.mount.camera is not None
        print(f"{label:28s}{pairs_of(judged, fit.mount.camera, fit.mount).line()} {place_line(fit.mount)}; "
              f"{fit.n_people} people, {fit.n_detections} detections")  # fmt: skip
    rng = np.random.default_rng(0)
    for label, lens, focal_known in (
        ("four points, f known", known, True),
        ("four points, f unknown", open_lens, False),
    ):
        mounts = [by_points(true, lens, rng, focal_known) for _ in range(10)]
        each = [pairs_of(judged[::3], m.camera, m) for m in mounts if m.camera is not None]
        means = [100 * float(np.abs(p.found_m / p.truth_m - 1).mean()) for p in each]
        print(f"{label:28s}{Pairs.joined(each).line()} {place_line(mounts[0])}; worst of 10: {max(means):.1f} %")
    print(f"{'the calibration':28s}{pairs_of(judged, true.camera, true.mount).line()} {place_line(true.mount)}")


if __name__ == "__main__":
    main()
