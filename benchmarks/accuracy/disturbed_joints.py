"""Known joints as a back end would find them: with its noise and its systematic errors on rendered people.

The noise is that of the back end's row in `keypoint_noise.toml`: the spread of each joint, more of it from above, the
floor in pixels, and an error of scale common to all joints of a person (`common`). Half of its
variance is the same for all people of a photo. A face that looks away shows no eyes and no nose, and a far ear is
hidden.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from proxemetry.arrays import FloatArray
from proxemetry.camera import Camera
from proxemetry.people import People
from proxemetry.people.keypoint_noise import NoiseLaw, law_of
from proxemetry.people.skeleton import COCO_17, kind_of

_STATURE_M = 1.7
#: What a joint scores that is seen: the median of both back ends in `calibrated_views.py` is 0.88 and 0.76.
_SCORE = 0.8
#: The share of the noise's variance that everyone in a photo has in common: assumed; three people then tell half of
#: what they would if each erred for themselves, where `alike` of the rows says a third.
_SHARED = 0.5
#: How far past the profile a face still shows nose and eyes, and its far ear, as cosines of the angle to the sight
#: line: assumed.
_FACE_SHOWS, _EAR_SHOWS = -0.2, -0.35
_NEAREST_M = 0.3
_VIEWS_DEG = (0.0, 10.0, 20.0, 30.0, 40.0, 53.0)
#: Where joints of rendered people are seen (`benchmarks/networks/from_above.py`, 54 pictures each of seeds 1 and 2):
#: downwards in the picture, and towards the same joint of the other side, percent of the stature, at `_VIEWS_DEG`.
HABITS: Mapping[str, Mapping[str, tuple[tuple[float, ...], tuple[float, ...]]]] = {
    "yolox-tinypose": {
        "nose": ((-0.6, -0.4, -0.2, 0.1, 0.2, 1.1), (0.0,) * 6),
        "eye": ((-0.5, -0.2, 0.0, 0.5, 0.5, 0.7), (0.4, 0.2, 0.5, 0.6, 0.6, 0.6)),
        "ear": ((0.1, 0.4, 0.6, 0.7, 0.7, 0.6), (0.1, -0.1, 0.3, 0.7, 1.1, 1.5)),
        "shoulder": ((0.0, 0.2, 0.0, 0.0, -0.1, 0.1), (0.1, 0.1, 0.4, 1.0, 0.8, 1.1)),
        "hip": ((-1.2, -0.9, -1.1, -0.2, 0.0, 0.9), (-0.4, -0.3, 0.0, 0.5, 0.5, 0.9)),
        "knee": ((-0.9, -0.4, -0.2, 0.2, 0.5, 2.0), (0.5, 0.5, 1.1, 1.5, 1.4, 1.6)),
        "ankle": ((-0.3, 0.1, -0.3, 0.1, 0.5, 2.0), (-0.1, 0.2, 0.7, 0.8, 0.3, 0.6)),
    },
    "nanodet-movenet": {
        "nose": ((-0.4, 0.1, -0.2, 0.1, 0.1, 0.9), (0.0,) * 6),
        "eye": ((-0.2, 0.0, 0.0, 0.3, 0.3, 0.9), (0.2, 0.8, 0.2, 0.4, 0.5, 0.5)),
        "ear": ((0.0, 0.2, 0.2, 0.5, 0.4, 0.5), (0.1, 0.1, 0.3, 1.0, 0.8, 0.8)),
        "shoulder": ((-0.4, -0.1, -0.3, -0.4, -0.5, -0.2), (0.1, 0.3, 0.2, 1.0, 1.3, 1.9)),
        "hip": ((-1.1, -1.1, -0.9, -0.6, -0.1, 1.2), (-0.2, -0.2, 0.3, 0.8, 0.8, 0.9)),
        "knee": ((-0.1, -0.7, -0.7, -0.5, 1.0, 0.9), (0.9, 0.8, 0.8, 0.9, 1.1, 1.2)),
        "ankle": ((0.5, 1.0, -0.9, -0.2, 0.7, 1.1), (0.3, 0.2, 0.5, 0.5, 0.6, 0.7)),
    },
}
_SHOULDERS = ("left_shoulder", "right_shoulder")
_ENDS = {"torso": (_SHOULDERS, ("left_hip", "right_hip")), "shoulders": (_SHOULDERS[:1], _SHOULDERS[1:])}


@dataclass(frozen=True)
class Disturbance:
    """How known joints are seen.

    source: the back end whose row the scene fit takes, and whose noise and habits these are. noise, habits: how much of
    them, 1 as they were measured.
    """

    source: str
    noise: float = 1.0
    habits: float = 0.0

    def seen(self, joints_m: FloatArray, camera: Camera, down: FloatArray, rng: np.random.Generator) -> People:
        """Return people with COCO's joints (P, 17, 3), camera frame, as seen; down: gravity's direction (3,) there."""
        exact = camera.project(joints_m.reshape(-1, 3)).reshape(*joints_m.shape[:2], 2)
        middle = np.nanmean(joints_m, axis=1)
        body_px = _STATURE_M * camera.f_px / middle[:, 2]
        sine = np.maximum(middle @ down / np.linalg.norm(middle, axis=1), 0.0)
        pixels = exact + self.habits * habit(self.source, exact, sine) * body_px[:, None, None]
        if self.noise:
            pixels = pixels + self.noise * noise_px(law_of(self.source, COCO_17.name), exact, body_px, sine, rng)
        inside = ((pixels >= 0) & (pixels < (camera.width, camera.height))).all(axis=-1)
        seen = inside & (joints_m[..., 2] > _NEAREST_M) & heads_show(joints_m)
        scores = np.where(seen, _SCORE, 0.0)
        return People(COCO_17, np.where(seen[..., None], pixels, np.nan), scores, source=self.source)


def noise_px(
    law: NoiseLaw, exact: FloatArray, body_px: FloatArray, sine: FloatArray, rng: np.random.Generator
) -> FloatArray:  # fmt: skip
    """Return errors (P, 17, 2) in pixels as a law has them, of joints at `exact`.

    body_px: shape (P,), statures in pixels; sine: shape (P,), of the angle from above.
    """
    spread = law.score_noise(COCO_17.joints, np.full(len(COCO_17), _SCORE))
    grown = spread * (1 + sine[:, None] * law.grows_from_above(COCO_17.joints)) * body_px[:, None]
    own, shared = rng.normal(size=exact.shape), rng.normal(size=(1, *exact.shape[1:]))
    errors = (np.sqrt(1 - _SHARED) * own + np.sqrt(_SHARED) * shared) * grown[..., None]
    errors += rng.normal(0, law.floor_px, exact.shape)
    for name, ends in _ENDS.items():
        longer = rng.normal(0, law.common.get(name, 0.0), len(exact))
        near, far = ([COCO_17.joints.index(joint) for joint in end] for end in ends)
        half = longer[:, None] * (exact[:, near].mean(axis=1) - exact[:, far].mean(axis=1)) / 2
        errors[:, near] += half[:, None]
        errors[:, far] -= half[:, None]
    return errors


def habit(source: str, exact: FloatArray, sine: FloatArray) -> FloatArray:
    """Return where joints at `exact` (P, 17, 2) are seen rather, in statures, at sines (P,) of the angle from above."""
    shift = np.zeros(exact.shape)
    angle = np.rad2deg(np.arcsin(np.clip(sine, 0.0, 1.0)))
    for k, joint in enumerate(COCO_17.joints):
        down, inwards = HABITS.get(source, {}).get(kind_of(joint), ((0.0,) * 6, (0.0,) * 6))
        other = exact[:, COCO_17.mirror[k]] - exact[:, k]
        unit = other / np.maximum(np.linalg.norm(other, axis=1, keepdims=True), 1e-9)
        shift[:, k] = np.interp(angle, _VIEWS_DEG, inwards)[:, None] * unit
        shift[:, k, 1] += np.interp(angle, _VIEWS_DEG, down)
    return shift / 100


def heads_show(joints_m: FloatArray) -> NDArray[np.bool_]:
    """Return which joints (P, 17) of people (P, 17, 3), camera frame, are not hidden by their own heads."""
    at = {joint: joints_m[:, k] for k, joint in enumerate(COCO_17.joints)}
    ears = (at["left_ear"] + at["right_ear"]) / 2
    to_camera = -ears / np.linalg.norm(ears, axis=1, keepdims=True)
    ahead, left = at["nose"] - ears, at["left_ear"] - at["right_ear"]
    shown = np.ones(joints_m.shape[:2], dtype=bool)
    for joint, axis, least in (
        ("nose", ahead, _FACE_SHOWS), ("left_eye", ahead, _FACE_SHOWS), ("right_eye", ahead, _FACE_SHOWS),
        ("left_ear", left, _EAR_SHOWS), ("right_ear", -left, _EAR_SHOWS),
    ):  # fmt: skip
        cosine = (axis * to_camera).sum(axis=1) / np.linalg.norm(axis, axis=1)
        shown[:, COCO_17.joints.index(joint)] = ~(cosine < least)
    return shown
