"""The columns of `pairs`: one row a pair of people of a photo."""

from __future__ import annotations

import math
from collections.abc import Callable

from ..distances import UNCERTAIN, ZONES
from ..proxemics import ORIENTATIONS, phase_of
from ..scene import Scene
from .attribute_columns import ENDS
from .column import LEVEL_TEXT, Column, Value
from .doubt_columns import column_of_doubt, doubt_text


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


def _doubt(end: str) -> Callable[[Scene, int, int], Value]:
    return lambda s, a, b: doubt_text(s, a if end == ENDS[0] else b)


PAIRS = (
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
    Column("low_m", "DOUBLE", "m", f"lower end of the {LEVEL_TEXT} interval", _pair("low_m")),
    Column("high_m", "DOUBLE", "m", f"upper end of the {LEVEL_TEXT} interval", _pair("high_m")),
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
    *(
        Column(column_of_doubt(end), "VARCHAR", "", f"doubt about person_{end}, see people", _doubt(end))
        for end in ENDS
    ),
)  # fmt: skip
