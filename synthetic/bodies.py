"""Human bodies drawn at random: lengths from measured populations, postures from plain forward kinematics.

Made to test methods, so nothing here is shared with them: no template, constant or prior of the package is used.
Body frame: x forward, y the person's left, z up, metres; the origin lies on the floor below the middle of the hips.

Sources. Lengths: ANSUR II (2012), 4082 men and 1986 women, with their correlations. Children: CDC medians of stature.
Segment lengths that ANSUR II does not give: Drillis and Contini (1966), as fractions of stature.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from proxemetry.arrays import FloatArray

Rng = np.random.Generator

#: What a detector calls the shoulders are the joints, not the outermost bones: 0.34 m where bones are 0.391 m apart.
SHOULDER_JOINTS_PER_BIACROMIAL = 0.87
#: The joint's centre lies this far below the acromion.
JOINT_BELOW_ACROMION_M = 0.035

# Mean, sd: stature, biacromial breadth, interpupillary distance, acromial height, trochanterion height.
_ADULTS = {
    "man": ((1.756, 0.069), (0.416, 0.019), (0.0640, 0.0034), (1.441, 0.063), (0.901, 0.049)),
    "woman": ((1.629, 0.064), (0.365, 0.018), (0.0617, 0.0036), (1.335, 0.058), (0.845, 0.045)),
}
_WITH_STATURE = {"man": (1.0, 0.53, 0.18, 0.97, 0.85), "woman": (1.0, 0.57, 0.20, 0.97, 0.85)}
# What is left of acromial and trochanterion height beside stature correlates so that acromion to trochanterion gets
# its measured sd of 0.033 m.
_HEIGHTS_RESIDUAL_CORRELATION = 0.24
# Age in years, mean and sd of stature (boys, girls averaged).
_CHILDREN = np.array([
    (2, 0.858, 0.035), (4, 1.018, 0.041), (6, 1.154, 0.052), (8, 1.280, 0.056), (10, 1.385, 0.066),
    (12, 1.504, 0.075), (14, 1.623, 0.073), (16, 1.681, 0.070),
])  # fmt: skip
_PUPILS_BY_AGE = np.array([(2, 0.0475), (5, 0.051), (16, 0.062)])


@dataclass(frozen=True)
class Build:
    """The lengths of one body, metres: heights above the bare sole, breadths between joint centres."""

    stature: float
    shoulders: float
    pupils: float
    shoulder_height: float
    hip_height: float
    hips: float
    ears: float
    sole: float
    child: bool

    @property
    def torso(self) -> float:
        """From the middle of the shoulder joints to the middle of the hip joints."""
        return self.shoulder_height - self.hip_height


def draw_build(rng: Rng, child: bool = False) -> Build:
    """Draw the lengths of one person: an adult of either sex alike, or a child of 2 to 16 years."""
    sex = "man" if rng.random() < 0.5 else "woman"
    mean = np.array([m for m, _ in _ADULTS[sex]])
    sd = np.array([s for _, s in _ADULTS[sex]])
    r = np.array(_WITH_STATURE[sex])
    common, own = rng.standard_normal(), rng.standard_normal(5)
    rho = _HEIGHTS_RESIDUAL_CORRELATION
    own[4] = rho * own[3] + math.sqrt(1 - rho * rho) * own[4]
    stature, biacromial, pupils, acromial, trochanterion = mean + sd * (r * common + np.sqrt(1 - r * r) * own)
    scale = 1.0
    if child:
        age = rng.uniform(2, 16)
        child_stature = np.interp(age, _CHILDREN[:, 0], _CHILDREN[:, 1])
        child_sd = np.interp(age, _CHILDREN[:, 0], _CHILDREN[:, 2])
        scale = float((child_stature + child_sd * common) / stature)
        pupils *= float(np.interp(age, _PUPILS_BY_AGE[:, 0], _PUPILS_BY_AGE[:, 1])) / mean[2]
    return Build(
        stature=stature * scale,
        shoulders=biacromial * SHOULDER_JOINTS_PER_BIACROMIAL * scale,
        pupils=pupils,
        shoulder_height=(acromial - JOINT_BELOW_ACROMION_M) * scale,
        hip_height=trochanterion * scale,
        hips=rng.normal(0.175, 0.012) * stature * scale / 1.692,
        ears=2.28 * pupils + rng.normal(0, 0.003),
        sole=rng.uniform(0.01, 0.04) * scale,
        child=child,
    )


def rotation(axis: str, angle_rad: float) -> FloatArray:
    """Return the right-handed rotation about a body axis: x tilts sideways, y leans forward, z turns left."""
    c, s = math.cos(angle_rad), math.sin(angle_rad)
    i, j = {"x": (1, 2), "y": (2, 0), "z": (0, 1)}[axis]
    matrix = np.eye(3)
    matrix[i, i] = matrix[j, j] = c
    matrix[i, j], matrix[j, i] = -s, s
    return matrix


@dataclass(frozen=True)
class Posture:
    """Angles in radians. `thighs` and `knees` are (left, right): a thigh is 0 hanging and pi/2 forward."""

    seated: bool
    lean: float
    tilt: float
    twist: float
    slump: float
    head_yaw: float
    head_pitch: float
    thighs: tuple[float, float]
    knees: tuple[float, float]
    spread: tuple[float, float]
    arms: tuple[float, float, float, float]


def draw_posture(rng: Rng, seated: bool) -> Posture:
    """Draw how one person stands, walks or sits."""
    degrees = math.radians
    walking = not seated and rng.random() < 0.3
    if seated:
        thighs = (degrees(rng.normal(84, 6)), degrees(rng.normal(84, 6)))
        knees = (degrees(rng.normal(82, 14)), degrees(rng.normal(82, 14)))
        spread = (degrees(abs(rng.normal(8, 6))), degrees(abs(rng.normal(8, 6))))
        lean, slump = degrees(rng.normal(-2, 10)), float(np.clip(rng.normal(0.035, 0.02), 0, 0.1))
    else:
        stride = degrees(rng.uniform(8, 24)) if walking else 0.0
        forward = 1 if rng.random() < 0.5 else -1
        thighs = (forward * stride + degrees(rng.normal(0, 2)), -forward * stride + degrees(rng.normal(0, 2)))
        bend = degrees(abs(rng.normal(12, 8))) if walking else 0.0
        knees = (
            degrees(abs(rng.normal(3, 3))) + bend * (forward < 0),
            degrees(abs(rng.normal(3, 3))) + bend * (forward > 0),
        )
        spread = (degrees(rng.normal(4, 3)), degrees(rng.normal(4, 3)))
        lean, slump = degrees(rng.normal(2, 4)), float(np.clip(rng.normal(0.01, 0.01), 0, 0.05))
    elbows = np.radians(np.clip(rng.normal(55 if seated else 25, 30, 2), 5, 140))
    raised = np.radians(rng.normal(20 if seated else 5, 15, 2))
    return Posture(
        seated, lean, degrees(rng.normal(0, 2.5)), degrees(rng.normal(0, 6)), slump, degrees(rng.normal(0, 25)),
        degrees(rng.normal(5, 10)), thighs, knees, spread, (*raised, *elbows),
    )  # fmt: skip


def pose_joints(build: Build, posture: Posture) -> dict[str, FloatArray]:
    """Return every joint of a body in the body frame, metres, the lower foot on the floor."""
    joints = {"mid_hip": np.zeros(3)}
    joints |= _legs(build, posture)
    joints |= _upper_body(build, posture)
    soles = [joints[f"{side}_{part}"][2] for side in ("left", "right") for part in ("heel", "big_toe")]
    lift = build.sole + 0.02 - min(soles)  # heel and toe keypoints lie some 2 cm above the sole
    return {name: point + np.array([0.0, 0.0, lift]) for name, point in joints.items()}


def _legs(build: Build, posture: Posture) -> dict[str, FloatArray]:
    thigh, ankle_height = 0.245 * build.stature, 0.043 * build.stature
    shank = max(build.hip_height - thigh - ankle_height, 0.1)
    joints: dict[str, FloatArray] = {}
    for k, (side, sign) in enumerate((("left", 1.0), ("right", -1.0))):
        hip = np.array([0.0, sign * build.hips / 2, 0.0])
        upper = rotation("x", sign * posture.spread[k]) @ rotation("y", -posture.thighs[k])
        lower = rotation("x", sign * posture.spread[k]) @ rotation("y", posture.knees[k] - posture.thighs[k])
        knee = hip + upper @ (0.0, 0.0, -thigh)
        ankle = knee + lower @ (0.0, 0.0, -shank)
        foot = rotation("z", sign * 0.17)  # toes point outwards by some 10 degrees, feet stay level
        joints |= {f"{side}_hip": hip, f"{side}_knee": knee, f"{side}_ankle": ankle}
        for name, ahead, left in (("heel", -0.028, 0.0), ("big_toe", 0.105, -0.012), ("small_toe", 0.085, 0.03)):
            offset = foot @ np.array([ahead, sign * left, 0.0]) * build.stature
            joints[f"{side}_{name}"] = ankle + offset - (0.0, 0.0, ankle_height - 0.02)
    return joints


def _upper_body(build: Build, posture: Posture) -> dict[str, FloatArray]:
    trunk = rotation("y", posture.lean) @ rotation("x", posture.tilt)
    chest = trunk @ rotation("z", posture.twist)
    neck = trunk @ (0.0, 0.0, build.torso * (1 - posture.slump))
    joints = {"neck": neck}
    elbow_length, wrist_length = 0.172 * build.stature, 0.157 * build.stature
    for k, (side, sign) in enumerate((("left", 1.0), ("right", -1.0))):
        shoulder = neck + chest @ (0.0, sign * build.shoulders / 2, 0.0)
        upper = chest @ rotation("x", sign * 0.15) @ rotation("y", -posture.arms[k])
        fore = upper @ rotation("y", -posture.arms[2 + k])
        elbow = shoulder + upper @ (0.0, 0.0, -elbow_length)
        wrist = elbow + fore @ (0.0, 0.0, -wrist_length)
        joints |= {f"{side}_shoulder": shoulder, f"{side}_elbow": elbow, f"{side}_wrist": wrist}
        for name, offset in (("pinky", -0.03), ("index", 0.03), ("thumb", 0.04)):
            reach = 0.05 if name == "thumb" else 0.09
            joints[f"{side}_{name}"] = wrist + fore @ (offset, 0.0, -reach)
    return joints | _head(build, posture, neck, chest)


def _head(build: Build, posture: Posture, neck: FloatArray, chest: FloatArray) -> dict[str, FloatArray]:
    """The head turns about a point at ear height: yaw against the chest, pitch against the vertical."""
    facing = math.atan2(chest[1, 0], chest[0, 0])
    turn = rotation("z", facing + posture.head_yaw) @ rotation("y", posture.head_pitch)
    size = build.ears / 0.143  # grows with the face, little with stature
    rise = max(build.stature - 0.13 * size - build.shoulder_height, 0.08)
    centre = neck + chest @ (0.025, 0.0, 0.0) + (0.0, 0.0, rise)
    offsets = {"nose": (0.115, 0.0, -0.02), "head_top": (0.0, 0.0, 0.13), "head_centre": (0.02, 0.0, 0.02)}
    for side, sign in (("left", 1.0), ("right", -1.0)):
        pupil = sign * build.pupils / 2 / size
        offsets |= {
            f"{side}_eye": (0.09, pupil, 0.02), f"{side}_eye_inner": (0.093, pupil * 0.5, 0.02),
            f"{side}_eye_outer": (0.08, pupil * 1.4, 0.02), f"{side}_ear": (0.0, sign * 0.0715, 0.0),
            f"{side}_mouth": (0.095, sign * 0.025, -0.05),
        }  # fmt: skip
    joints = {name: centre + turn @ (np.array(offset) * size) for name, offset in offsets.items()}
    joints["eyes_centre"] = (joints["left_eye"] + joints["right_eye"]) / 2
    return joints
