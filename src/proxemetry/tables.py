"""The three tidy tables of a results folder: their columns, units and meanings, and the rows of one scene.

The codebook is made from here, so that a column and its meaning can never part.
"""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

from .distances import UNCERTAIN, ZONES
from .intervals import LEVEL
from .people.skeleton import PARTS
from .proxemics import ORIENTATIONS, SHOTS, phase_of
from .scene import STATUSES, Scene

Value = str | int | float | bool | None


@dataclass(frozen=True)
class Column:
    """One column: its name, SQL type, unit ("" where it has none), meaning, and its value for a row of a scene.

    `value` takes (scene) for photos, (scene, person) for people and (scene, a, b) for pairs; the log has none.
    levels: the texts that a categorical column takes; ordered where they have an order. identifies: a number that names
    something and is not to be averaged.
    """

    name: str
    kind: str
    unit: str
    meaning: str
    value: Callable[..., Value] = lambda *_: None
    levels: tuple[str, ...] = ()
    ordered: bool = False
    identifies: bool = False


def rows(table: str, scene: Scene) -> list[dict[str, Value]]:
    """Return the rows of one scene in the table "photos", "people" or "pairs"."""
    if table == "photos":
        keys: list[tuple[int, ...]] = [()]
    elif table == "people":
        keys = [(i,) for i in range(len(scene))]
    else:
        keys = list(scene.distances.pairs())
    return [{c.name: _clean(c.value(scene, *key)) for c in TABLES[table]} for key in keys]


def _clean(value: Any) -> Value:
    if isinstance(value, float):
        value = float(value)
        return float(f"{value:.7g}") if math.isfinite(value) else None
    return value


def _if_counted(value: Callable[[Scene], Value]) -> Callable[[Scene], Value]:
    """Nobody was counted in a photo that could not be read or was excluded: that is no zero to average in."""
    return lambda s: None if s.status in ("failed", "excluded") else value(s)


def _camera(attribute: str) -> Callable[[Scene], Value]:
    return lambda s: None if s.camera.camera is None else getattr(s.camera.camera, attribute)


def _focal_source(scene: Scene) -> Value:
    return None if scene.camera.source is None else str(scene.camera.source)


def _assumed(scene: Scene) -> Value:
    return None if scene.camera.camera is None else scene.camera.is_assumed


def _camera_flags(scene: Scene) -> Value:
    return "; ".join(map(str, scene.camera.flags)) or None


def _about(attribute: str) -> Callable[[Scene], Value]:
    return lambda s: getattr(s.about, attribute)


def _corrections(scene: Scene) -> Value:
    return 0 if scene.review is None else scene.review.corrections


def _note(scene: Scene) -> Value:
    return None if scene.review is None else scene.review.note


def _floor(attribute: str, scale: float = 1.0) -> Callable[[Scene], Value]:
    return lambda s: None if s.bodies.floor is None else getattr(s.bodies.floor, attribute) * scale


_DEGREES = 180 / math.pi

_PHOTOS = (
    Column("photo", "VARCHAR", "", "path of the photo, relative to the folder named", lambda s: s.photo),
    Column("sha256", "VARCHAR", "", "SHA-256 of the file", lambda s: s.sha256 or None),
    Column(
        "status",
        "VARCHAR",
        "",
        "ok, no_camera (people without distances), failed or excluded",
        lambda s: s.status,
        STATUSES,
    ),
    Column("reason", "VARCHAR", "", "why the status is not ok, and what to do", lambda s: s.reason),
    Column("width_px", "INTEGER", "px", "width of the upright photo", lambda s: s.width_px or None),
    Column("height_px", "INTEGER", "px", "height of the upright photo", lambda s: s.height_px or None),
    Column("focal_px", "DOUBLE", "px", "focal length in pixels of the upright photo", _camera("f_px")),
    Column("focal_source", "VARCHAR", "", "where the focal length came from; ASSUMED is a guess", _focal_source),
    Column("n_people", "INTEGER", "", "people found; empty where the photo is failed or excluded", _if_counted(len)),
    Column("n_pairs", "INTEGER", "", "pairs with a distance", _if_counted(lambda s: s.distances.below(math.inf))),
    Column("seconds", "DOUBLE", "s", "computing time", lambda s: s.seconds),
    Column("focal_rel_sd", "DOUBLE", "", "relative standard deviation of the focal length", _camera("focal_rel_sd")),
    Column("focal_assumed", "BOOLEAN", "", "true: the focal length is a guess, as focal_source says", _assumed),
    Column("camera_flags", "VARCHAR", "", "what is doubtful about the camera", _camera_flags),
    Column("camera_height_m", "DOUBLE", "m", "height of the camera above the floor", _floor("height_m")),
    Column("camera_pitch_deg", "DOUBLE", "deg", "camera pitch, positive looks down", _floor("pitch_rad", _DEGREES)),
    Column("date", "VARCHAR", "", "when the photo was taken (its metadata)", _about("date")),
    Column("country", "VARCHAR", "", "country (its metadata)", _about("country")),
    Column("city", "VARCHAR", "", "city (its metadata)", _about("city")),
    Column("source", "VARCHAR", "", "agency or source (its metadata)", _about("source")),
    Column("camera_make", "VARCHAR", "", "maker of the camera (its metadata)", _about("camera_make")),
    Column("camera_model", "VARCHAR", "", "model of the camera (its metadata)", _about("camera_model")),
    Column("creator", "VARCHAR", "", "who took the photo (its metadata; --with-names)", _about("creator")),
    Column("caption", "VARCHAR", "", "caption (its metadata; --with-names)", _about("caption")),
    Column(
        "names",
        "VARCHAR",
        "",
        "names of those shown (its metadata; --with-names)",
        lambda s: "; ".join(s.about.people) or None,
    ),
    Column("latitude_deg", "DOUBLE", "deg", "where it was taken (its metadata; --with-gps)", _about("latitude_deg")),
    Column("longitude_deg", "DOUBLE", "deg", "where it was taken (its metadata; --with-gps)", _about("longitude_deg")),
    Column("corrections", "INTEGER", "", "corrections made by hand that are in these numbers", _corrections),
    Column("note", "VARCHAR", "", "a reviewer's remark", _note),
)


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


#: The level of every interval, as the columns' meanings name it.
_LEVEL = f"{LEVEL:.0%}".replace("%", " %")

_AXES = ("to the right", "down", "along the optical axis, the depth of the torso's middle")

_PEOPLE = (
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
        "the evidence used: feet, legs, torso, shoulders, eyes, head, with + between them; torso, shoulder or pupil "
        "where the paper's estimators placed the person",
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
    Column("nearest_low_m", "DOUBLE", "m", f"lower end of its {_LEVEL} interval", _proxemics("nearest_low_m")),
    Column("nearest_high_m", "DOUBLE", "m", f"upper end of its {_LEVEL} interval", _proxemics("nearest_high_m")),
    Column(
        "camera_distance_m", "DOUBLE", "m", "from the camera to the body's middle, in space",
        _proxemics("camera_distance_m"),
    ),
    Column("camera_low_m", "DOUBLE", "m", f"lower end of its {_LEVEL} interval", _proxemics("camera_low_m")),
    Column("camera_high_m", "DOUBLE", "m", f"upper end of its {_LEVEL} interval", _proxemics("camera_high_m")),
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
)  # fmt: skip
assert {p.lower() for p in PARTS} == {"eyes", "head", "shoulder", "torso"}


def _pair(matrix: str) -> Callable[[Scene, int, int], Value]:
    return lambda s, a, b: float(getattr(s.distances, matrix)[a, b])


def _zone_probability(k: int) -> Callable[[Scene, int, int], Value]:
    return lambda s, a, b: float(s.distances.zone_probability[a, b, k])


def _phase(scene: Scene, a: int, b: int) -> Value:
    return phase_of(scene.distances.zone(a, b), float(scene.distances.distance_m[a, b]))


def _orientation_probability(k: int) -> Callable[[Scene, int, int], Value]:
    return lambda s, a, b: float(s.proxemics.orientation_probability[a, b, k])


def _pair_reason(scene: Scene, a: int, b: int) -> Value:
    one, other = (scene.bodies.reasons[i] for i in (a, b))
    if one == other:
        return one
    return "; ".join(f"person {i}: {reason}" for i, reason in ((a, one), (b, other)) if reason)


def _on_ground(scene: Scene, a: int, b: int) -> Value:
    return scene.distances.on_ground if math.isfinite(scene.distances.distance_m[a, b]) else None


_PAIRS = (
    Column("photo", "VARCHAR", "", "path of the photo", lambda s, a, b: s.photo),
    Column("person_a", "INTEGER", "", "number of one person", lambda s, a, b: a, identifies=True),
    Column("person_b", "INTEGER", "", "number of the other person", lambda s, a, b: b, identifies=True),
    Column(
        "distance_m",
        "DOUBLE",
        "m",
        "distance between body centres along the ground (see on_ground), of least expected relative error",
        _pair("distance_m"),
    ),
    Column("low_m", "DOUBLE", "m", "lower end of the 90 % interval", _pair("low_m")),
    Column("high_m", "DOUBLE", "m", "upper end of the 90 % interval", _pair("high_m")),
    Column("distance_3d_m", "DOUBLE", "m", "distance in space", _pair("distance_3d_m")),
    Column(
        "zone",
        "VARCHAR",
        "",
        "Hall's zone of distance_m; uncertain where it is less likely than not",
        lambda s, a, b: s.distances.zone(a, b),
        (*ZONES, UNCERTAIN),
        ordered=True,
    ),
    Column("reason", "VARCHAR", "", "why there is no distance", _pair_reason),
    Column(
        "on_ground",
        "BOOLEAN",
        "",
        "true: distance_m is along the ground; false: gravity is unknown, it is in space",
        _on_ground,
    ),
    *(
        Column(f"p_{zone}", "DOUBLE", "", f"probability of the {zone} zone", _zone_probability(k))
        for k, zone in enumerate(ZONES)
    ),
    Column(
        "p_group", "DOUBLE", "", "probability that the two face each other (F-formation)", _pair("group_probability")
    ),
    Column(
        "phase", "VARCHAR", "", "Hall's phase within the zone: close or far", _phase, ("close", "far"), ordered=True
    ),
    Column(
        "orientation", "VARCHAR", "",
        f"how the two are turned to one another: {', '.join(ORIENTATIONS)}; uncertain where none is likelier than not; "
        "empty beyond 3.66 m or where a heading is unknown",
        lambda s, a, b: s.proxemics.orientation(a, b),
        (*ORIENTATIONS, UNCERTAIN),
    ),
    *(
        Column(
            f"p_{name.replace(' ', '_')}", "DOUBLE", "", f"probability of the orientation {name}",
            _orientation_probability(k),
        )
        for k, name in enumerate(ORIENTATIONS)
    ),
)  # fmt: skip

#: `corrections.csv`, the log of a review as it is exported.
CORRECTIONS = (
    Column("number", "INTEGER", "", "number of the action, in the order they were done"),
    Column("time", "VARCHAR", "", "when, in universal time (ISO 8601)"),
    Column("who", "VARCHAR", "", "the reviewer's name (--who)"),
    Column("photo", "VARCHAR", "", "path of the photo"),
    Column("sha256", "VARCHAR", "", "SHA-256 of the file"),
    Column("action", "VARCHAR", "", "what was done: remove_person, set_camera, exclude ..., undo"),
    Column("value", "VARCHAR", "", "with what, as JSON"),
)

#: Table -> its columns, in order.
TABLES: dict[str, tuple[Column, ...]] = {"photos": _PHOTOS, "people": _PEOPLE, "pairs": _PAIRS}


def safe_distance_columns(limit_m: float | None) -> tuple[Column, ...]:
    """Return the columns that the photos table has besides: the safe distance of the run and the pairs below it."""
    return (
        Column("safe_distance_m", "DOUBLE", "m", "the distance asked for with --safe-distance", lambda s: limit_m),
        Column(
            "n_below_safe",
            "INTEGER",
            "",
            "pairs nearer than safe_distance_m",
            _if_counted(lambda s: None if limit_m is None else s.distances.below(limit_m)),
        ),
    )


def all_columns() -> dict[str, tuple[Column, ...]]:
    """Return every table's columns, those of the safe distance with the photos'."""
    return {**TABLES, "photos": (*TABLES["photos"], *safe_distance_columns(None))}


#: How the codebook calls the SQL types.
_KINDS = {"VARCHAR": "text", "INTEGER": "integer", "DOUBLE": "number", "BOOLEAN": "true or false"}


def _codebook() -> dict[str, tuple[Column, ...]]:
    return {**all_columns(), "corrections": CORRECTIONS}


def codebook_rows() -> tuple[list[str], Iterator[tuple[str, ...]]]:
    """Return the codebook's header, and a row for every column: table, column, type, unit and meaning."""
    listed = ((table, column) for table, columns in _codebook().items() for column in columns)
    rows = ((table, c.name, _KINDS[c.kind], c.unit, c.meaning) for table, c in listed)
    return ["table", "column", "type", "unit", "meaning"], rows


def codebook_csv() -> str:
    """Return the codebook as CSV."""
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    header, rows = codebook_rows()
    writer.writerow(header)
    writer.writerows(rows)
    return out.getvalue()


def codebook_markdown() -> str:
    """Return the same as a page."""
    lines = ["# Codebook", "", "The columns of the tables in a results folder; a value that is missing is empty.", ""]
    for table, columns in _codebook().items():
        lines += [f"## {table}", "", "| column | type | unit | meaning |", "|---|---|---|---|"]
        lines += [f"| `{c.name}` | {_KINDS[c.kind]} | {c.unit} | {c.meaning} |" for c in columns]
        lines.append("")
    return "\n".join(lines)
