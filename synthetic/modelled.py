"""People drawn from the joint fit's own body model on one floor: photos whose answer is known."""

import numpy as np

from proxemetry.camera import Camera
from proxemetry.locate import LocateSettings
from proxemetry.locate.scenefit.body_model import body_model
from proxemetry.locate.scenefit.body_tables import LATENTS
from proxemetry.locate.scenefit.projection import (
    DEPTH,
    HEADING,
    HEIGHT,
    LOG_LENGTHS,
    N_LOCAL,
    N_SHARED,
    PITCH,
    POSTURE,
    BodyTables,
    project,
)
from proxemetry.locate.scenefit.projection import torso_position as torso_of
from proxemetry.people import People
from proxemetry.people.skeleton import COCO_17

CAMERA = Camera.centred(1200, 1920, 1080)
ADULTS = LocateSettings(body_size="adults")


def photo(seed, count=4, noise_px=1.5, pitch=0.05, height_m=1.6, camera=CAMERA, depths_m=(4, 9)):
    """Return people drawn from the body model itself on one floor, with their positions."""
    rng = np.random.default_rng(seed)
    model = body_model(COCO_17)
    local = np.zeros((count, N_LOCAL))
    local[:, LOG_LENGTHS] = np.log([1.70, 1.36, 0.51, 0.345, 0.063, 0.15]) + rng.normal(0, 0.03, (count, 1))
    local[:, HEADING] = rng.uniform(-1, 1, count)
    local[:, POSTURE] = rng.normal(0, 0.01, (count, len(LATENTS)))
    depth = rng.uniform(*depths_m, count)
    local[:, DEPTH] = np.log(depth)
    local[:, 0] = np.linspace(-0.5, 0.5, count) + rng.normal(0, 0.02, count)
    shared = np.zeros(N_SHARED)
    shared[PITCH], shared[HEIGHT] = pitch, np.log(height_m)
    # the torso's point that puts the sole on the floor, by Newton's method on its one unknown
    bodies = BodyTables.of(model, np.zeros(count, dtype=np.intp))
    for _ in range(4):
        seen = project(local, shared, bodies)
        local[:, 1] -= seen.floor / seen.equations[:, -1, 1]
    points = project(local, shared, bodies).points.transpose(0, 2, 1) * camera.f_px + (camera.cx, camera.cy)
    keypoints = np.full((count, len(COCO_17), 2), np.nan)
    keypoints[:, model.columns] = points + rng.normal(0, noise_px, points.shape)
    return People(COCO_17, keypoints, np.isfinite(keypoints).all(axis=-1) * 0.9), torso_of(local, shared)
