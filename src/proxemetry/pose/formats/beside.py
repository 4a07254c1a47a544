"""What a keypoint file has beside what is used of it, kept so that it can be written back."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

#: What is taken of a person's entry in any format, or follows from it.
TAKEN = frozenset((
    "image_id", "keypoints", "pose_keypoints_2d", "pose_keypoints", "num_keypoints", "keypoint_scores", "bbox", "box",
    "score", "depth_m", "depth_sd_m", "attributes",
))  # fmt: skip
#: Name -> x, y, score of the joints of a person that the skeleton has no place for.
EXTRA_JOINTS = "extra_joints"

Fields = Mapping[str, Any]


@dataclass(frozen=True)
class Beside:
    """What a file has of a photo and is not used, as JSON values.

    people: of each person the other fields of the entry, and under `EXTRA_JOINTS` the joints that the skeleton lacks.
    image: the photo's own fields. annotations: entries of the photo that are of no person. file: the rest of the file.
    """

    people: tuple[Fields, ...] = ()
    image: Fields = field(default_factory=dict[str, Any])
    annotations: tuple[Fields, ...] = ()
    file: Fields = field(default_factory=dict[str, Any])

    def scaled(self, scale: tuple[float, float] | None) -> Beside:
        """Return it in pixels of another size of the photo: x and y times `scale`; without any pixels where None."""
        people, annotations = (tuple(_scaled(e, scale) for e in of) for of in (self.people, self.annotations))
        return Beside(people, self.image, annotations, self.file)


def _scaled(entry: Fields, scale: tuple[float, float] | None) -> Fields:
    found: dict[str, Any] = {}
    for name, value in entry.items():
        change = _CHANGES.get(name)
        if change is None:
            found[name] = value
        elif scale is not None and (changed := change(value, scale)) is not None:
            found[name] = changed
    return found


def _numbers(value: object, group: int) -> list[float] | None:
    """Return a flat list of numbers in whole groups, None for anything else."""
    if not isinstance(value, Sequence) or isinstance(value, str) or len(value) % group:  # pyright: ignore[reportUnknownArgumentType]
        return None
    listed: list[Any] = list(value)  # pyright: ignore[reportUnknownArgumentType]
    return listed if all(isinstance(v, int | float) and not isinstance(v, bool) for v in listed) else None


def _rounded(value: float) -> float:
    return round(value, 2)


def _points(group: int) -> Callable[[object, tuple[float, float]], list[float] | None]:
    """Return what scales a flat list of points of which each has so many numbers, x and y first."""

    def change(value: object, scale: tuple[float, float]) -> list[float] | None:
        numbers = _numbers(value, group)
        if numbers is None:
            return None
        return [_rounded(v * scale[k % group]) if k % group < 2 else v for k, v in enumerate(numbers)]

    return change


def _polygons(value: object, scale: tuple[float, float]) -> list[list[float]] | None:
    """Scale polygons; a run-length code is of its own size alone."""
    if not isinstance(value, list):
        return None
    rows = [_points(2)(row, scale) for row in value]  # pyright: ignore[reportUnknownVariableType]
    return None if any(row is None for row in rows) else [row for row in rows if row is not None]


def _joints(value: object, scale: tuple[float, float]) -> dict[str, list[float]] | None:
    if not isinstance(value, dict):
        return None
    of_each: dict[str, Any] = {str(name): _points(3)(row, scale) for name, row in value.items()}  # pyright: ignore[reportUnknownVariableType, reportUnknownArgumentType]
    return {name: row for name, row in of_each.items() if row is not None}


def _area(value: object, scale: tuple[float, float]) -> float | None:
    return value * scale[0] * scale[1] if isinstance(value, int | float) else None


#: The fields of COCO, COCO-WholeBody and OpenPose that hold pixels.
_CHANGES: Mapping[str, Callable[[object, tuple[float, float]], Any]] = {
    EXTRA_JOINTS: _joints, "segmentation": _polygons, "area": _area,
    **dict.fromkeys(("bbox", "face_box", "lefthand_box", "righthand_box"), _points(2)),
    **dict.fromkeys(
        (
            "keypoints", "face_kpts", "lefthand_kpts", "righthand_kpts", "foot_kpts", "face_keypoints_2d",
            "hand_left_keypoints_2d", "hand_right_keypoints_2d", "face_keypoints", "hand_left_keypoints",
            "hand_right_keypoints",
        ),
        _points(3),
    ),
}  # fmt: skip
