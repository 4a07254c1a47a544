"""What a pose detector would answer for bodies whose joints are known: noise, occlusion, cropping, misses.

Noise follows the spread of human annotators per joint (the sigmas of the COCO keypoint score) times the square root
of the person's box area; good detectors reach about a third of it on sharp photos. Joints behind other people, behind a
table or on the far side of the own body are shakier and score lower; joints outside the picture are missing.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from proxemetry.arrays import FloatArray
from proxemetry.people.skeleton import Skeleton

Rng = np.random.Generator

_SIGMAS = {
    "nose": 0.026, "eye": 0.025, "ear": 0.035, "mouth": 0.026, "head": 0.035, "eyes_centre": 0.025, "neck": 0.06,
    "shoulder": 0.079, "elbow": 0.072, "wrist": 0.062, "mid_hip": 0.085, "hip": 0.107, "knee": 0.087,
    "ankle": 0.089, "toe": 0.068, "heel": 0.066, "pinky": 0.06, "index": 0.06, "thumb": 0.06,
}  # fmt: skip
_FACE = ("nose", "eye", "mouth")


@dataclass(frozen=True)
class Detector:
    """How well keypoints are found.

    noise: in units of the annotators' spread (0 gives exact keypoints). outliers: share of joints that land far off.
    miss_rate: share of people not found at all. duplicate_rate: share of people found twice. occlusion: whether
    joints hide behind people, tables and their own body. floor_px: what no detector goes below.
    """

    noise: float = 0.3
    outliers: float = 0.02
    miss_rate: float = 0.03
    duplicate_rate: float = 0.0
    occlusion: bool = True
    floor_px: float = 0.5


EXACT = Detector(noise=0.0, outliers=0.0, miss_rate=0.0, occlusion=False, floor_px=0.0)


@dataclass(frozen=True)
class Seen:
    """One person as the camera has them: pixels and depth per joint name, how they face, and what hides them.

    pixels: name -> (u, v). depth_m: of the torso. away: facing direction times viewing direction, 1 = seen from
    behind; for the body and for the head. table_v_px: below this row a table hides the legs.
    """

    pixels: dict[str, FloatArray]
    depth_m: float
    body_away: float
    head_away: float
    left_is_far: bool
    table_v_px: float = float("inf")


def detect(
    rng: Rng, people: list[Seen], skeleton: Skeleton, width: int, height: int, detector: Detector
) -> tuple[FloatArray, FloatArray, list[int]]:
    """Return keypoints of shape (D, K, 2), scores of shape (D, K), and for each detection whom it shows."""
    keypoints, scores, owners = [], [], []
    hidden_by_others = _hidden_by_others(people, skeleton)
    for k, person in enumerate(people):
        if rng.random() < detector.miss_rate:
            continue
        for _ in range(1 + (rng.random() < detector.duplicate_rate)):
            points, score = _one(rng, person, hidden_by_others[k], skeleton, detector)
            inside = ((points >= 0) & (points < (width, height))).all(axis=1)
            points[~inside], score[~inside] = np.nan, 0.0
            if (score > 0).sum() >= min(4, len(skeleton)):
                keypoints.append(points)
                scores.append(score)
                owners.append(k)
    count, joints = len(owners), len(skeleton)
    return np.array(keypoints).reshape(count, joints, 2), np.array(scores).reshape(count, joints), owners


def _one(
    rng: Rng, person: Seen, hidden: NDArray[np.bool_], skeleton: Skeleton, detector: Detector
) -> tuple[FloatArray, FloatArray]:
    exact = np.array([person.pixels[joint] for joint in skeleton.joints])
    span = np.nanmax(exact, axis=0) - np.nanmin(exact, axis=0)
    size = float(np.sqrt(max(span[0], 0.25 * span[1]) * span[1]))
    sigma = np.array([_sigma(joint) for joint in skeleton.joints])
    spread = np.hypot(detector.noise * sigma * size, detector.floor_px)
    shaky = np.ones(len(exact))
    score = np.clip(rng.normal(0.88, 0.06, len(exact)), 0.5, 0.99)
    if detector.occlusion:
        # Detectors guess the far side of a body well, for they see the near one; what others hide is often left out.
        far = _own_body_hides(rng, person, skeleton)
        shaky[far] = 1.8
        score[far] = np.clip(rng.normal(0.55, 0.15, far.sum()), 0.1, 0.85)
        score[far & (rng.random(len(exact)) < 0.1)] = 0.0
        below = hidden | (exact[:, 1] > person.table_v_px)
        shaky[below] = 2.5
        score[below] = np.clip(rng.normal(0.35, 0.15, below.sum()), 0.05, 0.7)
        score[below & (rng.random(len(exact)) < 0.5)] = 0.0
        if person.head_away > 0.3:  # a face seen from behind is not there at all
            face = np.array([any(part in joint for part in _FACE) for joint in skeleton.joints])
            score[face & (rng.random(len(exact)) < 0.9)] = 0.0
    shaky[rng.random(len(exact)) < detector.outliers] = 8.0
    points = exact + rng.standard_normal(exact.shape) * (spread * shaky)[:, None]
    if detector.occlusion and person.body_away > 0.5 and rng.random() < 0.03:
        points, score = points[list(skeleton.mirror)], score[list(skeleton.mirror)]  # taken for a front view
    points[(score == 0) | ~np.isfinite(points).all(axis=1)] = np.nan
    score[~np.isfinite(points).all(axis=1)] = 0.0
    return points, score


def _sigma(joint: str) -> float:
    return next(value for part, value in _SIGMAS.items() if part in joint)


def _own_body_hides(rng: Rng, person: Seen, skeleton: Skeleton) -> NDArray[np.bool_]:
    """In profile the far arm, hip and ear are behind the body."""
    profile = 1 - abs(person.body_away)
    far = "left" if person.left_is_far else "right"
    at_risk = np.array([joint.startswith(far) for joint in skeleton.joints])
    return at_risk & (rng.random(len(at_risk)) < 0.6 * profile**2)


def _hidden_by_others(people: list[Seen], skeleton: Skeleton) -> list[NDArray[np.bool_]]:
    """A joint is hidden where a nearer person's trunk and thighs, as an upright box, lie before it."""
    boxes = []
    for other in people:
        trunk = np.array([
            other.pixels[f"{side}_{part}"] for side in ("left", "right") for part in ("shoulder", "hip", "knee")
        ])  # fmt: skip
        head = other.pixels["head_top"]
        boxes.append((*np.nanmin(trunk, axis=0), *np.nanmax(trunk, axis=0), head[1]))
    answer = []
    for person in people:
        points = np.array([person.pixels[joint] for joint in skeleton.joints])
        hidden = np.zeros(len(points), dtype=bool)
        for other, (u0, _, u1, v1, top) in zip(people, boxes, strict=True):
            if other.depth_m < person.depth_m - 0.2:
                hidden |= (points[:, 0] > u0) & (points[:, 0] < u1) & (points[:, 1] > top) & (points[:, 1] < v1)
        answer.append(hidden)
    return answer
