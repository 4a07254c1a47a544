"""PETS 2009 S2.L1, view 1: the clip, the people's positions and the camera, read from the data set's own files.

The folder holds `vtest.avi` (OpenCV's copy of the clip), `truth_frames_0-399.csv` (frame, t_s, person, box_x0, box_y0,
box_x1, box_y1, x_m, y_m) and `calibration_tsai.xml`, the calibration that the data set gives.
"""

from __future__ import annotations

import csv
import xml.etree.ElementTree as ET
from collections import defaultdict
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from proxemetry.camera import Camera, FloorFrame, Mount

FRAMES_A_SECOND = 10.0


@dataclass(frozen=True, eq=False)
class Moment:
    """Who is where in one frame: ids (P,), boxes (P, 4) in pixels, places (P, 2) in metres."""

    t_s: float
    ids: np.ndarray
    boxes_px: np.ndarray
    places_m: np.ndarray


def read_truth(folder: Path) -> dict[int, Moment]:
    """Return every annotated frame by its number."""
    rows = defaultdict(list)
    with (folder / "truth_frames_0-399.csv").open() as file:
        for row in csv.DictReader(file):
            rows[int(row["frame"])].append([float(v) for k, v in row.items() if k != "frame"])
    found = {}
    for frame, values in sorted(rows.items()):
        table = np.array(values)
        found[frame] = Moment(float(table[0, 0]), table[:, 1].astype(int), table[:, 2:6], table[:, 6:8])
    return found


@dataclass(frozen=True, eq=False)
class Calibration:
    """The clip's camera: intrinsics, and world (metres, z up) to camera as x_c = rotation x_w + shift."""

    camera: Camera
    rotation: np.ndarray
    shift_m: np.ndarray

    @classmethod
    def read(cls, folder: Path) -> Calibration:
        """Return the calibration of Tsai's form (Tsai 1987); its slight radial distortion is left out."""
        root = ET.parse(folder / "calibration_tsai.xml").getroot()
        geometry, inner, outer = (root.find(n).attrib for n in ("Geometry", "Intrinsic", "Extrinsic"))
        number = lambda table, name: float(table[name])  # noqa: E731
        f = number(inner, "focal")
        camera = Camera(
            f * number(inner, "sx") / number(geometry, "dpx"), f / number(geometry, "dpy"), number(inner, "cx"),
            number(inner, "cy"), int(geometry["width"]), int(geometry["height"]),
        )  # fmt: skip
        a, b, c = (number(outer, n) for n in ("rx", "ry", "rz"))
        turn_x = np.array([[1, 0, 0], [0, np.cos(a), -np.sin(a)], [0, np.sin(a), np.cos(a)]])
        turn_y = np.array([[np.cos(b), 0, np.sin(b)], [0, 1, 0], [-np.sin(b), 0, np.cos(b)]])
        turn_z = np.array([[np.cos(c), -np.sin(c), 0], [np.sin(c), np.cos(c), 0], [0, 0, 1]])
        shift = np.array([number(outer, n) for n in ("tx", "ty", "tz")]) / 1000
        return cls(camera, turn_z @ turn_y @ turn_x, shift)

    def project(self, places_m: np.ndarray) -> np.ndarray:
        """Return where points of the floor (n, 2) are seen, pixels (n, 2)."""
        world = np.column_stack([places_m, np.zeros(len(places_m))])
        return self.camera.project(world @ self.rotation.T + self.shift_m)

    def mount(self) -> Mount:
        """Return the camera's place as exactly known, in the data set's own floor coordinates."""
        up = self.rotation[:, 2]
        pitch, roll = -np.arcsin(up[2]), np.arctan2(up[0], -up[1])
        place = -self.rotation.T @ self.shift_m
        right = np.array([1.0, 0, 0]) - up[0] * up
        right = self.rotation.T @ (right / np.linalg.norm(right))
        frame = FloorFrame(place[0], place[1], float(np.arctan2(right[1], right[0])))
        mount = Mount.stated(pitch, roll, place[2], pitch_sd_rad=1e-5, roll_sd_rad=1e-5, height_sd_m=1e-4)
        return Mount(mount.pitch_rad, mount.roll_rad, mount.height_m, mount.covariance, self.camera, floor_frame=frame)
