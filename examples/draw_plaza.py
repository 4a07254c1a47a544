"""Draw the example photo: six people at known places of a plaza, as a camera 1.6 m above the ground sees them.

    python examples/draw_plaza.py

writes plaza.jpg (with the EXIF of a 35 mm lens), plaza.json (the joints that a pose back end would find) and
plaza_truth.csv (where everybody stands) beside this file. Nobody in it is real, so that it may be shown.
"""

import csv
import json
import math
from pathlib import Path

import cv2
import numpy as np
from PIL import Image

from proxemetry.camera import Camera
from proxemetry.people.skeleton import COCO_17

HERE = Path(__file__).parent
WIDTH, HEIGHT = 1600, 1068
FOCAL_35MM = 35
CAMERA = Camera.centred(FOCAL_35MM * math.hypot(WIDTH, HEIGHT) / 43.267, WIDTH, HEIGHT)
CAMERA_HEIGHT_M, PITCH_RAD = 1.6, math.radians(4)

#: Where people stand (to the right and ahead of the camera, metres), heading in degrees, stature, clothes' colours.
PEOPLE = (
    (-1.55, 5.2, 75, 1.72, (176, 84, 62), (52, 58, 78)),
    (-0.55, 5.6, -70, 1.65, (232, 190, 96), (84, 92, 110)),
    (1.35, 6.4, 20, 1.81, (70, 116, 140), (46, 46, 52)),
    (2.35, 9.0, -35, 1.69, (150, 160, 120), (90, 74, 66)),
    (-2.9, 11.5, 160, 1.76, (120, 96, 140), (60, 64, 80)),
    (0.6, 14.0, 0, 1.62, (206, 120, 120), (70, 76, 92)),
)
SKIN, HAIR = (222, 178, 148), (74, 56, 46)

#: Joints of a person 1.70 m tall: to the left, up from the ground, forward; metres.
JOINTS_M = {
    "nose": (0, 1.56, 0.11), "left_eye": (0.0315, 1.60, 0.09), "right_eye": (-0.0315, 1.60, 0.09),
    "left_ear": (0.075, 1.575, 0.0), "right_ear": (-0.075, 1.575, 0.0), "left_shoulder": (0.175, 1.40, 0.0),
    "right_shoulder": (-0.175, 1.40, 0.0), "left_elbow": (0.23, 1.12, 0.02), "right_elbow": (-0.23, 1.12, 0.02),
    "left_wrist": (0.21, 0.90, 0.14), "right_wrist": (-0.21, 0.90, 0.14), "left_hip": (0.09, 0.90, 0.0),
    "right_hip": (-0.09, 0.90, 0.0), "left_knee": (0.10, 0.49, 0.03), "right_knee": (-0.10, 0.49, 0.03),
    "left_ankle": (0.10, 0.08, -0.02), "right_ankle": (-0.10, 0.08, -0.02),
}  # fmt: skip
LIMBS = (  # joints, thickness in metres, what it is
    ("left_hip", "left_knee", 0.15, "legs"), ("left_knee", "left_ankle", 0.11, "legs"),
    ("right_hip", "right_knee", 0.15, "legs"), ("right_knee", "right_ankle", 0.11, "legs"),
    ("left_shoulder", "left_elbow", 0.10, "top"), ("left_elbow", "left_wrist", 0.08, "skin"),
    ("right_shoulder", "right_elbow", 0.10, "top"), ("right_elbow", "right_wrist", 0.08, "skin"),
)  # fmt: skip


def in_camera(right_m, up_m, ahead_m):
    """Turn ground coordinates (right, above the ground, ahead) into the camera frame of the pitched camera."""
    down, (sine, cosine) = CAMERA_HEIGHT_M - np.asarray(up_m), (math.sin(PITCH_RAD), math.cos(PITCH_RAD))
    ahead = np.asarray(ahead_m)
    return np.stack(np.broadcast_arrays(right_m, down * cosine - ahead * sine, down * sine + ahead * cosine), axis=-1)


def joints_of(person):
    """Return the joints of one person in the camera frame, by name."""
    x, z, heading_deg, stature, *_ = person
    h, scale = math.radians(heading_deg), stature / 1.70
    placed = {}
    for name, (left, up, front) in JOINTS_M.items():
        # Heading 0 faces the camera: the person's left is the photo's right, the front points back at us.
        right = left * math.cos(h) + front * math.sin(h)
        ahead = left * math.sin(h) - front * math.cos(h)
        placed[name] = in_camera(x + right * scale, up * scale, z + ahead * scale)
    return placed


def draw_ground(canvas):
    """Paint sky, far walls and paving whose slabs are one metre."""
    rows = np.linspace(0, 1, HEIGHT)[:, None, None]
    canvas[:] = (np.array([236, 240, 244]) * (1 - rows) + np.array([214, 222, 228]) * rows).astype(np.uint8)
    horizon = int(CAMERA.project(in_camera(0.0, 0.0, 1e6))[1])
    for x0, x1, top, shade in ((0, 380, 250, 206), (360, 720, 330, 196), (980, 1320, 300, 200), (1290, 1600, 210, 210)):
        cv2.rectangle(canvas, (x0, horizon - top), (x1, horizon), (shade, shade - 4, shade - 12), -1)
        for u in range(x0 + 30, x1 - 40, 62):
            for v in range(horizon - top + 30, horizon - 40, 74):
                cv2.rectangle(canvas, (u, v), (u + 26, v + 40), (shade - 26, shade - 22, shade - 18), -1)
    canvas[horizon:] = (198, 192, 184)
    for a in range(-40, 41):
        polyline(canvas, in_camera(float(a), 0.0, np.geomspace(2, 80, 60)), (182, 176, 168))
    for b in range(2, 80):
        polyline(canvas, in_camera(np.linspace(-40, 40, 60), 0.0, float(b)), (182, 176, 168))


def polyline(canvas, points_m, colour):
    """Draw a line through points of the camera frame."""
    pixels = np.round(CAMERA.project(points_m) * 16).astype(np.int32)
    cv2.polylines(canvas, [pixels], False, colour, 1, cv2.LINE_AA, 4)


def draw_person(canvas, person):
    """Paint one person: a shadow, limbs as capsules, a torso, a head with hair towards the back."""
    x, z, heading_deg, _stature, top, legs = person
    colours = {"top": top, "legs": legs, "skin": SKIN}
    joints = joints_of(person)
    scale_px = CAMERA.f_px / joints["left_hip"][2]
    spot = CAMERA.project(in_camera(x, 0.0, z))
    cv2.ellipse(canvas, pixel(spot), (int(0.34 * scale_px), int(0.07 * scale_px)), 0, 0, 360, (168, 162, 156), -1, 16)
    for a, b, thickness, kind in sorted(LIMBS, key=lambda limb: -joints[limb[0]][2]):
        cv2.line(canvas, pixel(CAMERA.project(joints[a])), pixel(CAMERA.project(joints[b])), colours[kind],
                 max(2, int(thickness * scale_px)), cv2.LINE_AA)  # fmt: skip
    corners = ("left_shoulder", "right_shoulder", "right_hip", "left_hip")
    hull = cv2.convexHull(np.array([pixel(CAMERA.project(joints[j])) for j in corners]))
    cv2.fillConvexPoly(canvas, hull, top, cv2.LINE_AA)
    cv2.polylines(canvas, [hull], True, top, max(2, int(0.13 * scale_px)), cv2.LINE_AA)
    neck, ears = (
        (joints["left_shoulder"] + joints["right_shoulder"]) / 2,
        (joints["left_ear"] + joints["right_ear"]) / 2,
    )
    head = ears + (neck - ears) * 0.02
    cv2.line(canvas, pixel(CAMERA.project(neck)), pixel(CAMERA.project(ears)), SKIN, max(2, int(0.10 * scale_px)), 16)
    size = (int(0.085 * scale_px), int(0.115 * scale_px))
    cv2.ellipse(canvas, pixel(CAMERA.project(head)), size, 0, 0, 360, HAIR, -1, cv2.LINE_AA)
    if math.cos(math.radians(heading_deg)) > -0.2:
        face = head + (joints["nose"] - ears) * 0.45 + (neck - ears) * 0.12
        cv2.ellipse(
            canvas, pixel(CAMERA.project(face)), (int(size[0] * 0.82), int(size[1] * 0.8)), 0, 0, 360, SKIN, -1, 16
        )


def pixel(point):
    """Round pixel coordinates for drawing."""
    return tuple(round(v) for v in point)


def detected(person):
    """Return the person's joints as a detector gives them: pixels and a score, lower where the body hides a joint."""
    joints, middle = joints_of(person), in_camera(person[0], 1.2, person[1])
    keypoints = []
    for name in COCO_17.joints:
        hidden = name in ("nose", "left_eye", "right_eye") and math.cos(math.radians(person[2])) < -0.2
        behind = joints[name][2] > middle[2] + 0.06
        u, v = CAMERA.project(joints[name])
        keypoints.append([round(float(u), 1), round(float(v), 1), 0.0 if hidden else 0.6 if behind else 0.9])
    return {"keypoints": keypoints, "score": 0.9}


def main():
    """Write the photo, its keypoints and the truth."""
    canvas = np.zeros((HEIGHT, WIDTH, 3), np.uint8)
    draw_ground(canvas)
    for person in sorted(PEOPLE, key=lambda p: -p[1]):
        draw_person(canvas, person)
    exif = Image.Exif()
    exif[0x010F], exif[0x0110] = "proxemetry", "drawn"
    exif.get_ifd(0x8769)[0xA405] = FOCAL_35MM
    Image.fromarray(canvas).save(HERE / "plaza.jpg", quality=90, exif=exif)
    image = {"filename": "plaza.jpg", "width": WIDTH, "height": HEIGHT, "people": [detected(p) for p in PEOPLE]}
    (HERE / "plaza.json").write_text(json.dumps({"skeleton": "coco17", "images": [image]}, indent=1) + "\n")
    with (HERE / "plaza_truth.csv").open("w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(["person", "right_m", "ahead_m"])
        writer.writerows([i, p[0], p[1]] for i, p in enumerate(PEOPLE))


if __name__ == "__main__":
    main()
