"""A body as a few numbers: where a person's joints lie, given lengths, a posture class and how it is held.

The body frame has its origin in the middle of the torso (mid of neck and mid-hip) and axes forward, left, up. A joint
lies at `lengths @ C + stature * (rest + P @ w)`: linear in the body lengths of `anthropometry` and in the latent
posture `w`, so that its derivatives are the tables themselves. What belongs to the head turns with it.

Heights are ANSUR II's where it measured them (ectocanthus, tragion, lateral femoral epicondyle, lateral malleolus);
hips, knees and the widths between joints are where detectors trained on COCO place them.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray

from ..anthropometry import LENGTHS
from ..skeleton import Skeleton

FloatArray = NDArray[np.float64]

POSTURES = ("standing", "seated")
#: How likely a person is each, before any evidence.
POSTURE_WEIGHTS = (0.85, 0.15)

#: The latent posture: angles in radians, lengths in statures.
LATENTS = (
    "lean_forward", "lean_left", "nod", "head_forward", "head_down",
    "left_foot_forward", "left_foot_out", "left_foot_up",
    "right_foot_forward", "right_foot_out", "right_foot_up",
    "crouch", "slump",
)  # fmt: skip

#: Mean and standard deviation of each latent by posture. "crouch" is how much lower the torso is than with straight
#: legs, or than on a chair of mean height; "slump" how much shorter a bent back is, "head_down" a bent neck. Standing:
#: the spread of 2,502 upright frames of motion capture (mocap.cs.cmu.edu, subjects 1 to 3); seated: six people at work
#: (CMU Panoptic), rounded, and ergonomists' tables of chairs.
LATENT_PRIORS: dict[str, tuple[tuple[float, float], ...]] = {
    "standing": (
        (0.02, 0.12), (0.0, 0.07), (0.10, 0.30), (0.020, 0.022), (0.006, 0.010),
        (0.0, 0.11), (0.0, 0.035), (0.008, 0.020),
        (0.0, 0.11), (0.0, 0.035), (0.008, 0.020),
        (0.008, 0.014), (0.004, 0.006),
    ),
    "seated": (
        (0.05, 0.20), (0.0, 0.09), (0.15, 0.33), (0.035, 0.030), (0.015, 0.018),
        (0.0, 0.09), (0.0, 0.060), (0.0, 0.040),
        (0.0, 0.09), (0.0, 0.060), (0.0, 0.040),
        (0.0, 0.030), (0.020, 0.016),
    ),
}  # fmt: skip

#: What soles add below the foot, metres.
SHOE_M = 0.025

# Joint -> (forward, left, up above the shoulder line as a share of stature - shoulder height); forward and left are
# shares of the head's breadth, but the eyes' left is a share of the pupils' distance.
_FACE: dict[str, tuple[float, float, float]] = {
    "nose": (0.76, 0.0, 0.565),
    "left_eye": (0.56, 0.5, 0.665), "right_eye": (0.56, -0.5, 0.665), "eyes_centre": (0.56, 0.0, 0.665),
    "left_eye_inner": (0.58, 0.27, 0.665), "right_eye_inner": (0.58, -0.27, 0.665),
    "left_eye_outer": (0.50, 0.72, 0.665), "right_eye_outer": (0.50, -0.72, 0.665),
    "left_ear": (0.0, 0.5, 0.62), "right_ear": (0.0, -0.5, 0.62), "head_centre": (0.15, 0.0, 0.62),
    "left_mouth": (0.62, 0.16, 0.46), "right_mouth": (0.62, -0.16, 0.46), "head_top": (0.0, 0.0, 1.0),
}  # fmt: skip
_EYES = tuple(j for j in _FACE if "eye" in j)

# Left leg: (forward, left, height above the sole), in statures.
_STANDING_LEG = {
    "knee": (0.025, 0.055, 0.285), "ankle": (-0.012, 0.052, 0.047), "heel": (-0.042, 0.050, 0.020),
    "big_toe": (0.090, 0.062, 0.015), "small_toe": (0.072, 0.090, 0.015),
}  # fmt: skip
_SEATED_LEG = {
    "knee": (0.245, 0.075, 0.285), "ankle": (0.235, 0.070, 0.047), "heel": (0.205, 0.068, 0.020),
    "big_toe": (0.335, 0.080, 0.015), "small_toe": (0.318, 0.108, 0.015),
}  # fmt: skip
#: Height of the hip joints above the sole, seated on a chair of mean height, in statures.
_SEATED_HIP = 0.305
_HIP_OUT = 0.062
_FEET = ("ankle", "heel", "big_toe", "small_toe")

# How far a detected joint strays from the model, in statures: what posture the latents leave out, clothes, and the
# detector's own error. COCO's annotators disagree by these proportions (Ronchi and Perona 2017, its OKS constants).
_SPREAD = {
    "nose": 0.009, "eye": 0.008, "eye_inner": 0.009, "eye_outer": 0.009, "ear": 0.012, "eyes_centre": 0.012,
    "head_centre": 0.020, "mouth": 0.010, "head_top": 0.016, "shoulder": 0.015, "neck": 0.014, "hip": 0.022,
    "mid_hip": 0.020, "knee": 0.022, "ankle": 0.017, "heel": 0.018, "big_toe": 0.022, "small_toe": 0.024,
}  # fmt: skip

# Where a skeleton's definition differs from the table above: (forward, left, up) in statures for the left joint, and a
# factor on the spread. COCO-17 and BODY_25 share COCO's own annotations and are the table. Halpe's neck is annotated
# at the throat. BlazePose's hips lie nearer together and higher (its torso is 0.97 of COCO's). KORTE's labels are
# clicked by hand: one eye stands for both in profile, the head's middle is not the ears', the middle of the shoulders
# lies anywhere between the joints and the base of the neck 7 cm above them (half of that here, doubt and all), and the
# mid-hip is extrapolated from it and the torso's middle.
_DEFINITIONS: dict[str, dict[str, tuple[float, float, float, float]]] = {
    "halpe26": {"neck": (0.0, 0.0, 0.015, 1.3)},
    "blazepose33": {"hip": (0.0, -0.008, 0.009, 1.2), "shoulder": (0.0, 0.0, 0.0, 1.2)},
    "korte_parts": {
        "eyes_centre": (0.0, 0.0, 0.0, 1.5), "head_centre": (0.0, 0.0, 0.010, 1.25),
        "neck": (0.0, 0.0, 0.020, 2.0), "mid_hip": (0.0, 0.0, -0.020, 2.75),
    },
}  # fmt: skip


@dataclass(frozen=True, eq=False)
class BodyModel:
    """The tables of one skeleton, for the K of its keypoints that the model knows.

    columns: shape (K,), which of the skeleton's keypoints. body: shape (postures, K, 3, L), head: shape (K, 3, L), the
    joint per metre of each length, the second turning with the head. rest: shape (postures, K, 3), in statures.
    latent: shape (postures, K, 3, D), in statures. spread: shape (K,), in statures. torso: shape (postures, L) and
    torso_rest: shape (postures,), the height of the torso's middle above the sole, per metre of length and in statures.
    feet, torso_joints, shoulders, eyes, head_joints: shape (K,), which keypoints are such evidence.
    """

    columns: NDArray[np.intp]
    body: FloatArray
    head: FloatArray
    rest: FloatArray
    latent: FloatArray
    spread: FloatArray
    torso: FloatArray
    torso_rest: FloatArray
    kinds: dict[str, NDArray[np.bool_]]
    prior_mean: FloatArray
    prior_sd: FloatArray


@cache
def body_model(skeleton: Skeleton) -> BodyModel:
    """Return the tables of a skeleton's keypoints; elbows, wrists and hands tell nothing of where a person stands."""
    known = [(i, joint) for i, joint in enumerate(skeleton.joints) if _kind(joint) in _SPREAD]
    joints = [joint for _, joint in known]
    count = len(joints)
    body = np.zeros((len(POSTURES), count, 3, len(LENGTHS)))
    head = np.zeros((count, 3, len(LENGTHS)))
    rest = np.zeros((len(POSTURES), count, 3))
    latent = np.zeros((len(POSTURES), count, 3, len(LATENTS)))
    spread = np.array([_SPREAD[_kind(joint)] for joint in joints])
    for k, joint in enumerate(joints):
        for p, posture in enumerate(POSTURES):
            body[p, k], rest[p, k] = _joint(joint, posture)
            latent[p, k] = _latents(joint, posture)
        head[k] = _head(joint)
        forward, left, up, factor = _DEFINITIONS.get(skeleton.name, {}).get(_kind(joint), (0.0, 0.0, 0.0, 1.0))
        rest[:, k] += (forward, left * _side(joint), up)
        spread[k] *= factor
    priors = np.array([LATENT_PRIORS[posture] for posture in POSTURES])
    return BodyModel(
        np.array([i for i, _ in known], dtype=np.intp), body, head, rest, latent, spread, *_torso_height(),
        _evidence_kinds(joints), priors[..., 0], priors[..., 1],
    )  # fmt: skip


def _kind(joint: str) -> str:
    return joint.removeprefix("left_").removeprefix("right_")


def _side(joint: str) -> int:
    return 1 if joint.startswith("left") else -1 if joint.startswith("right") else 0


def _evidence_kinds(joints: list[str]) -> dict[str, NDArray[np.bool_]]:
    groups = {
        "feet": _FEET,
        "legs": ("knee",),
        "torso": ("hip", "mid_hip"),
        "shoulders": ("shoulder", "neck"),
        "eyes": tuple(_kind(joint) for joint in _EYES),
        "head": ("nose", "ear", "head_centre", "mouth", "head_top"),
    }
    return {name: np.array([_kind(joint) in kinds for joint in joints], dtype=bool) for name, kinds in groups.items()}


def _lengths(**factors: float) -> FloatArray:
    return np.array([factors.get(name, 0.0) for name in LENGTHS])


def _joint(joint: str, posture: str) -> tuple[FloatArray, FloatArray]:
    """Return the body part of a joint per metre of each length (3, L), and its constant part in statures (3,)."""
    table, rest = np.zeros((3, len(LENGTHS))), np.zeros(3)
    kind, side = _kind(joint), _side(joint)
    if joint in _FACE:
        share = _FACE[joint][2]
        table[2] = _lengths(torso=0.5, stature=share, shoulder_height=-share)
    elif kind in ("shoulder", "neck"):
        table[1] = _lengths(shoulders=side / 2)
        table[2] = _lengths(torso=0.5)
    elif kind in ("hip", "mid_hip"):
        rest[1] = side * _HIP_OUT
        table[2] = _lengths(torso=-0.5)
    else:
        leg = _STANDING_LEG if posture == "standing" else _SEATED_LEG
        forward, out, height = leg[kind]
        torso, torso_rest = _torso_height()
        p = POSTURES.index(posture)
        table[2] = -torso[p]
        rest[:] = (forward, side * out, height - torso_rest[p])
    return table, rest


def _head(joint: str) -> FloatArray:
    """Return the part of a joint that turns with the head, per metre of each length (3, L)."""
    table = np.zeros((3, len(LENGTHS)))
    if joint in _FACE:
        forward, left, _ = _FACE[joint]
        table[0] = _lengths(head=forward)
        table[1] = _lengths(pupils=left) if joint in _EYES else _lengths(head=left)
    return table


def _torso_height() -> tuple[FloatArray, FloatArray]:
    """Return the torso's middle above the sole: per metre of each length (postures, L), in statures (postures,)."""
    standing = _lengths(shoulder_height=1.0, torso=-0.5)
    return np.stack([standing, _lengths(torso=0.5)]), np.array([0.0, _SEATED_HIP])


_TYPICAL = np.array([1.0, 0.797, 0.31, 0.205, 0.037, 0.09])  # lengths in statures


def _latents(joint: str, posture: str) -> FloatArray:
    """Return how a joint moves with each latent (3, D), in statures per radian or per stature."""
    table = np.zeros((3, len(LATENTS)))
    kind, side = _kind(joint), _side(joint)
    body, rest = _joint(joint, posture)
    height = float(body[2] @ _TYPICAL + rest[2])
    forward = float(_head(joint)[0] @ _TYPICAL)
    table[2, LATENTS.index("slump")] = -0.5 if height > 0 else 0.5
    if kind in _FEET or kind == "knee":
        _leg_latents(table, kind, side, posture)
        return table
    # the trunk leans about its middle, the head with it
    table[0, LATENTS.index("lean_forward")] = height
    table[1, LATENTS.index("lean_left")] = height
    if joint in _FACE:
        table[0, LATENTS.index("head_forward")] = 1.0
        table[2, LATENTS.index("nod")] = -forward
        table[2, LATENTS.index("head_down")] = -1.0
    return table


def _leg_latents(table: FloatArray, kind: str, side: int, posture: str) -> None:
    share = 0.5 if kind == "knee" else 1.0
    name = "left" if side > 0 else "right"
    table[0, LATENTS.index(f"{name}_foot_forward")] = share
    table[1, LATENTS.index(f"{name}_foot_out")] = side * (1.0 if posture == "seated" else share)
    table[2, LATENTS.index(f"{name}_foot_up")] = share
    crouch = LATENTS.index("crouch")
    if posture == "standing":
        table[2, crouch] = share
        table[0, crouch] = 1.2 if kind == "knee" else 0.0  # bent legs bring the knees forward
    else:
        table[2, crouch] = 1.0
