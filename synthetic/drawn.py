"""People drawn as keypoints: a stick figure of known size at a known place, seen by a known camera."""

import numpy as np

from proxemetry.camera import Camera
from proxemetry.people import People
from proxemetry.people.skeleton import COCO_17, Skeleton

#: Joints of a standing figure in metres from the middle of its torso: x to the photo's right, y down. It faces the
#: camera, so the left side is on the right. The torso is 444 mm, the shoulders 389 mm and the pupils 63 mm: the
#: constants of Seker et al. 2021, so that their estimators place the figure exactly.
FIGURE_M = {
    "nose": (0.0, -0.42), "left_eye": (0.0315, -0.45), "right_eye": (-0.0315, -0.45), "left_ear": (0.07, -0.44),
    "right_ear": (-0.07, -0.44), "left_shoulder": (0.1945, -0.222), "right_shoulder": (-0.1945, -0.222),
    "left_elbow": (0.24, 0.05), "right_elbow": (-0.24, 0.05), "left_wrist": (0.25, 0.28), "right_wrist": (-0.25, 0.28),
    "left_hip": (0.09, 0.222), "right_hip": (-0.09, 0.222), "left_knee": (0.1, 0.65), "right_knee": (-0.1, 0.65),
    "left_ankle": (0.1, 1.05), "right_ankle": (-0.1, 1.05), "neck": (0.0, -0.222), "mid_hip": (0.0, 0.222),
}  # fmt: skip


def people_at(places_m: list[tuple[float, float, float]], camera: Camera, skeleton: Skeleton = COCO_17) -> People:
    """Return figures whose torsos' middles are at these places of the camera frame."""
    keypoints = np.full((len(places_m), len(skeleton), 2), np.nan)
    for i, place in enumerate(places_m):
        for k, joint in enumerate(skeleton.joints):
            if joint in FIGURE_M:
                keypoints[i, k] = camera.project(np.add(place, (*FIGURE_M[joint], 0.0)))
    return People(skeleton, keypoints, np.isfinite(keypoints).all(axis=-1).astype(float))
