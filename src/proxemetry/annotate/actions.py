"""What an annotator may do: each action's value, checked before it is kept, and the annotations that follow."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from typing import Any, cast

from ..archive.review.actions import Action
from ..errors import ProxemetryError, SettingsError
from ..files import require_whole_characters
from ..people.skeleton import PARTS
from .lens import stated_lens
from .places import Spot, Tape
from .places.measurements import SPOT_SD_M, TAPE_SD_M
from .state import Annotations, Person, PhotoNotes, Shoot

#: People and cameras are numbered to here, and shoots: more is a typing error.
MOST_NUMBER = 999
MOST_PEOPLE = 400
_LONGEST_NAME = 100
_LARGEST_PX = 1_000_000
#: Larger numbers are neither pixels nor metres.
_LARGEST = 1e9
_PERSON, _CAMERA = re.compile(r"P(0|[1-9]\d{0,2})"), re.compile(r"C(0|[1-9]\d{0,2})")

Value = Mapping[str, Any]


def _need(condition: bool, what: str) -> None:
    if not condition:
        raise SettingsError(f"annotation: {what}")


def _number(value: Any, what: str) -> float:
    is_number = isinstance(value, int | float) and not isinstance(value, bool) and abs(value) <= _LARGEST
    _need(is_number, f"{what} is a number")
    return float(value)


def _whole(value: Any, what: str, most: int = 10**9) -> int:
    _need(isinstance(value, int) and not isinstance(value, bool) and 0 <= value <= most, f"{what} is 0 to {most:,}")
    return int(value)


def _text(value: Any, what: str) -> str:
    _need(
        isinstance(value, str) and len(value) <= _LONGEST_NAME, f"{what} is a text of at most {_LONGEST_NAME} letters"
    )
    _need(len(f"{value} ".splitlines()) == 1, f"{what} is a text of one line")
    return " ".join(str(value).split())


def _tag(value: Any, kind: re.Pattern[str] | None = None) -> str:
    is_tag = isinstance(value, str) and any(k.fullmatch(value) for k in ((kind,) if kind else (_PERSON, _CAMERA)))
    example = "P3" if kind is _PERSON else "C0" if kind is _CAMERA else "P3 or C0"
    _need(is_tag, f"a tag is a letter and a number up to {MOST_NUMBER}, as {example}")
    return str(value)


def _pixel(value: Any) -> tuple[int, int]:
    pair = cast("list[Any]", value) if isinstance(value, list | tuple) else []
    _need(len(pair) == 2, "a point is a pair of pixels")
    x, y = (_number(v, "a pixel") for v in pair)
    _need(min(x, y) >= 0 and max(x, y) < _LARGEST_PX, "a point lies in the photo")
    return int(x), int(y)


def _points(value: Any) -> dict[str, tuple[int, int]]:
    _need(isinstance(value, dict) and all(part in PARTS for part in value), f"points are of {', '.join(PARTS)}")
    return {part: _pixel(value[part]) for part in PARTS if part in value}


def _mapping(value: Any) -> Mapping[str, Any] | None:
    _need(value is None or isinstance(value, dict), "what was read of a person or a photo is an object")
    return value


def _files(value: Any) -> list[str]:
    listed = cast("list[Any]", value) if isinstance(value, list) else []
    _need(bool(listed) and all(isinstance(v, str) and re.fullmatch(r"[0-9a-f]{64}", v) for v in listed),
          "photos are named by their files' SHA-256")  # fmt: skip
    return listed


# Photos


def _on_photo(change: Callable[[PhotoNotes, Value], PhotoNotes]) -> Callable[[Annotations, Action], Annotations]:
    def run(now: Annotations, action: Action) -> Annotations:
        _need(bool(action.sha256), "it belongs to a photo")
        return _with_photos(now, [action.sha256], lambda notes: change(notes, action.value))

    return run


def _with_photos(now: Annotations, files: Iterable[str], change: Callable[[PhotoNotes], PhotoNotes]) -> Annotations:
    return replace(now, photos={**now.photos, **{f: change(now.photo(f)) for f in files}})


def _propose(notes: PhotoNotes, value: Value) -> PhotoNotes:
    people, pose = value.get("people"), _text(value.get("pose"), "a back end's name")
    _need(isinstance(people, list) and len(cast("list[Any]", people)) <= MOST_PEOPLE, "a proposal lists people")
    found = tuple(
        Person(
            _whole(p.get("person"), "a person's key"),
            None if p.get("tag") is None else _tag(p["tag"], _PERSON),
            _points(p.get("points")),
            pose,
            _mapping(p.get("read")),
        )
        for p in cast("list[dict[str, Any]]", people)
    )
    known = {p.key for p in notes.people}
    _need(not known & {p.key for p in found} and len({p.key for p in found}) == len(found), "keys are used once")
    tags = [p.tag for p in (*notes.people, *found) if p.tag is not None]
    _need(len(set(tags)) == len(tags), "a person can be on a photo only once")
    return replace(notes, people=(*notes.people, *found), proposed=pose, read=_mapping(value.get("read")) or notes.read)


def _add_person(notes: PhotoNotes, value: Value) -> PhotoNotes:
    key, points = _whole(value.get("person"), "a person's key"), _points(value.get("points"))
    _need(notes.person(key) is None, "a person's key is used once")
    _need(bool(points), "a person has at least one point")
    _need(len(notes.people) < MOST_PEOPLE, f"a photo has at most {MOST_PEOPLE} people")
    return replace(notes, people=(*notes.people, Person(key, None, points)))


def _with_person(notes: PhotoNotes, value: Value, change: Callable[[Person], Person | None]) -> PhotoNotes:
    key = _whole(value.get("person"), "a person's key")
    person = notes.person(key)
    if person is None:
        raise SettingsError("annotation: that person is not on this photo any more")
    changed = change(person)
    return replace(notes, people=tuple(q for p in notes.people if (q := changed if p is person else p) is not None))


def _remove_person(notes: PhotoNotes, value: Value) -> PhotoNotes:
    return _with_person(notes, value, lambda person: None)


def _set_point(notes: PhotoNotes, value: Value) -> PhotoNotes:
    part = value.get("part")
    _need(part in PARTS, f"a part is one of {', '.join(PARTS)}")
    _need("to" in value, "a point moves to a pair of pixels, or to null where it is not visible")
    to = None if value["to"] is None else _pixel(value["to"])

    def change(person: Person) -> Person:
        points = {name: point for name, point in person.points.items() if name != part}
        return replace(person, points=points if to is None else {**points, cast(str, part): to})

    return _with_person(notes, value, change)


def _name_person(notes: PhotoNotes, value: Value) -> PhotoNotes:
    """Name a person; another person of that name on this photo becomes unnamed, since no one is on a photo twice."""
    tag = None if value.get("tag") is None else _tag(value["tag"], _PERSON)
    freed = tuple(replace(p, tag=None) if tag is not None and p.tag == tag else p for p in notes.people)
    return _with_person(replace(notes, people=freed), value, lambda p: replace(p, tag=tag))


def _name_people(notes: PhotoNotes, value: Value) -> PhotoNotes:
    listed = value.get("names")
    _need(isinstance(listed, list) and bool(listed), "names are a list of persons and tags")
    for item in cast("list[Any]", listed):
        _need(isinstance(item, dict), "a name is a person and a tag")
        notes = _name_person(notes, item)
    return notes


def _finish(notes: PhotoNotes, value: Value) -> PhotoNotes:
    _need(isinstance(value.get("done"), bool), "done is true or false")
    return replace(notes, done=value["done"])


def _skip(notes: PhotoNotes, value: Value) -> PhotoNotes:
    _need(isinstance(value.get("skipped"), bool), "skipped is true or false")
    return replace(notes, skipped=value["skipped"])


def _set_lens(now: Annotations, action: Action) -> Annotations:
    lens = None if action.value.get("lens") is None else stated_lens(action.value["lens"])
    return _with_photos(now, _files(action.value.get("photos")), lambda notes: replace(notes, lens=lens))


def _place_photos(now: Annotations, action: Action) -> Annotations:
    shoot = _whole(action.value.get("shoot"), "a shoot's number", MOST_NUMBER)
    camera = _tag(action.value.get("camera"), _CAMERA)
    shoots = {**now.shoots, shoot: now.shoot(shoot)}
    files = _files(action.value.get("photos"))
    return replace(_with_photos(now, files, lambda notes: replace(notes, shoot=shoot, camera=camera)), shoots=shoots)


# Shoots


def _on_shoot(change: Callable[[Shoot, Value], Shoot]) -> Callable[[Annotations, Action], Annotations]:
    def run(now: Annotations, action: Action) -> Annotations:
        number = _whole(action.value.get("shoot"), "a shoot's number", MOST_NUMBER)
        return replace(now, shoots={**now.shoots, number: change(now.shoot(number), action.value)})

    return run


def _name_shoot(shoot: Shoot, value: Value) -> Shoot:
    return replace(shoot, name=_text(value.get("name"), "a shoot's name"))


def _name_camera(shoot: Shoot, value: Value) -> Shoot:
    tag, name = _tag(value.get("tag"), _CAMERA), _text(value.get("name"), "a name")
    return replace(shoot, camera_names={**shoot.camera_names, tag: name})


def _name_tag(now: Annotations, action: Action) -> Annotations:
    tag, name = _tag(action.value.get("tag"), _PERSON), _text(action.value.get("name"), "a name")
    return replace(now, names={**now.names, tag: name})


def _sd(value: Value, default: float) -> float:
    return default if value.get("sd_m") is None else _number(value["sd_m"], "an uncertainty")


def _set_spot(shoot: Shoot, value: Value) -> Shoot:
    tag, at = _tag(value.get("tag")), value.get("at")
    spots = {t: s for t, s in shoot.spots.items() if t != tag}
    if at is not None:
        pair = cast("list[Any]", at) if isinstance(at, list | tuple) else []
        _need(len(pair) == 2, "coordinates are a pair of metres")
        x, y = (_number(v, "a coordinate") for v in pair)
        spots[tag] = Spot(tag, x, y, _sd(value, SPOT_SD_M))
    return replace(shoot, spots=spots)


def _set_tape(shoot: Shoot, value: Value) -> Shoot:
    a, b, metres = _tag(value.get("a")), _tag(value.get("b")), value.get("metres")
    ends = frozenset((a, b))
    tapes = dict(shoot.tapes)
    if metres is None:
        tapes.pop(ends, None)
    else:
        tapes[ends] = Tape(a, b, _number(metres, "a taped distance"), _sd(value, TAPE_SD_M))
    return replace(shoot, tapes=tapes)


@dataclass(frozen=True)
class Kind:
    """One kind of action: what it means and what its value holds, and the annotations that follow from it."""

    meaning: str
    apply: Callable[[Annotations, Action], Annotations]


KINDS: dict[str, Kind] = {
    "propose": Kind("a back end's people: {pose, people: [{person, points}]}", _on_photo(_propose)),
    "add_person": Kind("a person: {person, points: {part: [x, y]}}", _on_photo(_add_person)),
    "remove_person": Kind("not a person, or one who does not count: {person}", _on_photo(_remove_person)),
    "set_point": Kind("a point, or that it is not visible: {person, part, to: [x, y] or null}", _on_photo(_set_point)),
    "name_person": Kind("who it is: {person, tag or null}", _on_photo(_name_person)),
    "name_people": Kind("who several are: {names: [{person, tag}]}", _on_photo(_name_people)),
    "finish": Kind("this photo is done: {done}", _on_photo(_finish)),
    "skip": Kind("this photo is left out: {skipped}", _on_photo(_skip)),
    "set_lens": Kind("lens and sensor: {photos, lens: {focal_35mm}, {focal_mm, sensor_mm} or null}", _set_lens),
    "place_photos": Kind("where photos belong: {photos, shoot, camera}", _place_photos),
    "name_shoot": Kind("what a shoot is called: {shoot, name}", _on_shoot(_name_shoot)),
    "name_camera": Kind("what a camera's place is called: {shoot, tag, name}", _on_shoot(_name_camera)),
    "name_tag": Kind("what a person is called: {tag, name}", _name_tag),
    "set_spot": Kind("coordinates of a mark, metres: {shoot, tag, at: [x, y] or null}", _on_shoot(_set_spot)),
    "set_tape": Kind("a taped distance: {shoot, a, b, metres or null}", _on_shoot(_set_tape)),
}  # fmt: skip


def apply(now: Annotations, action: Action) -> Annotations:
    """Return the annotations after an action; raises SettingsError for one that cannot be followed."""
    try:
        require_whole_characters(action.value)
    except ValueError as error:
        raise SettingsError(f"annotation: {error}") from error
    _need(action.action in KINDS, f"action {action.action!r} is unknown: use one of {', '.join(KINDS)}")
    return KINDS[action.action].apply(now, action)


def replayed(actions: Iterable[Action]) -> tuple[Annotations, list[Action]]:
    """Return the annotations that actions in force amount to, and those that cannot be followed any more."""
    now, lost = Annotations(), list[Action]()
    for action in actions:
        try:
            now = apply(now, action)
        except (ProxemetryError, TypeError, AttributeError, KeyError):  # a log may hold what another program wrote
            lost.append(action)
    return now, lost
