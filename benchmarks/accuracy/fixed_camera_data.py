"""Fixed cameras with truth: a clip whose people stand at measured places, and seven calibrated cameras of one square.

PETS 2009 S2.L1 view 1 (`vtest.avi` of OpenCV): boxes of its people with places on the floor and Tsai's calibration.
WILDTRACK: calibrations of OpenCV's form for undistorted pictures, and where people stood.
"""

from __future__ import annotations

import csv
import math
import re
import xml.etree.ElementTree as ElementTree
from collections import defaultdict
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from proxemetry.arrays import FloatArray
from proxemetry.camera import Camera, FloorFrame, Mount
from proxemetry.overlap import pairwise_iou
from proxemetry.people import People
from proxemetry.photo import Photo
from proxemetry.pose import backend_named

#: A detection shows the person of a box of the truth that it overlaps by this much.
LEAST_OVERLAP = 0.4
#: What is taken for exact: the calibrations' own errors are not stated.
_EXACT_RAD, _EXACT_REL = 1e-4, 1e-4


@dataclass(frozen=True, eq=False)
class FixedCamera:
    """A calibrated camera over a level floor.

    rotation: shape (3, 3), from the floor's frame (x, y, up) to the camera's. place_m: shape (3,), of the camera.
    """

    camera: Camera
    rotation: FloatArray
    place_m: FloatArray

    @property
    def mount(self) -> Mount:
        """Where the camera is, as good as exactly."""
        up = self.rotation[:, 2]
        pitch, roll = math.asin(-up[2]), math.atan2(up[0], -up[1])
        right = self.rotation.T @ (math.cos(roll), math.sin(roll), 0.0)
        frame = FloorFrame(self.place_m[0], self.place_m[1], math.atan2(right[1], right[0]))
        stated = Mount.stated(
            pitch, roll, self.place_m[2], pitch_sd_rad=_EXACT_RAD, roll_sd_rad=_EXACT_RAD,
            height_sd_m=_EXACT_REL * self.place_m[2], camera=self.camera, source="calibration",
        )  # fmt: skip
        return Mount(
            stated.pitch_rad, stated.roll_rad, stated.height_m, stated.covariance, self.camera, source="calibration",
            floor_frame=frame,
        )  # fmt: skip

    def project(self, points_m: FloatArray) -> FloatArray:
        """Return pixels (..., 2) of points (..., 3) of the floor's frame."""
        return self.camera.project((np.asarray(points_m) - self.place_m) @ self.rotation.T)


@dataclass(frozen=True, eq=False)
class Frame:
    """The people of one frame: detections, and of each the row of the truth that it shows, or -1.

    persons: shape (Q,), who. floor_m: shape (Q, 2), where they stand.
    """

    number: int
    people: People
    owners: NDArray[np.intp]
    persons: NDArray[np.intp]
    floor_m: FloatArray


def pets_camera(path: Path) -> FixedCamera:
    """Read Tsai's calibration; the slight bend of its lens (half a pixel at the corners) is left out."""
    root = ElementTree.parse(path).getroot()
    part: dict[str, dict[str, float]] = {c.tag: {k: float(v) for k, v in c.attrib.items()} for c in root}
    geometry, lens, place = part["Geometry"], part["Intrinsic"], part["Extrinsic"]
    camera = Camera(
        lens["focal"] * lens["sx"] / geometry["dpx"], lens["focal"] / geometry["dpy"], lens["cx"], lens["cy"],
        int(geometry["width"]), int(geometry["height"]),
    )  # fmt: skip
    rotation = _about("z", place["rz"]) @ _about("y", place["ry"]) @ _about("x", place["rx"])
    shift = np.array([place["tx"], place["ty"], place["tz"]]) / 1000
    return FixedCamera(camera, rotation, -rotation.T @ shift)


def _about(axis: str, angle: float) -> FloatArray:
    c, s = math.cos(angle), math.sin(angle)
    return np.array({
        "x": [[1, 0, 0], [0, c, -s], [0, s, c]], "y": [[c, 0, s], [0, 1, 0], [-s, 0, c]],
        "z": [[c, -s, 0], [s, c, 0], [0, 0, 1]],
    }[axis])  # fmt: skip


def pets_frames(folder: Path, detect: Callable[[int], People]) -> list[Frame]:
    """Return the frames that the truth is about, every second one, with what `detect` gives for a frame's number."""
    truth: dict[int, list[Mapping[str, Any]]] = defaultdict(list)
    with (folder / "truth_frames_0-399.csv").open() as file:
        for row in csv.DictReader(file):
            truth[int(row["frame"])].append(row)
    frames: list[Frame] = []
    for number in sorted(truth):
        if number % 2:
            continue
        rows, people = truth[number], detect(number)
        boxes = np.array([[float(r[f"box_{k}"]) for k in ("x0", "y0", "x1", "y1")] for r in rows])
        floor = np.array([[float(r["x_m"]), float(r["y_m"])] for r in rows])
        frames.append(Frame(number, people, _owners(people, boxes), np.array([int(r["person"]) for r in rows]), floor))
    return frames


def _owners(people: People, boxes_px: FloatArray) -> NDArray[np.intp]:
    """Return the box that each detection shows, the best overlap first, one to one."""
    owners = np.full(len(people), -1)
    overlap = np.nan_to_num(pairwise_iou(people.boxes_px, boxes_px))
    while overlap.size and overlap.max() >= LEAST_OVERLAP:
        row, box = np.unravel_index(overlap.argmax(), overlap.shape)
        owners[row] = box
        overlap[row], overlap[:, box] = 0.0, 0.0
    return owners


def recorded_detector(path: Path) -> Callable[[int], People]:
    """Return a detector of frames by number that replays a keypoint file whose photos are `frame_000012.jpg`."""
    backend = backend_named(f"recorded:{path}")
    return lambda number: backend.detect(Photo(f"frame_{number:06d}.jpg", 768, 576, ""))


def clip_detector(path: Path, pose: str) -> Callable[[int], People]:
    """Return a detector of a clip's frames, to be asked for them in rising order."""
    import cv2

    backend, capture, at = backend_named(pose), cv2.VideoCapture(str(path)), [0]

    def detect(number: int) -> People:
        while at[0] < number:
            capture.grab()
            at[0] += 1
        at[0] += 1
        pixels = np.ascontiguousarray(capture.read()[1][:, :, ::-1])
        return backend.detect(Photo.from_array(pixels, f"frame_{number:06d}.jpg"))

    return detect


WILDTRACK_CAMERAS = ("CVLab1", "CVLab2", "CVLab3", "CVLab4", "IDIAP1", "IDIAP2", "IDIAP3")


def wildtrack_camera(folder: Path, name: str) -> FixedCamera:
    """Read one of the seven calibrations, of undistorted pictures of 1920 x 1080 pixels; centimetres become metres."""
    inside = _numbers(folder / "calibrations" / "intrinsic_zero" / f"intr_{name}.xml", "data")
    outside = folder / "calibrations" / "extrinsic" / f"extr_{name}.xml"
    import cv2

    rotation = np.asarray(cv2.Rodrigues(_numbers(outside, "rvec"))[0])
    camera = Camera(inside[0], inside[4], inside[2], inside[5], 1920, 1080)
    return FixedCamera(camera, rotation, -rotation.T @ _numbers(outside, "tvec") / 100)


def _numbers(path: Path, tag: str) -> FloatArray:
    found = re.search(rf"<{tag}>(.*?)</{tag}>", path.read_text(), re.DOTALL)
    assert found is not None
    return np.array(found[1].split(), dtype=float)


def wildtrack_people(folder: Path) -> dict[int, tuple[NDArray[np.intp], FloatArray]]:
    """Return frame -> who and where on the floor, shapes (Q,) and (Q, 2)."""
    rows = np.loadtxt(folder / "positions.csv", delimiter=",", skiprows=1)
    return {
        int(frame): (rows[rows[:, 0] == frame, 1].astype(int), rows[rows[:, 0] == frame, 2:])
        for frame in np.unique(rows[:, 0])
    }
