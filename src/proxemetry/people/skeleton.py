"""Joint names, and the skeletons of the common detectors as tables into them.

Left and right are the person's own. A skeleton that lacks a neck or a mid-hip gets the middle of the shoulders or of
the hips (METHOD section 1); nothing else is ever invented.
"""

from __future__ import annotations

from dataclasses import dataclass

from ..errors import SettingsError

_SIDES = ("left", "right")
_COCO_JOINTS = (
    "nose", "left_eye", "right_eye", "left_ear", "right_ear", "left_shoulder", "right_shoulder", "left_elbow",
    "right_elbow", "left_wrist", "right_wrist", "left_hip", "right_hip", "left_knee", "right_knee", "left_ankle",
    "right_ankle",
)  # fmt: skip

#: Joints that a skeleton may lack, and the pair whose middle stands for them.
MIDDLES = {"neck": ("left_shoulder", "right_shoulder"), "mid_hip": ("left_hip", "right_hip")}

#: The benchmark's four body parts (Seker et al. 2021, section 3.1).
PARTS = ("Eyes", "Shoulder", "Torso", "Head")

_BONES = (
    ("neck", "left_shoulder"), ("neck", "right_shoulder"), ("neck", "mid_hip"), ("mid_hip", "left_hip"),
    ("mid_hip", "right_hip"), ("neck", "nose"),
    *((f"{s}_{a}", f"{s}_{b}") for s in _SIDES for a, b in (
        ("shoulder", "elbow"), ("elbow", "wrist"), ("hip", "knee"), ("knee", "ankle"), ("ankle", "big_toe"),
        ("ankle", "heel"),
    )),
    *(("nose", f"{s}_eye") for s in _SIDES), *((f"{s}_eye", f"{s}_ear") for s in _SIDES),
)  # fmt: skip


@dataclass(frozen=True)
class Skeleton:
    """The joints of one detector, in its own order.

    `name` is how files and options call it; `joints` are the names of its K keypoints.
    """

    name: str
    joints: tuple[str, ...]

    def __len__(self) -> int:
        return len(self.joints)

    def index(self, joint: str) -> int | None:
        """Return the row of a joint, or None where this skeleton has none."""
        return self.joints.index(joint) if joint in self.joints else None

    @property
    def mirror(self) -> tuple[int, ...]:
        """For each keypoint the index of the one on the other side of the body."""
        return tuple(self.joints.index(_other_side(joint)) for joint in self.joints)

    @property
    def bones(self) -> tuple[tuple[str, str], ...]:
        """Pairs of joints to draw as lines; neck and mid-hip may be middles."""
        known = set(self.joints) | set(MIDDLES)
        return tuple((a, b) for a, b in _BONES if a in known and b in known)


def kind_of(joint: str) -> str:
    """Return a joint's name without its side."""
    return joint.removeprefix("left_").removeprefix("right_")


def _other_side(joint: str) -> str:
    if "left" in joint:
        return joint.replace("left", "right")
    return joint.replace("right", "left")


COCO_17 = Skeleton("coco17", _COCO_JOINTS)

HALPE_26 = Skeleton(
    "halpe26",
    (
        *_COCO_JOINTS, "head_top", "neck", "mid_hip", "left_big_toe", "right_big_toe", "left_small_toe",
        "right_small_toe", "left_heel", "right_heel",
    ),
)  # fmt: skip

BODY_25 = Skeleton(
    "body25",
    (
        "nose", "neck", "right_shoulder", "right_elbow", "right_wrist", "left_shoulder", "left_elbow", "left_wrist",
        "mid_hip", "right_hip", "right_knee", "right_ankle", "left_hip", "left_knee", "left_ankle", "right_eye",
        "left_eye", "right_ear", "left_ear", "left_big_toe", "left_small_toe", "left_heel", "right_big_toe",
        "right_small_toe", "right_heel",
    ),
)  # fmt: skip

BLAZEPOSE_33 = Skeleton(
    "blazepose33",
    (
        "nose", "left_eye_inner", "left_eye", "left_eye_outer", "right_eye_inner", "right_eye", "right_eye_outer",
        "left_ear", "right_ear", "left_mouth", "right_mouth", "left_shoulder", "right_shoulder", "left_elbow",
        "right_elbow", "left_wrist", "right_wrist", "left_pinky", "right_pinky", "left_index", "right_index",
        "left_thumb", "right_thumb", "left_hip", "right_hip", "left_knee", "right_knee", "left_ankle", "right_ankle",
        "left_heel", "right_heel", "left_big_toe", "right_big_toe",
    ),
)  # fmt: skip

#: The annotated points of the KORTE benchmark as keypoints: the shoulders' centre is the neck, and the mid-hip lies as
#: far below the torso's centre as the neck lies above it.
KORTE_PARTS = Skeleton("korte_parts", ("eyes_centre", "head_centre", "neck", "mid_hip"))

#: Boxes alone, as trackers and detectors give them: the middle of the upper edge, and that of the lower.
BOX = Skeleton("box", ("head_top", "heel"))

SKELETONS = {s.name: s for s in (COCO_17, HALPE_26, BODY_25, BLAZEPOSE_33, KORTE_PARTS, BOX)}


def skeleton_named(name: str) -> Skeleton:
    """Return the skeleton of that name, spelling loosely ("COCO-17", "body_25"); raises SettingsError."""
    key = name.lower().replace("-", "").replace("_", "")
    for skeleton in SKELETONS.values():
        if skeleton.name.replace("_", "") == key:
            return skeleton
    raise SettingsError(f"skeleton {name!r} is unknown: use one of {', '.join(SKELETONS)}")
