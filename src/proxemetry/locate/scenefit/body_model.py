"""A body as a few numbers: where a person's joints lie, given lengths, a posture class and how it is held.

The body frame has its origin in the middle of the torso (mid of neck and mid-hip) and axes forward, left, up. A joint
lies at `lengths @ C + stature * (rest + P @ w)`: linear in the body lengths of `anthropometry` and in the latent
posture `w`, so that its derivatives are the tables themselves. What belongs to the head turns with it.

A trunk that leans far (`body_tables.TRUNK_LEAN`) is turned about that middle before the latents bend it further.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray

from ...anthropometry import LENGTHS
from ...arrays import FloatArray
from ...people.skeleton import Skeleton, kind_of
from .body_tables import (
    DEFINITIONS,
    EYES,
    FACE,
    FACE_LEAN,
    FEET,
    HEADS,
    HIP_HEIGHT,
    HIP_OUT,
    LATENT_PRIORS,
    LATENTS,
    LEGS,
    LYING_HEIGHT,
    POSTURES,
    SPREAD,
    TRUNK_LEAN,
)  # fmt: skip

_CROUCH, _SLUMP, _LEAN = (LATENTS.index(name) for name in ("crouch", "slump", "lean_forward"))
_LYING = POSTURES.index("lying")


@dataclass(frozen=True, eq=False)
class BodyModel:
    """The tables of one skeleton, for the K of its keypoints that the model knows.

    columns: shape (K,), which of the skeleton's keypoints. body, head: shape (postures, K, 3, L), the joint per metre
    of each length, the second turning with the head. rest: shape (postures, K, 3), in statures.
    latent: shape (postures, K, 3, D), in statures. spread: shape (K,), in statures. torso: shape (postures, L),
    torso_rest: shape (postures,) and torso_latent: shape (postures, D), the height of the torso's middle above the
    sole, per metre of length and in statures. kinds: shape (K,) each, which keypoints are evidence of that name.
    prior_mean, prior_sd: shape (postures, D), of the latents.
    """

    columns: NDArray[np.intp]
    body: FloatArray
    head: FloatArray
    rest: FloatArray
    latent: FloatArray
    spread: FloatArray
    torso: FloatArray
    torso_rest: FloatArray
    torso_latent: FloatArray
    kinds: dict[str, NDArray[np.bool_]]
    prior_mean: FloatArray
    prior_sd: FloatArray


@cache
def body_model(skeleton: Skeleton) -> BodyModel:
    """Return the tables of a skeleton's keypoints; elbows, wrists and hands do not show where a person stands."""
    known = [(i, joint) for i, joint in enumerate(skeleton.joints) if kind_of(joint) in SPREAD]
    joints = [joint for _, joint in known]
    count = len(joints)
    body = np.zeros((len(POSTURES), count, 3, len(LENGTHS)))
    head = np.zeros((len(POSTURES), count, 3, len(LENGTHS)))
    rest = np.zeros((len(POSTURES), count, 3))
    latent = np.zeros((len(POSTURES), count, 3, len(LATENTS)))
    spread = np.array([SPREAD[kind_of(joint)] for joint in joints])
    for k, joint in enumerate(joints):
        for p in range(len(POSTURES)):
            body[p, k], rest[p, k] = _joint(joint, p)
            latent[p, k] = _latents(joint, p)
            head[p, k] = _leant(_head(joint, skeleton.name), FACE_LEAN[p])
        forward, left, up, factor = DEFINITIONS.get(skeleton.name, {}).get(kind_of(joint), (0.0, 0.0, 0.0, 1.0))
        rest[:, k] += (forward, left * _side(joint), up)
        spread[k] *= factor
    priors = np.array([LATENT_PRIORS[posture] for posture in POSTURES])
    heights = [_torso_height(p) for p in range(len(POSTURES))]
    torso, torso_rest, torso_latent = (np.array(part) for part in zip(*heights, strict=True))
    return BodyModel(
        np.array([i for i, _ in known], dtype=np.intp), body, head, rest, latent, spread, torso,
        torso_rest, torso_latent, _evidence_kinds(joints), priors[..., 0], priors[..., 1],
    )  # fmt: skip


def _side(joint: str) -> int:
    return 1 if joint.startswith("left") else -1 if joint.startswith("right") else 0


def _evidence_kinds(joints: list[str]) -> dict[str, NDArray[np.bool_]]:
    groups = {
        "feet": FEET,
        "legs": ("knee",),
        "torso": ("hip", "mid_hip"),
        "shoulders": ("shoulder", "neck"),
        "eyes": tuple(kind_of(joint) for joint in EYES),
        "head": ("nose", "ear", "head_centre", "mouth", "head_top"),
    }
    return {name: np.array([kind_of(joint) in kinds for joint in joints], dtype=bool) for name, kinds in groups.items()}


def _lengths(**factors: float) -> FloatArray:
    return np.array([factors.get(name, 0.0) for name in LENGTHS])


def _leant(table: FloatArray, lean: float) -> FloatArray:
    """Return vectors (3, ...) of forward, left, up, turned forward by an angle."""
    c, s = np.cos(lean), np.sin(lean)
    return np.stack([c * table[0] + s * table[2], table[1], c * table[2] - s * table[0]])


def _joint(joint: str, p: int) -> tuple[FloatArray, FloatArray]:
    """Return the body part of a joint per metre of each length (3, L), and its constant part in statures (3,)."""
    kind, side = kind_of(joint), _side(joint)
    if kind in FEET or kind == "knee":
        return _leg_joint(kind, side, p)
    table, rest = np.zeros((3, len(LENGTHS))), np.zeros(3)
    if joint in FACE:
        share = FACE[joint][2]
        table[2] = _lengths(torso=0.5, stature=share, shoulder_height=-share)
    elif kind in ("shoulder", "neck"):
        table[1] = _lengths(shoulders=side / 2)
        table[2] = _lengths(torso=0.5)
    else:
        rest[1] = side * HIP_OUT
        table[2] = _lengths(torso=-0.5)
    return _leant(table, TRUNK_LEAN[p]), rest


def _leg_joint(kind: str, side: int, p: int) -> tuple[FloatArray, FloatArray]:
    if p == _LYING:  # as standing, tipped over
        table, rest = _leg_joint(kind, side, POSTURES.index("standing"))
        return _leant(table, TRUNK_LEAN[p]), _leant(rest, TRUNK_LEAN[p])
    forward, out, height = LEGS[POSTURES[p]][kind]
    torso, torso_rest, _ = _torso_height(p)
    # the hips are behind the middle of a torso that leans
    table = np.stack([_lengths(torso=-0.5 * np.sin(TRUNK_LEAN[p])), _lengths(), -torso])
    return table, np.array([forward, side * out, height - torso_rest])


def _head(joint: str, skeleton: str = "") -> FloatArray:
    """Return the part of a joint that turns with the head, per metre of each length (3, L), the face upright."""
    table = np.zeros((3, len(LENGTHS)))
    if joint in FACE:
        forward, left, _ = FACE[joint]
        elsewhere = HEADS.get(skeleton, {}).get(kind_of(joint))
        if elsewhere is not None:
            forward, left = elsewhere[0], _side(joint) * elsewhere[1]
        table[0] = _lengths(head=forward)
        table[1] = _lengths(pupils=left) if joint in EYES else _lengths(head=left)
    return table


_TYPICAL = np.array([1.0, 0.797, 0.31, 0.205, 0.037, 0.09])  # lengths in statures
_TYPICAL_TORSO = float(_TYPICAL[LENGTHS.index("torso")])


def _torso_height(p: int) -> tuple[FloatArray, float, FloatArray]:
    """Return the torso's middle above the sole: per metre of each length (L,), in statures, and by latent (D,)."""
    latent = np.zeros(len(LATENTS))
    latent[_CROUCH] = -1.0
    if p == _LYING:
        return _lengths(), LYING_HEIGHT, latent
    c, s = np.cos(TRUNK_LEAN[p]), np.sin(TRUNK_LEAN[p])
    latent[_SLUMP] = -0.5 * c
    latent[_LEAN] = -0.5 * _TYPICAL_TORSO * s
    if POSTURES[p] in HIP_HEIGHT:
        return _lengths(torso=0.5 * c), HIP_HEIGHT[POSTURES[p]], latent
    return _lengths(shoulder_height=1.0, torso=0.5 * c - 1.0), 0.0, latent


def _latents(joint: str, p: int) -> FloatArray:
    """Return how a joint moves with each latent (3, D), in statures per radian or per stature."""
    kind = kind_of(joint)
    if kind in FEET or kind == "knee":
        return _leg_latents(kind, _side(joint), p)
    table = np.zeros((3, len(LATENTS)))
    upright, _ = _joint(joint, POSTURES.index("standing"))
    height, forward = float(upright[2] @ _TYPICAL), float(_head(joint)[0] @ _TYPICAL)
    table[2, _SLUMP] = -0.5 if height > 0 else 0.5
    # the trunk leans about its middle, the head with it
    table[0, _LEAN] = height
    table[1, LATENTS.index("lean_left")] = height
    if joint in FACE:
        table[0, LATENTS.index("head_forward")] = 1.0
        table[2, LATENTS.index("nod")] = -forward
        table[2, LATENTS.index("head_down")] = -1.0
    return _leant(table, TRUNK_LEAN[p])


def _leg_latents(kind: str, side: int, p: int) -> FloatArray:
    table = np.zeros((3, len(LATENTS)))
    share = 0.5 if kind == "knee" else 1.0
    name, stands = "left" if side > 0 else "right", POSTURES[p] not in HIP_HEIGHT
    table[0, LATENTS.index(f"{name}_foot_forward")] = share
    table[1, LATENTS.index(f"{name}_foot_out")] = side * (share if stands else 1.0)
    table[2, LATENTS.index(f"{name}_foot_up")] = share
    table[2, _SLUMP] = 0.5
    if p == _LYING:
        return _leant(table, TRUNK_LEAN[p])
    if stands:
        table[2, _CROUCH] = share
        table[0, _CROUCH] = 1.2 if kind == "knee" else 0.0  # bent legs bring the knees forward
    else:
        table[2, _CROUCH] = 1.0
    if TRUNK_LEAN[p]:  # who leans that far leans about the hips
        table[0, _LEAN] = -0.5 * _TYPICAL_TORSO * np.cos(TRUNK_LEAN[p])
        table[2, _LEAN] = 0.5 * _TYPICAL_TORSO * np.sin(TRUNK_LEAN[p])
    return table
