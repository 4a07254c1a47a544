"""What may be corrected by hand: the actions of the log, and what their values must hold before they are kept."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, cast

from ...camera.focal import FocalRequest
from ...errors import SettingsError
from ...files import require_whole_characters
from ...locate import BODY_SIZES

_LONGEST_NOTE = 10_000
#: Larger numbers are neither pixels nor millimetres.
_LARGEST = 1e9


@dataclass(frozen=True)
class Action:
    """One entry of the log. value: as `ACTIONS` describes it."""

    number: int
    time: str
    who: str
    photo: str
    sha256: str
    action: str
    value: Mapping[str, Any]


def camera_request(value: Mapping[str, Any]) -> FocalRequest:
    """Return what a "set_camera" action states; raises SettingsError where it contradicts itself."""
    lengths = {name: value.get(name) for name in ("focal_mm", "focal_35mm", "focal_px")}
    for name, length in lengths.items():
        _need(length is None or _is_number(length), f"{name} is a number")
    sensor = value.get("sensor_mm")
    _need(sensor is None or _are_numbers(sensor, 2), "sensor_mm is a pair of numbers")
    sides = None if sensor is None else (float(sensor[0]), float(sensor[1]))
    try:
        return FocalRequest(lengths["focal_mm"], lengths["focal_35mm"], lengths["focal_px"], sensor_mm=sides)
    except SettingsError as error:
        raise SettingsError(f"correction: {error}") from error


def _need(condition: bool, what: str) -> None:
    if not condition:
        raise SettingsError(f"correction: {what}")


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and abs(value) <= _LARGEST


def _are_numbers(value: Any, count: int) -> bool:
    return isinstance(value, list | tuple) and len(cast(Sequence[Any], value)) == count and all(map(_is_number, value))


def _check_box(value: Mapping[str, Any]) -> None:
    _need(_are_numbers(value.get("box"), 4), "the person must be given as a box of four numbers")


def _check_joints(value: Mapping[str, Any]) -> None:
    joints = value.get("joints")
    _need(isinstance(joints, dict) and len(cast(dict[str, Any], joints)) >= 2, "a new person needs at least two joints")
    _need(all(_are_numbers(p, 2) for p in cast(dict[str, Any], joints).values()), "a joint is a pair of numbers")


def _check_move(value: Mapping[str, Any]) -> None:
    _check_box(value)
    _need(isinstance(value.get("joint"), str), "a joint has a name")
    _need("to" in value and (value["to"] is None or _are_numbers(value["to"], 2)), "a joint moves to a pair of numbers")


def _check_camera(value: Mapping[str, Any]) -> None:
    request = camera_request(value)
    stated = (request.focal_mm, request.focal_35mm, request.focal_px)
    _need(sum(v is not None for v in stated) == 1, "state one focal length: in mm, as 35 mm equivalent or in px")
    _need(request.focal_mm is None or request.sensor_mm is not None, "a focal length in mm needs the sensor's size")


def _check_flag(name: str, *, person: bool) -> Callable[[Mapping[str, Any]], None]:
    def run(value: Mapping[str, Any]) -> None:
        if person:
            _check_box(value)
        _need(isinstance(value.get(name), bool), f"{name} is true or false")
        _need(isinstance(value.get("reason", ""), str), "a reason is a text")

    return run


def _check_size(value: Mapping[str, Any]) -> None:
    _check_box(value)
    sizes = (*BODY_SIZES, None)
    _need("body_size" in value and value["body_size"] in sizes, f"a body size is one of {', '.join(BODY_SIZES)}")


def _check_note(value: Mapping[str, Any]) -> None:
    text = value.get("text")
    _need(isinstance(text, str) and len(text) <= _LONGEST_NOTE, f"a note is a text of at most {_LONGEST_NOTE} letters")


@dataclass(frozen=True)
class Kind:
    """One kind of action: what its value holds and does, what is checked before it is kept, whether people move."""

    meaning: str
    check: Callable[[Mapping[str, Any]], None]
    moves: bool = True


#: Action -> its kind. "undo" {number} is an entry of the log and changes no scene by itself.
ACTIONS: dict[str, Kind] = {
    "remove_person": Kind("not a person, or one found twice: {box}", _check_box),
    "add_person": Kind("a person who was missed: {joints: {name: [x, y]}}", _check_joints),
    "move_joint": Kind("a joint moved, or removed: {box, joint, to: [x, y] or null}", _check_move),
    "set_camera": Kind("the focal length: {focal_px}, {focal_35mm} or {focal_mm, sensor_mm: [w, h]}", _check_camera),
    "off_floor": Kind("stands on another floor: {box, off_floor}", _check_flag("off_floor", person=True)),
    "body_size": Kind("whose body lengths to expect: {box, body_size or null}", _check_size),
    "exclude": Kind("the photo does not count: {excluded, reason}", _check_flag("excluded", person=False), False),
    "note": Kind("a remark on the photo: {text}", _check_note, False),
    "checked": Kind("checked and found right: {}", lambda value: None, False),
}


def check(action: str, value: Mapping[str, Any]) -> None:
    """Raise SettingsError where an action is unknown or its value is not as `ACTIONS` describes it."""
    try:
        require_whole_characters(value)
    except ValueError as error:
        raise SettingsError(f"correction: {error}") from error
    if action == "undo":
        _need(isinstance(value.get("number"), int), "undo names the number of an action")
        return
    _need(action in ACTIONS, f"action {action!r} is unknown: use one of {', '.join(ACTIONS)}")
    ACTIONS[action].check(value)
