"""What a person may correct in a scene, and the scene that follows from it.

A person is identified by the box that the back end gave, not by a number: numbers move when a person is removed, and a
rerun may find people in another order. A correction whose person is not there any more changes nothing.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from ...bodies import Bodies
from ...camera import CameraEstimate, Doubt
from ...camera.focal import estimate_camera, flags_beside_focal
from ...errors import ProxemetryError, SettingsError, one_line
from ...measure import remeasure
from ...overlap import iou
from ...people import People
from ...people.skeleton import Skeleton
from ...photo import Photo
from ...scene import Review, Scene
from ...settings import Settings
from .actions import ACTIONS, Action, camera_request, check

#: Two boxes this alike (area of overlap over area of union) are the same person.
SAME_PERSON_IOU = 0.5


@dataclass
class _Draft:
    """A scene while actions change it."""

    people: People
    camera: CameraEstimate
    off_floor: list[bool]
    sizes: list[str | None]
    excluded: str | None = None
    note: str | None = None
    moved: bool = False
    applied: list[int] = field(default_factory=list[int])

    def find(self, value: Mapping[str, Any]) -> int | None:
        """Return the row of the person that an action means, None where that person is no longer there."""
        box = value.get("box")
        if box is None or not len(self.people):
            return None
        overlap = iou(np.array(box, dtype=float), self.people.boxes_px)
        row = int(np.argmax(overlap))
        return row if overlap[row] >= SAME_PERSON_IOU else None


def apply(scene: Scene, actions: Sequence[Action]) -> Scene:
    """Return a measured scene with the actions in force applied in their order, placed again where they ask for it.

    The measured scene is left as it is. What was applied, and who made it, is in the result's `review`.
    """
    settings = scene.settings
    off_floor = [i in settings.locate.off_floor for i in range(len(scene))]
    sizes = list(settings.locate.body_sizes or (None,) * len(scene))
    draft = _Draft(scene.people, scene.camera, off_floor, sizes)
    for action in actions:
        check(action.action, action.value)
        change = _CHANGES.get(action.action)
        if change is not None and change(draft, action.value, scene):
            draft.applied.append(action.number)
            draft.moved |= ACTIONS[action.action].moves
    return _finished(scene, draft, settings, {a.number: a for a in actions})


def applied(scene: Scene, actions: Sequence[Action]) -> Scene:
    """Return what `apply` returns; a correction that cannot be applied costs its photo, which fails with the reason."""
    try:
        return apply(scene, actions)
    except Exception as error:  # a log may hold anything that an earlier version, or another program, wrote
        what = str(error) if isinstance(error, ProxemetryError) else f"{type(error).__name__}: {error}"
        numbers = ", ".join(str(a.number) for a in actions)
        reason = one_line(f"its corrections ({numbers} in the log) cannot be applied: {what}")
        failed = Scene.failed(scene.photo, reason, scene.sha256, settings=scene.settings, made_by=scene.made_by)
        return replace(failed, about=scene.about, width_px=scene.width_px, height_px=scene.height_px)


def _finished(scene: Scene, draft: _Draft, settings: Settings, actions: Mapping[int, Action]) -> Scene:
    if draft.excluded is not None:
        no_people = People.none(scene.people.skeleton)
        reason = f"excluded in review{': ' + draft.excluded if draft.excluded else ''}"
        bodies = Bodies.unplaced(0, scene.bodies.method, reason)
        result = replace(scene, people=no_people, bodies=bodies, status="excluded", reason=reason)
    elif draft.moved:
        locate = replace(
            settings.locate,
            body_sizes=tuple(draft.sizes) if any(draft.sizes) else None,
            off_floor=frozenset(i for i, off in enumerate(draft.off_floor) if off),
        )
        result = remeasure(scene, replace(settings, locate=locate), people=draft.people, camera=draft.camera)
    else:
        result = scene
    if not draft.applied:
        return result
    applied = [actions[number] for number in draft.applied]
    review = Review(
        corrections=sum(a.action not in ("note", "checked") for a in applied),
        kinds=tuple(sorted({a.action for a in applied})),
        who=tuple(sorted({a.who for a in applied})),
        note=draft.note or None,
    )
    return replace(result, review=review)


def _remove_person(draft: _Draft, value: Mapping[str, Any], scene: Scene) -> bool:
    row = draft.find(value)
    if row is None:
        return False
    draft.people = draft.people[[i for i in range(len(draft.people)) if i != row]]
    del draft.off_floor[row], draft.sizes[row]
    return True


def _add_person(draft: _Draft, value: Mapping[str, Any], scene: Scene) -> bool:
    skeleton = draft.people.skeleton
    keypoints = np.full((1, len(skeleton), 2), np.nan)
    for joint, point in value["joints"].items():
        row = skeleton.index(joint)
        if row is not None:
            keypoints[0, row] = _near(point, scene)
    if not np.isfinite(keypoints).any():
        return False
    added = People(skeleton, keypoints, np.isfinite(keypoints).all(axis=-1).astype(float))
    draft.people = _joined(draft.people, added)
    draft.off_floor.append(False)
    draft.sizes.append(None)
    return True


def _near(point: Sequence[float], scene: Scene) -> Sequence[float]:
    """Return a point in pixels; raises SettingsError where it is further from the photo than the photo is large."""
    for value, side in zip(point, (scene.width_px, scene.height_px), strict=True):
        if not -side <= value <= 2 * side:
            raise SettingsError(f"correction: a joint at {value:g} is far outside the photo of {side} pixels")
    return point


def _joined(one: People, other: People) -> People:
    arrays = (
        "keypoints_px", "scores", "boxes_px", "person_scores", "heading_rad", "heading_sd_rad", "depth_m", "depth_sd_m",
    )  # fmt: skip
    return People(
        one.skeleton, **{name: np.concatenate([getattr(one, name), getattr(other, name)]) for name in arrays},
        source=one.source, attributes=[*one.attributes, *other.attributes], rivals=[*one.rivals, *other.rivals],
        framed=[*one.framed, *other.framed],
    )  # fmt: skip


def _move_joint(draft: _Draft, value: Mapping[str, Any], scene: Scene) -> bool:
    row, joint = draft.find(value), draft.people.skeleton.index(value["joint"])
    if row is None or joint is None:
        return False
    keypoints, scores = draft.people.keypoints_px.copy(), draft.people.scores.copy()
    keypoints[row, joint] = np.nan if value["to"] is None else _near(value["to"], scene)
    scores[row, joint] = 0.0 if value["to"] is None else 1.0
    draft.people = replace(draft.people, keypoints_px=keypoints, scores=scores)
    return True


def _set_camera(draft: _Draft, value: Mapping[str, Any], scene: Scene) -> bool:
    estimate = estimate_camera(Photo(scene.photo, scene.width_px, scene.height_px, scene.sha256), camera_request(value))
    stated = estimate.camera
    if stated is None:
        return False
    before = draft.camera.camera
    camera = replace(stated, source=replace(stated.source, reviewed=True))
    if before is not None:  # the lens and the middle of the picture stay as they were
        camera = before.with_focal(stated.f_px, focal_rel_sd=stated.focal_rel_sd, source=camera.source)
    # What was doubtful about the old focal length is settled; that the new one is assumed is not.
    assumed = tuple(flag for flag in estimate.flags if flag.doubt is Doubt.ASSUMED)
    draft.camera = CameraEstimate(
        camera,
        draft.camera.candidates,
        (*assumed, *flags_beside_focal(draft.camera.flags)),
        lens=draft.camera.lens,
        mount=draft.camera.mount,
    )
    return True


def _set_off_floor(draft: _Draft, value: Mapping[str, Any], scene: Scene) -> bool:
    row = draft.find(value)
    if row is not None:
        draft.off_floor[row] = value["off_floor"]
    return row is not None


def _set_body_size(draft: _Draft, value: Mapping[str, Any], scene: Scene) -> bool:
    row = draft.find(value)
    if row is not None:
        draft.sizes[row] = value["body_size"]
    return row is not None


def _exclude(draft: _Draft, value: Mapping[str, Any], scene: Scene) -> bool:
    draft.excluded = value.get("reason", "") if value["excluded"] else None
    return True


def _note(draft: _Draft, value: Mapping[str, Any], scene: Scene) -> bool:
    draft.note = value["text"]
    return True


def _checked(draft: _Draft, value: Mapping[str, Any], scene: Scene) -> bool:
    return True


#: Action -> what changes the draft; the answer is whether there was anything to change.
_CHANGES: dict[str, Callable[[_Draft, Mapping[str, Any], Scene], bool]] = {
    "remove_person": _remove_person,
    "add_person": _add_person,
    "move_joint": _move_joint,
    "set_camera": _set_camera,
    "off_floor": _set_off_floor,
    "body_size": _set_body_size,
    "exclude": _exclude,
    "note": _note,
    "checked": _checked,
}


def joints_to_click(skeleton: Skeleton) -> tuple[str, ...]:
    """Return the joints that matter most for a person added by hand, in the order to click them."""
    order = (
        "left_shoulder", "right_shoulder", "left_hip", "right_hip", "left_ankle", "right_ankle", "nose", "left_eye",
        "right_eye", "left_knee", "right_knee",
    )  # fmt: skip
    return tuple(joint for joint in order if skeleton.index(joint) is not None)
