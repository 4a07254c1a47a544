"""Synthetic labelled scenes: people of known size at known places, known cameras, and a detector's keypoints.

    python -m synthetic.scenes OUT --count 200 --seed 1 --kind mixed

writes a folder that the benchmark reads as it reads the photographed one (three label files, `settings.csv`,
`focal_lengths_recovered.csv`) and `keypoints.json`, recorded keypoints with each photo's camera. Photo i of a seed is
the same whatever the count. As a library: `scenes(count, seed, recipe)` gives `SyntheticPhoto`s.
"""

from __future__ import annotations

import argparse
import math
from collections.abc import Iterator
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from proxemetry.arrays import FloatArray
from proxemetry.camera import Camera
from proxemetry.people import People
from proxemetry.people.skeleton import COCO_17, Skeleton
from synthetic.bodies import draw_build, draw_posture, pose_joints
from synthetic.detections import Detector, Seen, detect

Rng = np.random.Generator

SENSOR_WIDTH_MM = 36.0
FOCAL_LENGTHS_MM = (16.0, 24.0, 35.0, 50.0, 85.0, 105.0, 200.0, 300.0)
KINDS = ("eye_level", "tripod", "elevated", "pitched", "mixed")
#: Share of people on a chair, by recipe; "mixed" photos are all standing, all seated, or both.
POSTURES = {"standing": 0.0, "seated": 1.0, "mixed": None}
NEAREST_PEOPLE_M, FARTHEST_GROUP_M = 0.45, 35.0


@dataclass(frozen=True)
class Recipe:
    """What the photos of a set have in common.

    kind: how the camera stands, one of `KINDS`. posture: one of `POSTURES`. focal_mm: the lenses to draw from.
    children: share of people of 2 to 16 years. people: fewest and most. layouts: places to stand as arrays (P, 2) in
    metres to draw from instead of inventing them (the measured ones of a benchmark, `layouts_from_labels`).
    """

    kind: str = "mixed"
    posture: str = "mixed"
    focal_mm: tuple[float, ...] = FOCAL_LENGTHS_MM
    children: float = 0.0
    people: tuple[int, int] = (2, 7)
    skeleton: Skeleton = COCO_17
    detector: Detector = field(default_factory=Detector)
    layouts: tuple[FloatArray, ...] = ()
    width: int = 4160
    height: int = 2768


@dataclass(frozen=True, eq=False)
class SyntheticPhoto:
    """One photo's truth and what was detected in it; Q true people, D detections.

    people: the detections. owners: shape (D,), the row of the true person that each detection shows.
    joints_m: joint name -> shape (Q, 3), camera frame, metres. positions_m: shape (Q, 3), the torso's middle.
    ground_mm: shape (Q, 2), where the torso's middle lies over the floor, x and z of the level frame below the camera.
    up: unit vector against gravity, camera frame. heading_rad: shape (Q,), 0 faces the camera, positive turns towards
    the image's right. parts_px: benchmark part -> shape (Q, 2), NaN where outside the picture.
    """

    name: str
    kind: str
    camera: Camera
    focal_mm: float
    height_m: float
    pitch_rad: float
    roll_rad: float
    people: People
    owners: NDArray[np.intp]
    joints_m: dict[str, FloatArray]
    positions_m: FloatArray
    ground_mm: FloatArray
    up: FloatArray
    heading_rad: FloatArray
    stature_m: FloatArray
    seated: NDArray[np.bool_]
    child: NDArray[np.bool_]
    parts_px: dict[str, FloatArray]

    @property
    def distances_m(self) -> FloatArray:
        """Shape (Q, Q): true distances on the floor between the torsos' middles."""
        return np.linalg.norm(self.ground_mm[:, None] - self.ground_mm[None], axis=-1) / 1000


def scenes(count: int, seed: int = 0, recipe: Recipe | None = None) -> Iterator[SyntheticPhoto]:
    """Make `count` photos, each showing at least two people of whom at least one was detected."""
    for number in range(count):
        rng = np.random.default_rng([seed, number])
        photo = None
        while photo is None:
            photo = _attempt(rng, recipe or Recipe(), f"S{seed}_{number:05d}.jpg")
        yield photo


def layouts_from_labels(ground_truth_csv: str) -> tuple[FloatArray, ...]:
    """Return where people stand in each shoot of a benchmark, shapes (P, 2), metres, from its ground truth file."""
    import csv
    from pathlib import Path

    shoots: dict[str, list[tuple[float, float]]] = {}
    for row in csv.reader(Path(ground_truth_csv).read_text().splitlines()):
        if row and row[1].startswith("P"):
            shoots.setdefault(row[0], []).append((float(row[2]) / 1000, float(row[4]) / 1000))
    return tuple(np.array(places) for places in shoots.values())


def _attempt(rng: Rng, recipe: Recipe, name: str) -> SyntheticPhoto | None:
    """Draw one photo, or None where fewer than two people came out in the picture."""
    kind = recipe.kind if recipe.kind != "mixed" else str(rng.choice(KINDS[:-1]))
    places = _layout(rng, recipe)
    count = len(places)
    share = POSTURES[recipe.posture]
    share = float(rng.choice([0.0, 0.0, 1.0, 0.3])) if share is None else share
    seated = rng.random(count) < share
    builds = [draw_build(rng, child=bool(rng.random() < recipe.children)) for _ in range(count)]
    focal_mm = float(rng.choice(recipe.focal_mm))
    camera = Camera.centred(recipe.width * focal_mm / SENSOR_WIDTH_MM, recipe.width, recipe.height)
    view = _camera_pose(rng, kind, places, seated, camera)
    floor = _view_places(rng, places, view)
    headings = _headings(rng, floor)
    joints = [
        _to_camera(pose_joints(build, draw_posture(rng, bool(sits))), place, heading, view)
        for build, sits, place, heading in zip(builds, seated, floor, headings, strict=True)
    ]
    shown = np.array([_is_shown(camera, j) for j in joints])
    if shown.sum() < 2:
        return None
    keep = np.flatnonzero(shown)
    joints = [joints[k] for k in keep]
    seen = [_seen(rng, camera, joints[i], float(headings[k]), bool(seated[k])) for i, k in enumerate(keep)]
    keypoints, scores, owners = detect(rng, seen, recipe.skeleton, camera.width, camera.height, recipe.detector)
    if not owners:
        return None
    stacked = {joint: np.array([j[joint] for j in joints]) for joint in joints[0]}
    positions = (stacked["neck"] + stacked["mid_hip"]) / 2
    return SyntheticPhoto(
        name, kind, camera, focal_mm, view.height_m, view.pitch_rad, view.roll_rad,
        People(recipe.skeleton, keypoints, scores), np.array(owners, dtype=np.intp), stacked, positions,
        (positions @ view.rotation)[:, [0, 2]] * 1000, view.up, headings[keep],
        np.array([builds[k].stature for k in keep]), seated[keep], np.array([builds[k].child for k in keep]),
        _parts(camera, stacked, seen),
    )  # fmt: skip


@dataclass(frozen=True, eq=False)
class _View:
    """The camera over the floor: `rotation` takes the level frame (x right, y down, z ahead) to the camera's."""

    height_m: float
    pitch_rad: float
    roll_rad: float
    distance_m: float
    centre: FloatArray
    aside: float

    @property
    def rotation(self) -> FloatArray:
        p, r = self.pitch_rad, self.roll_rad
        pitched = np.array([[1, 0, 0], [0, math.cos(p), -math.sin(p)], [0, math.sin(p), math.cos(p)]])
        rolled = np.array([[math.cos(r), -math.sin(r), 0], [math.sin(r), math.cos(r), 0], [0, 0, 1]])
        return rolled @ pitched

    @property
    def up(self) -> FloatArray:
        return self.rotation @ (0.0, -1.0, 0.0)


def _layout(rng: Rng, recipe: Recipe) -> FloatArray:
    """Return places on the floor, shape (P, 2), metres, about their centre: groups and single people."""
    if recipe.layouts:
        places = recipe.layouts[rng.integers(len(recipe.layouts))]
        return places - places.mean(axis=0)
    count = int(rng.integers(recipe.people[0], recipe.people[1] + 1))
    spread = rng.uniform(0.6, 1.4) * math.sqrt(count)
    places: list[FloatArray] = []
    while len(places) < count:
        near = places[rng.integers(len(places))] if places and rng.random() < 0.5 else None
        place = rng.normal(0, spread, 2) if near is None else near + _offset(rng, rng.uniform(NEAREST_PEOPLE_M, 1.6))
        if all(np.hypot(*(place - other)) >= NEAREST_PEOPLE_M for other in places):
            places.append(place)
    return np.array(places) - np.mean(places, axis=0)


def _offset(rng: Rng, radius: float) -> FloatArray:
    angle = rng.uniform(0, 2 * math.pi)
    return radius * np.array([math.cos(angle), math.sin(angle)])


def _camera_pose(rng: Rng, kind: str, places: FloatArray, seated: NDArray[np.bool_], camera: Camera) -> _View:
    """Stand where the group fills the frame as photographers like it, within what the kind allows."""
    eyes = 1.2 if seated.all() else 1.55
    height = {
        "eye_level": rng.normal(eyes, 0.1), "tripod": 1.35, "elevated": rng.uniform(2.3, 6.0),
        "pitched": rng.uniform(0.4, 2.6),
    }[kind]  # fmt: skip
    wide = max(2 * float(np.abs(places).max()), 1.8)
    tall = rng.uniform(1.2, 3.5)
    distance = camera.f_px * max(wide / camera.width, tall / camera.height) / rng.uniform(0.6, 1.2)
    nearest = float(np.hypot(*places.T).max()) + 0.8
    distance = float(np.clip(distance, nearest, FARTHEST_GROUP_M))
    aim = rng.uniform(0.75, 1.25) * (0.75 if seated.all() else 1.0)
    pitch = math.atan2(height - aim, distance)
    if kind in ("eye_level", "tripod"):
        pitch = float(np.clip(rng.normal(0, math.radians(2)), -0.09, 0.09)) + 0.5 * pitch
    elif kind == "pitched":
        pitch += rng.normal(0, 0.15) * camera.height / camera.f_px
    roll = math.radians(rng.normal(0, 1.0))
    return _View(float(height), float(pitch), roll, distance, places.mean(axis=0), float(rng.uniform(-0.1, 0.1)))


def _view_places(rng: Rng, places: FloatArray, view: _View) -> FloatArray:
    """Turn the group at random and set it before the camera: shape (P, 2), x and z of the level frame, metres."""
    angle = rng.uniform(0, 2 * math.pi)
    turn = np.array([[math.cos(angle), -math.sin(angle)], [math.sin(angle), math.cos(angle)]])
    return (places - view.centre) @ turn.T + (view.aside * view.distance_m * 0.2, view.distance_m)


def _headings(rng: Rng, floor: FloatArray) -> FloatArray:
    """Face the group's centre, the camera, or anywhere."""
    answer = []
    for place in floor:
        towards = {"group": floor.mean(axis=0) - place, "camera": -place, "any": _offset(rng, 1.0)}
        x, z = towards[str(rng.choice(["group", "camera", "any"], p=[0.45, 0.3, 0.25]))]
        answer.append(math.atan2(x, -z) + rng.normal(0, 0.25))
    return np.array(answer)


def _to_camera(body: dict[str, FloatArray], place: FloatArray, heading: float, view: _View) -> dict[str, FloatArray]:
    """From the body frame to the camera frame."""
    forward = np.array([math.sin(heading), 0.0, -math.cos(heading)])
    up = np.array([0.0, -1.0, 0.0])
    axes = np.stack([forward, np.cross(up, forward), up])
    feet = np.array([place[0], view.height_m, place[1]])
    return {joint: view.rotation @ (point @ axes + feet) for joint, point in body.items()}


def _is_shown(camera: Camera, joints: dict[str, FloatArray]) -> bool:
    """A person is in the picture where head or chest are."""
    points = np.array([joints[j] for j in ("head_centre", "neck")] + [(joints["neck"] + joints["mid_hip"]) / 2])
    if points[:, 2].min() < 0.4:
        return False
    pixels = camera.project(points)
    return bool(((pixels >= 0) & (pixels < (camera.width, camera.height))).all(axis=1).any())


def _seen(rng: Rng, camera: Camera, joints: dict[str, FloatArray], heading: float, seated: bool) -> Seen:
    pixels = {joint: camera.project(point) for joint, point in joints.items()}
    sight = joints["neck"] / np.linalg.norm(joints["neck"])
    face = joints["nose"] - joints["head_centre"]
    head_away = float(sight @ face / np.linalg.norm(face))
    body_away = float(sight @ (math.sin(heading), 0.0, -math.cos(heading)))
    left_is_far = bool(joints["left_shoulder"][2] > joints["right_shoulder"][2])
    table = float("inf")
    if seated and rng.random() < 0.5:
        edge = 0.35 * joints["mid_hip"] + 0.65 * (joints["left_knee"] + joints["right_knee"]) / 2
        table = float(camera.project(edge)[1])
    return Seen(pixels, float(joints["neck"][2]), body_away, head_away, left_is_far, table)


def _parts(camera: Camera, joints: dict[str, FloatArray], seen: list[Seen]) -> dict[str, FloatArray]:
    """What an annotator would mark: centres inside the picture, the eyes only where the face is seen."""
    centres = {
        "Eyes": joints["eyes_centre"], "Shoulder": joints["neck"], "Torso": (joints["neck"] + joints["mid_hip"]) / 2,
        "Head": joints["head_centre"],
    }  # fmt: skip
    parts = {name: camera.project(points) for name, points in centres.items()}
    for pixels in parts.values():
        pixels[~((pixels >= 0) & (pixels < (camera.width, camera.height))).all(axis=1)] = np.nan
    parts["Eyes"][[person.head_away > 0.2 for person in seen]] = np.nan
    return parts


def main() -> None:
    """Write a set to a folder."""
    from synthetic.files import write

    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("out")
    parser.add_argument("--count", type=int, default=200)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--kind", choices=KINDS, default="mixed")
    parser.add_argument("--posture", choices=list(POSTURES), default="mixed")
    parser.add_argument("--children", type=float, default=0.0, metavar="SHARE")
    parser.add_argument("--noise", type=float, default=Detector.noise, help="in units of annotators' spread")
    parser.add_argument("--layouts", metavar="CSV", help="ground truth file whose places to use")
    args = parser.parse_args()
    recipe = Recipe(
        kind=args.kind, posture=args.posture, children=args.children, detector=replace(Detector(), noise=args.noise),
        layouts=layouts_from_labels(args.layouts) if args.layouts else (),
    )  # fmt: skip
    count = write(args.out, scenes(args.count, args.seed, recipe))
    print(f"{count} photos in {args.out}")


if __name__ == "__main__":
    main()
