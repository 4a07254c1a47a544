"""The numbers of the body model: where joints lie in each posture, how postures vary, and how well joints are defined.

Body frame and meaning: see `body_model`. Heights are ANSUR II's where it measured them (ectocanthus, tragion, lateral
femoral epicondyle, lateral malleolus); hips, knees and the widths between joints are where detectors trained on COCO
place them.
"""

from __future__ import annotations

import numpy as np

#: Riding is on a bicycle, bent is stooping from the hips, lying is on the back or the belly.
POSTURES = ("standing", "seated", "lying", "squatting", "riding", "bent")
#: The first so many are common; with the next, so many must be distinguished before the camera's pitch is known.
N_COMMON, N_TELLING = 2, 3
#: How likely a person is each, before any evidence.
POSTURE_WEIGHTS = (0.815, 0.14, 0.005, 0.01, 0.015, 0.015)
#: How far the trunk of each leans forward before any latent, and the face with it, radians.
TRUNK_LEAN = (0.0, 0.0, -np.pi / 2, 0.40, 0.40, 0.85)
FACE_LEAN = (0.0, 0.0, -np.pi / 2, 0.0, 0.0, 0.40)

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
#: (CMU Panoptic), rounded, with ergonomists' chairs, 38 to 50 cm high, and their 40 mm for a slumped back (Pheasant,
#: Bodyspace); the others by judgement: saddles set by the usual rule (0.88 of the inseam above the crank), stooping
#: over a table or to the ground, flat on floor or bed.
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
        (0.0, 0.030), (0.020, 0.022),
    ),
    "squatting": (
        (0.0, 0.25), (0.0, 0.09), (0.10, 0.30), (0.020, 0.025), (0.010, 0.015),
        (0.0, 0.09), (0.0, 0.050), (0.0, 0.040),
        (0.0, 0.09), (0.0, 0.050), (0.0, 0.040),
        (0.0, 0.050), (0.015, 0.015),
    ),
    "riding": (
        (0.0, 0.22), (0.0, 0.07), (0.10, 0.30), (0.020, 0.025), (0.010, 0.015),
        (0.0, 0.07), (0.0, 0.020), (0.0, 0.065),
        (0.0, 0.07), (0.0, 0.020), (0.0, 0.065),
        (0.0, 0.030), (0.010, 0.012),
    ),
    "bent": (
        (0.0, 0.28), (0.0, 0.09), (0.10, 0.35), (0.020, 0.030), (0.006, 0.015),
        (0.0, 0.11), (0.0, 0.040), (0.008, 0.025),
        (0.0, 0.11), (0.0, 0.040), (0.008, 0.025),
        (0.020, 0.030), (0.015, 0.015),
    ),
    "lying": (
        (0.0, 0.10), (0.0, 0.12), (0.0, 0.30), (0.0, 0.030), (0.0, 0.020),
        (0.0, 0.09), (0.02, 0.070), (0.0, 0.060),
        (0.0, 0.09), (0.02, 0.070), (0.0, 0.060),
        (0.0, 0.040), (0.0, 0.015),
    ),
}  # fmt: skip

#: What soles add below the foot, metres.
SHOE_M = 0.025

# Joint -> (forward, left, up above the shoulder line as a share of stature - shoulder height); forward and left are
# shares of the head's breadth, but the eyes' left is a share of the pupils' distance.
FACE: dict[str, tuple[float, float, float]] = {
    "nose": (0.76, 0.0, 0.565),
    "left_eye": (0.56, 0.5, 0.665), "right_eye": (0.56, -0.5, 0.665), "eyes_centre": (0.56, 0.0, 0.665),
    "left_eye_inner": (0.58, 0.27, 0.665), "right_eye_inner": (0.58, -0.27, 0.665),
    "left_eye_outer": (0.50, 0.72, 0.665), "right_eye_outer": (0.50, -0.72, 0.665),
    "left_ear": (0.0, 0.5, 0.62), "right_ear": (0.0, -0.5, 0.62), "head_centre": (0.15, 0.0, 0.62),
    "left_mouth": (0.62, 0.16, 0.46), "right_mouth": (0.62, -0.16, 0.46), "head_top": (0.0, 0.0, 1.0),
}  # fmt: skip
EYES = tuple(j for j in FACE if "eye" in j)
# Where a skeleton puts a joint of the head elsewhere: forward and left (of the left one) as above. BlazePose's ears are
# no ears: they lie 0.64 as far apart as PP-TinyPose's (84 heads in 26 photos, quartiles 0.5 and 0.8; COCO's own
# annotators agree with the latter), and in profile at 0.5 of the way from the nose, half of which is the nose's.
HEADS: dict[str, dict[str, tuple[float, float]]] = {"blazepose33": {"ear": (0.20, 0.32)}}

# Left leg: (forward, left, height above the sole), in statures.
STANDING_LEG = {
    "knee": (0.025, 0.055, 0.285), "ankle": (-0.012, 0.052, 0.047), "heel": (-0.042, 0.050, 0.020),
    "big_toe": (0.090, 0.062, 0.015), "small_toe": (0.072, 0.090, 0.015),
}  # fmt: skip
_SEATED_LEG = {
    "knee": (0.245, 0.075, 0.285), "ankle": (0.235, 0.070, 0.047), "heel": (0.205, 0.068, 0.020),
    "big_toe": (0.335, 0.080, 0.015), "small_toe": (0.318, 0.108, 0.015),
}  # fmt: skip
# On the haunches, heels on the ground or up; one knee down is within the spread.
_SQUATTING_LEG = {
    "knee": (0.220, 0.090, 0.270), "ankle": (0.070, 0.070, 0.065), "heel": (0.040, 0.070, 0.045),
    "big_toe": (0.165, 0.085, 0.015), "small_toe": (0.150, 0.110, 0.015),
}  # fmt: skip
# Pedals at the mean of a turn, heights above the road.
_RIDING_LEG = {
    "knee": (0.170, 0.060, 0.385), "ankle": (0.060, 0.060, 0.190), "heel": (0.020, 0.060, 0.165),
    "big_toe": (0.150, 0.070, 0.160), "small_toe": (0.135, 0.095, 0.160),
}  # fmt: skip
LEGS = {
    "standing": STANDING_LEG, "seated": _SEATED_LEG, "squatting": _SQUATTING_LEG, "riding": _RIDING_LEG,
    "bent": STANDING_LEG, "lying": STANDING_LEG,
}  # fmt: skip
#: Height of the hip joints above the floor in statures, where it does not follow from a standing person's shoulders: on
#: a chair of mean height, on the haunches, on a saddle.
HIP_HEIGHT = {"seated": 0.305, "squatting": 0.180, "riding": 0.555}
#: Height of a lying torso's middle above the floor, in statures.
LYING_HEIGHT = 0.07
#: Half the distance between the hip joints as COCO's annotators place them, in statures.
HIP_OUT = 0.062
FEET = ("ankle", "heel", "big_toe", "small_toe")

# How far a detected joint strays from the model, in statures: what posture the latents leave out, clothes, and the
# detector's own error. COCO's annotators disagree by these proportions (Ronchi and Perona 2017, its OKS constants).
SPREAD = {
    "nose": 0.009, "eye": 0.008, "eye_inner": 0.009, "eye_outer": 0.009, "ear": 0.012, "eyes_centre": 0.012,
    "head_centre": 0.020, "mouth": 0.010, "head_top": 0.016, "shoulder": 0.015, "neck": 0.014, "hip": 0.022,
    "mid_hip": 0.020, "knee": 0.022, "ankle": 0.017, "heel": 0.018, "big_toe": 0.022, "small_toe": 0.024,
}  # fmt: skip

# Where a skeleton's definition differs from the table above: (forward, left, up) in statures for the left joint, and a
# factor on the spread. COCO-17 and BODY_25 share COCO's own annotations and are the table. Halpe's neck is annotated at
# the throat. BlazePose's hips lie nearer together and higher (its torso is 0.97 of COCO's), its knees and ankles higher
# (compared with PP-TinyPose's of the same people in 36 photos: hips 0.9 +- 0.4, knees 0.6 +- 0.3, ankles 1.2 +- 0.4 %
# of the stature; with hand labels 1.6 %). KORTE's labels are clicked by hand: one eye stands for both in profile, the
# head's middle is not the ears', the middle of the shoulders lies anywhere between the joints and the base of the neck
# 7 cm above them (half of that here, doubt and all), and the mid-hip is extrapolated from it and the torso's middle.
# Detectors' boxes end some per cent above the hair and below the soles or short of them, wherever arms and bags are.
DEFINITIONS: dict[str, dict[str, tuple[float, float, float, float]]] = {
    "halpe26": {"neck": (0.0, 0.0, 0.015, 1.3)},
    "blazepose33": {
        "hip": (0.0, -0.008, 0.009, 1.2), "shoulder": (0.0, 0.0, 0.0, 1.2), "ear": (0.0, 0.0, 0.0, 1.3),
        "knee": (0.0, 0.0, 0.006, 1.0), "ankle": (0.0, 0.0, 0.010, 1.0),
    },
    "korte_parts": {
        "eyes_centre": (0.0, 0.0, 0.0, 1.5), "head_centre": (0.0, 0.0, 0.010, 1.25),
        "neck": (0.0, 0.0, 0.020, 2.0), "mid_hip": (0.0, 0.0, -0.020, 2.75),
    },
    "box": {"head_top": (0.0, 0.0, 0.0, 2.0), "heel": (0.0, 0.0, -0.010, 2.0)},
}  # fmt: skip
