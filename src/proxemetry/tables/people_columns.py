"""The columns of `people`: one row a person, with what proxemics and visual communication measure for each."""

from __future__ import annotations

import math
from collections.abc import Callable

from ..people.skeleton import PARTS
from ..proxemics import SHOTS
from ..scene import Scene
from .column import LEVEL_TEXT, Column, Value
from .doubt_columns import DOUBT, MEANING, doubt_text

_DEGREES = 180 / math.pi


def _position(axis: int) -> Callable[[Scene, int], Value]:
    return lambda s, i: float(s.bodies.positions_m[i, axis])


def _position_sd(axis: int) -> Callable[[Scene, int], Value]:
    return lambda s, i: float(s.bodies.position_sd_m[i, axis])


def _box(side: int) -> Callable[[Scene, int], Value]:
    return lambda s, i: float(s.people.boxes_px[i, side])


def _part(part: str, axis: int) -> Callable[[Scene, int], Value]:
    return lambda s, i: float(s.people.part(part)[i, axis])


def _proxemics(name: str) -> Callable[[Scene, int], Value]:
    return lambda s, i: float(getattr(s.proxemics, name)[i])


def _nearest_person(scene: Scene, i: int) -> Value:
    nearest = int(scene.proxemics.nearest[i])
    return nearest if nearest >= 0 else None


_AXES = ("to the right", "down", "along the optical axis, the depth of the torso's middle")

PEOPLE = (
    Column("photo", "VARCHAR", "", "path of the photo", lambda s, i: s.photo),
    Column("person", "INTEGER", "", "number of the person in the photo, from 0", lambda s, i: i, identifies=True),
    *(
        Column(f"{axis}_m", "DOUBLE", "m", f"position in the camera frame, {text}", _position(k))
        for k, (axis, text) in enumerate(zip("xyz", _AXES, strict=True))
    ),
    *(
        Column(f"{axis}_sd_m", "DOUBLE", "m", f"standard deviation of {axis}_m", _position_sd(k))
        for k, axis in enumerate("xyz")
    ),
    Column("method", "VARCHAR", "", "the method that placed the person", lambda s, i: s.bodies.method),
    Column(
        "basis",
        "VARCHAR",
        "",
        "the evidence used: feet, legs, torso, shoulders, eyes, head, depth, with + between them; torso, shoulder or "
        "pupil where the paper's estimators placed the person",
        lambda s, i: s.bodies.basis[i] or None,
    ),
    Column("score", "DOUBLE", "", "detector's confidence, 0 to 1", lambda s, i: float(s.people.person_scores[i])),
    *(
        Column(f"box_{side}", "DOUBLE", "px", f"box around the person, {side}", _box(k))
        for k, side in enumerate(("x0", "y0", "x1", "y1"))
    ),
    *(
        Column(f"{part.lower()}_{'uv'[axis]}_px", "DOUBLE", "px", f"centre of the {part.lower()}", _part(part, axis))
        for part in ("Eyes", "Head", "Shoulder", "Torso")
        for axis in (0, 1)
    ),
    Column("reason", "VARCHAR", "", "why there is no position", lambda s, i: s.bodies.reasons[i]),
    Column(
        "heading_deg",
        "DOUBLE",
        "deg",
        "where the body faces: 0 against the camera's axis, positive to the photo's right",
        lambda s, i: float(s.bodies.heading_rad[i]) * _DEGREES,
    ),
    Column(
        "heading_sd_deg",
        "DOUBLE",
        "deg",
        "standard deviation of heading_deg",
        lambda s, i: float(s.bodies.heading_sd_rad[i]) * _DEGREES,
    ),
    Column(
        "nearest_person", "INTEGER", "", "number of the nearest other person with a distance",
        _nearest_person, identifies=True,
    ),
    Column("nearest_m", "DOUBLE", "m", "distance to the nearest other person", _proxemics("nearest_m")),
    Column("nearest_low_m", "DOUBLE", "m", f"lower end of its {LEVEL_TEXT} interval", _proxemics("nearest_low_m")),
    Column("nearest_high_m", "DOUBLE", "m", f"upper end of its {LEVEL_TEXT} interval", _proxemics("nearest_high_m")),
    Column(
        "camera_distance_m", "DOUBLE", "m", "from the camera to the body's middle, in space",
        _proxemics("camera_distance_m"),
    ),
    Column("camera_low_m", "DOUBLE", "m", f"lower end of its {LEVEL_TEXT} interval", _proxemics("camera_low_m")),
    Column("camera_high_m", "DOUBLE", "m", f"upper end of its {LEVEL_TEXT} interval", _proxemics("camera_high_m")),
    Column(
        "shot_size", "VARCHAR", "",
        f"how much of the body the picture shows and how large: {', '.join(SHOTS)}",
        lambda s, i: s.proxemics.shots[i],
        SHOTS,
        ordered=True,
    ),
    Column(
        "view_horizontal_deg", "DOUBLE", "deg",
        "between where the body faces and the camera: 0 frontal, 90 in profile, 180 from behind",
        _proxemics("horizontal_deg"),
    ),
    Column(
        "view_horizontal_sd_deg", "DOUBLE", "deg", "standard deviation of view_horizontal_deg",
        _proxemics("horizontal_sd_deg"),
    ),
    Column(
        "view_vertical_deg", "DOUBLE", "deg",
        "how far the camera looks down on the head; negative: it looks up at it",
        _proxemics("vertical_deg"),
    ),
    Column(
        "group_id", "INTEGER", "",
        "number of the conversational group (F-formation) in the photo, from 0; empty: in none",
        lambda s, i: int(s.proxemics.group[i]) if s.proxemics.group[i] >= 0 else None,
        identifies=True,
    ),
    Column(
        "group_size", "INTEGER", "", "people in that group; 1: in none; empty: not placed",
        lambda s, i: int(s.proxemics.group_size[i]) if s.bodies.placed[i] else None,
    ),
    Column(
        "possible_duplicate", "BOOLEAN", "",
        "true: may be another person of the photo, of a higher score, seen a second time",
        lambda s, i: bool(s.possible_duplicates[i]),
    ),
    Column(DOUBT, "VARCHAR", "", MEANING, doubt_text),
    Column(
        "stated_depth_m", "DOUBLE", "m", "depth along the optical axis as another instrument measured it",
        lambda s, i: float(s.people.depth_m[i]),
    ),
    Column(
        "stated_depth_sd_m", "DOUBLE", "m", "standard deviation of stated_depth_m, as stated",
        lambda s, i: float(s.people.depth_sd_m[i]),
    ),
    Column(
        "depth_misfit", "DOUBLE", "",
        "standard deviations by which stated_depth_m is off all other evidence, positive: too far; beyond 3.3 the "
        "picture contradicts it",
        lambda s, i: float(s.bodies.depth_misfit[i]),
    ),
)  # fmt: skip
assert {p.lower() for p in PARTS} == {"eyes", "head", "shoulder", "torso"}
