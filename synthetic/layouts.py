"""The photos of a measured benchmark again, with synthetic bodies: its places, cameras and lenses, its framing.

Every photo of the label folder is taken again with people of random build and posture at the measured places, seen by
a detector of the kind that `synthetic/detections.py` describes; the bodies come from `synthetic/bodies.py` and share
nothing with the method that is judged. As a library: `photos(folder, seed)` gives `SyntheticPhoto`s with the setting in
`kind`.
"""

from __future__ import annotations

import csv
import math
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np

from proxemetry.arrays import FloatArray
from proxemetry.camera import Camera
from proxemetry.people import People
from proxemetry.people.skeleton import COCO_17, Skeleton
from synthetic import scenes as made
from synthetic.bodies import draw_build, draw_posture, pose_joints
from synthetic.detections import Detector, detect

Rng = np.random.Generator
#: Body of one person in the body frame: joint name -> (3,), metres; and the stature. Arguments: rng, seated.
DrawBody = Callable[[Rng, bool], tuple[dict[str, FloatArray], float]]

TRIPOD_M, BALCONY_M = 1.35, 3.65
_BALCONY = ("0", "C2")
_INDOORS = "1"


def drawn_body(rng: Rng, seated: bool) -> tuple[dict[str, FloatArray], float]:
    """Draw an adult of the synthetic population."""
    build = draw_build(rng)
    return pose_joints(build, draw_posture(rng, seated)), build.stature


def settings(labels: Path) -> list[tuple[str, str, str, int, int, float]]:
    """Return filename, shoot, camera, width, height, focal length in mm of every photo."""
    with (labels / "focal_lengths_recovered.csv").open() as file:
        return [
            (r["filename"], r["photoshoot"], r["camera"], int(r["image_width_px"]), int(r["image_height_px"]),
             float(r["focal_length_mm"]))
            for r in csv.DictReader(file)
        ]  # fmt: skip


def photos(
    labels: Path, seed: int = 0, *, detector: Detector | None = None, body: DrawBody = drawn_body,
    skeleton: Skeleton = COCO_17,
) -> Iterator[made.SyntheticPhoto]:  # fmt: skip
    """Yield every photo of the benchmark that shows two people or more, once."""
    places = _places(labels)
    marked = _marked(labels)
    for number, (name, shoot, camera_tag, width, height, focal_mm) in enumerate(settings(labels)):
        rng = np.random.default_rng([seed, number])
        camera = Camera.centred(width * focal_mm / 36.0, width, height)
        view, people = _aim(marked[name], places[shoot], camera_tag, camera, shoot)
        if len(people) >= 2:
            yield _photo(rng, name, camera, focal_mm, view, people, shoot == _INDOORS, detector, body, skeleton)


def _places(labels: Path) -> dict[str, dict[str, FloatArray]]:
    """Return shoot -> tag -> (x, z) in metres."""
    answer: dict[str, dict[str, FloatArray]] = {}
    for shoot, tag, x, _, z in csv.reader((labels / "ground_truth_locations.csv").read_text().splitlines()):
        answer.setdefault(shoot, {})[tag] = np.array([float(x), float(z)]) / 1000
    return answer


def _marked(labels: Path) -> dict[str, dict[str, FloatArray]]:
    """Return filename -> person -> the mean of the pixels marked on them."""
    points: dict[str, dict[str, list[tuple[float, float]]]] = {}
    for person, _, u, v, name, *_ in csv.reader((labels / "body_pixel_locations.csv").read_text().splitlines()):
        points.setdefault(name, {}).setdefault(person, []).append((float(u), float(v)))
    return {n: {p: np.mean(marks, axis=0) for p, marks in people.items()} for n, people in points.items()}


def _aim(
    marked: dict[str, FloatArray], places: dict[str, FloatArray], tag: str, camera: Camera, shoot: str
) -> tuple[made._View, FloatArray]:
    """Turn the camera so that the people come out about where they were marked; return (P, 2) floor places, x and z."""
    tags = [person for person in sorted(marked) if person in places]
    pixels = np.array([marked[person] for person in tags]).reshape(-1, 2)
    offsets = np.array([places[person] - places[tag] for person in tags]).reshape(-1, 2)
    # the ground truth's axes are right-handed seen from below: try both ways round and keep the one that fits
    answers: list[tuple[float, FloatArray]] = []
    for mirror in (1.0, -1.0):
        across, along = offsets[:, 0] * mirror, offsets[:, 1]
        bearing = np.arctan2(across, along) - np.arctan((pixels[:, 0] - camera.cx) / camera.f_px)
        yaw = math.atan2(np.sin(bearing).mean(), np.cos(bearing).mean())
        c, s = math.cos(yaw), math.sin(yaw)
        turned = np.stack([across * c - along * s, across * s + along * c], axis=1)
        answers.append((float(np.abs(np.angle(np.exp(1j * (bearing - yaw)))).max(initial=0.0)), turned))
    floor = min(answers, key=lambda a: a[0])[1]
    height_m = BALCONY_M if (shoot, tag) == _BALCONY else TRIPOD_M
    chest = 0.85 if shoot == _INDOORS else 1.35
    fall = np.arctan2(height_m - chest, np.hypot(*floor.T)) - np.arctan((pixels[:, 1] - camera.cy) / camera.f_px)
    return made._View(height_m, float(fall.mean()) if len(fall) else 0.0, 0.0, 0.0, np.zeros(2), 0.0), floor


def _photo(
    rng: Rng, name: str, camera: Camera, focal_mm: float, view: made._View, floor: FloatArray, seated: bool,
    detector: Detector | None, body: DrawBody, skeleton: Skeleton,
) -> made.SyntheticPhoto:  # fmt: skip
    headings = made._headings(rng, floor)
    view = made._View(view.height_m, view.pitch_rad, math.radians(rng.normal(0, 0.5)), 0.0, view.centre, 0.0)
    bodies = [body(rng, seated) for _ in floor]
    joints = [made._to_camera(b, p, h, view) for (b, _), p, h in zip(bodies, floor, headings, strict=True)]
    seen = [made._seen(rng, camera, j, float(h), seated) for j, h in zip(joints, headings, strict=True)]
    keypoints, scores, owners = detect(rng, seen, skeleton, camera.width, camera.height, detector or Detector())
    stacked = {joint: np.array([j[joint] for j in joints]) for joint in joints[0]}
    positions = (stacked["neck"] + stacked["mid_hip"]) / 2
    count = len(floor)
    kind = "seated" if seated else "elevated" if view.height_m > 3 else "standing"
    return made.SyntheticPhoto(
        name, kind, camera, focal_mm, view.height_m, view.pitch_rad, view.roll_rad,
        People(skeleton, keypoints, scores), np.array(owners, dtype=np.intp), stacked, positions,
        (positions @ view.rotation)[:, [0, 2]] * 1000, view.up, headings, np.array([s for _, s in bodies]),
        np.full(count, seated), np.zeros(count, dtype=bool), made._parts(camera, stacked, seen),
    )  # fmt: skip
