"""Captured postures on bodies of the synthetic population: people as they really stand and walk.

Bones keep their captured directions and take the lengths of a drawn build. Captures hold no face: it is set on the
captured head's axis, looking ahead with a random turn.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from proxemetry.arrays import FloatArray
from synthetic.bodies import Build, draw_build, draw_posture, pose_joints, rotation
from synthetic.layouts import DrawBody

Rng = np.random.Generator

#: Frames that count as upright: knees hardly bent, trunk near the vertical.
_LEAST_KNEE, _MOST_LEAN = np.radians(135), np.radians(30)


def mocap_bodies(file: Path) -> DrawBody:
    """Return a drawer of bodies in captured upright postures; seated people are drawn as in `synthetic/bodies.py`."""
    frames, names = _upright(file)

    def draw(rng: Rng, seated: bool) -> tuple[dict[str, FloatArray], float]:
        build = draw_build(rng)
        if seated:
            return pose_joints(build, draw_posture(rng, True)), build.stature
        return _dressed(rng, build, frames[rng.integers(len(frames))], names), build.stature

    return draw


def _upright(file: Path) -> tuple[FloatArray, dict[str, int]]:
    """Return frames (F, J, 3) in body axes: x forward, y left, z up, metres."""
    data = np.load(file)
    names = {str(name): k for k, name in enumerate(data["names"])}
    points = np.concatenate([data[key] for key in data.files if key != "names"]).astype(float)
    points = points[:, :, [2, 0, 1]]  # y is up in the captures: make it z, right-handed
    hips = points[:, names["lhipjoint"]] - points[:, names["rhipjoint"]]
    heading = np.arctan2(hips[:, 1], hips[:, 0]) - np.pi / 2
    c, s = np.cos(-heading), np.sin(-heading)
    zero, one = np.zeros_like(c), np.ones_like(c)
    turn = np.stack([np.stack([c, -s, zero], 1), np.stack([s, c, zero], 1), np.stack([zero, zero, one], 1)], 1)
    points = np.einsum("fij,fkj->fki", turn, points)
    return points[_is_upright(points, names)], names


def _is_upright(points: FloatArray, names: dict[str, int]) -> NDArray[np.bool_]:
    def at(name: str) -> FloatArray:
        return points[:, names[name]]

    keep = np.ones(len(points), dtype=bool)
    for side in "lr":
        thigh, shank = at(f"{side}hipjoint") - at(f"{side}femur"), at(f"{side}tibia") - at(f"{side}femur")
        cosine = (thigh * shank).sum(1) / np.linalg.norm(thigh, axis=1) / np.linalg.norm(shank, axis=1)
        keep &= np.arccos(np.clip(cosine, -1, 1)) > _LEAST_KNEE
    trunk = at("lowerneck") - at("root")
    return keep & (np.arccos(np.clip(trunk[:, 2] / np.linalg.norm(trunk, axis=1), -1, 1)) < _MOST_LEAN)


def _dressed(rng: Rng, build: Build, frame: FloatArray, names: dict[str, int]) -> dict[str, FloatArray]:
    def bone(a: str, b: str) -> FloatArray:
        along = frame[names[b]] - frame[names[a]]
        return along / np.linalg.norm(along)

    across_hips, across = bone("rhipjoint", "lhipjoint"), bone("rclavicle", "lclavicle")
    chest = (frame[names["lclavicle"]] + frame[names["rclavicle"]]) / 2
    pelvis = (frame[names["lhipjoint"]] + frame[names["rhipjoint"]]) / 2
    neck = build.torso * (chest - pelvis) / np.linalg.norm(chest - pelvis)
    joints = {"mid_hip": np.zeros(3), "neck": neck}
    thigh, ankle = 0.245 * build.stature, 0.043 * build.stature
    shank = max(build.hip_height - thigh - ankle, 0.1)
    for side, sign in (("left", 1.0), ("right", -1.0)):
        s = side[0]
        joints[f"{side}_hip"] = sign * across_hips * build.hips / 2
        joints[f"{side}_shoulder"] = neck + sign * across * build.shoulders / 2
        joints[f"{side}_knee"] = joints[f"{side}_hip"] + thigh * bone(f"{s}hipjoint", f"{s}femur")
        joints[f"{side}_ankle"] = joints[f"{side}_knee"] + shank * bone(f"{s}femur", f"{s}tibia")
        joints[f"{side}_elbow"] = joints[f"{side}_shoulder"] + 0.172 * build.stature * bone(
            f"{s}clavicle", f"{s}humerus"
        )
        joints[f"{side}_wrist"] = joints[f"{side}_elbow"] + 0.157 * build.stature * bone(f"{s}humerus", f"{s}radius")
        toe = bone(f"{s}foot", f"{s}toes")
        ahead = np.array([toe[0], toe[1], 0.0])
        ahead = ahead / max(float(np.linalg.norm(ahead)), 1e-6)
        for name, reach in (("heel", -0.028), ("big_toe", 0.105), ("small_toe", 0.085)):
            joints[f"{side}_{name}"] = joints[f"{side}_ankle"] + reach * build.stature * ahead - (0, 0, ankle - 0.02)
    joints |= _face(rng, build, neck, bone("lowerneck", "head"), across)
    lift = build.sole + ankle - min(joints["left_ankle"][2], joints["right_ankle"][2])
    return {name: point + np.array([0.0, 0.0, lift]) for name, point in joints.items()}


def _face(rng: Rng, build: Build, neck: FloatArray, axis: FloatArray, across: FloatArray) -> dict[str, FloatArray]:
    """Set the face of the synthetic body on the captured neck's direction, halfway straightened as necks do."""
    flat = pose_joints(build, draw_posture(rng, False))
    ears = (flat["left_ear"] + flat["right_ear"]) / 2
    rise = float(np.linalg.norm(ears - flat["neck"]))
    upright = axis + np.array([0.0, 0.0, 1.0])
    centre = neck + rise * upright / np.linalg.norm(upright)
    facing = np.arctan2(-across[0], across[1])
    own = np.arctan2(*(flat["nose"] - ears)[1::-1])
    turn = rotation("z", float(facing - own + rng.normal(0, np.radians(25))))
    faces = [name for name in flat if any(p in name for p in ("eye", "ear", "nose", "mouth", "head"))]
    return {name: centre + turn @ (flat[name] - ears) for name in faces}
