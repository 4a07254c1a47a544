"""People drawn from the joint fit's own body model on one floor: photos whose answer is known."""

import numpy as np

from proxemetry.arrays import FloatArray
from proxemetry.camera import Camera
from proxemetry.locate import LocateSettings
from proxemetry.locate.scenefit import projection as p
from proxemetry.locate.scenefit.body_model import body_model
from proxemetry.locate.scenefit.body_tables import LATENTS
from proxemetry.people import People
from proxemetry.people.skeleton import COCO_17

CAMERA = Camera.centred(1200, 1920, 1080)
ADULTS = LocateSettings(body_size="adults")
LENGTHS_M = [1.70, 1.36, 0.51, 0.345, 0.063, 0.15]


def camera_above(height_m: float, pitch_rad: float) -> FloatArray:
    """Return the shared unknowns (N_SHARED,) of a camera of known intrinsics without roll."""
    shared = np.zeros(p.N_SHARED)
    shared[p.PITCH], shared[p.HEIGHT] = pitch_rad, np.log(height_m)
    return shared


def on_floor(local: FloatArray, shared: FloatArray, sole_m: FloatArray | float = 0.0) -> tuple[FloatArray, FloatArray]:
    """Return standing people whose soles are so far above the floor, (P, N_LOCAL), and their joints (P, K, 2).

    The torso's point is moved up or down by Newton's method; joints are in focal lengths from the principal point.
    """
    local = local.copy()
    bodies = p.BodyTables.of(body_model(COCO_17), np.zeros(len(local), dtype=np.intp))
    for _ in range(6):
        seen = p.project(local, shared, bodies)
        local[:, 1] -= (seen.floor - sole_m) / seen.equations[:, -1, 1]
    return local, p.project(local, shared, bodies).points.transpose(0, 2, 1)


def people_of(joints: FloatArray, camera: Camera = CAMERA, score: float = 0.9) -> People:
    """Return the people whose joints of the body model these are, (P, K, 2), in pixels of a camera."""
    model = body_model(COCO_17)
    keypoints = np.full((len(joints), len(COCO_17), 2), np.nan)
    keypoints[:, model.columns] = joints * camera.f_px + (camera.cx, camera.cy)
    return People(COCO_17, keypoints, np.isfinite(keypoints).all(axis=-1) * score)


def photo(seed, count=4, noise_px=1.5, pitch=0.05, height_m=1.6, camera=CAMERA, depths_m=(4, 9)):
    """Return people drawn from the body model itself on one floor, with their positions."""
    rng = np.random.default_rng(seed)
    local = np.zeros((count, p.N_LOCAL))
    local[:, p.LOG_LENGTHS] = np.log(LENGTHS_M) + rng.normal(0, 0.03, (count, 1))
    local[:, p.HEADING] = rng.uniform(-1, 1, count)
    local[:, p.POSTURE] = rng.normal(0, 0.01, (count, len(LATENTS)))
    local[:, p.DEPTH] = np.log(rng.uniform(*depths_m, count))
    local[:, 0] = np.linspace(-0.5, 0.5, count) + rng.normal(0, 0.02, count)
    shared = camera_above(height_m, pitch)
    local, joints = on_floor(local, shared)
    return people_of(joints + rng.normal(0, noise_px, joints.shape) / camera.f_px, camera), p.torso_position(
        local, shared
    )
