"""Six people whose joints were measured in a room, seen from its calibrated cameras: real bodies, sitting, from above.

    python -m benchmarks.accuracy.captured_people ../shared/data/panoptic_poses [--noise 1.0]

The joints are CMU Panoptic's, triangulated from many cameras' detections, so they are where detectors place them; they
are projected into the high-definition cameras with the true intrinsics and moved by `--noise` times 1 % of the body's
height. Joints outside a picture are unseen. The postures of these six people were known when the scene fit's table of
postures was made; their places and the cameras were not used. The room's y axis points down.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import product
from pathlib import Path

import numpy as np

from proxemetry.arrays import FloatArray
from proxemetry.camera import Camera
from proxemetry.distances import measure_distances
from proxemetry.locate import LocateSettings, method_named
from proxemetry.people import People
from proxemetry.people.skeleton import COCO_17
from synthetic.pair_errors import Records, depth_summary, summary

#: The joints of a `joints19` row that COCO's 17 have, in its order, and the two that make the torso's middle.
JOINTS = ("neck", "nose", "mid_hip", "left_shoulder", "left_elbow", "left_wrist", "left_hip", "left_knee", "left_ankle",
          "right_shoulder", "right_elbow", "right_wrist", "right_hip", "right_knee", "right_ankle", "left_eye",
          "left_ear", "right_eye", "right_ear")  # fmt: skip
METHODS = ("scene", "torso", "combined")
#: Nobody's eyes are further apart: the face was triangulated from other things. Metres.
_FARTHEST_EYES_M = 0.10
_EYES = [JOINTS.index(joint) for joint in ("left_eye", "right_eye")]
_FACE = [JOINTS.index(joint) for joint in ("nose", "left_eye", "right_eye", "left_ear", "right_ear")]


@dataclass(frozen=True)
class View:
    """One calibrated camera: rotation (3, 3) and shift (3,) in metres from the room's frame."""

    name: str
    camera: Camera
    rotation: FloatArray
    shift_m: FloatArray

    def seen(self, points_m: FloatArray) -> FloatArray:
        """Return points of the room (..., 3) in the camera frame."""
        return points_m @ self.rotation.T + self.shift_m


def views_of(calibration: Path) -> list[View]:
    """Return the room's high-definition cameras."""
    views: list[View] = []
    for row in json.loads(calibration.read_text(encoding="utf-8"))["cameras"]:
        if row["type"] != "hd":
            continue
        k, (width, height) = row["K"], row["resolution"]
        camera = Camera(k[0][0], k[1][1], k[0][2], k[1][2], width, height)
        views.append(View(row["name"], camera, np.array(row["R"]), np.array(row["t"])[:, 0] / 100))
    return views


def frames_of(folder: Path, every: int) -> Iterator[FloatArray]:
    """Yield the joints (P, 19, 3) of every so many frames in metres, NaN where one was not measured, or not well."""
    for path in sorted(folder.glob("body3DScene_*.json"))[::every]:
        bodies = json.loads(path.read_text(encoding="utf-8"))["bodies"]
        values = np.array([b["joints19"] for b in bodies], dtype=float).reshape(len(bodies), 19, 4)
        yield with_human_faces(np.where(values[..., 3:] > 0, values[..., :3] / 100, np.nan))


def with_human_faces(joints_m: FloatArray) -> FloatArray:
    """Return joints (P, 19, 3) with every face unmeasured whose eyes are too far apart for one."""
    apart = np.linalg.norm(joints_m[:, _EYES[0]] - joints_m[:, _EYES[1]], axis=-1)
    kept = joints_m.copy()
    kept[np.ix_(apart > _FARTHEST_EYES_M, _FACE)] = np.nan
    return kept


def photo_of(joints_m: FloatArray, view: View, noise: float, rng: np.random.Generator) -> tuple[People, FloatArray]:
    """Return the people of whom five joints are seen, and where their torsos' middles are in the room, shape (P, 3)."""
    at = view.seen(joints_m)
    pixels = view.camera.project(at.reshape(-1, 3)).reshape(*at.shape[:2], 2)
    middle = (joints_m[:, JOINTS.index("neck")] + joints_m[:, JOINTS.index("mid_hip")]) / 2
    depth = view.seen(middle)[:, 2]
    pixels += rng.normal(0, 0.01 * noise * 1.7 * view.camera.f_px / np.abs(depth)[:, None, None], pixels.shape)
    shown = np.array([JOINTS.index(joint) for joint in COCO_17.joints])
    inside = ((pixels >= 0) & (pixels < (view.camera.width, view.camera.height))).all(axis=-1)[:, shown]
    seen = inside & (at[:, shown, 2] > 0.3)
    keep = np.isfinite(middle).all(axis=1) & (seen.sum(axis=1) >= 5)
    keypoints = np.where(seen[..., None], pixels[:, shown], np.nan)
    return People(COCO_17, keypoints[keep], np.where(seen, 0.9, 0.0)[keep], source="recorded"), middle[keep]


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("poses", type=Path)
    parser.add_argument("--noise", type=float, default=1.0)
    parser.add_argument("--every", type=int, default=10)
    parser.add_argument("--body-size", default=LocateSettings().body_size)
    args = parser.parse_args()
    rng = np.random.default_rng(0)
    answers = {method: Records(method) for method in METHODS}
    for folder in sorted(p for p in args.poses.iterdir() if p.is_dir()):
        views = views_of(next(folder.glob("calibration_*.json")))
        for joints_m, view in product(frames_of(folder, args.every), views):
            people, middle = photo_of(joints_m, view, args.noise, rng)
            if len(people) < 2:
                continue
            truth = np.linalg.norm((middle[:, None] - middle)[..., [0, 2]], axis=-1)
            true_depth = view.seen(middle)[:, 2]
            for method, records in answers.items():
                bodies = method_named(method)(people, view.camera, LocateSettings(body_size=args.body_size))
                distances = measure_distances(bodies)
                for pair in distances.pairs():
                    records.true_m.append(truth[pair])
                    records.estimate_m.append(distances.distance_m[pair])
                    records.low_m.append(distances.low_m[pair])
                    records.high_m.append(distances.high_m[pair])
                    records.group.append(folder.name)
                records.true_depth_m += list(true_depth)
                records.depth_m += list(bodies.positions_m[:, 2])
                records.depth_sd_m += list(bodies.position_sd_m[:, 2])
                records.person_group += [folder.name] * len(people)
    columns = ("pairs", "miss %", "mean %", "median", "bias %", "in 90 %", "depth %", "bias %")
    print(" " * 12 + "".join(f"{c:>{w}s}" for c, w in zip(columns, (7, 8, 8, 8, 8, 9, 9, 8), strict=True)))
    for method, records in answers.items():
        s, (depth, depth_bias, _) = summary(records), depth_summary(records)
        print(f"{method:12s}{s.pairs:7d}{s.missing_pct:8.0f}{s.mean_error_pct:8.1f}{s.median_error_pct:8.1f}"
              f"{s.bias_pct:+8.1f}{s.coverage_pct:9.0f}{depth:9.1f}{depth_bias:+8.1f}")  # fmt: skip


if __name__ == "__main__":
    main()
